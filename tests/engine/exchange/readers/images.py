"""Maps that are known, and the images that hold them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import normalize
from engine.images.encode import encode_png
from engine.surface.pbr_maps import PbrMaps

SIZE = 24


def relief(size: int = SIZE) -> NDArray[np.float32]:
    """Normals (y up) of waves whose crests run aslant, so that the slopes are correlated."""
    row, column = np.mgrid[0:size, 0:size]
    phase = 2.0 * np.pi * 2.0 * (column - row) / size  # rows run down: x and y grow together along the crests' normal
    slope = 0.5 * np.cos(phase)
    return normalize(np.dstack([-slope, -slope, np.ones_like(slope)])).astype(np.float32)


def find_known(seed: int = 1) -> PbrMaps:
    random = np.random.default_rng(seed)
    return PbrMaps(
        base_colour=random.random((SIZE, SIZE, 3)).astype(np.float32),
        normal=relief(),
        roughness=random.random((SIZE, SIZE)).astype(np.float32),
        metallic=random.random((SIZE, SIZE)).astype(np.float32),
        f0=np.full((SIZE, SIZE), 0.04, np.float32),
    )


def png(path: Path, codes: Any) -> Path:
    """Write codes (H, W) or (H, W, channels) as they are."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(encode_png(np.asarray(codes, np.uint8)))
    return path


def grey(value: int, size: int = 4) -> NDArray[np.uint8]:
    return np.full((size, size, 3), value, np.uint8)
