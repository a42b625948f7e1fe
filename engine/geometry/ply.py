"""PLY (Turk1994): polygons and triangle strips, as text or in either byte order, with lists of any lengths.

Ours instead of trimesh's, because that cuts polygons as fans, and reads no binary file whose polygons differ in size,
which is what modelling programs write. Colours of vertices are coded as sRGB. Properties that say nothing about the
shape or its colours are passed over.
Cost: as reading the file where all lists of an element are equally long, else 1 µs per list.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.geometry.gltf import NO_MATERIAL
from engine.geometry.obj import linear_colours, numbers_of
from engine.geometry.polygons import Polygons
from engine.storage.untrusted import AGAIN

_KINDS = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}

_TEXTURE = (("u", "v"), ("s", "t"), ("texture_u", "texture_v"), ("texcoord_u", "texcoord_v"))
_COLOURS = (("red", "green", "blue"), ("diffuse_red", "diffuse_green", "diffuse_blue"), ("r", "g", "b"))
_CORNERS = ("vertex_indices", "vertex_index")

#: Most bytes of a header.
HEADER_BYTES = 1 << 16


@dataclass
class _Element:
    """One kind of row: `properties` are name, kind of the value, and for lists kind of the count."""

    name: str
    count: int
    properties: list[tuple[str, np.dtype, np.dtype | None]] = field(default_factory=list)
    values: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    lengths: dict[str, NDArray[np.int64]] = field(default_factory=dict)


def read_ply(content: bytes, name: str) -> Polygons:
    """The polygons of a PLY file; InputError for one that is cut, or whose header says what cannot be."""
    try:
        elements, is_text, start = _header(content)
        body = numbers_of(content[start:]) if is_text else np.frombuffer(content, np.uint8, offset=start)
        if body is None:
            raise ValueError("something among its numbers is none")
        end = 0
        for element in elements.values():
            end = _read(element, body, end, is_text)
        if end < len(body):
            raise ValueError(f"{len(body) - end} {'numbers' if is_text else 'bytes'} too many follow")
        return _polygons(elements)
    except (LookupError, ValueError) as error:
        raise InputError(name, f"is damaged or of an unknown kind ({error})", AGAIN) from None


def _header(content: bytes) -> tuple[dict[str, _Element], bool, int]:
    """The elements by name, whether the body is text, and where it begins."""
    end = content.find(b"end_header", 0, HEADER_BYTES)
    if not content.startswith(b"ply") or end < 0:
        raise ValueError("it has no PLY header")
    lines = content[:end].decode("latin-1").splitlines()
    kind = next((line.split()[1] for line in lines if line.split()[:1] == ["format"] and len(line.split()) > 1), "")
    if kind not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"its format is {kind[:40]!r}")
    order = ">" if "big" in kind else "<"
    elements: dict[str, _Element] = {}
    current = _Element("", 0)
    for line in lines:
        match line.split():
            case ["element", name, count] if count.isascii() and count.isdigit():
                if name in elements or len(count) > 12:
                    raise ValueError(f"its element {name[:40]} is there twice, or too often")
                elements[name] = current = _Element(name, int(count))
            case ["property", "list", length, value, name]:
                current.properties.append((name, _kind(value, order), _kind(length, order)))
            case ["property", value, name]:
                current.properties.append((name, _kind(value, order), None))
            case ["element" | "property", *_]:
                raise ValueError(f"its header says {line[:60]!r}")
    after = content.find(b"\n", end, end + 64)
    alone = content.find(b"\r", end, end + 64)
    if after < 0 and alone < 0:
        raise ValueError("its header does not end")
    return elements, kind == "ascii", (after if after >= 0 else alone) + 1


def _kind(word: str, order: str) -> np.dtype:
    if word not in _KINDS:
        raise ValueError(f"a property is of the unknown kind {word[:40]!r}")
    return np.dtype(order + _KINDS[word])


def _read(element: _Element, body: NDArray, start: int, is_text: bool) -> int:
    """Fill in the values of an element whose rows begin at `start` of the body; where they end.

    The body is numbers or bytes; each value takes one place of the one, its size of the other.
    """
    least = sum(_places(length or value, is_text) for _, value, length in element.properties)
    if element.count * max(least, 1) > len(body) - start and element.count and least:
        raise ValueError(f"{element.count} of {element.name[:40]} are announced, and the file ends before")
    if not any(length for *_, length in element.properties):
        return _read_even(element, body, start, [1] * len(element.properties), is_text)
    if element.count == 0:
        return start
    lengths = _first_lengths(element, body, start, is_text)
    try:
        return _read_even(element, body, start, lengths, is_text)
    except ValueError:
        return _read_uneven(element, body, start, is_text)


def _places(kind: np.dtype, is_text: bool) -> int:
    return 1 if is_text else kind.itemsize


def _one(body: NDArray, at: int, kind: np.dtype, is_text: bool) -> int:
    """A length of a list."""
    if at + _places(kind, is_text) > len(body):
        raise ValueError("the file ends within a list")
    value = body[at] if is_text else body[at : at + kind.itemsize].view(kind)[0]
    if not 0 <= value <= len(body) or value != int(value):
        raise ValueError(f"a list is {value} long")
    return int(value)


def _first_lengths(element: _Element, body: NDArray, start: int, is_text: bool) -> list[int]:
    lengths = []
    for _, value, length in element.properties:
        count = _one(body, start, length, is_text) if length else 1
        lengths.append(count)
        start += (_places(length, is_text) if length else 0) + count * _places(value, is_text)
    return lengths


def _read_even(element: _Element, body: NDArray, start: int, lengths: list[int], is_text: bool) -> int:
    """Rows whose lists are as long as those of the first row; ValueError where one is not."""
    widths = [
        (_places(length, is_text) if length else 0) + (count if length else 1) * _places(value, is_text)
        for (_, value, length), count in zip(element.properties, lengths, strict=True)
    ]
    end = start + sum(widths) * element.count
    if end > len(body):
        raise ValueError(f"the file ends among its {element.name[:40]}")
    rows = body[start:end].reshape(element.count, sum(widths))
    column = 0
    for (name, value, length), count, width in zip(element.properties, lengths, widths, strict=True):
        cells = rows[:, column : column + width]
        column += width
        if length:
            head = _places(length, is_text)
            if (_values(cells[:, :head], length, is_text) != count).any():
                raise ValueError("lists differ in length")
            element.lengths[name] = np.full(element.count, count)
            cells = cells[:, head:]
        element.values[name] = _values(cells, value, is_text).reshape(-1)
    return end


def _values(cells: NDArray, kind: np.dtype, is_text: bool) -> NDArray[np.float64]:
    if is_text:
        return cells.astype(np.float64)
    return np.ascontiguousarray(cells).view(kind).astype(np.float64)


def _read_uneven(element: _Element, body: NDArray, start: int, is_text: bool) -> int:
    """Rows with lists of any length, one after the other."""
    places: dict[str, list[int]] = {name: [] for name, *_ in element.properties}
    counts: dict[str, list[int]] = {name: [] for name, *_ in element.properties}
    for _ in range(element.count):
        for name, value, length in element.properties:
            count = 1
            if length:
                count = _one(body, start, length, is_text)
                start += _places(length, is_text)
            places[name].append(start)
            counts[name].append(count)
            start += count * _places(value, is_text)
            if start > len(body):
                raise ValueError(f"the file ends among its {element.name[:40]}")
    for name, value, length in element.properties:
        sizes = np.array(counts[name])
        steps = np.arange(sizes.sum()) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        at = np.repeat(places[name], sizes) + steps * _places(value, is_text)
        cells = body[at][:, None] if is_text else body[at[:, None] + np.arange(value.itemsize)]
        element.values[name] = _values(cells, value, is_text).reshape(-1)
        if length:
            element.lengths[name] = sizes
    return start


def _polygons(elements: dict[str, _Element]) -> Polygons:
    vertex = elements["vertex"].values if "vertex" in elements else {}
    if not {"x", "y", "z"} <= set(vertex):
        raise ValueError("its vertices have no positions")
    points = np.stack([vertex[axis] for axis in "xyz"], axis=-1)
    if "face" in elements and elements["face"].count:
        corners, sizes = _corners(elements["face"])
    elif "tristrips" in elements and elements["tristrips"].count:
        corners, sizes = _triangulate_strips(*_corners(elements["tristrips"]))
    else:
        corners, sizes = np.empty(0, np.int64), np.empty(0, np.int64)
    at = np.where((corners >= 0) & (corners < len(points)), corners, 0)
    normals = np.stack([vertex[axis] for axis in ("nx", "ny", "nz")], -1) if {"nx", "ny", "nz"} <= set(vertex) else None
    colours = _colours(elements["vertex"])
    return Polygons(
        points,
        corners,
        sizes,
        None if normals is None else normals[at],
        _texture(elements, vertex, at),
        None if colours is None else colours[at],
        None if colours is None else np.zeros(len(sizes), np.int64),
        () if colours is None else (NO_MATERIAL,),
    )


def has_colours(head: bytes) -> bool:
    """True for a PLY file, by its header, whose vertices have colours."""
    end = head.find(b"end_header")
    lines = [line.split() for line in head[: max(end, 0)].splitlines()]
    names = {line[2].decode("latin-1") for line in lines if line[:1] == [b"property"] and len(line) == 3}
    return head.startswith(b"ply") and any(names.issuperset(each) for each in _COLOURS)


def _colours(vertex: _Element) -> NDArray[np.float64] | None:
    """(V, 3) linear colours; None without any."""
    names = next((each for each in _COLOURS if set(each) <= set(vertex.values)), None)
    if names is None:
        return None
    kind = next(kind for name, kind, _ in vertex.properties if name == names[0])
    largest = float(np.iinfo(kind).max) if kind.kind in "iu" else 1.0
    return linear_colours(np.stack([vertex.values[name] for name in names], axis=-1) / largest)


def _corners(element: _Element) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices of the corners and how many each polygon has."""
    lists = list(element.lengths)
    name = next((name for name in _CORNERS if name in lists), lists[0] if len(lists) == 1 else None)
    if name is None:
        raise ValueError("its faces name no vertices")
    values = element.values[name]
    usable = np.isfinite(values) & (np.abs(values) < 2.0**53)
    return np.where(usable, values, -1.0).astype(np.int64), element.lengths[name]


