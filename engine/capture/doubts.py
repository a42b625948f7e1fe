"""Doubts about a capture that only a user can settle: angles that nobody stated, and photographs of no use.

Those are photographs that cannot be read, and ones that show nothing (`engine.capture.empty`).

Numbers in file names are angles where a word says so (`10deg`). Bare numbers may count frames, and angles that are
assumed follow the order of names; both hold only where the light agrees: on an arc the sample receives
E sin(elevation), so the mean radiance grows with the elevation. It is enough that `RISING` of all pairs of photographs
do, because highlights and the shadow of the camera take some of it back. Of random orders of six photographs 20 in 720
pass (`test_a_random_order_rarely_passes`).
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.file_names import printable
from engine.capture.lights.light_angles import FROM_NAMES
from engine.capture.lights.selection import without
from engine.capture.lights.sources import Sources
from engine.core.colour import LUMINANCE
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict

#: Share of the pairs of photographs in which the higher lamp has to give more light.
RISING = 0.85

#: Photographs that remain without those that cannot be read: at least so many, and at least this share.
FEWEST, MAX_OF_THEM = 3, 0.75


class Doubtful(InputError):
    """A capture that a user may use all the same; `consent` names the setting of the import that says so.

    `otherwise` names another setting that would settle it too, if there is one.
    """

    def __init__(
        self, path: str | os.PathLike[str], problem: str, remedy: str, consent: str, otherwise: str = ""
    ) -> None:
        super().__init__(path, problem, remedy)
        self.consent = consent
        self.otherwise = otherwise


def check_angles(sources: Sources, images: Sequence[NDArray[np.float32]], trusted: bool) -> list[Finding]:
    """Findings about angles that nobody stated; Doubtful where the light of `images` contradicts them.

    `images` are small linear ones (h, w, 3), one for each light; a user may have said that angles are `trusted`.
    """
    from_names = any(one.verdict is Verdict.WARNING and one.text.startswith(FROM_NAMES) for one in sources.findings)
    if sources.angle_source != "assumed" and not (from_names and sources.angle_source == "file names"):
        return []
    means = np.array([float(image.mean(axis=(0, 1)) @ LUMINANCE) for image in images])
    share = rising_share(sources.elevation, means)
    origin = "read from bare numbers in the file names" if from_names else "assumed in the order of the file names"
    if share >= RISING:
        text = f"The photographs grow brighter with the elevations that were {origin}"
        return [Finding(Verdict.NOTE, f"{text}, as they do on an arc")]
    doubt = f"the photographs do not grow brighter with the elevations that were {origin}"
    if trusted:
        return [Finding(Verdict.WARNING, f"{doubt[:1].upper()}{doubt[1:]}; they were taken because a user said so")]
    problem = f"nothing says where the lamp stood, and {doubt}, as they would on an arc"
    remedy = (
        "Give the elevations in the order of the names (--angles-deg 10,20,30), add an .lp file or capture.toml, "
        "measure them on a mirror sphere (--sphere auto), estimate them (--estimate-lights), or say that these are "
        "right (--trust-angles)"
    )
    raise Doubtful(sources.photographs[0].parent, problem, remedy, "trust_angles")


def rising_share(elevation: NDArray[np.float64], means: NDArray[np.float64]) -> float:
    """Share of the pairs of different elevation in which the higher one has the larger mean; 1 where there are none."""
    higher = elevation[:, None] > elevation[None, :] + 1e-9
    rising = higher & (means[:, None] > means[None, :])
    return float(rising.sum() / higher.sum()) if higher.any() else 1.0


def without_unreadable(sources: Sources, error: InputError, of_first: int, strict: bool) -> Sources:
    """`sources` without the light of the photograph that `error` is about, and why; raises where it must not be.

    That is where `strict` refuses it, or where fewer remain of the `of_first` lights than a material needs.
    """
    path = Path(error.path)
    lit = [path in sources.files(light) for light in range(len(sources.photographs))]
    left = len(lit) - sum(lit)
    if not any(lit) or left < max(FEWEST, MAX_OF_THEM * of_first):
        raise error
    if strict:
        remedy = f"{error.remedy}, or import the other {left} photographs without it"
        raise Doubtful(path, error.problem, remedy, "leave_out") from None
    found = Finding(Verdict.WARNING, f"was excluded: it {error.problem}. {error.remedy}", printable(path))
    kept = without(sources, np.flatnonzero(lit))
    return replace(kept, findings=(*kept.findings, found))


def without_empty(sources: Sources, found: Mapping[int, tuple[str, str]], of_first: int, strict: bool) -> Sources:
    """`sources` without the lights `found` that show nothing, by place what is wrong and what to do; or themselves.

    That is where none is found, or where fewer remain of the `of_first` lights than a material needs: then all are
    used, and the report of the import tells of each. Raises Doubtful where `strict` refuses them.
    """
    left = len(sources.photographs) - len(found)
    if not found or left < max(FEWEST, MAX_OF_THEM * of_first):
        return sources
    if strict:
        place = min(found)
        problem, remedy = found[place]
        more = f", and so are {len(found) - 1} more of no use" if len(found) > 1 else ""
        remedy = f"{remedy}, import the other {left} photographs without {'it' if len(found) == 1 else 'them'}"
        raise Doubtful(
            sources.photographs[place], f"{problem}{more}", f"{remedy}, or use all of them", "leave_out", "use_all"
        )
    said = [
        Finding(Verdict.WARNING, f"was excluded: it {problem}. {remedy}", printable(sources.photographs[place]))
        for place, (problem, remedy) in sorted(found.items())
    ]
    kept = without(sources, np.array(sorted(found), np.intp))
    return replace(kept, findings=(*kept.findings, *said))
