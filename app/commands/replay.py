"""A project replayed: its results made anew, and compared bit by bit with those that it has.

Stack, material and maps of the surface are made from the photographs; fits, factor runs and bakes
(`app.commands.replay_made`) from what the document says. Results that the project lacks, because its data are gone or
they were never made, are made and not compared. What cannot be made from photographs, because it came from elsewhere or
is a measurement of a machine, is named with this reason.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import engine
from app.arguments.results import software
from app.commands.making import material_of, stack_of
from app.commands.replay_made import SAME, bakes_again, factors_again, fits_again, or_why_not
from app.commands.surface import surface_of
from app.document.document import Project
from app.project.made import list_notes
from app.project.photographs import photographs
from app.project.pixels import are_there
from app.project.project_file import data_folder, read
from engine.bundle.bundle import save_bundle
from engine.capture.stack import ImageStack
from engine.core.errors import InputError
from engine.core.steps import Step, Steps, part
from engine.storage.atomic import make_folder, write_bytes
from engine.storage.file_array import FileArray
from engine.surface.write import find_known_maps, write_surface

Array = NDArray[Any] | FileArray

#: Names of the forms of a material.
NAMES = {"shading_map": "shading map", "power_law": "power law", "directional": "directional map"}

NOTHING = "the project has no such result to compare with"
NO_PHOTOGRAPHS = "it came from a file and was not made of photographs here"
MEASURED = "times and errors are those of one machine at one time, and can only be measured again"
REIMPORTED = "the photographs were imported again after they were made"
REBUILT = "the settings were changed after it was built"


def replay(path: Path, folder: Path) -> Steps[list[dict[str, Any]]]:
    """Make all results of the project at `path` anew in `folder`: `name`, `bit_equal` and `reason` of each.

    Raises InputError where nothing in the project can be made anew, or where some of its photographs are gone.
    """
    opened = read(path)
    project, has_maps = opened.current, opened.current.surface is not None or "surface" in opened.missing
    gone = [file for file in photographs(project) if not file.is_file()]
    made = [each for each in list_notes(path) if each.kind == "bake"]
    runs = [run for run in project.factoring.runs if run.choices is not None]
    fits = [entry for entry in project.comparison.entries if entry.fitted is not None]
    has_stack = project.sources is not None or project.stack is not None
    if not (has_stack or made or runs or fits):
        raise InputError(
            path, "was not made from photographs and has no runs, fits or bakes to repeat", "Choose another project"
        )
    if gone:
        raise InputError(gone[0], f"is missing ({len(gone)} of the photographs)", "Put the photographs back")
    make_folder(folder)
    results = []
    if has_stack:
        results += yield from part(_from_photographs(project, has_maps, folder), 0.0, 0.6)
    elif project.has_map:
        results.append(_verdict("material", None, NO_PHOTOGRAPHS))
    results += yield from part(fits_again(project.comparison.entries), 0.6, 0.7)
    results += yield from part(factors_again(runs, data_folder(path), folder), 0.7, 0.8)
    results += yield from part(bakes_again(project, made, data_folder(path), folder), 0.8, 1.0)
    if project.accuracy is not None:
        results.append(_verdict("measured accuracy", None, MEASURED))
    write_bytes(folder / "replay.json", json.dumps(results, indent=2).encode())
    yield Step(1.0, "compared")
    return results


def _from_photographs(project: Project, has_maps: bool, folder: Path) -> Steps[list[dict[str, Any]]]:
    """Stack, material, and where the project `has_maps`, those of the surface.

    A stack that was imported elsewhere is taken as it is.
    """
    if project.sources is not None:
        choices = project.imported_with or project.import_choices
        stack = yield from part(stack_of(project.sources, choices, folder / "stack"), 0.0, 0.5)
        before = _arrays(project.stack) if project.stack is not None and are_there(project.stack) else {}
        results = [_compare("stack", before, _arrays(stack), _why(project))]
    else:
        assert project.stack is not None
        stack, results = project.stack, [_verdict("stack", None, NO_PHOTOGRAPHS)]
    material = yield from part(material_of(dataclasses.replace(project, stack=stack)), 0.5, 0.7)
    material = dataclasses.replace(material, brdf=project.material.brdf, measured=project.material.measured)
    yield from part(save_bundle(folder / "material.lightarc", material), 0.7, 0.75)
    why = _why(project, REBUILT if project.built_from and project.recipe != project.built_from else "")
    for name in ("shading_map", "power_law", "directional"):
        before, now = getattr(project.material, name), getattr(material, name)
        if before is not None or now is not None:
            results.append(_compare(NAMES[name], _arrays(before), _arrays(now), why))
    if has_maps:
        steps = or_why_not(_surface_again(project, stack, folder))
        results.append({"name": "surface maps", **(yield from part(steps, 0.75, 1.0))})
    return results


def _surface_again(project: Project, stack: ImageStack, folder: Path) -> Steps[dict[str, Any]]:
    """The maps of the surface, of those photographs that they were made of, beside the maps of the project."""
    of, excluded, *white = project.surface_from or (None, project.excluded)
    again = dataclasses.replace(project, stack=stack, excluded=excluded, white=white[0] if white else None)
    surface = yield from part(surface_of(again), 0.0, 0.8)
    provenance = {**stack.provenance, "excluded_photographs": sorted(excluded)}
    yield from part(write_surface(folder / "surface", surface, provenance, software("normals")), 0.8, 1.0)
    before = find_known_maps(project.surface.maps) if project.surface is not None else {}
    why = _why(project, REIMPORTED if of is not project.stack else "")
    return _compare("surface maps", before, find_known_maps(surface.maps), why)


def _arrays(value: Any) -> dict[str, Array]:
    """The arrays of a result by their names, those in files not read; none where there is no result."""
    parts = {each.name: getattr(value, each.name) for each in dataclasses.fields(value)} if value is not None else {}
    return {name: found for name, found in parts.items() if isinstance(found, np.ndarray | FileArray)}


def _why(project: Project, known: str = "") -> str:
    """The reason for a difference that is `known`, or the most likely one."""
    if known:
        return known
    made_by = str((project.stack.provenance if project.stack is not None else {}).get("software", "an unknown version"))
    now = f"lightarc {engine.__version__}"
    return f"it was made by {made_by}, not {now}" if made_by != now else "photographs, settings or machine differ"


def _compare(name: str, before: Mapping[str, Array], now: Mapping[str, Array], why: str) -> dict[str, Any]:
    """The verdict on one result."""
    if not before:
        return _verdict(name, None, NOTHING)
    both = before.keys() & now.keys()
    other = sorted(
        each for each in before.keys() | now.keys() if each not in both or not _same(before[each], now[each])
    )
    return _verdict(name, not other, f"{' and '.join(other)} differ: {why}" if other else SAME)


def _verdict(name: str, bit_equal: bool | None, reason: str) -> dict[str, Any]:
    return {"name": name, "bit_equal": bit_equal, "reason": reason}


def _same(one: Array, other: Array) -> bool:
    """True for equal bytes; a photograph at a time, since a stack may be larger than memory."""
    if (one.dtype, one.shape) != (other.dtype, other.shape):
        return False
    return all(np.asarray(a).tobytes() == np.asarray(b).tobytes() for a, b in zip(one, other, strict=True))
