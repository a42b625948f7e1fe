"""Archives of strangers (fault 8) that are unpacked: only whole, plain, wanted files, and never outside the folder."""

from __future__ import annotations

import bz2
import gzip
import io
import lzma
import stat
import struct
import tarfile
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.core.steps import drain
from engine.storage import unpack as unpacking
from engine.storage.unpack import is_archive, unpack

RANDOM = np.random.default_rng(1)
PHOTOGRAPHS = {f"photos/im_{n}.png": RANDOM.bytes(3000) for n in range(3)}
PACKERS: dict[str, Callable[[bytes], bytes]] = {
    "tar": bytes,
    "tar.gz": gzip.compress,
    "tar.bz2": bz2.compress,
    "tar.xz": lzma.compress,
}


def zip_entries(entries: Iterable[tuple[str | zipfile.ZipInfo, bytes]], comment: bytes = b"") -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.comment = comment
        for name, content in entries:
            archive.writestr(name, content)
    return stream.getvalue()


def tar(entries: Iterable[tuple[str | tarfile.TarInfo, bytes]], kind: int = tarfile.PAX_FORMAT) -> bytes:
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode="w", format=kind) as archive:
        for name, content in entries:
            info = name if isinstance(name, tarfile.TarInfo) else tarfile.TarInfo(name)
            info.size = info.size or len(content)
            archive.addfile(info, io.BytesIO(content))
    return stream.getvalue()


def pack(kind: str, entries: Iterable[tuple[Any, bytes]]) -> bytes:
    return zip_entries(entries) if kind == "zip" else PACKERS[kind](tar(entries))


def unpack_entries(folder: Path, content: bytes, name: str = "stranger.zip") -> dict[str, bytes]:
    """The files in the target afterwards; nothing else may have appeared."""
    path, target = folder / name, folder / "target"
    path.write_bytes(content)
    target.mkdir(exist_ok=True)
    members = drain(unpack(path, target, lambda names: names))
    written = {file.name: file.read_bytes() for file in target.iterdir()}
    assert set(written) == set(members)
    assert {file.name for file in folder.iterdir()} == {name, "target"}
    return written


def complaint(folder: Path, content: bytes) -> str:
    """Why it is refused; whatever was written before that lies in the target."""
    with pytest.raises(InputError) as refusal:
        unpack_entries(folder, content)
    assert {file.name for file in folder.iterdir()} == {"stranger.zip", "target"}
    assert not [file for file in (folder / "target").iterdir() if file.is_symlink()]
    return str(refusal.value)


@pytest.mark.parametrize("kind", ["zip", *PACKERS])
def test_all_kinds_give_back_what_was_packed(tmp_path: Path, kind: str) -> None:
    content = pack(kind, PHOTOGRAPHS.items())
    path = tmp_path / "plain"
    path.write_bytes(content)
    assert is_archive(path)
    path.unlink()
    assert unpack_entries(tmp_path, content) == {
        name.removeprefix("photos/"): data for name, data in PHOTOGRAPHS.items()
    }


def test_the_wanted_members_alone_are_written_and_their_places_reported(tmp_path: Path) -> None:
    path = tmp_path / "a.zip"
    path.write_bytes(zip_entries([("./x/a.png", b"a"), ("x/b.txt", b"b")]))
    assert drain(unpack(path, tmp_path, lambda names: names[:1])) == {"a.png": "x/a.png"}
    assert sorted(file.name for file in tmp_path.iterdir()) == ["a.png", "a.zip"]


def test_comments_folders_and_backslashes_are_harmless(tmp_path: Path) -> None:
    content = zip_entries(
        [("photos/", b""), ("photos/a.png", b"a"), ("photos\\b.png", b"b")], comment=b"from the studio"
    )
    assert unpack_entries(tmp_path, content) == {"a.png": b"a", "b.png": b"b"}


def test_names_in_utf8_without_the_flag(tmp_path: Path) -> None:
    content = bytearray(zip_entries([("é.png", b"a")]))
    for start, offset in ((content.index(b"PK\3\4"), 6), (content.index(b"PK\1\2"), 8)):
        flags = struct.unpack_from("<H", content, start + offset)[0]
        assert flags & 0x800
        struct.pack_into("<H", content, start + offset, flags & ~0x800)
    assert unpack_entries(tmp_path, bytes(content)) == {"é.png": b"a"}


NAMES = ["../im.png", "photos/../../im.png", "/im.png", "C:\\im.png", "C:im.png", "..\\im.png", "a/\nim.png", "x" * 256]


@pytest.mark.parametrize("kind", ["zip", "tar"])
@pytest.mark.parametrize("name", NAMES, ids=lambda name: ascii(name[:24]))
def test_fault_8_names_that_lead_elsewhere(tmp_path: Path, kind: str, name: str) -> None:
    content = pack(kind, [("photos/good.png", b"good"), (name, b"evil")])
    assert "impossible name" in complaint(tmp_path, content)
    assert not list((tmp_path / "target").iterdir())


def zip_link() -> bytes:
    link = zipfile.ZipInfo("im.png")
    link.external_attr, link.create_system = (stat.S_IFLNK | 0o777) << 16, 3
    return zip_entries([(link, b"/etc/passwd")])


def tar_entry(kind: bytes, **attributes: Any) -> bytes:
    info = tarfile.TarInfo("im.png")
    info.type = kind
    for name, value in attributes.items():
        setattr(info, name, value)
    return tar([(info, b"")])


