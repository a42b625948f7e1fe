"""Lamps that are near, or differ in intensity: what two spheres, a white patch and the object itself tell of them."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.lamp_gains import object_gains, patch_gains
from engine.capture.lights.mirror_sphere import Circle, find_sphere
from engine.capture.lights.sources import find
from engine.capture.lights.two_spheres import lamp_positions
from engine.capture.photograph.grey_patch import GreyPatch
from engine.core.errors import InputError, UsageError
from engine.core.steps import drain

HEIGHT, WIDTH = 300, 400
SPHERES = (Circle(60.0, 240.0, 40.0), Circle(340.0, 60.0, 40.0))
LAMPS = np.array([[500.0, 100.0, 300.0], [-200.0, 350.0, 420.0], [0.0, -300.0, 500.0], [30.0, 20.0, 700.0]])


def spot(sphere: Circle, lamp: Any) -> tuple[float, float]:
    """The point at which an orthographic camera sees the lamp: its normal halves the angle (found by iteration)."""
    centre = np.array([sphere.column - WIDTH / 2, HEIGHT / 2 - sphere.row, sphere.radius])
    normal = np.array([0.0, 0.0, 1.0])
    for _ in range(200):
        to_lamp = lamp - (centre + sphere.radius * normal)
        normal = to_lamp / np.linalg.norm(to_lamp) + (0.0, 0.0, 1.0)
        normal /= np.linalg.norm(normal)
    return sphere.column + sphere.radius * normal[0], sphere.row - sphere.radius * normal[1]


def test_two_spheres_show_where_lamps_stand() -> None:
    spots = np.array([[spot(sphere, lamp) for sphere in SPHERES] for lamp in LAMPS])
    assert lamp_positions(SPHERES, spots, HEIGHT, WIDTH) == pytest.approx(LAMPS, abs=1e-6)
    far = np.array([[spot(sphere, 1e6 * lamp) for sphere in SPHERES] for lamp in LAMPS])
    assert np.isinf(lamp_positions(SPHERES, far, HEIGHT, WIDTH)).all()
    with pytest.raises(UsageError, match="outline"):
        lamp_positions(SPHERES, np.zeros((1, 2, 2)), HEIGHT, WIDTH)


def scene(lamp: Any) -> Any:
    """A grey sample with two dark spheres and their highlights."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    image = np.full((HEIGHT, WIDTH), 0.25 + 0.2 * lamp[2] / np.linalg.norm(lamp))
    for sphere in SPHERES:
        inside = np.hypot(columns + 0.5 - sphere.column, rows + 0.5 - sphere.row) < sphere.radius
        image[inside] = 0.02
        column, row = spot(sphere, lamp)
        image += np.exp(-((columns + 0.5 - column) ** 2 + (rows + 0.5 - row) ** 2) / 4.0) * inside
    return np.clip(image, 0, 1)


def write(place: Path, images: Any) -> Path:
    place.mkdir()
    for index, image in enumerate(images):
        codes = np.uint16(65535 * np.repeat(image[..., None], 3, axis=2))
        (place / f"light_{index:02}.png").write_bytes(cv2.imencode(".png", codes)[1].tobytes())
    return place


def test_near_lamps_of_photographs_with_two_spheres(tmp_path: Path) -> None:
    place = write(tmp_path / "p", [scene(lamp) for lamp in LAMPS])
    settings = ImportSettings(motion="none", transfer="linear", second_sphere="auto")
    stack = drain(import_stack(find([place], sphere=SPHERES[0]), settings, tmp_path / "s"))
    lamps = LAMPS[np.argsort(LAMPS[:, 2] / np.linalg.norm(LAMPS, axis=1))]
    lengths = np.linalg.norm(lamps, axis=1)
    assert stack.elevation_deg == pytest.approx(np.degrees(np.arcsin(lamps[:, 2] / lengths)), abs=1.5)
    distance = stack.provenance["lamp_distance_widths"]
    assert distance == pytest.approx(np.median(np.linalg.norm(LAMPS, axis=1)) / WIDTH, rel=0.08)
    with pytest.raises(InputError, match="no first mirror sphere"):
        drain(import_stack(find([place], [10, 20, 30, 40]), settings, tmp_path / "t"))


