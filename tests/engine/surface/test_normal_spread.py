"""Reflectance averaged over normals, against the sum over the normals themselves, and what it must be without any."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core.directions import frames_along, normalize, world_from_tangent
from engine.surface.metallic_roughness import reflectance
from engine.surface.normal_spread import lowering, reflect_spread, spread_slopes

Array = NDArray[np.float64]


def gaussian_normals(widths: tuple[float, float], turn: float = 0.0, tilt: float = 0.0) -> Array:
    """(N, 3) normals of Gaussian slopes of these deviations, turned, about a slope of `tilt` in x."""
    slopes = np.random.default_rng(4).normal(size=(40_000, 2)) * widths
    cosine, sine = np.cos(turn), np.sin(turn)
    slopes = slopes @ np.array([[cosine, sine], [-sine, cosine]]) + (tilt, 0.0)
    return normalize(np.column_stack([-slopes, np.ones(len(slopes))]))


def moments(normals: Array) -> tuple[Array, Array]:
    x, y, _ = normals.T
    return normals.mean(axis=0)[None], np.array([[(x * x).mean(), (y * y).mean(), (x * y).mean()]])


def direction(theta_deg: float, phi_deg: float) -> Array:
    theta, phi = np.radians([theta_deg, phi_deg])
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def summed(normals: Array, light: Array, viewer: Array, roughness: float, base: float) -> float:
    """The mean of what each normal reflects in its own frame."""
    frames = world_from_tangent(normals)
    wi, wo = np.einsum("nij,i->nj", frames, light), np.einsum("nij,i->nj", frames, viewer)
    values = reflectance(wi, wo, np.full(3, base), roughness, 0.0, 0.04)[:, 0] * np.maximum(wi[:, 2], 0.0)
    return float(values.mean())


def averaged(normals: Array, light: Array, viewer: Array, roughness: float, base: float) -> float:
    mean, square = moments(normals)
    spread, length = spread_slopes(mean, square)
    frame = frames_along(normalize(mean), np.array([1.0, 0.0, 0.0]))
    wi, wo = np.einsum("nij,i->nj", frame, light), np.einsum("nij,i->nj", frame, viewer)
    one = np.ones(1)
    return float(
        reflect_spread(wi, wo, base * np.ones((1, 3)), roughness * one, 0 * one, 0.04 * one, spread, length)[0, 0]
    )


def test_the_peak_of_ggx_under_a_gaussian() -> None:
    for x in (1e-6, 1e-3, 0.1, 0.5, 0.999, 1.001, 2.0, 10.0, 1e3, 1e6):
        exact = 1 - mpmath.mpf(x) * mpmath.exp(x) * mpmath.e1(x)
        assert float(lowering(np.array([x]))[0]) == pytest.approx(float(exact), rel=1e-5)


def test_normals_that_are_alike_have_no_spread() -> None:
    normal = normalize(np.array([[0.3, -0.5, 0.8]]))
    x, y, _ = normal.T
    spread, length = spread_slopes(normal, np.stack([x * x, y * y, x * y], axis=1))
    assert np.abs(spread).max() < 1e-12
    assert length == pytest.approx(1.0)


@pytest.mark.parametrize("widths", [(0.1, 0.1), (0.3, 0.3), (0.3, 0.1)])
def test_slopes_of_a_known_spread_are_told(widths: tuple[float, float]) -> None:
    """Within 6 % of the largest variance, and the length of the mean exactly."""
    spread, length = spread_slopes(*moments(gaussian_normals(widths, turn=0.5)))
    turned = np.array([[np.cos(0.5), np.sin(0.5)], [-np.sin(0.5), np.cos(0.5)]])
    expected = turned.T @ np.diag(np.square(widths)) @ turned
    found = np.array([[spread[0, 0], spread[0, 2]], [spread[0, 2], spread[0, 1]]])
    assert np.abs(found - expected).max() < 0.06 * expected.max()
    normals = gaussian_normals(widths, turn=0.5)
    assert length[0] == pytest.approx(np.linalg.norm(normals.mean(axis=0)))


@pytest.mark.parametrize(
    ("light", "viewer"),
    [((0, 0), (0, 0)), ((30, 20), (30, 200)), ((30, 20), (0, 0)), ((50, 70), (0, 0)), ((60, 0), (40, 180))],
)
@pytest.mark.parametrize("roughness", [0.25, 0.5, 0.8])
@pytest.mark.parametrize("width", [0.05, 0.15, 0.3])
def test_gaussian_slopes_reflect_as_their_sum(
    light: tuple[float, float], viewer: tuple[float, float], roughness: float, width: float
) -> None:
    """Within 5 %, 10 % beside a peak."""
    normals = gaussian_normals((width, width))
    where = direction(*light), direction(*viewer)
    exact, found = (each(normals, *where, roughness, 0.2) for each in (summed, averaged))
    assert found == pytest.approx(exact, rel=0.05 if light == viewer or width > 0.1 else 0.1)


@pytest.mark.parametrize("widths", [(0.3, 0.1), (0.2, 0.05)])
@pytest.mark.parametrize("azimuth", [0, 60, 90])
def test_uneven_slopes_about_a_leaning_normal(widths: tuple[float, float], azimuth: float) -> None:
    normals = gaussian_normals(widths, turn=0.7, tilt=0.2)
    where = direction(35, azimuth), direction(20, azimuth + 160)
    exact, found = (each(normals, *where, 0.35, 0.2) for each in (summed, averaged))
    assert found == pytest.approx(exact, rel=0.08)


def test_a_small_spread_changes_little() -> None:
    """The values go over into those of the texel itself."""
    wi, wo = normalize(np.array([[0.3, 0.1, 0.9]])), normalize(np.array([[-0.2, 0.4, 0.8]]))
    one = np.ones(1)
    plain = reflectance(wi, wo, 0.3 * np.ones((1, 3)), 0.4 * one, 0.2 * one, 0.04 * one) * wi[:, 2:]
    spread = np.array([[1e-6, 1e-6, 0.0]])
    found = reflect_spread(wi, wo, 0.3 * np.ones((1, 3)), 0.4 * one, 0.2 * one, 0.04 * one, spread, one)
    assert found == pytest.approx(plain, rel=1e-3)


def test_nothing_breaks_at_the_ends() -> None:
    """Any spread, any direction: finite and not negative."""
    random = np.random.default_rng(7)
    count = 20_000
    wi, wo = (normalize(random.normal(size=(count, 3))) for _ in range(2))
    wo[:, 2] = np.abs(wo[:, 2]) + 1e-9
    normals = normalize(random.normal(size=(count, 4, 3)) * 10.0 ** random.uniform(-4, 1, (count, 1, 1)) + (0, 0, 1))
    x, y, _ = np.moveaxis(normals, -1, 0)
    square = np.stack([(x * x).mean(axis=1), (y * y).mean(axis=1), (x * y).mean(axis=1)], axis=1)
    spread, length = spread_slopes(normals.mean(axis=1), square)
    base, (roughness, metallic, f0) = random.random((count, 3)), random.random((3, count))
    found = reflect_spread(wi, normalize(wo), base, roughness, metallic, f0, spread, length)
    assert np.isfinite(found).all()
    assert (found >= 0.0).all()
