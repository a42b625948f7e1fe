"""Parallel cylinders on a floor, which shadow and mask each other (Poulin and Fournier 1990, SIGGRAPH, pp. 273–282).

The surface is brushed along the tangent x: cylinders of radius 1 at distance `spacing`, their axes at height 0, stand
out of a floor at height `floor`. Cylinders and floor reflect by the modified Phong model about their own normal, and

    f = 1/(spacing n·l n·v) ∫ f_phong(n; wi, wo) (n·wi) (n·wo) ds

over what both directions see of one period of the profile, where ds is the length along it. Occlusion is exact: in
the plane across the cylinders a direction of elevation ε sees of a cylinder the angles from −ε, where the surface turns
away, to 2 asin √(spacing sin ε / 2) − ε, where the neighbour's shadow begins, and of the floor what lies beyond
(1 − floor cos ε)/sin ε of the neighbour's axis. Both are intervals, so what two directions see is one.

On the cylinder with normal angle φ, δ = φ − φ̄ from the bisector of the two directions in that plane, at which they
enclose 2 acos c, and with A the product of their lengths there, (n·wi)(n·wo) = A (c² − sin² δ), and 1 − r·wo is
((wi_x + wo_x)² + (|wi| − |wo|)²)/2 + 2 A sin² δ with the lengths in that plane. Gauss–Legendre quadrature is over
tan(φ/2) for the diffuse part, and over tan(δ/2) for the highlight where that is above e⁻¹⁸ of its peak; the relative
error is below 1e-6. Angles are kept as cosine and sine throughout, so that nothing depends on the accuracy of inverse
functions in shaders.

Light that is reflected between cylinders is left out, as in the paper. What bounds the time is the power at the nodes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.evaluate import channels, evaluate
from engine.brdf.highlight import reflects_no_more_than_it_receives
from engine.directions import Vectors
from engine.kernels import scalar
from engine.params import Colour, check, param

Floats = NDArray[np.float64]

#: Gauss–Legendre nodes within (0, 1) and their weights, for highlights and for diffuse parts; the other half mirrors.
HIGHLIGHT_NODES, HIGHLIGHT_WEIGHTS = (half[9:] for half in np.polynomial.legendre.leggauss(18))
DIFFUSE_NODES, DIFFUSE_WEIGHTS = (half[6:] for half in np.polynomial.legendre.leggauss(12))

#: A highlight is integrated where it exceeds e to minus this, as a share of its peak.
DEPTH = 18.0


@dataclass(frozen=True)
class PoulinFournier:
    """Parallel cylinders along the tangent; anisotropic, as brushed metal, satin or grooves. See the module."""

    kd: Colour = param((0.3, 0.3, 0.3), 0.0, 1.0, doc="Diffuse reflectance of cylinders and floor.")
    ks: Colour = param((0.3, 0.3, 0.3), 0.0, 1.0, doc="Strength of their highlight.")
    exponent: float = param(40.0, 1.0, 1e6, doc="Sharpness of their highlight.", slider=(1.0, 1000.0), log=True)
    spacing: float = param(
        2.5, 2.0, 20.0, doc="Distance of the axes in radii; at 2 the cylinders touch.", slider=(2, 6)
    )
    floor: float = param(0.2, 0.0, 1.0, doc="Height of the floor above the axes in radii; at 1 it hides the cylinders.")

    isotropic: ClassVar[bool] = False
    reciprocal: ClassVar[bool] = True

    def __post_init__(self) -> None:
        check(self)

    @property
    def energy_conserving(self) -> bool:
        """Each point of the profile conserves energy, and what leaves it and is blocked is not counted."""
        return reflects_no_more_than_it_receives(self.kd, self.ks)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        return evaluate(self._formula, wi, wo)

    def _formula(self, wi: Floats, wo: Floats) -> Floats:
        diffuse, highlight = np.empty((2, wi.shape[1]))
        nodes = (HIGHLIGHT_NODES, HIGHLIGHT_WEIGHTS, DIFFUSE_NODES, DIFFUSE_WEIGHTS)
        _fill(wi, wo, self.exponent, self.spacing, self.floor, *nodes, diffuse, highlight)
        lobe = (self.exponent + 2.0) / (2.0 * np.pi) * highlight
        return channels(self.kd) / np.pi * diffuse + channels(self.ks) * lobe


@scalar
def _fill(  # type: ignore[no-untyped-def]
    wi, wo, exponent, spacing, floor, nodes, weights, diffuse_nodes, diffuse_weights, diffuse, highlight
):
    """The two integrals, without kd/π and ks (n + 2)/(2π), of each pair (3, n) into diffuse and highlight (n,)."""
    edge = math.sqrt((1.0 - floor) * (1.0 + floor))
    for k in range(wi.shape[1]):
        length_i, length_o = math.hypot(wi[1, k], wi[2, k]), math.hypot(wo[1, k], wo[2, k])
        right_i, right_o = wi[1, k] >= 0.0, wo[1, k] >= 0.0
        ix, iy = abs(wi[1, k]) / length_i, wi[2, k] / length_i
        ox, oy = abs(wo[1, k]) / length_o, wo[2, k] / length_o

        # what both see of the cylinder: normal angles from −low to high, each as (cosine, sine)
        high, low = (floor, edge), (floor, edge)
        shadow_i, shadow_o = _shadow(ix, iy, spacing), _shadow(ox, oy, spacing)
        high = _smaller(_smaller(high, shadow_i if right_i else (ix, iy)), shadow_o if right_o else (ox, oy))
        low = _smaller(_smaller(low, (ix, iy) if right_i else shadow_i), (ox, oy) if right_o else shadow_o)

        # the bisector (bx, by) of the two directions, and the cosine c of half the angle between them
        mx, my = ix + ox, iy + oy
        size = math.hypot(mx, my)
        if right_i == right_o:
            c, bx, by = 0.5 * size, my / size, (mx if right_i else -mx) / size
        else:
            turn = ix * oy - iy * ox
            c, bx, by = my / size, 0.5 * size, (turn if right_i else -turn) / size
        both = length_i * length_o
        t_low = _half_tangent(low[0] * bx - low[1] * by, -low[1] * bx - low[0] * by)
        t_high = _half_tangent(high[0] * bx + high[1] * by, high[1] * bx - high[0] * by)

        across = 1.0 / (spacing * (wi[2, k] * wo[2, k]))
        flat_diffuse = _floor_share(ix, iy, ox, oy, right_i, right_o, spacing, floor, edge)
        ends = _half_tangent(low[0], -low[1]), _half_tangent(high[0], high[1])
        arc = _matt(*ends, wi[:, k], wo[:, k], diffuse_nodes, diffuse_weights)
        diffuse[k] = flat_diffuse + across * arc

        deficit = 0.5 * ((wi[0, k] + wo[0, k]) ** 2 + (length_i - length_o) ** 2)
        value = 0.0
        if deficit < 1.0:
            reach2 = min(1.0, -math.expm1(-DEPTH / exponent) * (1.0 - deficit) / (2.0 * both))
            reach = math.sqrt(reach2) / (1.0 + math.sqrt(1.0 - reach2))
            ends = max(t_low, -reach), min(t_high, reach)
            value = across * both * _glossy(*ends, c, deficit, 2.0 * both, exponent, nodes, weights)
        if flat_diffuse > 0.0:
            flat = 0.5 * ((wi[0, k] + wo[0, k]) ** 2 + (wi[1, k] + wo[1, k]) ** 2 + (wi[2, k] - wo[2, k]) ** 2)
            if flat < 1.0:
                value += flat_diffuse * math.exp(exponent * math.log1p(-flat))
        highlight[k] = value


@scalar
def _shadow(x: Any, y: Any, spacing: Any) -> Any:
    """Where the neighbour's shadow begins: (cos, sin) of 2 asin √(spacing sin ε / 2) − ε, given those of ε."""
    q = min(1.0, 0.5 * spacing * y)
    cosine, sine = 1.0 - 2.0 * q, 2.0 * math.sqrt(q * (1.0 - q))
    return cosine * x + sine * y, sine * x - cosine * y


