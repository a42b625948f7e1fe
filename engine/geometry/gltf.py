"""Meshes of glTF 2.0 files (.glb, .gltf): every primitive wherever nodes place it, and the material of each by name.

Read are triangles, strips and fans (Sec. 3.7.2.1), accessors as floats, as whole numbers that stand for fractions
(KHR_mesh_quantization), sparse ones (Sec. 3.6.2) and, by the library DracoPy, compressed ones
(KHR_draco_mesh_compression), and instances (EXT_mesh_gpu_instancing). Colours of vertices are
linear and multiply the base colour (Sec. 3.9.2). A file without scenes shows all its root nodes. Texture coordinates
are those that the textures of a material share, transformed as they say (KHR_texture_transform); where textures differ
in that, those of the first hold, and `engine.exchange.readers.gltf` says so.
Ours instead of trimesh's, which reads zeros for sparse accessors, whole numbers for fractions, and no instances.
"""

from __future__ import annotations

import base64
import importlib.util
import itertools
import json
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.storage import readers
from engine.storage.untrusted import AGAIN

Array = NDArray[np.float64]

_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}

#: Modes of primitives that hold triangles.
_TRIANGLES, _STRIP, _FAN = 4, 5, 6

#: Most numbers of an accessor, against files that promise more than memory holds.
MAX_NUMBERS = 1 << 29

#: Nodes of a file, and levels of nodes within nodes.
MAX_NODES, MAX_NODE_LEVELS = 100_000, 100

#: Compression of primitives, which the library DracoPy reads where it is installed.
_DRACO = "KHR_draco_mesh_compression"

#: Name of the material of primitives that state none (Sec. 3.9.1), which is white metal.
NO_MATERIAL = "no material"

#: Keys of textures within a material, the base colour first.
_TEXTURES = ("baseColorTexture", "metallicRoughnessTexture", "normalTexture", "occlusionTexture")


class TexturePlace(NamedTuple):
    """Texture coordinates of a texture: the number of the set, offset, rotation in radians and scale.

    A point uv (v down) is looked up at offset + R(rotation) (scale uv) (KHR_texture_transform).
    """

    number: int = 0
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)

    @property
    def is_plain(self) -> bool:
        return self[1:] == TexturePlace()[1:]

    def transform(self, uv: Array) -> Array:
        """Coordinates (N, 2), v down, of the texture."""
        if self.is_plain:
            return uv
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        return np.asarray((uv * self.scale) @ np.array([[c, -s], [s, c]]) + self.offset)


def material_names(tree: Mapping[str, Any]) -> list[str]:
    """A name for each material of a file, no two alike."""
    names: list[str] = []
    for number, material in enumerate(tree.get("materials", ()), 1):
        stated = material.get("name") if isinstance(material, dict) else None
        name = stated[:60] if isinstance(stated, str) and stated else f"material {number}"
        while name in names or name == NO_MATERIAL:
            name += " 2"
        names.append(name)
    return names


def texture_places(material: Mapping[str, Any]) -> list[TexturePlace]:
    """Places of all textures of a material in the order of their importance; those that differ, once each."""
    pbr = _dict(material, "pbrMetallicRoughness")
    extensions = _dict(material, "extensions")
    owners = [pbr, material, *(each for each in extensions.values() if isinstance(each, dict))]
    found = [owner[key] for key in _TEXTURES for owner in owners if key in owner]
    known = {id(each) for each in found}
    textures = (value for owner in owners for key, value in owner.items() if key.endswith("Texture"))
    found += [each for each in textures if id(each) not in known]
    return list(dict.fromkeys(_place_of(each) for each in found if isinstance(each, dict)))


def _place_of(texture: Mapping[str, Any]) -> TexturePlace:
    extension = _dict(_dict(texture, "extensions"), "KHR_texture_transform")
    number = extension.get("texCoord", texture.get("texCoord", 0))
    offset, scale = (extension.get(key, usual) for key, usual in (("offset", (0, 0)), ("scale", (1, 1))))
    values = np.array([*offset, extension.get("rotation", 0), *scale], np.float64)
    if values.shape != (5,) or not np.isfinite(values).all() or not 0 <= int(number) < 16:
        raise ValueError("a transform of a texture is impossible")
    x, y, rotation, along, down = values.tolist()
    return TexturePlace(int(number), (x, y), rotation, (along, down))


