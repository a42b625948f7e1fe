"""A project replayed: its results made anew, and compared bit by bit with those that it has.

Stack, material and maps of the surface are made from the photographs; fits, factor runs and bakes
(`app.commands.replay`) from what the document says. Results that the project lacks, because its data are gone or
they were never made, are made and not compared. What cannot be made from photographs, because it came from elsewhere or
is a measurement of a machine, is named with this reason.

Fits, factor runs and bakes of a project made anew, and compared bit by bit with those that it has.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import engine
from app.arguments.results import software
from app.commands.brdf import fit, has_shader
from app.commands.brdf_figures import drawable
from app.commands.making import material_of, stack_of
from app.commands.surface import surface_of
from app.document.bake_request import Wanted, bake, choices_for, setting_for
from app.document.bake_request import estimate as estimate_bake
from app.document.comparison import Entry
from app.document.document import Project
from app.document.factoring import METHODS, Run
from app.document.scene import DEFAULT_MODEL
from app.document.variation import select_baked
from app.project.bakes import place_of as place_of_bake
from app.project.bakes import with_effects
from app.project.factors import place_of as place_of_factors
from app.project.made import Made, find_note, list_notes
from app.project.photographs import photographs
from app.project.pixels import are_there
from app.project.project_file import data_folder, read
from engine.brdf.brdf import model_name
from engine.brdf.readers.read import read_brdf_steps
from engine.bundle.bundle import save_bundle
from engine.capture.stack import ImageStack
from engine.core.errors import FileError, InputError, UsageError
from engine.core.params import parameters
from engine.core.steps import Step, Steps, part
from engine.factor.factor import factor
from engine.factor.factor_file import fingerprints, holds_factors, read_factors, write_factors
from engine.geometry.shapes import shape
from engine.scene.scene import brdfs_of_parts
from engine.storage.atomic import make_folder, write_bytes
from engine.storage.file_array import FileArray
from engine.surface.write import find_known_maps, write_surface
from engine.transport.baking.file import open_transport

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

NOT_FOUND_YET = "the run in the project has no result: it was stopped before it had one"
LOST = "its result is gone from the data folder"
SAME = "every value is the same"
OTHER_STATE = "it is of another state of the project, whose model, ground or BRDF was another one"
NOT_AT_END = "the search had not come to its end"
TARGET_GONE = "the BRDF that it was fitted to is compared no longer"
EDITED = "parameters were turned by hand, the fit was stopped before its end, or the machine differs"

Result = dict[str, Any]


def fits_again(entries: Sequence[Entry]) -> Steps[list[Result]]:
    """Fit each model among `entries` that is a fit again to its target, which is known by its name."""
    results: list[Result] = []
    for at, entry in enumerate(entries):
        if entry.fitted is None:
            continue
        target = next((each for each in entries if each.name == entry.fitted.of and each is not entry), None)
        if target is None:
            verdict = _replay_made_verdict(None, TARGET_GONE)
        else:
            steps = _fit_again(entry, target)
            verdict = yield from part(or_why_not(steps), at / len(entries), (at + 1) / len(entries))
        results.append({"name": f"fit {entry.name}", **verdict})
    return results


def _fit_again(entry: Entry, target: Entry) -> Steps[Result]:
    assert entry.fitted is not None
    found = yield from fit(target.brdf, model_name(entry.brdf), entry.fitted.weighting)
    before, now = ({p.name: getattr(brdf, p.name) for p in parameters(brdf)} for brdf in (entry.brdf, found.brdf))
    return _replay_made_compare(before, now, EDITED)


def factors_again(runs: Sequence[Run], kept: Path, folder: Path) -> Steps[list[Result]]:
    """Factor each of `runs` again into `folder`, and compare it with its result in the data folder `kept`."""
    results: list[Result] = []
    for at, run in enumerate(runs):
        assert run.choices is not None
        name = f"factors of {run.name}, {METHODS[run.choices.method]}"
        steps = _factor_again(run, kept, folder / f"factors-{at + 1}")
        verdict = yield from part(or_why_not(steps), at / len(runs), (at + 1) / len(runs))
        results.append({"name": name, **verdict})
    return results


def bakes_again(project: Project, made: Sequence[Made], kept: Path, folder: Path) -> Steps[list[Result]]:
    """Bake `made` again into `folder`, as far as they are of the model and the BRDF that the project has now."""
    results: list[Result] = []
    if not made:
        return results
    mesh = project.mesh or shape(DEFAULT_MODEL)
    brdf = project.material.reflectance
    if not has_shader(brdf):
        brdf = yield from part(drawable(brdf), 0.0, 0.1)
    for at, each in enumerate(made):
        name = f"bake {each.name.split('.')[0].removeprefix('bake-')}"
        try:
            values = {key: tuple(v) if isinstance(v, list) else v for key, v in each.made_with["settings"].items()}
            choices = choices_for(str(each.made_with["method"]), **values)
            varied = select_baked(choices.method, brdf, project.variations)
            parts = brdfs_of_parts(mesh, project.material)
            wanted = Wanted(mesh, project.look.ground, brdf, choices, variations=varied, parts=parts)
            wanted = with_effects(wanted, each.made_with["effects"])
        except (KeyError, TypeError, ValueError, AttributeError):
            results.append(_replay_made_verdict(None, "nobody noted how it was made") | {"name": name})
            continue
        name = f"bake {setting_for(choices)}"
        steps = _bake_again(wanted, each, kept, folder / f"bake-{at + 1}.transport")
        verdict = yield from part(or_why_not(steps), at / len(made), (at + 1) / len(made))
        results.append({"name": name, **verdict})
    return results


def or_why_not(steps: Steps[Result]) -> Steps[Result]:
    """The verdict of `steps`; where a user's file or wish keeps them from one, the reason."""
    try:
        return (yield from steps)
    except (FileError, UsageError) as error:
        return _replay_made_verdict(None, f"it cannot be made again: {error}")


