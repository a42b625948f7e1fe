"""Readers that are not part of the package: on the command line, in the API, the window, a project and a bundle."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lightarc
from app.brdf.dialogs import browse
from app.commands.recognise import recognise
from app.document.comparison import Entry
from app.document.document import Project
from app.project.project_file import History, Writer
from app.project.project_file import read as read_project
from engine.brdf.readers.read import read_brdf
from engine.capture.photograph.decode import read_photograph
from engine.capture.photograph.kinds import kind_name, kind_of, photograph_suffixes
from engine.geometry.mesh import read_mesh
from engine.storage.readers import Reader, dialog_filter, readers, register, suffixes, unregister
from tests.plain_formats import BRDF, IMAGE, MESH

TESTS = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Path]]:
    """A file of each kind, with its reader registered; the processes that know the readers serve all tests."""
    for reader in (IMAGE, MESH, BRDF):
        register(reader)
    yield files_in(tmp_path_factory.mktemp("plain"))
    for reader in (IMAGE, MESH, BRDF):
        unregister(reader)


def files_in(folder: Path) -> dict[str, Path]:
    """Sky of radiance 2, a square of two triangles, and a BRDF of 0.25/sr in some directions."""
    texts = {
        "sky.plainimage": "PLAINIMAGE 4 2 " + "2 " * 8,
        "square.plainmesh": "PLAINMESH\n0 0 0 1 0 0 1 1 0\n0 0 0 1 1 0 0 1 0\n",
        "paint.plainbrdf": "PLAINBRDF\n" + "\n".join(_rows()),
    }
    for name, text in texts.items():
        (folder / name).write_text(text)
    return {name.partition(".")[0]: folder / name for name in texts}


def _rows() -> Iterator[str]:
    rng = np.random.default_rng(1)
    for pair in rng.normal(size=(60, 2, 3)):
        pair[:, 2] = np.abs(pair[:, 2]) + 0.2
        directions = pair / np.linalg.norm(pair, axis=1, keepdims=True)
        yield " ".join(f"{value:.12f}" for value in directions.reshape(-1)) + " 0.25"


def test_an_installed_package_adds_readers_to_the_command_line(tmp_path: Path) -> None:
    """A distribution of its own, whose modules the confined process imports as well."""
    shutil.copy(TESTS / "plain_formats.py", tmp_path / "moon_formats.py")
    info = tmp_path / "moon-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: moon\nVersion: 1.0\n")
    entries = ["[lightarc.readers]", *(f"{name} = moon_formats:{name}" for name in ("IMAGE", "MESH", "BRDF")), ""]
    (info / "entry_points.txt").write_text("\n".join(entries))
    files = files_in(tmp_path)
    command = "import sys; sys.path.insert(0, sys.argv.pop(1)); from app.__main__ import main; sys.exit(main())"
    options = ["--brdf", files["paint"], "--env", files["sky"], "--width", "8", "--height", "6", "--renderer", "cpu"]
    words = [tmp_path, "render", files["square"], *options, "-o", tmp_path / "out.exr", "--json"]
    done = subprocess.run(
        [sys.executable, "-c", command, *map(str, words)], capture_output=True, text=True, cwd=TESTS.parent
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["environment"] == "sky.plainimage"
    assert json.loads(done.stdout)["mean_radiance"] > 0.1


def test_the_api_and_photographs_take_its_files(plain: dict[str, Path]) -> None:
    scene = lightarc.make_scene(plain["square"], brdf=plain["paint"], environment=plain["sky"])
    assert len(scene.mesh.faces) == 2
    assert scene.brdf.f(np.array([[0.0, 0.0, 1.0]]), np.array([[0.6, 0.0, 0.8]]))[0] == pytest.approx([0.25] * 3)
    assert scene.environment is not None
    assert scene.environment.radiance.max() == pytest.approx(2.0)
    photograph = read_photograph(plain["sky"])
    assert photograph.radiance.shape == (2, 4, 3)
    assert photograph.container == "PLAIN"


def test_the_window_recognises_offers_and_names_them(plain: dict[str, Path], monkeypatch: pytest.MonkeyPatch) -> None:
    groups = recognise(list(plain.values())).groups
    assert {(group.kind, group.paths[0]) for group in groups} == {
        ("environment", plain["sky"]),
        ("mesh", plain["square"]),
        ("brdf", plain["paint"]),
    }
    asked: list[str] = []

    def choose_nothing(*words: str) -> tuple[list[str], str]:
        asked.append(words[-1])
        return [], ""

    monkeypatch.setattr("app.brdf.dialogs.QFileDialog.getOpenFileNames", choose_nothing)
    browse(None, None)  # type: ignore[arg-type]
    assert "*.plainbrdf" in asked[0]
    assert "*.plainmesh" in dialog_filter("Meshes", suffixes("mesh"))
    assert ".plainimage" in photograph_suffixes()
    assert kind_name(kind_of(plain["sky"])) == "Plain image"


def test_a_project_and_a_bundle_keep_what_was_read(plain: dict[str, Path], tmp_path: Path) -> None:
    project = Project(mesh=read_mesh(plain["square"]))
    measured = read_brdf(plain["paint"])
    project = replace(project, comparison=replace(project.comparison, entries=(Entry("paint", measured, 0),)))
    writer = Writer(tmp_path / "moon.lap")
    writer.write(History(project, (), 0))
    writer.close()
    opened = read_project(tmp_path / "moon.lap")
    assert not opened.missing
    assert opened.current.mesh is not None
    assert np.array_equal(opened.current.mesh.positions, read_mesh(plain["square"]).positions)
    wi, wo = np.array([[0.0, 0.0, 1.0]]), np.array([[0.6, 0.0, 0.8]])
    assert np.allclose(opened.current.comparison.entries[0].brdf.f(wi, wo), measured.f(wi, wo))
    photographs = np.linspace(0.1, 1.0, 3)[:, None, None, None] * np.ones((3, 8, 8, 3), np.float32)
    material = lightarc.compress_material(lightarc.build_material(photographs, slices=3, brdf=plain["paint"]))
    lightarc.save_bundle(tmp_path / "moon.lightarc", material)
    assert lightarc.verify_bundle(tmp_path / "moon.lightarc").ok


@pytest.mark.parametrize(
    ("reader", "words"),
    [
        (replace(MESH, decode="read_mesh"), "package.module:function"),
        (replace(MESH, suffixes=(".PLY",)), "lower case"),
        (replace(MESH, suffixes=(".ply",)), "another reader of .ply"),
        (replace(IMAGE, signatures=()), "neither signatures"),
        (replace(BRDF, confined=False), "confined process"),
        (replace(BRDF, kind="sound"), "image, mesh or brdf"),  # type: ignore[arg-type]
    ],
)
def test_what_lacks_a_part_is_refused(reader: Reader, words: str) -> None:
    before = readers(reader.kind)
    with pytest.raises(ValueError, match=words):
        register(reader)
    assert before == readers(reader.kind)
