"""Lobes on the graphics device: where they stand, which one is in front, and what is drawn beside them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from engine.core.directions import surface_direction
from engine.geometry.camera import Camera
from engine.gl.lobe import LobeColours, LobeRenderer, LobeSurface, Rgb

SIZE = (240, 240)
BACKGROUND = (0.0, 0.0, 0.0)
COLOURS = LobeColours(BACKGROUND, rings=(0.0, 0.0, 1.0), light=(0.0, 1.0, 0.0))

#: Nearly parallel, along the world's −Z: the image shows the surface's tangent to the right and its normal upwards.
FRONT = Camera((0.0, 0.5, 100.0), (0.0, 0.5, 0.0), fov_deg=1.5)
HALF_HEIGHT = 100.0 * np.tan(np.radians(0.75))


def hemisphere(radius: float, colour: Rgb, rows: int = 64, columns: int = 65) -> LobeSurface:
    theta = np.linspace(0.0, 0.5 * np.pi, rows)[:, None]
    phi = np.linspace(0.0, 2.0 * np.pi, columns)[None]
    points = radius * surface_direction(theta, phi)
    angles = np.stack(np.broadcast_arrays(np.degrees(theta), np.degrees(phi)), axis=-1)
    return LobeSurface(points.astype(np.float32), angles.astype(np.float32), colour)


def draw(gl: Any, surfaces: Sequence[LobeSurface], light: tuple[float, float] = (0.7, np.pi)) -> np.ndarray:
    renderer = LobeRenderer(gl)
    framebuffer = gl.simple_framebuffer(SIZE)
    renderer.draw(framebuffer, surfaces, light, FRONT, COLOURS)
    image = np.frombuffer(framebuffer.read(components=3), np.uint8).reshape(SIZE[1], SIZE[0], 3)[::-1]
    renderer.release()
    return image / 255.0


def test_a_constant_lobe_is_half_a_disc_of_its_radius(gl: Any) -> None:
    image = draw(gl, [hemisphere(0.8, (1.0, 0.0, 0.0))])
    lobe = (image[..., 0] > 0.1) & (image[..., 1] == 0.0)
    pixel = 2.0 * HALF_HEIGHT / SIZE[1]
    # the light's lines, drawn in green, and the rings hide a little of it
    assert lobe.sum() * pixel**2 == pytest.approx(0.5 * np.pi * 0.8**2, rel=0.04)
    rows, columns = np.nonzero(lobe)
    across = (columns + 0.5 - SIZE[0] / 2) * pixel
    above = 0.5 - (rows + 0.5 - SIZE[1] / 2) * pixel
    assert [across.min(), across.max(), above.max()] == pytest.approx([-0.8, 0.8, 0.8], abs=2 * pixel)
    assert above.min() == pytest.approx(0.0, abs=2 * pixel)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_larger_lobe_hides_the_smaller_whatever_the_order(gl: Any, order: tuple[int, int]) -> None:
    both = [hemisphere(0.5, (1.0, 0.0, 0.0)), hemisphere(0.8, (1.0, 0.0, 1.0))]
    image = draw(gl, [both[place] for place in order])
    inside = image[SIZE[1] // 2, SIZE[0] // 2]
    assert inside[2] > 0.2


@pytest.mark.parametrize(("phi", "side"), [(np.pi, -1), (0.0, 1)])
def test_the_light_is_drawn_where_it_comes_from(gl: Any, phi: float, side: int) -> None:
    image = draw(gl, [], (np.radians(40.0), phi))
    green = (image[..., 1] > 0.5) & (image[..., 2] < 0.5)
    pixel = 2.0 * HALF_HEIGHT / SIZE[1]
    rows, columns = np.nonzero(green)
    across = (columns + 0.5 - SIZE[0] / 2) * pixel
    above = 0.5 - (rows + 0.5 - SIZE[1] / 2) * pixel
    lit = across * side > 0.0
    assert np.abs(np.degrees(np.arctan2(np.abs(across), above)) - 40.0)[above > 0.3].max() < 2.5
    # the arrow is a whole line, its mirror direction is dashed
    assert lit[above > 0.3].sum() > 1.5 * (~lit[above > 0.3]).sum()
    assert above[lit].max() == pytest.approx(1.15 * np.cos(np.radians(40.0)), abs=2 * pixel)


def test_lobes_are_uploaded_again_only_when_they_are_others(gl: Any) -> None:
    renderer = LobeRenderer(gl)
    framebuffer = gl.simple_framebuffer(SIZE)
    surfaces = [hemisphere(0.8, (1.0, 0.0, 0.0))]
    renderer.draw(framebuffer, surfaces, (0.5, 0.0), FRONT, COLOURS)
    first = renderer._surfaces[1][0][0]
    renderer.draw(framebuffer, surfaces, (0.6, 0.0), FRONT, COLOURS)
    assert renderer._surfaces[1][0][0] is first
    renderer.draw(framebuffer, [], (0.6, 0.0), FRONT, COLOURS)
    assert renderer._surfaces[1] == []
    renderer.release()
    framebuffer.release()


def test_a_translucent_lobe_is_seen_in_front_of_the_current_one_and_hides_nothing(gl: Any) -> None:
    inside, shell = hemisphere(0.5, (1.0, 0.0, 0.0)), hemisphere(0.8, (0.0, 0.0, 1.0))
    image = draw(gl, [LobeSurface(shell.points, shell.angles_deg, shell.colour, opacity=0.3), inside])
    middle = image[SIZE[1] // 2 + 20, SIZE[0] // 2 + 20]
    assert middle[0] > middle[2] > 0.02
    alone = draw(gl, [inside])[SIZE[1] // 2 + 20, SIZE[0] // 2 + 20]
    assert middle[0] == pytest.approx(0.7 * alone[0], abs=0.02)


def test_the_image_stays_opaque_under_translucent_lobes(gl: Any) -> None:
    """A window is composed with the alpha of the image."""
    shell = hemisphere(0.8, (0.0, 0.0, 1.0))
    renderer, framebuffer = LobeRenderer(gl), gl.simple_framebuffer(SIZE, 4)
    renderer.draw(
        framebuffer,
        [LobeSurface(shell.points, shell.angles_deg, shell.colour, opacity=0.3)],
        (0.7, 0.0),
        FRONT,
        COLOURS,
    )
    assert set(framebuffer.read(components=4)[3::4]) == {255}
    renderer.release()
