"""Half and difference angles (Rusinkiewicz1998): pairs of directions ↔ (theta_h, phi_h, theta_d, phi_d), in radians.

h = (wi + wo) / |wi + wo| has the angles theta_h, phi_h in the surface frame; d is wi in a frame whose z is h, and has
the angles theta_d, phi_d there. Which x that frame has is convention:

    classical   the rotation Ry(−theta_h) Rz(−phi_h), undefined at h = n, where phi_h = 0 is taken
    cole        r = norm(t − (t·h) h) with t = +x (Cole2002 Eq. 1.4), undefined at h = ±t, where r → ∓n is taken

Tables (MERL and ours) use the classical one. Everything is written without acos, and differences come from wi ± wo:
theta_d = atan2(|wi − wo|, |wi + wo|), and exchanging wi and wo negates both coordinates of d exactly, so that phi_d
moves by π and a table that is folded to [0, π) is reciprocal bit for bit.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.directions import Vectors, dot, surface_direction

Frame = Literal["classical", "cole"]
Angles = NDArray[np.float64]

#: |wi + wo|² below which the two are taken as opposite, and h as the normal.
OPPOSITE = 1e-22

#: |t − (t·h) h|² below which h is taken as ±t in Cole's frame.
ALONG_TANGENT = 1e-12


class HalfDifference(NamedTuple):
    """Angles (...) in radians: theta_h, theta_d in [0, π/2] above the horizon, phi_h and phi_d in (−π, π]."""

    theta_h: Angles
    phi_h: Angles
    theta_d: Angles
    phi_d: Angles


def polar(vectors: Vectors) -> tuple[Angles, Angles]:
    """(theta from +z, phi from +x) of vectors (..., 3) of any length; phi = 0 on the axis."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    on_axis = (x == 0.0) & (y == 0.0)
    return np.arctan2(np.hypot(x, y), z), np.where(on_axis, 0.0, np.arctan2(y, np.where(on_axis, 1.0, x)))


def half_vector(wi: ArrayLike, wo: ArrayLike) -> Vectors:
    """Unit vectors (..., 3) halfway between unit directions; the normal where the two are opposite."""
    both = np.asarray(wi, np.float64) + np.asarray(wo, np.float64)
    squared = dot(both, both)[..., None]
    apart = squared > OPPOSITE
    return np.where(apart, both / np.sqrt(np.where(apart, squared, 1.0)), (0.0, 0.0, 1.0))


def classical_frame(half: ArrayLike) -> tuple[Vectors, Vectors]:
    """The axes x and y (..., 3) of the difference vector for unit `half`; along t and b where half is ±n."""
    half = np.asarray(half, np.float64)
    x, y, z = np.moveaxis(half, -1, 0)
    across = np.hypot(x, y)
    on_axis = across == 0.0
    divisor = np.where(on_axis, 1.0, across)
    cosine, sine = np.where(on_axis, 1.0, x / divisor), np.where(on_axis, 0.0, y / divisor)
    return np.stack([z * cosine, z * sine, -across], axis=-1), np.stack([-sine, cosine, np.zeros_like(z)], axis=-1)


def cole_frame(half: ArrayLike) -> tuple[Vectors, Vectors]:
    """The axes r and s = h × r (..., 3) of Cole2002 Eq. 1.4, for unit `half`.

    t − (t·h) h is (q, −h_x h_y, −h_x h_z) with q = h_y² + h_z², and its square is q. Where q < 1e-12, r is the limit
    along the arc from n: −n for h = t, +n for h = −t, made orthogonal to h.
    """
    half = np.asarray(half, np.float64)
    x, y, z = np.moveaxis(half, -1, 0)
    squared = y * y + z * z
    along = squared < ALONG_TANGENT
    towards = -np.copysign(1.0, x)
    limit = np.stack([-towards * z * x, -towards * z * y, towards * (x * x + y * y)], axis=-1)
    r = np.where(along[..., None], limit, np.stack([squared, -x * y, -x * z], axis=-1))
    r /= np.sqrt(dot(r, r))[..., None]
    return r, np.cross(half, r)


def half_difference(wi: ArrayLike, wo: ArrayLike, frame: Frame = "classical") -> HalfDifference:
    """The angles of unit directions (..., 3) that broadcast against each other."""
    wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
    both, between = wi + wo, wi - wo
    half = half_vector(wi, wo)
    x_axis, y_axis = classical_frame(half) if frame == "classical" else cole_frame(half)
    theta_h, phi_h = polar(half)
    theta_d = np.arctan2(np.sqrt(dot(between, between)), np.sqrt(dot(both, both)))
    x, y = dot(x_axis, between), dot(y_axis, between)
    same = (x == 0.0) & (y == 0.0)
    phi_d = np.where(same, 0.0, np.arctan2(y, np.where(same, 1.0, x)))
    return HalfDifference(theta_h, phi_h, theta_d, phi_d)


def directions(
    theta_h: ArrayLike, phi_h: ArrayLike, theta_d: ArrayLike, phi_d: ArrayLike, frame: Frame = "classical"
) -> tuple[Vectors, Vectors]:
    """The unit directions (wi, wo), (..., 3) each, that have these angles; either may lie below the horizon."""
    theta_h, phi_h = np.broadcast_arrays(np.asarray(theta_h, np.float64), np.asarray(phi_h, np.float64))
    half = surface_direction(theta_h, phi_h)
    if frame == "classical":
        # from the angles, because at theta_h = 0 the half vector no longer knows phi_h
        x_axis = surface_direction(theta_h + 0.5 * np.pi, phi_h)
        y_axis = surface_direction(0.5 * np.pi, phi_h + 0.5 * np.pi)
    else:
        x_axis, y_axis = cole_frame(half)
    theta_d, phi_d = np.asarray(theta_d, np.float64), np.asarray(phi_d, np.float64)
    along = np.cos(theta_d)[..., None] * half
    aside = np.sin(theta_d)[..., None] * (np.cos(phi_d)[..., None] * x_axis + np.sin(phi_d)[..., None] * y_axis)
    return along + aside, along - aside
