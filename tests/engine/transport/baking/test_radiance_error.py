"""Errors of radiance are those of numbers that can be followed by hand."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.models.diffuse import Lambert
from engine.transport.baking.radiance_error import Deviation, choose_tried_pairs, exact_radiance


def test_pairs_count_by_their_cosine() -> None:
    deviation = Deviation()
    deviation.add(np.array([1.0, 0.25]), np.array([[3.0] * 3, [2.0] * 3]), np.array([[2.0] * 3, [4.0] * 3]))
    deviation.add(np.array([0.5]), np.array([[1.0, 1.0, 0.0]]), np.array([[1.0, 0.0, 0.0]]))
    difference = 1.0 * 3.0 + 0.25 * 12.0 + 0.5 * 1.0
    total = 1.0 * 12.0 + 0.25 * 48.0 + 0.5 * 1.0
    assert deviation.rmse_rel == pytest.approx(np.sqrt(difference / total), rel=1e-12)
    assert deviation.mean_rel == pytest.approx((3.0 - 1.5 + 0.5) / (6.0 + 3.0 + 0.5), rel=1e-12)
    assert deviation.error(0.125).pairs == 3
    assert deviation.error(0.125).negative_rel == 0.125


def test_where_all_is_dark_nothing_is_wrong() -> None:
    deviation = Deviation()
    assert (deviation.rmse_rel, deviation.mean_rel) == (0.0, 0.0)
    deviation.add(np.ones(2), np.zeros((2, 3)), np.zeros((2, 3)))
    assert (deviation.rmse_rel, deviation.mean_rel) == (0.0, 0.0)


def test_open_texels_above_the_surface_light_it() -> None:
    wi = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.0, -1.0]])
    visible, incident = np.array([1.0, 0.5, 1.0]), np.array([[1.0, 2.0, 3.0], [10.0, 0.0, 0.0], [99.0, 99.0, 99.0]])
    views = np.array([[0.0, 0.0, 1.0], [0.8, 0.0, 0.6]])
    expected = np.array([1.0 + 0.8 * 0.5 * 10.0, 2.0, 3.0]) * 0.5 / np.pi
    found = exact_radiance(Lambert((0.5, 0.5, 0.5)), wi, visible, incident, views)
    np.testing.assert_allclose(found, np.stack([expected, expected]), rtol=1e-12)


def test_vertices_are_tried_once_each_and_all_where_there_are_few() -> None:
    chosen, towards = choose_tried_pairs(1000, 400, 20, seed=1)
    assert (np.diff(chosen) > 0).all()
    assert chosen.shape == (400,)
    assert 0 <= chosen[0] < chosen[-1] < 1000
    np.testing.assert_allclose(np.linalg.norm(towards, axis=1), np.ones(20), rtol=1e-12)
    assert (choose_tried_pairs(5, 400, 20, seed=1)[0] == np.arange(5)).all()
