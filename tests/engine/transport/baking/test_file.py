"""Transport files: written in chunks, resumed, opened whole or refused with words."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import engine
from engine.core.errors import InputError, OutputError
from engine.geometry.shapes import plane, sphere
from engine.storage import atomic, scratch
from engine.transport.baking import packing
from engine.transport.baking.file import (
    TransportPlan,
    holds_transport,
    mesh_fingerprint,
    open_transport,
    plan_transport,
    write_transport,
    writing,
)
from engine.transport.baking.file_header import header_text

ROWS = 1000


@pytest.fixture(autouse=True)
def no_fault_stays() -> Iterator[None]:
    yield
    atomic.fault = None


def plan_file(settings: dict[str, Any] | None = None) -> TransportPlan:
    bounds = np.arange(0, ROWS + 1, 100)
    return plan_transport(
        "wavelet",
        sphere(),
        settings or {"edge": 16},
        {"view_maps": np.arange(60.0).reshape(5, 12)},
        {"words": ("<u4", (8,)), "peaks": ("<f4", (3,))},
        bounds,
    )


def rows(chunk: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(chunk)
    return {
        "words": rng.integers(0, 2**32, (100, 8), dtype=np.uint32),
        "peaks": rng.random((100, 3)).astype(np.float32),
    }


def write(path: Path, chunks: list[int] | None = None, settings: dict[str, Any] | None = None) -> list[int]:
    """Bake some chunks and stop, or all that are missing; which were asked for."""
    with writing(path, plan_file(settings)) as writer:
        asked = writer.missing
        for chunk in asked if chunks is None else chunks:
            writer.put(chunk, rows(chunk))
    return asked


@pytest.fixture
def file(tmp_path: Path) -> Path:
    write(tmp_path / "sphere.transport")
    return tmp_path / "sphere.transport"


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """The same as version 1 has it: every array in its place, as in an unfinished file, and the table sealed."""
    plan, path = plan_file(), tmp_path / "old.transport"
    content = bytearray(plan.size_bytes)
    content[: len(plan.beginning)] = plan.beginning
    places = {array.name: array for array in plan.header.arrays}
    for name, array in plan.whole.items():
        content[places[name].offset : places[name].offset + array.nbytes] = array.tobytes()
    table = b""
    for chunk in range(10):
        checksum = 0
        for name, array in rows(chunk).items():
            start = places[name].offset + 100 * chunk * places[name].row_bytes
            content[start : start + array.nbytes] = array.tobytes()
            checksum = zlib.crc32(array.tobytes(), checksum)
        table += (1 << 32 | checksum).to_bytes(8, "little")
    table += zlib.crc32(table).to_bytes(4, "little")
    content[plan.header.table_offset : plan.header.table_offset + len(table)] = table
    path.write_bytes(content)
    return path


def test_files_of_version_1_still_open(file: Path, old: Path) -> None:
    found, packed = open_transport(old, sphere()), open_transport(file)
    assert found.size_bytes == old.stat().st_size == plan_file().size_bytes > packed.size_bytes
    assert all(np.array_equal(found.arrays[name], packed.arrays[name]) for name in packed.arrays)
    assert found.settings == packed.settings


def test_what_was_written_is_found_again_and_read_only(file: Path) -> None:
    found = open_transport(file, sphere())
    made_by = {"edge": 16, "software": f"lightarc {engine.__version__}"}
    assert (found.kind, dict(found.settings)) == ("wavelet", made_by)
    assert found.size_bytes == file.stat().st_size < plan_file().size_bytes
    for chunk in range(10):
        for name, array in rows(chunk).items():
            assert np.array_equal(found.arrays[name][100 * chunk : 100 * (chunk + 1)], array)
            assert not found.arrays[name].flags.writeable
    assert np.array_equal(found.arrays["view_maps"], np.arange(60.0).reshape(5, 12))
    assert set(found.arrays) == {"words", "peaks", "view_maps"}
    assert mesh_fingerprint(found.mesh) == mesh_fingerprint(sphere())
    assert np.array_equal(found.mesh.tangents, sphere().tangents)
    assert holds_transport(file)


def test_an_interrupted_bake_goes_on_with_what_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "sphere.transport"
    with pytest.raises(ValueError, match="missing"):
        write(path, [0, 3, 7])
    assert not path.exists()
    assert write(path) == [1, 2, 4, 5, 6, 8, 9]
    write(tmp_path / "whole.transport")
    assert path.read_bytes() == (tmp_path / "whole.transport").read_bytes()
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["sphere.transport", "whole.transport"]


def test_what_ends_before_its_first_chunk_leaves_nothing(tmp_path: Path) -> None:
    def end(chunks: list[int]) -> None:
        with writing(tmp_path / "sphere.transport", plan_file()) as writer:
            for chunk in chunks:
                writer.put(chunk, rows(chunk))
            raise KeyboardInterrupt

    for chunks, left in ([], 0), ([2], 1), ([], 1):
        with pytest.raises(KeyboardInterrupt):
            end(chunks)
        assert len(list(tmp_path.iterdir())) == left


def test_other_settings_begin_anew(tmp_path: Path) -> None:
    path = tmp_path / "sphere.transport"
    with pytest.raises(ValueError, match="missing"):
        write(path, [0])
    assert write(path, settings={"edge": 32}) == list(range(10))


def test_a_chunk_that_was_half_written_is_baked_again(tmp_path: Path) -> None:
    path = tmp_path / "sphere.transport"
    with pytest.raises(ValueError, match="missing"):
        write(path, [0, 1])
    (partial,) = tmp_path.iterdir()
    content = bytearray(partial.read_bytes())
    content[-1] ^= 1  # the padding, which means nothing
    place = next(array.offset for array in plan_file().header.arrays if array.name == "words")
    content[place] ^= 1
    partial.write_bytes(content)
    assert write(path) == [0, *range(2, 10)]
    open_transport(path)


def test_arrays_that_a_loss_of_power_zeroed_are_written_again(tmp_path: Path) -> None:
    path = tmp_path / "sphere.transport"
    with pytest.raises(ValueError, match="missing"):
        write(path, [0, 1])
    (partial,) = tmp_path.iterdir()
    content = bytearray(partial.read_bytes())
    for array in plan_file().header.arrays:
        if array.crc32 is not None:
            content[array.offset : array.offset + array.size_bytes] = bytes(array.size_bytes)
    partial.write_bytes(content)
    assert write(path) == list(range(2, 10))
    assert np.array_equal(open_transport(path).arrays["view_maps"], np.arange(60.0).reshape(5, 12))


def test_a_killed_process_leaves_what_the_next_one_needs(tmp_path: Path) -> None:
    path = tmp_path / "sphere.transport"
    program = (
        "import os, sys; sys.path.insert(0, sys.argv[2]); from pathlib import Path;"
        "import test_file as t; from engine.transport.baking.file import writing\n"
        "with writing(Path(sys.argv[1]), t.plan_file()) as w:\n"
        "    for c in range(4): w.put(c, t.rows(c))\n"
        "    os.kill(os.getpid(), 9)"
    )
    words = [sys.executable, "-c", program, str(path), str(Path(__file__).parent)]
    assert subprocess.run(words, cwd=Path(__file__).parents[4], check=False).returncode == -9
    assert not path.exists()
    assert write(path) == list(range(4, 10))


def test_two_runs_do_not_write_one_file(tmp_path: Path) -> None:
    path = tmp_path / "sphere.transport"
    with pytest.raises(OutputError, match="another run"), writing(path, plan_file()), writing(path, plan_file()):
        pass


@pytest.mark.parametrize("operation", ["create", "lock", "write", "rename", "fsync", "close"])
def test_faults_of_the_disk_leave_the_target_as_it_was(operation: str, file: Path) -> None:
    before = file.read_bytes()

    def fault(name: str, _path: Path) -> None:
        if name == operation:
            raise OSError(28, "no space")

    atomic.fault = fault
    with pytest.raises(OutputError, match=r"sphere\.transport: the disk is full"):
        write(file, settings={"edge": 32})
    atomic.fault = None
    assert file.read_bytes() == before
    assert write(file, settings={"edge": 32}) is not None
    assert open_transport(file).settings["edge"] == 32


def test_short_writes_are_carried_on(tmp_path: Path) -> None:
    atomic.fault = lambda name, _path: 4096 if name == "write" else None
    write(tmp_path / "a.transport")
    open_transport(tmp_path / "a.transport")


def test_rows_of_another_shape_or_type_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="rows of words"), writing(tmp_path / "a", plan_file()) as writer:
        writer.put(0, {**rows(0), "words": rows(0)["words"][:50]})
    with pytest.raises(ValueError, match="rows of peaks"), writing(tmp_path / "a", plan_file()) as writer:
        writer.put(0, {**rows(0), "peaks": rows(0)["peaks"].astype(np.float64)})


def test_a_file_of_another_mesh_is_refused(file: Path) -> None:
    with pytest.raises(InputError, match="another mesh"):
        open_transport(file, plane())


@pytest.mark.parametrize("in_memory_bytes", [0, 1 << 30], ids=["in a scratch file", "in memory"])
def test_an_open_file_may_be_cut_short(file: Path, in_memory_bytes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a mapped file this test would end with signal 7."""
    monkeypatch.setattr(scratch, "IN_MEMORY_BYTES", in_memory_bytes)
    found = open_transport(file)
    file.write_bytes(b"")
    assert np.array_equal(found.arrays["words"][:100], rows(0)["words"])
    assert np.array_equal(found.mesh.positions, sphere().positions)


