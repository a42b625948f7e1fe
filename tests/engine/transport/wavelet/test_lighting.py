"""Light for wavelet transport: the sun split off, rotation, lamps, and updates without drift."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from engine.core.directions import normalize
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.mesh import Mesh
from engine.light.cube_map import cube_of
from engine.light.environment import EnvironmentMap, solid_angles, texel_directions
from engine.light.lamps import Lamp
from engine.transport.wavelet.bake import BakeSettings, Work, bake_in_memory, prepare
from engine.transport.wavelet.haar import cube_of_coefficients
from engine.transport.wavelet.lighting import Lighting, dark, lamp_tuples, lighting_of, rotate, tuples
from engine.transport.wavelet.quantise import encode_light
from engine.transport.wavelet.relight import Relighter, Relighting
from engine.transport.wavelet.transfer import WaveletTransport, radiance_towards, relight_transport, vectors_of

EDGE = 16


def diffuse() -> SeparableFactors:
    """Of albedo ½."""
    even = np.full((1, 4, 4, 3), math.sqrt(0.5 / math.pi), np.float32)
    return SeparableFactors(HemisphereMap("orthographic", 4), "in-out", even, even, isotropic=True, reciprocal=True)


def sky(rows: int = 64) -> EnvironmentMap:
    """Of mean about 1.1, brighter above."""
    up = texel_directions(rows, 2 * rows)[..., 1:2]
    clouds = np.random.default_rng(1).random((rows, 2 * rows, 3))
    return EnvironmentMap((1.0 + 0.6 * up + 0.2 * clouds).astype(np.float32))


def with_sun(value: float) -> EnvironmentMap:
    radiance = sky().radiance.copy()
    radiance[20, 33] += value
    return EnvironmentMap(radiance)


def bake(work: Work) -> WaveletTransport:
    parts = [arrays for _, arrays in bake_in_memory(work, np.arange(work.vertices))]
    arrays = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return WaveletTransport(work.surface, work.ground_vertex, work.factors, 0.0, EDGE, vectors_of(arrays))


@pytest.fixture(scope="module")
def transport() -> WaveletTransport:
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.2, 0.0], [0.1, 1.0, 0.3]])
    normals = np.repeat(normalize(np.cross(corners[1], corners[2]))[None], 3, axis=0).astype(np.float32)
    triangle = Mesh(corners, normals, np.zeros((3, 2), np.float32), np.array([[0, 1, 2]], np.int32), "triangle")
    return bake(prepare(triangle, diffuse(), BakeSettings(EDGE, 80, 1)))


@pytest.mark.parametrize("sun", [0.0, 1e3, 1e4, 1e6])
@pytest.mark.parametrize("threshold", [32, 1024])
def test_Z14_X6_no_sun_erases_the_sky(sun: float, threshold: int) -> None:
    lighting = lighting_of(with_sun(sun), 64, threshold=threshold)
    expected = cube_of(sky(), 64).radiance.astype(float)
    found = cube_of_coefficients(lighting.light.coefficients)
    quarters = [part.reshape(6, 2, 32, 2, 32, 3).sum(axis=(2, 4)) for part in (found, expected)]
    assert np.abs(quarters[0] - quarters[1]).sum() <= 0.01 * quarters[1].sum()
    assert lighting.light.energy_error_rel <= 0.01
    area = solid_angles(64, 128)[20, 0]
    brought = sum(np.array(lamp.flux) for lamp in lighting.lamps) if lighting.lamps else np.zeros(3)
    if sun >= 1e3:
        assert brought == pytest.approx(np.full(3, sun * area), rel=0.01)
    else:
        assert not cast(Any, brought).any()


def test_X6_without_the_split_a_sun_does_erase_details() -> None:
    """That the split is what helps."""
    whole = lighting_of(with_sun(1e6), 64, threshold=1024, split=False)
    quarters = cube_of_coefficients(whole.light.coefficients).reshape(6, 2, 32, 2, 32, 3).sum(axis=(2, 4))
    expected = cube_of(sky(), 64).radiance.reshape(6, 2, 32, 2, 32, 3).sum(axis=(2, 4), dtype=float)
    assert np.abs(quarters - expected)[1:].sum() > 0.02 * expected[1:].sum()


def test_Z15_ten_thousand_updates_are_one_fresh_sum(transport: WaveletTransport) -> None:
    rng = np.random.default_rng(2)
    radiance = rng.random((6, EDGE, EDGE, 3))
    first = encode_light(radiance, 0)
    relighting = Relighting(transport, first)
    quantised, scaling = first.quantised, first.scaling
    for _ in range(10_000):
        quantised, scaling = quantised.copy(), first.scaling * rng.random()
        quantised[rng.integers(6, len(quantised), 3)] = rng.integers(-32767, 32768, (3, 3))
        rows = relighting.update(replace(first, quantised=quantised, scaling=scaling))
    fresh = relight_transport(transport, replace(first, quantised=quantised, scaling=scaling))
    assert np.abs(rows - fresh).max() <= 1e-12 * np.abs(fresh).max()


def test_updates_reach_every_light(transport: WaveletTransport) -> None:
    one, other = (encode_light(np.random.default_rng(seed).random((6, EDGE, EDGE, 3)), 0) for seed in (1, 2))
    relighting = Relighting(transport, one)
    np.testing.assert_allclose(relighting.update(other), relight_transport(transport, other), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(relighting.update(one), relight_transport(transport, one), rtol=1e-10, atol=1e-12)
    with pytest.raises(ValueError, match="another edge"):
        relighting.update(encode_light(np.zeros((6, 8, 8, 3))))


def test_turning_moves_what_came_from_z_to_x_and_keeps_the_flux() -> None:
    radiance = np.zeros((32, 64, 3), np.float32)
    radiance[15, 31:33] = 1.0  # about +Z
    environment = EnvironmentMap(radiance)
    quarter = rotate(environment, math.pi / 2.0)
    towards = (quarter.radiance[..., :1] * texel_directions(32, 64)).sum(axis=(0, 1))
    assert normalize(towards) == pytest.approx([1.0, 0.0, 0.0], abs=0.06)
    assert rotate(environment, 0.0) is environment
    np.testing.assert_array_equal(rotate(environment, 2.0 * math.pi).radiance, radiance)
    for angle in (0.3, -1.7, 100.0):
        assert rotate(environment, angle).radiance.sum(dtype=float) == pytest.approx(radiance.sum(dtype=float))
    lamp = Lamp((0.0, 0.0, 1.0), (1.0, 1.0, 1.0)).rotate(math.pi / 2.0)
    assert lamp.direction == pytest.approx((1.0, 0.0, 0.0), abs=1e-12)


def test_a_lamp_is_its_cosine_times_the_brdf(transport: WaveletTransport) -> None:
    normal = normalize(transport.mesh.normals.astype(float))
    towards = normalize(normal[0] + 0.7 * normalize(np.cross(normal[0], [0.3, 0.5, 0.2])))
    lamp = Lamp(tuple(towards), (2.0, 1.0, 0.0))
    rows = tuples(transport, dark(EDGE, (lamp,)))
    found = radiance_towards(transport, rows, normal).value
    expected = 0.5 / math.pi * (normal @ towards)[:, None] * np.array([2.0, 1.0, 0.0])
    np.testing.assert_allclose(found, expected, rtol=1e-5)
    below = lamp_tuples(transport, dark(EDGE, (Lamp(tuple(-towards), (1.0, 1.0, 1.0)),)).directional)
    assert not below.any()


def test_lights_of_a_factor_are_times_as_bright() -> None:
    one, three = (lighting_of(with_sun(1e4), EDGE, factor=factor) for factor in (1.0, 3.0))
    np.testing.assert_allclose(three.light.scaling, 3.0 * one.light.scaling, rtol=1e-12)
    assert three.lamps[0].irradiance == pytest.approx([3.0 * x for x in one.lamps[0].irradiance])


def test_a_relighter_gives_what_a_fresh_sum_gives_with_the_least_work(
    transport: WaveletTransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Through changes of one coefficient, of all, of lamps alone and of nothing; what is done each time is counted."""
    calls: list[str] = []

    def count(name: str, where: str) -> None:
        module = "engine.transport.wavelet.relight"
        own = __import__(module, fromlist=[where])
        before = getattr(own, where)
        monkeypatch.setattr(f"{module}.{where}", lambda *words: cast(Any, calls).append(name) or before(*words))

    for name, where in {"whole": "relight_transport", "lamps": "lamp_tuples", "some": "add_changes"}.items():
        count(name, where)
    rng = np.random.default_rng(0)
    radiance = rng.random((6, EDGE, EDGE, 3)) + 1.0
    first = encode_light(radiance, 0)
    quantised = first.quantised.copy()
    quantised[700, 1] += 5
    touched, other = replace(first, quantised=quantised), encode_light(radiance[:, ::-1], 0)
    one, two = (Lamp((0.3, 1.0, z), (1.0, 2.0, 3.0)) for z in (0.1, 0.2))
    steps = [
        (Lighting(first, (one,)), ["whole", "lamps"]),
        (Lighting(first, (one,)), []),
        (Lighting(touched, (one,)), ["some"] * 4),
        (Lighting(first, (one,)), ["some"] * 2),
        (Lighting(first, (two,)), ["lamps"]),
        (Lighting(other), ["whole"]),
        (Lighting(replace(other, quantum=2.0 * other.quantum)), ["some"] * 2),
    ]
    relighter = Relighter(transport)
    for lighting, work in steps:
        calls.clear()
        assert np.array_equal(relighter.tuples(lighting), tuples(transport, lighting))
        assert calls == work
