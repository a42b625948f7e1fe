"""Materials of which some tiles keep their slices, drawn by both renderers."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from engine.core.steps import drain
from engine.gl.context import limits
from engine.gl.direct import DirectRenderer
from engine.render.direct import radiance
from engine.render.display import Display, display
from engine.scene.material import Material
from engine.scene.scene import LOOKUPS, Scene
from engine.shading.mixed import keep_tiles
from engine.shading.power_law import fit
from tests.engine.scenes import scene, weave

SIZE = (120, 90)


def make_crooked() -> Material:
    """A weave with a corner that darkens under more light, which no power law describes."""
    material = weave(64)
    assert material.shading_map is not None
    slices = material.shading_map.slices.copy()
    slices[1:, :30, :30] = slices[:0:-1, :30, :30]
    shading_map = dataclasses.replace(material.shading_map, slices=slices)
    return dataclasses.replace(material, shading_map=shading_map, power_law=drain(fit(shading_map)))


def mix(material: Material, bound: float) -> Material:
    assert material.power_law is not None
    assert material.shading_map is not None
    kept = drain(keep_tiles(material.power_law, material.shading_map, bound))
    return dataclasses.replace(material, power_law=kept)


def pair_scene(material: Material, **options: Any) -> Scene:
    return scene("sphere", material, source="power-law", light=(0.4, 0.5, 0.8), **options)


def draw(gl: Any, what: Scene, **options: Any) -> Any:
    renderer = DirectRenderer(gl, **options)
    image = renderer.radiance(what, SIZE, samples=1)
    messages = renderer.messages
    renderer.release()
    return image, messages


@pytest.fixture(scope="module")
def material() -> Material:
    return make_crooked()


@pytest.mark.parametrize("above", ["clamp", "scale"])
@pytest.mark.parametrize("lookup", LOOKUPS)
def test_GL8_both_renderers_agree_on_mixed_materials(gl: Any, material: Material, lookup: Any, above: Any) -> None:
    what = pair_scene(mix(material, 0.05), lookup=lookup, above=above)
    assert what.material is not None
    kept = what.material.power_law.kept  # type: ignore[union-attr]
    assert kept is not None
    assert 0 < (kept.place >= 0).sum() < kept.place.size
    drawn, _ = draw(gl, what)
    computed = drain(radiance(what, SIZE, samples=1))
    codes = [display(image, Display()).astype(int) for image in (drawn, computed)]
    different = np.abs(codes[0] - codes[1]).max(axis=-1)
    assert np.quantile(different, 0.999) <= 1


def test_tiles_that_are_all_kept_look_like_the_slices(gl: Any, material: Material) -> None:
    everything = mix(material, 0.0)
    by_slices, _ = draw(gl, dataclasses.replace(pair_scene(everything), source="slices"))
    by_tiles, _ = draw(gl, pair_scene(everything))
    np.testing.assert_allclose(by_tiles, by_slices, rtol=1e-4, atol=1e-6)
    by_pair, _ = draw(gl, pair_scene(material))
    assert np.abs(by_pair - by_slices).max() > 0.05


def test_keeping_what_a_power_law_cannot_describe_is_nearer_to_the_slices(gl: Any, material: Material) -> None:
    truth, _ = draw(gl, dataclasses.replace(pair_scene(material), source="slices"))
    errors = [np.abs(draw(gl, pair_scene(form))[0] - truth).mean() for form in (material, mix(material, 0.05))]
    assert errors[1] < 0.2 * errors[0]


def test_a_device_with_few_layers_shows_the_power_law_and_says_so(gl: Any, material: Material) -> None:
    few = dataclasses.replace(limits(gl), layers=4)
    image, messages = draw(gl, pair_scene(mix(material, 0.05)), texture_limits=few)
    assert any("keep their slices" in message for message in messages)
    plain, _ = draw(gl, pair_scene(material))
    assert np.array_equal(image, plain)


def test_an_environment_sums_over_kept_tiles_too(gl: Any, material: Material) -> None:
    from engine.light.environment import DistantLights

    what = pair_scene(mix(material, 0.05))
    directions = np.array([(0.4, 0.5, 0.8), (-0.5, 0.2, 0.8), (0.0, 0.0, 1.0)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    single = [dataclasses.replace(what, light=tuple(direction)) for direction in directions]
    together = dataclasses.replace(what)
    together.__dict__["lights"] = DistantLights(directions, np.ones((3, 3)))
    expected = sum(draw(gl, one)[0][..., :3] for one in single)
    drawn, _ = draw(gl, together)
    np.testing.assert_allclose(drawn[..., :3], expected, rtol=2e-4, atol=1e-5)
    computed = drain(radiance(together, SIZE, samples=1))
    assert np.quantile(np.abs(computed[..., :3] - drawn[..., :3]).max(axis=-1), 0.999) < 1e-3
