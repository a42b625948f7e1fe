"""Environment maps from files, repaired where a file holds what light cannot be, and those that need no file.

Real files have negative texels (ringing of lossy codecs and of resampling, down to -149 in published maps) and
infinite ones (half floats end at 65504). What is infinite is the sun or a lamp and becomes the largest half; what is
negative or no number becomes the median of its sound neighbours, channel by channel, and the health counts them. Cube
maps in a strip or a cross become the equirectangular layout of `engine.light.environment`.

Cube maps may come as one image: strips of six faces and crosses are recognised and cut into faces in OpenGL
orientation.

Strips hold +X −X +Y −Y +Z −Z. Faces are taken as they are, or each mirrored, as one standing inside sees them
(so OpenEXR stores them): whichever fits together better at the edges. Where OpenEXR says that an image is a cube map,
faces are mirrored and the outermost samples lie ON the edges (ImfEnvmap.h). A cross has −X +Z +X −Z in its row, +Y
above and −Y below +Z; one that stands has −Z below −Y, upside down. An image of a cross's proportions is a cross if
its six empty cells are.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.core.health import Finding, Health, Verdict
from engine.core.suggestion import suggest
from engine.images.decode import Image, read_image, refuse_larger
from engine.light.cube_map import CubeMap, environment_of, texels_beside
from engine.light.environment import EnvironmentMap
from engine.light.probe import FORMS, unfold, within_circle
from engine.light.sky import SKIES, make_built_in

#: Row and column of +X −X +Y −Y +Z −Z in each layout, by (rows, columns).
_CELLS = {
    (6, 1): [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (5, 0)],
    (1, 6): [(0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (0, 5)],
    (3, 4): [(1, 2), (1, 0), (0, 1), (2, 1), (1, 1), (1, 3)],
    (4, 3): [(1, 2), (1, 0), (0, 1), (2, 1), (1, 1), (3, 1)],
}

#: Largest variation of the empty cells of a cross, against the mean of the image; and the largest mismatch of edges,
#: against neighbours within faces, that gives no warning.
_EMPTY, _LOOSE = 1e-2, 8.0


@dataclass(frozen=True)
class CubeLayout:
    """Layout of the faces of a cube map in an image.

    `grid` are rows and columns of faces, `on_edges` means that the outermost samples lie on the edges of the faces.
    """

    grid: tuple[int, int]
    on_edges: bool = False

    def cut(self, image: NDArray[Any]) -> list[NDArray[Any]]:
        """The six faces (N, N, …) as they lie in the image, upright."""
        n = image.shape[0] // self.grid[0]
        faces = [image[i * n : (i + 1) * n, j * n : (j + 1) * n] for i, j in _CELLS[self.grid]]
        if self.grid == (4, 3):
            faces[5] = faces[5][::-1, ::-1]
        return faces

    def faces(self, faces: NDArray[np.float32]) -> tuple[NDArray[np.float32], list[str]]:
        """Faces (6, N, N, 3) as `cut` gives them in OpenGL orientation, and in words what was assumed or is odd."""
        if self.on_edges:
            return _from_edges(_mirror(faces)), ["is a cube map of OpenEXR; it was converted to latitude and longitude"]
        kind = "a strip of six faces" if 1 in self.grid else "a cross"
        said = [f"is a cube map laid out as {kind}; it was converted to latitude and longitude"]
        fits, mirrored = _misfit(faces), _misfit(_mirror(faces))
        if mirrored < 0.5 * fits and 1 in self.grid:
            faces, fits = _mirror(faces), mirrored
            said.append("its faces were mirrored, because only then they fit together")
        within = _roughness(faces)
        if fits > _LOOSE * within:
            said.append("its faces do not fit together at their edges: their order or orientation may be another")
        return np.ascontiguousarray(faces), said


def cube_layout(image: NDArray[np.float32], environment: str) -> CubeLayout | None:
    """The layout of an image (H, W, 3), where it is a cube map; `environment` is what OpenEXR says it is, or ''."""
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
    """True if every cell that a cross leaves empty is of one colour, and the image is not."""
    n = image.shape[0] // grid[0]
    if n < 2:
        return False
    allowed = _EMPTY * float(np.abs(image).mean(dtype=np.float64))
    empty = [(i, j) for i in range(grid[0]) for j in range(grid[1]) if (i, j) not in _CELLS[grid]]
    cells = [image[i * n : (i + 1) * n, j * n : (j + 1) * n].reshape(-1, 3) for i, j in empty]
    return bool(np.ptp(image) > allowed and all((np.ptp(cell, axis=0) <= allowed).all() for cell in cells))


def _mirror(faces: NDArray[Any]) -> NDArray[Any]:
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


#: Depth of a repair into a damaged area, in texels; what lies deeper is black.
REACH = 16

#: Most places of damage that are named.
_PLACES = 4

NOT_EQUIRECTANGULAR = (
    "Give the equirectangular (latitude-longitude) form, twice as wide as high, or a cube map as a strip or a cross"
)


def open_environment(name: str | os.PathLike[str]) -> EnvironmentMap:
    """A built-in map by its name, or the file at that path; InputError says what is wrong with a file.

    `ball:FILE` is a photograph of a mirror ball, `angular:FILE` an angular map (`engine.light.probe`).
    """
    if os.fspath(name) in SKIES:
        return make_built_in(os.fspath(name))
    form, _, file = os.fspath(name).partition(":")
    if form in FORMS and not Path(name).exists():
        return read_environment(file, form)
    if not Path(name).exists() and "." not in Path(name).name:
        known, meant = ", ".join(SKIES), suggest(os.fspath(name), SKIES)
        raise InputError(name, f"is neither a file nor a built-in environment{meant}", f"The built-in ones are {known}")
    return read_environment(name)


def read_environment(path: str | os.PathLike[str], form: str = "") -> EnvironmentMap:
    """Read an equirectangular image or a cube map (.hdr, .exr, others with a warning); cost as `read_image`.

    A cube map of edge N becomes 4 N × 2 N texels. Neighbours across its edges do not help in repairs. A square image
    of a `form` of `engine.light.probe`, cut at the rim of its circle, of N × N pixels becomes N × N / 2 texels.
    """
    image = read_image(path, clamp_infinite=True)
    refuse_larger(path, image.pixels)
    height, width = image.pixels.shape[:2]
    if form and width != height:
        raise InputError(path, f"is {width} × {height} texels, and such an image is square", "Cut it at the rim")
    layout = None if form else cube_layout(image.pixels, image.environment)
    if layout is None and not form and width != 2 * height:
        raise InputError(path, f"is {width} × {height} texels, {_layout(width, height)}", NOT_EQUIRECTANGULAR)
    broken = image.saturated & ~image.pixels.any(axis=2)  # what is not finite is masked, and 0
    bad = broken[..., None] | (image.pixels < 0)
    if bad.all():
        raise InputError(path, "holds no usable radiance: every texel is negative or not finite", "Export it again")
    if layout is None:
        if form:
            bad &= within_circle(height)[..., None]
        repaired, unreached = repair(image.pixels, bad, around=not form)
        repaired = unfold(repaired, form) if form else repaired
        return EnvironmentMap(repaired, Path(path).name, _health(image, broken, bad, unreached, repaired))
    faces = [repair(*both, around=False) for both in zip(layout.cut(image.pixels), layout.cut(bad), strict=True)]
    radiance, said = layout.faces(np.stack([face for face, _ in faces]))
    health = _health(image, broken, bad, sum(unreached for _, unreached in faces), radiance)
    findings = tuple(Finding(Verdict.WARNING, text) for text in said)
    cube = CubeMap(radiance, Path(path).name, health.merge(Health(findings=findings)))
    return environment_of(cube, 2 * cube.edge)


def _layout(width: int, height: int) -> str:
    """Likely kind of an image of these proportions."""
    long, short = max(width, height), min(width, height)
    if long == 6 * short:
        return "six faces of a cube map in a strip"
    if 3 * long == 4 * short:
        return "a photograph, or a cube map laid out as a cross whose empty corners are not empty"
    if 2 * long == 3 * short:
        return "perhaps a cube map in two rows of faces, or a photograph"
    return (
        "square, as mirror balls (--env ball:FILE) and angular maps (--env angular:FILE) are"
        if long == short
        else "not an equirectangular map"
    )


def repair(
    radiance: NDArray[np.float32], bad: NDArray[np.bool_], *, around: bool = True
) -> tuple[NDArray[np.float32], int]:
    """Replace what `bad` (H, W, 3) marks by the median of sound neighbours, inwards from the edge of damaged areas.

    The eight neighbours wrap around in longitude if the map goes `around`. Returns the map, and how many values the
    repair did not reach.
    """
    radiance, bad = np.where(bad, np.float32(np.nan), radiance), bad.copy()
    height, width = bad.shape[:2]
    for _ in range(REACH):
        row, column, channel = np.nonzero(bad)
        if row.size == 0:
            break
        neighbours = []
        for down in (-1, 0, 1):
            for right in (-1, 0, 1):
                beside = (column + right) % width if around else np.clip(column + right, 0, width - 1)
                neighbours.append(radiance[np.clip(row + down, 0, height - 1), beside, channel])
        ordered = np.sort(np.stack(neighbours), axis=0)  # NaN last
        sound = np.isfinite(ordered).sum(axis=0)
        index = np.arange(row.size)
        # Halves first: the sum of two of the largest numbers is infinite.
        median = ordered[np.maximum(sound - 1, 0) // 2, index] / 2 + ordered[sound // 2 % 9, index] / 2
        reached = sound > 0
        at = (row[reached], column[reached], channel[reached])
        radiance[at], bad[at] = median[reached], False
    radiance[bad] = 0.0
    return radiance, int(bad.sum())


def _health(
    image: Image, broken: NDArray[np.bool_], bad: NDArray[np.bool_], unreached: int, repaired: NDArray[np.float32]
) -> Health:
    negative = bad.any(axis=2) & ~broken
    lowest = min(float(image.pixels.min()), 0.0)
    figures = {
        "negative_texels": float(negative.sum()),
        "nonfinite_texels": float(broken.sum()),
        "most_negative_radiance": lowest,
        "unreached_values": float(unreached),
    }
    texts = list(image.warnings)
    if negative.any():
        texts.append(_replace(negative, f"negative, down to {lowest:.4g}"))
    if broken.any():
        texts.append(_replace(broken, "not finite"))
    if unreached:
        texts.append(f"{unreached} values lie more than {REACH} texels inside damaged areas and are black")
    if image.container not in ("EXR", "HDR", "PFM") and repaired.max() <= 1.0:
        texts.append(f"a {image.container} that holds no radiance above 1: lamps and the sun are far too dark in it")
    if not repaired.any():
        texts.append("the environment is black")
    findings = tuple(Finding(Verdict.WARNING, text) for text in texts)
    return Health(MappingProxyType(figures), findings)


def _replace(mask: NDArray[np.bool_], what: str) -> str:
    rows, columns = np.nonzero(mask)
    count = len(rows)
    places = "; ".join(f"column {c}, row {r}" for r, c in zip(rows[:_PLACES], columns[:_PLACES], strict=True))
    more = f"; and {count - _PLACES} more" if count > _PLACES else ""
    texels = f"{count} texel{'s are' if count > 1 else ' is'} {what} (at {places}{more})"
    return f"{texels}; replaced by the median of the neighbours"
