"""The tensor_file container: what is written is read, and what cannot be true is refused in a sentence."""

from __future__ import annotations

import contextlib
import os
import struct
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.brdf.readers.read import read_brdf
from engine.brdf.readers.rgl import RglBrdf, read_rgl
from engine.brdf.readers.tensor_file import read_tensor_file
from engine.core.errors import InputError
from tests.engine.brdf.readers.tensor_files import TYPES, fields_of, header_length, tensor_bytes
from tests.engine.damage import MEMORY_LIMIT_BYTES, ROUNDS, TIME_LIMIT_S, find_damaged, peak_memory_bytes

LIMIT = 1 << 20


def write(tmp_path: Path, content: bytes) -> Path:
    path = tmp_path / "some.bsdf"
    path.write_bytes(content)
    return path


def refuse(tmp_path: Path, content: bytes) -> str:
    with pytest.raises(InputError) as caught:
        read_tensor_file(write(tmp_path, content), LIMIT)
    return caught.value.problem


def small() -> bytes:
    return tensor_bytes({"a": np.arange(6, dtype=np.float32).reshape(2, 3), "b": np.array([7], np.uint8)})


def place(
    *, dimensions: int = 1, kind: int = 1, first: int = 0, shape: tuple[int, ...] = (4,), size: int = 64
) -> bytes:
    """A file of `size` bytes with one field as announced."""
    content = b"tensor_file\0\x01\x00" + struct.pack("<IH", 1, 1) + b"a" + struct.pack("<HBQ", dimensions, kind, first)
    return (content + struct.pack(f"<{len(shape)}Q", *shape)).ljust(64, b"\0")


def test_every_type_and_shape_comes_back(tmp_path: Path) -> None:
    fields = {kind: np.arange(12).reshape(3, 1, 4).astype(kind) for kind in TYPES} | {
        "none": np.empty((0, 9), np.float32),
        "scalar": np.array(2.5),
    }
    read = read_tensor_file(write(tmp_path, tensor_bytes(fields)), LIMIT)
    assert list(read) == list(fields)
    for name, array in fields.items():
        assert read[name].dtype == array.dtype
        np.testing.assert_array_equal(read[name], array)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"MERL" * 9, "is not a tensor_file: it begins otherwise"),
        (b"tensor_file\0\x02\x01" + bytes(40), "is a tensor_file of version 2.1, and 1.0 is read"),
        (b"tensor_file\0\x01\x00" + b"\x00\x00\x00\x0b" + bytes(40), "is byte-swapped: its numbers are big-endian"),
        (b"tensor_file\0\x01\x00" + b"\xff" * 40, "announces 4294967295 fields, more than 256: it is damaged"),
        (b"tensor_file\0\x01\x00", "is cut off within its list of fields"),
        (small()[:30], "is cut off within its list of fields"),
        (small()[:-1], "is cut off: its field 'b' ends at byte 97, the file at 96"),
        (small().replace(b"\x01\x00b", b"\x00\x00b"), "has a field whose name is 0 bytes long: it is damaged"),
        (small().replace(b"\x01\x00b", b"\x01\x00\xff"), "has a field whose name is not text: it is damaged"),
        (small().replace(b"\x01\x00b", b"\x01\x00a"), "has two fields of one name: it is damaged"),
        (place(kind=12, first=40), "has a field 'a' of the unknown type 12: it is damaged"),
        (place(dimensions=17, first=40), "has a field 'a' of 17 dimensions: it is damaged"),
        (place(first=38), "has a field 'a' that lies over the list of fields: it is damaged"),
        (place(first=61), "is cut off: its field 'a' ends at byte 65, the file at 64"),
        (place(first=2**64 - 2), "is cut off: its field 'a' ends at byte 18446744073709551618, the file at 64"),
        (
            place(dimensions=2, shape=(2**62, 2**62)),
            "is damaged: its field 'a' of 4611686018427387904 × 4611686018427387904 numbers does not fit into "
            "its 64 bytes",
        ),
        (
            place(dimensions=2, shape=(0, 2**63)),
            "is damaged: its field 'a' of 0 × 9223372036854775808 numbers does not fit into its 64 bytes",
        ),
    ],
)
def test_fault7_what_cannot_be_true_is_said(tmp_path: Path, content: bytes, problem: str) -> None:
    assert refuse(tmp_path, content) == problem