def _factor_again(run: Run, kept: Path, target: Path) -> Steps[Result]:
    brdf = run.given
    if isinstance(brdf, Path):
        brdf = yield from part(read_brdf_steps(brdf), 0.0, 0.1)
    assert run.choices is not None
    write_factors(target, (yield from part(factor(brdf, run.choices, None), 0.1, 1.0)))
    place = place_of_factors(run, kept)
    if not holds_factors(place):
        return _replay_made_verdict(None, LOST if find_note(place) is not None else NOT_FOUND_YET)
    before, why = fingerprints(place), "settings are the same, versions or machine differ"
    return _replay_made_compare(before, fingerprints(target), NOT_AT_END if read_factors(place).searching else why)


def _bake_again(wanted: Wanted, made: Made, kept: Path, target: Path) -> Steps[Result]:
    if place_of_bake(wanted, kept).name != made.name:
        return _replay_made_verdict(None, OTHER_STATE)
    estimate = yield from part(estimate_bake(wanted), 0.0, 0.2)
    if estimate.why_not:
        raise UsageError(estimate.why_not)
    yield from part(bake(target, estimate), 0.2, 1.0)
    if not made.present:
        return _replay_made_verdict(None, LOST)
    before, now = open_transport(kept / made.name), open_transport(target)
    by, own = str(before.settings.get("software", "an unknown version")), f"lightarc {engine.__version__}"
    why = f"it was made by {by}, not {own}" if by != own else "settings are the same, the machine differs"
    return _replay_made_compare(_numbers(before.arrays), _numbers(now.arrays), why)


def _numbers(arrays: Mapping[str, Any]) -> dict[str, tuple[Any, ...]]:
    """Type, shape and bytes of arrays, which are equal where the arrays are bit by bit."""
    return {name: (array.dtype.str, array.shape, np.asarray(array).tobytes()) for name, array in arrays.items()}


def _replay_made_compare(before: Mapping[str, object], now: Mapping[str, object], why: str) -> Result:
    other = sorted(name for name in {*before, *now} if before.get(name) != now.get(name))
    return _replay_made_verdict(not other, f"{' and '.join(other[:3])} differ: {why}" if other else SAME)


def _replay_made_verdict(bit_equal: bool | None, reason: str) -> Result:
    return {"bit_equal": bit_equal, "reason": reason}


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


def _arrays(value: DataclassInstance | None) -> dict[str, Array]:
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
