"""Forms in which lists of lights are written by mistake, and the list in another form.

Mirrored lists have an axis that points the other way, swapped ones x and y exchanged, turned ones both axes
pointing the other way; reversed and shifted ones name
the photographs in another order than they were taken in. The order is that of the file names.
"""

from __future__ import annotations

import dataclasses
import re

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.file_names import natural, printable
from engine.capture.lights.selection import reordered
from engine.capture.lights.sources import Sources
from engine.core.errors import InputError, UsageError

#: The form that a list is in, and its axes: signs of x and y, and whether they are exchanged.
LISTED = "listed"
AXES = {
    "mirrored-x": (-1.0, 1.0, False),
    "mirrored-y": (1.0, -1.0, False),
    "swapped-xy": (1.0, 1.0, True),
    "turned": (-1.0, -1.0, False),
}

_SHIFTED = re.compile(r"shifted([+-]\d{1,4})")


def is_form(form: str) -> bool:
    """Return whether a list of lights can be in `form`."""
    return form in (LISTED, "reversed", *AXES) or _SHIFTED.fullmatch(form) is not None


def check_form(form: str) -> None:
    """Raise UsageError for an unknown form."""
    if not is_form(form):
        known = ", ".join((LISTED, *AXES, "reversed", "shifted+1", "shifted-1"))
        raise UsageError(f"unknown form of a list of lights {form!r}; choose from {known}, …")


def change(directions: NDArray[np.float64], form: str) -> NDArray[np.float64]:
    """(N, 3) directions in the order of file names, as they are when the list is in `form`."""
    if form in AXES:
        x, y, is_swapped = AXES[form]
        turned = directions * (x, y, 1.0)
        return turned[:, [1, 0, 2]] if is_swapped else turned
    if form == "reversed":
        return directions[::-1]
    shift = _SHIFTED.fullmatch(form)
    return np.roll(directions, -int(shift[1]), axis=0) if shift else directions


def in_form(sources: Sources, form: str) -> Sources:
    """`sources` whose lights are those of their list in another form; InputError where they have no azimuth."""
    check_form(form)
    if form == LISTED:
        return sources
    place = sources.photographs[0].parent
    if sources.azimuth is None or sources.sphere is not None:
        problem = f"has no list of lights that could be {form}"
        raise InputError(place, problem, "Leave --lights-form out, or give a list with azimuths (.lp)")
    order = name_order(sources)
    elevation, azimuth = sources.elevation.copy(), sources.azimuth.copy()
    across = np.cos(elevation[order])
    listed = np.stack([across * np.cos(azimuth[order]), across * np.sin(azimuth[order]), np.sin(elevation[order])], 1)
    found = change(listed, form)
    elevation[order] = np.arctan2(found[:, 2], np.hypot(found[:, 0], found[:, 1]))
    azimuth[order] = np.arctan2(found[:, 1], found[:, 0])
    lit = dataclasses.replace(sources, elevation=elevation, azimuth=azimuth, lamp_gains=_gains(sources, order, form))
    return reordered(lit, np.argsort(elevation, kind="stable"))


def _gains(sources: Sources, order: NDArray[np.intp], form: str) -> dict[str, float]:
    """Intensities by name: they go with the lamps where the form moves those to other photographs."""
    if not sources.lamp_gains or form in AXES:
        return dict(sources.lamp_gains)
    names = [printable(sources.photographs[index]) for index in order]
    gains = change(np.array([[sources.lamp_gains[name]] for name in names]), form)
    return {name: float(gain) for name, (gain,) in zip(names, gains, strict=True)}


def name_order(sources: Sources) -> NDArray[np.intp]:
    """(N,) the photographs in the natural order of their names."""
    names = [natural(path.name) for path in sources.photographs]
    return np.array(sorted(range(len(names)), key=names.__getitem__), np.intp)
