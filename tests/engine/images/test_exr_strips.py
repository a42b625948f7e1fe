"""OpenEXR files written by strips are, byte for byte, what OpenEXR writes."""

from typing import Any

import numpy as np
import pytest

from engine.core.steps import drain
from engine.images.encode import encode_exr
from engine.images.exr_strips import Planes, write_exr_strips
from engine.storage.scratch import scratch_array

RNG = np.random.default_rng(3)


def write(planes: Planes) -> bytes:
    parts: list[bytes] = []
    late = drain(write_exr_strips(planes, parts.append, "writing"))
    content = bytearray(b"".join(parts))
    assert content[late.place : late.place + len(late.content)] == bytes(len(late.content))
    content[late.place : late.place + len(late.content)] = late.content
    return bytes(content)


@pytest.mark.parametrize("shape", [(1, 1), (15, 7), (16, 7), (17, 1), (40, 333), (129, 64)])
@pytest.mark.parametrize("half", [False, True])
def test_strips_are_the_bytes_of_openexr(shape: Any, half: bool) -> None:
    channels = {f"slice{n:02d}.{c}": RNG.random(shape, np.float32) * (n + 1) for n in (0, 1) for c in "RGB"}
    channels["slice01.clipped"] = RNG.random(shape) < 0.1
    channels["flat"] = np.full(shape, 1e6, np.float32)
    attributes = {"unit": "radiance", "r_max": "0.25"}
    expected = encode_exr(channels, half=half, attributes=attributes)
    assert write(Planes(channels, attributes, half)) == expected


def test_noise_that_does_not_pack_is_stored_as_openexr_does() -> None:
    channels = {"Y": RNG.integers(0, 1 << 32, (33, 50), np.uint32).view(np.float32)}
    assert write(Planes(channels)) == encode_exr(channels, half=False)


def test_a_map_on_the_disk_is_written_from_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.storage.scratch.IN_MEMORY_BYTES", 0)
    image = scratch_array((50, 20, 3), np.float32)
    image[...] = RNG.random((50, 20, 3), np.float32)
    channels = {name: image[..., index] for index, name in enumerate("RGB")}
    assert write(Planes(channels)) == encode_exr(channels, half=False)
