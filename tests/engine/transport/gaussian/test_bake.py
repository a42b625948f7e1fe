"""Baking lobes: to the same bytes whatever happens, near the sum over all light, and refused where it is not lobes."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.errors import InputError
from engine.core.steps import Step, Steps, drain
from engine.geometry.ground import Ground
from engine.light.cube_map import cube_of
from engine.light.environment_file import open_environment
from engine.transport.baking.diffuse_specular import diffuse_part
from engine.transport.baking.file import open_transport
from engine.transport.baking.settings import GaussianSettings
from engine.transport.baking.spatially_varying import Variation
from engine.transport.gaussian import bake as gaussian_bake
from engine.transport.gaussian.bake import BakeSettings, Work, bake, estimate_s, prepare, transport_of
from engine.transport.gaussian.error import GaussianError, Weighting
from engine.transport.gaussian.fitting.views import VIEWS, view_directions
from engine.transport.gaussian.samples import glossy_surface
from engine.transport.gaussian.transfer import diffuse_gain, diffuse_radiance
from engine.transport.sh.lighting import project
from tests.engine.transport.gaussian.test_samples import sphere
from tests.threads import threads

GLOSSY = "ashikhmin-shirley:kd=0.4/0.3/0.2,ks=0.05,nu=10,nv=30"
QUICK = BakeSettings(samples=64, edge=16, fine=2)


def ready(settings: BakeSettings = QUICK, text: str = GLOSSY, **more: Any) -> Work:
    ground = Ground(cells=4) if more.pop("on_ground", True) else None
    light = "studio", cube_of(open_environment("studio"), 16)
    return drain(prepare(sphere(4), brdf_from_text(text), settings, ground, environment=light, probes=8, **more))


@pytest.fixture(scope="module")
def work() -> Work:
    return ready()


@pytest.fixture(scope="module")
def file(work: Work, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("baked") / "ball.transport"
    drain(bake(path, work))
    return path


def test_a_bake_holds_what_was_announced(work: Work, file: Path) -> None:
    assert 0.2 * work.size_bytes < file.stat().st_size < work.size_bytes
    assert estimate_s(work) > 0.0
    transport = transport_of(open_transport(file, work.surface))
    (lobes,) = transport.components
    assert lobes.sigma.shape == (len(sphere(4).positions), VIEWS, 1)
    assert transport.ground_vertex == len(sphere(4).positions)
    assert transport.grazing
    facing = transport.normals[: transport.ground_vertex] @ view_directions().T > 0.0
    assert not lobes.weight[~facing].any()
    assert np.abs(np.einsum("...i,...i->...", lobes.mean, lobes.mean) - 1.0).max() < 1e-5
    assert [each.name for each in file.parent.iterdir()] == [file.name]


def test_lobes_of_open_vertices_have_about_the_energy_of_the_highlight(work: Work, file: Path) -> None:
    """A plain fit loses some; one with all energy has that of the BRDF."""
    whole = drain(bake(file.with_name("whole"), ready(BakeSettings(samples=64, edge=16, fine=2, weights="preserving"))))
    surface = glossy_surface(work.surface, brdf_from_text(GLOSSY))
    vertex = 0  # the top, which sees the whole sky
    views = np.flatnonzero(view_directions() @ surface.frames[vertex, :, 2] > 0.3)
    from engine.transport.gaussian.samples import draw

    drawn = draw(surface, vertex, view_directions()[views], 4096)
    exact = np.einsum("ms,msc->mc", drawn.weight, drawn.value)
    found = whole.transport.components[0].energy()[vertex, views]
    assert np.abs(found / exact - 1.0).max() < 0.12  # 64 directions
    assert abs((found / exact - 1.0).mean()) < 0.03


def test_what_was_interrupted_ends_in_the_same_bytes(work: Work, file: Path, tmp_path: Path) -> None:
    path = tmp_path / "again"
    for stop in (3, 2):
        steps = bake(path, work)
        for number, _ in enumerate(steps):
            if number == stop:
                break
        steps.close()
        assert not path.exists()
    baked = drain(bake(path, work))
    assert 0 < baked.resumed_chunks < baked.chunks
    assert path.read_bytes() == file.read_bytes()
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_one_thread_and_two_make_the_same_bytes(work: Work, file: Path, tmp_path: Path) -> None:
    for count in (1, 2):
        with threads(count):
            drain(bake(tmp_path / str(count), work))
        assert (tmp_path / str(count)).read_bytes() == file.read_bytes()


def test_the_diffuse_part_is_the_sum_over_the_light(file: Path) -> None:
    """Against a brute sum over texels with the BRDF's own diffuse part, of an open vertex."""
    transport = transport_of(open_transport(file))
    cube = cube_of(open_environment("sky"), 32)
    diffuse = diffuse_part(brdf_from_text(GLOSSY))
    assert diffuse.grazing
    vertex, eye = 0, np.array([2.0, 6.0, 1.0])
    frame = glossy_surface(sphere(4), brdf_from_text(GLOSSY)).frames[vertex]
    from engine.light.cube_map import cube_directions, cube_solid_angles

    wi = cube_directions(32).reshape(-1, 3) @ frame
    wo = (eye - transport.mesh.positions[vertex]) @ frame
    area = np.tile(cube_solid_angles(32).reshape(-1), 6)
    incident = cube.radiance.reshape(-1, 3) * area[:, None]
    exact = (diffuse.f(wi, wo / np.linalg.norm(wo)) * np.maximum(wi[:, 2:], 0.0) * incident).sum(axis=0)
    found = (
        diffuse_radiance(transport, project(cube, GaussianSettings.order))[vertex]
        * diffuse_gain(transport, eye)[vertex]
    )
    assert np.abs(found / exact - 1.0).max() < 0.03


