"""Two captures of one sample as one: photographs that were taken later join those that are there.

Directions of light that both captures know are kept as they are. Where one only assumes even steps, both are looked at
anew together, because steps are even among all photographs.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.file_names import join_names
from engine.capture.lights.light_angles import direction_text
from engine.capture.lights.sources import Sources, Unpacked, find
from engine.core.directions import surface_direction
from engine.core.errors import InputError

#: Directions of light that differ by no more are the same, in radians.
SAME = 1e-6


def join(one: Sources, other: Sources) -> Sources:
    """The photographs of both by rising elevation; what holds for a whole capture is that of `one` where it says it.

    Raises InputError where names or directions of light come twice, or where only one has a mirror sphere.
    """
    new = other.photographs[0]
    _refuse_twice(new, [path.name for path in (*_files(one), *_files(other))])
    if (one.sphere is None) != (other.sphere is None):
        raise InputError(new.parent, "has its lights from another source", "Open it as a project of its own")
    if "assumed" in (one.angle_source, other.angle_source):
        both = find([*_files(one), *_files(other), *_frames(one, other)])
        return replace(both, unpacked=_unpack(one, other))
    if bool(one.crossed) != bool(other.crossed):
        problem = "has pairs under polarisers, and the other photographs have none"
        raise InputError((new if other.crossed else one.photographs[0]).parent, problem, "Open it by itself")
    order = np.argsort([*one.elevation, *other.elevation], kind="stable")
    elevation = np.concatenate([one.elevation, other.elevation])[order]
    azimuth = _azimuth(one, other, order)
    photographs = _order(order, one.photographs, other.photographs)
    both_state = bool(one.lamp_gains) and bool(other.lamp_gains)  # else intensities of some lamps are not known
    if one.sphere is None:
        _refuse_one_light(photographs, elevation, azimuth)
    return replace(
        one,
        photographs=photographs,
        elevation=elevation,
        azimuth=azimuth,
        exposure_s=_order(order, one.exposure_s, other.exposure_s),
        exposures=_order(order, one.exposures, other.exposures),
        highlights_px=_order(order, one.highlights_px, other.highlights_px),
        dark=one.dark or other.dark,
        flat=one.flat or other.flat,
        lamp_distance=one.lamp_distance if one.lamp_distance is not None else other.lamp_distance,
        lamp_gains={**one.lamp_gains, **other.lamp_gains} if both_state else {},
        lamp_sigma={**other.lamp_sigma, **one.lamp_sigma} if both_state else {},
        reference=one.reference or other.reference,
        control_points={**one.control_points, **other.control_points},
        transfer=one.transfer or other.transfer,
        crossed={**one.crossed, **other.crossed},
        notes="\n".join(filter(None, (one.notes, other.notes))),
        unpacked=_unpack(one, other),
        findings=tuple(dict.fromkeys((*one.findings, *other.findings))),
    )


def _files(sources: Sources) -> list[Path]:
    return [exposure.path for light in sources.exposures for exposure in light]


def _frames(one: Sources, other: Sources) -> list[Path]:
    """Calibration frames, each kind once."""
    return [path for path in (one.dark or other.dark, one.flat or other.flat) if path is not None]


def _order(order: NDArray[np.int_], one: tuple[Any, ...], other: tuple[Any, ...]) -> tuple[Any, ...]:
    both = (*one, *other)
    return tuple(both[at] for at in order)


def _azimuth(one: Sources, other: Sources, order: NDArray[np.int_]) -> NDArray[np.float64] | None:
    """None unless both know it."""
    if one.azimuth is None or other.azimuth is None:
        return None
    return np.concatenate([one.azimuth, other.azimuth])[order]


def _unpack(one: Sources, other: Sources) -> Unpacked | None:
    """The archive of the one that came from one; of two archives neither holds all photographs."""
    found = [each.unpacked for each in (one, other) if each.unpacked is not None]
    return found[0] if len(found) == 1 else None


def _refuse_twice(place: Path, names: list[str]) -> None:
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        problem = f"holds photographs that are there already, or that are called the same: {join_names(twice)}"
        raise InputError(place.parent, problem, "Leave them out, or give them other names")


def _refuse_one_light(
    photographs: tuple[Path, ...], elevation: NDArray[np.float64], azimuth: NDArray[np.float64] | None
) -> None:
    """Two photographs under one light would be one: which of them counts is for a user to say."""
    around = azimuth if azimuth is not None else np.zeros(len(elevation))
    light = surface_direction(0.5 * np.pi - elevation, around)
    apart = np.linalg.norm(light[:, None] - light[None], axis=-1) + np.eye(len(light))
    first, second = np.unravel_index(int(np.argmin(apart)), apart.shape)
    if apart[first, second] < SAME:
        names = f"{photographs[first].name} and {photographs[second].name}"
        known = None if azimuth is None else float(np.degrees(azimuth[second]))
        where = direction_text(float(np.degrees(elevation[second])), known)
        problem = f"has the light of another photograph ({names}, {where})"
        raise InputError(photographs[second], problem, "Leave one of them out, or correct its light")
