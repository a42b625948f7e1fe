"""OBJ and OFF: polygons as text, whole, with corners that may be wrong and numbers that may not.

Wavefront OBJ: `v`, `vt`, `vn` and `f`, indices from 1 or backwards from the line they stand on, lines continued with
a backslash. Colours of vertices (`v x y z r g b`) are coded as sRGB, as MeshLab and Blender write them. Groups and
curves say nothing about the shape and are passed over; of materials the names are kept (`usemtl`), and no other file is
opened. OFF with any of the prefixes ST, C and N.
Ours instead of trimesh's, because that cuts every polygon as a fan, and refuses files for one wrong index.
Cost: about 0.3 s for 100,000 triangles, most of it in taking lines apart.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import srgb_decode
from engine.core.errors import InputError
from engine.geometry.gltf import NO_MATERIAL
from engine.geometry.polygons import Polygons
from engine.storage.untrusted import AGAIN

Rows = tuple[list[int], list[bytes]]

_OFF_HEADER = re.compile(rb"(?P<st>ST)?(?P<c>C)?(?P<n>N)?(?P<odd>4?n?)OFF")
_NOT_A_NUMBER = re.compile(rb"[+-]?(1\.#|nan|inf)", re.IGNORECASE)


def read_obj(content: bytes, name: str) -> Polygons:
    """The polygons of an OBJ file; InputError for what should be a number and is none, with its line."""
    rows = _obj_rows(content)
    numbers, lines = rows[b"f"]
    tokens = [line.split() for line in lines]
    sizes = np.array([len(corners) for corners in tokens], np.int64)
    index = _face_indices([corner for corners in tokens for corner in corners], np.repeat(numbers, sizes), name)
    points = _table(rows[b"v"], 3, name)
    known = [len(rows[key][0]) for key in (b"v", b"vt", b"vn")]
    absolute = np.empty_like(index)
    for column, key in enumerate((b"v", b"vt", b"vn")):
        before = np.repeat(np.searchsorted(rows[key][0], numbers), sizes)
        relative = index[:, column]
        absolute[:, column] = np.where(relative > 0, relative - 1, np.where(relative < 0, before + relative, -1))
    textured = absolute[:, 1] if known[1] else None
    directed = absolute[:, 2] if known[2] else None
    part, part_names = _materials(rows[b"usemtl"], np.asarray(numbers, np.int64))
    colours = _colours(rows[b"v"], name)
    if colours is not None and part is None:
        part, part_names = np.zeros(len(numbers), np.int64), (NO_MATERIAL,)
    return Polygons(
        points,
        absolute[:, 0],
        sizes,
        _pick(_table(rows[b"vn"], 3, name), directed),
        _pick(_table(rows[b"vt"], 2, name, least=1), textured),
        None if colours is None else _pick(colours, absolute[:, 0]),
        part,
        part_names,
    )


def _colours(rows: Rows, name: str) -> NDArray[np.float64] | None:
    """(rows, 3) linear colours of points that state x y z r g b, NaN for the others; None without any."""
    counts = np.array([len(line.split()) for line in rows[1]])
    stated = np.isin(counts, (6, 7))
    if not stated.any():
        return None
    given = [(number, line.split(maxsplit=3)[3]) for number, line, has in zip(*rows, stated, strict=True) if has]
    found = np.full((len(counts), 3), np.nan)
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


def _obj_rows(content: bytes) -> dict[bytes, Rows]:
    """For each kind of line that matters the numbers of its lines, and what they say."""
    text = content.removeprefix(b"\xef\xbb\xbf").replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\t", b" ")
    rows: dict[bytes, Rows] = {key: ([], []) for key in (b"v", b"vt", b"vn", b"f", b"usemtl")}
    for number, line in enumerate(text.replace(b"\\\n", b" ").split(b"\n"), 1):
        key, _, said = line.lstrip(b" ").partition(b" ")
        if key in rows:
            numbers, lines = rows[key]
            numbers.append(number)
            lines.append(said.partition(b" #")[0] if b"#" in said else said)
    return rows


def _face_indices(corners: list[bytes], line: NDArray[np.int64], name: str) -> NDArray[np.int64]:
    """(C, 3) indices of point, texture coordinate and normal as they are written, 0 where there is none."""
    text = b" ".join(corners)
    slashes = {corner.count(b"/") for corner in corners} if b"/" in text else {0}
    if len(slashes) > 1:
        corners = [corner + b"/0" * (2 - corner.count(b"/")) for corner in corners]
        slashes = {2}
        text = b" ".join(corners)
    columns = 1 + max(slashes, default=0)
    if columns > 3:
        number = next(n for n, corner in zip(line, corners, strict=True) if corner.count(b"/") > 2)
        raise InputError(name, f"is damaged: line {number} gives a corner with too many parts", AGAIN)
    text = (text + b" ").replace(b"//", b"/0/").replace(b"/ ", b"/0 ").replace(b"/", b" ")
    read = _floats(text.split() if columns > 1 else corners, np.repeat(line, columns), name).reshape(-1, columns)
    whole = np.where(np.abs(read) < 2.0**53, read, 0.0).astype(np.int64)
    broken = np.any(np.floor(read) != read, axis=1)
    if broken.any():
        number = line[np.argmax(broken)]
        raise InputError(name, f"is damaged: an index in line {number} is not a whole number", AGAIN)
    return np.pad(whole, ((0, 0), (0, 3 - columns)))


def _pick(table: NDArray[np.float64], index: NDArray[np.int64] | None) -> NDArray[np.float64] | None:
    """Rows of `table`, NaN where the index names none."""
    if index is None:
        return None
    inside = (index >= 0) & (index < len(table))
    return np.where(inside[:, None], table[np.where(inside, index, 0)], np.nan)


def _table(rows: Rows, columns: int, name: str, least: int | None = None) -> NDArray[np.float64]:
    """(rows, columns) the first numbers of each row; a row of at least `least` is filled up with 0."""
    tokens: list[bytes] = []
    for number, line in zip(*rows, strict=True):
        said = line.split()[:columns]
        if len(said) < columns:
            if len(said) < (least or columns):
                raise InputError(name, f"is damaged: {columns} numbers are missing in line {number}", AGAIN)
            said += [b"0"] * (columns - len(said))
        tokens += said
    return _floats(tokens, np.repeat(rows[0], columns), name).reshape(-1, columns)


def _floats(tokens: list[bytes], line: NDArray[np.int64], name: str) -> NDArray[np.float64]:
    """Numbers of tokens; NaN for the several ways to write that, InputError with its line for what is none."""
    fast = numbers_of(b" ".join(tokens))
    if fast is not None and len(fast) == len(tokens):
        return fast
    slow = np.empty(len(tokens))
    for place, token in enumerate(tokens):
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
    corners = [c for (n, line), size in zip(faces, sizes, strict=True) for c in line[1 : 1 + size]]
    index = _face_indices(corners, np.repeat([number for number, _ in faces], sizes), name)[:, 0]
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
