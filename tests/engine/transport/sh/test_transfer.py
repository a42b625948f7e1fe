"""Transfer in SH: open and closed points, brute sums over texels, bounces, fixed light and view, the file."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from engine.brdf.brdf import Brdf, brdf_from_text
from engine.brdf.models.diffuse import Lambert
from engine.core.directions import normalize
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.light.cube_map import CubeMap, cube_directions, cube_solid_angles
from engine.transport.baking.file import open_transport
from engine.transport.baking.visibility import receivers
from engine.transport.relight import RelightSh
from engine.transport.sh.bake import BakeSettings, bake, prepare, reflect, transport_of
from engine.transport.sh.basis import cosine_zonal, evaluate, turn_zonal
from engine.transport.sh.brdf_table import lambert_table, tabulate
from engine.transport.sh.error import sh_error
from engine.transport.sh.rotation import rotate_into_frames
from engine.transport.sh.transfer import (
    STEP,
    ShTransport,
    compute_unshadowed,
    diffuse_vectors,
    local_views,
    matrices,
    products,
    sum_signed_radiance,
    tangent_frames,
    texel_basis,
    transfer,
    visibility_harmonics,
    with_table,
)
from tests.threads import threads

EDGE = 16
GLOSSY = "ggx:kd=0.3/0.5/0.2,alpha=0.4,f0=0.04"
QUICK = BakeSettings(order=4, edge=EDGE, fine=2, gather=256)


@pytest.fixture(autouse=True)
def quick_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small tables: their contents are tested in test_brdf_table."""
    monkeypatch.setattr("engine.transport.sh.brdf_table.SAMPLES", 512)


def small(turns: int = 12, rows: int = 7) -> Mesh:
    """A coarse sphere of `turns` vertices around and `rows` of them between the poles."""
    theta = np.pi * np.arange(1, rows + 1) / (rows + 1)
    phi = 2.0 * np.pi * np.arange(turns) / turns
    ring = [[np.sin(t) * np.sin(p), np.cos(t), np.sin(t) * np.cos(p)] for t in theta for p in phi]
    positions = np.array([[0.0, 1.0, 0.0], *ring, [0.0, -1.0, 0.0]])
    faces = []
    for column in range(turns):
        beside = (column + 1) % turns
        faces.append((0, 1 + column, 1 + beside))
        for row in range(rows - 1):
            a, b = 1 + row * turns + column, 1 + row * turns + beside
            faces += [(a, a + turns, b + turns), (a, b + turns, b)]
        last = 1 + (rows - 1) * turns
        faces.append((last + column, len(positions) - 1, last + beside))
    uv = np.zeros((len(positions), 2), np.float32)
    return Mesh(positions, positions.astype(np.float32), uv, np.array(faces, np.int32), "small")


def bake_transfer(
    mesh: Mesh, brdf: Brdf, path: Path, settings: BakeSettings = QUICK, ground: Ground | None = None
) -> Any:
    return drain(bake(path, drain(prepare(mesh, brdf, settings, ground))))


def random_light(order: int) -> np.ndarray:
    return np.random.default_rng(5).normal(size=(order**2, 3))


@pytest.mark.parametrize("order", [3, 5])
def test_triple_products_are_the_integrals(order: int) -> None:
    table = products(order)
    directions = cube_directions(64).reshape(-1, 3)
    area = np.tile(cube_solid_angles(64).reshape(-1), 6)
    basis, higher = evaluate(order, directions), evaluate(2 * order - 1, directions)
    rng = np.random.default_rng(0)
    for pair in rng.choice(len(table.first), 30):
        i, j = table.first[pair], table.second[pair]
        exact = (basis[:, i] * basis[:, j] * area) @ higher
        found = np.zeros(higher.shape[1])
        terms = slice(table.start[pair], table.start[pair + 1])
        found[table.index[terms]] = table.weight[terms]
        even = (
            np.arange((2 * order - 1) ** 2) - np.repeat(np.arange(2 * order - 1) ** 2, 2 * np.arange(2 * order - 1) + 1)
        ) % 2 == 0
        assert np.abs(found - exact)[even].max() < 2e-3


def test_integrals_over_texels_sum_to_those_over_the_sphere() -> None:
    total = texel_basis(EDGE, 7).astype(np.float64).sum(axis=0)
    assert abs(total[0] - np.sqrt(4.0 * np.pi)) < 1e-5
    assert np.abs(total[1:]).max() < 1e-5


