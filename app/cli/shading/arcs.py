"""Arcs of lamps in `lightarc shade`: one of a dome by `--azimuth` or `--arc`, or a material of each by `--per-arc`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.capture.lights.selection import Azimuth
from engine.core.steps import Step
from engine.shading.stack_arcs import exclude_beside, find_arcs
from engine.storage.atomic import atomic_folder, write_json

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack

#: The work that makes one material, of the arguments, the stack, and where steps are shown.
Make = Callable[[argparse.Namespace, "ImageStack", Callable[[Step], None]], dict[str, Any]]


def exclude(arguments: argparse.Namespace, stack: ImageStack) -> list[str]:
    """Names of the photographs to leave out: those that were named, and those beside the arc that was asked for."""
    if arguments.azimuth is None and not arguments.arc:
        return list(arguments.exclude)
    return exclude_beside(stack, arguments.azimuth and Azimuth(*arguments.azimuth), arguments.exclude)


def run(arguments: argparse.Namespace, stack: ImageStack, make: Make, show: Callable[[Step], None]) -> dict[str, Any]:
    """Write a shading map of each arc into a folder, all of them or none."""
    found = find_arcs(stack, arguments.exclude)
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
