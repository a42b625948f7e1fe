"""A scene's lights and surface: what lamps and a ground add to them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.core.directions import dot
from engine.core.steps import drain
from engine.geometry.ground import Ground
from engine.gl.direct import DirectRenderer
from engine.light.environment_file import open_environment
from engine.light.lamps import Lamp, lights_of_all
from engine.render.direct import radiance
from engine.scene.scene import MAX_LAMPS
from tests.engine.scenes import scene

SUN = Lamp((0.2, 0.9, 0.4), (2.0, 1.5, 1.0))
DISC = Lamp((-0.8, 0.3, 0.5), (0.5, 0.8, 1.0), 0.1)


def test_without_lamps_the_light_is_what_it_was() -> None:
    (direction,) = scene(light=(0.0, 0.0, 2.0)).lights.direction
    np.testing.assert_array_equal(direction, (0.0, 0.0, 1.0))


def test_lamps_come_after_the_light_and_keep_their_irradiance() -> None:
    shown = scene(lamps=(SUN, DISC), irradiance=3.0)
    lights = shown.lights
    np.testing.assert_array_equal(lights.irradiance[0], 3.0)
    np.testing.assert_array_equal(lights.irradiance[1], SUN.irradiance)
    cosine = dot(lights.direction[2:], DISC.direction)[:, None]
    np.testing.assert_allclose((lights.irradiance[2:] * cosine).sum(axis=0), DISC.irradiance, rtol=1e-12)


def test_lamps_alone_where_the_light_is_out() -> None:
    lights = scene(lamps=(SUN,), irradiance=0.0).lights
    np.testing.assert_array_equal(lights.irradiance, [SUN.irradiance])


def test_neither_the_factor_nor_the_rotation_of_the_environment_moves_lamps() -> None:
    sky = open_environment("sky")
    plain = scene(environment=sky, lamps=(DISC,)).lights
    turned = scene(environment=sky, lamps=(DISC,), irradiance=5.0, environment_rotation=1.0).lights
    np.testing.assert_array_equal(turned.direction[64:], plain.direction[64:])
    np.testing.assert_array_equal(turned.irradiance[64:], plain.irradiance[64:])
    assert len(plain.direction) == 64 + len(lights_of_all([DISC]).direction)


def test_too_many_lamps_are_refused() -> None:
    with pytest.raises(ValueError, match=f"at most {MAX_LAMPS} lamps"):
        scene(lamps=(SUN,) * (MAX_LAMPS + 1))


@pytest.mark.parametrize("renderer", ["gl", "cpu"])
def test_images_of_lamps_add_up(renderer: str, request: pytest.FixtureRequest) -> None:
    """Light is additive: the image under light and lamp is the sum of the images under each."""

    def image(**lights: Any) -> Any:
        shown = scene(brdf="phong:exponent=20", **lights)
        if renderer == "cpu":
            return drain(radiance(shown, (40, 30), samples=1))
        drawing = DirectRenderer(request.getfixturevalue("gl"))
        drawn = drawing.radiance(shown, (40, 30), samples=1)
        drawing.release()
        return drawn

    both, light, lamps = image(lamps=(SUN, DISC)), image(), image(lamps=(SUN, DISC), irradiance=0.0)
    assert lamps[..., :3].max() > 0.1
    np.testing.assert_allclose(both[..., :3], light[..., :3] + lamps[..., :3], atol=2e-6)


def test_the_surface_holds_the_model_and_then_the_ground() -> None:
    alone, shown = scene(), scene(ground=Ground(cells=4))
    assert alone.surface is alone.mesh
    np.testing.assert_array_equal(shown.surface.faces[: len(shown.mesh.faces)], shown.mesh.faces)
    assert len(shown.surface.faces) == len(shown.mesh.faces) + 32
    assert shown.surface is shown.surface
