"""The view of a bundle comes back as it was; what it refers to is opened only where it is the same."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands.bundle_view import Referred, find_referred, view_of, with_view
from app.document.document import Look, Project
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh, read_mesh
from engine.geometry.shapes import flat_image
from engine.light.environment_file import open_environment
from engine.light.lamps import LampSettings
from engine.light.near_lamps import NearLampSettings

LOOK = Look(
    light_theta_deg=12.0,
    gain=3.0,
    has_ground=True,
    mode="reference",
    comparing="wipe",
    bounces=2,
    lamps=(LampSettings(theta_deg=20.0, colour=(1.0, 0.5, 0.25)),),
    near_lamps=(NearLampSettings(x=1.0, power=3.0, colour=(1.0, 0.5, 0.25), shape="disc", facing_theta_deg=120.0),),
)
CAMERA = Camera((3.0, 2.0, 1.0), (0.25, 0.25, 0.25), fov_deg=20.0)


def keep(project: Project, bundle: Path) -> dict[str, Any]:
    """The provenance as a manifest keeps it."""
    text = json.dumps({"view": view_of(project, bundle)})
    assert str(bundle.parent) not in text, "it tells nobody where this user keeps files"
    found: dict[str, Any] = json.loads(text)
    return found


def find_by(provenance: dict[str, Any], bundle: Path) -> Referred:
    return drain(find_referred(provenance, bundle, (30, 40)))


def test_a_flat_image_comes_back_with_the_proportions_of_the_material(tmp_path: Path) -> None:
    bundle = tmp_path / "ring.lightarc"
    found = find_by(keep(Project(mesh=flat_image(40, 30)), bundle), bundle)
    assert found.missing == ()
    assert np.ptp(found.parts["mesh"].positions, axis=0).tolist() == [2.0, 1.5, 0.0]
    assert found.parts["camera"] is None


@pytest.fixture
def shown(mesh: Path) -> Project:
    """A scene with a model from a file."""
    model = read_mesh(mesh)
    files = {model.name: mesh}
    return Project(mesh=model, environment=open_environment("overcast"), look=LOOK, camera=CAMERA, came_from=files)


def test_everything_that_is_seen_comes_back(shown: Project, mesh: Path, tmp_path: Path) -> None:
    bundle = tmp_path / "out" / "felt.lightarc"
    provenance = keep(shown, bundle)
    assert with_view(Look(), provenance) == LOOK
    found = find_by(provenance, bundle)
    assert found.missing == ()
    assert (found.parts["camera"], found.parts["came_from"]) == (CAMERA, {"tetrahedron": mesh})
    assert found.parts["environment"].name == "overcast"
    assert found.parts["mesh"].positions.tolist() == shown.mesh.positions.tolist()  # type: ignore[union-attr]


def test_a_flipped_model_comes_back_flipped_and_a_new_project_as_one(shown: Project, tmp_path: Path) -> None:
    assert isinstance(shown.mesh, Mesh)
    turned = dataclasses.replace(shown, mesh=shown.mesh.flipped(), environment=None)
    found = find_by(keep(turned, tmp_path / "a"), tmp_path / "a")
    assert found.parts["mesh"].normals.tolist() == turned.mesh.normals.tolist()  # type: ignore[union-attr]
    assert found.parts["environment"] is None
    found = find_by(keep(Project(), tmp_path / "a"), tmp_path / "a")
    assert (found.parts["mesh"], found.parts["camera"], found.missing) == (None, None, ())


def test_a_model_that_is_another_by_now_is_named_and_one_beside_the_bundle_is_opened(
    shown: Project, mesh: Path, tmp_path: Path
) -> None:
    bundle = tmp_path / "felt.lightarc"
    provenance, content = keep(shown, bundle), mesh.read_text()
    mesh.write_text(content.replace("v 1 0 0", "v 2 0 0"))
    found = find_by(provenance, bundle)
    assert "mesh" not in found.parts
    assert "camera" not in found.parts
    assert found.missing == ("The model tetrahedron is not where it was; the material is shown on another",)
    folder = tmp_path / "elsewhere"
    folder.mkdir()
    (folder / mesh.name).write_text(content)
    assert find_by(provenance, folder / "felt.lightarc").parts["mesh"] is not None


@pytest.mark.parametrize(
    "model",
    [
        *(None, 3, [], {}, {"name": 3}, {"name": "nobody"}, {"name": "a", "file": 3, "hash": ""}),
        *({"name": "a", "file": "//server/a.obj", "hash": ""}, {"name": "a", "file": "\\\\server\\a.obj", "hash": ""}),
        *({"name": "a", "file": "\0.obj", "hash": ""}, {"name": "a", "file": "/etc/passwd", "bytes": 1, "hash": ""}),
        *({"name": "a", "file": "/dev/zero", "bytes": 0, "hash": ""}, {"name": "a", "file": "x" * 9999 + ".obj"}),
    ],
)
def test_a_reference_that_leads_nowhere_opens_nothing(model: Any, tmp_path: Path) -> None:
    view = {"model": model, "environment": model, "camera": {"eye": [0, 0, float("nan")], "target": 3}}
    found = find_by({"view": view}, tmp_path / "a")
    assert not {"mesh", "camera"} & set(found.parts)
    assert found.parts.get("environment") is None


def test_lights_of_a_bundle_that_knew_spheres_alone_are_spheres() -> None:
    said = {"x": 1.0, "y": 2.0, "z": 0.0, "radius": 0.5, "power": 3.0, "colour": [1.0, 0.5, 0.25]}
    found = with_view(Look(), {"view": {"near_lamps": [said]}}).near_lamps
    assert found == (NearLampSettings("sphere", 1.0, 2.0, 0.0, 0.5, power=3.0, colour=(1.0, 0.5, 0.25)),)


@pytest.mark.parametrize(
    "view",
    [
        *(None, 3.0, [], {}, {"gain": "3"}, {"gain": True}, {"gain": float("nan")}, {"gain": 1e9}, {"exposure_ev": {}}),
        *({"tone_map": "nonsense"}, {"tone_map": []}, {"has_ground": 1}, {"has_ground": None}, {"mode": "nonsense"}),
        *(
            {"mode": []},
            {"lamps": [{}]},
            {"lamps": [3]},
            {"near_lamps": [{"x": 1.0}]},
            {"bounces": True},
            {"bounces": 99},
            {"directions": 0},
        ),
    ],
)
def test_a_view_that_cannot_be_changes_nothing(view: Any) -> None:
    assert with_view(Look(gain=2.0), {"view": view}) == Look(gain=2.0)
