"""Mirror balls and angular maps of a known sky, drawn here pixel by pixel, as environments."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.images.encode import rgb_channels, write_exr
from engine.light.environment import solid_angles, texel_directions
from engine.light.environment_file import open_environment

Numbers = NDArray[np.float64]

SIDE = 128


def sky(direction: Numbers) -> Numbers:
    """Smooth light that tells every direction from every other."""
    x, y, z = np.moveaxis(direction, -1, 0)
    return np.stack([2.0 + x + 0.3 * y * z, 2.0 + y + 0.3 * x * z, 2.0 + z + 0.3 * x * y], axis=-1)


def draw(form: str) -> NDArray[np.float32]:
    """(SIDE, SIDE, 3) by reflection of rays on a ball, or by angles; black without the circle."""
    steps = (np.arange(SIDE) + 0.5) / SIDE * 2.0 - 1.0
    x, y = np.meshgrid(steps, -steps)
    r = np.hypot(x, y)
    if form == "ball":
        normal = np.stack([x, y, np.sqrt(np.maximum(1.0 - r * r, 0.0))], axis=-1)
        ray = np.array((0.0, 0.0, -1.0))
        direction = ray - 2.0 * (normal @ ray)[..., None] * normal
    else:
        angle = np.pi * r
        direction = np.stack([np.sin(angle) * x / r, np.sin(angle) * y / r, -np.cos(angle)], axis=-1)
    image: NDArray[np.float32] = np.where(r[..., None] <= 1.0, sky(direction), 0.0).astype(np.float32)
    return image


@pytest.mark.parametrize("form", ["ball", "angular"])
def test_the_light_comes_back(tmp_path: Path, form: str) -> None:
    path = tmp_path / "probe.exr"
    write_exr(path, rgb_channels(draw(form)))
    found = np.asarray(open_environment(f"{form}:{path}").radiance, np.float64)
    assert found.shape == (SIDE // 2, SIDE, 3)
    wanted, weight = sky(texel_directions(*found.shape[:2])), solid_angles(*found.shape[:2])[..., None]
    apart = np.sqrt(np.sum(weight * (found - wanted) ** 2) / np.sum(weight * wanted**2))
    assert apart < (0.02 if form == "ball" else 0.005)
    assert np.sum(weight * found) == pytest.approx(np.sum(weight * wanted), rel=0.01)


def test_a_square_image_says_how_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "probe.exr"
    write_exr(path, rgb_channels(draw("ball")))
    with pytest.raises(InputError, match="ball:FILE"):
        open_environment(str(path))
    write_exr(path, rgb_channels(np.ones((4, 8, 3), np.float32)))
    with pytest.raises(InputError, match="square"):
        open_environment(f"ball:{path}")