def test_a_second_sphere_is_found_beside_the_first() -> None:
    images = np.stack([scene(lamp) for lamp in LAMPS]).astype(np.float32)
    for first, other in (SPHERES, SPHERES[::-1]):
        found = find_sphere(images, first)
        assert (found.column, found.row, found.radius) == pytest.approx(
            (other.column, other.row, other.radius), abs=1.5
        )


def dome(count: int) -> tuple[Any, Any]:
    """Elevations and azimuths of lamps evenly on a hemisphere (golden spiral)."""
    height = 0.1 + 0.85 * (np.arange(count) + 0.5) / count
    return np.arcsin(height), np.mod(np.arange(count) * 2.399963, 2 * np.pi)


def test_gains_of_a_white_patch_are_exact_up_to_one_factor() -> None:
    elevation, _ = dome(12)
    gains = np.random.default_rng(1).uniform(0.5, 1.5, 12)
    found = patch_gains(0.37 * gains * np.sin(elevation), elevation)
    assert found == pytest.approx(gains / np.median(gains), rel=1e-12)


def test_gains_of_an_object_are_found_beside_a_smooth_reflectance() -> None:
    """One lamp of half the intensity turns nothing else; a gain that changes smoothly stays, as is said."""
    elevation, azimuth = dome(48)
    smooth = np.sin(elevation) * np.exp(0.3 * np.cos(elevation) * np.cos(azimuth) - 1.5 * np.cos(elevation) ** 2)
    gains = np.ones(48)
    gains[[5, 20, 33]] = 0.5, 1.6, 0.8
    found = object_gains(0.2 * smooth * gains, elevation, azimuth)
    assert found == pytest.approx(gains, abs=0.02)
    assert object_gains(0.2 * smooth, elevation, azimuth) == pytest.approx(np.ones(48), abs=0.02)


@pytest.mark.parametrize("how", ["object", GreyPatch(10, 20, 40, 30)])
def test_lamps_of_photographs_are_equalised(tmp_path: Path, how: Any) -> None:
    elevation, azimuth = dome(16)
    gains = np.ones(16)
    gains[[3, 9]] = 0.6, 1.4
    texture = 1 + 0.2 * np.random.default_rng(2).uniform(-1, 1, (60, 80))
    place = write(tmp_path / "p", [0.5 * g * np.sin(e) * texture for g, e in zip(gains, elevation, strict=True)])
    directions = np.stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], axis=1
    )
    lines = [f"light_{index:02}.png {x:.9f} {y:.9f} {z:.9f}" for index, (x, y, z) in enumerate(directions)]
    (place / "dome.lp").write_text("\n".join(["16", *lines]))
    settings = ImportSettings(motion="none", transfer="linear", equalise=how)
    stack = drain(import_stack(find([place]), settings, tmp_path / "s"))
    assert stack.provenance["lamp_gains"] == pytest.approx(gains, abs=0.06)
    brightness = stack.mean_radiance / np.sin(elevation)
    assert brightness.max() / brightness.min() < 1.08
    assert any("Lamps were equalised by" in finding.text for finding in stack.health.findings)


def test_few_lamps_do_not_tell_their_gains(tmp_path: Path) -> None:
    place = write(tmp_path / "p", [np.full((20, 30), 0.2 + 0.1 * index) for index in range(4)])
    settings = ImportSettings(motion="none", equalise="object")
    with pytest.raises(InputError, match="too few to separate"):
        drain(import_stack(find([place], [10, 20, 30, 40]), settings, tmp_path / "s"))
