"""Zips and folders of strangers (fault 8): nothing outside, nothing unknown, nothing larger than announced."""

from __future__ import annotations

import io
import os
import stat
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from engine.core.errors import InputError
from engine.storage.archive import Archive, open_archive

KNOWN = frozenset({"manifest.json", "shader/lightarc.glsl"})


def pack(*entries: tuple[str | zipfile.ZipInfo, bytes], method: int = zipfile.ZIP_DEFLATED) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return stream.getvalue()


def entry(name: str, *, mode: int = 0o100644, flags: int = 0) -> zipfile.ZipInfo:
    info = zipfile.ZipInfo(name)
    info.external_attr, info.flag_bits, info.create_system = mode << 16, flags, 3
    return info


def open_path(folder: Path, content: bytes) -> Archive:
    path = folder / "hostile.lightarc"
    path.write_bytes(content)
    before = sorted(folder.rglob("*"))
    try:
        return open_archive(path, KNOWN)
    finally:
        assert sorted(folder.rglob("*")) == before


def complaint_of(folder: Path, content: bytes) -> str | None:
    try:
        archive = open_path(folder, content)
        for name in archive.sizes:
            archive.read(name)
    except InputError as error:
        return str(error)
    return None


GOOD = pack(("manifest.json", b"{}"), ("shader/lightarc.glsl", b"void"))


def test_a_good_zip_opens(tmp_path: Path) -> None:
    archive = open_path(tmp_path, GOOD)
    assert dict(archive.sizes) == {"manifest.json": 2, "shader/lightarc.glsl": 4}
    assert archive.read("shader/lightarc.glsl") == b"void"
    assert archive.size_bytes == len(GOOD)


def test_folder_entries_of_other_packers_are_harmless(tmp_path: Path) -> None:
    content = pack(("shader/", b""), ("manifest.json", b"{}"))
    assert list(open_path(tmp_path, content).sizes) == ["manifest.json"]


NAMES = [
    "../manifest.json", "/manifest.json", "C:\\manifest.json", "C:manifest.json", "shader/../manifest.json",
    "Manifest.json", "manifest.json/", "./manifest.json", "shader\\lightarc.glsl", "manifest.json ", "inner.zip",
    "x" * 251, "m\u0430nifest.json", "\u202emanifest.json", "shader/lightarc.glsl/x", "a/" * 500 + "b",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES, ids=lambda name: ascii(name[:24]))
def test_fault_8_only_known_names(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError) as caught:
        open_path(tmp_path, pack(("manifest.json", b"{}"), (name, b"x")))
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500 + len(str(tmp_path))


def test_fault_8_nul_in_a_name(tmp_path: Path) -> None:
    content = pack(("manifest.json#evil", b"{}")).replace(b"manifest.json#", b"manifest.json\0")
    with pytest.raises(InputError, match="impossible name"):
        open_path(tmp_path, content)


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_fault_8_duplicates(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="twice"):
        open_path(tmp_path, pack(("manifest.json", b"{}"), ("manifest.json", b"[]")))


@pytest.mark.parametrize("mode", [stat.S_IFLNK | 0o777, stat.S_IFIFO | 0o600, stat.S_IFCHR | 0o600], ids=oct)
def test_fault_8_links_and_devices_in_a_zip(tmp_path: Path, mode: int) -> None:
    with pytest.raises(InputError, match="not a regular file"):
        open_path(tmp_path, pack((entry("manifest.json", mode=mode), b"/etc/passwd")))


def test_fault_8_encrypted(tmp_path: Path) -> None:
    content = bytearray(pack(("manifest.json", b"{}")))
    content[content.index(b"PK\1\2") + 8] |= 1
    with pytest.raises(InputError, match="encrypted"):
        open_path(tmp_path, bytes(content))


def test_fault_8_unknown_method(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="unknown method"):
        open_path(tmp_path, pack(("manifest.json", b"{}"), method=zipfile.ZIP_BZIP2))


def test_fault_8_wrong_checksum(tmp_path: Path) -> None:
    content = bytearray(pack(("manifest.json", b'{"a": 1}'), method=zipfile.ZIP_STORED))
    content[content.index(b'"a"') + 1] ^= 1
    with pytest.raises(InputError, match="damaged"):
        open_path(tmp_path, bytes(content)).read("manifest.json")


def test_fault_8_bomb_that_tells_its_size(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="more than 100 times"):
        open_path(tmp_path, pack(("manifest.json", bytes(20_000_000))))


def test_fault_8_bomb_that_lies_about_its_size(tmp_path: Path) -> None:
    content = bytearray(pack(("manifest.json", bytes(40_000_000))))
    for signature, offset in ((b"PK\1\2", 24), (b"PK\3\4", 22)):
        start = content.index(signature) + offset
        content[start : start + 4] = struct.pack("<L", 1000)
    archive = open_path(tmp_path, bytes(content))
    tracemalloc.start()
    with pytest.raises(InputError, match="damaged"):
        archive.read("manifest.json")
    assert tracemalloc.get_traced_memory()[1] < 5_000_000
    tracemalloc.stop()


