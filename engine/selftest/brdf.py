"""Hard cases of BRDFs, their coordinates, tangent frames, factorisations and four-dimensional rotations."""

from __future__ import annotations

import numpy as np

from engine.brdf.analysis import albedo
from engine.brdf.brdf import brdf_from_text
from engine.brdf.half_difference import classical_frame, cole_frame, directions, half_difference, polar
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.table import bin_centres
from engine.core.directions import normalize, surface_direction, world_from_tangent
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.homomorphic import LogSpace
from engine.factor.solvers.nonnegative import nonnegative
from engine.factor.solvers.quaternions import Pair, canonical, compose, matrix, multiply, power, unit
from engine.factor.solvers.svd import svd, symmetric
from engine.selftest.case import Found, Question

U64 = 2.0**-53

MODELS = ("ashikhmin-shirley:kd=0.3,ks=0.05,nu=10,nv=100", "ggx:kd=0.3,alpha=0.2,f0=0.04", "ward", "cook-torrance")


def _pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    theta, phi = np.arccos(1.0 - rng.random((2, count))), 2.0 * np.pi * rng.random((2, count))
    return surface_direction(theta[0], phi[0]), surface_direction(theta[1], phi[1])


def _grazing_is_finite() -> Found:
    edge = surface_direction(np.pi / 2 + np.array([-1e-8, 0.0, 1e-8])[:, None], np.linspace(0, 6, 7)[None])
    values = [brdf_from_text(text).f(edge[:, :, None, None], edge) for text in MODELS]
    return float(sum(np.count_nonzero(~np.isfinite(value)) for value in values)), 0.0


def _opposite_is_finite() -> Found:
    wi = normalize(np.array([1.0, 0.0, 1e-9]))
    values = [brdf_from_text(text).f(wi, wi * (-1.0, 1.0, 1.0)) * wi[2] for text in MODELS]
    return float(sum(np.count_nonzero(~np.isfinite(value)) for value in values)), 0.0


def _reciprocity() -> Found:
    wi, wo = _pairs(20_000)
    worst = 0.0
    for text in MODELS:
        brdf = brdf_from_text(text)
        there, back = brdf.f(wi, wo), brdf.f(wo, wi)
        worst = max(worst, float((np.abs(there - back) / np.maximum(there, 1e-300)).max()))
    return worst, 8.0 * 2.0 * U64


def _energy() -> Found:
    wi = surface_direction(np.radians(np.linspace(0.0, 89.9, 16)))
    return max(float(albedo(brdf_from_text(text), wi, count=1024).max()) for text in MODELS[:2]), 1.01


def _narrow_highlight() -> Found:
    brdf = brdf_from_text("ggx:kd=0,alpha=0.0001,f0=1")
    found = albedo(brdf, np.array([0.0, 0.0, 1.0]), count=4096)
    return float(np.abs(found - 1.0).max()), 1e-2


def _furnace() -> Found:
    """White facets under even light must vanish in it."""
    wi = surface_direction(np.radians(np.array([0.0, 40.0, 70.0, 85.0])))
    worst = 0.0
    for roughness in (0.1, 0.3, 0.5, 0.8, 1.0):
        white = MetallicRoughness((1.0, 1.0, 1.0), 1.0, roughness, 1.0)
        worst = max(worst, float(np.abs(albedo(white, wi, count=4096) - 1.0).max()))
    return worst, 0.015


def _check_positive_terms() -> Found:
    """Light below zero in non-negative terms of the BRDF of the wavelet paper."""
    brdf = brdf_from_text("ashikhmin-shirley:kd=0.5,ks=0.75,nu=10,nv=100")
    tilt, turn = (grid.ravel() for grid in np.meshgrid(np.linspace(0.0, 1.5, 16), np.linspace(0.0, 6.0, 8)))
    sides = surface_direction(tilt, turn)
    values = brdf.f(sides[:, None], sides[None])[..., 1] * sides[:, 2]
    found = nonnegative(values, 4, 0)
    product = (found.left * found.value) @ found.right.T
    return float(np.maximum(-product, 0.0).sum() / product.sum()), 0.0


def _small_half_angles() -> Found:
    theta = 10.0 ** np.linspace(-6.0, 0.0, 200)
    found = polar(surface_direction(theta, 0.3))[0]
    return float(np.abs(found / theta - 1.0).max()), 8.0 * U64


def _half_and_difference_return() -> Found:
    rng = np.random.default_rng(0)
    theta_h, theta_d = rng.uniform(1e-3, 1.5, (2, 20_000))
    phi_h, phi_d = rng.uniform(-3.0, 3.0, (2, 20_000))
    found = half_difference(*directions(theta_h, phi_h, theta_d, phi_d))
    worst = [np.abs(found.theta_h - theta_h), np.abs(found.phi_h - phi_h), np.abs(found.theta_d - theta_d)]
    return float(np.max(worst)), 1e-12


