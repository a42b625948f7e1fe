"""The CPU renderer by itself: predicted radiance, steps, sizes. Agreement with the GPU is tested beside the GPU's."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import world_direction
from engine.core.steps import Step, drain
from engine.render import direct
from engine.render.direct import radiance
from engine.render.display import Display
from engine.render.display import display as display_image
from engine.render.hex_tiling import Maps
from engine.scene.material import Material, auto_sigma
from engine.scene.scene import LOOKUPS, Scene
from tests.engine.scenes import head_on, scene, weave


def draw(what: Scene, size: tuple[int, int] = (32, 24), samples: int = 1) -> np.ndarray:
    return drain(radiance(what, size, samples=samples))


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_head_on_plane_has_the_predicted_radiance(samples: int) -> None:
    image = draw(head_on(irradiance=2.0), samples=samples)
    np.testing.assert_allclose(image[..., :3], 1 / np.pi, rtol=1e-6)
    assert (image[..., 3] == 1.0).all()


def test_average_over_a_weave_is_what_was_photographed() -> None:
    """Lambert, automatic sigma, light from above: the mean luminance of the image is r_max."""
    from engine.core.colour import luminance

    material = weave(64)
    image = draw(head_on(material, repeats=40.0), (64, 64))
    assert material.shading_map is not None
    assert luminance(image[..., :3]).mean() == pytest.approx(material.shading_map.r_max, rel=0.02)


def test_the_lit_side_is_where_the_light_is() -> None:
    right = dataclasses.replace(scene("sphere", brdf="lambert"), light=tuple(world_direction(np.pi / 2, np.pi / 2)))
    image = draw(right, (41, 31))[..., 0]
    assert image[:, 21:].sum() > 5 * image[:, :20].sum()
    above = dataclasses.replace(right, light=(0.0, 1.0, 0.0))
    image = draw(above, (41, 31))[..., 0]
    assert image[:15].sum() > 2 * image[16:].sum()


def test_steps_carry_the_image_so_far_and_can_be_left() -> None:
    steps = radiance(scene("sphere"), (200, 200), samples=2)
    first = next(steps)
    assert isinstance(first, Step)
    assert 0 < first.done < 1
    assert first.partial.shape == (200, 200, 4)
    steps.close()


@pytest.mark.parametrize("size", [(0, 0), (1, 1), (1, 40), (40, 1)])
def test_GL7_any_size(size: tuple[int, int]) -> None:
    assert draw(head_on(), size).shape == (size[1], size[0], 4)


def test_GL5_GL1_what_is_not_finite_is_black() -> None:
    what = head_on(weave(8))
    assert what.material is not None
    assert np.isfinite(
        draw(dataclasses.replace(what, material=Material(None, what.material.power_law, sigma=np.inf)))
    ).all()


@pytest.mark.parametrize("lookup", LOOKUPS)
def test_every_lookup_is_dark_without_light(lookup: Any) -> None:
    assert draw(head_on(weave(8), lookup=lookup, irradiance=0.0))[..., :3].max() == 0.0


@pytest.mark.parametrize(
    "options", [{"source": "film"}, {"lookup": "x"}, {"above": "x"}, {"irradiance": -1.0}, {"repeats": 0.0}]
)
def test_a_scene_that_makes_no_sense_is_refused(options: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"unknown|not a positive|outside"):
        head_on(**options)


def test_a_scene_takes_the_form_that_its_material_has() -> None:
    material = weave(8)
    assert head_on(material, source="power-law").shading is material.power_law
    assert head_on(material, source="slices").shading is material.shading_map
    assert head_on(dataclasses.replace(material, shading_map=None)).shading is material.power_law
    assert head_on().shading is None
    assert head_on().sigma == 1.0


def test_auto_sigma_makes_the_largest_r_of_the_capture_r_max() -> None:
    brdf = brdf_from_text("phong:kd=0.3,ks=0.4,exponent=30")
    elevation = np.radians([20.0, 50.0, 80.0])
    sigma = auto_sigma(brdf, elevation, 0.7)
    value = [brdf.f((np.cos(e), 0, np.sin(e)), (0, 0, 1))[0] * np.sin(e) for e in elevation]
    assert sigma * max(value) == pytest.approx(0.7)
    assert auto_sigma(brdf_from_text("lambert:albedo=0.5"), (), 0.7) == pytest.approx(0.7 * np.pi / 0.5)
    assert auto_sigma(brdf_from_text("lambert:albedo=0"), elevation, 0.7) == 1.0


def test_display_puts_the_background_behind_and_blends_edges() -> None:
    image = np.array([[[0, 0, 0, 0], [0.25, 0.25, 0.25, 0.5], [0.5, 0.5, 0.5, 1]]], np.float32)
    display = Display(operator="none", background=(0.0, 0.0, 1.0))
    assert display_image(image, display)[0].tolist() == [[0, 0, 255], [137, 137, 225], [188, 188, 188]]


@pytest.mark.parametrize("options", [{"exposure_ev": np.nan}, {"exposure_ev": 1e400}, {"operator": "film"}])
def test_a_display_that_makes_no_sense_is_refused(options: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="not possible"):
        Display(**options)


def test_textures_are_sampled_with_the_steps_of_neighbouring_pixels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Head-on, one pixel to the right changes u alone and one pixel along the other axis v alone, by equal amounts."""
    taken: list[list[np.ndarray]] = []

    def remember(_scene: Scene, levels: Any, uv: np.ndarray, along: list[np.ndarray], terms: Any) -> np.ndarray:
        taken.append(along)
        return np.zeros((len(uv), 3))

    monkeypatch.setattr(direct, "sample", remember)
    what = head_on(weave(8))
    draw(what, (12, 12))
    pixel = 2.0 * np.tan(np.radians(10.0)) * 2.0 / 12 * what.repeats / float(np.ptp(what.mesh.positions[:, 0]))
    for right, up in taken:
        np.testing.assert_allclose(np.abs(right), np.broadcast_to([pixel, 0.0], right.shape), atol=1e-9)
        np.testing.assert_allclose(np.abs(up), np.broadcast_to([0.0, pixel], up.shape), atol=1e-9)
    assert taken


