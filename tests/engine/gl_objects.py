"""Objects that the graphics driver still holds, for tests of leaks."""

from __future__ import annotations

import ctypes


def living_objects() -> dict[str, int]:
    """The number of names of each kind that the driver of the current context knows."""
    egl = ctypes.CDLL("libEGL.so.1")
    egl.eglGetProcAddress.restype = ctypes.c_void_p
    counts = {}
    for kind in ("Texture", "Buffer", "Framebuffer", "Renderbuffer", "Program", "Shader", "VertexArray"):
        is_one = ctypes.CFUNCTYPE(ctypes.c_ubyte, ctypes.c_uint)(egl.eglGetProcAddress(f"glIs{kind}".encode()))
        counts[kind] = sum(is_one(name) for name in range(1, 5000))
    return counts
