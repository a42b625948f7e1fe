"""A project replayed: its results made anew, and compared bit by bit with those that it has.

Stack and material are made from the photographs, factor runs and bakes (`app.commands.replay_made`) from what the
document says. Results that the project lacks, because its data are gone or they were never made, are made and not
compared.
"""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import engine
from app.commands.making import material_of, stack_of
from app.commands.replay_made import bakes_again, factors_again
from app.document.document import Project
from app.project.made import noted
from app.project.photographs import photographs
from app.project.project_file import data_folder, read
from engine.core.errors import InputError
from engine.core.steps import Step, Steps, part
from engine.storage.atomic import make_folder, write_bytes

Arrays = dict[str, NDArray[Any]]

NOTHING = "the project has no such result to compare with"


def replayed(path: Path, folder: Path) -> Steps[list[dict[str, Any]]]:
    """Make all results of the project at `path` anew in `folder`: `name`, `bit_equal` and `reason` of each.

    Raises InputError where nothing in the project can be made anew, or where some of its photographs are gone.
    """
    project = read(path).current
    gone = [file for file in photographs(project) if not file.is_file()]
    made = [each for each in noted(path) if each.kind == "bake"]
    runs = [run for run in project.factoring.runs if run.choices is not None]
    if project.sources is None and not made and not runs:
        raise InputError(
            path, "was not made from photographs and has no runs or bakes to repeat", "Choose another project"
        )
    if gone:
        raise InputError(gone[0], f"is missing ({len(gone)} of the photographs)", "Put the photographs back")
    make_folder(folder)
    results = (yield from part(_from_photographs(project, folder), 0.0, 0.6)) if project.sources is not None else []
    results += yield from part(factors_again(runs, data_folder(path), folder), 0.6, 0.8)
    results += yield from part(bakes_again(project, made, data_folder(path), folder), 0.8, 1.0)
    write_bytes(folder / "replay.json", json.dumps(results, indent=2).encode())
    yield Step(1.0, "compared")
    return results


def _from_photographs(project: Project, folder: Path) -> Steps[list[dict[str, Any]]]:
    """Stack and material."""
    from engine.bundle.bundle import save_bundle

    assert project.sources is not None
    choices = project.imported_with or project.import_choices
    stack = yield from part(stack_of(project.sources, choices, folder / "stack"), 0.0, 0.6)
    material = yield from part(material_of(dataclasses.replace(project, stack=stack)), 0.6, 0.9)
    material = dataclasses.replace(material, brdf=project.material.brdf, measured=project.material.measured)
    yield from part(save_bundle(folder / "material.lightarc", material), 0.9, 1.0)
    before, now = project.material, material
    forms: list[tuple[str, Any, Any]] = [
        ("shading map", before.shading_map, now.shading_map),
        ("power law", before.power_law, now.power_law),
    ]
    if before.directional is not None or now.directional is not None:
        forms.append(("directional map", before.directional, now.directional))
    return [
        _compared("stack", _arrays(project.stack), _arrays(stack), _why(project, of_material=False)),
        *(_compared(name, _arrays(one), _arrays(other), _why(project)) for name, one, other in forms),
    ]


def _arrays(value: Any) -> Arrays:
    """The arrays of a result by their names; none where there is no result."""
    names = [each.name for each in dataclasses.fields(value)] if value is not None else []
    return {name: np.asarray(found) for name in names if isinstance(found := getattr(value, name), np.ndarray)}


def _why(project: Project, *, of_material: bool = True) -> str:
    """The most likely reason for a difference."""
    if of_material and project.recipe != project.built_from:
        return "the settings were changed after it was built"
    made_by = str((project.stack.provenance if project.stack is not None else {}).get("software", "an unknown version"))
    now = f"lightarc {engine.__version__}"
    return f"it was made by {made_by}, not {now}" if made_by != now else "photographs, settings or machine differ"


def _compared(name: str, before: Arrays, now: Arrays, why: str) -> dict[str, Any]:
    """The verdict on one result."""
    if not before:
        return {"name": name, "bit_equal": None, "reason": NOTHING}
    other = [each for each in before if each not in now or not _same(before[each], now[each])]
    reason = f"{' and '.join(other)} differ: {why}" if other else "every value is the same"
    return {"name": name, "bit_equal": not other, "reason": reason}


def _same(one: NDArray[Any], other: NDArray[Any]) -> bool:
    """True for equal bytes; a photograph at a time, since a stack may be larger than memory."""
    if (one.dtype, one.shape) != (other.dtype, other.shape):
        return False
    return all(a.tobytes() == b.tobytes() for a, b in zip(np.atleast_1d(one), np.atleast_1d(other), strict=True))