def _triangulate_strips(
    corners: NDArray[np.int64], sizes: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles of strips, which end where a list does or at an index of −1; every other one is turned round."""
    strip = np.repeat(np.arange(len(sizes)), sizes) + np.cumsum(corners < 0)
    windows = np.lib.stride_tricks.sliding_window_view(corners, 3) if len(corners) > 2 else np.empty((0, 3), np.int64)
    starts = np.concatenate([[True], (np.diff(strip) != 0)]) if len(strip) else np.empty(0, bool)
    first = np.maximum.accumulate(np.where(starts, np.arange(len(strip)), 0)) + (corners < 0)
    first = np.maximum.accumulate(first)
    whole = (windows >= 0).all(axis=1) & (strip[: len(windows)] == strip[2:])
    odd = (np.arange(len(windows)) - first[: len(windows)]) % 2 == 1
    triangles = np.where(odd[:, None], windows[:, [1, 0, 2]], windows)[whole]
    return triangles.reshape(-1), np.full(len(triangles), 3)


def _texture(
    elements: dict[str, _Element], vertex: dict[str, NDArray[np.float64]], at: NDArray[np.int64]
) -> NDArray[np.float64] | None:
    """Texture coordinates of the corners: stated by the faces, or by the vertices under one of several names."""
    face = elements.get("face")
    if face is not None and "texcoord" in face.lengths:
        stated = face.values["texcoord"]
        _, sizes = _corners(face)
        return stated.reshape(-1, 2) if np.array_equal(face.lengths["texcoord"], 2 * sizes) else None
    for u, v in _TEXTURE:
        if u in vertex and v in vertex:
            return np.stack([vertex[u], vertex[v]], -1)[at]
    return None
