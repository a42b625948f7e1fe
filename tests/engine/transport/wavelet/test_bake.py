"""Bakes: into a file, interrupted, resumed, refused; and what they must be for known visibility."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.factor.errors import reference
from engine.factor.factor_file import open_reflectance
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import open_mesh, plane, sphere
from engine.transport.baking.chunks import estimate_s as estimate_chunks_s
from engine.transport.baking.file import open_transport, plan_transport, writing
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.bake import (
    BakeSettings,
    Work,
    bake,
    bake_in_memory,
    estimate_s,
    factors_for,
    prepare,
    transport_of,
)
from engine.transport.wavelet.quantise import encode_light
from engine.transport.wavelet.transfer import radiance_towards, relight_transport

COARSE = BakeSettings(16, 40, 2)


def diffuse(albedo: float = 0.5) -> SeparableFactors:
    hemisphere_map = HemisphereMap("orthographic", 4)
    even = np.full((1, 4, 4, 3), math.sqrt(albedo / math.pi), np.float32)
    return SeparableFactors(hemisphere_map, "in-out", even, even, isotropic=True, reciprocal=True, name="even")


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch, shared_data: Callable[[str], Path]) -> Work:
    """Suzanne on a ground, in chunks of a hundred vertices."""
    monkeypatch.setattr(wavelet_bake, "CHUNK_TEXELS", 100 * 6 * 16 * 16)
    mesh = open_mesh(str(shared_data("mesh/classic/suzanne.obj")))
    return prepare(mesh, diffuse(), COARSE, Ground(cells=6, albedo=0.3))


def test_a_bake_is_as_large_as_was_said_and_opens_as_it_was(small: Work, tmp_path: Path) -> None:
    baked = drain(bake(tmp_path / "a.transport", small))
    assert (tmp_path / "a.transport").stat().st_size == baked.file.size_bytes < small.size_bytes
    transport = transport_of(open_transport(tmp_path / "a.transport", small.surface))
    assert (transport.ground_vertex, transport.ground_albedo) == (small.ground_vertex, 0.3)
    assert len(transport.mesh.positions) == small.vertices == small.ground_vertex + 49
    assert transport.rows == small.vertices
    assert (transport.factors.name, transport.factors.isotropic) == ("even", True)
    assert 0.0 < baked.visibility_s < baked.bake_s
    assert baked.chunks == len(baked.transport.mesh.positions) // 100 + 2
    some = np.arange(5, 200, 7)
    for vertices, arrays in bake_in_memory(small, some):
        assert np.array_equal(arrays["words"], transport.vectors.words[vertices])
        assert np.array_equal(arrays["indices"], transport.vectors.indices[vertices])


def test_an_interrupted_bake_goes_on_and_is_the_same_file(small: Work, tmp_path: Path) -> None:
    whole, path = tmp_path / "whole.transport", tmp_path / "parts.transport"
    drain(bake(whole, small))
    for count in (4, 9):
        steps = bake(path, small)
        for _ in range(count):
            next(steps)
        steps.close()
        assert not path.exists()
    baked = drain(bake(path, small))
    assert baked.resumed_chunks > 2
    assert path.read_bytes() == whole.read_bytes()
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["parts.transport", "whole.transport"]


def test_a_free_vertex_under_even_light_reflects_the_albedo_and_skips_its_rays(tmp_path: Path) -> None:
    work = prepare(plane(), diffuse(), COARSE)
    baked = drain(bake(tmp_path / "plane.transport", work))
    assert baked.unoccluded_vertices == work.vertices
    light = encode_light(np.ones((6, 16, 16, 3)))
    found = radiance_towards(baked.transport, relight_transport(baked.transport, light), plane().normals.astype(float))
    assert found.value == pytest.approx(0.5, abs=4e-3)


def test_a_model_shades_the_ground_below_it(tmp_path: Path) -> None:
    mesh = sphere()
    few = Mesh(mesh.positions, mesh.normals, mesh.uv, mesh.faces, "sphere")
    work = prepare(few, diffuse(), BakeSettings(16, 200, 2), Ground(cells=8, albedo=1.0, extent=4.0))
    ground = np.arange(work.ground_vertex, work.vertices)
    _, arrays = next(iter(bake_in_memory_of_ground(work, ground)))
    positions = work.surface.positions[ground]
    distance = np.hypot(positions[:, 0] - mesh.centre[0], positions[:, 2] - mesh.centre[2]) / mesh.radius
    lit = arrays["peaks"][:, 0]
    assert lit[np.argmin(distance)] < 0.3 * lit[np.argmax(distance)]


def bake_in_memory_of_ground(work: Work, ground: np.ndarray) -> list[tuple[np.ndarray, dict[str, np.ndarray]]]:
    return [(vertices, dict(arrays)) for vertices, arrays in bake_in_memory(work, ground)]


def test_factors_are_taken_as_they_are_or_made_as_asked() -> None:
    given = diffuse()
    assert drain(factors_for(given, 4)).first is given.first or drain(factors_for(given, 4)).terms == 1
    phong = drain(factors_for(brdf_from_text("phong:exponent=5"), 3))
    assert (phong.terms, phong.parametrisation, phong.isotropic) == (3, "in-out", True)
    one = drain(factors_for(brdf_from_text("ashikhmin-shirley:nu=10,nv=100"), 1, kind="polar"))
    assert (one.terms, one.hemisphere_map.kind, one.isotropic) == (1, "polar", False)
    half = SeparableFactors(given.hemisphere_map, "half-diff", given.first, given.second)
    with pytest.raises(ValueError, match="in-out"):
        drain(factors_for(half, 2))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ((128, 96, 4), "16-bit"),
        ((48, 96, 4), "power of two"),
        ((64, 0, 4), "coefficients"),
        ((64, 5000, 4), "coefficients"),
        ((64, 96, 16), "fine"),
        ((64, 96, 0), "fine"),
    ],
)
def test_X5_Z13_settings_that_cannot_be_are_refused(settings: tuple[int, int, int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        BakeSettings(*settings)


def test_the_time_is_estimated(small: Work) -> None:
    assert 0.0 < estimate_s(small) < 600.0


@pytest.mark.parametrize(("vertices", "first"), [(1000, 1000), (1000, 300), (30, 29), (500, 0), (0, 0)])
def test_model_and_ground_are_estimated_by_their_own(
    vertices: int, first: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With a clock that a vertex of the model moves by 3 s, one of the ground by 1 s and each call by nothing."""
    clock = [0.0]
    monkeypatch.setattr("engine.transport.baking.chunks.time.perf_counter", lambda: clock[0])

    def make(some: np.ndarray) -> None:
        assert len(np.unique(some)) == len(some)
        assert len(set(some < first)) == 1
        clock[0] += 3.0 * np.count_nonzero(some < first) + np.count_nonzero(some >= first)

    assert estimate_chunks_s(make, vertices, first) == pytest.approx(3.0 * first + (vertices - first))


