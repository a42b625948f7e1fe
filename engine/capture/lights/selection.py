"""Lights of a capture that an import keeps: those of one azimuth, the best arc, or a list.

A light straight above belongs to every azimuth. The arc that `Arc` means is that of the dome which a shading map is
best made of: the most lights whose elevations differ, and of equally many those that span the widest range.
Cost: none worth mentioning.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.azimuth_spread import about_azimuth
from engine.capture.lights.file_names import comparable, join_names, natural, printable
from engine.capture.lights.sources import Sources
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Verdict

#: Lights above this elevation in degrees have no azimuth worth the name.
_ABOVE_DEG = 88.0

#: Elevations in degrees that lie closer are one step of an arc.
_STEP_DEG = 2.0

#: Lights that make an arc, in elevations that differ.
_FEWEST = 3

_RANGE = re.compile(r"(\d{1,6})(?:-(\d{1,6}))?")


@dataclass(frozen=True)
class Azimuth:
    """Lights whose azimuth differs from `middle_deg` (0 = right, 90 = up) by at most `tolerance_deg`, in degrees."""

    middle_deg: float
    tolerance_deg: float = 2.5

    def __post_init__(self) -> None:
        if not -360.0 <= self.middle_deg <= 360.0 or not 0.0 <= self.tolerance_deg <= 180.0:
            raise UsageError(
                f"azimuth {self.middle_deg:g}±{self.tolerance_deg:g} is not within ±360° with a tolerance of 0° to 180°"
            )


@dataclass(frozen=True)
class Arc:
    """The lights of the best arc, whose azimuths differ from its middle by at most `tolerance_deg` degrees."""

    tolerance_deg: float = 10.0


@dataclass(frozen=True)
class Listed:
    """Lights by number from 1 in the order of the file names (3, 5-9), or by file name."""

    items: tuple[str, ...]


Selection = Azimuth | Arc | Listed


def select(sources: Sources, selection: Selection) -> Sources:
    """`sources` with the lights of `selection` alone, and a finding that says which these are.

    Raises InputError where azimuths are unknown, where fewer than two lights remain, or for an item of a list that is
    no light of the capture.
    """
    if isinstance(selection, Listed):
        kept = _by_list(sources, selection.items)
        words = "Of the list"
    else:
        azimuth, elevation = _degrees(sources)
        near = selection if isinstance(selection, Azimuth) else _best(azimuth, elevation, selection.tolerance_deg)
        kept = np.flatnonzero(_within(azimuth, elevation, near))
        words = f"Of azimuth {_words(near)}"
        if kept.size < 2:
            offset = np.abs(_turn(azimuth - near.middle_deg))
            nearest = azimuth[np.argsort(offset, kind="stable")][:3]
            there = ", ".join(f"{angle % 360:.1f}°" for angle in nearest)
            remedy = f"The nearest lights are at {there}; widen the tolerance, or choose another azimuth"
            raise InputError(_place(sources), f"has {_few(kept.size)} at azimuth {_words(near)}", remedy)
    if len(kept) < 2:
        raise InputError(_place(sources), "keeps one light of the list only", "At least two are needed")
    return _only(sources, kept, words)


def without(sources: Sources, places: NDArray[np.intp]) -> Sources:
    """`sources` without the lights at `places`."""
    return _reduce(sources, np.delete(np.arange(len(sources.photographs)), places))


def reordered(sources: Sources, order: NDArray[np.intp]) -> Sources:
    """`sources` with its lights in another order, in which their elevations rise."""
    return _reduce(sources, order)


def _only(sources: Sources, kept: NDArray[np.intp], words: str) -> Sources:
    """`sources` reduced to the lights `kept`, in rising order, and what to say about it."""
    text = f"{words}, {len(kept)} of {len(sources.photographs)} lights are used: {_elevations(sources, kept)}"
    reduced = _reduce(sources, kept)
    about = about_azimuth(reduced.azimuth)
    others = [finding for finding in reduced.findings if finding not in about]
    return dataclasses.replace(reduced, findings=(*others, Finding(Verdict.NOTE, text), *about))


def _reduce(sources: Sources, kept: NDArray[np.intp]) -> Sources:
    azimuth = None if sources.azimuth is None else sources.azimuth[kept]
    photographs = tuple(sources.photographs[index] for index in kept)
    outdated = about_azimuth(sources.azimuth)
    findings = [finding for finding in sources.findings if finding not in outdated]
    return dataclasses.replace(
        sources,
        photographs=photographs,
        elevation=sources.elevation[kept],
        azimuth=azimuth,
        exposure_s=tuple(sources.exposure_s[index] for index in kept),
        exposures=tuple(sources.exposures[index] for index in kept),
        highlights_px=tuple(sources.highlights_px[index] for index in kept) if sources.highlights_px else (),
        reference=sources.reference if sources.reference in photographs else None,
        control_points={path: pairs for path, pairs in sources.control_points.items() if path in photographs},
        findings=(*findings, *about_azimuth(azimuth)),
    )


def _elevations(sources: Sources, kept: NDArray[np.intp]) -> str:
    return "elevations " + join_names([f"{math.degrees(sources.elevation[index]):.1f}°" for index in kept], 12)


def _degrees(sources: Sources) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    if sources.azimuth is None:
        remedy = "Give an .lp file, azimuth_deg in capture.toml, or measure the lights on a mirror sphere"
        raise InputError(_place(sources), "has no azimuths to choose lights by", remedy)
    return np.degrees(sources.azimuth), np.degrees(sources.elevation)


def _place(sources: Sources) -> Path:
    return sources.photographs[0].parent


def _turn(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles in degrees brought into [-180, 180)."""
    return np.mod(angle + 180.0, 360.0) - 180.0


