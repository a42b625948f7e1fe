"""Error of an image that leaves an effect out, for each effect of a scene, in numbers and in words.

The error is the root mean square over pairs of point and view of the difference that the effect makes, over that of the
radiance (see `engine.planning.effects.radiance`): self-shadowing relative to direct light, interreflection relative to
all of it. Some hundreds of pairs know it to a tenth or a fifth, and an effect left out by mistake is worse than one
that is kept: so the larger of two weightings is reported, with and without the pairs that the surface itself hides, and
one standard error on top, between a fifth and three fifths. Where every vertex sees its whole hemisphere, and where a
BRDF or a light does not have the effect at all, the estimate is exactly 0.

A BRDF whose parameters differ over a model, as a plan looks at it: point by point, and on average.

Where a plan leaves the variation out, each parameter stands at its mean over the points of a sample, which lie as dense
as the surface, each weighted by the light that it receives: what is in the dark counts for nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.colour import luminance
from engine.core.directions import world_from_tangent
from engine.core.figure_text import number, percent
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.light.light_tree import choose_lights
from engine.planning.effects.between_vertices import Between, between_vertices
from engine.planning.effects.radiance import FEWER, Radiances, bounce, radiances
from engine.planning.effects.relative_error import relative_error, with_margin
from engine.planning.effects.sample import FINE, Sample, sample
from engine.planning.effects.simplified import albedos
from engine.scene.material import Material, auto_sigma
from engine.shading.directional.effective_light import effective_cosine
from engine.surface.layered import reflect_maps
from engine.transport.baking.spatially_varying import (
    Variation,
    check_variations,
    vertex_values,
    with_parameters,
)
from engine.transport.sh.transfer import is_diffuse


@dataclass(frozen=True, eq=False)
class Varied:
    """`brdf` with `values` (V,) of some parameters at each vertex of a model, as `variations` say."""

    brdf: Brdf
    variations: tuple[Variation, ...]
    values: Mapping[str, Array]

    def mean(self, sample: Sample) -> Mapping[str, float]:
        """Mean of each parameter over `sample`."""
        weight = measure_received(sample)
        if weight.sum() <= 0.0:
            weight = np.ones(len(weight))
        rows = sample.vertices
        means = {name: float(values[rows] @ weight / weight.sum()) for name, values in self.values.items()}
        return MappingProxyType(means)

    def at(self, vertices: NDArray[np.int64]) -> list[Brdf]:
        """The BRDF of each of `vertices`."""
        return [
            with_parameters(self.brdf, {name: float(values[vertex]) for name, values in self.values.items()})
            for vertex in vertices
        ]


def vary(mesh: Mesh, brdf: Brdf, variations: Sequence[Variation]) -> Varied:
    """The BRDF of `mesh`; ValueError for parameters that it does not have, InputError for what is not an image."""
    checked = check_variations(brdf, variations)
    values = {each.parameter: each.at(vertex_values(mesh, each.source)) for each in checked}
    return Varied(brdf, checked, MappingProxyType(values))


def measure_received(sample: Sample) -> Array:
    """(N,) luminance of the irradiance of each point."""
    normal = sample.frames[:, :, 2]
    cosine = np.maximum(normal @ sample.texels.direction.T, 0.0) * sample.visible
    total = cosine @ luminance(sample.incident)
    towards = np.maximum(normal @ sample.lamp_direction.T, 0.0) * sample.lamp_lit
    return np.asarray(total + towards @ luminance(sample.lamp_irradiance))


Array = NDArray[np.float64]
Indices = NDArray[np.int64]

#: The effects in the order in which they are reported.
EFFECTS = (
    "self-shadowing",
    "interreflection",
    "glossy",
    "anisotropy",
    "all-frequency-light",
    "sun-split",
    "mesostructure",
    "spatially-varying-gloss",
    "fresnel",
    "retro-reflection",
)

#: The order of spherical harmonics that is enough where light is of low frequency.
LOW_ORDER = 5

#: A rise towards grazing views that changes less is the noise of the albedos that tell it.
NOISE = 1e-3

#: Texels of a material, and lights, by which its mesostructure is judged.
TEXELS, LIGHTS = 64, 16


@dataclass(frozen=True)
class Estimate:
    """`error_rel` of leaving the effect out, and what was found, as a sentence with its number."""

    effect: str
    error_rel: float
    text: str


@dataclass(frozen=True, eq=False)
class Scenery:
    """A scene that has been looked at.

    Attributes
    ----------
    sample, radiances : many pairs under a coarse map of the light, with each effect and without it.
    fine, methods : fewer under a finer map, by each method.
    bounced : what other parts of the surface add to `sample`, twice with different noise.
    varied : the BRDF where it is not the same all over the model; `brdf` is then the mean of it.
    between : places between the vertices, where a camera looks at the model.
    """

    sample: Sample
    brdf: Brdf
    radiances: Radiances
    fine: Sample
    methods: Radiances
    bounced: tuple[Array, Array]
    material: Material | None = None
    varied: Varied | None = None
    between: Between | None = None

    @property
    def mean(self) -> Mapping[str, float]:
        """Values of the varying parameters in `brdf`."""
        return {} if self.varied is None else self.varied.mean(self.sample)

    @property
    def indirect(self) -> Array:
        return 0.5 * (self.bounced[0] + self.bounced[1])


def scenery(
    mesh: Mesh,
    brdf: Brdf,
    environment: EnvironmentMap,
    *,
    rotation: float = 0.0,
    ground: Ground | None = None,
    material: Material | None = None,
    variations: Sequence[Variation] = (),
    camera: Camera | None = None,
) -> Scenery:
    """Look at a scene: `mesh`, on a ground where there is one, of the BRDF `brdf`, under a rotated map.

    `variations` move parameters of the BRDF over the mesh: ValueError for those that it does not have. With a `camera`
    it is looked at in its image, else from all around.
    """
    place: dict[str, Any] = {"rotation": rotation, "ground": ground, "camera": camera}
    points, views, edge = FINE
    many = sample(mesh, environment, **place)
    fine = sample(mesh, environment, points=points, views=views, edge=edge, seed=1, brdf=brdf, **place)
    own = vary(mesh, brdf, variations) if variations else None
    if own is not None:
        brdf = with_parameters(brdf, dict(own.mean(many)))
    light = bounce(many, brdf, ground.albedo if ground else 0.0)
    between = between_vertices(many, camera, len(mesh.faces)) if camera is not None else None
    return observe_as(brdf, many, fine, light, material, own, between)


def observe_as(
    brdf: Brdf,
    many: Sample,
    fine: Sample,
    light: tuple[Array, Array],
    material: Material | None = None,
    own: Varied | None = None,
    between: Between | None = None,
) -> Scenery:
    """A scene whose samples have been taken, with the BRDF `brdf`; where it varies, points have their `own`."""
    at = [None if own is None else own.at(each.vertices) for each in (many, fine)]
    effects = radiances(many, brdf, own=at[0], methods=False)
    methods = radiances(fine, brdf, own=at[1], effects=False)
    return Scenery(many, brdf, effects, fine, methods, light, material, own, between)


@lru_cache(maxsize=8)
def estimates(scene: Scenery) -> Mapping[str, Estimate]:
    """The estimates of all effects, by name; remembered."""
    functions: tuple[Callable[[Scenery], Estimate], ...] = (
        self_shadowing,
        interreflection,
        glossy,
        anisotropy,
        all_frequency_light,
        sun_split,
        mesostructure,
        spatially_varying_gloss,
        fresnel,
        retro_reflection,
    )
    found = [function(scene) for function in functions]
    return MappingProxyType({each.effect: each for each in found})


def self_shadowing(scene: Scenery) -> Estimate:
    """Error of direct light with V = 1 everywhere."""
    looked = scene.sample
    if looked.unoccluded_fraction == 1.0:
        return Estimate("self-shadowing", 0.0, "Every vertex sees its whole hemisphere: nothing shades anything.")
    error = relative_error(scene.radiances.unshadowed, scene.radiances.full, looked.shares)
    text = (
        f"{percent(1.0 - looked.unoccluded_fraction)} of the vertices see less than their hemisphere, on average "
        f"{percent(looked.open_share)} of it; without shadows the error of direct light is {percent(error)}."
    )
    return Estimate("self-shadowing", error, text)


def interreflection(scene: Scenery) -> Estimate:
    """Error of all light without what has met the surface before."""
    name = "interreflection"
    if scene.sample.unoccluded_fraction == 1.0:
        return Estimate(name, 0.0, "Every vertex sees its whole hemisphere: no part lights another.")
    one, other = scene.bounced
    squares = (one * other).sum(axis=-1)
    error = relative_error(
        scene.radiances.full, scene.radiances.full + scene.indirect, scene.sample.shares, difference=squares
    )
    albedo, closed = float(albedos(scene.brdf).mean.mean()), 1.0 - scene.sample.open_share
    text = (
        f"An albedo of {number(albedo)} and {percent(closed)} of the view closed by other parts: "
        f"their light is {percent(error)} of the image."
    )
    return Estimate(name, error, text)


def glossy(scene: Scenery) -> Estimate:
    """Error of the Lambertian BRDF of equal albedo."""
    if is_diffuse(scene.brdf):
        return Estimate("glossy", 0.0, "The BRDF is Lambertian: it looks the same from every side.")
    error = relative_error(scene.radiances.diffuse, scene.radiances.full, scene.sample.shares)
    return Estimate("glossy", error, f"The error of a diffuse surface of equal albedo is {percent(error)}.")


def anisotropy(scene: Scenery) -> Estimate:
    """Error of the mean over turns of both directions."""
    found = scene.radiances.unbrushed
    if found is None:
        text = "The BRDF is isotropic."
        return Estimate("anisotropy", 0.0, text)
    rows = slice(None, None, FEWER)
    error = relative_error(found[rows], scene.radiances.full[rows], [each[rows] for each in scene.sample.shares])
    return Estimate("anisotropy", error, f"The error of the mean over all azimuths is {percent(error)}.")


def all_frequency_light(scene: Scenery) -> Estimate:
    """Error of spherical harmonics of `LOW_ORDER`."""
    error = relative_error(scene.methods.spherical_harmonics[LOW_ORDER], scene.methods.full, scene.fine.shares)
    text = f"{LOW_ORDER**2} spherical harmonics of this light have an error of {percent(error)} with this BRDF."
    return Estimate("all-frequency-light", error, text)


def sun_split(scene: Scenery) -> Estimate:
    """Error of quantised wavelets of the whole map."""
    suns = scene.sample.light.suns
    if scene.methods.unsplit is None:
        return Estimate("sun-split", 0.0, "The light has no tiny source that is many times as bright as all around it.")
    error = relative_error(scene.methods.unsplit, scene.methods.full, scene.fine.shares)
    what = "One tiny bright source brings" if suns == 1 else f"{suns} tiny bright sources bring"
    share = _share_of_suns(scene.sample)
    text = f"{what} {percent(share)} of the light; left in the map, the error of the image is {percent(error)}."
    return Estimate("sun-split", error, text)


def _share_of_suns(looked: Sample) -> float:
    whole = float(luminance(looked.light.whole_cube.radiance.reshape(-1, 3)) @ looked.texels.area)
    rest = float(luminance(looked.light.cube.radiance.reshape(-1, 3)) @ looked.texels.area)
    return max(0.0, 1.0 - rest / whole) if whole > 0.0 else 0.0


def mesostructure(scene: Scenery) -> Estimate:
    """Error of the material's mean over its texels."""
    material = scene.material
    if material is None or not material.has_map:
        return Estimate("mesostructure", 0.0, "No maps of a material: every point of the surface is alike.")
    rng = np.random.default_rng(0)
    height, width = material.size
    row, column = rng.integers(height, size=TEXELS), rng.integers(width, size=TEXELS)
    lights = choose_lights(scene.sample.light.whole, LIGHTS)
    apart, whole = np.zeros(scene.sample.seen.shape), np.zeros(scene.sample.seen.shape)
    if material.pbr is not None:
        looked_up: Callable[..., Array] = _evaluate_texels
    else:
        looked_up = _directional if material.directional is not None else _evaluate_brightness
    for point, (frame, views) in enumerate(zip(scene.sample.frames, scene.sample.views, strict=True)):
        wi = lights.direction @ frame
        product = luminance(scene.brdf.f(wi[None], views[:, None])) * np.maximum(wi[:, 2], 0.0)
        looked = looked_up(scene, material, row, column, wi, views, product)
        value = np.einsum("tkjc,jc->tkc", looked.astype(np.float64), lights.irradiance)
        apart[point] = ((value - value.mean(axis=0)) ** 2).sum(axis=-1).mean(axis=0)
        whole[point] = (value**2).sum(axis=-1).mean(axis=0)
    cosine = scene.sample.shares[0]
    error = with_margin((apart * cosine).sum(axis=1), (whole * cosine).sum(axis=1), True)
    return Estimate("mesostructure", error, f"The texels of the material differ from their mean by {percent(error)}.")