def test_a_better_fit_is_chosen_by_the_error_of_radiance(work: Work) -> None:
    error = work.error
    assert 0.0 < error.of(work.weights[0]) == min(error.plain_rmse_rel, error.preserving_rmse_rel)
    assert error.glossy_plain_rmse_rel < 0.5
    assert ready(BakeSettings(samples=64, weights="plain")).weights == ("plain",)


@pytest.mark.parametrize("better", ["plain", "preserving"])
def test_direct_light_is_weighed_by_the_lower_error_and_indirect_light_with_all_energy(
    monkeypatch: pytest.MonkeyPatch, better: Weighting
) -> None:
    plain, preserving = (0.1, 0.2) if better == "plain" else (0.2, 0.1)
    found = GaussianError(plain, preserving, 0.0, 0.0, 0.3, 0.3, 1)

    def find_known(*_: object, **__: object) -> Steps[GaussianError]:
        yield Step(1.0, "known")
        return found

    monkeypatch.setattr(gaussian_bake, "gaussian_error", find_known)
    assert ready(replace(QUICK, indirect=True)).weights == (better, "preserving")


def test_indirect_light_is_a_component_of_its_own(tmp_path: Path) -> None:
    settings = BakeSettings(samples=64, edge=16, fine=2, indirect=True)
    baked = drain(bake(tmp_path / "a", ready(settings)))
    direct, indirect = baked.transport.components
    low = baked.transport.normals[: baked.transport.ground_vertex, 1] < -0.3  # looks at the ground
    views = view_directions()[:, 1] < 0.0
    shares = [each.energy()[low][:, views].sum() for each in (direct, indirect)]
    assert shares[1] > 0.1 * shares[0] > 0.0
    assert not indirect.weight[0].any()  # the top sees the sky alone
    assert baked.transport.diffuse is not None
    assert baked.transport.diffuse.rows.shape[1] == 3
    assert {"indirect_error_rel_mean", "direct_plain_energy_lost_rel", "direct_flipped_pairs"} <= set(baked.figures)


def test_parameters_that_vary_move_the_width_of_lobes(tmp_path: Path) -> None:
    varied = (Variation("alpha", 0.1, 0.7, "y"), Variation("kd", 0.0, 0.8, "y"))
    made = ready(QUICK, "ggx:kd=0.3,alpha=0.2,f0=0.5", on_ground=False, variations=varied)
    transport = drain(bake(tmp_path / "a", made)).transport
    (lobes,) = transport.components
    bright = lobes.energy().sum(axis=2).argmax(axis=1)
    sigma = lobes.sigma[np.arange(len(bright)), bright, 0]
    assert sigma[0] > 3.0 * sigma[-1]  # the top against the bottom
    flat = diffuse_radiance(transport, project(cube_of(open_environment("overcast"), 32), made.settings.order))
    assert flat[0].min() > 0.0
    assert abs(flat[-1]).max() == 0.0
    assert json.loads(json.dumps(open_transport(tmp_path / "a").settings["variations"])) == [
        "alpha=0.1:0.7:y",
        "kd=0.0:0.8:y",
    ]


def test_what_is_diffuse_is_refused() -> None:
    with pytest.raises(ValueError, match="this BRDF has no glossy part"):
        ready(text="lambert:albedo=0.5")


@pytest.mark.parametrize(
    "settings", [{"lobes": 4}, {"samples": 4}, {"order": 2}, {"edge": 2}, {"fine": 0}, {"weights": "loud"}]
)
def test_settings_that_cannot_be_are_refused(settings: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=r"possible|outside|cannot|weights"):
        BakeSettings(**settings)


def test_damaged_files_and_other_kinds_are_refused(file: Path, tmp_path: Path) -> None:
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 1
    (tmp_path / "damaged").write_bytes(content)
    with pytest.raises(InputError, match="damaged"):
        transport_of(open_transport(tmp_path / "damaged"))
    opened = open_transport(file)
    changes: list[dict[str, Any]]
    changes = [{"kind": "sh"}, {"settings": {**opened.settings, "ground_vertex": 3}}, {"settings": {}}]
    for change in changes:
        with pytest.raises(InputError):
            transport_of(type(opened)(**{**vars(opened), **change}))
    for name, value in (
        ("direct_sigma", 0.0),
        ("direct_weight", -1.0),
        ("direct_mean", 0.5),
        ("direct_weight", np.nan),
    ):
        broken = opened.arrays[name].copy()
        broken.reshape(-1)[0] = value
        arrays = {**opened.arrays, name: broken}
        with pytest.raises(InputError, match="lobes have"):
            transport_of(type(opened)(**{**vars(opened), "arrays": arrays}))
