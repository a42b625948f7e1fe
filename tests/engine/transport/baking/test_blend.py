"""Mixtures of BRDFs over a model: what each part of it must be, and what cannot be mixed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import plane, sphere
from engine.light.lamps import Lamp
from engine.transport.baking.blend import Mixture, blend_from_text, mixture, together
from engine.transport.baking.file import open_transport, plan_transport, writing
from engine.transport.wavelet.bake import BakeSettings, bake, factors_for, prepare, transport_of
from engine.transport.wavelet.error import wavelet_error
from engine.transport.wavelet.lighting import Lighting, tuples
from engine.transport.wavelet.quantise import encode_light
from engine.transport.wavelet.transfer import WaveletTransport, radiance_towards

COARSE = BakeSettings(8, 40, 1)
BASES = ("phong:exponent=4", "lambert:albedo=0.5")
LIGHT = Lighting(encode_light(np.random.default_rng(3).random((6, 8, 8, 3))), (Lamp((0.2, 1.0, 0.3), (1.0, 2.0, 3.0)),))


@pytest.fixture(scope="module")
def factors() -> list[SeparableFactors]:
    """Three terms and one, over equal maps."""
    return [drain(factors_for(brdf_from_text(text), terms)) for text, terms in zip(BASES, (3, 1), strict=True)]


def small_sphere() -> Mesh:
    mesh = sphere()
    kept = np.arange(0, len(mesh.faces), 97)
    used, faces = np.unique(mesh.faces[kept], return_inverse=True)
    return Mesh(mesh.positions[used], mesh.normals[used], mesh.uv[used], faces.reshape(-1, 3).astype(np.int32), "few")


def bake_blend(path: Path, factors: SeparableFactors, mixed: Mixture | None = None) -> WaveletTransport:
    return drain(bake(path, prepare(small_sphere(), factors, COARSE, Ground(cells=3), mixed))).transport


def observe(transport: WaveletTransport) -> np.ndarray:
    directions = transport.mesh.normals + np.array([0.3, 0.2, 0.1])
    return radiance_towards(
        transport, tuples(transport, LIGHT), directions / np.linalg.norm(directions, axis=1)[:, None]
    ).value


def test_a_mixture_is_the_weighted_mean_of_bakes_of_each(factors: list[SeparableFactors], tmp_path: Path) -> None:
    mesh = small_sphere()
    mixed = mixture(mesh, (3, 1), ["y"])
    height = np.clip((mesh.positions[:, 1:2] - mesh.positions[:, 1].min()) / np.ptp(mesh.positions[:, 1]), 0.0, 1.0)
    whole = bake_blend(tmp_path / "whole", together(factors), mixed)
    one, other = (observe(bake_blend(tmp_path / f"{number}", each)) for number, each in enumerate(factors))
    found, first = observe(whole), whole.ground_vertex
    # sums below 0 are clamped after the mixture, which tells where one of the bases is below
    above = (one[:first] > 0.0) & (other[:first] > 0.0)
    expected = (1.0 - height) * one[:first] + height * other[:first]
    assert above.mean() > 0.8
    assert found[:first][above] == pytest.approx(expected[above], rel=1e-5)
    assert np.array_equal(found[first:], one[first:])
    assert found[:first].min() >= 0.0


def test_weights_and_colours_change_without_another_bake(factors: list[SeparableFactors], tmp_path: Path) -> None:
    mesh = small_sphere()
    image = tmp_path / "grey.png"
    cv2.imwrite(str(image), np.full((4, 4, 3), 128, np.uint8))
    grey = ((128 / 255 + 0.055) / 1.055) ** 2.4
    whole = bake_blend(tmp_path / "a", together(factors), mixture(mesh, (3, 1), ["y"]))
    dark = replace(whole, mixture=mixture(mesh, (3, 1), ["y"], str(image)))
    first = whole.ground_vertex
    assert observe(dark)[:first] == pytest.approx(grey * observe(whole)[:first], rel=1e-5)
    assert np.array_equal(observe(dark)[first:], observe(whole)[first:])
    only = replace(whole, mixture=Mixture((3, 1), np.tile(np.array([0.0, 1.0], np.float32), (first, 1))))
    assert observe(only)[:first] == pytest.approx(observe(bake_blend(tmp_path / "b", factors[1]))[:first], rel=1e-6)
    again = transport_of(open_transport(tmp_path / "a"))
    assert again.mixture is not None
    assert again.mixture.terms == (3, 1)
    assert np.array_equal(again.mixture.weights, mixture(mesh, (3, 1), ["y"]).weights)


def test_the_error_of_a_mixture_is_found_against_its_own_sum(factors: list[SeparableFactors]) -> None:
    mesh = small_sphere()
    work = prepare(mesh, together(factors), COARSE, None, mixture(mesh, (3, 1), ["x"]))
    light = np.random.default_rng(0).random((6, 8, 8, 3)) + 1.0
    brdfs = [brdf_from_text(text) for text in BASES]
    right = drain(wavelet_error(work, brdfs, light, vertices=40, views=6))
    wrong = drain(wavelet_error(work, brdfs[::-1], light, vertices=40, views=6))
    assert right.rmse_rel < 0.05 < wrong.rmse_rel


def test_weights_add_up_to_one_and_share_what_is_too_much() -> None:
    found = mixture(plane(), (1, 1, 1), ["x", "y"]).weights
    assert found.sum(axis=1) == pytest.approx(1.0, abs=1e-6)
    assert found.min() >= 0.0
    both = np.argmax(plane().positions @ (1.0, 1.0, 0.0))
    assert found[both] == pytest.approx([0.0, 0.5, 0.5])
    assert mixture(plane(), (4,), []).weights.shape == (len(plane().positions), 1)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("ggx:alpha=0.1:y", ("ggx:alpha=0.1", "y")),
        ("phong:mask.png", ("phong", "mask.png")),
        ("lambert:albedo=1:C:\\a b\\mask.png", ("lambert:albedo=1", "C:\\a b\\mask.png")),
    ],
)
def test_texts_are_taken_apart(text: str, parts: tuple[str, str]) -> None:
    assert blend_from_text(text) == parts


@pytest.mark.parametrize("text", ["", "ggx", "ggx:", ":x", "ggx:alpha=0.3"])
def test_texts_without_a_source_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="BRDF:SOURCE"):
        blend_from_text(text)


def test_what_cannot_be_mixed_is_refused(factors: list[SeparableFactors], tmp_path: Path) -> None:
    mesh, even = small_sphere(), np.ones((1, 4, 4, 3), np.float32)
    other = SeparableFactors(HemisphereMap("orthographic", 4), "in-out", even, even)
    with pytest.raises(ValueError, match="different maps"):
        together([factors[0], other])
    with pytest.raises(ValueError, match="does not fit"):
        prepare(mesh, factors[0], COARSE, None, mixture(mesh, (3, 1), ["x"]))
    with pytest.raises(ValueError, match="do not fit"):
        mixture(mesh, (3, 1), [])
    with pytest.raises(ValueError, match="from 0 to 1"):
        Mixture((1,), np.full((3, 1), np.float32(1.5)))
    with pytest.raises(ValueError, match="from 0 to 1"):
        Mixture((1,), np.full((3, 1), np.float32(np.nan)))
    with pytest.raises(InputError):
        mixture(mesh, (1, 1), [str(tmp_path / "nothing.png")])


def test_files_whose_mixture_cannot_be_are_refused(factors: list[SeparableFactors], tmp_path: Path) -> None:
    mesh = small_sphere()
    path = tmp_path / "a.transport"
    drain(bake(path, prepare(mesh, together(factors), COARSE, None, mixture(mesh, (3, 1), ["y"]))))
    found = open_transport(path)
    streamed = {name: found.arrays[name] for name in ("indices", "words", "peaks", "counts")}
    kinds = {name: (array.dtype, array.shape[1:]) for name, array in streamed.items()}
    weights = np.array(found.arrays["weights"])
    bounds = np.array([0, len(streamed["words"])])

    def open_path(weights: np.ndarray, bases: object, albedo: np.ndarray | None = None) -> WaveletTransport:
        whole = {name: found.arrays[name] for name in ("view_maps", "light_maps")} | {"weights": weights}
        whole |= {} if albedo is None else {"albedo": albedo}
        plan = plan_transport("wavelet", found.mesh, {**found.settings, "bases": bases}, whole, kinds, bounds)
        with writing(tmp_path / "lie", plan) as writer:
            writer.put(0, streamed)
        return transport_of(open_transport(tmp_path / "lie"))

    assert open_path(weights, [3, 1]).mixture is not None
    for lie in (
        (weights[:-1], [3, 1]),
        (weights, [2, 1]),
        (weights, [4]),
        (weights, [3, 1, 0]),
        (weights, [5, -1]),
        (weights, None),
        (weights.astype(np.float64), [3, 1]),
        (weights * np.float32(np.nan), [3, 1]),
        (weights + np.float32(1.0), [3, 1]),
        (weights, [3, 1], np.full((3, 3), np.float32(0.5))),
        (weights, [3, 1], np.full((len(weights), 3), np.float32(np.inf))),
    ):
        with pytest.raises(InputError, match="cannot be"):
            open_path(*lie)