def _evaluate_brightness(
    scene: Scenery, material: Material, row: Indices, column: Indices, _wi: Array, _views: Array, product: Array
) -> Array:
    """(T, V, L, 3) of texels for f cos (V, L) under lights `_wi` (L, 3), by the shading map."""
    shading = material.shading_map or material.power_law
    assert shading is not None
    sigma = material.sigma
    if sigma is None:
        sigma = auto_sigma(scene.brdf, [math.radians(each) for each in material.elevation_deg], shading.r_max)
    r = np.broadcast_to(sigma * product, (TEXELS, *product.shape))
    return np.asarray(shading.lookup(row[:, None, None], column[:, None, None], r))


def _directional(
    scene: Scenery, material: Material, row: Indices, column: Indices, wi: Array, _views: Array, product: Array
) -> Array:
    """The same by the directional map, whose texture runs along the frames of vertices here."""
    directional = material.directional
    assert directional is not None
    table = effective_cosine(scene.brdf)
    largest = table.largest if material.sigma is None else directional.r_max / material.sigma
    azimuth = np.broadcast_to(np.arctan2(wi[:, 1], wi[:, 0]), product.shape)
    cosine = table(product / (largest or 1.0), azimuth).ravel()
    texels = directional.planes[:, row, column].T
    return directional.sample(texels, cosine, azimuth.ravel()).reshape(TEXELS, *product.shape, 3)


