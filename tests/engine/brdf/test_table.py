"""Tables: exact at bin centres, bound of the interpolation, reciprocity bit for bit, holes, seams and edges."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.half_difference import directions, half_difference
from engine.brdf.models.microfacet import Ggx
from engine.brdf.table import (
    DirectionTable,
    HalfDifferenceTable,
    bin_centres,
    bin_directions,
    fill_holes,
    missing_health,
    nearest,
)
from engine.core.directions import surface_direction
from tests.engine.brdf.test_half_difference import random_directions

SHAPE = (6, 5, 8)
U = np.finfo(np.float64).eps / 2


def random_table(shape: tuple[int, int, int] = SHAPE, dtype: Any = np.float64) -> HalfDifferenceTable:
    values = np.random.default_rng(0).random((*shape, 3)).astype(dtype)
    return HalfDifferenceTable(values, np.zeros(shape, bool))


def by_hand(table: HalfDifferenceTable, theta_h: float, theta_d: float, phi_d: float) -> NDArray[np.float64]:
    """The interpolation again, from its description: hat functions around every node."""
    heights, depths, turns = table.missing.shape
    nodes_h = np.r_[0.0, np.arange(heights) + 0.5]
    nodes_d = np.r_[0.0, np.arange(depths) + 0.5]
    weight_h = [np.interp(np.sqrt(theta_h / (np.pi / 2)) * heights, nodes_h, row) for row in np.eye(heights + 1)]
    weight_d = [np.interp(theta_d / (np.pi / 2) * depths, nodes_d, row) for row in np.eye(depths + 1)]
    turn = (phi_d / np.pi * turns - 0.5) % turns
    weight_p = [max(0.0, 1.0 - min(abs(turn - p), turns - abs(turn - p))) for p in range(turns)]
    mean = table.values.astype(np.float64)
    full = np.zeros((heights + 1, depths + 1, turns, 3))
    full[1:, 1:] = mean
    full[0, 1:] = mean[0].mean(axis=1)[:, None]
    full[1:, 0] = mean[:, 0].mean(axis=1)[:, None]
    full[0, 0] = mean[0, 0].mean(axis=0)
    return np.einsum("h,d,p,hdpc->c", weight_h, weight_d, weight_p, full)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_table_is_exact_at_its_bin_centres(dtype: Any) -> None:
    table = random_table(dtype=dtype)
    theta_h, theta_d, phi_d = bin_centres(SHAPE)
    found = table.at(theta_h[:, None, None], theta_d[:, None], phi_d)
    assert np.abs(found - table.values).max() <= 16 * U
    wi, wo = bin_directions(SHAPE)
    above = (wi[..., 2] > 0) & (wo[..., 2] > 0)
    assert above.sum() > 100
    assert np.abs(table.f(wi, wo) - table.values)[above].max() <= 1e-12
    assert np.all(table.f(wi, wo)[~above] == 0.0)


def test_the_interpolation_is_the_one_described() -> None:
    table = random_table()
    random = np.random.default_rng(1)
    angles = random.random((500, 3)) * (np.pi / 2, np.pi / 2, np.pi)
    angles[:30, 0] *= 1e-3
    angles[30:60, 1] *= 1e-2
    found = table.at(*angles.T)
    assert found == pytest.approx(np.array([by_hand(table, *angle) for angle in angles]), abs=1e-13)


def test_M4_exchanging_the_directions_gives_the_same_bits() -> None:
    table = random_table()
    wi, wo = random_directions(200_000), random_directions(200_000, 1)
    assert np.array_equal(table.f(wi, wo), table.f(wo, wi))
    mirrored = wi * (-1.0, -1.0, 1.0)
    assert np.array_equal(table.f(wi, mirrored), table.f(mirrored, wi))


def test_M4_every_spelling_of_a_boundary_finds_a_bin() -> None:
    table = random_table()
    phi = np.array([0.0, -0.0, -1e-17, 1e-17, np.pi, -np.pi, np.nextafter(np.pi, 0.0), 7 * np.pi, -1e6])
    for theta_d in (0.0, np.pi / 4, np.pi / 2):
        values = table.at(np.pi / 2, theta_d, phi)
        assert np.all(np.isfinite(values))
        assert np.abs(values[:7] - values[0]).max() <= 1e-13
    wi = np.array([[1.0, 0.0, 1e-12], [1.0, 0.0, 1e-300], [0.0, -1.0, 5e-324]])
    opposite = wi * (-1.0, -1.0, 1.0)
    assert np.all(np.isfinite(table.f(wi, opposite)))


def test_M2_with_the_half_vector_at_the_normal_the_tangent_does_not_matter() -> None:
    table = random_table()
    phi = np.linspace(0.0, 6.28, 200)
    wi, wo = surface_direction(0.6, phi), surface_direction(0.6, phi) * (-1.0, -1.0, 1.0)
    values = table.f(wi, wo)
    assert np.array_equal(half_difference(wi, wo).theta_h, np.zeros(200))
    assert np.ptp(values, axis=0).max() <= 4 * U
    wi, wo = surface_direction(0.6, phi), surface_direction(0.2, phi + 1.0)
    assert np.ptp(table.f(wi, wo), axis=0).max() <= 1e-13


def test_the_function_is_continuous_across_the_seam_and_in_retro_reflection() -> None:
    table = random_table()
    wi, wo = directions(0.7, 0.0, 0.5, np.array([1e-9, np.pi - 1e-9]))
    assert np.ptp(table.f(wi, wo), axis=0).max() <= 1e-7
    centre = surface_direction(0.7)
    around = surface_direction(0.7 + 1e-9 * np.cos(np.arange(12)), 1e-9 * np.sin(np.arange(12)))
    assert np.abs(table.f(around, centre) - table.f(centre, centre)).max() <= 1e-7


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 0.0, -1.0, -1e-300])
def test_what_is_not_above_the_horizon_is_zero(bad: float) -> None:
    tables: list[Any] = [random_table(), direction_table()]
    for table in tables:
        assert np.array_equal(table.f([0.0, 0.0, bad], [0.0, 0.0, 1.0]), np.zeros(3))
        assert np.array_equal(table.f([[0.0, 0.0, 1.0]], [0.0, 0.0, bad]), np.zeros((1, 3)))
    assert tables[0].f([bad, 0.0, 1.0], [0.0, 0.0, 1.0]).shape == (3,)
    assert np.all(np.isfinite(tables[0].f([bad, 0.0, 1.0], [0.0, 0.0, 1.0])))


def test_a_sampled_model_comes_back_within_the_bound_of_linear_interpolation() -> None:
    """Halving the bins divides the error by four where the function is smooth."""
    model = Ggx(kd=(0.2, 0.3, 0.4), alpha=0.6, f0=(0.1, 0.1, 0.1))
    wi, wo = random_directions(20_000), random_directions(20_000, 1)
    inner = (wi[:, 2] > 0.4) & (wo[:, 2] > 0.4)
    errors = []
    for size in (16, 32, 64):
        shape = (size, size, size)
        low, high = bin_directions(shape)
        low, high = (np.where(d[..., 2:] > 0, d, (0.0, 0.0, 1.0)) for d in (low, high))
        table = HalfDifferenceTable(model.f(low, high), np.zeros(shape, bool))
        errors.append(np.sqrt(np.mean((table.f(wi, wo) - model.f(wi, wo))[inner] ** 2)))
    assert errors[0] / errors[1] > 3.0
    assert errors[1] / errors[2] > 3.0


def test_holes_are_filled_by_the_stated_rule() -> None:
    values = np.zeros((3, 3, 6, 3))
    missing = np.ones((3, 3, 6), bool)
    for p, value in ((1, 10.0), (4, 40.0)):
        values[1, 1, p] = value
        missing[1, 1, p] = False
    fill_holes(values, missing)
    assert values[1, 1, :, 0] == pytest.approx([20.0, 10.0, 20.0, 30.0, 40.0, 30.0])
    assert np.all(values == values[1, 1])
    one = np.zeros((1, 1, 5, 3))
    one[0, 0, 2] = 7.0
    fill_holes(one, np.array([[[True, True, False, True, True]]]))
    assert np.all(one == 7.0)
    assert list(nearest(np.array([False, True, False, True, False, False]))) == [1, 1, 1, 3, 3, 3]
    with pytest.raises(ValueError, match="no entry"):
        fill_holes(values, np.ones((3, 3, 6), bool))


def test_measured_entries_stay_as_they_are_when_others_are_filled() -> None:
    random = np.random.default_rng(3)
    values = random.random((7, 8, 9, 3))
    missing = random.random((7, 8, 9)) < 0.7
    missing[2] = missing[5, 3] = True
    filled = np.where(missing[..., None], np.nan, values)
    fill_holes(filled, missing)
    assert np.array_equal(filled[~missing], values[~missing])
    assert np.all(np.isfinite(filled))
    assert filled.min() >= values[~missing].min()
    assert filled.max() <= values[~missing].max()


def test_missing_entries_are_counted_and_reported() -> None:
    missing = np.zeros(SHAPE, bool)
    missing[0, 0, :2] = True
    table = HalfDifferenceTable(np.ones((*SHAPE, 3)), missing, health=missing_health(missing))
    assert (table.samples, table.invalid_samples) == (240, 2)
    assert "2 of 240 entries are missing" in table.health.findings[0].text
    assert not missing_health(np.zeros(SHAPE, bool)).findings


@pytest.mark.parametrize(
    ("values", "missing"),
    [
        (np.ones((2, 2, 2)), np.zeros((2, 2, 2), bool)),
        (np.ones((2, 2, 2, 3)), np.zeros((2, 2, 3), bool)),
        (np.ones((2, 2, 2, 3), int), np.zeros((2, 2, 2), bool)),
        (np.full((2, 2, 2, 3), np.nan), np.zeros((2, 2, 2), bool)),
        (np.full((2, 2, 2, 3), -1.0), np.zeros((2, 2, 2), bool)),
        (np.full((2, 2, 2, 3), 1e31), np.zeros((2, 2, 2), bool)),
    ],
)
def test_impossible_tables_are_refused(values: NDArray[Any], missing: NDArray[np.bool_]) -> None:
    with pytest.raises(ValueError, match="values"):
        HalfDifferenceTable(values, missing)


def direction_table(symmetric: bool = False, columns: int = 12) -> DirectionTable:
    theta = np.radians([0.0, 15.0, 30.0, 45.0, 60.0, 75.0])
    phi = 2.0 * np.pi * np.arange(columns) / columns
    values = np.random.default_rng(0).random((6, columns, 6, columns, 3))
    if symmetric:
        values = 0.5 * (values + values.transpose(2, 3, 0, 1, 4))
    return DirectionTable(theta, phi, theta, phi, values, np.zeros(values.shape[:4], bool))


def test_a_direction_table_is_exact_at_its_nodes_and_closes_on_itself() -> None:
    table = direction_table()
    wi = surface_direction(table.theta_i[1:, None], table.phi_i)[:, :, None, None]
    wo = surface_direction(table.theta_o[1:, None], table.phi_o)
    assert np.abs(table.f(wi, wo) - table.values[1:, :, 1:]).max() <= 1e-12
    middle = surface_direction(table.theta_o[2], np.radians(345.0))
    assert table.f(wi[2, 3, 0, 0], middle) == pytest.approx(
        0.5 * (table.values[3, 3, 2, 11] + table.values[3, 3, 2, 0]), abs=1e-12
    )
    seam = surface_direction(0.5, np.array([-1e-12, 0.0, 1e-12]))
    assert np.ptp(table.f(seam, wo[2, 5]), axis=0).max() <= 1e-10


def test_beyond_the_last_row_the_line_goes_on_but_not_below_zero() -> None:
    table = direction_table()
    wi = surface_direction(np.pi / 2 - 1e-9, table.phi_i[4])
    wo = surface_direction(table.theta_o[2], table.phi_o[7])
    line = 2.0 * table.values[5, 4, 2, 7] - table.values[4, 4, 2, 7]
    assert table.f(wi, wo) == pytest.approx(np.maximum(line, 0.0), abs=1e-7)
    both = table.f(random_directions(20_000) * (1, 1, 1e-3), random_directions(20_000, 1) * (1, 1, 1e-3))
    assert both.min() >= 0.0
    assert both.max() <= 9.0


def test_a_direction_table_is_reciprocal_where_its_entries_are() -> None:
    wi, wo = random_directions(20_000), random_directions(20_000, 1)
    symmetric, other = direction_table(symmetric=True), direction_table()
    assert symmetric.reciprocal
    assert symmetric.asymmetry == 0.0
    assert np.abs(symmetric.f(wi, wo) - symmetric.f(wo, wi)).max() <= 1e-13
    assert not other.reciprocal
    assert 0.5 < other.asymmetry <= 1.0
    assert not other.isotropic


def test_a_table_with_one_azimuth_of_the_light_is_isotropic() -> None:
    theta, phi = np.radians([0.0, 40.0, 80.0]), np.radians(np.arange(0.0, 360.0, 30.0))
    values = np.random.default_rng(4).random((3, 1, 3, 12, 3))
    table = DirectionTable(theta, np.zeros(1), theta, phi, values, np.zeros(values.shape[:4], bool))
    assert table.isotropic
    turn = np.linspace(0, 6, 50)
    values = table.f(surface_direction(0.4, turn), surface_direction(1.0, turn + 2.0))
    assert np.ptp(values, axis=0).max() <= 1e-12
    mirrored = table.values[:, :, :, (-np.arange(12)) % 12].transpose(2, 1, 0, 3, 4)
    symmetric = DirectionTable(theta, np.zeros(1), theta, phi, 0.5 * (table.values + mirrored), table.missing)
    assert symmetric.reciprocal
    wi, wo = random_directions(5_000), random_directions(5_000, 1)
    assert np.abs(symmetric.f(wi, wo) - symmetric.f(wo, wi)).max() <= 1e-12
