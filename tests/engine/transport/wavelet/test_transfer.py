"""Wavelet transport: against sums over texels, analytic cases, threads, and what relighting must keep exactly."""

from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest

from engine.core.directions import normalize, world_from_tangent
from engine.factor.hemisphere_map import HemisphereMap, MapKind
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import sphere
from engine.light.cube_map import cube_directions, cube_solid_angles
from engine.transport.wavelet.haar import cube_coefficients, strongest
from engine.transport.wavelet.quantise import BOUNDS, STEP, WaveletLight, dequantise, encode_light
from engine.transport.wavelet.transfer import (
    Vectors16,
    WaveletTransport,
    cube_texels,
    light_maps,
    radiance_towards,
    relight_transport,
    sum_signed_radiance,
    transport_vectors,
    vectors_of,
    vertex_frames,
)
from tests.threads import threads

EDGE = 16
TEXELS = 6 * EDGE * EDGE


def random_factors(terms: int, kind: MapKind = "orthographic", grey: bool = False) -> SeparableFactors:
    rng = np.random.default_rng(terms)
    hemisphere_map = HemisphereMap(kind, 12)
    first, second = rng.standard_normal((2, terms, *hemisphere_map.shape, 1 if grey else 3))
    return SeparableFactors(
        hemisphere_map,
        "in-out",
        *cast(Any, (np.broadcast_to(side, (terms, *hemisphere_map.shape, 3)) for side in (first, second))),
    )