def test_every_truncation_is_refused(file: Path, tmp_path: Path) -> None:
    content = file.read_bytes()
    cut = tmp_path / "cut.transport"
    for part in [*range(64), 63.9999]:
        cut.write_bytes(content[: int(len(content) * part / 64)])
        with pytest.raises(InputError, match=r"transport file|damaged|cut short|cannot be read"):
            open_transport(cut)
    cut.write_bytes(content + b"0")
    with pytest.raises(InputError, match="damaged or cut short"):
        open_transport(cut)


def test_every_flipped_bit_that_means_something_is_found(old: Path, tmp_path: Path) -> None:
    content = bytearray(old.read_bytes())
    header = plan_file().header
    meaningful = [*range(8), 8, 12, 100, 500, header.table_offset, header.table_offset + 3, header.table_offset + 80]
    for array in header.arrays:
        meaningful += [array.offset, array.offset + array.size_bytes // 2, array.offset + array.size_bytes - 1]
    damaged = tmp_path / "damaged.transport"
    for place in meaningful:
        content[place] ^= 4
        damaged.write_bytes(content)
        with pytest.raises(InputError, match=r"damaged|not a transport file"):
            open_transport(damaged)
        content[place] ^= 4


def with_header(change: dict[str, Any], file: Path) -> None:
    """Put a header with other values, and the checksum that belongs to it, into `file` of version 1."""
    content = file.read_bytes()
    value = {**plan_file().header.model_dump(), **change}
    text = json.dumps(value, sort_keys=True).encode()
    start = plan_file().header.table_offset
    head = b"LATRANS1" + len(text).to_bytes(4, "little") + zlib.crc32(text).to_bytes(4, "little") + text
    file.write_bytes(head.ljust(start, b"\0") + content[start:])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"version": 3}, "newer Lightarc"),
        ({"version": 2}, "table of its blocks"),
        ({"chunks": 1 << 26}, "where something else is"),
        ({"chunks": 9}, "table of its chunks"),
        ({"table_offset": 1 << 47}, "where something else is"),
        ({"size_bytes": 1 << 47}, "bytes instead"),
        ({"arrays": []}, "do not fit its size"),
        ({"kind": "../x"}, "faulty kind"),
        ({"more": 1}, "faulty more"),
    ],
)
def test_headers_that_lie_are_refused(change: dict[str, Any], message: str, old: Path) -> None:
    with_header(change, old)
    with pytest.raises(InputError, match=message):
        open_transport(old)