@scalar
def _smaller(a: Any, b: Any) -> Any:
    """The smaller of two angles in [0, π], each as (cosine, sine), by the tangents of their halves."""
    return a if a[1] * (1.0 + b[0]) <= b[1] * (1.0 + a[0]) else b


@scalar
def _half_tangent(cosine: Any, sine: Any) -> Any:
    return sine / (1.0 + cosine)


@scalar
def _floor_share(  # type: ignore[no-untyped-def]
    ix, iy, ox, oy, right_i, right_o, spacing, floor, edge
):
    """The part of a period that is floor which both directions see."""
    reach_i = (1.0 - floor * ix) / iy if ix > floor else edge
    reach_o = (1.0 - floor * ox) / oy if ox > floor else edge
    right = max(reach_i if right_i else edge, reach_o if right_o else edge)
    left = max(edge if right_i else reach_i, edge if right_o else reach_o)
    return max(0.0, spacing - (left + right)) / spacing


@scalar
def _matt(low: Any, high: Any, wi: Any, wo: Any, nodes: Any, weights: Any) -> Any:
    """∫ (n·wi) (n·wo) dφ over tan(φ/2) from low to high.

    From the normal and not from the bisector: what a grazing direction sees lies near φ = 0, where n·w is small.
    """
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    total = 0.0
    for k in range(len(nodes)):
        for t in (middle - half * nodes[k], middle + half * nodes[k]):
            scale = 1.0 / (1.0 + t * t)
            cosines = (wi[1] * 2.0 * t + wi[2] * (1.0 - t * t)) * (wo[1] * 2.0 * t + wo[2] * (1.0 - t * t))
            total += weights[k] * cosines * scale * scale * scale
    return 2.0 * half * total


@scalar
def _glossy(low: Any, high: Any, c: Any, deficit: Any, rise: Any, exponent: Any, nodes: Any, weights: Any) -> Any:
    """∫ (1 − deficit − rise sin² δ)^exponent (c² − sin² δ) dδ over t = tan(δ/2) from low to high.

    log(1 − x) in place of the slower log1p(−x) is wrong by exponent · 1e-16, which the quadrature's error covers.
    """
    if not high > low:
        return 0.0
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    total = 0.0
    for k in range(len(nodes)):
        for t in (middle - half * nodes[k], middle + half * nodes[k]):
            scale = 1.0 / (1.0 + t * t)
            sine2 = 4.0 * t * t * scale * scale
            gone = deficit + rise * sine2
            if gone < 1.0:
                power = math.exp(exponent * math.log(1.0 - gone))
                total += weights[k] * power * max(c * c - sine2, 0.0) * scale
    return 2.0 * half * total