def read_gltf(content: bytes, name: str, beside: Mapping[str, bytes] = MappingProxyType({})) -> list[dict[str, Any]]:
    """The primitives of the scene in the world: `positions`, `faces`, tables `normals`, `uv` (v up) and `colours` of
    the vertices or None, and the name of the `material`, None where no primitive has one or is coloured.

    `beside` holds the other files that it keeps its numbers in.
    """
    tree, body = _open(content, name)
    _refuse_deep_nodes(tree, name)
    _refuse_compression(tree, name)
    accessors = _Accessors(tree, body, beside, name)
    shapes: dict[int, list[dict[str, Any]]] = {}
    parts = []
    for node, world_from_node in _walk_nodes(tree):
        if node["mesh"] not in shapes:
            primitives = tree["meshes"][node["mesh"]]["primitives"]
            shapes[node["mesh"]] = [_read_primitive(tree, accessors, each) for each in primitives if _has_faces(each)]
        for node_from_part in _instances(node, accessors):
            parts += [place_part(shape, world_from_node @ node_from_part) for shape in shapes[node["mesh"]]]
    if not has_materials(tree):
        for part in parts:
            part["material"] = None
    return parts


def _refuse_compression(tree: Mapping[str, Any], name: str) -> None:
    """InputError for a file whose numbers are compressed in a way that is not read here."""
    required = tree.get("extensionsRequired", ())
    if "EXT_meshopt_compression" in required:
        remedy = "Export it without that: gltfpack without -c, or gltf-transform copy"
        raise InputError(name, "uses meshopt compression, which is not read", remedy)
    if _DRACO in required and importlib.util.find_spec("DracoPy") is None:
        remedy = "Install the extra draco: pip install 'lightarc[draco]', or export it without that"
        raise InputError(name, "uses Draco compression, for which the library DracoPy is not installed", remedy)


def has_materials(tree: Mapping[str, Any]) -> bool:
    """True if a primitive of the file has a material, or colours of vertices."""
    primitives = [each for mesh in tree.get("meshes", ()) for each in mesh["primitives"]]
    return any("material" in each or "COLOR_0" in each["attributes"] for each in primitives)


def _open(content: bytes, name: str) -> tuple[dict[str, Any], bytes]:
    """The tree and the binary chunk."""
    body = b""
    if content.startswith(b"glTF"):
        end = 20 + int.from_bytes(content[12:16], "little")
        content, body = content[20:end], content[end + 8 :]
    tree = json.loads(content.decode("utf-8-sig"))
    if not str(tree["asset"]["version"]).startswith("2"):
        raise InputError(name, f"is glTF {tree['asset']['version']}; only GLTF 2 is read", "Export it as glTF 2.0")
    return tree, body


def _refuse_deep_nodes(tree: dict[str, Any], name: str) -> None:
    """Bound the nodes and their levels, in time linear in the file; InputError beyond, and for nodes in a circle."""
    nodes = tree.get("nodes", ())
    if len(nodes) > MAX_NODES:
        raise InputError(
            name, f"has {len(nodes):,} nodes, more than {MAX_NODES:,}", "Join its parts and export it again"
        )
    children = [[int(child) for child in node.get("children", ())] for node in nodes]
    parents = [0] * len(nodes)
    for child in itertools.chain.from_iterable(children):
        if not 0 <= child < len(nodes):
            raise InputError(name, f"is damaged: a node names node {child}, which is not there", AGAIN)
        parents[child] += 1
    level, reached = [at for at, count in enumerate(parents) if not count], 0
    for _ in range(MAX_NODE_LEVELS):
        reached += len(level)
        below = []
        for child in itertools.chain.from_iterable(children[at] for at in level):
            parents[child] -= 1
            if not parents[child]:
                below.append(child)
        level = below
    if level:
        problem = f"has nodes within nodes over more than {MAX_NODE_LEVELS} levels"
        raise InputError(name, problem, "Apply the transforms of its groups and export it again")
    if reached < len(nodes):
        raise InputError(name, "is damaged: its nodes lie within each other in a circle", AGAIN)


