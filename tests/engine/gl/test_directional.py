"""Directional maps as textures: both renderers draw the same image."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from engine.core.steps import drain
from engine.gl.context import Limits
from engine.gl.direct import DirectRenderer
from engine.light.lamps import Lamp
from engine.render.direct import radiance
from engine.render.display import Display, display
from engine.scene.scene import LOOKUPS, Scene
from engine.storage.records import MAX_PLANES
from tests.engine.domes import dome_material
from tests.engine.gl_objects import living_objects
from tests.engine.scenes import scene

SIZE = (120, 90)

LAMPS = (Lamp((-0.8, 0.1, 0.5), (0.8, 0.4, 0.2)), Lamp((0.1, 0.9, 0.2), (0.3, 0.5, 0.9)))


def draw(gl: Any, what: Scene, **options: Any) -> Any:
    renderer = DirectRenderer(gl, **options)
    image, messages = renderer.radiance(what, SIZE, samples=1), renderer.messages
    renderer.release()
    return image, messages


def assert_alike(drawn: Any, what: Scene) -> None:
    computed = drain(radiance(what, SIZE, samples=1))
    codes = [display(image, Display()).astype(int) for image in (drawn, computed)]
    assert codes[1].max() > 100
    different = np.abs(codes[0] - codes[1]).max(axis=-1)
    assert np.quantile(different, 0.995) <= 1


@pytest.mark.parametrize("above", ["clamp", "scale"])
@pytest.mark.parametrize("lookup", LOOKUPS)
def test_both_renderers_agree(gl: Any, lookup: Any, above: Any) -> None:
    what = scene("torus-knot", dome_material(), lamps=LAMPS, lookup=lookup, above=above)
    assert_alike(draw(gl, what)[0], what)


@pytest.mark.parametrize("brdf", ["lambert", "ggx:alpha_x=0.2,alpha_y=0.5", "phong:kd=0,ks=0.5,exponent=60"])
def test_both_renderers_agree_for_any_brdf(gl: Any, brdf: str) -> None:
    what = scene("sphere", dome_material(), brdf, light=(0.4, 0.5, 0.8))
    assert_alike(draw(gl, what)[0], what)


def test_another_brdf_or_material_is_uploaded_and_released(gl: Any) -> None:
    before = living_objects()
    renderer = DirectRenderer(gl)
    first = scene("sphere", dome_material(), "lambert")
    other = scene("sphere", dome_material(), "phong:exponent=60")
    images = [renderer.radiance(each, SIZE, samples=1) for each in (first, other, first)]
    renderer.release()
    assert np.abs(images[0] - images[1]).max() > 0.05
    assert (images[0] == images[2]).all()
    left = living_objects()
    assert left.pop("Program") - before.pop("Program") <= 1, "the one in use goes when another is used"
    assert left.pop("Shader") - before.pop("Shader") <= 2
    assert left == before


def test_a_small_device_shows_fewer_texels_and_says_so(gl: Any) -> None:
    material = dome_material()
    assert material.directional is not None
    planes = np.repeat(np.repeat(material.directional.planes, 16, axis=1), 16, axis=2)
    large = dataclasses.replace(material, directional=dataclasses.replace(material.directional, planes=planes))
    what = scene("sphere", large, "lambert")
    small = dataclasses.replace(DirectRenderer(gl).limits, texture_size=64)
    assert isinstance(small, Limits)
    _, messages = draw(gl, what, texture_limits=small)
    assert any("64" in message for message in messages)


def test_both_renderers_agree_from_afar(gl: Any) -> None:
    """Many repeats, so that all is drawn from small sizes, which no mean of codes is."""
    what = scene("torus-knot", dome_material(), "lambert:albedo=0.5", repeats=40.0)
    assert_alike(draw(gl, what)[0], what)


def test_as_many_planes_as_a_map_may_have(gl: Any) -> None:
    """Planes whose sums are those of fewer: the same image."""
    material = dome_material()
    few = material.directional
    assert few is not None
    times = MAX_PLANES // len(few.planes)
    many = dataclasses.replace(
        few,
        planes=np.tile(few.planes, (times, 1, 1)),
        low=np.tile(few.low, times) / times,
        step=np.tile(few.step, times) / times,
        vectors=np.tile(few.vectors, times),
    )
    what = scene("sphere", dataclasses.replace(material, directional=many), "lambert", light=(0.4, 0.5, 0.8))
    same = scene("sphere", material, "lambert", light=(0.4, 0.5, 0.8))
    assert_alike(draw(gl, what)[0], same)
