"""Environment maps from files, repaired where a file holds what light cannot be, and those that need no file.

Real files have negative texels (ringing of lossy codecs and of resampling, down to -149 in published maps) and
infinite ones (half floats end at 65504). Each such channel of a texel becomes the median of its sound neighbours, and
the health counts them. Cube maps in a strip or a cross become the equirectangular layout of `engine.environment`.
"""

from __future__ import annotations

import os
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from engine.cube_layouts import cube_layout
from engine.cube_map import CubeMap, environment_of
from engine.environment import EnvironmentMap
from engine.errors import InputError
from engine.health import Finding, Health, Verdict
from engine.images.decode import Image, read_image
from engine.sky import SKIES, built_in

#: How far a repair reaches into a damaged area, in texels; what lies deeper is black.
REACH = 16

#: How many places of damage are named.
_PLACES = 4

NOT_EQUIRECTANGULAR = (
    "Give the equirectangular (latitude-longitude) form, twice as wide as high, or a cube map as a strip or a cross"
)


def open_environment(name: str | os.PathLike[str]) -> EnvironmentMap:
    """A built-in map by its name, or the file at that path; InputError says what is wrong with a file."""
    if os.fspath(name) in SKIES:
        return built_in(os.fspath(name))
    if not Path(name).exists() and "." not in Path(name).name:
        known = ", ".join(SKIES)
        raise InputError(name, "is neither a file nor a built-in environment", f"The built-in ones are {known}")
    return read_environment(name)


def read_environment(path: str | os.PathLike[str]) -> EnvironmentMap:
    """Read an equirectangular picture or a cube map (.hdr, .exr, others with a warning); cost as `read_image`.

    A cube map of edge N becomes 4 N × 2 N texels. Neighbours across its edges do not help in repairs.
    """
    image = read_image(path)
    height, width = image.pixels.shape[:2]
    layout = cube_layout(image.pixels, image.environment)
    if layout is None and width != 2 * height:
        raise InputError(path, f"is {width} × {height} texels, {_layout(width, height)}", NOT_EQUIRECTANGULAR)
    broken = image.saturated & ~image.pixels.any(axis=2)  # what is not finite is masked, and 0
    bad = broken[..., None] | (image.pixels < 0)
    if bad.all():
        raise InputError(path, "holds no usable radiance: every texel is negative or not finite", "Export it again")
    if layout is None:
        repaired, unreached = repair(image.pixels, bad)
        return EnvironmentMap(repaired, Path(path).name, _health(image, broken, bad, unreached, repaired))
    faces = [repair(*both, around=False) for both in zip(layout.cut(image.pixels), layout.cut(bad), strict=True)]
    radiance, said = layout.faces(np.stack([face for face, _ in faces]))
    health = _health(image, broken, bad, sum(unreached for _, unreached in faces), radiance)
    findings = tuple(Finding(Verdict.WARNING, text) for text in said)
    cube = CubeMap(radiance, Path(path).name, health.merged(Health(findings=findings)))
    return environment_of(cube, 2 * cube.edge)


def _layout(width: int, height: int) -> str:
    """What a picture of these proportions probably is."""
    long, short = max(width, height), min(width, height)
    if long == 6 * short:
        return "six faces of a cube map in a strip"
    if 3 * long == 4 * short:
        return "a photograph, or a cube map laid out as a cross whose empty corners are not empty"
    if 2 * long == 3 * short:
        return "perhaps a cube map in two rows of faces, or a photograph"
    return "square, as mirror-ball and angular maps are" if long == short else "not an equirectangular map"


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
        median = (ordered[np.maximum(sound - 1, 0) // 2, index] + ordered[sound // 2 % 9, index]) / 2
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
        texts.append(_replaced(negative, f"negative, down to {lowest:.4g}"))
    if broken.any():
        texts.append(_replaced(broken, "not finite"))
    if unreached:
        texts.append(f"{unreached} values lie more than {REACH} texels inside damaged areas and are black")
    if image.container not in ("EXR", "HDR") and repaired.max() <= 1.0:
        texts.append(f"a {image.container} that holds no radiance above 1: lamps and the sun are far too dark in it")
    if not repaired.any():
        texts.append("the environment is black")
    findings = tuple(Finding(Verdict.WARNING, text) for text in texts)
    return Health(MappingProxyType(figures), findings)


def _replaced(mask: NDArray[np.bool_], what: str) -> str:
    rows, columns = np.nonzero(mask)
    count = len(rows)
    places = "; ".join(f"column {c}, row {r}" for r, c in zip(rows[:_PLACES], columns[:_PLACES], strict=True))
    more = f"; and {count - _PLACES} more" if count > _PLACES else ""
    texels = f"{count} texel{'s are' if count > 1 else ' is'} {what} (at {places}{more})"
    return f"{texels}; replaced by the median of the neighbours"