def frames_and_visibility(count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(7)
    frames = world_from_tangent(normalize(rng.standard_normal((count, 3))))
    return frames, rng.choice(np.array([0, 3, 16], np.uint8), (count, TEXELS))


def brute_transport(factors: SeparableFactors, frames: np.ndarray, visible: np.ndarray) -> np.ndarray:
    """(B, K, M, 3): light map × visibility × cosine × solid angle at every texel, by the map's own look-up."""
    direction = cube_directions(EDGE).reshape(-1, 3)
    area = np.tile(cube_solid_angles(EDGE).reshape(-1), 6)
    result = np.zeros((len(frames), factors.terms, TEXELS, 3))
    for b, frame in enumerate(frames):
        local = direction @ frame
        up = np.flatnonzero(local[:, 2] > 0.0)
        factor = local[up, 2] * visible[b, up] / 16.0 * area[up]
        for k in range(factors.terms):
            result[b, k, up] = factors.hemisphere_map.look_up(factors.second[k], local[up]) * factor[:, None]
    return result


@pytest.mark.parametrize("kind", ["orthographic", "polar", "parabolic"])
@pytest.mark.parametrize("grey", [False, True])
def test_vectors_are_the_strongest_coefficients_of_the_sum_over_texels(kind: MapKind, grey: bool) -> None:
    factors = random_factors(3, kind, grey)
    frames, visible = frames_and_visibility(11)
    maps = light_maps(factors)
    assert maps.shape[1] == (1 if grey else 3)
    found = transport_vectors(frames, visible, 16, cube_texels(EDGE), factors.hemisphere_map, maps, 40)
    expected = brute_transport(factors, frames, visible).reshape(33, 6, EDGE, EDGE, 3)
    for row, image in enumerate(expected):
        coefficients = cube_coefficients(image)
        kept = strongest(coefficients, 40)
        count = found["counts"][row]
        values = dequantise(found["words"][row], found["peaks"][row])[:count]
        assert np.isin(found["indices"][row, :count], kept).mean() > 0.95  # float32 may order near ties otherwise
        bound = np.abs(coefficients).max(axis=0) / (2.0 * (np.array(BOUNDS) // (STEP, STEP, STEP // 2))) * 1.01 + 1e-6
        assert (np.abs(values - coefficients[found["indices"][row, :count]]) <= bound).all()
        assert (np.diff(found["indices"][row, :count].astype(int)) > 0).all()
        assert not found["words"][row, count:].any()


def test_Z4_vectors_do_not_depend_on_the_number_of_threads() -> None:
    factors = random_factors(2)
    frames, visible = frames_and_visibility(37)
    arguments = (frames, visible, 16, cube_texels(EDGE), factors.hemisphere_map, light_maps(factors), 30)
    with threads(2):
        together = transport_vectors(*arguments)
    with threads(1):
        alone = transport_vectors(*arguments)
    assert all(np.array_equal(together[name], alone[name]) for name in together)


def transport(factors: SeparableFactors, mesh: Mesh, visible: np.ndarray | None = None, kept: int = TEXELS) -> Any:
    """Of all vertices, which see everything unless given, with all coefficients."""
    count = len(mesh.positions)
    seen = np.full((count, TEXELS), 16, np.uint8) if visible is None else visible
    frames = vertex_frames(mesh, factors.isotropic)
    arrays = transport_vectors(frames, seen, 16, cube_texels(EDGE), factors.hemisphere_map, light_maps(factors), kept)
    return WaveletTransport(mesh, count, factors, 0.0, EDGE, vectors_of(arrays))


def small_sphere(count: int = 60) -> Mesh:
    whole = sphere()
    step = len(whole.positions) // count
    chosen = slice(None, None, step)
    vertices = len(whole.positions[chosen])
    faces = np.arange(vertices // 3 * 3, dtype=np.int32).reshape(-1, 3)
    return Mesh(whole.positions[chosen].copy(), whole.normals[chosen].copy(), whole.uv[chosen].copy(), faces, "some")


def lambert() -> SeparableFactors:
    hemisphere_map = HemisphereMap("orthographic", 4)
    even = np.full((1, 4, 4, 3), math.sqrt(0.5 / math.pi), np.float32)
    return SeparableFactors(hemisphere_map, "in-out", even, even, isotropic=True, reciprocal=True)


def sky(seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.random((6, EDGE, EDGE, 3)) ** 4


def test_relighting_with_everything_kept_is_the_sum_over_texels() -> None:
    factors = random_factors(2)
    mesh = small_sphere(20)
    visible = np.random.default_rng(3).choice(np.array([0, 8, 16], np.uint8), (len(mesh.positions), TEXELS))
    found = relight_transport(transport(factors, mesh, visible), encode_light(sky(), 0))
    expected = brute_transport(factors, vertex_frames(mesh, False), visible)
    exact = np.einsum("bkmc,mc->bkc", expected, sky().reshape(-1, 3)).reshape(found.shape)
    assert np.abs(found - exact).max() <= 1.5e-3 * STEP * np.abs(exact).max()


def test_even_light_on_a_free_diffuse_vertex_is_the_albedo() -> None:
    mesh = small_sphere()
    some = transport(lambert(), mesh)
    light = encode_light(np.full((6, EDGE, EDGE, 3), 2.0))
    radiance = radiance_towards(some, relight_transport(some, light), normalize(mesh.normals))
    assert radiance.value == pytest.approx(np.full((len(mesh.positions), 3), 1.0), abs=6e-3)
    assert radiance.negative_rel == 0.0


def test_more_coefficients_never_err_more() -> None:
    mesh = small_sphere(30)
    visible = np.random.default_rng(5).choice(np.array([0, 16], np.uint8), (len(mesh.positions), TEXELS // 16))
    visible = np.repeat(visible, 16, axis=1)
    light = encode_light(sky(), 0)
    exact = relight_transport(transport(lambert(), mesh, visible), light)
    errors = [
        np.linalg.norm(relight_transport(transport(lambert(), mesh, visible, kept), light) - exact)
        for kept in (8, 32, 128, 512)
    ]
    assert np.all(np.diff(errors) < 0.0)


def saturate(edge: int, terms: int) -> tuple[Vectors16, WaveletLight]:
    """Rows of quantised coefficients at their bounds under light at its own."""
    indices = np.arange(6, 6 + terms, dtype=np.uint16)[None]
    words = np.full((1, terms), (1023 | 1023 << 11 | 511 << 22), np.uint32)
    vectors = Vectors16(indices, words, np.array([[1023.0, 1023.0, 511.0]], np.float32), np.array([terms], np.uint16))
    quantised = np.full((6 * edge * edge, 3), 32767, np.int16)
    quantised[:6] = 0
    return vectors, WaveletLight(np.zeros((6, 3)), quantised, 1.0, 0.0, 0.0)


@pytest.mark.parametrize("sign", [1, -1])
def test_Z12_X4_accumulators_do_not_overflow(sign: int) -> None:
    vectors, light = saturate(EDGE, 96)
    light = WaveletLight(light.scaling, (sign * light.quantised).astype(np.int16), 1.0, 0.0, 0.0)
    mesh = Mesh(
        np.eye(3), np.eye(3, dtype=np.float32), np.zeros((3, 2), np.float32), np.array([[0, 1, 2]], np.int32), ""
    )
    three = Vectors16(
        *(np.repeat(getattr(vectors, name), 3, axis=0) for name in ("indices", "words", "peaks", "counts"))
    )
    found = relight_transport(WaveletTransport(mesh, 3, lambert(), 0.0, EDGE, three), light)
    exact = [sign * 1023 * 32767 * 96, sign * 1023 * 32767 * 96, sign * 511 * 32767 * 96]
    assert found[0].tolist() == exact
    assert abs(exact[0]) > 2**31


def test_Z16_a_channel_without_light_stays_dark() -> None:
    mesh = small_sphere(20)
    dark = sky()
    dark[..., 1] = 0.0
    some = transport(lambert(), mesh)
    found = relight_transport(some, encode_light(dark, 0))
    assert not found[:, 1].any()
    assert found[:, 0].all()


def test_scaling_the_light_scales_the_tuples() -> None:
    mesh, factors = small_sphere(20), lambert()
    some = transport(factors, mesh)
    one, four = (relight_transport(some, encode_light(sky() * factor, 0)) for factor in (1.0, 4.0))
    assert np.array_equal(4.0 * one, four)


def test_nothing_is_seen_from_behind_and_negative_sums_are_clamped_and_reported() -> None:
    mesh, factors = small_sphere(20), random_factors(2)
    some = transport(factors, mesh)
    rows = relight_transport(some, encode_light(sky(), 0))
    behind = radiance_towards(some, rows, -normalize(mesh.normals))
    assert not behind.value.any()
    front = radiance_towards(some, rows, normalize(mesh.normals))
    local = np.broadcast_to([0.0, 0.0, 1.0], (len(mesh.positions), 3))
    signed = sum_signed_radiance(some, rows, local, np.arange(len(mesh.positions)))
    assert (front.value >= 0.0).all()
    assert front.negative_rel == pytest.approx(-signed[signed < 0.0].sum() / signed[signed > 0.0].sum())


def test_a_ground_has_one_diffuse_term() -> None:
    mesh, factors = small_sphere(20), random_factors(3)
    count = len(mesh.positions)
    whole = transport(lambert(), mesh)
    model = transport(factors, mesh)
    vectors = Vectors16(
        *(
            np.concatenate([getattr(model.vectors, name)[: 3 * 5], getattr(whole.vectors, name)[5:]])
            for name in ("indices", "words", "peaks", "counts")
        )
    )
    mixed = WaveletTransport(mesh, 5, factors, 0.5, EDGE, vectors)
    rows = relight_transport(mixed, encode_light(sky(), 0))
    found = radiance_towards(mixed, rows, normalize(mesh.normals)).value
    assert rows.shape == (15 + count - 5, 3)
    np.testing.assert_allclose(found[5:], rows[15:] * 0.5 / math.pi)


def test_transport_that_does_not_fit_is_refused() -> None:
    mesh, factors = small_sphere(20), lambert()
    some = transport(factors, mesh)
    with pytest.raises(ValueError, match="do not belong"):
        WaveletTransport(mesh, len(mesh.positions) - 1, random_factors(2), 0.0, EDGE, some.vectors)
    half = SeparableFactors(factors.hemisphere_map, "half-diff", factors.first, factors.second)
    with pytest.raises(ValueError, match="in-out"):
        WaveletTransport(mesh, len(mesh.positions), half, 0.0, EDGE, some.vectors)
    with pytest.raises(ValueError, match="does not fit transport"):
        relight_transport(some, encode_light(np.zeros((6, 32, 32, 3))))
    lying = some.vectors.indices.copy()
    lying[0, 0] = TEXELS
    with pytest.raises(ValueError, match="do not exist"):
        Vectors16(lying, some.vectors.words, some.vectors.peaks, some.vectors.counts).check(EDGE)
