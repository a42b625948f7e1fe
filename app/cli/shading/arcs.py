"""Arcs of lamps in `lightarc shade`: one of a dome by `--azimuth` or `--arc`, or a material of each by `--per-arc`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from engine.capture.lights.selection import Azimuth, arcs, beside
from engine.core.errors import InputError
from engine.core.steps import Step
from engine.shading.shading_map import include
from engine.storage.atomic import atomic_folder, write_json

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack

#: The work that makes one material, of the arguments, the stack, and where steps are shown.
Make = Callable[[argparse.Namespace, "ImageStack", Callable[[Step], None]], dict[str, Any]]


def exclude(arguments: argparse.Namespace, stack: ImageStack) -> list[str]:
    """Names of the photographs to leave out: those that were named, and those beside the arc that was asked for."""
    if arguments.azimuth is None and not arguments.arc:
        return list(arguments.exclude)
    near = Azimuth(*arguments.azimuth) if arguments.azimuth is not None else _arcs(arguments, stack, best=True)[0][0]
    left_out = beside(*_angles(stack), near)
    if len(stack.sources) - left_out.sum() < 2:
        problem = f"has fewer than two lamps at the azimuth {near.middle_deg:g}° ± {near.tolerance_deg:g}°"
        raise InputError(stack.folder or "the stack", problem, "Widen the tolerance, or choose another azimuth")
    names = [name for name, is_out in zip(stack.sources, left_out, strict=True) if is_out]
    return list(dict.fromkeys([*arguments.exclude, *names]))


def run(arguments: argparse.Namespace, stack: ImageStack, make: Make, show: Callable[[Step], None]) -> dict[str, Any]:
    """Write a shading map of each arc into a folder, all of them or none."""
    found = _arcs(arguments, stack)
    records = []
    with atomic_folder(Path(arguments.output), "arcs.json") as folder:
        for at, (near, names) in enumerate(found):
            file = f"arc-{round(near.middle_deg) % 360:03}.lightarc"
            own = argparse.Namespace(**vars(arguments))
            own.output, own.representation = str(folder / file), "shading-map"
            own.exclude = [name for name in stack.sources if name not in names]
            made = make(own, stack, _within(show, at / len(found), 1.0 / len(found)))
            made["output"] = str(Path(arguments.output) / file)
            records.append({"azimuth_deg": near.middle_deg, "file": file, "photographs": len(names), **made})
        write_json(folder / "arcs.json", {"lightarc_arcs": 1, "arcs": records})
    return {"arcs": records, "warnings": [text for each in records for text in each["warnings"]]}


def heading(record: dict[str, Any]) -> str:
    """The line above what is told of the material of one arc."""
    return f"{record['file']}, {record['photographs']} photographs at the azimuth {record['azimuth_deg']:g}°: "


def _within(show: Callable[[Step], None], start: float, share: float) -> Callable[[Step], None]:
    """Show steps of a part of the work as those of all of it."""
    return lambda step: show(Step(start + share * step.done, step.note))


def _arcs(arguments: argparse.Namespace, stack: ImageStack, best: bool = False) -> list[tuple[Azimuth, list[str]]]:
    """Arcs of the photographs that are not left out, with their names; the one of most photographs where `best`."""
    used = include(stack, arguments.exclude)
    azimuth, elevation = _angles(stack)
    found = [(near, [stack.sources[used[at]] for at in own]) for near, own in arcs(azimuth[used], elevation[used])]
    if not found:
        problem = "has no arc of lamps: nowhere are there three elevations within 10° of one azimuth"
        raise InputError(stack.folder or "the stack", problem, "Leave out --arc and --per-arc")
    return [max(found, key=lambda arc: len(arc[1]))] if best else found


def _angles(stack: ImageStack) -> tuple[np.ndarray[Any, np.dtype[np.float64]], np.ndarray[Any, np.dtype[np.float64]]]:
    if stack.azimuth is None:
        remedy = "Import it with a light list (.lp) or a capture.toml"
        raise InputError(stack.folder or "the stack", "its lamps have no azimuth", remedy)
    return stack.azimuth, stack.elevation
