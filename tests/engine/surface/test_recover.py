"""Surfaces found in photographs whose shape, colour and gloss are known, and lamps that cannot tell them."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.models.microfacet import MetallicRoughness
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.surface.lamps import lamps, observe_slopes
from engine.surface.recover import recover
from engine.surface.reflectance import texels
from tests.engine.domes import dome
from tests.engine.surface.photographs import angle_deg, bump, directions, lambertian, lights, normals, stack

AROUND = (0.0, 60.0, 120.0, 180.0, 240.0, 300.0)


def test_the_normals_of_a_lambertian_bump_are_exact() -> None:
    height, normal = bump()
    photographs = lambertian(normal, (0.6, 0.4, 0.2), *lights((25.0, 45.0, 70.0), AROUND))
    maps = drain(recover(photographs, np.arange(18), left_out=False)).maps
    assert angle_deg(maps.normal, normal).max() < 0.1
    assert maps.height is not None
    assert np.corrcoef(maps.height.ravel(), height.ravel())[0, 1] > 0.9999
    assert np.abs(maps.height - (height - height.mean())).max() < 0.01 * np.ptp(height)
    assert np.median(maps.metallic) == 0.0
    np.testing.assert_allclose(np.median(maps.base_colour, axis=(0, 1)), (0.6, 0.4, 0.2), atol=0.02)


def test_shadows_and_highlights_do_not_bend_the_normals() -> None:
    """A sixth of the photographs of each texel is black or twice as bright: least squares would err by degrees."""
    _, normal = bump()
    elevation, azimuth = lights((30.0, 50.0, 70.0), AROUND)
    clean = lambertian(normal, (0.3, 0.3, 0.3), elevation, azimuth)
    random = np.random.default_rng(1)
    radiance = np.asarray(clean.radiance).copy()
    wrong = random.random(radiance.shape[:3])
    radiance[wrong < 0.08] = 0.0
    radiance[wrong > 0.92] *= 2.0
    broken = stack(radiance, elevation, azimuth)
    plain = np.linalg.lstsq(directions(elevation, azimuth), radiance[..., 1].reshape(18, -1), rcond=None)[0]
    plain = (plain / np.linalg.norm(plain, axis=0)).T.reshape(normal.shape)
    ours = drain(recover(broken, np.arange(18), left_out=False)).maps.normal
    assert np.median(angle_deg(plain, normal)) > 2.0
    assert np.median(angle_deg(ours, normal)) < 0.3


@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_gloss_is_found_with_the_slopes(metallic: float) -> None:
    """Photographs by the program's own glTF model, evaluated in the frame of each normal."""
    rng = np.random.default_rng(2)
    right, up = 0.25 * rng.standard_normal((2, 24, 24))
    normal = normals(right, up)
    model = MetallicRoughness((0.5, 0.35, 0.2), metallic, 0.45)
    elevation, azimuth = lights((25.0, 40.0, 55.0, 70.0, 85.0), AROUND)
    towards = directions(elevation, azimuth)
    wo = np.stack([np.sqrt(1 - normal[..., 2] ** 2), np.zeros(normal.shape[:2]), normal[..., 2]], axis=-1)
    tangent = (np.array([0, 0, 1.0]) - normal[..., 2:] * normal) / wo[..., :1]
    frame = np.stack([tangent, np.cross(normal, tangent), normal], axis=-2)
    wi = np.einsum("ijkl,nl->nijk", frame, towards)
    cosine = np.maximum(wi[..., 2:], 0.0)
    radiance = np.pi * np.where(cosine > 0, model.f(wi, np.broadcast_to(wo, wi.shape)), 0.0) * cosine
    maps = drain(recover(stack(radiance, elevation, azimuth), np.arange(30), white=1.0, left_out=False)).maps
    assert np.median(angle_deg(maps.normal, normal)) < 1.0
    assert np.median(maps.roughness) == pytest.approx(0.45, abs=0.04)
    assert np.median(maps.metallic) == pytest.approx(metallic, abs=0.1)
    np.testing.assert_allclose(np.median(maps.base_colour, axis=(0, 1)), (0.5, 0.35, 0.2), rtol=0.12)


@pytest.mark.parametrize("azimuth_deg", [0.0, 30.0, 90.0])
def test_one_arc_tells_the_slope_along_it_alone(azimuth_deg: float) -> None:
    _, normal = bump(32)
    elevation, azimuth = lights((30.0, 50.0, 70.0, 90.0), (azimuth_deg, azimuth_deg + 180.0))
    photographs = lambertian(normal, (0.5, 0.5, 0.5), elevation, azimuth)
    found = drain(recover(photographs, np.arange(8), left_out=False))
    maps, along = found.maps, np.radians(azimuth_deg)
    assert maps.observed.kind == "along the arc"
    assert maps.observed.azimuth is not None
    assert np.cos(2 * (maps.observed.azimuth - along)) == pytest.approx(1.0)
    assert maps.height is None
    assert any("arc" in text for text in found.health.warnings)
    given, wanted = (each[..., :2] / each[..., 2:] for each in (maps.normal, normal))
    direction = np.array([np.cos(along), np.sin(along)])
    np.testing.assert_allclose(given @ direction, wanted @ direction, atol=0.01)
    assert np.abs(given @ np.array([-direction[1], direction[0]])).max() < 1e-5


