"""Text meshes (OBJ, OFF, ASCII PLY and STL, glTF) before they are parsed: their letters, and whether they are whole.

The parsers read UTF-8 only, to which UTF-16 and Latin-1 are turned, and trimesh takes what is there for all there is.
PLY and OFF say beforehand how many lines follow; ASCII STL has an end mark, which trimesh wants. OBJ has neither: one
that was cut between two lines cannot be noticed.
"""

from __future__ import annotations

from collections.abc import Iterator

from engine.core.errors import InputError
from engine.storage.text import utf8
from engine.storage.untrusted import AGAIN

_STL_HEADER_BYTES, _STL_FACE_BYTES = 84, 50
_COUNT_DIGITS = 12


def check_text(content: bytes, kind: str, name: str) -> bytes:
    """`content` of a mesh of `kind` ("obj", …), text as UTF-8; InputError where lines that it announces are missing."""
    if kind in ("obj", "off", "ply", "gltf") or (kind.startswith("stl") and not _is_binary_stl(content)):
        content = utf8(content)
    if kind == "ply" and b"ascii" in content[:40]:
        header, end, body = content.partition(b"end_header")
        _check_lines(body.strip().count(b"\n") + 1, sum(ply_counts(header).values()) if end else 0, name)
    elif kind == "off":
        _check_off(content, name)
    if kind in ("obj", "off") or (kind == "stl" and not _is_binary_stl(content)):
        return _as_utf8(content)
    return content


def ply_counts(header: bytes) -> dict[bytes, int]:
    """Number of each element that the header of a PLY file announces."""
    lines = [line.split() for line in header.splitlines() if line.startswith(b"element")]
    return {words[1]: int(words[2]) for words in lines if len(words) == 3 and _is_count(words[2])}


def off_counts(content: bytes) -> tuple[int, int] | None:
    """The vertices and faces that an OFF file announces, None where it does not."""
    return _two_counts(next(_off_lines(content), b""))


def _off_lines(content: bytes) -> Iterator[bytes]:
    """The lines after the word OFF that hold anything but a comment."""
    lines = (line.partition(b"#")[0].strip() for line in content.partition(b"OFF")[2].splitlines())
    return (line for line in lines if line)


def _two_counts(line: bytes) -> tuple[int, int] | None:
    words = line.split(maxsplit=2)[:2]
    return (int(words[0]), int(words[1])) if len(words) == 2 and all(map(_is_count, words)) else None


def _is_count(word: bytes) -> bool:
    return word.isdigit() and len(word) <= _COUNT_DIGITS


def _check_off(content: bytes, name: str) -> None:
    lines = list(_off_lines(content))
    counts = _two_counts(lines[0]) if lines else None
    if counts:
        _check_lines(len(lines) - 1, sum(counts), name)


def _check_lines(found: int, announced: int, name: str) -> None:
    if found < announced:
        raise InputError(name, f"is damaged: of {announced} lines that it announces, {found} follow", AGAIN)


def _is_binary_stl(content: bytes) -> bool:
    return len(content) == _STL_HEADER_BYTES + _STL_FACE_BYTES * int.from_bytes(content[80:84], "little")


def _as_utf8(content: bytes) -> bytes:
    """Names and comments of older programs are in Latin-1, in which every byte is a letter."""
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1").encode("utf-8")
    return content
