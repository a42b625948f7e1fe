"""The light that a directional map is looked up with: cases that are solved by hand, and laws for every BRDF."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.colour import luminance
from engine.core.directions import surface_direction
from engine.shading.directional.effective_light import (
    SAMPLES,
    bilinear,
    effective_cosine,
    table_directions,
    weights_at,
)
from tests.engine.domes import dome_material

FALLING = ("lambert", "phong:exponent=20", "ggx:alpha=0.3", "oren-nayar", "ggx:alpha_x=0.2,alpha_y=0.5", "ward")


def test_lambert_sees_the_light_where_it_is() -> None:
    """f is constant: r over its largest is the cosine itself."""
    cosine = np.array([0.001, 0.2, 0.77, 1.0])
    assert effective_cosine(brdf_from_text("lambert"))(cosine, 1.3) == pytest.approx(cosine, rel=1e-5)


def test_a_power_of_the_cosine_is_undone() -> None:
    """Phong's highlight alone, seen from above: r = cos^(n + 1), so that the cosine is its root."""
    found = effective_cosine(brdf_from_text("phong:kd=0,ks=0.3,exponent=20"))
    assert found(np.array([0.5**21, 1e-9]), 0.0) == pytest.approx([0.5, 1e-9 ** (1.0 / 21.0)], rel=1e-4)


@pytest.mark.parametrize("text", FALLING)
def test_from_above_the_light_is_the_light(text: str) -> None:
    brdf = brdf_from_text(text)
    table = effective_cosine(brdf)
    tilt, azimuth = np.meshgrid(np.linspace(0.02, 1.45, 40), np.linspace(0.0, 6.0, 9))
    wi = surface_direction(tilt.ravel(), azimuth.ravel())
    r = luminance(brdf.f(wi, np.broadcast_to((0.0, 0.0, 1.0), wi.shape))) * wi[:, 2]
    assert (np.diff(r.reshape(9, 40), axis=1) < 0.0).all()
    found = table(r / table.largest, azimuth.ravel())
    assert np.degrees(np.arccos(found)) == pytest.approx(np.degrees(tilt.ravel()), abs=0.3)


def test_where_r_does_not_fall_the_lowest_light_of_equal_r_counts() -> None:
    """Two lobes at once cannot be told apart; the running maximum from the horizon is what can be looked up."""

    class Rising:
        isotropic = True

        def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
            return np.where(wi[:, 2:] > 0.5, 0.2, 0.5 / np.maximum(wi[:, 2:], 1e-9)) * np.ones(3)

    found = effective_cosine(Rising())  # type: ignore[arg-type]
    assert found.largest == pytest.approx(0.5)
    assert found(np.array([0.3, 1.0, 5.0]), 0.0) == pytest.approx(0.0, abs=1e-3)


def test_what_reflects_nothing_is_black() -> None:
    found = effective_cosine(brdf_from_text("lambert:albedo=0"))
    assert found.largest == 0.0
    assert (found(np.array([0.0, -1.0]), 0.0) == 0.0).all()


def test_tables_keep_the_weights_of_planes() -> None:
    directional = dome_material().directional
    assert directional is not None
    rng = np.random.default_rng(4)
    tilt, azimuth = rng.uniform(0.0, 1.5, 200), rng.uniform(-math.pi, math.pi, 200)
    exact = directional.functions(surface_direction(tilt, azimuth))
    found = weights_at(directional.table, np.cos(tilt), azimuth)
    values = directional.planes.reshape(len(directional.planes), -1).astype(float)
    codes = [each[..., 0, None] + each[..., 1:] @ values for each in (exact, found)]
    assert np.sqrt(np.mean((codes[0] - codes[1]) ** 2)) < 0.15


def test_bilinear_tables_repeat_or_end() -> None:
    table = np.arange(6.0, dtype=np.float32).reshape(2, 3, 1)
    places = np.array([0.0, 0.5, 9.0]), np.array([0.5, 2.5, 3.0])
    assert bilinear(table, *places, wrap_second=True)[:, 0] == pytest.approx([0.5, (2.0 + 0.0 + 5.0 + 3.0) / 4.0, 3.0])
    assert bilinear(table, *places)[:, 0] == pytest.approx([0.5, 3.5, 5.0])


def test_directions_of_the_table_run_from_the_normal_to_the_horizon() -> None:
    directions = table_directions()
    assert directions[0] == pytest.approx(np.broadcast_to((0.0, 0.0, 1.0), directions[0].shape))
    assert directions[-1, :, 2] == pytest.approx(0.0, abs=1e-12)
    assert directions[-1, directions.shape[1] // 4] == pytest.approx((0.0, 1.0, 0.0), abs=1e-12)
    assert len(directions) < SAMPLES
