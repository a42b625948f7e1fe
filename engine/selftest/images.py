"""Hard cases of photographs, colours, alignment, shading maps and the power law."""

from __future__ import annotations

import numpy as np

from engine.capture.registration.pair_motion import Refused, first_shift, pyramid
from engine.core.colour import srgb_decode, srgb_encode, srgb_from_xyz, to_display8, tone_map, xyz_from_srgb
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.light.cube_map import CubeMap, mean_radiance
from engine.render.hex_tiling import grid_tiles
from engine.render.pbr import texels_at
from engine.selftest.case import Found, Question
from engine.shading.power_law import fit, power
from engine.shading.quantise import quantise
from engine.shading.shading_map import ShadingMap, interpolation_weights, target_radiance
from engine.surface.pbr_maps import PbrMaps

U64, U32 = 2.0**-53, 2.0**-24


def _codes_survive() -> Found:
    codes = np.arange(65536) / 65535.0
    back = np.rint(srgb_encode(srgb_decode(codes)) * 65535.0)
    return float(np.count_nonzero(back != np.arange(65536))), 0.0


def _break_is_smooth() -> Found:
    below, above = np.nextafter(0.04045, 0.0), np.nextafter(0.04045, 1.0)
    return float(abs(srgb_decode(above) - srgb_decode(below))), 1e-7


def _mean_of_many() -> Found:
    cube = CubeMap(np.full((6, 512, 512, 3), 0.1, np.float32))
    return float(np.abs(mean_radiance(cube) / np.float64(np.float32(0.1)) - 1.0).max()), 1e-7


def _still_image() -> Found:
    image = np.random.default_rng(0).random((96, 96)).astype(np.float32)
    levels = pyramid(image)
    matrix, _ = first_shift(levels[-1], levels, np.eye(3))
    return float(np.abs(matrix - np.eye(3)).max()), 1e-6


def _texture_is_asked_for() -> Found:
    try:
        levels = pyramid(np.full((96, 96), 0.5, np.float32))
        first_shift(levels[-1], levels, np.eye(3))
    except Refused:
        return 0.0, 0.0
    return 1.0, 0.0


def _slices_are_linear() -> Found:
    means = np.sort(np.random.default_rng(0).random(9))
    weights = interpolation_weights(means, 8)
    return float(np.abs(weights @ means - target_radiance(means.max(), 8)).max() / means.max()), 4.0 * U64


def _neighbours_bracket() -> Found:
    means = np.array([0.0, 0.02, 0.05, 0.06, 0.065, 0.3, 0.7, 0.72, 0.9, 1.0])
    weights = interpolation_weights(means, 8)
    return float(max(-weights.min(), weights.max() - 1.0, 0.0)), 0.0


def _equal_means_share() -> Found:
    weights = interpolation_weights(np.array([0.2, 0.5, 0.5, 1.0]), 6)
    return float(np.abs(weights[:, 1] - weights[:, 2]).max()), 0.0


def _map(exponents: np.ndarray) -> ShadingMap:
    share = np.linspace(0.0, 1.0, 8)
    slices = power(np.full((len(exponents), 1, 3), 0.5), exponents[:, None, None] * np.ones(3), share[:, None, None])
    return ShadingMap(slices.astype(np.float32), 1.0, share)


def _exponents_are_found() -> Found:
    wanted = np.array([0.3, 1.0, 2.0, 3.5, 5.0])
    found = drain(fit(_map(wanted))).exponent[:, 0, 0]
    return float(np.abs(found / wanted - 1.0).max()), 1e-5


def _black_texel() -> Found:
    slices = np.zeros((8, 2, 2, 3), np.float32)
    slices[:, 0, 0] = np.linspace(0.0, 1.0, 8, dtype=np.float32)[:, None]
    found = drain(fit(ShadingMap(slices, 1.0, np.linspace(0.0, 1.0, 8))))
    return float(np.abs(found.scale[1]).max() + np.abs(found.exponent[1] - 1.0).max()), 0.0


def _check_rounded_exponents() -> Found:
    whole = _map(np.linspace(0.3, 12.0, 64))
    storage = drain(quantise(drain(fit(whole)), whole, 8)).storage
    return float(storage.measured), float(storage.bound)


