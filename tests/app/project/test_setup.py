"""A project as input of the command line: the scene that a user set up is what is drawn, baked and planned."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.document.bake_request import choices_for, estimate, make_request
from app.document.document import Look, Project
from app.document.open_document import Document
from app.project.bakes import bake_and_keep
from app.project.project_file import History, Writer, data_folder
from app.project.report import identity
from app.project.setup import set_up
from engine.brdf.brdf import brdf_from_text
from engine.bundle.bundle import open_bundle
from engine.bundle.manifest import describe_bundle
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.geometry.camera import Camera, frame
from engine.geometry.shapes import shape
from engine.images.decode import read_image
from engine.light.lamps import LampSettings
from engine.light.sky import make_built_in
from engine.scene.material import Material, material_of_maps
from engine.surface.pbr_maps import PbrMaps
from engine.transport.baking.file import open_transport
from tests.app.command import Command
from tests.engine.scenes import weave

CAMERA = Camera((0.0, 0.5, 4.0), (0.0, 0.0, 0.0), fov_deg=30.0)
BRDF = "ggx:alpha=0.3"
LOOK = Look(mode="direct", light_theta_deg=40.0, light_phi_deg=10.0, irradiance=2.0, exposure_ev=1.0, has_ground=True)
SMALL = ("--width", "48", "--height", "36", "--renderer", "cpu", "--samples", "1")


def save(path: Path, **parts: Any) -> Path:
    """A project file with these parts."""
    writer = Writer(path)
    writer.write(History(Project(**parts)))
    writer.close()
    return path


@pytest.fixture
def project(tmp_path: Path) -> Path:
    material = Material(None, None, brdf=BRDF)
    return save(tmp_path / "a.lap", mesh=shape("sphere"), material=material, look=LOOK, camera=CAMERA)


def test_the_scene_is_the_one_that_was_set_up(tmp_path: Path) -> None:
    lamps = (LampSettings(),)
    look = Look(gain=3.0, rotation_deg=90.0, lamps=lamps, repeats=5.0, source="power-law", lookup="angle", directions=8)
    sky, material = make_built_in("overcast"), weave(16)
    path = save(tmp_path / "a.lap", mesh=shape("sphere"), environment=sky, material=material, look=look, camera=CAMERA)
    found = set_up(path)
    scene = found.scene
    assert (scene.camera, scene.irradiance, scene.repeats, scene.directions) == (CAMERA, 3.0, 5.0, 8)
    assert (scene.source, scene.lookup, scene.lamps) == ("power-law", "angle", (lamps[0].lamp,))
    assert scene.environment_rotation == pytest.approx(np.pi / 2)
    assert scene.environment is not None
    assert np.array_equal(scene.environment.radiance, sky.radiance)
    assert scene.material is not None
    assert found.mode == "shading-map"
    assert np.array_equal(scene.mesh.positions, shape("sphere").positions)


def test_pbr_maps_are_kept_and_drawn(tmp_path: Path) -> None:
    random = np.random.default_rng(0)
    maps = PbrMaps(
        base_colour=random.random((4, 4, 3)).astype(np.float32),
        normal=np.broadcast_to(np.array([0, 0, 1], np.float32), (4, 4, 3)).copy(),
        roughness=random.random((4, 4)).astype(np.float32),
        metallic=np.zeros((4, 4), np.float32),
        f0=np.full((4, 4), 0.04, np.float32),
    )
    found = set_up(save(tmp_path / "a.lap", mesh=shape("sphere"), material=material_of_maps(maps, "rock")))
    assert found.mode == "shading-map"
    assert found.scene.pbr is not None
    assert np.array_equal(found.scene.pbr.base_colour, maps.base_colour)


def test_a_model_that_nobody_moved_is_framed_for_the_image(tmp_path: Path) -> None:
    path = save(tmp_path / "a.lap")
    scene = set_up(path, 2.0).scene
    assert scene.mesh.name == "cloth"
    assert scene.camera == frame(scene.mesh.positions, 2.0)


def test_data_that_are_gone_are_named_in_place_of_another_scene(tmp_path: Path) -> None:
    path = save(tmp_path / "a.lap", mesh=shape("sphere"), environment=make_built_in("overcast"), material=weave(16))
    shutil.rmtree(data_folder(path))
    with pytest.raises(InputError, match="model and light and shading map and power law"):
        set_up(path)


def test_a_image_of_a_project_is_the_image_of_its_scene(lightarc: Command, project: Path, tmp_path: Path) -> None:
    one, other = tmp_path / "one.exr", tmp_path / "other.exr"
    found = lightarc("render", project, "-o", one, *SMALL, "--json")
    assert found.code == 0, found.err
    camera = "eye=0,0.5,4 target=0,0,0 fov_deg=30"
    options = ("--brdf", BRDF, "--light-deg", "40,10", "--intensity", "2", "--camera", camera, "--ground")
    drawn = ("--mode", "direct", *SMALL)
    assert lightarc("render", "sphere", "-o", other, *options, *drawn).code == 0
    assert np.array_equal(read_image(one).pixels, read_image(other).pixels)
    lit = tmp_path / "lit.exr"
    assert lightarc("render", project, "-o", lit, "--intensity", "4", *SMALL).code == 0
    assert np.allclose(read_image(lit).pixels, 2.0 * read_image(one).pixels, rtol=2e-3)


def test_options_that_contradict_a_project_are_refused(lightarc: Command, project: Path, tmp_path: Path) -> None:
    found = lightarc("render", project, "-o", tmp_path / "a.png", "--brdf", "phong")
    assert found.code == 2
    assert "--brdf is part of the project" in found.err
    for verb, output in (("plan", ()), ("tradeoff", ("-o", tmp_path / "sweep"))):
        assert "the project has none" in lightarc(verb, project, *output).err
        assert "needs either --brdf or --material" in lightarc(verb, "sphere", *output).err
    assert "a model needs --brdf" in lightarc("bake", "sphere", "-o", tmp_path / "a.transport").err


def test_a_bake_of_a_project_is_of_its_model_ground_and_mode(lightarc: Command, tmp_path: Path) -> None:
    """So are its settings, as the user chose them there; an option of the command stands before both."""
    look = Look(mode="sh", has_ground=True, ground_albedo=0.25)
    material, chosen = Material(None, None, brdf="lambert"), {"sh": {"order": 3}, "wavelet": {"terms": 2}}
    path = save(tmp_path / "a.lap", mesh=shape("plane"), look=look, material=material, bakes=chosen)
    for given, order in (((), 3), (("--order", "4"), 4)):
        target = tmp_path / f"{order}.transport"
        found = lightarc("bake", path, "-o", target, *given, "--ground-cells", "4", "--json")
        assert found.code == 0, found.err
        result = json.loads(found.out)
        assert result["vertices"] == 2 * len(shape("plane").positions) + 25  # of its back as well
        assert (result["knobs"]["mode"], result["knobs"]["order"]) == ("sh", order)
        assert open_transport(target).kind == "sh"


def test_a_image_is_drawn_from_the_bake_of_the_window_with_its_settings(lightarc: Command, tmp_path: Path) -> None:
    """A project whose bake lies beside it is not baked again; one without is baked as the user chose."""
    parts: dict[str, Any] = {"mesh": shape("plane"), "material": Material(None, None, brdf="lambert"), "camera": CAMERA}
    path = save(tmp_path / "a.lap", look=Look(mode="sh"), bakes={"sh": {"order": 3}}, **parts)
    images = []
    for name in ("anew", "kept"):
        found = lightarc("render", path, *SMALL, "-o", tmp_path / f"{name}.exr", "--json")
        assert found.code == 0, found.err
        assert json.loads(found.out)["baked_before"] == (name == "kept")
        images.append(read_image(tmp_path / f"{name}.exr").pixels)
        choices = choices_for("sh", order=3)
        wanted = make_request(shape("plane"), None, brdf_from_text("lambert"), choices, None)
        drain(bake_and_keep(drain(estimate(wanted)), data_folder(path)))
    assert np.array_equal(images[0], images[1])


def test_the_camera_is_kept_beside_the_steps_and_undo_leaves_it() -> None:
    document = Document()
    document.change("Model", mesh=shape("sphere"))
    document.change("Gain", look=Look(gain=2.0))
    document.look_from(CAMERA)
    assert document.undo_stack.count() == 2
    document.undo_stack.undo()
    assert (document.project.look.gain, document.project.camera) == (1.0, CAMERA)
    document.undo_stack.undo()
    assert (document.project.mesh, document.project.camera) == (None, None)


def test_a_bundle_is_made_of_a_project_and_names_it(lightarc: Command, tmp_path: Path) -> None:
    """The material is the project's, and the record leads back to the state of the project that it was made of."""
    photographs = [{"file": "felt_10deg.png", "motion": [1.0, 0.0, 0.5]}]
    provenance = {"camera": "one", "photographs": photographs, "settings": {"motion": "auto"}}
    path = save(tmp_path / "felt.lap", mesh=shape("sphere"), material=weave(16), provenance=provenance)
    done = lightarc("bundle", "make", str(path), "-o", str(tmp_path / "felt.lightarc"), "--json")
    assert done.code == 0
    assert json.loads(done.out)["ok"]
    made = open_bundle(tmp_path / "felt.lightarc")
    assert made.shading_map is not None
    of = weave(16).shading_map
    assert of is not None
    assert np.array_equal(made.shading_map.slices, of.slices)
    record = describe_bundle(tmp_path / "felt.lightarc")["provenance"]
    assert {name: record[name] for name in provenance} == provenance
    assert record["project"] == identity(path)
    save(path, mesh=shape("sphere"), material=weave(16), provenance={"camera": "another"})
    assert identity(path)["state"] != record["project"]["state"]


def test_what_cannot_become_a_bundle_is_said(lightarc: Command, project: Path, tmp_path: Path) -> None:
    done = lightarc("bundle", "make", str(project), "-o", str(tmp_path / "b.lightarc"))
    assert done.code == 3
    assert "has no material yet" in done.err
    assert lightarc("bundle", "make", str(project)).code == 2
    assert lightarc("bundle", "verify", str(project), "-o", str(tmp_path / "b.lightarc")).code == 2
    assert not (tmp_path / "b.lightarc").exists()
