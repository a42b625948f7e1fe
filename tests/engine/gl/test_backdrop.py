"""The environment behind an image on the screen is the one that saved images have."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.geometry.camera import Camera
from engine.gl.screen import Image, Layer, Screen
from engine.light.environment import EnvironmentMap
from engine.render.background import Backdrop
from engine.render.display import Display
from engine.render.display import display as display_image


def test_the_screen_shows_what_a_saved_image_has(gl: Any) -> None:
    draw = np.random.default_rng(4)
    texels = np.repeat(np.repeat(draw.uniform(0.1, 0.9, (8, 16, 3)), 8, axis=0), 8, axis=1).astype(np.float32)
    camera = Camera((0.3, 0.5, 3.0), (0.1, 0.0, 0.0), (0.0, 1.0, 0.0), 50.0)
    backdrop = Backdrop(EnvironmentMap(texels, "patches"), camera, rotation=0.7, gain=0.8)
    pixels = np.zeros((40, 64, 4), np.float32)
    pixels[10:20, 20:40] = (0.3, 0.2, 0.1, 1.0)
    pixels[20:30, 20:40] = (0.15, 0.1, 0.05, 0.5)
    image, screen = Image(gl, (64, 40)), Screen(gl)
    image.write(pixels)
    target = gl.simple_framebuffer((64, 40))
    display = Display(0.5, "none")
    screen.show(Layer(image), target, display, behind=backdrop)
    shown = np.frombuffer(target.read(components=3), np.uint8).reshape(40, 64, 3)[::-1].astype(int)
    expected = display_image(backdrop.behind(pixels), display).astype(int)
    assert np.abs(shown - expected).max() <= 2
    screen.show(Layer(image), target, display)
    plain = np.frombuffer(target.read(components=3), np.uint8).reshape(40, 64, 3)[::-1].astype(int)
    assert np.abs(plain - display_image(pixels, display)).max() <= 1
    for owner in (screen, image, target):
        owner.release()
