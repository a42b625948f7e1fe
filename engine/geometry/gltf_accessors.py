"""Accessors of glTF as plain arrays, where trimesh reads them wrongly or not at all.

trimesh reads zeros for sparse accessors, whole numbers where they stand for fractions (KHR_mesh_quantization), and no
fans of triangles. Such accessors are decoded here (glTF 2.0, Sec. 3.6.2) and put in a buffer of their own, as 32-bit
floats and plain triangles; a file without scenes gets one of all its root nodes.
"""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.storage.untrusted import AGAIN

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_FLOAT, _UNSIGNED = 5126, 5125

#: Modes of primitives; numbers of components are those of the attributes that are read.
_TRIANGLES, _FAN = 4, 6
_READ = {"POSITION": 3, "NORMAL": 3, "TEXCOORD_0": 2}

#: Most numbers of an accessor, against files that promise more than memory holds.
MAX_NUMBERS = 1 << 29


def plain_tree(tree: dict[str, Any], body: bytes, beside: Mapping[str, bytes], name: str) -> dict[str, Any]:
    """`tree` with what trimesh reads wrongly in plain form; the same where there is nothing of it.

    `body` is the binary chunk of a .glb, `beside` the files that others keep their numbers in. InputError for accessors
    that name bytes which are not there.
    """
    _complete_scenes(tree)
    reader = _Reader(tree, body, beside, name)
    for primitive in (one for mesh in tree.get("meshes", ()) for one in mesh["primitives"]):
        attributes = primitive["attributes"]
        for key in _READ:
            if key in attributes and reader.is_odd(attributes[key]):
                attributes[key] = reader.add(reader.values(attributes[key], _READ[key]), _FLOAT)
        if "indices" in primitive and "sparse" in reader.accessor(primitive["indices"]):
            primitive["indices"] = reader.add(reader.values(primitive["indices"], 1), _UNSIGNED)
        if primitive.get("mode", _TRIANGLES) == _FAN:
            primitive["indices"] = reader.add(_triangles_of(reader, primitive), _UNSIGNED)
            primitive["mode"] = _TRIANGLES
    reader.finish()
    return tree


def _complete_scenes(tree: dict[str, Any]) -> None:
    if tree.get("scenes") or not tree.get("nodes"):
        return
    children = {child for node in tree["nodes"] for child in node.get("children", ())}
    tree["scenes"] = [{"nodes": [at for at in range(len(tree["nodes"])) if at not in children]}]
    tree["scene"] = 0


def _triangles_of(reader: _Reader, primitive: dict[str, Any]) -> NDArray[np.float64]:
    """(3 (N − 2),) indices of the triangles of a fan of N corners."""
    if "indices" in primitive:
        corners = reader.values(primitive["indices"], 1).reshape(-1)
    else:
        corners = np.arange(reader.count(primitive["attributes"]["POSITION"]), dtype=np.float64)
    first = np.broadcast_to(corners[:1], max(len(corners) - 2, 0))
    return np.stack([first, corners[1:-1], corners[2:]], axis=-1).reshape(-1, 1)


class _Reader:
    """Accessors of one file, and those that are added in plain form."""

    def __init__(self, tree: dict[str, Any], body: bytes, beside: Mapping[str, bytes], name: str) -> None:
        self.tree, self.body, self.beside, self.name = tree, body, beside, name
        self.added = bytearray()
        self.decoded: dict[str, bytes] = {}

    def accessor(self, index: int) -> dict[str, Any]:
        found: dict[str, Any] = self.tree["accessors"][index]
        return found

    def is_odd(self, index: int) -> bool:
        accessor = self.accessor(index)
        return "sparse" in accessor or bool(accessor.get("normalized")) or accessor.get("componentType") != _FLOAT

    def count(self, index: int) -> int:
        return int(self.accessor(index)["count"])

    def values(self, index: int, columns: int) -> NDArray[np.float64]:
        """(N, columns) numbers of an accessor."""
        accessor = self.accessor(index)
        count, kind = self.count(index), int(accessor["componentType"])
        if _COLUMNS.get(accessor["type"]) != columns or not 0 <= count * columns <= MAX_NUMBERS:
            raise self._refuse()
        found = np.zeros((count, columns))
        if "bufferView" in accessor:
            found = self._view(accessor["bufferView"], accessor.get("byteOffset", 0), kind, count, columns)
        if (sparse := accessor.get("sparse")) is not None:
            changed = int(sparse["count"])
            at, to = sparse["indices"], sparse["values"]
            rows = self._view(at["bufferView"], at.get("byteOffset", 0), int(at["componentType"]), changed, 1)
            new = self._view(to["bufferView"], to.get("byteOffset", 0), kind, changed, columns)
            rows = rows.reshape(-1).astype(np.int64)
            if changed and not 0 <= rows.min() <= rows.max() < count:
                raise self._refuse()
            found[rows] = new
        if accessor.get("normalized"):
            largest = float(np.iinfo(np.dtype(_TYPES[kind])).max)
            found = np.maximum(found / largest, -1.0)
        return found

    def add(self, values: NDArray[np.float64], kind: int) -> int:
        """The index of a new accessor of `values` (N, columns)."""
        data = np.ascontiguousarray(values, _TYPES[kind]).tobytes()
        views, accessors = self.tree.setdefault("bufferViews", []), self.tree["accessors"]
        buffer = len(self.tree.get("buffers", ()))
        views.append({"buffer": buffer, "byteOffset": len(self.added), "byteLength": len(data)})
        shape = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}[values.shape[1]]
        accessors.append({"bufferView": len(views) - 1, "componentType": kind, "count": len(values), "type": shape})
        self.added += data
        return len(accessors) - 1

    def finish(self) -> None:
        """Put what was added into the tree, as a buffer within it."""
        if self.added:
            uri = "data:application/octet-stream;base64," + base64.b64encode(self.added).decode()
            self.tree.setdefault("buffers", []).append({"byteLength": len(self.added), "uri": uri})

    def _view(self, index: int, offset: int, kind: int, count: int, columns: int) -> NDArray[np.float64]:
        view = self.tree["bufferViews"][index]
        buffer = self.tree["buffers"][view["buffer"]]
        uri = buffer.get("uri")
        if uri is None:
            content = self.body
        elif str(uri).startswith("data:"):
            if str(uri) not in self.decoded:
                self.decoded[str(uri)] = base64.b64decode(str(uri).partition(",")[2])
            content = self.decoded[str(uri)]
        else:
            content = self.beside.get(str(uri), b"")
        dtype = np.dtype(_TYPES[kind])
        row = dtype.itemsize * columns
        stride = int(view.get("byteStride", row)) or row
        start = int(view.get("byteOffset", 0)) + int(offset)
        end = start + (count - 1) * stride + row if count else start
        if not 0 <= start <= end <= len(content) or stride < row:
            raise self._refuse()
        rows = np.lib.stride_tricks.as_strided(
            np.frombuffer(content, np.uint8, end - start, start), (count, row), (stride, 1), writeable=False
        )
        return np.ascontiguousarray(rows).view(dtype).reshape(count, columns).astype(np.float64)

    def _refuse(self) -> InputError:
        return InputError(self.name, "is damaged: an accessor names bytes that are not there", AGAIN)
