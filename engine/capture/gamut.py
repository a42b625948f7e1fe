"""Colours of a capture beyond Rec.709, and the working space in which maps of it are made.

Photographs in wide spaces, and RAW files by the matrices of their cameras, show colours that Rec.709 holds with
negative components alone. Radiance keeps them as they are. Reflectance between 0 and 1 would lose them, so that maps
are made in a wider space on request. What counts is the mean of a texel over all photographs, in which noise hardly
does.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import REC_709, REC_2020, WorkingSpace, working_space
from engine.core.figure_text import percent
from engine.core.health import Finding, Verdict

#: Choice of a user: a working space, or Rec.2020 where colours go beyond Rec.709.
SpaceChoice = Literal["rec709", "rec2020", "acescg", "auto"]
CHOICES: tuple[SpaceChoice, ...] = get_args(SpaceChoice)

#: A colour is beyond where a component is below zero by this share of the largest.
BEYOND = 0.01

#: Texels below this share of the brightest are noise.
DARKEST = 0.01

#: Shares of texels from which colours beyond Rec.709 are said, and from which they are a warning.
SAID, WARNED = 1e-3, 1e-2

#: Share of the texels that are beyond that the greatest distance leaves out.
_REST = 0.01


@dataclass(frozen=True)
class Gamut:
    """Shares of texels beyond Rec.709 and beyond the working space, and the greatest distance from Rec.709.

    `distance` is what the lowest component lacks to 0, as a share of the largest one.
    """

    beyond_rec709: float
    beyond_space: float
    distance: float


def measure_gamut(grid: NDArray[np.float32], choice: SpaceChoice) -> tuple[WorkingSpace, Gamut]:
    """The working space that `choice` makes for texels (N, T, 3) of N photographs in Rec.709, and their gamut."""
    colours = grid.mean(axis=0, dtype=np.float64)
    bright = colours.max(axis=1) > DARKEST * colours.max(initial=0.0)
    colours = colours[bright]
    outside = _distance(colours)
    beyond = float((outside > BEYOND).mean()) if len(outside) else 0.0
    if choice == "auto":
        space = REC_2020 if beyond >= SAID else REC_709
    else:
        space = working_space(choice)
    rest = _distance(colours @ space.from_rec709.T)
    farthest = float(np.quantile(outside[outside > BEYOND], 1.0 - _REST)) if beyond else 0.0
    return space, Gamut(beyond, float((rest > BEYOND).mean()) if len(rest) else 0.0, farthest)


def _distance(colours: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(-colours.min(axis=1) / np.maximum(colours.max(axis=1), 1e-12))


def gamut_record(space: WorkingSpace, gamut: Gamut) -> dict[str, Any]:
    """The record of a stack."""
    return {"working_space": space.label, "gamut": asdict(gamut)}


def gamut_text(record: Mapping[str, Any]) -> str:
    """A sentence on the record of a stack; empty where nothing lies beyond Rec.709 and that is the working space."""
    gamut = record.get("gamut")
    space = working_space(record.get("working_space") or REC_709.label)
    beyond = 0.0 if gamut is None else float(gamut["beyond_rec709"])
    if gamut is None or beyond < SAID:
        if space == REC_709:
            return ""
        return f"maps of the surface are made in {space.label}; no colours lie beyond Rec.709"
    found = f"colours of {percent(beyond)} of the texels lie beyond Rec.709, by up to {percent(gamut['distance'])}"
    if space == REC_709:
        lost = "maps of the surface clip them, unless imported with --working-space rec2020"
        return f"{found} of their largest component: {lost}"
    rest = "none" if gamut["beyond_space"] < SAID else f"{percent(gamut['beyond_space'])} of them"
    return f"{found} of their largest component; maps of the surface are made in {space.label}, beyond which lie {rest}"


def about_radiance_maps(provenance: Mapping[str, Any], of_planes: bool) -> tuple[Finding, ...]:
    """Findings on colours beyond Rec.709 in maps of radiance, which are in that space: planes, or else slices."""
    gamut = provenance.get("gamut")
    share, distance = (gamut.get(name) if isinstance(gamut, dict) else None for name in ("beyond_rec709", "distance"))
    if not isinstance(share, float) or not isinstance(distance, float) or share < SAID:
        return ()
    found = f"colours of {percent(share)} of the texels lie beyond Rec.709"
    if not of_planes:
        return (Finding(Verdict.NOTE, f"{found}: slices keep them, and a power law clips them"),)
    lost = f"planes clip them, by up to {percent(distance)} of their largest component"
    return (Finding(Verdict.WARNING if share >= WARNED else Verdict.NOTE, f"{found}: {lost}"),)


def about_gamut(space: WorkingSpace, gamut: Gamut) -> list[Finding]:
    """Findings on the colours; none where they lie within Rec.709."""
    said = gamut_text(gamut_record(space, gamut))
    lost = gamut.beyond_space if space != REC_709 else gamut.beyond_rec709
    verdict = Verdict.WARNING if lost >= WARNED else Verdict.NOTE
    return [Finding(verdict, f"{said[0].upper()}{said[1:]}")] if said else []