def _evaluate_texels(
    _scene: Scenery, material: Material, row: Indices, column: Indices, wi: Array, views: Array, _product: Array
) -> Array:
    """The same by PBR maps, each texel in the frame about its normal."""
    maps = material.pbr
    assert maps is not None
    frames = world_from_tangent(maps.normal[row, column].astype(np.float64))
    light, viewer = np.einsum("tij,li->tlj", frames, wi), np.einsum("tij,vi->tvj", frames, views)
    base, roughness, metallic, f0 = (
        each[row, column][:, None, None] for each in (maps.base_colour, maps.roughness, maps.metallic, maps.f0)
    )
    upright = frames[:, None, None, 2, :]
    return reflect_maps(maps, light[:, None], viewer[:, :, None], base, roughness, metallic, f0, upright)


def spatially_varying_gloss(scene: Scenery) -> Estimate:
    """Error of parameters at their mean everywhere."""
    found = scene.radiances.even
    if found is None or scene.varied is None:
        has_maps = scene.material is not None and scene.material.pbr is not None
        text = "Texels of the maps differ: see mesostructure." if has_maps else "The surface has one BRDF."
        return Estimate("spatially-varying-gloss", 0.0, text)
    error = relative_error(found, scene.radiances.full, scene.sample.shares)
    means = " and ".join(f"{name} at its mean, {number(value, 3)}," for name, value in scene.mean.items())
    text = f"The BRDF varies over the surface; with {means} everywhere the error is {percent(error)}."
    return Estimate("spatially-varying-gloss", error, text)


def fresnel(scene: Scenery) -> Estimate:
    """Error of an albedo that stays what it is at the normal."""
    error = relative_error(scene.radiances.risen, scene.radiances.full, scene.sample.shares)
    if error < NOISE:
        return Estimate("fresnel", 0.0, "The BRDF does not rise towards grazing views.")
    text = f"Its rise towards grazing views changes the image by {percent(error)}; it costs nothing."
    return Estimate("fresnel", error, text)


def retro_reflection(scene: Scenery) -> Estimate:
    """Error of reflection towards the light's side cut to that across it."""
    found = scene.radiances.unretro
    if found is None:
        return Estimate("retro-reflection", 0.0, "Nothing is sent back towards the light more than across it.")
    error = relative_error(found, scene.radiances.full, scene.sample.shares)
    text = f"What is sent back towards the light changes the image by {percent(error)}; it costs nothing."
    return Estimate("retro-reflection", error, text)