def _xyz_and_back() -> Found:
    rgb = np.random.default_rng(0).normal(size=(10_000, 3))
    return float(np.abs(srgb_from_xyz(xyz_from_srgb(rgb)) - rgb).max()), 1e-14


def _grey_card() -> Found:
    code = to_display8(np.full((1, 1, 3), 0.18))
    return float(np.abs(code.astype(int) - 118).max()), 1.0


def _exposures_stay_finite() -> Found:
    image = np.array([[[0.0, 1e-30, 1e9], [np.nan, np.inf, -1.0]]], np.float32)
    shown = [tone_map(image, ev, how) for ev in (-20.0, 20.0) for how in ("none", "neutral", "aces")]
    return float(sum(np.count_nonzero(~np.isfinite(each)) for each in shown)), 0.0


def _relief() -> PbrMaps:
    """Smooth random relief with slopes of 0.3, of a roughness that makes it glitter."""
    size, random = 64, np.random.default_rng(1)
    frequency = np.fft.fftfreq(size)[:, None] ** 2 + np.fft.rfftfreq(size)[None] ** 2
    height = np.fft.irfft2(np.fft.rfft2(random.normal(size=(size, size))) * np.exp(-frequency / 0.0072), s=(size, size))
    down, right = (0.5 * (np.roll(height, -1, axis) - np.roll(height, 1, axis)) for axis in (0, 1))
    scale = 0.3 / np.sqrt(0.5 * (down**2 + right**2).mean())
    normal = normalize(np.dstack([-right * scale, down * scale, np.ones((size, size))])).astype(np.float32)
    plane = np.ones((size, size), np.float32)
    return PbrMaps(0.2 * np.ones((size, size, 3), np.float32), normal, 0.25 * plane, 0.0 * plane, 0.04 * plane)


def _relief_from_afar() -> Found:
    """Mean radiance of relief at every mip level, against that of all its texels."""
    maps, levels = _relief(), grid_tiles(_relief())
    size = maps.size[0]
    place = (np.arange(size) + 0.5) / size
    uv = np.stack(np.meshgrid(place, place), axis=-1).reshape(-1, 2)
    up = np.array([0.0, 0.0, 1.0])
    frame, axes = np.tile(np.eye(3), (len(uv), 1, 1)), np.tile(np.eye(3)[:2], (len(uv), 1, 1))

    def mean(detail: float, light: np.ndarray) -> float:
        texels = texels_at(levels, uv, np.full(len(uv), detail), maps)
        bent = texels.bend_frames(frame, axes, np.tile(up, (len(uv), 1)))
        wi, wo = np.einsum("nij,i->nj", bent, light), np.einsum("nij,i->nj", bent, up)
        return float(texels.product(np.arange(len(uv)), wi, wo).mean())

    worst = 0.0
    for light in (up, normalize(np.array([0.6, 0.2, 0.77]))):
        exact = mean(0.0, light)
        worst = max(worst, *(abs(mean(detail, light) / exact - 1.0) for detail in (4.0, 5.0, 6.0)))
    return worst, 0.05


QUESTIONS = (
    Question("R6", "16-bit sRGB codes that decoding and coding change", _codes_survive),
    Question("R6", "jump of sRGB where its line meets its power", _break_is_smooth),
    Question("R10", "relative error of the mean of 4.7 million equal numbers", _mean_of_many),
    Question("AL1", "shift found between a photograph and itself, in pixels", _still_image),
    Question("AL2", "photographs without texture that are aligned all the same", _texture_is_asked_for),
    Question("S1", "how far weights of photographs leave 0 … 1, where means are uneven", _neighbours_bracket),
    Question("S2", "difference of the weights of photographs of equal mean", _equal_means_share),
    Question("S7", "error of the means of slices, relative to the largest", _slices_are_linear),
    Question("P1", "relative error of exponents of exact powers", _exponents_are_found),
    Question("P2", "deviation of a texel without light from scale 0 and exponent 1", _black_texel),
    Question("P9", "error of exponents in 8 bits, in radiance, against its bound", _check_rounded_exponents),
    Question("P10", "error of the mean light of relief that is seen from afar", _relief_from_afar),
    Question("CO1", "error of linear sRGB after XYZ and back", _xyz_and_back),
    Question("CO5", "values that are not finite after tone mapping at ±20 EV", _exposures_stay_finite),
    Question("CO7", "code of a grey card of 18 %, off 118", _grey_card),
)
