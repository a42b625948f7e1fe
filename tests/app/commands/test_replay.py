"""A project made anew from its photographs: equal where nothing has changed, and a reason where something has."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import pytest

from app.commands.making import material_of, stack_of
from app.commands.replay import replayed
from app.document.document import ImportChoices, Project
from app.project.project_file import History, Writer
from engine.capture.lights.sources import find
from engine.core.errors import InputError
from engine.core.steps import drain
from tests.app.command import Command


def saved(path: Path, project: Project) -> Path:
    writer = Writer(path)
    writer.write(History(project))
    writer.close()
    return path


def test_a_replay_is_equal_until_the_settings_change(lightarc: Command, tmp_path: Path, photographs: Path) -> None:
    sources, choices = find([photographs]), ImportChoices(motion="none")
    stack = drain(stack_of(sources, choices, tmp_path / "stack"))
    project = Project(sources=sources, import_choices=choices, imported_with=choices, stack=stack)
    project = dataclasses.replace(project, material=drain(material_of(project)), built_from=project.recipe)
    path = saved(tmp_path / "a.lap", project)
    found = lightarc("project", "replay", path, "-o", tmp_path / "again", "--json")
    assert found.code == 0, found.err
    results = json.loads(found.out)["results"]
    assert [(each["name"], each["bit_equal"]) for each in results] == [
        ("stack", True),
        ("shading map", True),
        ("power law", True),
    ]
    assert (tmp_path / "again" / "material.lightarc").is_file()
    saved(path, dataclasses.replace(project, slices=project.slices + 1))
    stack_again, map_again, _ = drain(replayed(path, tmp_path / "other"))
    assert stack_again["bit_equal"]
    assert not map_again["bit_equal"]
    assert "settings were changed" in map_again["reason"]


def test_a_project_without_photographs_cannot_be_replayed(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not made from photographs"):
        drain(replayed(saved(tmp_path / "a.lap", Project()), tmp_path / "again"))
