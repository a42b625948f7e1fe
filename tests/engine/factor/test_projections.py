"""Projections: known coordinates by hand, conjugates, and masks against scipy's convex hulls."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay

from engine.brdf.half_difference import directions
from engine.core.directions import normalize, surface_direction
from engine.factor.projections import (
    DIFFERENCE,
    FIRST,
    KINDS,
    PARAMETRISATIONS,
    SECOND,
    SUM,
    FixedProjection,
    LinearProjection,
    linear,
    linear_of_pair,
    look_ups,
    mccool_projections,
    points_of,
    texture_mask,
)
from engine.factor.solvers.quaternions import random_pair


def hemisphere(count: int, seed: int) -> np.ndarray:
    directions = normalize(np.random.default_rng(seed).normal(size=(count, 3)))
    directions[:, 2] = np.abs(directions[:, 2])
    return directions


def test_coordinates_of_a_pair_known_by_hand() -> None:
    """wi at 90° along +x is (1, 0), wo at the normal (0, 0): h at 45° is tan 22.5° along x, θ_d is 45°."""
    r = np.tan(np.pi / 8)
    points = points_of([[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], "in-out")
    np.testing.assert_allclose(points.flat, [[1.0, 0.0, 0.0, 0.0]], atol=1e-15)
    np.testing.assert_allclose(points.half, [[r, 0.0]], atol=1e-15)
    np.testing.assert_allclose(points.angles, [[r, r, 1.0]], atol=1e-15)
    np.testing.assert_allclose(SUM.coordinates(points), [[0.5, 0.0]], atol=1e-15)
    np.testing.assert_allclose(FixedProjection("elevations").coordinates(points), [[1.0, -1.0]], atol=1e-15)
    turned = points_of([[1.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], "half-diff")
    np.testing.assert_allclose(turned.flat, [[r, 0.0, r, 0.0]], atol=1e-15)


@pytest.mark.parametrize(
    "half", [surface_direction(0.0), surface_direction(np.pi / 2, 0.0), surface_direction(np.pi / 2, np.pi)]
)
def test_X13_coles_frame_is_finite_at_the_normal_and_at_the_tangent(half: np.ndarray) -> None:
    """Exchanging the directions negates d bit for bit also where a frame has no axis of its own."""
    for offset in (0.0, 1e-14, 1e-9, 1e-3):
        aside = normalize(np.cross(half, [0.3, 0.8, 0.52]))
        h = normalize(half + offset * aside)
        wi, wo = normalize(h + 0.2 * aside)[None], normalize(h - 0.2 * aside)[None]
        there, back = points_of(wi, wo, "half-diff"), points_of(wo, wi, "half-diff")
        assert np.isfinite(there.flat).all()
        np.testing.assert_array_equal(there.flat[:, 2:], -back.flat[:, 2:])
        np.testing.assert_allclose(np.hypot(*there.flat[0, 2:]), there.angles[0, 1], atol=1e-12)


@pytest.mark.parametrize("parametrisation", PARAMETRISATIONS)
def test_L14_a_conjugate_sees_the_exchanged_pair_bit_for_bit(parametrisation: Any) -> None:
    rng = np.random.default_rng(1)
    wi, wo = hemisphere(2000, 2), hemisphere(2000, 3)
    there, back = points_of(wi, wo, parametrisation), points_of(wo, wi, parametrisation)
    linears = [linear_of_pair(random_pair(rng)) for _ in range(20)]
    for projection in [*linears, *(FixedProjection(kind) for kind in KINDS)]:
        conjugate = cast(Any, projection).conjugate(parametrisation)
        np.testing.assert_array_equal(cast(Any, projection).coordinates(there), conjugate.coordinates(back))
        np.testing.assert_array_equal(conjugate.coordinates(there), cast(Any, projection).coordinates(back))


@pytest.mark.parametrize("extent", ["disks", "cube"])
def test_L13_masks_hold_every_look_up_of_ten_thousand_rotations(extent: Any) -> None:
    """Half of them with each extent."""
    rng = np.random.default_rng(4)
    size = 9
    wi, wo = hemisphere(20, 5), hemisphere(20, 6)
    points = points_of(wi, wo, "in-out")
    for _ in range(5_000):
        projection = linear_of_pair(random_pair(rng), extent)
        place = 0.5 * (projection.coordinates(points) + 1.0) * (size - 1)
        assert place.min() >= -1e-12
        assert place.max() <= size - 1 + 1e-12
        corner = np.minimum(place.astype(int), size - 2)
        mask = projection.mask(size)
        for right, down in ((0, 0), (1, 0), (0, 1), (1, 1)):
            assert mask[corner[:, 1] + down, corner[:, 0] + right].all()


def test_L13_masks_are_the_hulls_of_the_projected_corners_and_their_neighbours() -> None:
    rng = np.random.default_rng(7)
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 4)).reshape(4, -1).T
    axis = np.linspace(-1.0, 1.0, 17)
    texels = np.stack(np.meshgrid(axis, axis), axis=-1)
    step = axis[1] - axis[0]
    square = np.array([[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]) * step
    for projection in (*(linear_of_pair(random_pair(rng), "cube") for _ in range(50)), FIRST, SECOND, SUM, DIFFERENCE):
        image = corners @ (projection.rows / projection.scale[:, None]).T
        grown = (image[:, None] + square).reshape(-1, 2)
        inside = Delaunay(grown[ConvexHull(grown).vertices]).find_simplex(texels, tol=1e-7) >= 0
        np.testing.assert_array_equal(projection.mask(17), inside)


def test_the_image_of_the_cube_fills_the_square() -> None:
    projection = linear_of_pair(random_pair(np.random.default_rng(8)), "cube")
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 4)).reshape(4, -1).T
    image = corners @ (projection.rows / projection.scale[:, None]).T
    np.testing.assert_allclose(image.max(axis=0), 1.0, atol=1e-14)


def test_fixed_masks_hold_every_look_up() -> None:
    wi, wo = hemisphere(20_000, 9), hemisphere(20_000, 10)
    points = points_of(wi, wo, "in-out")
    for kind in KINDS:
        place = 0.5 * (FixedProjection(kind).coordinates(points) + 1.0) * 11
        corner = np.minimum(place.astype(int), 10)
        mask = FixedProjection(kind).mask(12)
        for right, down in ((0, 0), (1, 0), (0, 1), (1, 1)):
            assert mask[corner[:, 1] + down, corner[:, 0] + right].all()


def test_reciprocal_terms_read_twice_unless_they_are_their_own_conjugate() -> None:
    points = points_of(hemisphere(3, 11), hemisphere(3, 12), "in-out")
    reads = {kind: len(look_ups(FixedProjection(kind), points, "in-out", True)) for kind in KINDS}
    assert reads == {
        "wi": 2,
        "wo": 2,
        "half": 1,
        "elevations": 2,
        "elevations-exchanged": 2,
        **{kind: 1 for kind in KINDS if FixedProjection(kind).angles},
    }
    assert len(look_ups(SUM, points, "in-out", True)) == 2
    assert len(look_ups(SUM, points, "in-out", False)) == 1
    assert len(mccool_projections(True)) == 2
    assert len(mccool_projections(False)) == 3
    mask = texture_mask(FIRST, "in-out", True, 8)
    np.testing.assert_array_equal(mask, FIRST.mask(8) | SECOND.mask(8))


def test_what_is_no_projection_is_refused() -> None:
    with pytest.raises(ValueError, match="orthonormal"):
        LinearProjection(np.ones((2, 4)))
    with pytest.raises(ValueError, match="independent"):
        linear([[1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]])
    with pytest.raises(ValueError, match="half"):
        FixedProjection("mirror")  # type: ignore[arg-type]


def test_scales_of_angles_are_what_they_say() -> None:
    """For a pair whose angles are known: θ_h = 20°, θ_d = 50°, and θ_m from the two elevations."""
    theta_h, theta_d = np.radians([20.0, 50.0])
    wi, wo = directions(np.array([theta_h]), 0.0, np.array([theta_d]), 0.5 * np.pi)
    theta_m = np.arccos(np.sqrt(wi[0, 2] * wo[0, 2]))
    points = points_of(wi, wo, "in-out")
    for base, angles in (
        ("wi-dot-h", (theta_h, theta_d)),
        ("half-mean", (theta_h, theta_m)),
        ("wi-dot-h-mean", (theta_d, theta_m)),
    ):
        radii = np.tan(0.5 * np.array(angles))
        for scale, wanted in (
            ("cosines", 2.0 * np.cos(angles) - 1.0),
            ("sines", 2.0 * np.sin(angles) - 1.0),
            ("squares", 2.0 * radii**2 - 1.0),
            ("turned", np.array([radii.sum() - 1.0, radii[0] - radii[1]])),
        ):
            projection = FixedProjection(f"{base}-{scale}")  # type: ignore[arg-type]
            assert (projection.angles, projection.measure) == (base, scale)
            np.testing.assert_allclose(projection.coordinates(points)[0], wanted, atol=1e-14)
