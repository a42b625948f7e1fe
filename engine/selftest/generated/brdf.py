"""Laws of BRDFs, their coordinates, their logarithms, decompositions and four-dimensional rotations."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from engine.brdf.analysis import albedo
from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, brdf_to_text
from engine.brdf.half_difference import directions, half_difference
from engine.core.directions import Vectors, normalize, surface_direction, world_from_tangent
from engine.core.params import Parameter, parameters
from engine.factor.homomorphic import LogSpace
from engine.factor.solvers.quaternions import Pair, compose, matrix, multiply, power, unit
from engine.factor.solvers.svd import svd
from engine.selftest.case import Found
from engine.selftest.generated.law import SEED, SHARE, Law, Values, decades, draw, many

U64 = 2.0**-53

#: Most numbers that the parameters of a model are, three for a colour.
MAX_NUMBERS = max(sum(3 if each.is_colour else 1 for each in parameters(model)) for model in MODELS.values())

#: The place of each of them within its range, from 0 to 1.
_PARAMETERS = st.lists(SHARE, min_size=MAX_NUMBERS, max_size=MAX_NUMBERS)
_MODEL = {"model": st.sampled_from(sorted(MODELS)), "shares": _PARAMETERS}

#: The cosine and the azimuth of a direction; grazing ones are drawn as often as others.
_DIRECTION = st.tuples(st.one_of(SHARE, decades(-12, -1)), st.floats(0.0, 6.3)).map(list)
_PAIRS = {"wi": many(_DIRECTION), "wo": many(_DIRECTION)}


def _brdf(case: Values) -> Brdf:
    model, shares = MODELS[case["model"]], list(case["shares"])
    values = {}
    for each in parameters(model):
        count = 3 if each.is_colour else 1
        values[each.name], shares = _value(each, shares[:count]), shares[count:]
    brdf: Brdf = model(**values)
    return brdf


def _value(of: Parameter, shares: list[float]) -> float | tuple[float, ...]:
    """From the range of the slider, by its scale."""
    low, high = max(of.slider[0], of.low), min(of.slider[1], of.high)
    by_ratio = of.log and low > 0.0
    values = [low * (high / low) ** share if by_ratio else low + (high - low) * share for share in shares]
    inside = [float(min(max(value, low), high)) for value in values]
    return tuple(inside) if of.is_colour else inside[0]


def _directions(of: list[list[float]]) -> Vectors:
    cosine, azimuth = np.array(of, np.float64).T
    return surface_direction(np.arccos(np.clip(cosine, 0.0, 1.0)), azimuth)


def _values_are_finite(case: Values) -> Found:
    value = _brdf(case).f(_directions(case["wi"])[:, None], _directions(case["wo"]))
    return float(np.count_nonzero(~np.isfinite(value) | (value < 0.0))), 0.0


def _exchange(case: Values) -> Found:
    brdf = _brdf(case)
    if not brdf.reciprocal:
        return 0.0, 0.0
    wi, wo = _directions(case["wi"])[:, None], _directions(case["wo"])
    there, back = brdf.f(wi, wo), brdf.f(wo, wi)
    return float((np.abs(there - back) / np.maximum(np.maximum(there, back), 1e-300)).max()), 1e-9


def _energy(case: Values) -> Found:
    brdf = _brdf(case)
    if not brdf.energy_conserving:
        return 0.0, 0.0
    wi = _directions([case["wi"][0]])
    return float(albedo(brdf, wi, count=1024).max()), 1.01


def _text(case: Values) -> Found:
    brdf = _brdf(case)
    return float(brdf_from_text(brdf_to_text(brdf)) != brdf), 0.0


def _frames(case: Values) -> Found:
    normal = normalize(np.array(case["normals"]) * case["scale"])
    frames = world_from_tangent(normal)
    off = np.abs(np.swapaxes(frames, -1, -2) @ frames - np.eye(3)).max()
    return float(max(off, np.abs(np.linalg.det(frames) - 1.0).max())), 2e-15


def _angles(case: Values) -> Found:
    theta_h, phi_h, theta_d, phi_d = np.array(case["angles"]).T
    theta_h, theta_d = 1e-3 + 1.5 * theta_h, 1e-3 + 1.5 * theta_d
    phi_h, phi_d = 6.0 * phi_h - 3.0, 6.0 * phi_d - 3.0
    found = half_difference(*directions(theta_h, phi_h, theta_d, phi_d))
    return float(np.max(np.abs([found.theta_h - theta_h, found.phi_h - phi_h, found.theta_d - theta_d]))), 1e-12


def _logarithms(case: Values) -> Found:
    value = np.array(case["values"], np.float64)
    if not value.mean(axis=0).max() > 0.0:
        return 0.0, 0.0
    space = LogSpace.of(value)
    back = space.backward(space.forward(value))
    return float((np.abs(back - value) / (value + space.epsilon * space.mean)).max()), 64.0 * U64


def _decomposition(case: Values) -> Found:
    """Residual after some terms, over the least possible; of values that may be equal, or differ by 1e-15."""
    values = np.sort(np.array(case["values"]))[::-1]
    rng = np.random.default_rng(case["seed"])
    left, right = (np.linalg.qr(rng.normal(size=(len(values) + more, len(values))))[0] for more in (3, 7))
    terms = max(1, int(case["share"] * len(values)))
    whole = (left * values) @ right.T
    found = svd(whole, terms)
    rest = np.linalg.norm(whole - (found.left * found.value) @ found.right.T)
    rounding = 1e-14 * float(np.linalg.norm(values))
    return float((rest + rounding) / (np.linalg.norm(values[terms:]) + rounding)), 2.0


def _cluster(case: Values) -> Found:
    figure, _ = _decomposition({**case, "values": [case["value"] * (1.0 + gap) for gap in case["gaps"]]})
    return figure, 2.0


def _half_turns(case: Values) -> Found:
    q = unit(np.array([case["w"], *case["axis"]]))
    half = power(q, 0.5)
    return float(np.abs(multiply(half, half) - q).max()), 16.0 * U64


def _rotations(case: Values) -> Found:
    pair = Pair(unit(np.array([1.0, 0, 0, 0])), unit(np.array([1.0, 0, 0, 0])))
    for s, t in case["pairs"]:
        pair = compose(pair, Pair(unit(np.array([1.0, *s])), unit(np.array([1.0, *t]))))
    whole = matrix(pair)
    return float(np.abs(whole @ whole.T - np.eye(4)).max()), 1e-13


_ANGLES = many(st.tuples(SHARE, SHARE, SHARE, SHARE).map(list))
_VECTOR = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3)
_DARK_TO_BRIGHT = st.one_of(st.just(0.0), decades(-30, 30))
_COLOUR = st.lists(_DARK_TO_BRIGHT, min_size=3, max_size=3)
_GAP = st.one_of(st.just(0.0), decades(-15, -3))

LAWS = (
    Law("BR1", "values of models that are not finite, or below 0", draw(**_MODEL, **_PAIRS), _values_are_finite),
    Law("BR9", "relative difference when light and viewer are exchanged", draw(**_MODEL, **_PAIRS), _exchange),
    Law("BR10", "largest albedo of models that keep energy", draw(**_MODEL, wi=_PAIRS["wi"]), _energy),
    Law("BR12", "models that are others after writing and reading their text", draw(**_MODEL), _text),
    Law(
        "F1",
        "deviation of tangent frames from orthonormal and right-handed",
        draw(normals=many(_VECTOR), scale=decades(-100, 100)),
        _frames,
    ),
    Law("M5", "error of half and difference angles there and back, in radians", draw(angles=_ANGLES), _angles),
    Law("L1", "relative error of logarithms there and back, zeros included", draw(values=many(_COLOUR)), _logarithms),
    Law(
        "W6",
        "residual of a decomposition, over the least possible",
        draw(values=many(decades(-12, 3), 1, 16), seed=SEED, share=SHARE),
        _decomposition,
    ),
    Law(
        "W7",
        "residual of a decomposition with nearly equal values, over the least possible",
        draw(value=decades(-3, 3), gaps=many(_GAP, 2, 16), seed=SEED, share=SHARE),
        _cluster,
    ),
    Law(
        "Q1",
        "error of half of a turn, twice",
        draw(w=st.one_of(st.floats(-1.0, -1e-3), st.floats(1e-3, 1.0)), axis=_VECTOR),
        _half_turns,
    ),
    Law(
        "Q5",
        "deviation of turns after each other from orthogonal",
        draw(pairs=many(st.tuples(_VECTOR, _VECTOR).map(list))),
        _rotations,
    ),
)
