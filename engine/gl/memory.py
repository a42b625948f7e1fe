"""What a context holds in the memory of the graphics device."""

from __future__ import annotations

import gc
from typing import Any

import moderngl

#: What has memory of its own; framebuffers and vertex arrays only name these.
HOLDERS = (
    moderngl.Buffer,
    moderngl.Renderbuffer,
    moderngl.Texture,
    moderngl.TextureArray,
    moderngl.TextureCube,
    moderngl.Texture3D,
)

#: Filters that read smaller copies of a texture, a third more in all.
WITH_COPIES = {
    moderngl.NEAREST_MIPMAP_NEAREST,
    moderngl.NEAREST_MIPMAP_LINEAR,
    moderngl.LINEAR_MIPMAP_NEAREST,
    moderngl.LINEAR_MIPMAP_LINEAR,
}


def device_bytes(context: Any) -> int:
    """Bytes of all buffers, textures and renderbuffers of `context`; what the driver adds to them is not known."""
    living = [
        each
        for each in gc.get_objects()
        if isinstance(each, HOLDERS) and each.ctx is context and not isinstance(each.mglo, moderngl.InvalidObject)
    ]
    return sum(_bytes(each) for each in living)


def _bytes(holder: Any) -> int:
    if isinstance(holder, moderngl.Buffer):
        return int(holder.size)
    texels = 1
    for edge in holder.size:
        texels *= edge
    # a depth is 24 bits, which devices store in 32
    each = 4 if getattr(holder, "depth", False) else holder.components * int(holder.dtype[-1])
    faces = 6 if isinstance(holder, moderngl.TextureCube) else 1
    copies = 4 / 3 if getattr(holder, "filter", (0, 0))[0] in WITH_COPIES else 1
    return round(texels * each * faces * copies)
