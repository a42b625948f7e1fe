"""STL and glTF: what trimesh finds in them, and words for what it would pass over in silence.

A glTF file may keep its numbers in other files. The parent hands those to the decoder that lie beside or below it, and
no others.

The memory of a mesh is estimated from the first bytes of its file and its size.

Cost: one read of a few kilobytes.
"""

from __future__ import annotations

import io
import itertools
import json
import os
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

import numpy as np
import psutil
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.geometry.gltf_accessors import plain_tree
from engine.geometry.mesh_text import off_counts, ply_counts
from engine.storage.text import utf8
from engine.storage.untrusted import AGAIN, DECODER_MEMORY_BYTES, FILE_LIMIT_BYTES, GIBIBYTE, open_checked, read_head

if TYPE_CHECKING:
    import trimesh

#: The name under which trimesh keeps texture coordinates also of parts that have no material.
_UV = "_UV"

#: Extensions of glTF without which its numbers mean nothing, and what to ask of the program that writes it.
_PACKED = {
    "KHR_draco_mesh_compression": "Draco compression",
    "EXT_meshopt_compression": "meshopt compression",
    "EXT_mesh_gpu_instancing": "instances on the graphics device",
}

#: Nodes of a glTF file, and levels of nodes within nodes: trimesh's time grows with the product of both.
MAX_NODES, MAX_NODE_LEVELS = 100_000, 100

#: Most files that a glTF file may name.
_MAX_FILES = 200


def list_named_files(content: bytes) -> list[str]:
    """The files that a glTF file keeps its numbers in, as it names them."""
    tree = json.loads(content)  # in any of the Unicode codings
    uris = [buffer["uri"] for buffer in tree.get("buffers", ()) if "uri" in buffer]
    return [str(uri) for uri in uris if not str(uri).startswith("data:")]


def files_beside(path: str | os.PathLike[str], uris: Sequence[str]) -> dict[str, Path]:
    """The files that the glTF file `path` names, by what it calls them; InputError for one outside its folder."""
    folder = Path(path).absolute().parent
    if len(uris) > _MAX_FILES:
        raise InputError(path, f"keeps its data in {len(uris)} files", "Export it as .glb")
    found = {}
    for uri in uris:
        if uri.startswith(("http:", "https:", "file:")):
            raise InputError(path, f"keeps its data elsewhere ({uri[:60]!r})", "Export it as .glb")
        try:
            beside = folder / unquote(uri)
            if not beside.resolve().is_relative_to(folder.resolve()):
                raise InputError(path, f"names a file outside its folder ({uri[:60]!r})", "Export it as .glb")
            with open_checked(beside, FILE_LIMIT_BYTES):
                found[uri] = beside
        except ValueError as error:
            raise InputError(path, f"names an impossible file ({error})", "Export it as .glb") from None
        except InputError as error:
            if error.path == os.fspath(path):
                raise
            problem = f"needs the file {uri[:60]!r} beside it, which {error.problem}"
            raise InputError(path, problem, "Copy that as well, or export it as .glb") from None
    return found


class _Beside:
    """The files that a glTF file names; trimesh asks for them by their names."""

    def __init__(self, contents: Mapping[str, bytes], name: str) -> None:
        self._contents = contents
        self._name = name

    def __getitem__(self, uri: str) -> bytes:
        if uri not in self._contents:
            raise InputError(self._name, f"keeps its data elsewhere ({uri[:60]!r})", "Export it as .glb")
        return self._contents[uri]

    get = __getitem__


def scene_parts(content: bytes, name: str, beside: Mapping[str, bytes] = MappingProxyType({})) -> list[dict[str, Any]]:
    """Positions, faces, and normals and texture coordinates of corners, of each mesh wherever it is placed."""
    kind = Path(name).suffix.lower().lstrip(".")
    if kind in ("glb", "gltf"):
        content = _reduce(content, kind, name, beside)
    scene = _scene(content, kind, name, beside)
    placed = [scene.graph.get(node) for node in scene.graph.nodes_geometry]
    return [_part(scene.geometry[mesh], world_from_part) for world_from_part, mesh in placed]


def _scene(content: bytes, kind: str, name: str, beside: Mapping[str, bytes]) -> Any:
    """Scene that trimesh reads, if it could read all of it."""
    import trimesh

    options = {"resolver": _Beside(beside, name)} if kind in ("glb", "gltf") else {}
    with warnings.catch_warnings():
        # numpy stops at the first thing that is not a number, and trimesh goes on with what came before it
        warnings.filterwarnings("error", message=".*could not be read to its end", category=DeprecationWarning)
        try:
            return trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False, **options)
        except (DeprecationWarning, ImportError, NameError, NotImplementedError, AssertionError) as error:
            raise InputError(name, f"is damaged or of an unknown kind ({error})", AGAIN) from None


def _reduce(content: bytes, kind: str, name: str, beside: Mapping[str, bytes]) -> bytes:
    """A glTF file in plain form, without materials and images, with texture coordinates where trimesh keeps them."""
    end = 20 + int.from_bytes(content[12:16], "little")
    text = content[20:end] if kind == "glb" else content
    tree = json.loads(text.decode("utf-8-sig"))
    _refuse_deep_nodes(tree, name)
    _refuse_what_is_passed_over(tree, name)
    plain_tree(tree, content[end + 8 :] if kind == "glb" else b"", beside, name)
    for part in (one for mesh in tree.get("meshes", ()) for one in mesh["primitives"]):
        part.pop("material", None)
        part["attributes"] = {
            _UV if key == "TEXCOORD_0" else key: index
            for key, index in part["attributes"].items()
            if key in ("POSITION", "NORMAL", "TEXCOORD_0")
        }
    for unused in ("materials", "textures", "images", "samplers", "animations", "skins"):
        tree.pop(unused, None)
    text = json.dumps(tree).encode()
    if kind == "gltf":
        return text
    text += b" " * (-len(text) % 4)
    length = 20 + len(text) + len(content) - end
    return (
        content[:8]
        + length.to_bytes(4, "little")
        + len(text).to_bytes(4, "little")
        + content[16:20]
        + text
        + content[end:]
    )


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


