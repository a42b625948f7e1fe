"""OBJ and OFF: polygons as text, whole, with corners that may be wrong and numbers that may not.

Wavefront OBJ: `v`, `vt`, `vn` and `f`, indices from 1 or backwards from the line they stand on, lines continued with
a backslash. Colours of vertices (`v x y z r g b`) are coded as sRGB, as MeshLab and Blender write them. Groups and
curves say nothing about the shape and are passed over; of materials the names are kept (`usemtl`), and no other file is
opened. OFF with any of the prefixes ST, C and N.
Ours instead of trimesh's, because that cuts every polygon as a fan, and refuses files for one wrong index.
Cost: about 0.25 s for 100,000 triangles, half of it in taking lines apart, and 250 bytes a triangle.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import srgb_decode
from engine.core.errors import InputError
from engine.geometry.gltf import NO_MATERIAL
from engine.geometry.polygons import Polygons
from engine.storage.untrusted import AGAIN

Rows = tuple[list[int], list[bytes]]

#: Bytes of an OBJ that are taken apart at once: the objects of its lines take twenty times as much.
BLOCK_BYTES = 1 << 22

_OFF_HEADER = re.compile(rb"(?P<st>ST)?(?P<c>C)?(?P<n>N)?(?P<odd>4?n?)OFF")
_ONE_SPACE = bytes.maketrans(b"\t\x0b\x0c", b"   ")
_NOT_A_NUMBER = re.compile(rb"[+-]?(1\.#|nan|inf)", re.IGNORECASE)


class _Stated(NamedTuple):
    """What lines of an OBJ state, in their order: the numbers of the lines by kind, and a row for each.

    points (V, 3), colours (V, 3) linear and NaN where a point states none, uv (T, 2), normals (N, 3), sizes (F,) of
    faces and corners (C, 3), their indices as they are written.
    """

    point_lines: NDArray[np.int64]
    uv_lines: NDArray[np.int64]
    normal_lines: NDArray[np.int64]
    face_lines: NDArray[np.int64]
    points: NDArray[np.float64]
    colours: NDArray[np.float64]
    uv: NDArray[np.float64]
    normals: NDArray[np.float64]
    sizes: NDArray[np.int64]
    corners: NDArray[np.int64]


def read_obj(content: bytes, name: str) -> Polygons:
    """The polygons of an OBJ file; InputError for what should be a number and is none, with its line."""
    blocks, materials = list[_Stated](), (list[int](), list[bytes]())
    for first, lines in _blocks(content):
        rows = _obj_rows(lines, first)
        blocks.append(_read_rows(rows, name))
        numbers, names = rows[b"usemtl"]
        materials[0].extend(numbers)
        materials[1].extend(names)
    stated = _Stated(*(np.concatenate(columns) for columns in zip(*blocks, strict=True)))
    del blocks
    sizes, absolute = stated.sizes, stated.corners
    for column, lines_of in enumerate((stated.point_lines, stated.uv_lines, stated.normal_lines)):
        relative = absolute[:, column]
        behind = relative < 0  # counts from its own line
        backwards = np.repeat(np.searchsorted(lines_of, stated.face_lines), sizes)[behind] + relative[behind]
        absolute[:, column] = np.where(relative > 0, relative - 1, -1)
        absolute[behind, column] = backwards
    part, part_names = _materials(materials, stated.face_lines)
    colours = None if np.isnan(stated.colours).all() else stated.colours
    if colours is not None and part is None:
        part, part_names = np.zeros(len(sizes), np.int64), (NO_MATERIAL,)
    return Polygons(
        stated.points,
        absolute[:, 0],
        sizes,
        _pick(stated.normals, absolute[:, 2] if len(stated.normals) else None),
        _pick(stated.uv, absolute[:, 1] if len(stated.uv) else None),
        None if colours is None else _pick(colours, absolute[:, 0]),
        part,
        part_names,
    )


def _blocks(content: bytes) -> Iterator[tuple[int, list[bytes]]]:
    """The number of the first line of each block, and the lines, without their ends; one block at least."""
    text = content.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    text = text.translate(_ONE_SPACE).replace(b"\\\n", b" ")
    start, first = 0, 1
    while start <= len(text):
        end = text.find(b"\n", start + BLOCK_BYTES)
        end = len(text) if end < 0 else end
        lines = text[start:end].split(b"\n")
        yield first, lines
        start, first = end + 1, first + len(lines)


def _read_rows(rows: dict[bytes, Rows], name: str) -> _Stated:
    """The numbers of a block of lines."""
    lines = {key: np.asarray(numbers, np.int64) for key, (numbers, _) in rows.items()}
    points, normals = _table(rows[b"v"], 3, name), _table(rows[b"vn"], 3, name)
    uv = _table(rows[b"vt"], 2, name, least=1)
    sizes, index = _face_indices(rows[b"f"], name)
    colours = _colours(rows[b"v"], name)
    return _Stated(lines[b"v"], lines[b"vt"], lines[b"vn"], lines[b"f"], points, colours, uv, normals, sizes, index)


def _colours(rows: Rows, name: str) -> NDArray[np.float64]:
    """(rows, 3) linear colours of points that state x y z r g b, NaN for the others."""
    stated = np.isin(_count_numbers(rows[1]), (6, 7))
    found = np.full((len(stated), 3), np.nan)
    if stated.any():
        given = [(number, line.split(maxsplit=3)[3]) for number, line, has in zip(*rows, stated, strict=True) if has]
        found[stated] = linear_colours(_table(([each[0] for each in given], [each[1] for each in given]), 3, name))
    return found


def linear_colours(srgb: NDArray[np.float64]) -> NDArray[np.float64]:
    """Linear colours of what programs write for vertices, which is coded as sRGB."""
    return np.asarray(srgb_decode(np.clip(np.nan_to_num(srgb, nan=1.0), 0.0, 1.0)), np.float64)


def _materials(rows: Rows, lines: NDArray[np.int64]) -> tuple[NDArray[np.int64] | None, tuple[str, ...]]:
    """The material of each face by the lines that they stand on, and the names of all; None without any."""
    if not rows[0]:
        return None, ()
    stated = [said.decode("utf-8", "replace").strip() or NO_MATERIAL for said in rows[1]]
    names = list(dict.fromkeys([NO_MATERIAL, *stated]))
    of_row = np.array([0, *(names.index(each) for each in stated)])
    used, part = np.unique(of_row[np.searchsorted(rows[0], lines)], return_inverse=True)
    return part.reshape(-1), tuple(names[at] for at in used)


def _obj_rows(lines: Iterable[bytes], first: int) -> dict[bytes, Rows]:
    """For each kind of line that matters the numbers of its lines, and what they say."""
    rows: dict[bytes, Rows] = {key: ([], []) for key in (b"v", b"vt", b"vn", b"f", b"usemtl")}
    for number, line in enumerate(lines, first):
        key, _, said = line.lstrip(b" ").partition(b" ")
        if key in rows:
            numbers, kept = rows[key]
            numbers.append(number)
            kept.append(said.partition(b" #")[0] if b"#" in said else said)
    return rows


def _words_of(lines: Sequence[bytes]) -> tuple[NDArray[np.uint8], NDArray[np.intp], NDArray[np.intp]]:
    """The bytes of lines, each with an end, the starts of the words in them, and the line of each word."""
    text = np.frombuffer(b"\n".join([*lines, b""]), np.uint8)
    space = (text == ord(" ")) | (text == ord("\n"))
    starts = np.flatnonzero(~space & np.concatenate([[True], space[:-1]]))
    return text, starts, np.searchsorted(np.flatnonzero(text == ord("\n")), starts)


def _count_numbers(lines: Sequence[bytes]) -> NDArray[np.int64]:
    """(lines,) words of each line."""
    return np.bincount(_words_of(lines)[2], minlength=len(lines)).astype(np.int64)


def _face_indices(rows: Rows, name: str) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(F,) corners of faces and (C, 3) indices of point, uv and normal as they are written, 0 where there is none."""
    written, starts, of_line = _words_of(rows[1])
    sizes = np.bincount(of_line, minlength=len(rows[1])).astype(np.int64)
    line = np.repeat(np.asarray(rows[0], np.int64), sizes)
    slashes = np.bincount(
        np.searchsorted(starts, np.flatnonzero(written == ord("/")), "right") - 1, minlength=len(line)
    )
    columns = 1 + int(slashes.max(initial=0))
    if columns > 3:
        number = line[np.argmax(slashes > 2)]
        raise InputError(name, f"is damaged: line {number} gives a corner with too many parts", AGAIN)
    if np.any(written[starts] == ord("/")):
        number = line[np.argmax(written[starts] == ord("/"))]
        raise InputError(name, f"is damaged: line {number} gives a corner without a point", AGAIN)
    text = written.tobytes()
    if slashes.min(initial=columns) != columns - 1:
        columns = 3
        text = b" ".join(corner + b"/0" * (2 - corner.count(b"/")) for corner in text.split()) + b" "
    if columns > 1:
        for ending in (b"/ ", b"/\n"):
            text = text.replace(ending, b"/0 ")
        text = text.replace(b"//", b"/0/").replace(b"/", b" ")
    read = _floats(text, np.repeat(line, columns), name).reshape(-1, columns)
    whole = np.where(np.abs(read) < 2.0**53, read, 0.0).astype(np.int64)
    broken = np.any(np.floor(read) != read, axis=1)
    if broken.any():
        number = line[np.argmax(broken)]
        raise InputError(name, f"is damaged: an index in line {number} is not a whole number", AGAIN)
    return sizes, np.pad(whole, ((0, 0), (0, 3 - columns)))


