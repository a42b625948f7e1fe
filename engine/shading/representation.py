"""The representation of a material: the shading map of one arc, or planes for lamps on several sides.

Each is judged by the photographs that it was not made of (`leave_one_out`); the one with the lesser error is taken. A
capture along one arc has no azimuth to tell apart and keeps the shading map of Kautz2004. For lamps on several sides a
shading map is judged on a grid of texels, and made of all of them only where it is taken.
"""

from __future__ import annotations

import time
from collections.abc import Collection
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from engine.capture.gamut import about_radiance_maps
from engine.capture.lights.azimuth_spread import ONE_ARC, azimuth_spread
from engine.capture.object_part import object_share
from engine.capture.stack import ImageStack
from engine.core.errors import InputError
from engine.core.figure_text import number
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Steps, part
from engine.shading.directional.moments import moments
from engine.shading.directional.outliers import outliers
from engine.shading.directional.planes import BUDGET, DirectionalMap, choose_planes, directions, project
from engine.shading.fidelity import FEWEST, Fidelity, fidelity
from engine.shading.shading_map import ShadingMap, build, check_brightest, check_light, include

Representation = Literal["auto", "shading-map", "directional"]

REPRESENTATIONS: tuple[Representation, ...] = ("auto", "shading-map", "directional")


#: Bytes of a texel of one slice: three channels in single precision.
SLICE_BYTES = 12


@dataclass(frozen=True)
class Chosen:
    """The map of a material and what was weighed.

    Attributes
    ----------
    map : the representation that was chosen.
    shown : its errors; `others` those of the candidates that were not chosen, by name.
    fit_s : seconds that its fit took.
    bytes_per_texel : of all candidates by name, before compression.
    outliers : findings about photographs that the others contradict.
    remarks : findings about light and colours that the map does not hold.
    """

    map: ShadingMap | DirectionalMap
    shown: Fidelity
    others: dict[str, Fidelity]
    fit_s: float
    bytes_per_texel: dict[str, int]
    outliers: tuple[Finding, ...] = ()
    remarks: tuple[Finding, ...] = ()

    @property
    def name(self) -> str:
        return "directional" if isinstance(self.map, DirectionalMap) else "shading-map"

    @property
    def health(self) -> Health:
        """The verdict in words, and the errors of what was chosen and of what was not."""
        knows = "the direction of the light" if self.name == "directional" else "brightness alone"
        figures: dict[str, float] = {"mean_picture_rmse_srgb8": self.shown.mean_picture}
        for name, shown in {self.name: self.shown, **self.others}.items():
            stem = name.replace("-", "_")
            figures[f"{stem}_leave_one_out_rmse_srgb8"] = shown.leave_one_out
            figures[f"{stem}_in_sample_rmse_srgb8"] = shown.in_sample
            figures[f"{stem}_bytes_per_texel"] = self.bytes_per_texel[name]
        return Health(MappingProxyType(figures), (self.shown.finding(knows), *self.outliers, *self.remarks))


def choose(
    stack: ImageStack,
    slices: int,
    *,
    excluded: Collection[str] = (),
    wanted: Representation = "auto",
    most: int = BUDGET,
) -> Steps[Chosen]:
    """The map of the photographs that are not `excluded`, in the `wanted` representation or in the better one.

    A directional map has `most` bytes a texel or fewer.
    InputError where a directional map is wanted of a stack that cannot have one, and as `build` raises it.
    """
    found = yield from _choose(stack, slices, include(stack, excluded), excluded, wanted, most)
    return replace(found, remarks=about_radiance_maps(stack.provenance, found.name == "directional"))