def _refuse_what_is_passed_over(tree: dict[str, Any], name: str) -> None:
    """Packed parts, and accessors without numbers, for which trimesh takes zeros."""
    for extension in tree.get("extensionsRequired", ()):
        if extension in _PACKED:
            raise InputError(name, f"uses {_PACKED[extension]}, which is not read", "Export it without that")
    accessors = tree.get("accessors", ())
    for primitive in (one for mesh in tree.get("meshes", ()) for one in mesh["primitives"]):
        attributes = primitive["attributes"]
        used = [attributes[key] for key in ("POSITION", "NORMAL", "TEXCOORD_0") if key in attributes]
        used += [primitive["indices"]] if "indices" in primitive else []
        for accessor in [accessors[index] for index in used]:
            if "bufferView" not in accessor and "sparse" not in accessor:
                raise InputError(name, "is damaged: an accessor has no data", AGAIN)


def _part(geometry: trimesh.Trimesh, world_from_part: NDArray[np.float64]) -> dict[str, Any]:
    """One geometry of a scene in the world.

    trimesh's own concatenation would do, but copies materials, and for that it wants an image library.
    """
    if not hasattr(geometry, "faces"):
        return {"faces": np.empty((0, 3), np.int64), "positions": np.empty((0, 3)), "normals": None, "uv": None}
    linear = world_from_part[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        positions = np.asarray(geometry.vertices, np.float64) @ linear.T + world_from_part[:3, 3]
    faces = np.asarray(geometry.faces, np.int64).reshape(-1, 3)
    if np.linalg.det(linear) < 0.0:
        faces = faces[:, ::-1]
    inside = np.where((faces >= 0) & (faces < len(positions)), faces, 0) if len(positions) else None
    normals = geometry._cache.cache.get("vertex_normals")
    stated = normals is not None and len(normals) == len(positions) and inside is not None
    uv = geometry.vertex_attributes.get(_UV)
    usable = uv is not None and np.shape(uv)[1:] == (2,) and len(uv) == len(positions) and inside is not None
    return {
        "faces": faces,
        "positions": positions,
        "normals": (np.asarray(normals, np.float64) @ _adjugate(linear))[inside] if stated else None,
        "uv": (np.asarray(uv, np.float64) * (1.0, -1.0) + (0.0, 1.0))[inside] if usable else None,
    }


def _adjugate(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """The inverse of (3, 3) times its determinant without its sign, which matrices without an inverse have as well."""
    x, y, z = linear.T
    rows = np.stack([np.cross(y, z), np.cross(z, x), np.cross(x, y)])
    return rows * (-1.0 if np.linalg.det(linear) < 0.0 else 1.0)


#: Most bytes for reading a triangle, measured on files of each kind, besides the file itself.
FACE_BYTES = 1500

#: Least bytes of a triangle in a file, with its share of the vertices, for kinds that do not say how many there are.
_MIN_BYTES = {"obj": 30, "glb": 18, "gltf": 18, "stl_ascii": 150}

#: Share of the free memory that reading may take.
SHARE = 0.8

_HEAD_BYTES = 1 << 16


def decoder_memory_bytes() -> int:
    """Address space that the decoder of a mesh gets: what is free, less a reserve, and never less than others get."""
    return max(DECODER_MEMORY_BYTES, int(SHARE * psutil.virtual_memory().available))


def check_memory(path: str | os.PathLike[str]) -> None:
    """InputError for a mesh that would not fit in the memory that is free."""
    head, size_bytes = read_head(path, _HEAD_BYTES)
    faces = estimate_faces(head, size_bytes, Path(path).suffix.lower().lstrip("."))
    needed_bytes = faces * FACE_BYTES + 2 * size_bytes
    free_bytes = psutil.virtual_memory().available
    if needed_bytes > SHARE * free_bytes:
        raise InputError(
            path,
            f"has about {faces / 1e6:.2g} million triangles and needs about {needed_bytes / GIBIBYTE:.2g} GiB of "
            f"memory, of which {free_bytes / GIBIBYTE:.2g} GiB are free",
            "Reduce it in a modelling program, or close other programs",
        )


def estimate_faces(head: bytes, size_bytes: int, kind: str) -> int:
    """Number of triangles in a file, from what it announces or from its size; at most what its size can hold."""
    announced: int | None = None
    if kind == "stl" and len(head) >= 84 and size_bytes == 84 + 50 * int.from_bytes(head[80:84], "little"):
        return int.from_bytes(head[80:84], "little")
    head = utf8(head)
    if kind == "stl":
        kind = "stl_ascii"
    if kind == "ply":
        announced = ply_counts(head).get(b"face")
    if kind == "off" and (counts := off_counts(head)):
        announced = counts[1]
    least = size_bytes // _MIN_BYTES.get(kind, 10)
    return least if announced is None else min(announced, size_bytes // 6)