def _frames_of_half_vectors() -> Found:
    half = np.array([[0, 0, 1.0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [1e-9, 0, 1]])
    half = normalize(half)
    worst = 0.0
    for frame in (classical_frame, cole_frame):
        axes = np.stack([*frame(half), half], axis=-1)
        worst = max(worst, float(np.abs(np.swapaxes(axes, -1, -2) @ axes - np.eye(3)).max()))
    return worst, 4.0 * 2.0 * U64


def _bins_are_their_own() -> Found:
    theta_h, theta_d, phi_d = bin_centres((90, 90, 180))
    index = np.sqrt(theta_h / (0.5 * np.pi)) * 90, theta_d / (0.5 * np.pi) * 90, phi_d / np.pi * 180
    return float(sum(np.count_nonzero(each.astype(int) != np.arange(len(each))) for each in index)), 0.0


def _corner_texels() -> Found:
    hemisphere_maps = HemisphereMap("orthographic", 48), HemisphereMap("parabolic", 48), HemisphereMap("polar", 48)
    return float(
        sum(np.count_nonzero(~np.isfinite(hemisphere_map.directions)) for hemisphere_map in hemisphere_maps)
    ), 0.0


def _frames_at_the_pole() -> Found:
    small = np.array([0.0, 1e-12, 1e-8, 1e-4, 1e-3])
    normal = normalize(np.stack([small, -np.ones(5), 0.5 * small], axis=-1))
    frames = world_from_tangent(normal)
    return float(np.abs(np.swapaxes(frames, -1, -2) @ frames - np.eye(3)).max()), 2e-15


def _frames_turn_right() -> Found:
    normal = normalize(np.random.default_rng(0).normal(size=(20_000, 3)))
    return float(np.abs(np.linalg.det(world_from_tangent(normal)) - 1.0).max()), 2e-15


def _check_signed_values() -> Found:
    rng = np.random.default_rng(1)
    basis = np.linalg.qr(rng.normal(size=(40, 40)))[0]
    values = np.concatenate([[1.0, -1.0, 0.5], np.full(37, 0.01)])
    whole = (basis * values) @ basis.T
    return _against_best(0.5 * (whole + whole.T), 3, symmetric), 1.0 + 1e-6


def _triangular() -> Found:
    return _against_best(np.triu(np.random.default_rng(2).normal(size=(8, 8)), 1), 4, svd), 1.0 + 1e-6


def _against_best(whole: np.ndarray, terms: int, method: object) -> float:
    found = method(whole, terms)  # type: ignore[operator]
    rest = np.linalg.norm(whole - (found.left * found.value) @ found.right.T)
    return float(rest / np.linalg.norm(np.linalg.svd(whole, compute_uv=False)[terms:]))


def _rank_one() -> Found:
    found = svd(np.outer(np.arange(1.0, 13.0), np.ones(9)), 4)
    return float(np.abs(found.value[1:]).max() / found.norm), 64 * U64


def _logarithms_return() -> Found:
    value = np.abs(np.random.default_rng(0).normal(size=(5_000, 3))) * 10.0 ** np.linspace(-6, 2, 5_000)[:, None]
    value[:10] = 0.0
    space = LogSpace.of(value)
    back = space.backward(space.forward(value))
    return float((np.abs(back - value) / (value + space.epsilon * space.mean)).max()), 64 * U64


def _small_turns() -> Found:
    q = unit(np.array([1.0, 1e-10, 0.0, 0.0]))
    half = power(q, 0.5)
    return float(np.abs(multiply(half, half) - q).max()), 4.0 * U64


def _half_turns() -> Found:
    q = unit(np.array([-1.0, 1e-8, 0.0, 0.0]))
    half = power(q, 0.5)
    return float(np.abs(multiply(half, half) - q).max()), 8.0 * U64


def _many_turns() -> Found:
    step = canonical(Pair(unit(np.array([1.0, 0.1, 0.2, 0.3])), unit(np.array([1.0, -0.3, 0.1, 0.2]))))
    pair = step
    for _ in range(2_000):
        pair = compose(pair, step)
    whole = matrix(pair)
    return float(np.abs(whole @ whole.T - np.eye(4)).max()), 1e-13


QUESTIONS = (
    Question("BR1", "values at the horizon that are not finite", _grazing_is_finite),
    Question("BR3", "values of light from opposite the viewer that are not finite", _opposite_is_finite),
    Question("BR7", "error of the energy of a highlight of roughness 1e-4", _narrow_highlight),
    Question("BR9", "relative difference when light and viewer are exchanged", _reciprocity),
    Question("BR10", "largest albedo of models that keep energy, to 89.9°", _energy),
    Question("BR11", "light that white facets of any roughness lose or gain, as a share", _furnace),
    Question("M1", "relative error of half angles down to 1e-6", _small_half_angles),
    Question("M5", "error of half and difference angles there and back, in radians", _half_and_difference_return),
    Question(
        "M6", "deviation of frames of half vectors from orthonormal, at their singular places", _frames_of_half_vectors
    ),
    Question("M7", "bins of a MERL table whose middle is in another bin", _bins_are_their_own),
    Question("M9", "texels of direction maps that hold no direction", _corner_texels),
    Question("F1", "deviation of frames from orthonormal near the one singularity", _frames_at_the_pole),
    Question("F3", "deviation of the determinant of frames from 1", _frames_turn_right),
    Question("W2", "values of terms that a matrix of rank 1 does not have, relative", _rank_one),
    Question("W4", "residual of three terms with values ±1, over the least possible", _check_signed_values),
    Question("W6", "residual of four terms of a triangular matrix, over the least possible", _triangular),
    Question("W7", "light below zero in four non-negative terms, over all", _check_positive_terms),
    Question("L1", "relative error of logarithms of values there and back, zeros included", _logarithms_return),
    Question("Q1", "error of half of a turn by 1e-10, twice", _small_turns),
    Question("Q2", "error of half of a turn by nearly 360°, twice", _half_turns),
    Question("Q5", "deviation from orthogonal after 2,000 turns", _many_turns),
)