def terms_of(f: float, cosine: float, irradiance: float) -> Iterator[tuple[Any, ...]]:
    """One light on one point."""
    yield np.array([0]), np.full((1, 3), f), np.array([cosine]), np.full(3, irradiance), None


@pytest.mark.parametrize("cosine", [0.8, 4.0], ids=["within", "above"])
@pytest.mark.parametrize("lookup", ["outgoing", "radiance"])
def test_share_and_weight_of_a_sample_are_the_reflected_radiance(lookup: Any, cosine: float) -> None:
    """In grey, for a map whose value is its share of r_max: above r_max too, where the share ends at 1."""
    material = weave(8)
    assert material.power_law is not None
    power_law = dataclasses.replace(material.power_law, r_max=0.5)
    what = head_on(Material(None, power_law, sigma=0.5), source="power-law", lookup=lookup, above="scale")
    ((point, share, weight, _),) = direct._shares(what, terms_of(0.4, cosine, 2.0), 1)
    assert point.tolist() == [0]
    assert 0.0 < share[0] <= 1.0
    np.testing.assert_allclose(weight * share, np.full((1, 3), 0.4 * cosine * 2.0), rtol=1e-6)


def test_a_power_law_is_its_scale_times_the_weighted_power_of_the_share() -> None:
    level = np.stack([np.full((4, 4, 3), 0.5), np.full((4, 4, 3), 2.0)])
    lit = (np.array([0, 2]), np.array([0.5, 0.0]), np.array([[3.0, 2.0, 1.0], [1.0, 1.0, 1.0]]), None)
    value = direct._sum_of_powers(iter([lit]), Maps([level]), np.full((3, 2), 0.5), np.zeros(3))
    np.testing.assert_allclose(value, [[0.375, 0.25, 0.125], [0.0] * 3, [0.0] * 3])
