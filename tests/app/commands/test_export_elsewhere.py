"""Exports of a project without its window: maps of the surface are made once and leave with all forms, errors kept."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import pytest

from app.commands import export_elsewhere, surface
from app.commands.export_bundle import export as export_bundle
from app.document.document import Project
from app.document.exporting import Exporting
from app.project import losses
from app.project.losses import find_kept, keep, keys_of
from engine.bundle.bundle import open_bundle
from engine.core.steps import Step, drain, relay
from engine.exchange import export
from engine.images.decode import read_image
from engine.surface.recover import Surface
from tests.engine.exchange.materials import dome_stack, woven_material


@pytest.fixture
def project() -> Project:
    """A cloth whose photographs under a dome tell its surface."""
    return Project(stack=dome_stack(24, 20), material=woven_material(24, 20))


def with_maps(project: Project) -> Project:
    made = drain(surface.surface_of(project))
    return dataclasses.replace(project, surface=made, surface_from=project.surface_recipe)


def partials(steps: Any) -> list[Any]:
    return [step.partial for step in steps if step.partial is not None]


def test_maps_that_exist_are_not_made_again(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = with_maps(project)
    assert whole.surface is not None
    monkeypatch.setattr(export_elsewhere, "surface_of", None)
    (leaving,) = partials(export_elsewhere.prepare_export(whole, None, export_elsewhere.Known()))
    assert leaving.subject.maps is whole.surface.maps
    assert leaving.subject.white == whole.surface.white


def test_maps_that_an_export_made_are_handed_on(project: Project) -> None:
    made, leaving = partials(export_elsewhere.prepare_export(project, None, export_elsewhere.Known()))
    assert isinstance(made, Surface)
    assert leaving.subject.maps is made.maps


def test_maps_of_other_photographs_are_not_taken(project: Project) -> None:
    whole = dataclasses.replace(with_maps(project), excluded=frozenset(["a"]))
    assert surface.material_with_surface(whole).surface is None
    assert surface.needs_surface(whole)


def test_a_bundle_holds_the_maps_of_the_surface(project: Project, tmp_path: Path) -> None:
    """Unless they are left out; alone they are a material of PBR maps."""
    whole = with_maps(project)
    assert whole.surface is not None
    both = drain(export_bundle(whole, tmp_path / "both.lightarc", None))
    assert both.problems == ()
    found = open_bundle(both.path)
    assert found.surface is not None
    assert found.surface.maps.size == (24, 20)
    assert found.power_law is not None
    without = drain(export_bundle(whole, tmp_path / "law.lightarc", None, frozenset(["power-law"])))
    assert open_bundle(without.path).surface is None
    alone = open_bundle(drain(export_bundle(whole, tmp_path / "maps.lightarc", None, frozenset(["pbr"]))).path)
    assert (alone.power_law, alone.surface) == (None, None)
    assert alone.pbr is not None


def test_kept_errors_are_found_by_what_they_depend_on(project: Project, tmp_path: Path) -> None:
    offer = export.Offer("gltf", {"rmse_rel": None, "flip": 0.25, "warnings": ["f0 is a mean"]}, None)
    keys = drain(keys_of(project, ("gltf", "textures")))
    keep(keys["gltf"], offer, tmp_path)
    assert find_kept(keys, [tmp_path])["gltf"].entry == offer.entry
    renamed = dataclasses.replace(project, material=dataclasses.replace(project.material, name="Felt"))
    assert drain(keys_of(renamed, ("gltf", "textures"))) == keys
    fine = dataclasses.replace(project, exporting=Exporting(coding="exr"))
    of_fine = drain(keys_of(fine, ("gltf", "textures")))
    assert {name for name in keys if of_fine[name] != keys[name]} == {"textures"}
    fewer = dataclasses.replace(project, excluded=frozenset(["a"]))
    assert not set(drain(keys_of(fewer, ("gltf", "textures"))).values()) & set(keys.values())


@pytest.mark.parametrize(
    "damage",
    [
        {"lightarc_loss": 0},
        {"entry": {"flip": -1.0}},
        {"entry": {"flip": "much"}},
        {"ball": "AAAA", "size": [1 << 20, 1 << 20]},
        {"ball": "AAAA", "size": [2, 2]},
        {"ball": 3, "size": None},
    ],
)
def test_damaged_errors_are_none(damage: dict[str, Any], tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    keep("loss-1.json", export.Offer("gltf", {"flip": 0.25}, None), tmp_path)
    path = tmp_path / "loss-1.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **damage}))
    assert find_kept({"gltf": "loss-1.json"}, [tmp_path]) == {}
    assert "is damaged" in caplog.text


def test_an_export_states_errors_that_were_measured_before(
    project: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = drain(export_elsewhere.send(project, None, export_elsewhere.Known(), ["gltf"], tmp_path / "1", tmp_path))
    monkeypatch.setattr(export, "references", None)  # nothing is compared any more
    whole = with_maps(project)
    again = drain(export_elsewhere.send(whole, None, export_elsewhere.Known(), ["gltf"], tmp_path / "2", tmp_path))
    names = (*export.ERRORS, "bytes", "warnings")
    (one,), (other,) = first.record["targets"], again.record["targets"]
    assert {name: one[name] for name in names} == {name: other[name] for name in names}
    assert losses.OWN not in [entry["target"] for entry in again.record["targets"]]


def test_a_larger_tile_is_written_and_its_errors_are_not_kept(project: Project, tmp_path: Path) -> None:
    """They belong to the tile, and the cards of the window show those of the sample."""
    larger = dataclasses.replace(project, exporting=Exporting(repeats=2, width_mm=30.0))
    seen: list[Any] = []

    def watch(step: Step) -> Step:
        seen.append(step.partial)
        return step

    steps = export_elsewhere.send(
        larger, None, export_elsewhere.Known(), ["textures"], tmp_path / "1", tmp_path / "kept"
    )
    done = drain(relay(steps, watch))
    image = next(done.folder / name for name in done.files if name.endswith(".png"))
    assert read_image(image).pixels.shape[:2] == (48, 40)
    assert not any(hasattr(each, "target") for each in seen)
    assert not list((tmp_path / "kept").glob("*"))
