"""The compiled part of Poulin and Fournier's model; the formulas are in `engine.brdf.models.poulin_fournier`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar

Floats = NDArray[np.float64]

#: A highlight is integrated where it exceeds e to minus this, as a share of its peak.
DEPTH = 18.0


@scalar
def fill(
    wi: Floats,
    wo: Floats,
    exponent: float,
    spacing: float,
    floor: float,
    nodes: Floats,
    weights: Floats,
    diffuse_nodes: Floats,
    diffuse_weights: Floats,
    diffuse: Floats,
    highlight: Floats,
) -> None:
    """The two integrals of each pair (3, n) into diffuse and highlight (n,), without kd/π and ks (n + 2)/(2π)."""
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
        arc = _diffuse(*ends, wi[:, k], wo[:, k], diffuse_nodes, diffuse_weights)
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
def _shadow(x: float, y: float, spacing: float) -> tuple[float, float]:
    """Start of the neighbour's shadow: (cos, sin) of 2 asin √(spacing sin ε / 2) − ε, given those of ε."""
    q = min(1.0, 0.5 * spacing * y)
    cosine, sine = 1.0 - 2.0 * q, 2.0 * math.sqrt(q * (1.0 - q))
    return cosine * x + sine * y, sine * x - cosine * y


@scalar
def _smaller(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
    """The smaller of two angles in [0, π], each as (cosine, sine), by the tangents of their halves."""
    return a if a[1] * (1.0 + b[0]) <= b[1] * (1.0 + a[0]) else b


@scalar
def _half_tangent(cosine: float, sine: float) -> float:
    return sine / (1.0 + cosine)


@scalar
def _floor_share(
    ix: float, iy: float, ox: float, oy: float, right_i: bool, right_o: bool, spacing: float, floor: float, edge: float
) -> float:
    """The part of a period that is floor which both directions see."""
    reach_i = (1.0 - floor * ix) / iy if ix > floor else edge
    reach_o = (1.0 - floor * ox) / oy if ox > floor else edge
    right = max(reach_i if right_i else edge, reach_o if right_o else edge)
    left = max(edge if right_i else reach_i, edge if right_o else reach_o)
    return max(0.0, spacing - (left + right)) / spacing


@scalar
def _diffuse(low: float, high: float, wi: Floats, wo: Floats, nodes: Floats, weights: Floats) -> float:
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
def _glossy(
    low: float, high: float, c: float, deficit: float, rise: float, exponent: float, nodes: Floats, weights: Floats
) -> float:
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