def test_fault_8_more_than_a_bundle_may_hold(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.storage.archive.BUNDLE_LIMIT_BYTES", 4 << 30)
    content = bytearray(pack(("manifest.json", b"{}"), ("shader/lightarc.glsl", b"x")))
    at = -1
    for _ in range(2):
        at = content.index(b"PK\1\2", at + 1)
        content[at + 20 : at + 28] = struct.pack("<LL", 0xFFFFFFF0, 0xFFFFFFF0)
    with pytest.raises(InputError, match="more than 4 GiB"):
        open_path(tmp_path, bytes(content))


def test_fault_8_a_million_members_cost_nothing(tmp_path: Path) -> None:
    record = GOOD[GOOD.index(b"PK\1\2") : GOOD.index(b"PK\5\6")]
    directory = record * 500_000
    end = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, 10, 10, len(directory), 0, 0)
    (tmp_path / "million.lightarc").write_bytes(directory + end)
    tracemalloc.start()
    with pytest.raises(InputError, match="more than an archive may"):
        open_archive(tmp_path / "million.lightarc", KNOWN)
    assert tracemalloc.get_traced_memory()[1] < 2 * (len(directory) + 1_000_000)
    tracemalloc.stop()


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda content: b"", "empty"),
        (lambda content: b"GIF89a" + bytes(100), "not a zip archive"),
        (lambda content: content + b"more", "cut short or has data"),
        (lambda content: b"#!/bin/sh\n" + content, "does not fit"),
        (lambda content: content[:-22] + content[-22:-2] + b"\5\0hello", "cut short or has data"),
    ],
    ids=["empty", "another kind", "data after", "data before", "comment"],
)
def test_fault_8_what_is_not_exactly_a_zip(tmp_path: Path, change: Callable[[bytes], bytes], match: str) -> None:
    with pytest.raises(InputError, match=match):
        open_path(tmp_path, change(GOOD))


def test_fault_5_every_truncation_is_noticed(tmp_path: Path) -> None:
    for length in range(len(GOOD)):
        with pytest.raises(InputError):
            open_path(tmp_path, GOOD[:length])


@pytest.mark.campaign(rounds=24)
def test_fault_5_no_flipped_bit_crashes(tmp_path: Path, seed: int) -> None:
    for bit in range(seed % 24, 8 * len(GOOD), 24):
        content = bytearray(GOOD)
        content[bit // 8] ^= 1 << bit % 8
        complaint = complaint_of(tmp_path, bytes(content))
        assert complaint is None or complaint.isprintable()


def folder_bundle(folder: Path) -> Path:
    bundle = folder / "bundle"
    (bundle / "shader").mkdir(parents=True)
    (bundle / "manifest.json").write_bytes(b"{}")
    (bundle / "shader" / "lightarc.glsl").write_bytes(b"void")
    (bundle / ".DS_Store").touch()
    return bundle


def test_a_good_folder_opens(tmp_path: Path) -> None:
    archive = open_archive(folder_bundle(tmp_path), KNOWN)
    assert dict(archive.sizes) == {"manifest.json": 2, "shader/lightarc.glsl": 4}
    assert archive.read("manifest.json") == b"{}"


def test_fault_8_links_in_a_folder(tmp_path: Path) -> None:
    bundle = folder_bundle(tmp_path)
    (tmp_path / "secret").write_bytes(b"{}")
    (bundle / "manifest.json").unlink()
    (bundle / "manifest.json").symlink_to(tmp_path / "secret")
    with pytest.raises(InputError, match="not a regular file"):
        open_archive(bundle, KNOWN)
    (bundle / "manifest.json").unlink()
    (bundle / "shader").rename(tmp_path / "elsewhere")
    (bundle / "shader").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="'shader' is not a regular file"):
        open_archive(bundle, KNOWN)


@pytest.mark.parametrize("name", ["notes.txt", "Manifest.json", "deep/er"])
def test_fault_8_unknown_files_in_a_folder(tmp_path: Path, name: str) -> None:
    bundle = folder_bundle(tmp_path)
    (bundle / name).parent.mkdir(exist_ok=True)
    (bundle / name).touch()
    with pytest.raises(InputError, match=r"no bundle holds|not a regular file"):
        open_archive(bundle, KNOWN)


def test_fault_12_pipes_devices_and_nothing(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    for path in (tmp_path / "pipe", Path("/dev/zero"), tmp_path / "loop", tmp_path / "absent", "nul\0", "x" * 300):
        with pytest.raises(InputError):
            open_archive(path, KNOWN)
    bundle = folder_bundle(tmp_path)
    (bundle / "manifest.json").unlink()
    os.mkfifo(bundle / "manifest.json")
    with pytest.raises(InputError, match="not a regular file"):
        open_archive(bundle, KNOWN)
