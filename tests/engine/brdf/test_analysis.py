"""Figures and slices against closed forms."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest

from engine.brdf.analysis import (
    MaximumAlbedo,
    ReciprocityError,
    albedo,
    conserves_energy,
    doubts,
    half_difference_slice,
    lobe,
    maximum_albedo,
    polar_slice,
    reciprocity_error,
)
from engine.brdf.brdf import brdf_from_text
from engine.core.directions import dot, surface_direction


def test_albedo_of_lambert_is_its_parameter_and_black_below_the_horizon() -> None:
    brdf = brdf_from_text("lambert:albedo=0.2/0.5/0.9")
    seen = albedo(brdf, surface_direction(np.array([0.0, 1.0, 1.57, 2.0])))
    assert seen[:3] == pytest.approx(np.broadcast_to([0.2, 0.5, 0.9], (3, 3)), rel=1e-12)
    assert seen[3].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("exponent", [5.0, 1000.0, 1e5])
def test_albedo_of_phong_at_the_normal_is_kd_plus_ks(exponent: float) -> None:
    brdf = brdf_from_text(f"phong:kd=0.2,ks=0.5,exponent={exponent}")
    assert albedo(brdf, [0.0, 0.0, 1.0]) == pytest.approx([0.7] * 3, rel=2e-3)


def test_maximum_albedo_says_where() -> None:
    grazing = maximum_albedo(brdf_from_text("ggx:kd=0.9,alpha=0.1,f0=0.04"))
    assert grazing.theta > np.radians(80)
    assert grazing.albedo[1] > 1
    normal = maximum_albedo(brdf_from_text("phong:kd=0,ks=0.5,exponent=50"))
    assert normal.theta < np.radians(40)
    assert max(normal.albedo) == pytest.approx(0.5, rel=0.01)


def test_albedo_of_one_way_data_is_what_leaves_the_surface() -> None:
    """f = 1/(pi cos(theta_o)) sends 2 units of a beam on, however it comes, while viewers may see any amount."""

    class Glowing:
        isotropic, reciprocal, energy_conserving = True, False, False

        def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
            wi, wo = np.broadcast_arrays(wi, wo)
            visible = (wi[..., 2:] > 0) & (wo[..., 2:] > 0)
            return np.where(visible, 1.0 / (np.pi * np.where(visible, wo[..., 2:], 1.0)), 0.0) * np.ones(3)

    assert albedo(cast(Any, Glowing()), surface_direction(np.array([0.2, 1.5]))) == pytest.approx(2.0, rel=0.02)


def test_albedos_of_many_beams_equal_single_albedos() -> None:
    brdf, theta = brdf_from_text("ggx:kd=0.1,alpha=0.3,f0=0.5"), np.array([0.1, 0.7, 1.4])
    assert np.array_equal(
        albedo(brdf, surface_direction(theta)), [albedo(brdf, surface_direction(angle)) for angle in theta]
    )


def test_reciprocity_error_is_zero_for_reciprocal_models_and_found_where_not() -> None:
    class OneWay:
        isotropic, reciprocal, energy_conserving = True, False, True

        def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
            wi, wo = np.broadcast_arrays(wi, wo)
            return np.where((wi[..., 2:] > 0) & (wo[..., 2:] > 0), 1.0 + wi[..., 2:], 0.0) * np.ones(3)

    assert reciprocity_error(brdf_from_text("phong:exponent=20")).largest < 1e-14
    found = reciprocity_error(cast(Any, OneWay()))
    assert 0.1 < found.rms < 0.5
    assert 0.5 < found.largest < 2 / 3


def test_polar_slice_has_its_peak_in_the_mirror_direction() -> None:
    theta, values = polar_slice(brdf_from_text("phong:kd=0,ks=0.5,exponent=500"), np.radians(30.0))
    assert np.degrees(theta[np.argmax(values[:, 0])]) == pytest.approx(30.0, abs=0.5)
    assert theta[0] == pytest.approx(-theta[-1])


def test_half_difference_slice_has_the_highlight_on_the_left_and_grazing_on_top() -> None:
    image = half_difference_slice(brdf_from_text("ggx:kd=0,alpha=0.1,f0=0.04"), 90)
    assert np.unravel_index(np.argmax(image[45:, :, 0]), (45, 90))[1] == 0
    assert image[10, 0, 0] > image[60, 0, 0]
    beyond = half_difference_slice(brdf_from_text("lambert"), 90, phi_d=0.0)
    assert beyond[0, 89].tolist() == [0.0, 0.0, 0.0]
    assert beyond[89, 0] == pytest.approx([0.5 / np.pi] * 3)


def test_lobe_covers_the_hemisphere_once() -> None:
    wo, values = lobe(brdf_from_text("phong:kd=0.5,ks=0.3,exponent=30"), 0.6, 0.4, size=(32, 48))
    assert wo.shape == values.shape == (32, 48, 3)
    assert dot(wo, wo) == pytest.approx(1.0)
    assert values[:, 0] == pytest.approx(values[:, -1])
    peak = wo.reshape(-1, 3)[np.argmax(values[..., 0])]
    assert dot(peak, surface_direction(0.6, 0.4 + np.pi)) > np.cos(np.radians(6))


def test_energy_is_conserved_where_no_albedo_exceeds_1_whatever_a_measurement_claims() -> None:
    class Measured(_Half):
        energy_conserving = False

    kept, lost = (cast(Any, Measured(albedo)) for albedo in (0.5, 1.5))
    assert conserves_energy(kept, maximum_albedo(kept, angles=3))
    assert not conserves_energy(lost, maximum_albedo(lost, angles=3))


def test_what_makes_a_measurement_doubtful_is_said_and_nothing_else() -> None:
    measured = cast(Any, _Half(0.5))
    good, bad = ReciprocityError(0.01, 0.02, 100), ReciprocityError(0.47, 1.5, 100)
    dim, bright = MaximumAlbedo((0.1, 0.2, 0.3), 0.5, 0.0), MaximumAlbedo((0.1, 1.2, 0.3), np.radians(80.0), 0.0)
    assert doubts(measured, good, dim) == []
    (words,) = doubts(measured, bad, dim)
    assert "47 %" in words
    measured.energy_conserving = False
    (words,) = doubts(measured, good, bright)
    assert "80°" in words
    assert "120 %" in words
    measured.leave_one_out = 0.99
    (words,) = doubts(measured, good, dim)
    assert "99 %" in words
    measured.leave_one_out = 0.0
    (words,) = doubts(measured, good, MaximumAlbedo((-0.035, 0.05, 0.08), 0.1, 0.0))
    assert words.startswith("-3.5 % of red light is reflected")


class _Half:
    """Reflects the same to all sides."""

    isotropic = reciprocal = energy_conserving = True

    def __init__(self, albedo: float) -> None:
        self.albedo = albedo

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        wi, wo = np.broadcast_arrays(wi, wo)
        return np.where((wi[..., 2:] > 0) & (wo[..., 2:] > 0), self.albedo / np.pi, 0.0) * np.ones(3)
