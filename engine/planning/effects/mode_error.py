"""Predicted error of each setting, from a sample of a scene, before anything is baked.

Spherical harmonics of an order are the truncated sums of `engine.planning.effects.radiance`; directional lights are
summed as they are drawn; wavelets run through the factors of a bake, and through its transform and quantisation, at
some of the points, and Gaussians through its fit (`engine.planning.effects.lobe_error`). The error of the reference is
its noise, which falls with the root of the samples. Between the settings that are tried an error is a power law of the
parameter, and along a sweep it never rises, but for terms: those of an isotropic BRDF come in pairs, the sine and
cosine of a turn, and half a pair may be worse than none. By a camera, errors are what the sample says; from all around
they are raised by what so few views leave unknown. What a method cannot show (shadows of
lights that stand for an environment, light between parts of the model in wavelets) is not in these figures: the plan
adds the estimate of that effect.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.core.cached import cached_property, remember
from engine.core.directions import world_from_tangent
from engine.core.errors import UsageError
from engine.core.one_thread import one_thread
from engine.core.steps import drain
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.mesh import Mesh
from engine.planning.costs.planned import planning_of
from engine.planning.costs.setting import Setting, parameters_of
from engine.planning.effects.between_vertices import interpolation_error
from engine.planning.effects.estimates import Scenery
from engine.planning.effects.radiance import LIGHTS, ORDERS
from engine.planning.effects.relative_error import relative_error
from engine.planning.effects.sample import FINE, Sample
from engine.transport import method as transport
from engine.transport.wavelet.bake import factors_of_each
from engine.transport.wavelet.quantise import encode_light
from engine.transport.wavelet.transfer import (
    WaveletTransport,
    check_factors,
    cube_texels,
    light_maps,
    relight_transport,
    sum_signed_radiance,
    transport_vectors,
    vectors_of,
)

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

Array = NDArray[np.float64]

#: Terms and coefficients that are tried, and points at which: one in so many.
TERMS, KEPT, FEWER = (1, 2, 4, 8), (24, 96, 384), 2

#: The power by which errors of a method and of radiance between the vertices add up.
TOGETHER = 4.0

#: An error that nothing lies below: float32, packed coefficients, and tables.
FLOOR = 1e-4


@dataclass(frozen=True, eq=False)
class ModeErrors:
    """Errors of settings on one scene; `wavelet` by terms and coefficients, `coarse` of half the edge of `FINE`.

    `interpolated` is that of radiance between the vertices, where a camera looks at the model, else 0. `lights` cast no
    shadows and are compared without; in `lit` lamps do, and shadows of the rest that are missing are part of the error.
    """

    scene: Scenery
    spherical_harmonics: dict[int, float]
    lights: dict[int, float]
    coarse: float
    interpolated: float
    lit: dict[int, float] = field(default_factory=dict)

    @cached_property
    def wavelet(self) -> dict[tuple[int, int], float]:
        """Worked out when it is first asked for: the BRDF has to be factored."""
        return _wavelets(self.scene)

    def of(self, setting: Setting) -> float:
        """The error of `setting`; ValueError for a mode of which nothing is known."""
        if setting.mode in transport.names():
            return planning_of(setting.mode).error(self, setting)
        if "directions" in setting.parameters:
            return max(FLOOR, between(self.lights, setting["directions"]))
        raise ValueError(f"nothing is known of the error of {setting.mode}")

    def with_shadows(self, setting: Setting) -> float:
        """The error of a sum over directions in which lamps cast shadows."""
        return max(FLOOR, between(self.lit, setting["directions"]))

    def knows(self, mode: str) -> bool:
        """True if settings of a mode can draw the scene at all."""
        if mode in transport.names():
            return planning_of(mode).can_draw(self.scene)
        return "directions" in parameters_of(mode)


def wavelet_error(errors: ModeErrors, setting: Setting) -> float:
    """The error of terms and coefficients, and of the edge of the light's map."""
    rows = {
        terms: between({k: e for (t, k), e in errors.wavelet.items() if t == terms}, setting["coefficients"])
        for terms in TERMS
    }
    texels = errors.coarse * (0.5 * FINE[2]) / setting["cube"]
    return max(FLOOR, together(math.hypot(between(rows, setting["terms"]), texels), errors.interpolated))


def together(own: float, missed: float) -> float:
    """The error of a method and that of radiance between the vertices, which come to hardly more than the larger.

    Squares would add up if they had nothing to do with each other. But few coefficients have no highlight that a face
    could miss, and what many lack is much of what the faces miss. On generated scenes fourth powers add up.
    """
    return float((own**TOGETHER + missed**TOGETHER) ** (1.0 / TOGETHER))


@lru_cache(maxsize=8)
def mode_errors(scene: Scenery) -> ModeErrors:
    """The errors of all modes on `scene`, remembered; some 0.1 s."""
    found, shares, margin = scene.methods, _shares(scene.fine), not scene.fine.by_camera
    spherical_harmonics = {
        order: relative_error(found.spherical_harmonics[order], found.full, shares, margin=margin) for order in ORDERS
    }
    lights = {
        number: relative_error(found.lights[number], found.unshadowed, shares, margin=margin) for number in LIGHTS
    }
    lit = {
        number: relative_error(each, found.full, shares, margin=margin) for number, each in (found.lit or {}).items()
    }
    coarse = relative_error(found.coarse, found.full, shares, margin=margin)
    interpolated = interpolation_error(scene.between, scene.brdf) if scene.between is not None else 0.0
    return ModeErrors(scene, _falling(spherical_harmonics), _falling(lights), coarse, interpolated, _falling(lit))


