"""BRDFs whose parameters vary over a model: mixed tables beside their own, how many there are, and bakes."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.geometry.ground import Ground
from engine.light.cube_map import CubeMap
from engine.transport.baking.file import open_transport
from engine.transport.baking.spatially_varying import Variation, vary_brdf, vertex_values
from engine.transport.sh import brdf_table_varying
from engine.transport.sh.bake import BakeSettings, bake, prepare, transport_of
from engine.transport.sh.brdf_table import BrdfTable, tabulate
from engine.transport.sh.brdf_table_varying import VariedTable, tabulate_varied
from engine.transport.sh.error import sh_error
from engine.transport.sh.transfer import local_views, sum_signed_radiance, transfer, view_vectors, with_table
from tests.engine.transport.sh.test_transfer import small

GLOSSY = "ggx:kd=0.3/0.5/0.2,alpha=0.4,f0=0.04"
ALPHA, KD = Variation("alpha", 0.2, 0.6, "y"), Variation("kd", 0.0, 0.8, "x")
QUICK = BakeSettings(order=4, edge=16, fine=2, gather=256)


@pytest.fixture(autouse=True)
def quick_tables(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small tables: their contents are tested in test_brdf_table."""
    monkeypatch.setattr("engine.transport.sh.brdf_table.SAMPLES", 512)


def views(count: int) -> np.ndarray:
    wo = np.random.default_rng(3).normal(size=(count, 3))
    wo[:, 2] = np.abs(wo[:, 2]) + 0.1
    return normalize(wo)


def grid_table(steps: tuple[int, ...], numbers: np.ndarray) -> VariedTable:
    """Tables whose coefficients are linear in each number, so that mixing is exact: 1 + u + 2 v + 4 u v."""
    nodes = tuple(np.linspace(0.0, 1.0, count) ** 2 for count in steps)
    mesh = np.stack(np.meshgrid(*nodes, indexing="ij"), axis=-1).reshape(-1, len(steps))
    tables = tuple(BrdfTable(3, np.full((8, 9, 3), value)) for value in bilinear(mesh))
    return VariedTable(tables, nodes, numbers)


def bilinear(numbers: np.ndarray) -> np.ndarray:
    u, v = numbers[:, 0], numbers[:, -1] if numbers.shape[1] > 1 else np.zeros(len(numbers))
    return np.asarray(1.0 + u + 2.0 * v + 4.0 * u * v)


@pytest.mark.parametrize("steps", [(1,), (2,), (5,), (1, 1), (1, 4), (3, 1), (4, 3)])
def test_mixing_is_linear_in_each_number_and_exact_at_nodes(steps: tuple[int, ...]) -> None:
    rng = np.random.default_rng(0)
    numbers = rng.random((200, len(steps))) * [count > 1 for count in steps]
    numbers[:2] = [[0.0] * len(steps), [1.0 if count > 1 else 0.0 for count in steps]]
    varied = grid_table(steps, numbers)
    index, weight = varied.corners(np.arange(200))
    assert np.abs(weight.sum(axis=1) - 1.0).max() < 1e-12
    assert (index.min() >= 0, index.max() < len(varied.tables)) == (True, True)
    wo = views(200)
    expected = bilinear(numbers)
    upright = varied.at(np.tile([0.0, 0.0, 1.0], (200, 1)), np.arange(200))
    np.testing.assert_allclose(upright[:, 0], np.repeat(expected[:, None], 3, axis=1), rtol=1e-5)
    light = rng.normal(size=(200, 9, 3))
    unit = BrdfTable(3, np.ones((8, 9, 3))).radiance(light, wo)
    np.testing.assert_allclose(varied.radiance(light, wo, np.arange(200)), unit * expected[:, None], rtol=1e-4)
    some = np.array([7, 0, 150])
    np.testing.assert_array_equal(
        varied.radiance(light[some], wo[some], some), varied.radiance(light, wo, np.arange(200))[some]
    )


