"""Arcs of lamps in a stack: which photographs belong to one azimuth, and which are excluded with them."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.selection import Azimuth, arcs, beside
from engine.capture.stack import ImageStack
from engine.core.errors import InputError
from engine.shading.shading_map import include


def find_arcs(stack: ImageStack, excluded: Collection[str] = ()) -> list[tuple[Azimuth, list[str]]]:
    """Return the arcs of the photographs that are not excluded, each with the names of its photographs.

    Raises InputError where lamps have no azimuths, and where none of these has three elevations.
    """
    used = include(stack, excluded)
    azimuth, elevation = _angles(stack)
    found = [(near, [stack.sources[used[at]] for at in own]) for near, own in arcs(azimuth[used], elevation[used])]
    if not found:
        problem = "has no arc of lamps: nowhere are there three elevations within 10° of one azimuth"
        raise InputError(stack.folder or "the stack", problem, "Use all lamps, or import more photographs")
    return found


def exclude_beside(stack: ImageStack, azimuth: Azimuth | None, excluded: Collection[str] = ()) -> list[str]:
    """Return `excluded` and the names of all photographs beside an azimuth; None for the arc of most photographs.

    Raises InputError where fewer than two lamps stand at the azimuth.
    """
    near = max(find_arcs(stack, excluded), key=lambda arc: len(arc[1]))[0] if azimuth is None else azimuth
    outside = beside(*_angles(stack), near)
    if len(stack.sources) - outside.sum() < 2:
        problem = f"has fewer than two lamps at the azimuth {near.middle_deg:g}° ± {near.tolerance_deg:g}°"
        raise InputError(stack.folder or "the stack", problem, "Widen the tolerance, or choose another azimuth")
    names = [name for name, is_out in zip(stack.sources, outside, strict=True) if is_out]
    return list(dict.fromkeys([*excluded, *names]))


def _angles(stack: ImageStack) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if stack.azimuth is None:
        remedy = "Import it with a light list (.lp) or a capture.toml"
        raise InputError(stack.folder or "the stack", "its lamps have no azimuth", remedy)
    return stack.azimuth, stack.elevation