def _shares(sample: Sample) -> tuple[Array, ...]:
    """Weights of pairs in images; from all around also equal ones, where grazing views count as in a bake's error."""
    return sample.shares if sample.by_camera else (*sample.shares, np.ones(sample.views.shape[:2]))


def _falling(errors: dict[int, float]) -> dict[int, float]:
    """The same where none is below one after it: noise of the sample apart, a larger parameter is never worse."""
    most = np.maximum.accumulate(list(errors.values())[::-1])[::-1] if errors else ()
    return {parameter: float(error) for parameter, error in zip(errors, most, strict=True)}


def between(errors: dict[int, float], parameter: float) -> float:
    """A power law between two of `errors`; beyond the last as between the last two, before the first as there."""
    parameters = sorted(errors)
    if len(parameters) == 1:
        return errors[parameters[0]]
    high = min(max(int(np.searchsorted(parameters, parameter)), 1), len(parameters) - 1)
    low = parameters[high - 1]
    one, other = max(errors[low], FLOOR), max(errors[parameters[high]], FLOOR)
    return one * (parameter / low) ** (math.log(other / one) / math.log(parameters[high] / low))


def can_be_factored(brdf: Brdf) -> bool:
    """True if wavelets take the BRDF: not factors over half and difference vectors, or too many."""
    if isinstance(brdf, SeparableFactors):
        try:
            check_factors(brdf)
        except UsageError:
            return False
    return True


@remember(16)
def factors_by_terms(brdf: Brdf) -> dict[int, SeparableFactors]:
    """The signed factors of bakes by their number of terms; non-negative ones err about as much, and take seconds."""
    return drain(factors_of_each(brdf, TERMS, signs="signed"))


def _wavelets(scene: Scenery) -> dict[tuple[int, int], float]:
    sample = scene.fine
    rows = np.arange(0, len(sample.vertices), FEWER)
    frames = compute_bake_frames(scene, rows)
    light = encode_light(sample.light.cube.radiance)
    visible = np.ascontiguousarray(sample.visible[rows], np.uint8)
    wanted, found = scene.methods.full[rows], {}
    vertices = np.repeat(np.arange(len(rows)), sample.views.shape[1])
    views = np.einsum("nji,njk,nvk->nvi", frames, sample.frames[rows], sample.views[rows]).reshape(-1, 3)
    for terms, factors in factors_by_terms(scene.brdf).items():
        for kept in KEPT:
            with one_thread():
                transport = _transport(scene, rows, frames, visible, factors, kept)
                tuples = relight_transport(transport, light) + _sum_lamps(scene, rows, frames, factors)
                signed = sum_signed_radiance(transport, tuples, views, vertices)
            value = np.maximum(signed, 0.0).reshape(wanted.shape)
            shares = [each[rows] for each in _shares(sample)]
            found[terms, kept] = relative_error(value, wanted, shares, margin=not sample.by_camera)
    for terms in TERMS:
        for kept, error in _falling({kept: found[terms, kept] for kept in KEPT}).items():
            found[terms, kept] = error
    return found


def compute_bake_frames(scene: Scenery, rows: NDArray[np.int64]) -> Array:
    """(R, 3, 3) frames in which wavelets are baked: terms cut off mid-pair turn with them, though no BRDF does."""
    along = scene.fine.frames[rows]
    return world_from_tangent(along[:, :, 2]) if scene.brdf.isotropic else along


def _transport(
    scene: Scenery,
    rows: NDArray[np.int64],
    frames: Array,
    visible: NDArray[np.uint8],
    factors: SeparableFactors,
    kept: int,
) -> WaveletTransport:
    """The wavelets of the chosen points alone, as if they were the mesh."""
    sample = scene.fine
    arrays = transport_vectors(
        frames, visible, 1, cube_texels(sample.edge), factors.hemisphere_map, light_maps(factors), kept
    )
    surface, chosen = sample.surface, sample.vertices[rows]
    some = Mesh(
        surface.positions[chosen], surface.normals[chosen], surface.uv[chosen], np.zeros((1, 3), np.int32), "sample"
    )
    transport = WaveletTransport(some, len(rows), factors, 0.0, sample.edge, vectors_of(arrays))
    object.__setattr__(transport, "frames", frames)  # cached: those of the whole mesh, with its tangents
    return transport


def _sum_lamps(scene: Scenery, rows: NDArray[np.int64], frames: Array, factors: SeparableFactors) -> Array:
    """(R, 3) what lamps add to the tuples."""
    sample = scene.fine
    total = np.zeros((len(rows), factors.terms, 3))
    for number, direction in enumerate(sample.lamp_direction):
        local = np.einsum("nij,i->nj", frames, direction)
        lit = np.flatnonzero((local[:, 2] > 0.0) & sample.lamp_lit[rows, number])
        incident = local[lit, 2:] * sample.lamp_irradiance[number]
        for k in range(factors.terms):
            total[lit, k] += factors.hemisphere_map.look_up(factors.second[k], local[lit]) * incident
    return total.reshape(-1, 3)