def test_a_vertex_that_varies_shows_what_a_table_of_its_own_would() -> None:
    numbers = np.random.default_rng(1).random((6, 2))
    brdf = brdf_from_text(GLOSSY)
    varied = drain(tabulate_varied(brdf, 4, (ALPHA, KD), numbers))
    wo = views(40)
    light = np.random.default_rng(2).normal(size=(40, 16, 3))
    light[:, 0] += 3.0
    for vertex, number in enumerate(numbers):
        (own,) = vary_brdf(brdf, (ALPHA, KD), [[n] for n in number])
        exact = drain(tabulate(own, 4)).radiance(light, wo)
        found = varied.radiance(light, wo, np.full(40, vertex))
        assert np.linalg.norm(found - exact) < 0.03 * np.linalg.norm(exact)


def test_the_error_falls_with_the_number_of_tables_and_is_the_reported_one(monkeypatch: pytest.MonkeyPatch) -> None:
    numbers = np.linspace(0.0, 1.0, 16)[:, None]
    brdf, wide = brdf_from_text(GLOSSY), Variation("alpha", 0.05, 0.8, "y")
    exact = [drain(tabulate(one, 4)).values for one in vary_brdf(brdf, [wide], [numbers[:, 0]])]
    monkeypatch.setattr(brdf_table_varying, "TOLERANCE", 0.0)
    errors, reported = [], []
    for most in (2, 3, 5):
        monkeypatch.setattr(brdf_table_varying, "MAX_NODES", (most, most))
        varied = drain(tabulate_varied(brdf, 4, [wide], numbers))
        assert len(varied.tables) == most
        index, weight = varied.corners(np.arange(16))
        mixed = [
            sum(w * varied.tables[t].values for t, w in zip(*at, strict=True)) for at in zip(index, weight, strict=True)
        ]
        errors.append(max(np.linalg.norm(m - e) / np.linalg.norm(e) for m, e in zip(mixed, exact, strict=True)))
        reported.append(varied.interpolation_rel)
    assert all(after < 0.7 * before for before, after in pairwise(errors)), errors
    np.testing.assert_allclose(reported, errors, rtol=0.35)


def test_a_parameter_that_is_linear_needs_only_its_ends_and_one_that_stays_a_single_table() -> None:
    numbers = np.stack([np.linspace(0.0, 1.0, 9), np.full(9, 0.25)], axis=1)
    varied = drain(tabulate_varied(brdf_from_text(GLOSSY), 3, (KD, ALPHA), numbers))
    assert varied.steps == (2, 1)
    assert varied.interpolation_rel < 0.01  # what is left is noise of the tables
    assert varied.nodes[1].tolist() == [0.25]


def test_a_varied_lambertian_model_keeps_vectors_and_has_the_albedo_of_its_vertices(tmp_path: Path) -> None:
    mesh, shade = small(), Variation("albedo", 0.1, 0.9, "y")
    done = drain(bake(tmp_path / "t", drain(prepare(mesh, brdf_from_text("lambert"), QUICK, variations=[shade]))))
    transport = done.transport
    assert transport.rows.shape == (len(mesh.positions), 1, 16)
    even = np.zeros((16, 3))
    even[0] = np.sqrt(4.0 * np.pi)
    everything = np.arange(len(mesh.positions))
    straight = np.tile([0.0, 0.0, 1.0], (len(mesh.positions), 1))
    found = sum_signed_radiance(transport, transfer(transport, even), straight, everything)
    expected = 0.1 + 0.8 * vertex_values(mesh, "y")
    np.testing.assert_allclose(found, np.repeat(expected[:, None], 3, axis=1), rtol=2e-5)
    seen = view_vectors(transport, straight)
    np.testing.assert_allclose(np.einsum("vci,ic->vc", seen, even), found, rtol=2e-5)


