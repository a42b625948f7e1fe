"""The bytes that a context holds in the memory of the device."""

from __future__ import annotations

import threading
import weakref
from typing import Any

from engine.gl.context import device_bytes


def test_every_holder_counts(gl: Any) -> None:
    dead = [weakref.proxy(each) for each in (threading.Thread(),)]
    assert len(dead) == 1, "what it stands for is gone, which the count survives"
    before = device_bytes(gl)
    kept = [
        gl.buffer(reserve=1000),
        gl.texture((5, 3), 2, dtype="f2"),
        gl.texture_array((4, 4, 6), 3, dtype="f1"),
        gl.texture_cube((8, 8), 4, dtype="f4"),
        gl.renderbuffer((7, 2)),
        gl.depth_renderbuffer((7, 2)),
    ]
    sizes = [1000, 5 * 3 * 2 * 2, 4 * 4 * 6 * 3, 6 * 8 * 8 * 16, 7 * 2 * 4, 7 * 2 * 4]
    assert device_bytes(gl) - before == sum(sizes)
    for each, size in zip(kept, sizes, strict=True):
        held = device_bytes(gl)
        each.release()
        assert held - device_bytes(gl) == size


def test_smaller_copies_are_a_third_more(gl: Any) -> None:
    texture = gl.texture((64, 64), 4)
    before = device_bytes(gl)
    texture.build_mipmaps()
    texture.filter = (gl.LINEAR_MIPMAP_LINEAR, gl.LINEAR)
    assert device_bytes(gl) - before == round(64 * 64 * 4 / 3)
    texture.release()
