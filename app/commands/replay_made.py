"""Fits, factor runs and bakes of a project made anew, and compared bit by bit with those that it has."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import engine
from app.commands.brdf import fit, has_shader
from app.commands.brdf_figures import drawable
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
from app.project.made import Made, find_note
from engine.brdf.brdf import model_name
from engine.brdf.readers.read import read_brdf_steps
from engine.core.errors import FileError, UsageError
from engine.core.steps import Steps, part
from engine.factor.factor_file import fingerprints, holds_factors, read_factors, write_factors
from engine.geometry.shapes import shape
from engine.transport.baking.file import open_transport

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
            verdict = _verdict(None, TARGET_GONE)
        else:
            steps = _fit_again(entry, target)
            verdict = yield from part(or_why_not(steps), at / len(entries), (at + 1) / len(entries))
        results.append({"name": f"fit {entry.name}", **verdict})
    return results


def _fit_again(entry: Entry, target: Entry) -> Steps[Result]:
    assert entry.fitted is not None
    found = yield from fit(target.brdf, model_name(entry.brdf), entry.fitted.weighting)
    return _compare(dataclasses.asdict(entry.brdf), dataclasses.asdict(found.brdf), EDITED)


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
            wanted = Wanted(mesh, project.look.ground, brdf, choices, variations=varied)
            wanted = with_effects(wanted, each.made_with["effects"])
        except (KeyError, TypeError, ValueError, AttributeError):
            results.append(_verdict(None, "nobody noted how it was made") | {"name": name})
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
        return _verdict(None, f"it cannot be made anew: {error}")


def _factor_again(run: Run, kept: Path, target: Path) -> Steps[Result]:
    from engine.factor.factor import factor

    brdf = run.given
    if isinstance(brdf, Path):
        brdf = yield from part(read_brdf_steps(brdf), 0.0, 0.1)
    assert run.choices is not None
    write_factors(target, (yield from part(factor(brdf, run.choices, None), 0.1, 1.0)))
    place = place_of_factors(run, kept)
    if not holds_factors(place):
        return _verdict(None, LOST if find_note(place) is not None else NOT_FOUND_YET)
    before, why = fingerprints(place), "settings are the same, versions or machine differ"
    return _compare(before, fingerprints(target), NOT_AT_END if read_factors(place).searching else why)


def _bake_again(wanted: Wanted, made: Made, kept: Path, target: Path) -> Steps[Result]:
    if place_of_bake(wanted, kept).name != made.name:
        return _verdict(None, OTHER_STATE)
    estimate = yield from part(estimate_bake(wanted), 0.0, 0.2)
    if estimate.why_not:
        raise UsageError(estimate.why_not)
    yield from part(bake(target, estimate), 0.2, 1.0)
    if not made.present:
        return _verdict(None, LOST)
    before, now = open_transport(kept / made.name), open_transport(target)
    by, own = str(before.settings.get("software", "an unknown version")), f"lightarc {engine.__version__}"
    why = f"it was made by {by}, not {own}" if by != own else "settings are the same, the machine differs"
    return _compare(_numbers(before.arrays), _numbers(now.arrays), why)


def _numbers(arrays: Mapping[str, Any]) -> dict[str, tuple[Any, ...]]:
    """Type, shape and bytes of arrays, which are equal where the arrays are bit by bit."""
    return {name: (array.dtype.str, array.shape, np.asarray(array).tobytes()) for name, array in arrays.items()}


def _compare(before: Mapping[str, object], now: Mapping[str, object], why: str) -> Result:
    other = sorted(name for name in {*before, *now} if before.get(name) != now.get(name))
    return _verdict(not other, f"{' and '.join(other[:3])} differ: {why}" if other else SAME)


def _verdict(bit_equal: bool | None, reason: str) -> Result:
    return {"bit_equal": bit_equal, "reason": reason}
