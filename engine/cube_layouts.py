"""Cube maps as one picture: strips of six faces and crosses, recognised and cut into faces in OpenGL orientation.

Strips hold +X −X +Y −Y +Z −Z. Faces are taken as OpenGL has them, or each mirrored, as one standing inside sees them
(so OpenEXR stores them): whichever fits together better at the edges. Where OpenEXR says that a picture is a cube map,
faces are mirrored and the outermost samples lie ON the edges (ImfEnvmap.h). A cross has −X +Z +X −Z in its row, +Y
above and −Y below +Z; one that stands has −Z below −Y, upside down. A picture of a cross's proportions is a cross if
its six empty cells are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.cube_map import texels_beside

#: Row and column of +X −X +Y −Y +Z −Z in each layout, by (rows, columns).
_CELLS = {
    (6, 1): [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0)],
    (1, 6): [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (0, 5)],
    (3, 4): [(1, 2), (1, 0), (0, 1), (2, 1), (1, 1), (1, 3)],
    (4, 3): [(1, 2), (1, 0), (0, 1), (2, 1), (1, 1), (3, 1)],
}

#: How much the empty cells of a cross may vary, against the mean of the picture; and how well edges must fit together,
#: against neighbours within faces, not to be warned of.
_EMPTY, _LOOSE = 1e-2, 8.0


@dataclass(frozen=True)
class CubeLayout:
    """Where the faces of a cube map lie in a picture.

    `grid` are rows and columns of faces, `on_edges` tells that the outermost samples lie on the edges of the faces.
    """

    grid: tuple[int, int]
    on_edges: bool = False

    def cut(self, image: NDArray[Any]) -> list[NDArray[Any]]:
        """The six faces (N, N, …) as they lie in the picture, upright."""
        n = image.shape[0] // self.grid[0]
        faces = [image[i * n : (i + 1) * n, j * n : (j + 1) * n] for i, j in _CELLS[self.grid]]
        if self.grid == (4, 3):
            faces[5] = faces[5][::-1, ::-1]
        return faces

    def faces(self, faces: NDArray[np.float32]) -> tuple[NDArray[np.float32], list[str]]:
        """Faces (6, N, N, 3) as `cut` gives them in OpenGL orientation, and in words what was assumed or is odd."""
        if self.on_edges:
            return _from_edges(_mirrored(faces)), [
                "is a cube map of OpenEXR; it was converted to latitude and longitude"
            ]
        kind = "a strip of six faces" if 1 in self.grid else "a cross"
        said = [f"is a cube map laid out as {kind}; it was converted to latitude and longitude"]
        fits, mirrored = _misfit(faces), _misfit(_mirrored(faces))
        if mirrored < 0.5 * fits and 1 in self.grid:
            faces, fits = _mirrored(faces), mirrored
            said.append("its faces were mirrored, because only then they fit together")
        within = _roughness(faces)
        if fits > _LOOSE * within:
            said.append("its faces do not fit together at their edges: their order or orientation may be another")
        return np.ascontiguousarray(faces), said


def cube_layout(image: NDArray[np.float32], environment: str) -> CubeLayout | None:
    """The layout of a picture (H, W, 3), where it is a cube map; `environment` is what OpenEXR says it is, or ''."""
    height, width = image.shape[:2]
    if environment == "cube" and height == 6 * width:
        return CubeLayout((6, 1), on_edges=True)
    for grid in ((6, 1), (1, 6)):
        if height * grid[1] == width * grid[0]:
            return CubeLayout(grid)
    for grid in ((3, 4), (4, 3)):
        if height * grid[1] == width * grid[0] and height % grid[0] == 0 and _is_cross(image, grid):
            return CubeLayout(grid)
    return None


def _is_cross(image: NDArray[np.float32], grid: tuple[int, int]) -> bool:
    """Whether every cell that a cross leaves empty is of one colour, and the picture is not."""
    n = image.shape[0] // grid[0]
    if n < 2:
        return False
    allowed = _EMPTY * float(np.abs(image).mean(dtype=np.float64))
    empty = [(i, j) for i in range(grid[0]) for j in range(grid[1]) if (i, j) not in _CELLS[grid]]
    cells = [image[i * n : (i + 1) * n, j * n : (j + 1) * n].reshape(-1, 3) for i, j in empty]
    return bool(np.ptp(image) > allowed and all((np.ptp(cell, axis=0) <= allowed).all() for cell in cells))


def _mirrored(faces: NDArray[Any]) -> NDArray[Any]:
    """Each face seen from the other side: left and right exchanged, on +Y and −Y above and below."""
    mirrored = faces[:, :, ::-1].copy()
    mirrored[2:4] = faces[2:4, ::-1]
    return mirrored


def _misfit(faces: NDArray[np.float32]) -> float:
    """Mean difference of texels that meet at the edges of faces, of values with their range compressed."""
    n = faces.shape[1]
    level = np.log1p(faces.astype(np.float64))
    beyond = level.reshape(-1, 3)[texels_beside(n)]
    at_edge = np.stack([level[:, 0], level[:, -1], level[:, :, 0], level[:, :, -1]], axis=1)
    return float(np.abs(at_edge - beyond).mean())


def _roughness(faces: NDArray[np.float32]) -> float:
    """Mean difference of neighbours within faces, measured as `_misfit`."""
    level = np.log1p(faces.astype(np.float64))
    steps: list[Callable[[], Any]] = [lambda: np.diff(level, axis=1), lambda: np.diff(level, axis=2)]
    return float(np.mean([np.abs(step()).mean() if faces.shape[1] > 1 else 0.0 for step in steps]))


def _from_edges(faces: NDArray[np.float32]) -> NDArray[np.float32]:
    """Texels with their centres inside from samples of which the outermost lie on the edges, by straight lines."""
    n = faces.shape[1]
    at = (np.arange(n) + 0.5) / n * (n - 1)
    low = np.minimum(at.astype(np.int64), max(n - 2, 0))
    high = np.minimum(low + 1, n - 1)
    share = (at - low).astype(np.float32)
    rows = faces[:, low] * (1 - share)[:, None, None] + faces[:, high] * share[:, None, None]
    return np.ascontiguousarray(rows[:, :, low] * (1 - share)[:, None] + rows[:, :, high] * share[:, None])
