"""One capture of a batch: import, calibration, material, maps, project and exports, in one folder, whole or not at all.

The steps are those of the window and of `lightarc import`, `shade`, `normals` and `export`. The folder holds

    NAME.lap, NAME.lap-data   the project, without the pixels of the photographs, of which it can read them again
    material.lightarc         the bundle
    maps                      the maps of the surface, where the lamps tell its slopes
    export                    a folder for each target
    capture.json              what the report says of it, and the key

The key is the hash of what all of this is made from: contents of files, choices, targets and the version of the
program. A folder that has the key is not made again. No file depends on when or on how many processes it was made,
but for the time of change in the project.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import engine
from app.batch.captures import OF_PROJECT, Capture, capture_from, value_of
from app.batch.record import FOLDER_RECORD, read_folder
from app.batch.template import read_template
from app.commands.export_bundle import export as export_bundle
from app.commands.export_elsewhere import Known, send
from app.commands.making import keep_marks, material_of, stack_of, with_material
from app.commands.surface import save as save_maps
from app.commands.surface import surface_of
from app.document.document import ImportChoices, Project
from app.project.made import key_of
from app.project.photographs import photographs, take_marks
from app.project.pixels import FILES
from app.project.project_file import ENDING, History, Writer, data_folder
from app.project.thumbnail import keep_thumbnail
from engine.capture.lights.sources import find_packed
from engine.core.health import Verdict
from engine.core.steps import Step, Steps, part, without_partials
from engine.scene.credits import Credits
from engine.storage.atomic import atomic_folder, discard, make_folder, write_json
from engine.surface.lamps import shows_slopes

#: Members of the folder.
BUNDLE, MAPS, EXPORT = "material.lightarc", "maps", "export"

#: Targets where nobody chose any.
TARGETS = ("web",)

#: Columns of metadata that become credits, by the names of those.
_CREDITS = {"title": "title", "author": "author", "license": "license", "licence": "license", "source": "source"}


@dataclass(frozen=True)
class Outputs:
    """The results that each capture of a batch has: by the choices of the project `template`, into the folder
    `output`, with an export to each of `targets`; None for those of the template, or a web page where it has none."""

    output: Path
    template: Path | None = None
    targets: tuple[str, ...] | None = None


class _Unchanged(Exception):
    """The folder of the capture is what would be made; `record` is its record."""

    def __init__(self, record: dict[str, Any]) -> None:
        super().__init__()
        self.record = record


def make_of_request(capture: str, order: Mapping[str, Any]) -> Steps[dict[str, Any]]:
    """As `make`, of what a process is told: the text of the capture, and the order as JSON values."""
    template, targets = order["template"], order["targets"]
    chosen = Outputs(
        Path(order["output"]),
        None if template is None else Path(template),
        None if targets is None else tuple(targets),
    )
    return make(capture_from(capture), chosen)


def make(capture: Capture, outputs: Outputs) -> Steps[dict[str, Any]]:
    """Make the folder of `capture` unless it is there; its record.

    Raises
    ------
    FileError : photographs, a file of the choices or the template cannot be used, or the disk is full.
    UsageError : a choice does not suit the photographs.
    """
    yield Step(0.0, "looking for photographs")
    project = read_template(outputs.template)
    target = outputs.output / capture.name
    try:
        with atomic_folder(target, FOLDER_RECORD) as folder:
            return (yield from _make(capture, project, outputs, folder))
    except _Unchanged as same:
        return same.record


def _make(capture: Capture, template: Project, outputs: Outputs, folder: Path) -> Steps[dict[str, Any]]:
    path = folder / f"{capture.name}{ENDING}"
    data, final = make_folder(data_folder(path)), outputs.output / capture.name / path.name
    project = _choose(template, capture, outputs.targets)
    frames = _list_files(project)
    finding = find_packed([capture.place], aside=frames, keep=data / "photographs" / "archive")
    sources = yield from part(finding, 0.0, 0.02)
    project = replace(project, sources=sources, imported_with=project.import_choices)
    files = (*photographs(project), *frames)
    marks = yield from part(take_marks(files), 0.02, 0.05)
    key = _key(project, capture, {file: mark.hash for file, mark in marks.items()})
    if (known := read_folder(final.parent)) is not None and known.get("key") == key:
        raise _Unchanged(known)

    stack = yield from _pass_on(stack_of(sources, project.import_choices, data / f"stack-{key}"), 0.05, 0.45)
    project = replace(project, stack=stack, excluded=project.excluded & frozenset(stack.sources))
    material = yield from _pass_on(material_of(project), 0.45, 0.6)
    project = with_material(project, stack, material)
    if shows_slopes(stack):
        surface = yield from _pass_on(surface_of(project), 0.6, 0.7)
        untimed = replace(surface, seconds={})  # as what is made twice is the same
        project = replace(project, surface=untimed, surface_from=project.surface_recipe)
        yield from _pass_on(save_maps(project, folder / MAPS), 0.7, 0.75)
    yield from _pass_on(export_bundle(project, folder / BUNDLE, None), 0.75, 0.8)
    sent = None
    if targets := project.exporting.targets:
        sending = send(project, None, Known(), targets, folder / EXPORT, data)
        sent = (yield from _pass_on(sending, 0.8, 0.97)).record
    yield Step(0.97, "writing the project")
    writer = Writer(path, seen_from=data_folder(final), own=data)
    writer.write(History(project))
    writer.close()
    keep_marks(data, marks)
    yield from _pass_on(keep_thumbnail(path, project), 0.98, 0.99)
    if stack.folder is not None:
        for name in FILES:
            discard(stack.folder / name)
    record = {"lightarc_capture": 1, "key": key, **_describe(capture, project, sent)}
    write_json(folder / FOLDER_RECORD, record)
    return record


def _pass_on(steps: Steps[Any], start: float, stop: float) -> Steps[Any]:
    return part(without_partials(steps), start, stop)


def _choose(template: Project, capture: Capture, targets: tuple[str, ...] | None) -> Project:
    """`template` with the options, the name and the credits of a capture."""
    values = {name: value_of(name, text) for name, text in capture.options.items()}
    own = {name: value for name, value in values.items() if name in OF_PROJECT}
    choices = replace(
        template.import_choices, **{name: value for name, value in values.items() if name not in OF_PROJECT}
    )
    said = {_CREDITS[name.lower()]: text for name, text in capture.metadata.items() if name.lower() in _CREDITS}
    exporting = template.exporting
    credits = Credits(**said).over(exporting.credits)
    if targets is None:
        targets = TARGETS if exporting.targets is None else exporting.targets
    exporting = replace(exporting, targets=targets, credits=credits)
    return replace(template, **own, import_choices=choices, exporting=exporting, name=capture.name)


def _list_files(project: Project) -> list[Path]:
    """Files beside the photographs that the choices of an import name."""
    values = (getattr(project.import_choices, each.name) for each in fields(ImportChoices))
    return [value for value in values if isinstance(value, Path)]


def _key(project: Project, capture: Capture, contents: Mapping[Path, str]) -> str:
    """The hash of all that the folder of a capture is made from."""
    parts = [getattr(project, each.name) for each in fields(Project)]
    return key_of(engine.__version__, dict(capture.metadata), *parts, contents=contents)


def _describe(capture: Capture, project: Project, sent: Mapping[str, Any] | None) -> dict[str, Any]:
    """Figures of a capture for the report: verdict, warnings, errors, and the files of its folder."""
    stack, material = project.stack, project.material
    assert stack is not None
    health = material.health if project.surface is None else material.health.merge(project.surface.health)
    kind = "directional" if material.directional is not None else "shading_map"
    chart = (stack.provenance.get("chart") or {}).get("summary", {}).get("after", {})
    targets = {each["target"]: each["rmse_rel"] for each in (sent["targets"] if sent is not None else ())}
    return {
        "name": capture.name,
        "photographs": len(stack.sources),
        "width_px": int(stack.radiance.shape[2]),
        "height_px": int(stack.radiance.shape[1]),
        "representation": kind.replace("_", "-"),
        "verdict": Verdict(health.verdict).name.lower(),
        "warnings": list(dict.fromkeys(health.warnings)),
        "held_out_rmse_srgb8": _number(health.figures.get(f"{kind}_leave_one_out_rmse_srgb8")),
        "mean_picture_rmse_srgb8": _number(health.figures.get("mean_picture_rmse_srgb8")),
        "delta_e": _number(chart.get("mean")),
        "alignment_residual_px": _number(
            max((q.alignment_residual_px for q in stack.quality if q.alignment_residual_px is not None), default=None)
        ),
        "calibration": [term["text"] for term in stack.provenance.get("calibration") or []],
        "rmse_rel": {name: _number(error) for name, error in targets.items()},
        "project": f"{capture.name}{ENDING}",
        "page": f"{EXPORT}/web/{_page_of(sent)}" if "web" in targets else None,
        "maps": MAPS if project.surface is not None else None,
    }


def _page_of(sent: Mapping[str, Any] | None) -> str:
    """The file of the web page among those of an export, the one HTML file that is neither a part nor a snippet."""
    files = next((each["files"] for each in (sent or {"targets": ()})["targets"] if each["target"] == "web"), ())
    names = [Path(name).name for name in files if len(Path(name).parts) == 2 and name.endswith(".html")]
    return next(name for name in names if name != "embed.html")


def _number(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None
