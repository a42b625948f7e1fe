"""Complete readers from outside the package: an image, a mesh and a measured BRDF, each a list of numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.brdf.samples import BrdfSamples
from engine.images.raster import Raster, check_size
from engine.storage.untrusted import read_bytes
from lightarc import Reader


def read_image(content: bytes, name: str) -> Raster:
    """Linear grey radiance: width and height, and the rows of pixels."""
    _, width, height, *values = content.split()
    check_size(name, int(width), int(height), 4, len(content))
    return Raster(np.array(values, np.float32).reshape(int(height), int(width)), None, 32, "linear", "PLAIN")


def read_mesh(content: bytes, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Three corners of a triangle in each line."""
    points = np.array(content.split()[1:], float).reshape(-1, 3)
    return points, np.arange(len(points)).reshape(-1, 3)


def read_brdf(path: Path) -> BrdfSamples:
    """Two directions and a value in each line."""
    rows = np.array(read_bytes(path).split()[1:], float).reshape(-1, 7)
    return BrdfSamples(rows[:, :3], rows[:, 3:6], rows[:, 6:].repeat(3, 1), name=path.stem, kind="plain rows")


IMAGE = Reader(
    "image",
    "Plain image",
    f"{__name__}:read_image",
    (".plainimage",),
    signatures=(b"PLAINIMAGE",),
    of_radiance=True,
)
MESH = Reader("mesh", "Plain mesh", f"{__name__}:read_mesh", (".plainmesh",), signatures=(b"PLAINMESH",))
BRDF = Reader("brdf", "Plain BRDF", f"{__name__}:read_brdf", (".plainbrdf",), signatures=(b"PLAINBRDF",))