def test_a_varied_bake_is_read_back_as_it_was_and_each_vertex_shows_its_own_brdf(tmp_path: Path) -> None:
    mesh, brdf = small(), brdf_from_text(GLOSSY)
    work = drain(prepare(mesh, brdf, QUICK, Ground(cells=4), (ALPHA, KD)))
    done = drain(bake(tmp_path / "t", work))
    assert done.file.settings["variations"] == ["alpha=0.2:0.6:y", "kd=0.0:0.8:x"]
    transport = transport_of(open_transport(tmp_path / "t"))
    assert isinstance(transport.table, VariedTable)
    np.testing.assert_array_equal(transport.table.numbers[:, 0], vertex_values(mesh, "y"))
    light = np.random.default_rng(5).normal(size=(16, 3))
    rows = transfer(transport, light)
    everything = np.arange(len(transport.mesh.positions))
    local = local_views(transport, (2.0, 1.0, 4.0))
    found = sum_signed_radiance(transport, rows, local, everything)
    seen = np.flatnonzero(local[: len(mesh.positions), 2] > 0.0)[::5]
    for vertex in seen:
        numbers = [[mesh_number] for mesh_number in transport.table.numbers[vertex]]
        own = with_table(transport, drain(tabulate(vary_brdf(brdf, (ALPHA, KD), numbers)[0], 4)))
        exact = sum_signed_radiance(own, rows, local[vertex][None], np.array([vertex]))
        assert np.abs(found[vertex] - exact[0]).max() < 0.03 * np.abs(found).max()
    by_view = np.einsum("vci,ic->vc", view_vectors(transport, local), light)
    np.testing.assert_allclose(by_view, found, atol=2e-5 * np.abs(found).max())


def test_the_error_against_the_sum_over_texels_is_about_that_of_one_brdf() -> None:
    mesh, brdf = small(), brdf_from_text(GLOSSY)
    radiance = np.random.default_rng(0).random((6, 16, 16, 3)).astype(np.float32)
    radiance[2, 4:8, 4:8] = 20.0
    cube = CubeMap(radiance)
    plain = drain(sh_error(drain(prepare(mesh, brdf, QUICK)), brdf, cube, vertices=40, views=8))
    alpha = Variation("alpha", 0.3, 0.5, "y")
    work = drain(prepare(mesh, brdf, QUICK, variations=[alpha]))
    varied = drain(sh_error(work, brdf, cube, variations=[alpha], vertices=40, views=8))
    assert 0.6 * plain.rmse_rel < varied.rmse_rel < 1.6 * plain.rmse_rel


def test_interreflection_takes_the_albedo_of_each_vertex() -> None:
    shade = Variation("albedo", 0.1, 0.9, "y")
    work = drain(
        prepare(small(), brdf_from_text("lambert"), BakeSettings(order=3, edge=8, bounces=1), variations=[shade])
    )
    np.testing.assert_allclose(work.albedo[:, 0], 0.1 + 0.8 * vertex_values(small(), "y"), rtol=1e-6)


def test_what_cannot_be_is_refused(tmp_path: Path) -> None:
    brdf, numbers = brdf_from_text(GLOSSY), np.zeros((4, 1))
    with pytest.raises(ValueError, match="no parameter"):
        drain(tabulate_varied(brdf, 3, [Variation("nu", 1.0, 2.0, "x")], numbers))
    three = [ALPHA, KD, Variation("f0", 0.0, 0.1, "x")]
    with pytest.raises(ValueError, match="1 or 2"):
        drain(tabulate_varied(brdf, 3, three, np.zeros((4, 3))))
    for wrong in (np.full((4, 1), 2.0), np.full((4, 1), np.nan), np.zeros((4, 2)), np.zeros(4)):
        with pytest.raises(ValueError, match=r"outside|number"):
            grid_table((3,), wrong)
    with pytest.raises(InputError):
        drain(prepare(small(), brdf, QUICK, variations=[Variation("alpha", 0.1, 0.2, str(tmp_path / "absent.png"))]))