def _walk_nodes(tree: dict[str, Any]) -> Iterator[tuple[dict[str, Any], Array]]:
    """The nodes with meshes of the scene that is shown, each with its matrix (4, 4) to the world."""
    nodes = tree.get("nodes", ())
    children = {child for node in nodes for child in node.get("children", ())}
    roots = [at for at in range(len(nodes)) if at not in children]
    if tree.get("scenes"):
        roots = tree["scenes"][tree.get("scene", 0)].get("nodes", ())
    waiting = [(at, np.eye(4)) for at in reversed(roots)]
    while waiting:
        at, above = waiting.pop()
        if not 0 <= at < len(nodes):
            raise IndexError(at)
        with np.errstate(over="ignore", invalid="ignore"):
            world_from_node = above @ _matrix(nodes[at])
        if "mesh" in nodes[at]:
            yield nodes[at], world_from_node
        waiting += [(child, world_from_node) for child in reversed(nodes[at].get("children", ()))]


def _matrix(node: Mapping[str, Any]) -> Array:
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    stated = (node.get("translation", (0, 0, 0)), node.get("rotation", (0, 0, 0, 1)), node.get("scale", (1, 1, 1)))
    return _matrices(*(np.array([each], np.float64) for each in stated))[0]


def _matrices(translation: Array, rotation: Array, scale: Array) -> Array:
    """(N, 4, 4) of translations (N, 3), quaternions x, y, z, w (N, 4), and scales (N, 3)."""
    length = np.linalg.norm(rotation, axis=1, keepdims=True)
    x, y, z, w = (rotation / np.where(length > 0.0, length, 1.0)).T
    found = np.zeros((len(translation), 4, 4))
    found[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], 1)
    found[:, 1, :3] = np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], 1)
    found[:, 2, :3] = np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], 1)
    found[:, :3, :3] *= scale[:, None]
    found[:, :3, 3], found[:, 3, 3] = translation, 1.0
    return found


def _instances(node: Mapping[str, Any], accessors: _Accessors) -> Array:
    """(N, 4, 4) where the mesh of a node stands within it (EXT_mesh_gpu_instancing)."""
    attributes = _dict(_dict(_dict(node, "extensions"), "EXT_mesh_gpu_instancing"), "attributes")
    known = {key: attributes[key] for key in ("TRANSLATION", "ROTATION", "SCALE") if key in attributes}
    if not known:
        return np.eye(4)[None]
    usual: dict[str, tuple[float, ...]] = {"TRANSLATION": (0, 0, 0), "ROTATION": (0, 0, 0, 1), "SCALE": (1, 1, 1)}
    count = min(accessors.count(each) for each in known.values())
    tables = [
        accessors.values(known[key], len(each))[:count]
        if key in known
        else np.tile(np.array(each, np.float64), (count, 1))
        for key, each in usual.items()
    ]
    return _matrices(*tables)


def _has_faces(primitive: Mapping[str, Any]) -> bool:
    return "POSITION" in primitive["attributes"] and primitive.get("mode", _TRIANGLES) in (_TRIANGLES, _STRIP, _FAN)


def _read_primitive(tree: Mapping[str, Any], accessors: _Accessors, primitive: Mapping[str, Any]) -> dict[str, Any]:
    """A primitive in its own coordinates."""
    attributes, number = primitive["attributes"], primitive.get("material")
    names = material_names(tree)
    if number is not None and not 0 <= number < len(names):
        raise IndexError(number)
    places = [] if number is None else texture_places(tree["materials"][number])
    place = places[0] if places else TexturePlace()
    corners = accessors.unpack(primitive)
    positions = accessors.values(attributes["POSITION"], 3)
    uv = accessors.table(attributes.get(f"TEXCOORD_{place.number}"), 2, len(positions))
    return {
        "positions": positions,
        "faces": _faces(accessors, primitive, len(positions), corners),
        "normals": accessors.table(attributes.get("NORMAL"), 3, len(positions)),
        "uv": None if uv is None else place.transform(uv) * (1.0, -1.0) + (0.0, 1.0),
        "colours": accessors.colours(attributes.get("COLOR_0"), len(positions)),
        "material": NO_MATERIAL if number is None else names[number],
    }


