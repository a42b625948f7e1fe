"""Normals that one pixel covers: their mean, the spread of their slopes, and the reflectance averaged over them.

A mean normal alone is smoother than the relief that it stands for; what it loses is added to the highlight (LEAN
mapping, Olano2010). The spread is the covariance S of the slopes of the normals about their mean, along the texture's
axes. GGX over Gaussian slopes is not GGX: it is close to a generalised Trowbridge–Reitz distribution

    D ∝ (1 + s·M⁻¹s / a²)^−γ,    M = α² I + 2 S,

whose height is that of GGX under a Gaussian, in closed form, and whose exponent rises from 2 without a spread to that
of a Gaussian. Its error is 1 to 4 % of the root mean square, and 12 % where all slopes lie along one line; GGX of the
width M, the usual choice, errs by up to 21 %. Two moments know nothing of slopes that are far from Gaussian: weaves and
ripples are up to 25 % too bright or too dark. Shadowing is that of the normals that reflect, their mean given the
half vector: the reflectance is averaged over normals as they are, each shaded in its own frame. Directions are in the
frame of the mean normal, normal +z. Without a spread the values are those of `engine.surface.metallic_roughness`.
Bound by arithmetic, some 0.3 µs a point.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.multiple_scattering import SMOOTHEST
from engine.surface.metallic_roughness import multiple_scattering_of

Array = NDArray[np.float64]

#: Sum of the variances of slopes below which normals are alike.
ALIKE = 1e-6

#: Least cosines between the normals that reflect and the half vector, and the viewer.
MIN_COSINE = 0.01

#: Least z of the mean normal, beyond which what is seen of the spread from above says too little.
MIN_RISE = 0.2

#: x eˣ E₁(x) above 1, and E₁(x) + ln x below (Abramowitz1964 5.1.56 and 5.1.53), highest powers first.
_ABOVE = (1.0, 8.5733287401, 18.0590169730, 8.6347608925, 0.2677737343)
_UNDER = (1.0, 9.5733223454, 25.6329561486, 21.0996530827, 3.9584969228)
_BELOW = (0.00107857, -0.00976004, 0.05519968, -0.24991055, 0.99999193, -0.57721566)


def spread_slopes(mean: Array, square: Array) -> tuple[Array, Array]:
    """Covariance xx, yy, xy (N, 3) of the slopes of normals about their mean, and the length (N,) of that mean.

    `mean` (N, 3) is the mean normal, `square` (N, 3) the means of the products xx, yy, xy of its components. The axes
    are x projected into the plane across the mean normal, and the normal times that.
    """
    length = np.linalg.norm(mean, axis=1)
    x, y, z = (mean / np.maximum(length, 1e-12)[:, None]).T
    # P has the axes' components x and y as columns, and covariances there are P C Pᵀ
    root = np.sqrt(np.maximum(1.0 - x * x, 1e-6))
    z = np.maximum(z, MIN_RISE)
    one, three, four = 1.0 / root, x * y / (z * root), root / z  # P⁻¹ = ((1/√, 0), (xy/(z√), √/z))
    xx, yy, xy = (square - np.stack([mean[:, 0] ** 2, mean[:, 1] ** 2, mean[:, 0] * mean[:, 1]], axis=1)).T
    across = one * one * xx
    along = three * three * xx + 2.0 * three * four * xy + four * four * yy
    both = one * (three * xx + four * xy)
    covariance = np.stack([np.maximum(across, 0.0), np.maximum(along, 0.0), both], axis=1)
    # of normals, whose ends lie on a sphere, to that of Gaussian slopes, which reach farther
    trace = np.minimum(covariance[:, 0] + covariance[:, 1], 1.0)
    reach = np.maximum(1.0 - trace * (2.05 - 1.9 * trace + 1.15 * trace**2), 0.15)
    return covariance / reach[:, None], length


def reflect_spread(
    wi: Array,
    wo: Array,
    base_colour: Array,
    roughness: Array,
    metallic: Array,
    f0: Array,
    spread: Array,
    length: Array,
    scatters_again: bool = False,
) -> Array:
    """f times cosine (N, 3), averaged over the normals of each point.

    `base_colour` is (N, 3), `roughness`, `metallic` and `f0` are (N,), `spread` (N, 3) and `length` (N,)
    are those of `spread_slopes`; directions are unit vectors. `scatters_again` is that of `reflectance`.
    """
    both = wi + wo
    half = both / np.maximum(np.linalg.norm(both, axis=1, keepdims=True), 1e-12)
    grazing = (1.0 - np.clip((half * wi).sum(axis=1), 0.0, 1.0)) ** 5
    metal = metallic[:, None]
    at_normal = f0[:, None] * (1.0 - metal) + base_colour * metal
    fresnel = at_normal + (1.0 - at_normal) * grazing[:, None]
    cosine = np.maximum(wi[:, 2], 0.0) * length
    diffuse = (1.0 - fresnel) * (1.0 - metal) * base_colour * (cosine / np.pi)[:, None]
    value = diffuse + fresnel * spread_lobe(wi, wo, half, roughness, spread)[:, None]
    if scatters_again:
        above, viewer = np.maximum(wi[:, 2], 0.0), np.maximum(wo[:, 2], 0.0)
        value = value + cosine[:, None] * multiple_scattering_of(above, viewer, roughness, at_normal)
    return np.asarray(value)


def spread_lobe(wi: Array, wo: Array, half: Array, roughness: Array, spread: Array) -> Array:
    """(N,) D G / (4 n·v), averaged over normals."""
    alpha2 = np.maximum(roughness, SMOOTHEST) ** 4
    xx, yy, xy = spread.T
    shown = half[:, 2] > MIN_COSINE
    slope = half[:, :2] / np.where(shown, half[:, 2], 1.0)[:, None]
    # the mean slope of the normals that reflect, S (α²/2 + S)⁻¹ s
    own = 0.5 * alpha2
    determinant = np.maximum((own + xx) * (own + yy) - xy * xy, 1e-24)
    solved = np.stack([(own + yy) * slope[:, 0] - xy * slope[:, 1], (own + xx) * slope[:, 1] - xy * slope[:, 0]])
    solved /= determinant
    reflecting = np.stack([xx * solved[0] + xy * solved[1], xy * solved[0] + yy * solved[1], np.ones(len(slope))])
    reflecting /= np.linalg.norm(reflecting, axis=0)
    # lobes about steep normals are wider in slopes
    wider2 = alpha2 / reflecting[2] ** 3
    a, b, c = wider2 + 2.0 * xx, wider2 + 2.0 * yy, 2.0 * xy
    width = np.sqrt(np.maximum(a * b - c * c, 1e-24))
    quadratic = (b * slope[:, 0] ** 2 - 2.0 * c * slope[:, 0] * slope[:, 1] + a * slope[:, 1] ** 2) / width**2
    more = np.maximum(width / wider2 - 1.0, 1e-6)
    peak = (1.0 + 1.0 / more) * lowering(1.0 / more)
    exponent = 2.0 + more * (0.88 + 1.32 / (1.0 + (more / 1.455) ** 0.618))
    distribution = peak / (np.pi * width) * (1.0 + quadratic * peak / (exponent - 1.0)) ** -exponent
    # cos⁻⁴ of the angle to the half vector, over the normals about those that reflect most
    trace = 0.5 * (xx + yy)
    left = trace * own / (own + trace) * (1.0 + 0.35 * np.sqrt(trace / own))
    facing = np.maximum((reflecting.T * half).sum(axis=1), MIN_COSINE)
    distribution *= (1.0 + 4.0 * left + 8.0 * left**2) / (facing**4 * reflecting[2] ** 3)
    light = np.maximum((reflecting.T * wi).sum(axis=1), 0.0)
    viewer = np.maximum((reflecting.T * wo).sum(axis=1), MIN_COSINE)
    value = distribution * light / (_smith(light, alpha2) * _smith(viewer, alpha2))
    return np.asarray(np.where(shown, value, 0.0))


def lowering(x: Array) -> Array:
    """1 − x eˣ E₁(x) for x > 0: the peak of GGX under a Gaussian over that of the Gaussian, to 2e-7.

    x is the ratio of their squared widths, α² / (2 σ²).
    """
    above, below = np.maximum(x, 1.0), np.minimum(x, 1.0)
    difference = np.subtract(_UNDER, _ABOVE)[1:]
    integral = np.polyval(_BELOW, below) - np.log(below)
    return np.asarray(
        np.where(x > 1.0, np.polyval(difference, above) / np.polyval(_UNDER, above), 1.0 - x * np.exp(below) * integral)
    )


def _smith(cosine: Array, alpha2: Array) -> Array:
    return np.asarray(cosine + np.sqrt(alpha2 + (1.0 - alpha2) * cosine**2))