def test_fault7_fields_over_one_another(tmp_path: Path) -> None:
    content = bytearray(small())
    place = content.index(b"\x01\x00b") + 3 + 3
    (first,) = struct.unpack_from("<Q", content, 18 + 3 + 3)
    struct.pack_into("<Q", content, place, first + 5)
    assert refuse(tmp_path, bytes(content)) == "has a field 'b' that lies over 'a': it is damaged"


def test_fault7_a_byte_swapped_file_is_named(tmp_path: Path) -> None:
    fields = {"a": np.arange(6, dtype=np.float32)}
    assert refuse(tmp_path, tensor_bytes(fields, ">")) == "is byte-swapped: its numbers are big-endian"


def test_fault7_a_pointer_of_git_lfs_is_named(tmp_path: Path) -> None:
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n"
    assert refuse(tmp_path, pointer) == "is a git-lfs pointer, not the data"


def test_fault7_a_polarised_measurement_is_named(shared_data: Callable[[str], Path]) -> None:
    path = shared_data("brdf/spectralon_lowres.pbsdf")
    for read in (read_rgl, read_brdf):
        with pytest.raises(InputError) as caught:
            read(path)
        assert caught.value.problem == (
            "is a polarised measurement (Mueller matrices over half and difference angles), not an RGL BRDF"
        )


def measurement(spectral: bool) -> bytes:
    """A small anisotropic file."""
    random = np.random.default_rng(1)
    values = random.uniform(0.1, 1.0, (3, 2, 3, 4, 4))
    fields = fields_of(
        np.radians([-180.0, 0.0, 180.0]),
        np.radians([0.0, 90.0]),
        vndf=random.uniform(0.1, 1.0, (3, 2, 6, 8)),
        ndf=random.uniform(0.1, 1.0, (4, 8)),
        sigma=random.uniform(0.1, 1.0, (4, 8)),
        values=values,
        wavelengths=[450.0, 550.0, 650.0] if spectral else None,
        jacobian=1,
    )
    return tensor_bytes(fields)


@pytest.mark.campaign(rounds=ROUNDS)
@pytest.mark.parametrize("spectral", [False, True], ids=["rgb", "spectral"])
def test_fault5_damaged_files(tmp_path: Path, spectral: bool, seed: int) -> None:
    """A measurement that evaluates, or a sentence; in time and within memory."""
    good = measurement(spectral)
    wi, wo = np.array([0.48, 0.6, 0.64]), np.array([-0.6, 0.0, 0.8])
    path = write(tmp_path, good)
    assert np.all(read_rgl(path).f(wi, wo) > 0.0)
    before = peak_memory_bytes(os.getpid())
    read = 0
    damages = list(find_damaged(good, (0, header_length(good)), seed=seed))
    for damage in damages:
        path.write_bytes(damage.content)
        started = time.thread_time()
        result: RglBrdf | None = None
        with contextlib.suppress(InputError):
            result = read_rgl(path)
        assert time.thread_time() - started < TIME_LIMIT_S, damage.what
        if result is not None:
            value = result.f(wi, wo)
            assert np.isfinite(value).all(), damage.what
            assert spectral or (value >= 0.0).all(), damage.what
            assert damage.what != "cut", "a cut file was taken for a whole one"
            read += 1
    assert peak_memory_bytes(os.getpid()) - before < MEMORY_LIMIT_BYTES
    assert read > len(damages) // 8, "all were refused: nothing was tried behind the list of fields"
