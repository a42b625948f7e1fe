"""OpenGL contexts without a window (EGL), what a context can do, and the memory that it holds."""

from __future__ import annotations

import gc
import math
from dataclasses import dataclass
from typing import Any, Protocol

import moderngl

from engine.core.errors import MissingCapability

#: OpenGL's context and framebuffers, by which the rest of the program names them.
Context = moderngl.Context
Framebuffer = moderngl.Framebuffer

REMEDY = (
    "Install a driver with OpenGL 3.3 (on Debian and Ubuntu: apt install libegl1 libgl1-mesa-dri), "
    "or render on the CPU with --renderer cpu"
)


class Owned(Protocol):
    """An object on a device, until its owner releases it."""

    def release(self) -> None: ...


#: The scissor of a framebuffer that has none, which the types of moderngl leave out.
NO_SCISSOR: Any = None

#: Objects with memory of their own; framebuffers and vertex arrays only name these.
HOLDERS = (
    moderngl.Buffer,
    moderngl.Renderbuffer,
    moderngl.Texture,
    moderngl.TextureArray,
    moderngl.TextureCube,
    moderngl.Texture3D,
)

Holder = (
    moderngl.Buffer
    | moderngl.Renderbuffer
    | moderngl.Texture
    | moderngl.TextureArray
    | moderngl.TextureCube
    | moderngl.Texture3D
)

#: Filters that read smaller copies of a texture, a third more in all.
WITH_COPIES = {
    moderngl.NEAREST_MIPMAP_NEAREST,
    moderngl.NEAREST_MIPMAP_LINEAR,
    moderngl.LINEAR_MIPMAP_NEAREST,
    moderngl.LINEAR_MIPMAP_LINEAR,
}


@dataclass(frozen=True)
class Limits:
    """Largest texture edge in texels and most layers of an array texture."""

    texture_size: int
    layers: int


def create_context(backend: str = "egl") -> moderngl.Context:
    """A standalone moderngl context with OpenGL 3.3 core; MissingCapability where there is none.

    The caller releases it. Several may exist; the newest is current, `with context:` makes one current.
    """
    try:
        settings: dict[str, Any] = {"backend": backend}
        return moderngl.create_context(standalone=True, require=330, **settings)
    except Exception as error:
        # glcontext raises plain Exception for what the driver refuses, and ImportError or OSError for a missing library
        if type(error) not in (Exception, ImportError, OSError, ValueError, moderngl.Error):
            raise
        raise MissingCapability(f"OpenGL 3.3 is not available ({' '.join(str(error).split())})", REMEDY) from None


def attach_context() -> moderngl.Context:
    """The context that a window has made current; MissingCapability where it is older than OpenGL 3.3."""
    try:
        return moderngl.create_context(require=330)
    except (OSError, ValueError, moderngl.Error) as error:
        raise MissingCapability(f"OpenGL 3.3 is not available ({error})", REMEDY) from None


def limits(context: moderngl.Context) -> Limits:
    return Limits(context.info["GL_MAX_TEXTURE_SIZE"], context.info["GL_MAX_ARRAY_TEXTURE_LAYERS"])


def renderer_name(context: moderngl.Context) -> str:
    return str(context.info["GL_RENDERER"])


def driver_name(context: moderngl.Context) -> str:
    """Renderer, maker and version, as the driver calls itself."""
    return ", ".join(str(context.info[name]) for name in ("GL_RENDERER", "GL_VENDOR", "GL_VERSION"))


def device_bytes(context: moderngl.Context) -> int:
    """Bytes of all buffers, textures and renderbuffers of `context`; what the driver adds to them is not known."""
    living = [
        each
        for each in gc.get_objects()
        if issubclass(type(each), HOLDERS)  # isinstance() asks what a weak proxy stands for, which may be gone
        and each.ctx is context
        and not isinstance(each.mglo, moderngl.InvalidObject)
    ]
    return sum(_bytes(each) for each in living)


def _bytes(holder: Holder) -> int:
    if isinstance(holder, moderngl.Buffer):
        return int(holder.size)
    texels = math.prod(holder.size)
    # a depth is 24 bits, which devices store in 32
    each = 4 if getattr(holder, "depth", False) else holder.components * int(holder.dtype[-1])
    faces = 6 if isinstance(holder, moderngl.TextureCube) else 1
    copies = 4 / 3 if getattr(holder, "filter", (0, 0))[0] in WITH_COPIES else 1
    return round(texels * each * faces * copies)
