"""Laws of spherical harmonics, wavelets, environments and their filters."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from engine.core.directions import normalize
from engine.light.cube_map import CubeMap, cube_of, mean_radiance
from engine.light.environment import EnvironmentMap, solid_angles
from engine.light.environment_file import repair
from engine.light.gaussian_prefilter import gaussian_integral, prefilter
from engine.light.sun_split import split_sun
from engine.selftest.case import Found
from engine.selftest.generated.law import SEED, SHARE, Law, Values, decades, draw, many
from engine.transport.sh.basis import evaluate
from engine.transport.sh.lighting import project
from engine.transport.sh.rotation import rotation
from engine.transport.wavelet.haar import cube_coefficients, cube_of_coefficients
from engine.transport.wavelet.quantise import BOUNDS, dequantise, encode_light, pack, quantise, unpack

#: Rows of environments, edges of cube maps, order of spherical harmonics, and widths of filters.
ROWS, EDGE, ORDER, SIGMAS = 16, 8, 8, (0.3, 1.0)


def _turn(vector: list[float]) -> np.ndarray:
    matrix: np.ndarray = Rotation.from_rotvec(vector).as_matrix()
    return matrix


def _addition(case: Values) -> Found:
    """The squares of all functions of an order add up to the same number everywhere."""
    points = normalize(np.array(case["points"]) * case["scale"])
    squares = (evaluate(15, points) ** 2).sum(axis=1)
    return float(np.abs(squares / (225.0 / (4.0 * np.pi)) - 1.0).max()), 4e-14


def _turns(case: Values) -> Found:
    one, other = (_turn(each) for each in case["turns"])
    both = rotation(ORDER, one) @ rotation(ORDER, other)
    return float(np.abs(rotation(ORDER, one @ other) - both).max()), 1e-12


def _turn_light(case: Values) -> Found:
    """A function turned by its coefficients is the function at directions turned back."""
    turn = _turn(case["turn"])
    rng = np.random.default_rng(case["seed"])
    values, points = rng.normal(size=ORDER**2), rng.normal(size=(16, 3))
    points = normalize(points)
    turned = evaluate(ORDER, points) @ (rotation(ORDER, turn) @ values)
    return float(np.abs(turned - evaluate(ORDER, points @ turn) @ values).max()), 1e-11


def _sky(case: Values) -> EnvironmentMap:
    """Noise of any size, and one texel of any other."""
    radiance = (case["sky"] * np.random.default_rng(case["seed"]).random((ROWS, 2 * ROWS, 3))).astype(np.float32)
    down, along = (min(int(share * size), size - 1) for share, size in zip(case["at"], (ROWS, 2 * ROWS), strict=True))
    radiance[down, along] = case["sun"]
    return EnvironmentMap(radiance)


def _flux(case: Values) -> Found:
    environment = _sky(case)
    rest, suns = split_sun(environment)
    even = [project(each, 1)[0] for each in (environment, rest)]
    lamp = sum(np.asarray(each.irradiance) / np.cos(each.radius / 2.0) ** 2 for each in suns) / np.sqrt(4.0 * np.pi)
    return float(np.abs((even[1] + lamp) / even[0] - 1.0).max()), 2e-6


def _cube(case: Values) -> Found:
    environment = _sky(case)
    weight = solid_angles(ROWS, 2 * ROWS)
    weight = np.broadcast_to(np.asarray(weight).reshape(ROWS, -1), (ROWS, 2 * ROWS))[..., None]
    wanted = (environment.radiance.astype(np.float64) * weight).sum(axis=(0, 1)) / weight.sum()
    return float(np.abs(mean_radiance(cube_of(environment, EDGE)) / wanted - 1.0).max()), 2e-6


def _haar(case: Values) -> Found:
    images = case["size"] * np.random.default_rng(case["seed"]).normal(size=(6, 16, 16, 3))
    coefficients = cube_coefficients(images)
    back = np.abs(cube_of_coefficients(coefficients) - images).max() / np.abs(images).max()
    energy = abs((coefficients**2).sum() / (images**2).sum() - 1.0)
    return float(max(back, energy)), 1e-14


def _codes(case: Values) -> Found:
    values = np.random.default_rng(case["seed"]).normal(size=(4, 96, 3)) * np.array(case["sizes"])
    words, peaks = quantise(values)
    off = np.abs(dequantise(words, peaks) - values.astype(np.float32)) / np.maximum(peaks[:, None], 1e-300)
    return float((off * 2.0 * np.array(BOUNDS)).max()), 1.0 + 1e-4


def _words(case: Values) -> Found:
    ranges = np.array([1024, 1024, 512])
    whole = np.clip(np.rint(np.array(case["shares"]) * 2.0 * ranges - ranges), -ranges, ranges - 1).astype(np.int64)
    return float(np.abs(unpack(pack(whole)) - whole).max()), 0.0


def _wavelet_light(case: Values) -> Found:
    environment = _sky(case)
    found = encode_light(cube_of(environment, EDGE).radiance)
    return float(not (np.isfinite(found.energy_error_rel) and found.energy_error_rel >= 0.0)), 0.0


def _repair(case: Values) -> Found:
    """Values that are not radiance after the repair, and good ones that it changes."""
    texels = np.array(case["texels"], np.float32)
    radiance = np.broadcast_to(texels[:, None], (len(texels), 4, 3)).copy()
    bad = ~np.isfinite(radiance) | (radiance < 0.0)
    repaired, left = repair(np.where(bad, np.float32(0.0), radiance), bad)
    changed = np.count_nonzero((repaired != radiance) & ~bad)
    return float(np.count_nonzero(~np.isfinite(repaired) | (repaired < 0.0)) + changed + (left < 0)), 0.0


def _integrals(case: Values) -> Found:
    """Of the unit sphere at most, and never less for a wider Gaussian."""
    integral = gaussian_integral(np.sort(case["sigmas"]))
    return float(max(integral.max() / (4.0 * np.pi) - 1.0, -np.diff(integral).min(initial=0.0), -integral.min())), 1e-12


def _even(case: Values) -> Found:
    levels = prefilter(CubeMap(np.full((6, EDGE, EDGE, 3), case["radiance"], np.float32)), SIGMAS).levels
    return max(float(np.abs(level / np.float32(case["radiance"]) - 1.0).max()) for level in levels), 1e-5


_TURN = st.lists(st.one_of(st.floats(-3.2, 3.2), decades(-15, -3)), min_size=3, max_size=3)
_SKY = draw(
    sky=decades(-3, 6), sun=st.one_of(st.just(0.0), decades(-3, 9)), at=st.tuples(SHARE, SHARE).map(list), seed=SEED
)
_POINTS = many(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3))
_TEXEL = st.lists(st.floats(width=32), min_size=3, max_size=3)

LAWS = (
    Law(
        "H2",
        "relative error of the addition theorem, order 15",
        draw(points=_POINTS, scale=decades(-100, 100)),
        _addition,
    ),
    Law("H5", "error of two rotations after each other", draw(turns=st.tuples(_TURN, _TURN).map(list)), _turns),
    Law("H7", "error of a function turned by its coefficients", draw(turn=_TURN, seed=SEED), _turn_light),
    Law("EN6", "relative change of the light by splitting suns off", _SKY, _flux),
    Law("EN4", "relative change of the light from map to cube", _SKY, _cube),
    Law("EN1", "relative error of even light after filtering", draw(radiance=decades(-20, 15)), _even),
    Law("EN5", "texels that a repair leaves bad, or changes without need", draw(texels=many(_TEXEL)), _repair),
    Law("Z1", "relative error of images after the transform and back", draw(size=decades(-9, 9), seed=SEED), _haar),
    Law(
        "Z9",
        "error of quantised coefficients, in halves of a step",
        draw(sizes=st.tuples(*[decades(-9, 9)] * 3).map(list), seed=SEED),
        _codes,
    ),
    Law(
        "Z10",
        "error of packed coefficients after unpacking",
        draw(shares=many(st.tuples(SHARE, SHARE, SHARE).map(list))),
        _words,
    ),
    Law("X6", "skies whose error in wavelets is not a number", _SKY, _wavelet_light),
    Law("G4", "error of integrals of Gaussians", draw(sigmas=many(decades(-6, 8), 2)), _integrals),
)