@pytest.mark.parametrize("field", ["dtype", "shape", "offset", "name"])
def test_arrays_that_lie_are_refused(field: str, old: Path) -> None:
    for number, array in enumerate(plan_file().header.model_dump()["arrays"]):
        lie = {"dtype": "|b1", "shape": [1 << 40, 1 << 8], "offset": array["offset"] + 4096 * 3, "name": "other"}[field]
        arrays = plan_file().header.model_dump()["arrays"]
        arrays[number] = {**array, field: lie}
        with_header({"arrays": arrays}, old)
        if array["name"] in ("words", "peaks", "view_maps") and field in ("name", "dtype"):
            continue  # what a reader of this kind of transport finds, not the container
        with pytest.raises(InputError):
            open_transport(old)


def repack(file: Path, change: dict[str, Any]) -> None:
    """Put a header with other values, and the checksum that belongs to it, into the packed `file`."""
    content = file.read_bytes()
    length = int.from_bytes(content[8:12], "little")
    text = json.dumps({**json.loads(content[16 : 16 + length]), **change}, sort_keys=True).encode()
    head = b"LATRANS1" + len(text).to_bytes(4, "little") + zlib.crc32(text).to_bytes(4, "little") + text
    file.write_bytes(head + content[16 + length :])


def test_a_small_file_that_declares_much_is_refused_before_there_is_room_for_it(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(packing, "scratch_array", lambda *_: pytest.fail("room was made"))
    arrays = json.loads(header_text(plan_file().header))["arrays"]
    last = arrays[-1]
    arrays[-1] = {**last, "shape": [1 << 30, 3]}
    repack(file, {"arrays": arrays, "size_bytes": last["offset"] + 12 * (1 << 30) + 4096})
    with pytest.raises(InputError, match="more than it can hold"):
        open_transport(file)


def test_packed_files_whose_headers_lie_are_refused(file: Path) -> None:
    whole = file.read_bytes()
    arrays = json.loads(header_text(plan_file().header))["arrays"]
    for change in (
        {"size_bytes": plan_file().size_bytes + 4096},
        {"chunks": 1 << 26, "table_offset": 0},
        {"chunks": 9},
        {"arrays": [{**each, "dtype": "<u2"} if each["name"] == "words" else each for each in arrays]},
        {"arrays": [{**each, "shape": [9, 12]} if each["name"] == "view_maps" else each for each in arrays]},
    ):
        file.write_bytes(whole)
        repack(file, change)
        with pytest.raises(InputError):
            open_transport(file)


def test_every_flipped_bit_of_a_packed_file_is_found(file: Path, tmp_path: Path) -> None:
    content, damaged = bytearray(file.read_bytes()), tmp_path / "damaged.transport"
    size = len(content) - 4096  # of what is not the page of the check
    for place in (*range(8), 8, 12, 100, *np.linspace(500, size - 1, 100).astype(int), *range(size - 90, size)):
        content[place] ^= 4
        damaged.write_bytes(content)
        with pytest.raises(InputError, match=r"damaged|cut short|not a transport file"):
            open_transport(damaged)
        content[place] ^= 4


def test_what_packs_to_less_than_a_thousandth_is_padded(tmp_path: Path) -> None:
    known = {"lobes": np.zeros((1 << 22, 1), np.float32)}
    plan = plan_transport("gaussian", plane(), {}, known, {}, np.zeros(1, np.int64))
    write_transport(tmp_path / "a", plan)
    assert (tmp_path / "a").stat().st_size >= plan.size_bytes / 1000
    assert not open_transport(tmp_path / "a").arrays["lobes"].any()


def test_what_is_no_file_of_ours_is_refused(tmp_path: Path) -> None:
    (tmp_path / "empty").write_bytes(b"")
    (tmp_path / "text").write_bytes(b"x" * 5000)
    os.mkfifo(tmp_path / "pipe")
    for name in ("empty", "text", "pipe", "absent", "", "x\0y"):
        with pytest.raises(InputError):
            open_transport(tmp_path / name)
        assert not holds_transport(tmp_path / name)


def test_rows_that_were_put_can_be_read_back(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="missing"):
        write(tmp_path / "a", [3])
    with suppress(KeyboardInterrupt), writing(tmp_path / "a", plan_file()) as writer:
        assert 3 not in writer.missing
        assert all(np.array_equal(writer.get(3)[name], values) for name, values in rows(3).items())
        raise KeyboardInterrupt


def test_arrays_that_are_all_known_are_written_at_once(tmp_path: Path) -> None:
    known = {"lobes": np.arange(24.0, dtype=np.float32).reshape(2, 3, 4), "none": np.zeros((0, 3), np.float32)}
    plan = plan_transport("gaussian", sphere(), {"lobes": 1}, known, {}, np.zeros(1, np.int64))
    write_transport(tmp_path / "a", plan)
    found = open_transport(tmp_path / "a", sphere())
    assert found.kind == "gaussian"
    assert all(np.array_equal(found.arrays[name], values) for name, values in known.items())
    with pytest.raises(ValueError, match="chunks"):
        write_transport(tmp_path / "b", plan_file())
