"""Names of the members of a bundle, and its manifest, which is read without the libraries that pixels take.

A manifest is read in a process that unpacks and parses alone, and starts in half the time of one that decodes pixels.
"""

from __future__ import annotations

import os
from typing import Any

from engine.storage.archive import Archive, json_of, open_archive
from engine.storage.records import MAX_PLANES, TABLE, Manifest, manifest_of

MANIFEST = "manifest.json"
PREVIEW = "preview.png"

#: Maps of a shading map and its power law.
SLICES, KEPT = "shading_map.exr", "power_law_kept_tiles.exr"
SCALE, EXPONENT, ERROR = "power_law_scale.exr", "power_law_exponent.exr", "power_law_error.exr"
CODES = "power_law_exponent.png"
MAPS = frozenset({SLICES, SCALE, EXPONENT, CODES, ERROR, KEPT})

#: Parts of a directional map.
NUMBERS, WEIGHTS = "directional.json", "directional_weights.exr"
PLANE_FILES = tuple(f"directional_plane{k:02d}.png" for k in range(MAX_PLANES))
DIRECTIONAL = frozenset({NUMBERS, WEIGHTS, *PLANE_FILES})

PBR = "pbr_maps.exr"

#: The object of a material before its background.
MASK = "mask.png"

#: Members for other programs.
BRDF, SHADER, VIEWER = "brdf.json", "shader/lightarc.glsl", "viewer/index.html"

MEMBERS = MAPS | DIRECTIONAL | {PBR, MASK, MANIFEST, BRDF, TABLE, PREVIEW, SHADER, VIEWER}

#: The decoder process of bundles whose maps are read as well, and that of zips and records alone.
MAPS_PROCESS, RECORDS_PROCESS = "engine.bundle.member_maps", "engine.storage.archive_child"

#: Largest manifest, and largest BRDF in words.
JSON_LIMIT_BYTES = 16 << 20


def read_manifest(archive: Archive) -> Manifest:
    """The manifest of a bundle; InputError where it is damaged or of a newer version."""
    content = archive.read(MANIFEST, JSON_LIMIT_BYTES)
    return manifest_of(json_of(content, archive.path, MANIFEST, archive.process), archive.path)


def describe_bundle(path: str | os.PathLike[str], process: str = RECORDS_PROCESS) -> dict[str, Any]:
    """The manifest of a bundle as JSON values, with the `warnings` of its health; its pixels are not looked at.

    `process` is `MAPS_PROCESS` where that is running anyway.
    """
    manifest = read_manifest(open_archive(path, MEMBERS, process))
    return {**manifest.model_dump(), "warnings": manifest.health.restored().warnings}