def sparse() -> bytes:
    content = bytearray(tar_entry(tarfile.REGTYPE))
    content[156:157] = tarfile.GNUTYPE_SPARSE
    content[386:398], content[398:410] = b"00000000000\0", b"00000000000\0"
    content[483:495] = b"77777777777\0"
    content[148:156] = b" " * 8
    content[148:156] = f"{sum(content[:512]):06o}\0 ".encode()
    return bytes(content)


def encrypt() -> bytes:
    content = bytearray(zip_entries([("im.png", b"secret")]))
    for start, offset in ((content.index(b"PK\3\4"), 6), (content.index(b"PK\1\2"), 8)):
        struct.pack_into("<H", content, start + offset, 1)
    return bytes(content)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (zip_link(), "not a regular file"),
        (tar_entry(tarfile.SYMTYPE, linkname="/etc/passwd"), "not a regular file"),
        (tar_entry(tarfile.LNKTYPE, linkname="../x"), "not a regular file"),
        (tar_entry(tarfile.FIFOTYPE), "not a regular file"),
        (tar_entry(tarfile.CHRTYPE), "not a regular file"),
        (sparse(), "not a regular file"),
        (encrypt(), "encrypted"),
        (zip_entries([("a/im.png", b"a"), ("b/IM.png", b"b")]), "holds both"),
        (tar([("im.png", b"a"), ("im.png", b"b")]), "holds both"),
        (b"7z\xbc\xaf\x27\x1c" + bytes(600), "7z archive, which is not read"),
        (b"Rar!\x1a\x07\x01" + bytes(600), "RAR archive, which is not read"),
        (gzip.compress(b"a letter" * 200), "not a tar archive"),
        (b"PK\3\4" + bytes(600), "cut short"),
        (bytes(100), "not a tar archive"),
    ],
    ids=lambda value: value if isinstance(value, str) else "archive",
)  # fmt: skip
def test_fault_8_what_is_no_plain_file_is_refused(tmp_path: Path, content: bytes, words: str) -> None:
    assert words in complaint(tmp_path, content)


@pytest.mark.parametrize("kind", ["zip", "tar.gz", "tar.bz2", "tar.xz"])
def test_fault_8_bombs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    monkeypatch.setattr(unpacking, "RATIO_FLOOR_BYTES", 1000)
    monkeypatch.setattr("engine.storage.archive.RATIO_FLOOR_BYTES", 1000)
    content = pack(kind, [("im.png", bytes(4_000_000))])
    assert "more than 100 times its size" in complaint(tmp_path, content)


@pytest.mark.parametrize("kind", ["zip", "tar", "tar.gz"])
def test_fault_8_limits_on_the_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    content = pack(kind, PHOTOGRAPHS.items())
    monkeypatch.setattr(unpacking, "MEMBER_LIMIT", 2)
    monkeypatch.setattr("engine.storage.archive.MEMBER_LIMIT", 2)
    assert "lists" in complaint(tmp_path, content)
    monkeypatch.setattr(unpacking, "MEMBER_LIMIT", 10)
    monkeypatch.setattr("engine.storage.archive.MEMBER_LIMIT", 10)
    monkeypatch.setattr(unpacking, "RATIO_LIMIT", 0)
    monkeypatch.setattr(unpacking, "RATIO_FLOOR_BYTES", 8000)
    assert "unpack to more than" in complaint(tmp_path, content)


def test_fault_8_a_header_of_a_tar_that_wants_memory(tmp_path: Path) -> None:
    info = tarfile.TarInfo("im.png")
    info.pax_headers = {"comment": "x" * 3_000_000}
    assert "a header of" in complaint(tmp_path, tar([(info, b"a")]))


def test_fault_8_a_size_that_is_a_lie(tmp_path: Path) -> None:
    content = bytearray(zip_entries([("im.png", b"a" * 500)]))
    struct.pack_into("<L", content, content.index(b"PK\1\2") + 24, 400)
    assert "damaged" in complaint(tmp_path, bytes(content))


@pytest.mark.parametrize("kind", ["zip", *PACKERS])
def test_fault_5_every_cut_is_noticed(tmp_path: Path, kind: str) -> None:
    content = pack(kind, PHOTOGRAPHS.items())
    whole = len(content) if kind != "tar" else content.rindex(PHOTOGRAPHS["photos/im_2.png"]) + 3072
    for cut in [*range(1, whole, whole // 60), whole - 1]:
        words = complaint(tmp_path, content[:cut]) if cut else ""
        assert "\n" not in words


@pytest.mark.campaign(rounds=5)
@pytest.mark.parametrize("kind", ["zip", "tar.gz", "tar.bz2", "tar.xz"])
def test_fault_5_flipped_bits_never_change_a_photograph(tmp_path: Path, kind: str, seed: int) -> None:
    content, random = pack(kind, PHOTOGRAPHS.items()), np.random.default_rng(2 + seed)
    good = {name.removeprefix("photos/"): data for name, data in PHOTOGRAPHS.items()}
    refused = 0
    for place in random.integers(0, len(content), 40):
        damaged = bytearray(content)
        damaged[place] ^= 1 << int(random.integers(8))
        for file in (tmp_path / "target").glob("*"):
            file.unlink()
        try:
            written = unpack_entries(tmp_path, bytes(damaged))
        except InputError:
            refused += 1
            continue
        assert all(data in good.values() for data in written.values())
    assert refused > 40 * 2 / 3