def _faces(
    accessors: _Accessors, primitive: Mapping[str, Any], count: int, corners: NDArray[np.int64] | None
) -> NDArray[np.int64]:
    """(F, 3) indices of vertices, −1 for those that are not there; `corners` are those that were compressed."""
    if corners is not None:
        return np.where((corners >= 0) & (corners < count), corners, -1).reshape(-1, 3)
    if "indices" in primitive:
        corners = accessors.values(primitive["indices"], 1).reshape(-1).astype(np.int64)
    else:
        corners = np.arange(count)
    mode = primitive.get("mode", _TRIANGLES)
    if mode == _STRIP:  # every other triangle is turned, so that all are alike
        first = np.arange(max(len(corners) - 2, 0))
        odd = first % 2
        faces = np.stack([corners[first], corners[first + 1 + odd], corners[first + 2 - odd]], axis=-1)
    elif mode == _FAN:
        ends = corners[2:]
        faces = np.stack([np.broadcast_to(corners[:1], ends.shape), corners[1:-1], ends], axis=-1)
    else:
        faces = corners[: len(corners) // 3 * 3].reshape(-1, 3)
    return np.where((faces >= 0) & (faces < count), faces, -1)


def place_part(shape: dict[str, Any], world_from_part: Array) -> dict[str, Any]:
    """A primitive in the world."""
    linear = world_from_part[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        positions = shape["positions"] @ linear.T + world_from_part[:3, 3]
        turned = np.linalg.det(linear) < 0.0
        normals = None if shape["normals"] is None else shape["normals"] @ _adjugate(linear)
    faces = shape["faces"][:, ::-1] if turned else shape["faces"]
    return {**shape, "positions": positions, "normals": normals, "faces": faces}


def _adjugate(linear: Array) -> Array:
    """The inverse of (3, 3) times its determinant without its sign, which matrices without an inverse have as well."""
    x, y, z = linear.T
    rows = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)])
    return rows * (-1.0 if np.linalg.det(linear) < 0.0 else 1.0)