def _within(azimuth: NDArray[np.float64], elevation: NDArray[np.float64], near: Azimuth) -> NDArray[np.bool_]:
    """True for lights (N,) of this azimuth; 1e-6° is the rounding of angles that went through radians."""
    return (np.abs(_turn(azimuth - near.middle_deg)) <= near.tolerance_deg + 1e-6) | (elevation > _ABOVE_DEG)


def _best(azimuth: NDArray[np.float64], elevation: NDArray[np.float64], tolerance_deg: float) -> Azimuth:
    """The arc about one of the lights, and then about the middle of its lights, that has most steps of elevation."""

    def find_worthwhile(near: Azimuth) -> tuple[int, float]:
        rising = np.sort(elevation[_within(azimuth, elevation, near)])
        steps, last = 0, -math.inf
        for angle in rising:
            if angle - last >= _STEP_DEG:
                steps, last = steps + 1, angle
        return steps, round(float(rising[-1] - rising[0]), 3) if rising.size else 0.0

    sides = azimuth[elevation <= _ABOVE_DEG]
    starts = [Azimuth(float(_turn(angle)), tolerance_deg) for angle in sides] or [Azimuth(0.0, tolerance_deg)]
    start = max(starts, key=find_worthwhile)
    low = (elevation <= _ABOVE_DEG) & _within(azimuth, elevation, start)
    offsets = _turn(azimuth[low] - start.middle_deg) if low.any() else np.zeros(1)
    middle = start.middle_deg + float(offsets.min() + offsets.max()) / 2
    centred = Azimuth(round(middle % 360.0, 2), tolerance_deg)
    return centred if find_worthwhile(centred) >= find_worthwhile(start) else start


def _by_list(sources: Sources, items: Sequence[str]) -> NDArray[np.intp]:
    names = [printable(path) for path in sources.photographs]
    in_order = sorted(range(len(names)), key=lambda index: natural(names[index]))
    by_name = {comparable(name): index for index, name in enumerate(names)}
    kept: set[int] = set()
    for item in items:
        number = _RANGE.fullmatch(item)
        if comparable(item) in by_name:
            kept.add(by_name[comparable(item)])
        elif number is not None:
            first, last = int(number[1]), int(number[2] or number[1])
            if not 1 <= first <= last <= len(names):
                problem = f"has lights 1 to {len(names)}, but {item} was asked for"
                raise InputError(_place(sources), problem, "Count photographs in the order of their file names")
            kept.update(in_order[first - 1 : last])
        else:
            problem = f"has no light called {item[:80]}"
            raise InputError(_place(sources), problem, "Give file names of its photographs, or their numbers: 1,4-9")
    return np.array(sorted(kept), np.intp)


def _few(count: int) -> str:
    return "no light" if count == 0 else "one light only"


def beside(azimuth: NDArray[np.float64], elevation: NDArray[np.float64], near: Azimuth) -> NDArray[np.bool_]:
    """True for lights at these angles (N,), in radians, that are not of the azimuth."""
    return np.asarray(~_within(np.degrees(azimuth), np.degrees(elevation), near))


def arcs(
    azimuth: NDArray[np.float64], elevation: NDArray[np.float64], tolerance_deg: float = Arc.tolerance_deg
) -> list[tuple[Azimuth, NDArray[np.intp]]]:
    """The arcs of lights at these angles (N,) in radians, by rising azimuth, each with the places of its lights.

    The best arc is taken first, and then the best of what is left, while one has three elevations. A light belongs to
    one arc, one straight above to all of them.
    """
    azimuth, elevation = np.degrees(azimuth), np.degrees(elevation)
    above = elevation > _ABOVE_DEG
    left, found = ~above, []
    while left.any():
        near = _best(azimuth[left | above], elevation[left | above], tolerance_deg)
        own = left & _within(azimuth, elevation, near)
        steps = np.unique(np.round(elevation[own | above] / _STEP_DEG))
        if not own.any() or len(steps) < _FEWEST:
            break
        found.append((near, np.flatnonzero(own | above)))
        left &= ~own
    return sorted(found, key=lambda arc: arc[0].middle_deg % 360.0)


def _words(near: Azimuth) -> str:
    return f"{near.middle_deg:g}° ± {near.tolerance_deg:g}°"
