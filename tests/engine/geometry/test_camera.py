"""The camera: framing, rays and matrices agree."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from engine.core.directions import dot
from engine.geometry.camera import Camera, frame, orbit, pan, parse, unparse, zoom

CAMERA = Camera((0.0, 0.0, 4.0))


def pixels(
    camera: Camera, points: np.ndarray, width: int, height: int, origin: tuple[float, ...] = (0, 0, 0)
) -> np.ndarray:
    """Image positions (column, row) of world points through the projection matrix."""
    matrix = camera.clip_from_model(origin, 2.0, width / height)
    clip = np.concatenate([points - origin, np.ones((len(points), 1))], axis=1) @ matrix.T
    ndc = clip[:, :2] / clip[:, 3:]
    return (ndc * (1.0, -1.0) + 1.0) / 2.0 * (width, height)


def test_the_field_of_view_is_vertical_and_the_image_upright() -> None:
    half_height = 4.0 * np.tan(np.radians(35.0) / 2)
    points = np.array([[0.0, half_height, 0.0], [half_height, 0.0, 0.0], [0.0, 0.0, 0.0]])
    assert pixels(CAMERA, points, 400, 200) == pytest.approx(np.array([[200, 0], [300, 100], [200, 100]]), abs=1e-9)


@pytest.mark.parametrize("origin", [(0.0, 0.0, 0.0), (0.3, -0.2, 0.5)])
def test_rays_go_through_the_pixels_that_the_matrix_gives(origin: tuple[float, ...]) -> None:
    camera = Camera((3.0, 2.0, 5.0), (0.2, 0.1, 0.0), fov_deg=50.0)
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (50, 3))
    column, row = pixels(camera, points, 321, 123, origin).T
    rays = camera.rays(column, row, 321, 123)
    towards = points - camera.eye
    assert dot(rays, towards) == pytest.approx(np.linalg.norm(towards, axis=1), rel=1e-12)


@pytest.mark.parametrize("aspect", [0.3, 1.0, 2.5])
@pytest.mark.parametrize("direction", [(0.0, 0.0, 1.0), (1.0, 1.0, 1.0), (0.0, 1.0, 0.0)])
@pytest.mark.parametrize("shift", [0.0, 1e5])
def test_framing_shows_the_whole_object_and_fills_the_image(
    aspect: float, direction: tuple[float, float, float], shift: float
) -> None:
    points = np.random.default_rng(3).normal(size=(500, 3)) * (1.0, 0.2, 0.5) + shift
    camera = frame(points, aspect, direction=direction)
    centre = (points.min(0) + points.max(0)) / 2
    matrix = camera.clip_from_model(centre, 6.0, aspect)
    clip = np.concatenate([points - centre, np.ones((500, 1))], axis=1) @ matrix.T
    reach = np.abs(clip[:, :2] / clip[:, 3:]).max()
    assert 0.9 <= reach <= 1.0


@pytest.mark.parametrize("distance", [1e12, 1e30, 1e80])
@pytest.mark.parametrize("radius", [1e-3, 1.0, 1e15])
def test_from_however_far_the_matrix_fits_single_precision_and_shows_a_point(distance: float, radius: float) -> None:
    camera = Camera((distance * radius, distance * radius, 0.0))
    with np.errstate(all="raise"):
        matrix = camera.clip_from_model((0.0, 0.0, 0.0), radius, 1.5).astype(np.float32)
    clip = np.array([[radius, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]]) @ matrix.astype(np.float64).T
    assert np.abs(clip[:, :2] / clip[:, 3:]).max() < 1e-8
    assert (np.abs(clip[:, 2] / clip[:, 3]) <= 1.0 + 1e-6).all()


def test_text_round_trip_and_defaults() -> None:
    camera = Camera((1.5, 2.0, 4.0), (0.1, 0.2, 0.3), (0.0, 0.0, 1.0), 42.0)
    assert parse(unparse(camera), CAMERA) == camera
    assert parse("fov_deg=50", CAMERA) == dataclasses.replace(CAMERA, fov_deg=50.0)
    assert parse("", CAMERA) == CAMERA


@pytest.mark.parametrize(
    "text",
    [
        "eye=1,2",
        "eye=a,b,c",
        "lens=3",
        "fov_deg=0",
        "fov_deg=nan",
        "eye=nan,0,1",
        "eye=1e101,0,1",
        "eye=0,0,0",
        "up=0,0,1",
        "eye",
    ],
)
def test_bad_text_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        parse(text, CAMERA)


def test_orbit_keeps_the_distance_and_never_rolls_over_the_pole() -> None:
    turned = orbit(CAMERA, np.pi / 2, 0.0)
    assert turned.eye == pytest.approx((4.0, 0.0, 0.0), abs=1e-12)
    over = orbit(CAMERA, 0.0, 10.0)
    assert np.linalg.norm(over.eye) == pytest.approx(4.0)
    assert over.eye[1] == pytest.approx(4.0, rel=1e-5)


def test_pan_and_zoom() -> None:
    assert zoom(CAMERA, 0.5).eye == pytest.approx((0.0, 0.0, 2.0))
    moved = pan(CAMERA, 0.5, 0.0)
    assert pixels(moved, np.zeros((1, 3)), 200, 200)[0] == pytest.approx((0.0, 100.0))