class _Accessors:
    """Accessors of one file as arrays of floats."""

    def __init__(self, tree: dict[str, Any], body: bytes, beside: Mapping[str, bytes], name: str) -> None:
        self.tree, self.body, self.beside, self.name = tree, body, beside, name
        self._decoded: dict[str, bytes] = {}
        self._unpacked: dict[int, Array] = {}

    def _accessor(self, index: int) -> dict[str, Any]:
        if index < 0:
            raise IndexError(index)
        found: dict[str, Any] = self.tree["accessors"][index]
        return found

    def count(self, index: int) -> int:
        return int(self._accessor(index)["count"])

    def table(self, index: int | None, columns: int, count: int) -> Array | None:
        """(count, columns) numbers of the vertices; None where there are none, or not as many."""
        if index is None or self.count(index) != count:
            return None
        return self.values(index, columns)

    def colours(self, index: int | None, count: int) -> Array | None:
        """(count, 3) linear colours in [0, 1] of the vertices, without their opacity."""
        if index is None:
            return None
        columns = 4 if self._accessor(index)["type"] == "VEC4" else 3
        found = self.table(index, columns, count)
        return None if found is None else np.clip(np.nan_to_num(found[:, :3], nan=1.0), 0.0, 1.0)

    def unpack(self, primitive: Mapping[str, Any]) -> NDArray[np.int64] | None:
        """The corners of the triangles of a primitive that Draco compressed, whose accessors get their numbers.

        None for others. Vertices have another order there than in what the accessors hold, if anything.
        """
        packed = _dict(_dict(primitive, "extensions"), _DRACO)
        if not packed or importlib.util.find_spec("DracoPy") is None:
            return None
        attributes = primitive["attributes"]
        most = max(self.count(index) for index in (*attributes.values(), primitive["indices"]))
        if not 0 <= most <= MAX_NUMBERS // 4:
            raise self._refuse()
        view = self.tree["bufferViews"][packed["bufferView"]]
        content, start = self._content(self.tree["buffers"][view["buffer"]].get("uri")), int(view.get("byteOffset", 0))
        if not 0 <= start <= start + int(view["byteLength"]) <= len(content):
            raise self._refuse()
        mesh = readers.load("DracoPy:decode")(content[start : start + int(view["byteLength"])])
        for key, number in _dict(packed, "attributes").items():
            found = mesh.get_attribute_by_unique_id(int(number))
            accessor = self._accessor(attributes[key])
            values = np.array(found["data"], np.float64).reshape(-1, _COLUMNS[accessor["type"]])
            if len(values) != self.count(attributes[key]) or len(mesh.faces) * 3 > self.count(primitive["indices"]):
                raise InputError(self.name, "is damaged: its compressed numbers are not as many as it says", AGAIN)
            self._unpacked[attributes[key]] = values
        return np.asarray(mesh.faces, np.int64).reshape(-1)

    def values(self, index: int, columns: int) -> Array:
        """(N, columns) numbers of an accessor."""
        accessor = self._accessor(index)
        if index in self._unpacked:
            if self._unpacked[index].shape[1] != columns:
                raise self._refuse()
            return self._to_fractions(accessor, self._unpacked[index])
        count, kind = self.count(index), int(accessor["componentType"])
        if _COLUMNS.get(accessor["type"]) != columns or not 0 <= count * columns <= MAX_NUMBERS:
            raise self._refuse()
        sparse = accessor.get("sparse")
        if "bufferView" in accessor:
            found = self._view(accessor["bufferView"], accessor.get("byteOffset", 0), kind, count, columns)
        elif sparse is None:
            raise InputError(self.name, "is damaged: an accessor has no data", AGAIN)
        else:
            found = np.zeros((count, columns))
        if sparse is not None:
            changed = int(sparse["count"])
            at, to = sparse["indices"], sparse["values"]
            rows = self._view(at["bufferView"], at.get("byteOffset", 0), int(at["componentType"]), changed, 1)
            new = self._view(to["bufferView"], to.get("byteOffset", 0), kind, changed, columns)
            rows = rows.reshape(-1).astype(np.int64)
            if changed and not 0 <= rows.min() <= rows.max() < count:
                raise self._refuse()
            found[rows] = new
        return self._to_fractions(accessor, found)

    def _to_fractions(self, accessor: Mapping[str, Any], found: Array) -> Array:
        """Numbers of an accessor, whole ones that stand for fractions as these."""
        if not accessor.get("normalized"):
            return found
        largest = float(np.iinfo(np.dtype(_TYPES[int(accessor["componentType"])])).max)
        return np.maximum(found / largest, -1.0)

    def _view(self, index: int, offset: int, kind: int, count: int, columns: int) -> Array:
        view = self.tree["bufferViews"][index]
        content = self._content(self.tree["buffers"][view["buffer"]].get("uri"))
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

    def _content(self, uri: object) -> bytes:
        if uri is None:
            return self.body
        named = str(uri)
        if not named.startswith("data:"):
            if named not in self.beside:
                raise InputError(self.name, f"keeps its data elsewhere ({named[:60]!r})", "Export it as .glb")
            return self.beside[named]
        if named not in self._decoded:
            self._decoded[named] = base64.b64decode(named.partition(",")[2])
        return self._decoded[named]

    def _refuse(self) -> InputError:
        return InputError(self.name, "is damaged: an accessor names bytes that are not there", AGAIN)


def _dict(owner: Mapping[str, Any], key: str) -> dict[str, Any]:
    value = owner.get(key)
    return value if isinstance(value, dict) else {}