def _choose(
    stack: ImageStack,
    slices: int,
    used: NDArray[np.int64],
    excluded: Collection[str],
    wanted: Representation,
    most: int,
) -> Steps[Chosen]:
    if wanted == "directional":
        _check_directions(stack, used)
        return (yield from _directional(stack, used, most))
    if wanted == "shading-map" or not has_sides(stack, used):
        return (yield from _shading_map(stack, slices, used, excluded))
    check_light(stack, used)
    check_brightest(stack, used)
    shown = (yield from part(fidelity(stack, used, slices), 0.0, 0.1)).over(object_share(stack))
    planes = yield from part(_directional(stack, used, most), 0.1, 0.9)
    if planes.shown.leave_one_out < shown.leave_one_out:
        byte_counts = {**planes.bytes_per_texel, "shading-map": SLICE_BYTES * slices}
        return replace(planes, others={"shading-map": shown}, bytes_per_texel=byte_counts)
    plain = yield from part(_shading_map(stack, slices, used, excluded), 0.9, 1.0)
    byte_counts = {**plain.bytes_per_texel, **planes.bytes_per_texel}
    others = {"directional": planes.shown}
    return replace(plain, others=others, bytes_per_texel=byte_counts, outliers=planes.outliers)


def _shading_map(stack: ImageStack, slices: int, used: NDArray[np.int64], excluded: Collection[str]) -> Steps[Chosen]:
    started = time.perf_counter()
    shading_map = yield from part(build(stack, slices, excluded=excluded), 0.0, 0.6)
    fit_s = time.perf_counter() - started
    shown = (yield from part(fidelity(stack, used, slices), 0.6, 1.0)).over(object_share(stack))
    return Chosen(shading_map, shown, {}, fit_s, {"shading-map": SLICE_BYTES * len(shading_map.slices)})


def has_sides(stack: ImageStack, used: NDArray[np.int64]) -> bool:
    """True where lamps stood on several sides, and enough of them to tell."""
    return stack.azimuth is not None and len(used) >= FEWEST and azimuth_spread(stack.azimuth[used]) > ONE_ARC


def check_worth(stack: ImageStack, chosen: Chosen) -> None:
    """Raise InputError where lamps stood on several sides and the mean of their photographs shows each better."""
    if stack.azimuth is None or not chosen.shown.is_worse:
        return
    what = "the shading map" if chosen.name == "shading-map" else "a directional map"
    problem = f"{what} has a held-out error of {number(chosen.shown.leave_one_out)} 8-bit levels"
    mean = f"their mean image {number(chosen.shown.mean_picture)}"
    if chosen.name == "shading-map":
        mean += ", because the lights come from several azimuths"
        instead = "Let it choose the representation, import one arc of it (import --arc)"
    else:
        mean += ", because their lights do not explain them"
        instead = "Check the light list and the alignment"
    remedy = f"{instead}, leave out the others with --exclude, or write it all the same with --force"
    raise InputError(stack.folder or "the stack", f"{problem}, {mean}", remedy)


def _check_directions(stack: ImageStack, used: NDArray[np.int64]) -> None:
    where = stack.folder or "the stack"
    if stack.azimuth is None:
        raise InputError(where, "its lamps have no azimuth", "Import it with a light list (.lp) or a capture.toml")
    if len(used) < FEWEST:
        raise InputError(where, f"{len(used)} photographs are too few to leave one out", f"Use {FEWEST} or more")


def _directional(stack: ImageStack, used: NDArray[np.int64], most: int) -> Steps[Chosen]:
    started = time.perf_counter()
    found = yield from part(moments(stack, used), 0.0, 0.5)
    choice = yield from part(choose_planes(stack, used, found, most), 0.5, 0.6)
    # the search for outliers takes one core, and the planes take the others
    with ThreadPoolExecutor(1, thread_name_prefix="outliers") as pool:
        judged = pool.submit(outliers, directions(stack, used), found.average_channels(), choice.kernel)
        planes = yield from part(project(stack, used, found, choice), 0.6, 1.0)
    fit_s = time.perf_counter() - started
    shown = Fidelity(planes.leave_one_out, planes.in_sample, planes.mean_picture, len(used))
    about = tuple(_about_outlier(stack.sources[used[place]], ratio) for place, ratio in judged.result().items())
    return Chosen(planes, shown, {}, fit_s, {"directional": planes.bytes_per_texel}, about)


def _about_outlier(name: str, ratio: float) -> Finding:
    text = (
        f"is predicted from the others {number(ratio, 2)} times worse than is usual for a lamp there: it may have "
        "moved, or have another lamp or exposure than is stated. Look at it, and leave it out if that is so"
    )
    return Finding(Verdict.WARNING, text, name)
