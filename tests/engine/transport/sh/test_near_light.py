"""Near lamps: their closed form beside sums over directions, laws, and the field between the points of a grid."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize, world_from_tangent
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.geometry.ground import Ground
from engine.light.lamps import Lamp
from engine.light.near_lamps import NearLamp, near_lamp_from_text
from engine.transport.sh.bake import BakeSettings, bake, prepare
from engine.transport.sh.basis import cosine_zonal, evaluate, turn_zonal
from engine.transport.sh.brdf_table import lambert_table
from engine.transport.sh.lighting import lamp_coefficients
from engine.transport.sh.near_light import (
    SWEEP,
    TOLERANCE,
    grid,
    incident,
    interpolate,
    near_light,
)
from engine.transport.sh.transfer import ShTransport, sum_signed_radiance, transfer
from tests.engine.transport.sh.test_transfer import small

WHITE = (1.0, 1.0, 1.0)


def sphere_points(count: int, seed: int = 0) -> np.ndarray:
    return normalize(np.random.default_rng(seed).normal(size=(count, 3)))


def test_a_rectangle_and_a_disc_are_the_radiance_that_comes_from_their_front() -> None:
    """Brute force: directions of the whole sphere, each with the radiance of the lamp if it meets it."""
    height, turn = np.meshgrid(1.0 - 2.0 * (np.arange(300) + 0.5) / 300, 2.0 * np.pi * np.arange(600) / 600)
    ring = np.sqrt(1.0 - height**2)
    wi = np.stack([ring * np.cos(turn), height, ring * np.sin(turn)], axis=-1).reshape(-1, 3)
    basis = evaluate(6, wi)
    for text in ("shape=rectangle,x=0.2,y=0.8,width=1,height=0.6", "shape=disc,y=0.9,z=0.3,radius=0.5"):
        lamp = near_lamp_from_text(f"{text},power=5,colour=1:0.5:0.2")
        place = wi * (lamp.position[1] / np.maximum(wi[:, 1:2], 1e-9)) - lamp.position  # its plane is level
        inside = (place @ lamp.half_sides.T) / (lamp.half_sides**2).sum(axis=1)
        met = (np.hypot(*inside.T) if lamp.shape == "disc" else np.abs(inside).max(axis=1)) <= 1.0
        summed = (basis[met & (wi[:, 1] > 0.0)].sum(axis=0) * 4.0 * np.pi / len(wi))[:, None] * lamp.radiance
        found = incident([lamp], [(0.0, 0.0, 0.0)], 6)[0]
        assert np.linalg.norm(found - summed) < 0.02 * np.linalg.norm(summed)
        behind = dataclasses.replace(lamp, facing=(0.0, 1.0, 0.0))
        assert not incident([behind], [(0.0, 0.0, 0.0)], 6).any()
        with pytest.raises(UsageError, match=f"the {lamp.shape} at .* touches the model"):
            near_light([lamp], np.asarray([lamp.position]), 6)


@pytest.mark.parametrize("distance", [1.05, 1.5, 4.0])
def test_a_sphere_is_the_sum_over_the_directions_that_meet_it(distance: float) -> None:
    """Brute force: rays in even cosine and azimuth over the cone of the sphere, each with its radiance."""
    centre, radius, power = np.array([0.3, -0.2, 0.9]), 0.5, np.array([7.0, 5.0, 3.0])
    point = centre - radius * distance * normalize(np.array([0.5, 0.7, -0.1]))
    limit = math.sqrt(1.0 - 1.0 / distance**2)
    cosine = limit + (1.0 - limit) * (np.arange(400) + 0.5) / 400
    azimuth = 2.0 * np.pi * np.arange(60) / 60
    across = np.sqrt(1.0 - cosine**2)[:, None]
    cone = np.stack(np.broadcast_arrays(across * np.cos(azimuth), across * np.sin(azimuth), cosine[:, None]), axis=-1)
    wi = cone.reshape(-1, 3) @ world_from_tangent(normalize(centre - point)).T
    offset = point - centre
    along = wi @ offset
    assert (along**2 - offset @ offset + radius**2 > -1e-9).all(), "every ray meets the sphere"
    radiance = power / (4.0 * np.pi**2 * radius**2)  # of a sphere of even radiance: power = π L · 4 π r²
    summed = evaluate(8, wi).sum(axis=0)[:, None] * radiance * (2.0 * np.pi * (1.0 - limit) / len(wi))
    found = incident([NearLamp(tuple(centre), tuple(power), radius)], [point], 8)[0]
    assert np.linalg.norm(found - summed) < 1e-4 * np.linalg.norm(summed)


def test_what_passes_through_a_sphere_about_a_lamp_is_its_power() -> None:
    lamp = NearLamp((0.1, 0.2, 0.0), (2.0, 3.0, 4.0), 0.3)
    towards = sphere_points(4000)
    light = incident([lamp], 2.0 * towards, 30)
    irradiance = np.einsum("pi,pic->pc", turn_zonal(cosine_zonal(30), -towards), light)
    np.testing.assert_allclose(irradiance.mean(axis=0) * 4.0 * np.pi * 4.0, lamp.power, rtol=0.01)


def test_a_lamp_far_away_is_a_distant_one() -> None:
    direction, distance = normalize(np.array([0.2, 0.9, 0.4])), 1e5
    near = NearLamp(tuple(direction * distance), (4.0 * np.pi * distance**2,) * 3, distance * math.sin(0.2))
    found = near_light([near], small().positions, 5)
    assert found.points == 8
    expected = lamp_coefficients(Lamp(tuple(direction), WHITE, 0.2), 5)
    assert np.abs(found.coefficients - expected).max() < 1e-4


@pytest.mark.parametrize("centre", [(1.6, 0.4, 0.2), (0.0, 3.0, 0.0)])
def test_the_error_falls_with_the_number_of_points(centre: tuple[float, float, float]) -> None:
    """Of the light and of what a vertex shows of it, beside the closed form at every vertex."""
    mesh, lamp = small(24, 11), NearLamp(centre, (30.0, 20.0, 10.0), 0.2)
    exact = incident([lamp], mesh.positions, 5)
    facing = turn_zonal(cosine_zonal(5), mesh.normals.astype(np.float64))
    shown = np.einsum("vi,vic->vc", facing, exact)
    errors, of_radiance, points = [], [], []
    for along in (2, 3, 5, 9, 17):
        found = near_light([lamp], mesh.positions, 5, along)
        points.append(found.points)
        errors.append(np.linalg.norm(found.coefficients - exact) / np.linalg.norm(exact))
        seen = np.einsum("vi,vic->vc", facing, found.coefficients)
        of_radiance.append(np.linalg.norm(seen - shown) / np.linalg.norm(shown))
        assert found.error_rel == pytest.approx(errors[-1], rel=0.2)
    assert points == [8, 27, 125, 729, 4913]
    assert all(after < 0.55 * before for before, after in pairwise(errors[1:])), errors
    assert all(after < 0.55 * before for before, after in pairwise(of_radiance[1:])), of_radiance
    assert errors[1] < errors[0]


def test_points_are_as_many_as_the_error_needs() -> None:
    mesh = small()
    far, near = (near_light([NearLamp((0.0, d, 0.0), WHITE)], mesh.positions, 5) for d in (40.0, 3.0))
    assert far.points == 8
    assert 27 < near.points <= SWEEP[-1] ** 3
    assert TOLERANCE <= 0.01, "what the command line and the program promise"
    assert max(far.error_rel, near.error_rel) <= TOLERANCE
    uneven = sphere_points(200)
    x, y, z = 1.001 * uneven[40]
    touching = near_light([NearLamp((x, y, z), WHITE)], uneven, 5)
    assert touching.error_rel > TOLERANCE, "the error of the finest grid is reported"
    assert np.isfinite(touching.coefficients).all()


def test_a_grid_without_extent_is_a_point_and_a_flat_one_has_one_layer() -> None:
    flat = np.array([[0.0, 2.0, 0.0], [4.0, 2.0, 1.0]])
    assert [len(nodes) for nodes in grid(flat, 5)] == [5, 1, 2]
    assert [len(nodes) for nodes in grid(flat[:1], 5)] == [1, 1, 1]
    assert [len(nodes) for nodes in grid(flat, 1)] == [1, 1, 1]
    assert grid(flat, 5)[1] == pytest.approx([2.0])
    assert len(near_light([NearLamp((0.0, 0.0, 0.0), WHITE)], np.zeros((0, 3)), 3).coefficients) == 0


@given(st.integers(0, 10_000), st.integers(1, 4))
def test_trilinear_functions_are_interpolated_exactly(seed: int, along: int) -> None:
    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(20, 3)) * rng.uniform(0.0, 3.0, 3)
    nodes = grid(positions, along)
    corner = rng.normal(size=(2, 2, 2))

    def value(at: np.ndarray) -> np.ndarray:
        total = np.zeros(len(at))
        for i, j, k in np.ndindex(2, 2, 2):
            total += corner[i, j, k] * at[:, 0] ** i * at[:, 1] ** j * at[:, 2] ** k
        return total

    points = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    values = np.broadcast_to(value(points)[:, None, None], (len(points), 1, 3))
    inside = np.stack([np.clip(positions[:, k], nodes[k][0], nodes[k][-1]) for k in range(3)], axis=-1)
    found = interpolate(nodes, values, positions)[:, 0, 0]
    np.testing.assert_allclose(found, value(inside), atol=2e-5 * max(1.0, np.abs(values).max()))


def test_an_open_diffuse_model_shows_the_irradiance_of_the_lamp() -> None:
    """With the whole disc above the horizon: albedo / π · power cos θ / (4 π d²), for any radius."""
    mesh, lamp = small(24, 11), NearLamp((0.0, 4.0, 0.0), (300.0, 200.0, 100.0), 0.5)
    vectors = turn_zonal(cosine_zonal(15) / np.pi, mesh.normals.astype(np.float64))[:, None].astype(np.float32)
    table = lambert_table(brdf_from_text("lambert:albedo=0.5"), 15)  # type: ignore[arg-type]
    transport = ShTransport(mesh, len(mesh.positions), True, 0.0, table, False, vectors)
    rows = transfer(transport, near_light([lamp], mesh.positions, 15).coefficients)
    everything = np.arange(len(mesh.positions))
    found = sum_signed_radiance(transport, rows, np.tile([0.0, 0.0, 1.0], (len(everything), 1)), everything)
    offset = np.array(lamp.position) - mesh.positions
    distance = np.linalg.norm(offset, axis=1)
    cosine = np.einsum("vi,vi->v", offset, mesh.normals) / distance
    expected = 0.5 / np.pi * np.array(lamp.power) * (np.maximum(cosine, 0.0) / (4.0 * np.pi * distance**2))[:, None]
    whole = np.abs(cosine) > lamp.radius / distance
    assert np.linalg.norm((found - expected)[whole]) < 0.02 * np.linalg.norm(expected[whole])


@pytest.mark.parametrize("text", ["lambert", "ggx:kd=0.3,alpha=0.4,f0=0.04"])
def test_light_of_ones_own_that_is_alike_for_all_is_light_for_all(tmp_path: Path, text: str) -> None:
    settings = BakeSettings(order=3, edge=8, fine=1)
    work = drain(prepare(small(), brdf_from_text(text), settings, Ground(cells=4)))
    transport = drain(bake(tmp_path / "t", work)).transport
    light = np.random.default_rng(1).normal(size=(9, 3))
    each = np.tile(light, (len(transport.mesh.positions), 1, 1))
    np.testing.assert_array_equal(transfer(transport, each), transfer(transport, light))
    each[0] = 0.0
    changed = (transfer(transport, each) != transfer(transport, light)).any(axis=1)
    count = 1 if transport.diffuse else 9
    assert changed[:count].any()
    assert not changed[count:].any()
    with pytest.raises(ValueError, match="does not fit"):
        transfer(transport, each[1:])


def test_lamps_come_as_text() -> None:
    lamp = near_lamp_from_text("x=1,y=2.5,z=-3,radius=0.25,power=40,colour=1:0.5:0.25")
    assert lamp == NearLamp((1.0, 2.5, -3.0), (40.0, 20.0, 10.0), 0.25)
    for wrong in ("x", "w=1", "x=a", "radius=-1", "power=nan", "x=inf"):
        with pytest.raises(ValueError, match=r"\w"):
            near_lamp_from_text(wrong)


def test_lamps_that_cannot_be_are_refused() -> None:
    positions = small().positions
    with pytest.raises(ValueError, match="touches the model"):
        near_light([NearLamp((0.0, 1.2, 0.0), WHITE, 0.3)], positions, 3)
    with pytest.raises(ValueError, match="touches the model"):
        near_light([NearLamp((0.0, 1.0, 0.0), WHITE)], positions, 3)
    with pytest.raises(ValueError, match="32 bits"):
        near_light([NearLamp((0.0, 1.5, 0.0), (1e38,) * 3)], positions, 3)
    with pytest.raises(ValueError, match="points along a side"):
        near_light([NearLamp((0.0, 3.0, 0.0), WHITE)], positions, 3, 0)
    for place, power, radius in (
        ((0.0, math.nan, 0.0), WHITE, 0.0),
        ((0.0,) * 3, (-1.0,) * 3, 0.0),
        ((0.0,) * 3, WHITE, -1.0),
    ):
        with pytest.raises(ValueError, match="lamp"):
            NearLamp(place, power, radius)