def test_files_of_other_kinds_meshes_and_lies_are_refused(small: Work, tmp_path: Path) -> None:
    path = tmp_path / "a.transport"
    drain(bake(path, small))
    with pytest.raises(InputError, match="another mesh"):
        transport_of(open_transport(path, sphere()))
    found = open_transport(path)
    rows = np.array([0, len(found.arrays["words"])])
    streamed = {name: (found.arrays[name].dtype, found.arrays[name].shape[1:]) for name in ("words", "peaks", "counts")}
    whole = {name: found.arrays[name] for name in ("view_maps", "light_maps")}

    def write(kind: str, settings: dict[str, object], indices: np.ndarray) -> Path:
        other = tmp_path / "other.transport"
        kinds = {"indices": (indices.dtype, indices.shape[1:]), **streamed}
        with writing(other, plan_transport(kind, found.mesh, settings, whole, kinds, rows)) as writer:
            writer.put(0, {"indices": indices, **{name: found.arrays[name] for name in streamed}})
        return other

    settings, indices = dict(found.settings), np.array(found.arrays["indices"])
    transport_of(open_transport(write("wavelet", settings, indices)))
    with pytest.raises(InputError, match="mode sh"):
        transport_of(open_transport(write("sh", settings, indices)))
    with pytest.raises(InputError, match="do not exist"):
        transport_of(open_transport(write("wavelet", settings, np.full_like(indices, 6 * 16 * 16))))
    with pytest.raises(InputError, match="other types"):
        transport_of(open_transport(write("wavelet", settings, indices.astype(np.uint32))))
    for name, lie in {"edge": 128, "ground_vertex": 3, "map": "cube", "map_size": "x", "ground_albedo": []}.items():
        if name == "ground_vertex":
            continue  # with one term all numbers of vectors are alike
        with pytest.raises(InputError, match="cannot be"):
            transport_of(open_transport(write("wavelet", {**settings, name: lie}, indices)))
    with pytest.raises(InputError, match="cannot be"):
        transport_of(open_transport(write("wavelet", {}, indices)))


def test_fewer_terms_are_the_first_of_more() -> None:
    """A norm for each number of terms would let four be worse than two."""
    paint = brdf_from_text("ggx:kd=0.3,alpha=0.3,f0=0.04")
    few, many = (drain(factors_for(paint, terms, signs="signed")) for terms in (4, 8))
    assert np.array_equal(few.second, many.second[:4])


def test_a_peak_at_the_horizon_does_not_choose_a_term_for_all_views(shared_data: Callable[[str], Path]) -> None:
    paper = open_reflectance(str(shared_data("brdf/rgl/paper_white_rgb.bsdf")))
    one = drain(factors_for(paper, 1))
    rng = np.random.default_rng(3)
    wi, wo = (normalize(rng.normal(size=(500, 3)) * 0.4 + np.array([0.0, 0.0, 1.0])) for _ in range(2))
    value = paper.f(wi, wo)
    assert np.linalg.norm(one.f(wi, wo) - value) < 0.1 * np.linalg.norm(value)


@pytest.mark.parametrize(
    "text",
    [
        "ggx:kd=0.3,alpha=0.2,f0=0.04",
        pytest.param("ashikhmin-shirley:kd=0.5,ks=0.75,nu=10,nv=100", marks=pytest.mark.long),
    ],
)
def test_terms_that_would_be_black_are_replaced_by_nonnegative_ones(text: str) -> None:
    brdf = brdf_from_text(text)
    pairs = reference(brdf, seed=5)
    signed, chosen = (drain(factors_for(brdf, 4, signs=signs)) for signs in ("signed", "auto"))
    assert signed.negative_energy(pairs.wi, pairs.wo) > 0.01
    assert chosen.negative_energy(pairs.wi, pairs.wo) == 0.0
    before, after = pairs.measure_held_out(signed), pairs.measure_held_out(chosen)
    assert after.sq_log < 0.5 * before.sq_log
    assert after.rms_cosine_weighted < 1.05 * before.rms_cosine_weighted


def test_terms_that_are_nowhere_negative_stay_those_of_least_squares() -> None:
    brdf = brdf_from_text("phong:exponent=20")
    signed, chosen = (drain(factors_for(brdf, 4, signs=signs)) for signs in ("signed", "auto"))
    assert np.array_equal(signed.first, chosen.first)
