"""Images of the ball, against the renderer of the program and closed forms."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from engine.capture.stack import ImageStack
from engine.core.steps import drain
from engine.exchange.loss import loss, maps_shown, material_shown, photograph_error, references, sphere
from engine.exchange.pbr_from_material import nearest_maps
from engine.light.environment import DistantLights
from engine.surface.metallic_roughness import reflectance
from engine.surface.pbr_maps import PbrMaps

from .materials import measure_maps, woven_law, woven_material


def one_light(*direction: float) -> DistantLights:
    towards = np.array([direction]) / np.linalg.norm(direction)
    return DistantLights(towards, np.ones((1, 3)))


def test_the_sphere_is_round_and_its_frames_are_frames() -> None:
    view = sphere(64, 48, 32)
    np.testing.assert_allclose(
        view.frame @ np.swapaxes(view.frame, 1, 2), np.tile(np.eye(3), (len(view.row), 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(view.frame), 1.0)
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", view.frame, view.wo), np.tile((0.0, 0.0, 1.0), (len(view.row), 1)), atol=1e-12
    )
    left = view.column < 24
    assert (view.frame[left, 0, 2] < 0.0).all()
    assert (view.frame[view.row < 32, 1, 2] > 0.0).all()


def test_a_material_is_its_look_up() -> None:
    """Against `PowerLawMap.lookup` at the r that the equation gives."""
    material = woven_material()
    view, light = sphere(24, 20, 24), one_light(0.3, 0.5, 0.8)
    wi = np.einsum("nij,i->nj", view.frame, light.direction[0])
    material = dataclasses.replace(material, sigma=0.2)
    r = 0.2 * (material.reflectance.f(wi, view.wo) @ (0.2126390, 0.7151687, 0.0721923)) * np.maximum(wi[:, 2], 0.0)
    wanted = woven_law().lookup(view.row + 0.5, view.column + 0.5, r)
    np.testing.assert_allclose(material_shown(material)(view, light), wanted, rtol=1e-5, atol=1e-7)


def test_maps_with_flat_normals_are_f_cos() -> None:
    maps, _ = drain(nearest_maps(woven_material()))
    view, light = sphere(24, 20, 24), one_light(0.3, 0.5, 0.8)
    wi = np.einsum("nij,i->nj", view.frame, light.direction[0])
    at = (view.row, view.column)
    f = reflectance(wi, view.wo, maps.base_colour[at], maps.roughness[at], maps.metallic[at], maps.f0[at])
    np.testing.assert_allclose(maps_shown(maps)(view, light), f * np.maximum(wi[:, 2:], 0.0), atol=1e-12)


def test_a_map_of_normals_tilts_the_surface() -> None:
    """A flat ball's middle with a normal tilted by 30° to the right, under a light from there, is lit in full."""
    maps = measure_maps()
    tilted = np.zeros_like(maps.normal)
    tilted[...] = (np.sin(np.radians(30.0)), 0.0, np.cos(np.radians(30.0)))
    plain = PbrMaps(
        np.full_like(maps.base_colour, 0.5), tilted, np.ones_like(maps.roughness), 0.0 * maps.metallic, 0.0 * maps.f0
    )
    view = sphere(12, 10, 11)
    middle = np.argmax(view.frame[:, 2, 2])
    lit = [
        maps_shown(plain)(view, one_light(np.sin(np.radians(a)), 0.0, np.cos(np.radians(a))))[middle, 0]
        for a in (-30, 0, 30, 60)
    ]
    assert np.argmax(lit) == 2
    assert lit[0] < lit[1]


def test_the_material_loses_nothing_against_itself() -> None:
    material = woven_material()
    wanted = drain(references(material))
    assert set(wanted) == {"studio", "noon", "overcast"}
    assert drain(loss(material_shown(material), wanted, (24, 20))).mean_rmse_rel == 0.0
    maps, white = drain(nearest_maps(material))
    found = drain(loss(maps_shown(maps, np.pi * white), wanted, (24, 20)))
    assert 0.02 < found.mean_rmse_rel < 1.0
    assert 0.0 < found.mean_flip < 1.0


def test_photographs_of_the_maps_themselves_have_no_error() -> None:
    maps = measure_maps()
    lamps = np.array([[0.8, 0.0, 0.6], [0.0, 0.6, 0.8], [0.0, 0.0, 1.0]])
    rows, columns = (grid.ravel() for grid in np.mgrid[0:12, 0:10])
    view = dataclasses.replace(
        sphere(12, 10, 4),
        row=rows,
        column=columns,
        frame=np.tile(np.eye(3), (120, 1, 1)),
        wo=np.tile((0.0, 0.0, 1.0), (120, 1)),
    )
    photographs = [maps_shown(maps)(view, one_light(*lamp)).reshape(12, 10, 3) for lamp in lamps]
    stack = ImageStack(
        radiance=np.array(photographs, np.float32),
        saturated=np.zeros((3, 12, 10), np.bool_),
        elevation=np.arcsin(lamps[:, 2]),
        azimuth=np.arctan2(lamps[:, 1], lamps[:, 0]),
        mean_radiance=np.ones(3),
        sources=("a", "b", "c"),
        angle_source="user",
    )
    assert drain(photograph_error(maps_shown(maps), stack)) < 1e-6
    darker = dataclasses.replace(maps, base_colour=0.5 * maps.base_colour)
    assert drain(photograph_error(maps_shown(darker), stack)) == pytest.approx(0.5, abs=0.2)
    mask = np.zeros((12, 10), np.bool_)
    mask[:, 4:] = True
    before = dataclasses.replace(stack, radiance=np.where(mask[..., None], stack.radiance[:], np.float32(3.0)))
    assert drain(photograph_error(maps_shown(maps), before)) > 0.5
    assert drain(photograph_error(maps_shown(maps), before, mask)) < 1e-6


def test_the_background_of_an_object_does_not_count() -> None:
    material = woven_material()
    mask = np.zeros((24, 20), np.bool_)
    mask[5:19, 4:] = True
    maps, white = drain(nearest_maps(material))
    other = dataclasses.replace(maps, base_colour=np.where(mask[..., None], maps.base_colour, np.float32(0.0)))
    wanted = drain(references(material))
    (whole, _), (own, black) = (
        [drain(loss(maps_shown(each, np.pi * white), wanted, (24, 20), part)) for each in (maps, other)]
        for part in (None, mask)
    )
    assert own.mean_rmse_rel == black.mean_rmse_rel != whole.mean_rmse_rel
    assert own.mean_flip == black.mean_flip
    nowhere = drain(loss(maps_shown(maps, np.pi * white), wanted, (24, 20), np.zeros((24, 20), np.bool_)))
    assert nowhere.mean_rmse_rel == whole.mean_rmse_rel
