"""Whether a mesh fits in memory, told from the first bytes of its file and its size.

Cost: one read of a few kilobytes.
"""

from __future__ import annotations

import os
from pathlib import Path

import psutil

from engine.errors import InputError
from engine.files.text import utf8
from engine.files.untrusted import DECODER_MEMORY_BYTES, GIBIBYTE, read_head
from engine.mesh_text import off_counts, ply_counts

#: What reading a triangle takes at most, measured on files of each kind, besides the file itself.
FACE_BYTES = 1500

#: Least bytes of a triangle in a file, with its share of the vertices, for kinds that do not say how many there are.
_LEAST_BYTES = {"obj": 30, "glb": 18, "gltf": 18, "stl_ascii": 150}

#: Share of the free memory that reading may take.
SHARE = 0.8

_HEAD_BYTES = 1 << 16


def decoder_memory_bytes() -> int:
    """Address space that the decoder of a mesh gets: what is free, less a reserve, and never less than others get."""
    return max(DECODER_MEMORY_BYTES, int(SHARE * psutil.virtual_memory().available))


def check_memory(path: str | os.PathLike[str]) -> None:
    """InputError for a mesh that would not fit in the memory that is free."""
    head, size_bytes = read_head(path, _HEAD_BYTES)
    faces = estimated_faces(head, size_bytes, Path(path).suffix.lower().lstrip("."))
    needed_bytes = faces * FACE_BYTES + 2 * size_bytes
    free_bytes = psutil.virtual_memory().available
    if needed_bytes > SHARE * free_bytes:
        raise InputError(
            path,
            f"has about {faces / 1e6:.2g} million triangles and needs about {needed_bytes / GIBIBYTE:.2g} GiB of "
            f"memory, of which {free_bytes / GIBIBYTE:.2g} GiB are free",
            "Reduce it in a modelling program, or close other programs",
        )


def estimated_faces(head: bytes, size_bytes: int, kind: str) -> int:
    """How many triangles a file holds, from what it announces or from its size; at most what its size can hold."""
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
    least = size_bytes // _LEAST_BYTES.get(kind, 10)
    return least if announced is None else min(announced, size_bytes // 6)