def test_H11_an_open_point_has_the_rotation_and_a_closed_one_exactly_nothing() -> None:
    frames = tangent_frames(small())[::7]
    light = random_light(4)
    directions = cube_directions(64).reshape(-1, 3)
    above = (frames[:, :, 2] @ directions.T > 0.0).astype(np.uint8)
    rotated = rotate_into_frames(light, frames)
    for free, bound in ((True, 1e-6), (False, 0.02)):  # exactly, and by the sum over texels cut at the horizon
        seen = visibility_harmonics(above, 1, 64, 7)
        found = matrices(seen, frames, np.full(len(frames), free)) @ light
        assert np.abs(found - rotated).max() < bound * np.abs(rotated).max()
    closed = matrices(visibility_harmonics(np.zeros_like(above), 1, 64, 7), frames, np.zeros(len(frames), bool))
    assert not closed.any()


def test_matrices_are_the_integral_of_visibility_seen_in_a_mirror() -> None:
    rng = np.random.default_rng(1)
    frames = tangent_frames(small())[[5, 40]]
    directions = cube_directions(EDGE).reshape(-1, 3)
    counts = rng.choice(np.array([0, 2, 4], np.uint8), (2, len(directions)))
    counts[(frames[:, :, 2] @ directions.T) <= 0.0] = 0
    found = matrices(visibility_harmonics(counts, 4, EDGE, 7), frames, np.zeros(2, bool))
    light = random_light(4)
    area = np.tile(cube_solid_angles(EDGE).reshape(-1), 6)
    for frame, count, matrix in zip(frames, counts, found, strict=True):
        weight = count / 4.0 * area
        mirrored = directions - 2.0 * np.outer(directions @ frame[:, 2], frame[:, 2])
        expected = np.zeros((16, 3))
        for towards in (directions, mirrored):
            expected += (evaluate(4, towards @ frame) * weight[:, None]).T @ (evaluate(4, towards) @ light)
        assert np.abs(matrix @ light - expected).max() < 0.02 * np.abs(expected).max()


def test_vectors_of_diffuse_vertices_are_the_integral_with_the_cosine() -> None:
    normals = normalize(np.random.default_rng(2).normal(size=(3, 3)))
    directions = cube_directions(32).reshape(-1, 3)
    above = (normals @ directions.T > 0.0).astype(np.uint8)
    exact = turn_zonal(cosine_zonal(5) / np.pi, normals)
    summed = diffuse_vectors(above, 1, 32, 5, normals, np.zeros(3, bool))
    assert np.abs(summed - exact).max() < 2e-3
    assert np.abs(diffuse_vectors(above, 1, 32, 5, normals, np.ones(3, bool)) - exact).max() < 1e-7


@pytest.mark.parametrize("text", ["lambert:albedo=0.6/0.5/0.4", GLOSSY])
def test_convex_models_are_shaded_as_without_transfer(text: str, tmp_path: Path) -> None:
    mesh, brdf = small(), brdf_from_text(text)
    done = bake_transfer(mesh, brdf, tmp_path / "a.transport")
    light, eye = random_light(4), (3.0, 1.0, 2.0)
    assert done.unoccluded_vertices == len(mesh.positions)
    assert done.file.arrays["rows"].shape == ((1 if text.startswith("lambert") else 16) * len(mesh.positions), 1, 16)
    table = drain(tabulate(brdf, 4))
    expected = table.radiance(compute_unshadowed(mesh, light), local_views(done.transport, eye))
    found = show(done.transport, light, eye)
    facing = local_views(done.transport, eye)[:, 2] > 0.0
    rounding = 0.0 if done.transport.diffuse else STEP * np.abs(light).max()
    assert np.abs(found - expected)[facing].max() < 2e-5 * np.abs(expected).max() + rounding
    assert not found[~facing].any()


def show(transport: ShTransport, light: np.ndarray, eye: tuple[float, float, float]) -> np.ndarray:
    """(V, 3) the radiance of all vertices towards `eye`."""
    everything = np.arange(len(transport.mesh.positions))
    return sum_signed_radiance(transport, transfer(transport, light), local_views(transport, eye), everything)


