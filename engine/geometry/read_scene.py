"""STL as trimesh finds it, the files that a glTF file names, and the memory that a mesh needs.

A glTF file may keep its numbers in other files. The parent hands those to the decoder that lie beside or below it, and
no others.

The memory of a mesh is estimated from the first bytes of its file and its size.

Cost: one read of a few kilobytes.
"""

from __future__ import annotations

import gc
import io
import json
import os
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from engine.core.budget import free_bytes
from engine.core.errors import InputError
from engine.geometry.mesh_text import off_counts, ply_counts
from engine.storage.text import utf8
from engine.storage.untrusted import AGAIN, DECODER_MEMORY_BYTES, FILE_LIMIT_BYTES, GIBIBYTE, open_checked, read_head

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
            problem = f"needs the file {uri[:60]!r} next to it, which {error.problem}"
            raise InputError(path, problem, "Copy that as well, or export it as .glb") from None
    return found


def read_stl(content: bytes, name: str) -> list[dict[str, Any]]:
    """Positions and faces of each solid of an STL file."""
    import trimesh

    kind = Path(name).suffix.lower().lstrip(".")
    with warnings.catch_warnings():
        # numpy stops at the first thing that is not a number, and trimesh goes on with what came before it
        warnings.filterwarnings("error", message=".*could not be read to its end", category=DeprecationWarning)
        try:
            scene = trimesh.load_scene(io.BytesIO(content), file_type=kind, process=False)
        except (DeprecationWarning, ImportError, NameError, NotImplementedError, AssertionError) as error:
            raise InputError(name, f"is damaged or of an unknown kind ({error})", AGAIN) from None
    found = [
        {
            "positions": np.asarray(solid.vertices, np.float64),
            "faces": np.asarray(solid.faces, np.int64).reshape(-1, 3),
        }
        for solid in scene.geometry.values()
        if hasattr(solid, "faces")
    ]
    del scene
    gc.collect()  # what trimesh made refers to itself, and holds all arrays
    return found


#: Bytes for reading a triangle, besides the file itself. Models whose triangles share their vertices take 320 to 370
#: (`python -m benchmarks --only large-models`), those whose triangles share none some 700 (OBJ) to 1,400 (STL). What is
#: refused by them may be of the first kind and fit, and glTF and STL of the second kind may need more.
FACE_BYTES = {"ply": 950, "glb": 950, "gltf": 950, "obj": 950, "stl": 900}
TEXT_FACE_BYTES = 1400

#: Least bytes of a triangle in a file, with its share of the vertices, for kinds that do not say how many there are.
_MIN_BYTES = {"obj": 30, "glb": 18, "gltf": 18, "stl_ascii": 150}

#: Share of the free memory that reading may take.
SHARE = 0.8

_HEAD_BYTES = 1 << 16


def decoder_memory_bytes() -> int:
    """Address space that the decoder of a mesh gets: what is free, less a reserve, and never less than others get."""
    return max(DECODER_MEMORY_BYTES, int(SHARE * free_bytes()))


def check_memory(path: str | os.PathLike[str]) -> None:
    """InputError for a mesh that would not fit in the memory that is free."""
    head, size_bytes = read_head(path, _HEAD_BYTES)
    kind = Path(path).suffix.lower().lstrip(".")
    faces = estimate_faces(head, size_bytes, kind)
    needed_bytes = faces * FACE_BYTES.get(kind, TEXT_FACE_BYTES) + 2 * size_bytes
    free = free_bytes()
    if needed_bytes > SHARE * free:
        raise InputError(
            path,
            f"has about {faces / 1e6:.2g} million triangles and needs about {needed_bytes / GIBIBYTE:.2g} GiB of "
            f"memory, of which {free / GIBIBYTE:.2g} GiB are free",
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