def _pick(table: NDArray[np.float64], index: NDArray[np.int64] | None) -> NDArray[np.float64] | None:
    """Rows of `table`, NaN where the index names none."""
    if index is None:
        return None
    inside = (index >= 0) & (index < len(table))
    return np.where(inside[:, None], table[np.where(inside, index, 0)], np.nan)


def _table(rows: Rows, columns: int, name: str, least: int | None = None) -> NDArray[np.float64]:
    """(rows, columns) the first numbers of each row; a row of at least `least` is filled up with 0."""
    numbers, lines = rows
    counts = _count_numbers(lines)
    if np.any(counts < (least or columns)):
        number = numbers[int(np.argmax(counts < (least or columns)))]
        raise InputError(name, f"is damaged: {columns} numbers are missing in line {number}", AGAIN)
    if np.any(counts != columns):
        lines = [b" ".join([*line.split()[:columns], *[b"0"] * (columns - len(line.split()))]) for line in lines]
    return _floats(b"\n".join(lines), np.repeat(numbers, columns), name).reshape(-1, columns)


def _floats(text: bytes, line: NDArray[np.int64], name: str) -> NDArray[np.float64]:
    """Numbers of words; NaN for the several ways to write that, InputError with its line for what is none."""
    fast = numbers_of(text)
    if fast is not None and len(fast) == len(line):
        return fast
    slow = np.empty(len(line))
    for place, token in enumerate(text.split()):
        try:
            slow[place] = float(token.replace(b"_", b"?"))
        except ValueError:
            if not _NOT_A_NUMBER.match(token):
                said = token[:24].decode("utf-8", "replace")
                raise InputError(name, f"is damaged: {said!r} in line {line[place]} is not a number", AGAIN) from None
            slow[place] = np.nan
    return slow