def test_what_the_graphics_device_draws_is_the_same_light(tmp_path: Path) -> None:
    light, eye = random_light(4), (3.0, 1.0, 2.0)
    for text in (GLOSSY, "lambert:albedo=0.2/0.3/0.4"):
        path = tmp_path / f"{text[:3]}.transport"
        transport = bake_transfer(small(), brdf_from_text(text), path, ground=Ground(cells=4)).transport
        lit = RelightSh(transport, transfer(transport, light))
        local = local_views(transport, eye)
        kept = lit.flat_vertex
        own = lit.rows[: kept * 16].reshape(kept, 16, 3)
        found = np.concatenate([lit.table.radiance(own, local[:kept], np.arange(kept)), lit.flat])
        expected = show(transport, light, eye)
        facing = local[:, 2] > 0.0
        assert np.abs(found - expected)[facing].max() < 1e-5 * expected.max()


def test_H12_light_of_another_order_is_refused(tmp_path: Path) -> None:
    transport = bake_transfer(small(), Lambert(), tmp_path / "a.transport").transport
    with pytest.raises(ValueError, match="does not fit transport of order 4"):
        transfer(transport, random_light(5))


def box() -> Mesh:
    """A closed box seen from inside: every vertex sees faces alone. Eight corners of each face are apart."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    positions: list[Any] = []
    normals: list[Any] = []
    faces: list[Any] = []
    for quad in quads:
        a, b, c, d = corners[list(quad)]
        inwards = -normalize((a + b + c + d) / 4.0)
        order = (0, 1, 2, 3) if np.dot(np.cross(b - a, c - a), inwards) > 0.0 else (0, 3, 2, 1)
        # a little in from the corners, so that origins do not lie on three faces at once
        start, points = len(positions), corners[[quad[k] for k in order]]
        positions += list(points)
        normals += [inwards] * 4
        faces += [(start, start + 1, start + 2), (start, start + 2, start + 3)]
    count = len(positions)
    return Mesh(
        np.array(positions),
        np.array(normals, np.float32),
        np.zeros((count, 2), np.float32),
        np.array(faces, np.int32),
        "box",
    )


def test_H11_inside_a_closed_box_it_is_dark(tmp_path: Path) -> None:
    for brdf in (Lambert(), brdf_from_text(GLOSSY)):
        settings = replace(QUICK, bounces=2)
        transport = bake_transfer(box(), brdf, tmp_path / f"{type(brdf).__name__}.transport", settings).transport
        assert not transport.rows.any()


def test_bounces_add_up_to_less_than_a_geometric_series(tmp_path: Path) -> None:
    """The sent light exceeds one reflection, and stays below that of a closed room of the same albedo."""
    mesh, albedo = small(), 0.5
    work = drain(prepare(mesh, Lambert((albedo,) * 3), replace(QUICK, bounces=8), Ground(albedo=albedo, cells=1)))
    of = receivers(work.surface, work.caster)
    sent = drain(reflect(work, of))
    ambient = np.zeros(16)
    ambient[0] = np.sqrt(4.0 * np.pi)
    radiance = sent[:, 0] @ ambient
    assert (radiance[: len(mesh.positions)] > 0.0).all()
    assert radiance.max() <= albedo / (1.0 - albedo) + 1e-6
    lowest = mesh.positions[:, 1].argmin()
    once = drain(
        reflect(
            drain(prepare(mesh, Lambert((albedo,) * 3), replace(QUICK, bounces=1), Ground(albedo=albedo, cells=1))), of
        )
    )
    assert (radiance - once[:, 0] @ ambient)[lowest] >= 0.0


def test_bounces_brighten_the_underside_by_what_the_ground_sends(tmp_path: Path) -> None:
    """Over a wide white ground, the underside of a small sphere far up sees the radiance of the ground."""
    mesh = small()
    ground = Ground(height=-40.0, albedo=0.8, extent=400.0, cells=8)
    light = np.zeros((16, 3))
    light[0] = np.sqrt(4.0 * np.pi)
    for brdf in (Lambert((0.5,) * 3), brdf_from_text("ggx:kd=0.5,alpha=0.5,f0=0.04")):
        rows = {}
        for bounces in (0, 1):
            path = tmp_path / f"{type(brdf).__name__}{bounces}.transport"
            transport = bake_transfer(mesh, brdf, path, replace(QUICK, bounces=bounces), ground).transport
            rows[bounces] = transport, transfer(transport, light)
        lowest = int(mesh.positions[:, 1].argmin())
        local = np.array([[0.6, 0.0, 0.8]])
        dark, bright = (
            sum_signed_radiance(transport, found, local, np.array([lowest]))[0, 0] for transport, found in rows.values()
        )
        table = transport.table
        lit = np.zeros((1, 16, 3))
        lit[0, 0] = np.sqrt(4.0 * np.pi)
        open_sky = table.radiance(lit, local)[0, 0]
        assert dark < 0.05 * open_sky
        assert bright == pytest.approx(0.8 * open_sky, rel=0.05)


def test_another_brdf_is_shown_without_a_bake_where_it_can_be(tmp_path: Path) -> None:
    glossy = bake_transfer(small(), brdf_from_text(GLOSSY), tmp_path / "a.transport").transport
    other = drain(tabulate(brdf_from_text("phong:exponent=8"), 5))
    fresh = bake_transfer(small(), brdf_from_text("phong:exponent=8"), tmp_path / "b.transport").transport
    light, eye = random_light(4), (3.0, 1.0, 2.0)
    changed = show(with_table(glossy, other), light, eye)
    assert np.abs(changed - show(fresh, light, eye)).max() < 0.01 * np.abs(changed).max()
    diffuse = bake_transfer(small(), Lambert((0.5,) * 3), tmp_path / "c.transport").transport
    scaled = show(with_table(diffuse, lambert_table(Lambert((0.25,) * 3), 4)), light, eye)
    assert np.abs(2.0 * scaled - show(diffuse, light, eye)).max() < 1e-6
    with pytest.raises(ValueError, match="baked as vectors"):
        with_table(diffuse, other)
    with pytest.raises(ValueError, match="baked for one BRDF"):
        with_table(
            bake_transfer(small(), Lambert(), tmp_path / "d.transport", replace(QUICK, bounces=1)).transport, other
        )


def test_the_file_is_the_same_for_any_number_of_threads_and_after_a_pause(tmp_path: Path) -> None:
    brdf, settings = brdf_from_text(GLOSSY), replace(QUICK, bounces=1)
    ground = Ground(cells=4)
    with threads(1):
        bake_transfer(small(), brdf, tmp_path / "one.transport", settings, ground)
    with threads(2):
        work = drain(prepare(small(), brdf, settings, ground))
        steps = bake(tmp_path / "two.transport", work)
        for step in steps:
            if "baking vertex" in step.note:
                break
        steps.close()
        assert not (tmp_path / "two.transport").exists()
        again = bake_transfer(small(), brdf, tmp_path / "two.transport", settings, ground)
    assert again.resumed_chunks >= 1
    assert (tmp_path / "one.transport").read_bytes() == (tmp_path / "two.transport").read_bytes()
    assert (tmp_path / "two.transport").stat().st_size < work.size_bytes


def test_files_of_other_modes_and_meshes_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.transport"
    bake_transfer(small(), Lambert(), path)
    transport_of(open_transport(path, small()))
    with pytest.raises(InputError, match="another mesh"):
        transport_of(open_transport(path, small(10)))
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))
    with pytest.raises(InputError, match="damaged"):
        transport_of(open_transport(path))


def test_settings_that_cannot_be_baked_are_refused() -> None:
    for wrong in ({"order": 2}, {"order": 16}, {"edge": 2}, {"fine": 0}, {"bounces": -1}, {"gather": 3}):
        with pytest.raises(ValueError, match=r"outside|not possible|not 0"):
            BakeSettings(**cast(Any, wrong))
    mesh, rows = small(), np.zeros((3, 1, 16), np.float32)
    with pytest.raises(ValueError, match="do not belong"):
        ShTransport(mesh, len(mesh.positions), True, 0.0, lambert_table(Lambert(), 4), False, rows)


def test_the_error_falls_with_the_order() -> None:
    rng = np.random.default_rng(0)
    cube = CubeMap(rng.random((6, EDGE, EDGE, 3), np.float32) ** 8)
    brdf = brdf_from_text(GLOSSY)
    errors = []
    for order in (3, 4, 5, 7, 10, 15):
        work = drain(prepare(small(), brdf, BakeSettings(order=order, edge=EDGE, fine=2), Ground(cells=4)))
        errors.append(drain(sh_error(work, brdf, cube, vertices=20, views=6)).rmse_rel)
    assert all(after < 0.95 * before for before, after in pairwise(errors)), errors
