"""A project made anew from its photographs: equal where nothing has changed, and a reason where something has."""

from __future__ import annotations

import dataclasses
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands.making import material_of, stack_of
from app.commands.replay import NO_PHOTOGRAPHS, replay
from app.commands.surface import surface_of
from app.document.document import ImportChoices, Project
from app.document.measured import Accuracy
from app.project.project_file import History, Writer
from engine.capture.lights.sources import find
from engine.capture.stack import ImageStack
from engine.core.errors import InputError
from engine.core.steps import drain
from tests.app.command import Command


def save(path: Path, project: Project) -> Path:
    writer = Writer(path)
    writer.write(History(project))
    writer.close()
    return path


def test_a_replay_is_equal_until_the_settings_change(lightarc: Command, tmp_path: Path, photographs: Path) -> None:
    sources, choices = find([photographs]), ImportChoices(motion="none")
    stack = drain(stack_of(sources, choices, tmp_path / "stack"))
    project = Project(sources=sources, import_choices=choices, imported_with=choices, stack=stack)
    project = dataclasses.replace(project, material=drain(material_of(project)), built_from=project.recipe)
    path = save(tmp_path / "a.lap", project)
    found = lightarc("project", "replay", path, "-o", tmp_path / "again", "--json")
    assert found.code == 0, found.err
    results = json.loads(found.out)["results"]
    assert [(each["name"], each["bit_equal"]) for each in results] == [
        ("stack", True),
        ("shading map", True),
        ("power law", True),
    ]
    assert (tmp_path / "again" / "material.lightarc").is_file()
    with (tmp_path / "stack" / "codes.npy").open("r+b") as file:
        file.seek(-3, os.SEEK_END)
        file.write(b"\0\1\0")
    save(path, dataclasses.replace(project, slices=project.slices + 1))
    stack_again, map_again, _ = drain(replay(path, tmp_path / "other"))
    assert (stack_again["bit_equal"], stack_again["reason"][:17]) == (False, "radiance differ: ")
    assert not map_again["bit_equal"]
    assert "settings were changed" in map_again["reason"]


def test_maps_of_the_surface_are_made_of_the_photographs_that_they_were_made_of(
    tmp_path: Path, photographs: Path
) -> None:
    """Bit-equal while those are the same; of lamps that tell no slope, the reason why not."""
    stack = drain(stack_of(find([photographs]), ImportChoices(motion="none"), tmp_path / "stack"))
    numbers: dict[str, Any] = {name: np.array(getattr(stack, name)) for name in ("radiance", "saturated")}
    stack = dataclasses.replace(stack, **numbers, azimuth=np.zeros(5), folder=None)
    out = Project(stack=stack, excluded=frozenset(stack.sources[:1]))
    project = Project(stack=stack, surface=drain(surface_of(out)), surface_from=out.surface_recipe)

    def surface_in(name: str, surface_from: tuple[ImageStack, frozenset[str]]) -> dict[str, Any]:
        path = save(tmp_path / f"{name}.lap", dataclasses.replace(project, surface_from=surface_from))
        found: dict[str, Any] = drain(replay(path, tmp_path / name))[-1]
        assert found["name"] == "surface maps"
        return found

    assert surface_in("same", (stack, out.excluded))["bit_equal"]
    assert (tmp_path / "same" / "surface" / "surface.json").is_file()
    others = surface_in("others", (stack, frozenset()))
    assert (others["bit_equal"], others["reason"][:16]) == (False, "base_colour and ")
    none = surface_in("none", (stack, frozenset(stack.sources[2:])))
    assert (none["bit_equal"], "do not separate a slope" in none["reason"]) == (None, True)


def test_what_no_photographs_lead_to_is_named_with_the_reason(tmp_path: Path, photographs: Path) -> None:
    """A stack that was imported elsewhere is taken as it is; measured times are never called the same."""
    stack = drain(stack_of(find([photographs]), ImportChoices(motion="none"), tmp_path / "stack"))
    project = Project(stack=stack, accuracy=Accuracy((), (), (8, 8), 1, "none"))
    project = dataclasses.replace(project, material=drain(material_of(project)), built_from=project.recipe)
    results = drain(replay(save(tmp_path / "a.lap", project), tmp_path / "again"))
    assert [(each["name"], each["bit_equal"]) for each in results] == [
        ("stack", None),
        ("shading map", True),
        ("power law", True),
        ("measured accuracy", None),
    ]
    assert results[0]["reason"] == NO_PHOTOGRAPHS


def test_a_project_without_photographs_cannot_be_replayed(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not made from photographs"):
        drain(replay(save(tmp_path / "a.lap", Project()), tmp_path / "again"))
