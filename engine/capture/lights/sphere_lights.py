"""The lights of a capture from the mirror sphere in its photographs: sources whose directions are measured.

Each light is measured on the shortest of its exposures, where its reflection is smallest. The direction is that seen
from the sphere; for a near lamp it differs from that seen from the sample by where the sphere lies, unless a second
sphere shows the lamp's position (`engine.capture.lights.two_spheres`).
Cost: each photograph is decoded once more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import closing
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.azimuth_spread import about_azimuth
from engine.capture.lights.file_names import printable
from engine.capture.lights.light_angles import ASSUMED, FROM_NAMES, SPHERE
from engine.capture.lights.mirror_sphere import Circle, find_highlights, find_sphere, light_direction
from engine.capture.lights.sources import Sources
from engine.capture.lights.two_spheres import lamp_positions
from engine.capture.photograph.decode import ReadAhead
from engine.core.colour import luminance
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Verdict
from engine.core.steps import Steps
from engine.storage.scratch import release, scratch_array

if TYPE_CHECKING:
    from engine.images.decode import TransferChoice

#: Stated and measured elevations that differ by more are worth a warning.
DISAGREEMENT = math.radians(3.0)

_REMEDY = "Mark it by hand in the Capture workspace or as highlight_px in capture.toml, or leave the photograph out"


def with_sphere(
    sources: Sources, outline: Circle | Literal["auto"], highlights: Mapping[str, tuple[float, float]] | None = None
) -> Sources:
    """`sources` whose lights are to be measured on a sphere with this `outline`.

    `highlights` are (column, row) by file name where a user corrected them; the others stay as they were.
    Elevations that were only assumed are forgotten, so that what is measured is not held against them.
    """
    marked = highlights or {}
    names = map(printable, sources.photographs)
    assumed = sources.angle_source == "assumed"
    return replace(
        sources,
        sphere=outline,
        highlights_px=tuple(marked.get(name, old) for name, old in zip(names, sources.highlights_px, strict=True)),
        elevation=np.zeros_like(sources.elevation) if assumed else sources.elevation,
        angle_source=SPHERE,
        findings=tuple(one for one in sources.findings if not one.text.startswith((ASSUMED, FROM_NAMES))),
    )


def measure_lights(
    sources: Sources, transfer: TransferChoice, second: Circle | Literal["auto"] | None = None
) -> Steps[Sources]:
    """`sources` with the directions that their mirror sphere shows, by rising elevation, and its outline.

    With a `second` sphere the directions are those from the middle of the image, and the distance of near lamps is
    that of their median. Raises InputError that names the photograph in which no highlight is found, or where there is
    no sphere.
    """
    images = yield from luminances(sources, transfer)
    outline = sources.sphere
    if not isinstance(outline, Circle):
        outline = find_outline(sources, images)
    _check_inside(sources, outline, images[0])
    spots = _spots(sources, images, outline)
    directions = np.array([_direction(sources, index, spot, outline) for index, spot in enumerate(spots)])
    findings, distance = list[Finding](), sources.lamp_distance
    if second is not None:
        positions = _positions(sources, images, outline, spots, second)
        directions, distance, found = _observe_from_the_middle(directions, positions, images.shape[2])
        findings.append(found)
    elevation = np.arcsin(np.clip(directions[:, 2], -1, 1))
    azimuth = np.arctan2(directions[:, 1], directions[:, 0])
    findings += [finding for finding in sources.findings if finding not in about_azimuth(sources.azimuth)]
    findings += _disagreements(sources, elevation)
    order = np.argsort(elevation, kind="stable")
    return replace(
        sources.reorder(order),
        elevation=elevation[order],
        azimuth=azimuth[order],
        sphere=outline,
        lamp_distance=distance,
        findings=(*findings, *about_azimuth(azimuth)),
    )


def _positions(
    sources: Sources,
    images: NDArray[np.float32],
    first: Circle,
    spots: list[tuple[float, float]],
    second: Circle | Literal["auto"],
) -> NDArray[np.float64]:
    """(N, 3) lamps in pixels from the middle of the image, infinite where they are far; `spots` are on the first."""
    try:
        other = second if isinstance(second, Circle) else find_sphere(images, first)
    except UsageError as error:
        remedy = "Give its outline: --second-sphere COLUMN,ROW,RADIUS"
        raise InputError(sources.photographs[0].parent, f"shows no second sphere: {error}", remedy) from None
    _check_inside(sources, other, images[0])
    seconds = _spots(replace(sources, highlights_px=(None,) * len(images)), images, other)
    return lamp_positions((first, other), np.stack([spots, seconds], axis=1), *images.shape[1:])


def _observe_from_the_middle(
    directions: NDArray[np.float64], positions: NDArray[np.float64], width: int
) -> tuple[NDArray[np.float64], float | None, Finding]:
    """Directions from the middle of the image, the median distance in widths of the image, and what to say."""
    near = np.isfinite(positions).all(axis=1) & (positions[:, 2] > 0)
    if near.sum() * 2 < len(near):
        text = "The rays of two mirror spheres are parallel: the lamps are taken as distant"
        return directions, None, Finding(Verdict.NOTE, text)
    distances = np.linalg.norm(positions, axis=1)
    directions = directions.copy()
    directions[near] = positions[near] / distances[near, None]
    widths = distances[near] / width
    text = (
        f"Two mirror spheres show the lamps {np.median(widths):.2f} image widths away ({widths.min():.2f} to "
        f"{widths.max():.2f}); {near.sum()} of {len(near)} lights were placed so"
    )
    return directions, max(0.51, float(np.median(widths))), Finding(Verdict.NOTE, text)


def luminances(sources: Sources, transfer: TransferChoice) -> Steps[NDArray[np.float32]]:
    """(N, H, W) luminance of the photographs, in a file where it is large."""
    count = len(sources.photographs)
    images: NDArray[np.float32] | None = None
    with closing(ReadAhead(sources.photographs, transfer=transfer)) as ahead:
        for index, path in enumerate(sources.photographs):
            note = f"Looking at the sphere in {index + 1} of {count}"
            photograph = yield from ahead.next_photograph(index / count, note)
            if images is None:
                images = scratch_array((count, *photograph.saturated.shape), np.float32)
            if photograph.saturated.shape != images.shape[1:]:
                problem = f"is not of the size of {sources.photographs[0].name}, so the sphere lies elsewhere in it"
                raise InputError(path, problem, "Leave it out")
            images[index] = luminance(photograph.radiance)
            release(images)
    assert images is not None
    return images


def find_outline(sources: Sources, images: NDArray[np.float32]) -> Circle:
    """The outline of the sphere in `images` (N, H, W); InputError where none is found."""
    try:
        return find_sphere(images)
    except UsageError as error:
        remedy = (
            "Mark it by hand in the Capture workspace, or give --sphere COLUMN,ROW,RADIUS or [sphere] in capture.toml"
        )
        raise InputError(sources.photographs[0].parent, str(error), remedy) from None


def _check_inside(sources: Sources, outline: Circle, image: NDArray[np.float32]) -> None:
    height, width = image.shape
    if not (0 <= outline.column <= width and 0 <= outline.row <= height and outline.radius < max(height, width)):
        problem = f"the outline of the sphere lies outside the {width} × {height} px of the photographs"
        raise InputError(sources.photographs[0].parent, problem, "Correct the outline of the sphere")


def _spots(sources: Sources, images: NDArray[np.float32], outline: Circle) -> list[tuple[float, float]]:
    """Where each photograph shows the lamp: marked or found; InputError that names one that shows none."""
    spots = list[tuple[float, float]]()
    found = find_highlights(images, outline)
    for path, marked, spot in zip(sources.photographs, sources.highlights_px, found, strict=True):
        if marked is not None:
            spots.append(marked)
        elif isinstance(spot, UsageError):
            raise InputError(path, f"{spot} (the sphere is at {_text(outline)})", _REMEDY)
        else:
            spots.append(spot)
    return spots


def _direction(sources: Sources, index: int, spot: tuple[float, float], outline: Circle) -> NDArray[np.float64]:
    try:
        return light_direction(outline, *spot)
    except UsageError as error:
        problem = f"{error} (the sphere is at {_text(outline)})"
        raise InputError(sources.photographs[index], problem, _REMEDY) from None


def _text(outline: Circle) -> str:
    return f"column {outline.column:.0f}, row {outline.row:.0f}, radius {outline.radius:.0f} px"


def _disagreements(sources: Sources, measured: NDArray[np.float64]) -> list[Finding]:
    text = "its light is measured at {:.1f}° on the sphere, but said to be at {:.1f}°; the measured one is used"
    return [
        Finding(Verdict.WARNING, text.format(math.degrees(found), math.degrees(stated)), path.name)
        for path, found, stated in zip(sources.photographs, measured, sources.elevation, strict=True)
        if stated > 0 and abs(found - stated) > DISAGREEMENT
    ]
