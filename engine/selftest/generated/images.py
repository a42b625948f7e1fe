"""Laws of colours, shading maps, the power law, alignment and figures as users read them."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from engine.capture.registration.pair_motion import Refused, first_shift, pyramid
from engine.core.colour import srgb_from_xyz, to_display8, tone_map, xyz_from_srgb
from engine.core.figure_text import number, percent
from engine.core.steps import drain
from engine.selftest.case import Found
from engine.selftest.generated.law import SEED, SHARE, Law, Values, decades, draw, many
from engine.shading.power_law import fit, power
from engine.shading.quantise import quantise
from engine.shading.shading_map import ShadingMap, interpolation_weights, target_radiance

U64 = 2.0**-53

#: Slices of shading maps that are fitted.
SLICES = 8


def _weights(case: Values) -> Found:
    """Distance of weights from 0 … 1, and of the means of slices from a line, in units of the largest mean."""
    means = np.array(case["means"])
    weights = interpolation_weights(means, SLICES)
    outside = max(-weights.min(), weights.sum(axis=1).max() - 1.0, 0.0)
    line = np.abs(weights @ means - target_radiance(means.max(), SLICES)).max() / means.max()
    return float(max(outside, line)), 16.0 * U64


def _map(exponents: np.ndarray, scale: float) -> ShadingMap:
    share = np.linspace(0.0, 1.0, SLICES)
    slices = scale * power(np.ones((len(exponents), 1, 3)), exponents[:, None, None] * np.ones(3), share[:, None, None])
    return ShadingMap(slices.astype(np.float32), 1.0, share)


def _exponents(case: Values) -> Found:
    wanted = np.array(case["exponents"])
    found = drain(fit(_map(wanted, case["scale"]))).exponent[:, 0, 0]
    return float(np.abs(found / wanted - 1.0).max()), 1e-5


def _any_texel(case: Values) -> Found:
    slices = np.array(case["slices"], np.float32)[:, None, None, None] * np.ones((1, 1, 2, 3), np.float32)
    slices[0] = 0.0
    found = drain(fit(ShadingMap(slices, 1.0, np.linspace(0.0, 1.0, SLICES))))
    whole = np.stack([found.scale, found.exponent])
    return float(np.count_nonzero(~np.isfinite(whole) | (whole < 0.0))), 0.0


def _round(case: Values) -> Found:
    whole = _map(np.array(case["exponents"]), case["scale"])
    storage = drain(quantise(drain(fit(whole)), whole, 16 if case["fine"] else 8)).storage
    return float(storage.measured), float(storage.bound)


def _show(case: Values) -> Found:
    image = np.array(case["colours"], np.float32)[None]
    shown = tone_map(image, case["ev"], case["operator"])
    codes = to_display8(shown)
    return float(np.count_nonzero(~np.isfinite(shown)) + (codes.shape != shown.shape)), 0.0


def _xyz(case: Values) -> Found:
    rgb = np.array(case["colours"])
    size = np.maximum(np.abs(rgb).max(axis=-1, keepdims=True), 1e-300)
    return float((np.abs(srgb_from_xyz(xyz_from_srgb(rgb)) - rgb) / size).max()), 1e-13


def _shift(case: Values) -> Found:
    """An image of noise and the same image moved by whole pixels.

    A shift of one pixel may be taken for none: features are blurred as far, and the refinement that follows finds it.
    """
    rng = np.random.default_rng(case["seed"])
    scene = rng.random((128, 128)).astype(np.float32)
    along, down = (round(8.0 * (2.0 * share - 1.0)) for share in case["shift"])
    still, moved = scene[16:112, 16:112], scene[16 + down : 112 + down, 16 + along : 112 + along]
    try:
        matrix, _ = first_shift(
            pyramid(np.ascontiguousarray(moved))[-1], pyramid(np.ascontiguousarray(still)), np.eye(3)
        )
    except Refused:
        return 96.0, 1.0
    return float(np.hypot(*(matrix[:2, 2] - (along, down)))), 1.0


def _figures(case: Values) -> Found:
    """Figures that are off by more than the half of their second digit, and shares that are called all."""
    value = case["value"] * (-1.0 if case["negative"] else 1.0)
    read = float(number(value).replace(",", ""))
    missing = abs(1.0 - case["share"])
    is_wrong = percent(case["share"]) == "100 %" and missing >= 1e-6 and case["share"] < 1.0
    return max(abs(read / value - 1.0), float(is_wrong)), 0.0501


_ANY_NUMBER = st.floats(width=32, allow_nan=True, allow_infinity=True)
_EXPONENTS = {"exponents": many(st.floats(0.3, 5.0)), "scale": decades(-3, 3)}

LAWS = (
    Law(
        "S7",
        "distance of weights from 0 … 1, and of the means of slices from a line",
        draw(means=many(decades(-9, 9), 1, 64)),
        _weights,
    ),
    Law("P1", "relative error of exponents of exact powers", draw(**_EXPONENTS), _exponents),
    Law(
        "P2",
        "scales and exponents that are not finite or below 0",
        draw(slices=st.lists(st.one_of(st.just(0.0), decades(-30, 15)), min_size=SLICES, max_size=SLICES)),
        _any_texel,
    ),
    Law("P9", "error of rounded exponents, against its bound", draw(**_EXPONENTS, fine=st.booleans()), _round),
    Law(
        "CO5",
        "values that are not finite after tone mapping",
        draw(
            colours=many(st.lists(_ANY_NUMBER, min_size=3, max_size=3)),
            ev=st.floats(-20.0, 20.0),
            operator=st.sampled_from(["none", "neutral", "aces"]),
        ),
        _show,
    ),
    Law(
        "CO1",
        "relative error of linear sRGB after XYZ and back",
        draw(colours=many(st.lists(st.floats(-1e9, 1e9), min_size=3, max_size=3))),
        _xyz,
    ),
    Law(
        "AL1",
        "error of the first shift that is found, in pixels",
        draw(seed=SEED, shift=st.lists(SHARE, min_size=2, max_size=2)),
        _shift,
    ),
    Law(
        "N7",
        "relative error of a figure as it is printed",
        draw(value=decades(-12, 12), negative=st.booleans(), share=st.floats(0.0, 12.0)),
        _figures,
    ),
)
