"""Directions and frames."""

from __future__ import annotations

import numpy as np
import pytest

from engine.core.directions import (
    dot,
    normalize,
    surface_direction,
    world_angles,
    world_direction,
    world_from_tangent,
)

POLE = np.array([0.0, -1.0, 0.0])


def test_world_angles_are_measured_from_up_and_from_the_viewer_towards_the_right() -> None:
    assert world_direction(0.0, 1.0) == pytest.approx([0.0, 1.0, 0.0])
    assert world_direction(np.pi / 2, 0.0) == pytest.approx([0.0, 0.0, 1.0])
    assert world_direction(np.pi / 2, np.pi / 2) == pytest.approx([1.0, 0.0, 0.0])
    assert world_angles(world_direction(0.7, -2.0)) == pytest.approx((0.7, -2.0))
    assert world_angles((0.0, 1.0, 0.0)) == (0.0, 0.0)


def test_surface_directions_have_the_normal_at_zero() -> None:
    assert surface_direction(0.0) == pytest.approx([0.0, 0.0, 1.0])
    assert surface_direction(np.pi / 2, np.pi / 2) == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)
    assert surface_direction(np.linspace(0, 1, 5), 0.3).shape == (5, 3)


@pytest.mark.parametrize("hopeless", [(0.0, 0.0, 0.0), (np.nan, 0.0, 1.0), (np.inf, 0.0, 0.0), (1e200, 1e200, 0.0)])
def test_GL3_normalising_nothing_gives_the_fallback(hopeless: tuple[float, ...]) -> None:
    assert normalize(hopeless, fallback=(0.0, 1.0, 0.0)).tolist() == [0.0, 1.0, 0.0]


def test_F1_frames_are_orthonormal_everywhere() -> None:
    rng = np.random.default_rng(1)
    near_pole = normalize(POLE + 10.0 ** -rng.uniform(1, 16, (1000, 1)) * rng.normal(size=(1000, 3)))
    signed_zeros = [(0.0, -1.0, 0.0), (-0.0, -1.0, 0.0), (0.0, -1.0, -0.0), (0.0, 1.0, 0.0), (1.0, -0.0, 0.0)]
    normals = np.concatenate([normalize(rng.normal(size=(10_000, 3))), near_pole, signed_zeros])
    frames = world_from_tangent(normals)
    assert np.abs(np.einsum("nij,nik->njk", frames, frames) - np.eye(3)).max() <= 2e-15
    assert np.linalg.det(frames) == pytest.approx(np.ones(len(normals)), abs=2e-15)
    assert np.array_equal(frames[..., 2], normals)


def test_F5_the_stable_frame_is_the_printed_one_away_from_its_singularity() -> None:
    """To 1e-14 from 2° on and 3e-14 before: what rounding the components of n does to the printed 1 + n_y."""
    n = normalize(np.random.default_rng(2).normal(size=(1_000_000, 3)))
    n = n[dot(n, POLE) < np.cos(np.radians(1.0))]
    x, y, z = n.T
    printed = normalize(np.stack([(y + 1) ** 2 + z**2 - x**2, -2 * (y + 1) * x, -2 * x * z], axis=-1))
    frames = world_from_tangent(n)
    bound = np.where(y > -np.cos(np.radians(2.0)), 1e-14, 3e-14)
    assert (np.abs(frames[..., 0] - printed).max(axis=1) <= bound).all()
    assert (np.abs(frames[..., 1] - np.cross(n, printed)).max(axis=1) <= bound).all()


def test_F5_vectors_near_the_singularity_that_broke_other_frames_are_safe() -> None:
    """The vectors of Duff et al. 2017, Table 1, with their singular axis rotated to ours."""
    bad = [(0.00038527316, 0.00038460016, -0.99999988079), (-0.00019813581, -0.00008946839, -0.99999988079)]
    n = normalize([(x, z, y) for x, y, z in bad])
    frames = world_from_tangent(n)
    assert np.abs(np.einsum("nij,nik->njk", frames, frames) - np.eye(3)).max() <= 2e-15