def test_a_near_lamp_lights_each_texel_from_its_own_direction() -> None:
    _, normal = bump(32)
    elevation, azimuth = lights((35.0, 55.0, 75.0), AROUND)
    distance, size = 1.5, 32
    place = (np.arange(size) + 0.5) / size - 0.5
    ground = np.stack(np.broadcast_arrays(place[None, :], -place[:, None], 0.0), axis=-1)
    towards = distance * directions(elevation, azimuth)[:, None, None, :] - ground
    length = np.linalg.norm(towards, axis=-1)
    arriving = np.maximum((normal * towards).sum(axis=-1), 0.0) / length * (distance / length) ** 2
    evened = arriving * (length / distance) ** 3  # as the import does with near lamps
    radiance = np.repeat(0.5 * evened[..., None], 3, axis=-1)
    near = stack(radiance, elevation, azimuth, lamp_distance_widths=distance)
    found = angle_deg(drain(recover(near, np.arange(18), left_out=False)).maps.normal, normal)
    assert found.max() < 0.1
    far = stack(radiance, elevation, azimuth)
    other = angle_deg(drain(recover(far, np.arange(18), left_out=False)).maps.normal, normal)
    assert np.median(other) > 10.0 * np.median(found)


def test_three_lamps_are_enough_and_two_are_refused() -> None:
    _, normal = bump(16)
    elevation, azimuth = lights((50.0,), (0.0, 120.0, 240.0))
    photographs = lambertian(normal, (0.5, 0.5, 0.5), elevation, azimuth)
    lit = (normal @ directions(elevation, azimuth).T > 0).all(axis=-1)
    found = drain(recover(photographs, np.arange(3), left_out=False))
    assert np.median(angle_deg(found.maps.normal, normal)[lit]) < 0.1
    assert any("plastic" in text for text in found.health.warnings)
    with pytest.raises(InputError, match="lit from 2 directions"):
        lamps(photographs, np.arange(2))
    nowhere = stack(np.asarray(photographs.radiance, np.float64), elevation, None)
    with pytest.raises(InputError, match="azimuth"):
        lamps(nowhere, np.arange(3))


def test_equal_directions_count_once() -> None:
    elevation, azimuth = np.radians([40.0, 40.0, 40.0]), np.radians([10.0, 10.1, 200.0])
    with pytest.raises(InputError, match="lit from 2 directions"):
        lamps(stack(np.ones((3, 4, 4, 3)), elevation, azimuth), np.arange(3))


def test_a_ring_of_high_lamps_is_no_arc() -> None:
    ring = directions(np.full(8, np.radians(80.0)), np.arange(8) * np.pi / 4)
    assert observe_slopes(ring).kind == "both"


def test_a_black_photograph_leaves_flat_normals_of_unknown_angle() -> None:
    elevation, azimuth = lights((40.0, 60.0), AROUND)
    black = stack(np.zeros((12, 8, 8, 3)), elevation, azimuth)
    maps = drain(recover(black, np.arange(12), left_out=False)).maps
    assert (maps.normal[..., 2] == 1.0).all()
    assert maps.uncertainty is not None
    assert (maps.uncertainty.normal > 1.5).all()


@pytest.mark.parametrize("dimmed", [0.0, 0.15])
def test_normals_err_as_they_say_where_lamps_of_one_side_err_alike(dimmed: float) -> None:
    """A third of the lamps, on a side of each texel's own, is dimmed: no residual is then independent of the next."""
    rng = np.random.default_rng(3)
    _, normal = bump(32)
    elevation, azimuth = lights((30.0, 50.0, 70.0), tuple(float(angle) for angle in range(0, 360, 30)))
    radiance = np.asarray(lambertian(normal, (0.5, 0.5, 0.5), elevation, azimuth).radiance).copy()
    side = rng.uniform(-np.pi, np.pi, (32, 32))
    beside = np.cos(azimuth[:, None, None] - side) > 0.5
    radiance *= np.where(beside, 1.0 - dimmed, 1.0)[..., None]
    radiance += 0.01 * rng.standard_normal(radiance.shape)
    maps = drain(recover(stack(radiance, elevation, azimuth), np.arange(36), left_out=False)).maps
    assert maps.uncertainty is not None
    angle = np.radians(angle_deg(maps.normal, normal))
    within = np.mean(angle < maps.uncertainty.normal)
    print(within, np.median(angle), np.median(maps.uncertainty.normal))
    assert 0.5 < within < 0.85


def test_a_sample_of_texels_holds_those_of_its_rows_and_columns() -> None:
    """In a stack that is taller than wide."""
    photographs = dome(4, height=23, width=11)
    some = texels(photographs, np.array([0, 2]), 1, 23, 3)
    radiance, usable, rows, columns = some.radiance, some.usable, some.rows, some.columns
    assert (rows.max(), columns.max(), len(rows)) == (22, 10, 8 * 4)
    np.testing.assert_array_equal(radiance, photographs.radiance[[0, 2]][:, rows, columns])
    assert usable.all()
