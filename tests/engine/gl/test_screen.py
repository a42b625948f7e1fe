"""Linear images in GPU memory and how they come to the screen: shown, side by side, subtracted, enlarged."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.core.colour import OPERATORS, luminance, srgb_encode
from engine.gl.screen import Image, Layer, Screen
from engine.render.display import Display, diverging
from engine.render.display import display as display_image
from tests.engine.gl_objects import living_objects

SIZE = (40, 24)


def pixels(seed: int, size: tuple[int, int] = SIZE) -> np.ndarray:
    """Radiance from 0 to 8 times coverage, which is 0 to 1."""
    random = np.random.default_rng(seed)
    coverage = np.clip(random.random((size[1], size[0], 1)) * 1.6 - 0.3, 0.0, 1.0)
    return np.concatenate([8.0 * random.random((size[1], size[0], 3)) ** 4 * coverage, coverage], axis=2).astype("f4")


def image_of(gl: Any, content: np.ndarray) -> Image:
    image = Image(gl, (content.shape[1], content.shape[0]))
    image.write(content)
    return image


def observe(framebuffer: Any) -> np.ndarray:
    width, height = framebuffer.size
    return np.frombuffer(framebuffer.read(alignment=1), np.uint8).reshape(height, width, 3)[::-1].astype(int)


def test_what_is_written_is_read_back_whole_and_in_strips(gl: Any) -> None:
    content = pixels(0)
    image = image_of(gl, content)
    assert np.array_equal(image.read(), content)
    assert np.array_equal(np.concatenate([image.read(first, 7) for first in range(0, 24, 7)]), content)
    image.release()


@pytest.mark.parametrize("operator", OPERATORS)
@pytest.mark.parametrize("exposure_ev", [-3.0, 0.0, 6.0])
def test_GL8_a_image_is_shown_as_the_engine_shows_it(gl: Any, operator: Any, exposure_ev: float) -> None:
    content, display = pixels(1), Display(exposure_ev, operator, (0.1, 0.2, 0.05))
    framebuffer = gl.simple_framebuffer(SIZE, 3)
    Screen(gl).show(Layer(image_of(gl, content)), framebuffer, display)
    assert np.abs(observe(framebuffer) - display_image(content, display)).max() <= 1


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_a_better_image_covers_by_its_share(gl: Any, share: float) -> None:
    one, other = pixels(2), pixels(3)
    framebuffer = gl.simple_framebuffer(SIZE, 3)
    Screen(gl).show(Layer(image_of(gl, one), image_of(gl, other), share), framebuffer, Display())
    mixed = (1.0 - share) * one + np.float32(share) * other
    assert np.abs(observe(framebuffer) - display_image(mixed.astype("f4"), Display())).max() <= 1


@pytest.mark.parametrize("middle", [0, 1, 17, 40])
def test_two_images_share_the_screen_without_a_gap(gl: Any, middle: int) -> None:
    one, other = pixels(4), pixels(5)
    framebuffer, screen = gl.simple_framebuffer(SIZE, 3), Screen(gl)
    screen.show(Layer(image_of(gl, one)), framebuffer, Display(), (0, middle))
    screen.show(Layer(image_of(gl, other)), framebuffer, Display(), (middle, SIZE[0]))
    expected = np.concatenate([one[:, :middle], other[:, middle:]], axis=1)
    assert np.abs(observe(framebuffer) - display_image(expected, Display())).max() <= 1


def test_the_difference_is_that_of_the_engine_where_both_are_covered(gl: Any) -> None:
    one, other, display = pixels(6), pixels(7), Display(background=(0.3, 0.1, 0.2))
    one[:12, :, 3] = other[:12, :, 3] = 1.0
    framebuffer = gl.simple_framebuffer(SIZE, 3)
    layers = Layer(image_of(gl, one)), Layer(image_of(gl, other))
    Screen(gl).show_difference(*layers, framebuffer, display, 2.0)
    apart = luminance(one[..., :3]) - luminance(other[..., :3])
    covered = np.minimum(one[..., 3], other[..., 3]) > 0.999
    background = np.round(255.0 * np.asarray(srgb_encode(list(display.background))))
    expected = np.where(covered[..., None], diverging(apart / 2.0), background)
    assert 0.5 < covered.mean() < 1.0
    assert np.abs(observe(framebuffer) - expected).max() <= 1


def test_a_image_of_fewer_pixels_fills_the_screen(gl: Any) -> None:
    small = np.ones((3, 5, 4), np.float32) * (0.2, 0.4, 0.6, 1.0)
    framebuffer = gl.simple_framebuffer(SIZE, 3)
    Screen(gl).show(Layer(image_of(gl, small.astype("f4"))), framebuffer, Display())
    assert np.ptp(observe(framebuffer), axis=(0, 1)).max() == 0


def test_GL1_GL2_what_is_not_finite_or_huge_is_shown_without_harm(gl: Any) -> None:
    content = np.ones((2, 4, 4), np.float32)
    content[0] = [[np.inf] * 3 + [1.0], [1e30] * 3 + [1.0], [0.0] * 4, [-0.0] * 4]
    framebuffer = gl.simple_framebuffer((4, 2), 3)
    for operator in OPERATORS:
        Screen(gl).show(Layer(image_of(gl, content)), framebuffer, Display(20.0, operator))
        top = observe(framebuffer)[0]
        assert (top[:2] >= 254).all()
        assert (top[2:] == top[2]).all()


def test_GL9_images_and_screens_leave_nothing_behind(gl: Any) -> None:
    framebuffer = gl.simple_framebuffer(SIZE, 3)
    before = living_objects()
    for turn in range(20):
        image, screen = image_of(gl, pixels(turn)), Screen(gl)
        screen.show(Layer(image), framebuffer, Display())
        image.release()
        screen.release()
    left = living_objects()
    assert left.pop("Program") - before.pop("Program") <= 1, "the one in use goes when another is used"
    assert left.pop("Shader") - before.pop("Shader") <= 2
    assert left == before
