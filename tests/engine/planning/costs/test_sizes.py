"""Predicted bytes are those of the files and of the arrays in memory, to the byte."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.light.environment_file import open_environment
from engine.planning.costs import sizes
from engine.planning.costs.load import Load
from engine.planning.costs.setting import Setting
from engine.transport.baking.file_header import head_of, read_header
from engine.transport.gaussian import bake as gaussian_bake
from engine.transport.relight import relight_gaussians
from engine.transport.sh import bake as sh_bake
from engine.transport.sh.transfer import is_diffuse, transfer
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.lighting import lighting_of
from engine.transport.wavelet.transfer import relight_transport
from tests.engine.planning.brute_force import sphere, spheres

GLOSSY = "ggx:kd=0.5,alpha=0.3,f0=0.04"


def load_of(surface: Mesh, model: Mesh, brdf: Any) -> Load:
    vertices, first = len(surface.positions), len(model.positions)
    look = (is_diffuse(brdf), bool(brdf.isotropic), False)
    return Load(vertices, 1, len(surface.faces), 1.0, *look, ground=vertices - first)


@pytest.mark.parametrize(
    ("text", "ground"),
    [
        ("lambert:albedo=0.5", None),
        ("lambert:albedo=0.5", Ground(cells=16)),
        (GLOSSY, Ground(cells=16)),
        ("ward:alpha_x=0.1,alpha_y=0.4", None),
        pytest.param(GLOSSY, None, marks=pytest.mark.long),
        pytest.param("ward:alpha_x=0.1,alpha_y=0.4", Ground(cells=16), marks=pytest.mark.long),
    ],
)
def test_T7_sizes_of_harmonics_are_those_of_their_files(text: str, ground: Ground | None) -> None:
    mesh, brdf = spheres(1.2), brdf_from_text(text)
    for order, bounces in ((3, 0), (5, 2)):
        work = drain(sh_bake.prepare(mesh, brdf, sh_bake.BakeSettings(order, bounces=bounces), ground))
        setting = Setting("sh", {"order": order, "interreflection": min(bounces, 1)})
        assert sizes.spherical_harmonics(setting, load_of(work.surface, mesh, brdf)).file == work.size_bytes


def test_T7_coloured_bounces_take_three_times_the_rows() -> None:
    mesh, brdf = spheres(1.2), brdf_from_text("lambert:albedo=0.5/0.4/0.3")
    work = drain(sh_bake.prepare(mesh, brdf, sh_bake.BakeSettings(5, bounces=2)))
    load = Load(len(mesh.positions), 1, len(mesh.faces), 1.0, True)
    assert sizes.spherical_harmonics(Setting("sh", {"interreflection": 1}), load).file == work.size_bytes


@pytest.mark.parametrize("ground", [None, Ground(cells=16)])
@pytest.mark.parametrize(("terms", "kept", "edge", "bounces"), [(2, 24, 64, 0), (4, 384, 16, 3), (3, 4000, 16, 0)])
def test_T7_sizes_of_wavelets_are_those_of_their_files(
    ground: Ground | None, terms: int, kept: int, edge: int, bounces: int
) -> None:
    from engine.planning.costs.machine_profile import factors_of

    mesh = spheres(1.2)
    kept_at_most = min(kept, 6 * edge**2)
    settings = wavelet_bake.BakeSettings(edge, kept_at_most, bounces=bounces)
    work = wavelet_bake.prepare(mesh, factors_of(terms), settings, ground)
    named = {"terms": terms, "coefficients": kept, "cube": edge, "interreflection": min(bounces, 1)}
    setting = Setting("wavelet", named)
    assert sizes.wavelets(setting, load_of(work.surface, mesh, brdf_from_text(GLOSSY))).file == work.size_bytes


@pytest.mark.parametrize("bounces", [False, True])
def test_T7_sizes_of_gaussians_are_those_of_their_files(tmp_path: Path, bounces: bool) -> None:
    mesh, brdf = sphere(4), brdf_from_text(GLOSSY)
    settings = gaussian_bake.BakeSettings(2, bounces, samples=16, weights="plain", relaxations=0)
    work = drain(gaussian_bake.prepare(mesh, brdf, settings, probes=2))
    made = drain(gaussian_bake.bake(tmp_path / "lobes.transport", work))
    setting = Setting("gaussian", {"lobes": 2, "interreflection": int(bounces)})
    predicted = sizes.gaussians(setting, load_of(mesh, mesh, brdf))
    header = read_header(tmp_path / "lobes.transport", head_of(tmp_path / "lobes.transport")[0])
    assert abs(predicted.file - header.size_bytes) <= 4096  # a header of a page more or less
    light = relight_gaussians(made.transport, None)
    held = [array for lobes in made.transport.components for array in (lobes.weight, lobes.mean, lobes.sigma)]
    assert made.transport.diffuse is not None
    assert predicted.memory - mesh_bytes(made.file.mesh) == sum(
        array.nbytes for array in held
    ) + light.diffuse.nbytes + (made.transport.diffuse.rows.nbytes)


def mesh_bytes(mesh: Mesh) -> int:
    return sum(array.nbytes for array in (mesh.positions, mesh.normals, mesh.uv, mesh.faces))


def test_T7_memory_is_that_of_the_arrays_held_while_drawn(tmp_path: Path) -> None:
    from engine.planning.costs.machine_profile import factors_of
    from engine.transport.sh.lighting import project

    mesh, brdf, light = sphere(8), brdf_from_text(GLOSSY), open_environment("sky")
    load = load_of(mesh, mesh, brdf)
    spherical_harmonics = drain(
        sh_bake.bake(tmp_path / "a", drain(sh_bake.prepare(mesh, brdf, sh_bake.BakeSettings(5))))
    ).transport
    held = (
        spherical_harmonics.rows.nbytes
        + cast(Any, spherical_harmonics.table).values.nbytes
        + transfer(spherical_harmonics, project(light, 5)).nbytes
    )
    assert sizes.spherical_harmonics(Setting("sh"), load).memory == mesh_bytes(spherical_harmonics.mesh) + held
    work = wavelet_bake.prepare(mesh, factors_of(2), wavelet_bake.BakeSettings(16, 24))
    wavelets = drain(wavelet_bake.bake(tmp_path / "b", work)).transport
    arrays = (wavelets.vectors.indices, wavelets.vectors.words, wavelets.vectors.peaks, wavelets.vectors.counts)
    maps = (wavelets.factors.first, wavelets.factors.second)
    rows = relight_transport(wavelets, lighting_of(light, 16).light)
    setting = Setting("wavelet", {"terms": 2, "coefficients": 24, "cube": 16})
    predicted = sizes.wavelets(setting, load).memory
    assert predicted == mesh_bytes(wavelets.mesh) + sum(array.nbytes for array in (*arrays, *maps, rows))
