"""The reflectance of PBR maps under layers: OpenPBR with what each texel has of its base, or sheen and coat of glTF.

Coat, fuzz, film and what else a texel does not say are those of one `OpenPbr` for all. The clear coat of glTF lies over
any texel, about the normal of the surface whatever the map of normals (`engine.brdf.models.clear_coat`); its sheen lies
below, about the normal of the map (`engine.brdf.models.sheen`), and about their mean where a pixel covers several:
images of relief of slopes of 0.2 and 0.5 seen from afar are then some 2 % and 10 % darker than from near.

Where a pixel covers normals that differ, the variances of their slopes are added to the squares of the widths of
OpenPBR's highlights (Olano2010), which is coarser than what maps without layers have
(`engine.surface.normal_spread`). Directions are in the frame of the normal, +z. Bound by arithmetic, some 0.6 µs a
point.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.clear_coat import coat_lobe, coat_share
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import Base, OpenPbr, base_width, coat_widths, reflect, two_widths
from engine.brdf.models.sheen import sheen
from engine.surface.metallic_roughness import reflectance
from engine.surface.pbr_maps import PbrMaps

Floats = NDArray[np.float64]

#: Largest f0 that an index of refraction stands for.
MAX_F0 = 0.9

#: Least cosine at which sheen is evaluated.
LOWEST = 1e-6

#: The normal of the surface where none bends it.
UP = np.array([0.0, 0.0, 1.0])


def reflect_layers(
    layers: OpenPbr,
    wi: Floats,
    wo: Floats,
    base_colour: ArrayLike,
    roughness: ArrayLike,
    metallic: ArrayLike,
    f0: ArrayLike,
    variance: ArrayLike = 0.0,
) -> Floats:
    """f (..., 3) in 1/sr without the cosine, 0 where a direction is below the surface.

    Parameters
    ----------
    layers : all but the base colour, metalness, roughness and index, of which its own do not count.
    wi, wo : (..., 3) unit directions that broadcast against each other.
    base_colour : (..., 3); the others are (...) or numbers.
    variance : the sum of the variances of slopes along both axes.
    """
    wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
    shape = wi.shape[:-1]
    seen = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
    light, viewer = (np.where(seen[..., None], side, UP).reshape(-1, 3).T for side in (wi, wo))
    colour = np.broadcast_to(np.asarray(base_colour, np.float64), (*shape, 3)).reshape(-1, 3).T
    each = [np.broadcast_to(np.asarray(values, np.float64), shape).ravel() for values in (roughness, metallic, f0)]
    spread = np.broadcast_to(np.asarray(variance, np.float64), shape).ravel()
    root = np.sqrt(np.minimum(each[2], MAX_F0))
    widths = _widen(two_widths(base_width(each[0], layers), layers.anisotropies[0]), spread)
    coat = _widen(coat_widths(layers), spread)
    base = Base(colour, each[1], widths, (1.0 + root) / (1.0 - root))
    value = reflect(layers, light, viewer, base, coat).T.reshape(*shape, 3)
    return np.asarray(np.where(seen[..., None], value, 0.0))


def reflect_maps(
    maps: PbrMaps,
    wi: Floats,
    wo: Floats,
    base_colour: ArrayLike,
    roughness: ArrayLike,
    metallic: ArrayLike,
    f0: ArrayLike,
    upright: ArrayLike = UP,
) -> Floats:
    """f times the cosine (..., 3) of texels of `maps` with these values, under its layers where it has any.

    `upright` (..., 3) is the normal of the surface in the frame of the directions, whose +z is that of the map.
    """
    cosine = np.maximum(np.asarray(wi)[..., 2:], 0.0)
    if maps.openpbr is not None:
        return reflect_layers(maps.openpbr, wi, wo, base_colour, roughness, metallic, f0) * cosine
    value = reflectance(wi, wo, base_colour, roughness, metallic, f0, maps.multiple_scattering) * cosine
    if maps.of_gltf is None:
        return value
    return cover(maps.of_gltf, value, wi, wo, upright, maps.multiple_scattering)


def cover(
    layers: MetallicRoughness,
    value: Floats,
    wi: Floats,
    wo: Floats,
    upright: ArrayLike,
    scatters_again: bool,
    length: ArrayLike = 1.0,
) -> Floats:
    """`value` (..., 3), f times the cosine of what lies below, under the sheen and the clear coat of glTF.

    Parameters
    ----------
    layers : of which sheen and coat count.
    wi, wo, upright : (..., 3) unit directions that broadcast, to the light, the viewer and along the coat's normal; the
        normal of the sheen is +z.
    length : (...) of the mean of the normals that a point covers.
    """
    if any(layers.sheen_color):
        value = _lay_sheen(layers, value, wi, wo, np.asarray(length))
    return _lay_coat(layers, value, wi, wo, upright, scatters_again) if layers.coat_weight else value


def _lay_sheen(layers: MetallicRoughness, value: Floats, wi: Floats, wo: Floats, length: Floats) -> Floats:
    wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), wo)
    both, lit = wi + wo, (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
    sine2 = (both[..., 0] ** 2 + both[..., 1] ** 2) / np.maximum(np.sum(both * both, axis=-1), 1e-12)
    light, viewer = (np.maximum(each[..., 2], LOWEST) for each in (wi, wo))
    fibres, left = sheen(light, viewer, np.minimum(sine2, 1.0), layers.sheen_roughness, max(layers.sheen_color))
    shown = np.where(lit, length * wi[..., 2] * fibres, 0.0)
    return np.asarray(left[..., None] * value + shown[..., None] * np.asarray(layers.sheen_color))


def _lay_coat(
    coat: MetallicRoughness, value: Floats, wi: Floats, wo: Floats, upright: ArrayLike, scatters_again: bool
) -> Floats:
    wi, wo, upright = np.broadcast_arrays(np.asarray(wi, np.float64), wo, upright)
    light, viewer = np.sum(wi * upright, axis=-1), np.sum(wo * upright, axis=-1)
    share = np.asarray(coat_share(viewer, coat.coat_weight))
    lit = (light > 0.0) & (viewer > 0.0)
    lobe = np.zeros(lit.shape)
    both = (wi + wo)[lit]
    aside = np.cross(upright[lit], both)
    sine2 = np.sum(aside * aside, axis=-1) / np.sum(both * both, axis=-1)
    lobe[lit] = light[lit] * coat_lobe(light[lit], viewer[lit], sine2, coat.coat_roughness, float(scatters_again))
    return np.asarray((1.0 - share)[..., None] * value + (share * lobe)[..., None])


def _widen(widths: tuple[ArrayLike, ArrayLike], variance: Floats) -> tuple[Floats, Floats]:
    along, across = (np.minimum(np.sqrt(np.square(width) + variance), 1.0) for width in widths)
    return along, across
