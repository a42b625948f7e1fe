"""OpenEXR files written by strips are, byte for byte, what OpenEXR writes."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from engine.core.steps import drain
from engine.images.encode import as_half, encode_exr
from engine.images.exr_strips import Planes, find_strips, read_strips, write_exr_strips
from engine.storage.scratch import scratch_array

RNG = np.random.default_rng(3)


def write(planes: Planes) -> bytes:
    parts: list[bytes] = []
    late = drain(write_exr_strips(planes, parts.append, "writing"))
    content = bytearray(b"".join(parts))
    assert content[late.place : late.place + len(late.content)] == bytes(len(late.content))
    content[late.place : late.place + len(late.content)] = late.content
    return bytes(content)


def read(content: bytes) -> dict[str, np.ndarray]:
    file = io.BytesIO(content)
    strips = find_strips(file)
    assert strips is not None
    image = np.concatenate([samples for _, samples in read_strips(file, strips)])
    return {name: image[:, place] for place, name in enumerate(strips.channels)}


@pytest.mark.parametrize("shape", [(1, 1), (15, 7), (16, 7), (17, 1), (40, 333), (129, 64)])
@pytest.mark.parametrize("half", [False, True])
def test_strips_are_the_bytes_of_openexr(shape: Any, half: bool) -> None:
    channels = {f"slice{n:02d}.{c}": RNG.random(shape, np.float32) * (n + 1) for n in (0, 1) for c in "RGB"}
    channels["slice01.clipped"] = RNG.random(shape) < 0.1
    channels["flat"] = np.full(shape, 1e6, np.float32)
    attributes = {"unit": "radiance", "r_max": "0.25"}
    expected = encode_exr(channels, half=half, attributes=attributes)
    assert write(Planes(channels, attributes, half)) == expected
    found = read(expected)
    assert found.keys() == channels.keys()
    for name, channel in channels.items():
        stored = as_half(channel) if half else np.float32(channel)
        assert np.array_equal(found[name], stored)
        assert found[name].dtype == stored.dtype


def test_noise_that_does_not_pack_is_stored_as_openexr_does() -> None:
    channels = {"Y": RNG.integers(0, 1 << 32, (33, 50), np.uint32).view(np.float32)}
    content = encode_exr(channels, half=False)
    assert write(Planes(channels)) == content
    assert np.array_equal(read(content)["Y"].view(np.uint32), channels["Y"].view(np.uint32))


def test_what_is_no_plain_file_is_left_to_openexr(tmp_path: Path) -> None:
    image = {"RGB": RNG.random((20, 20, 3), np.float32)}
    for compression in (OpenEXR.PIZ_COMPRESSION, OpenEXR.ZIPS_COMPRESSION):
        path = tmp_path / "image.exr"
        OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, image).write(str(path))
        assert find_strips(io.BytesIO(path.read_bytes())) is None
    assert find_strips(io.BytesIO(b"")) is None
    assert find_strips(io.BytesIO(path.read_bytes()[:60])) is None


def test_damaged_strips_are_refused() -> None:
    content = encode_exr({"Y": np.zeros((40, 30), np.float32)}, half=False)
    strips = find_strips(io.BytesIO(content))
    assert strips is not None
    first = strips.start + 3 * 8
    for place, replaced in ((strips.start, 8), (first, 1), (first + 4, 255), (first + 8, 4), (strips.start + 16, 5)):
        damaged = bytearray(content)
        damaged[place] ^= replaced
        with pytest.raises(ValueError, match="its"):
            list(read_strips(io.BytesIO(damaged), strips))
    for end in (strips.start + 20, len(content) - 3):
        with pytest.raises(ValueError, match="its"):
            list(read_strips(io.BytesIO(content[:end]), strips))


def test_a_map_on_the_disk_is_written_from_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.storage.scratch.IN_MEMORY_BYTES", 0)
    image = scratch_array((50, 20, 3), np.float32)
    image[...] = RNG.random((50, 20, 3), np.float32)
    channels = {name: image[..., index] for index, name in enumerate("RGB")}
    assert write(Planes(channels)) == encode_exr(channels, half=False)