def numbers_of(text: bytes) -> NDArray[np.float64] | None:
    """All numbers of a text that holds nothing else; None where it does."""
    if not text.strip():
        return np.empty(0)
    with warnings.catch_warnings():
        # numpy's way to say that it stopped before the end, until it became an error
        warnings.simplefilter("error", DeprecationWarning)
        try:
            return np.fromstring(text, np.float64, sep=" ")
        except (DeprecationWarning, ValueError):
            return None


def read_off(content: bytes, name: str) -> Polygons:
    """The polygons of an OFF file, with its normals and texture coordinates where it has them."""
    lines = (line.partition(b"#")[0].split() for line in content.splitlines())
    rows = [(number, line) for number, line in enumerate(lines, 1) if line]
    header = _OFF_HEADER.fullmatch(rows[0][1][0]) if rows else None
    if header is None:
        raise InputError(name, "is damaged or of an unknown kind: it does not begin with OFF", AGAIN)
    first, beside = rows[0][0], rows[0][1][1:]
    if header["odd"] or beside[:1] == [b"BINARY"]:
        raise InputError(name, "is OFF of a kind that is not read (binary, or of four dimensions)", "Export it as PLY")
    rows = [(first, beside), *rows[1:]] if beside else rows[1:]
    counts = _whole(rows[0][1][:2], rows[0][0], name) if rows else []
    if len(counts) < 2 or min(counts) < 0 or len(rows) <= sum(counts):
        raise InputError(name, f"is damaged: it announces {counts} vertices and faces, which do not follow", AGAIN)
    vertices, faces = rows[1 : 1 + counts[0]], rows[1 + counts[0] : 1 + sum(counts)]
    points = _columns(vertices, slice(0, 3), 3, name)
    sizes = [_whole(line[:1], number, name)[0] for number, line in faces]
    for (number, line), size in zip(faces, sizes, strict=True):
        if not 0 <= size < len(line):
            raise InputError(name, f"is damaged: line {number} names {size} corners and gives fewer", AGAIN)
    corners = [b" ".join(line[1 : 1 + size]) for (_, line), size in zip(faces, sizes, strict=True)]
    index = _face_indices(([number for number, _ in faces], corners), name)[1][:, 0]
    normals = _columns(vertices, slice(3, 6), 3, name) if header["n"] else None
    uv = _columns(vertices, slice(-2, None), 2, name) if header["st"] else None
    inside = np.where((index >= 0) & (index < len(points)), index, -1)
    of_corners = [None if table is None else _pick(table, inside) for table in (normals, uv)]
    return Polygons(points, index, np.array(sizes, np.int64), of_corners[0], of_corners[1])


def _columns(rows: Iterable[tuple[int, list[bytes]]], part: slice, count: int, name: str) -> NDArray[np.float64]:
    numbers, lines = [], []
    for number, line in rows:
        numbers.append(number)
        lines.append(b" ".join(line[part]))
    return _table((numbers, lines), count, name)


def _whole(tokens: Sequence[bytes], line: int, name: str) -> list[int]:
    if not all(re.fullmatch(rb"[+-]?\d{1,15}", token) for token in tokens):
        raise InputError(name, f"is damaged: line {line} does not begin with counts", AGAIN)
    return [int(token) for token in tokens]
