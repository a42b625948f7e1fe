"""`lightarc export`: a material in forms that other programs open, with the error of each."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.options import add_search, refuse_unused
from app.arguments.quantities import MILLIMETRES, share
from app.arguments.results import EXPORT, Input, Output
from app.commands.making import readable_stack
from app.commands.rebuilding import set_up_whole
from app.commands.surface import material_with_surface
from app.document.exporting import Exporting
from app.project.project_file import data_folder
from app.project.setup import is_project
from engine.capture.scale import mm_per_texel
from engine.capture.stack import open_stack
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import number, percent, size_text
from engine.core.steps import Step, drain
from engine.exchange.targets import EXPORTERS

if TYPE_CHECKING:
    from app.commands.export_elsewhere import Known
    from app.document.document import Project
    from engine.capture.stack import ImageStack
    from engine.scene.material import Material

EXAMPLE = "lightarc export woven.lightarc --to textures --preset unreal -o woven-unreal"

#: Presets and codings: options are there without the engine.
PRESETS = ("blender", "unreal", "unity", "godot", "substance", "gltf")
CODINGS = ("png8", "png16", "exr")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "source",
        type=Input(),
        metavar="MATERIAL|PROJECT",
        help="a bundle, a project (.lap), a folder or zip of PBR textures, a MaterialX document (.mtlx), a glTF file "
        "or an RTI file (.ptm, .rti, a folder with info.json)",
    )
    parser.add_argument("--to", nargs="+", action="extend", choices=(*EXPORTERS, "auto"), help="targets, one or more")
    parser.add_argument(
        "--proof",
        action="store_true",
        help="write all targets, and a sheet with the image that each of their programs on this machine draws beside "
        "ours (MaterialX, three.js in Chromium, Blender, Mitsuba, RTI files; USD, glTF validator and glslang check)",
    )
    parser.add_argument(
        "-o", "--output", required=True, type=Output(EXPORT), metavar="FOLDER", help="folder, a folder in it per target"
    )
    parser.add_argument(
        "--stack",
        type=Input(),
        metavar="STACK",
        help="the stack that the bundle was made of, to state errors against the photographs (a project knows its own)",
    )
    parser.add_argument(
        "--error",
        type=share,
        metavar="E",
        help="for --to auto, which writes the smallest representation whose relative RMSE under the environments is at "
        "most E (0.05)",
    )
    textures = parser.add_argument_group("textures")
    textures.add_argument("--preset", choices=PRESETS, help="names and packing of a program (blender)")
    textures.add_argument("--coding", choices=CODINGS, help="PNG of 8 or 16 bits, or OpenEXR (png8)")
    textures.add_argument(
        "--normal",
        choices=("opengl", "directx"),
        help="y of normals up or down; otherwise as the program of the preset reads them",
    )
    parser.add_argument(
        "--tiling-mode",
        choices=("grid", "hex"),
        help="for --to materialx: how maps repeat, the same in a grid, or in hexagonal cells without a visible period "
        "(grid)",
    )
    parser.add_argument(
        "--enlarge",
        type=int,
        metavar="N",
        help="write a tile of N × N repeats that all differ, in hexagonal cells that repeat at its border, for "
        "programs that know no other way to repeat maps than a grid (2 to 16)",
    )
    parser.add_argument(
        "--width-mm",
        type=MILLIMETRES,
        metavar="MM",
        help="width of the sample, from the left edge of its maps to the right one, for units, heights and scale bars "
        "(without it that of lightarc import --scale, where the photographs or the bundle have it)",
    )
    add_search(parser)
    credits = parser.add_argument_group("credits", "written into the files, before those that the material came with")
    credits.add_argument("--title", type=str, default="", metavar="TEXT", help="title of the work")
    credits.add_argument("--author", type=str, default="", metavar="TEXT", help="who made it")
    credits.add_argument("--license", type=str, default="", metavar="SPDX", help="its licence, as CC-BY-4.0")
    credits.add_argument("--source", dest="origin", type=str, default="", metavar="TEXT", help="where it comes from")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """`targets`, a list of objects with `target`, `files`, `bytes`, `rmse_rel`, `rmse_rel_reference`, `flip`,
    `by_environment`, `errors_are` (the meaning of these, and why one is null) and `warnings`; the same errors of the
    `slices` beside a power law in shaders and of the `power_law` of Blender; of RTI and BRDFs `rmse_rel_by_file`.
    `material`, the errors before leaving; `proof`, the sheet and its consumers."""
    if arguments.proof == bool(arguments.to):
        raise UsageError("give either --to with one or more targets, or --proof, which writes all of them")
    show(Step(0.0, "reading the material"))
    from app.commands.export_elsewhere import Known, find_known_entries, own_errors
    from engine.exchange.export import export
    from engine.exchange.subject import Settings
    from engine.scene.credits import Credits

    _refuse_unused(arguments)
    material, stack, project = _open(arguments)
    width_mm = arguments.width_mm
    if width_mm is None and stack is None and project is None:
        width_mm = _find_width_mm(arguments.source, material)
    if arguments.enlarge is not None:
        from engine.exchange.enlarge import enlarge, width_of_tile

        width_mm = width_of_tile(material, arguments.enlarge, stack, width_mm)
        material = drain(enlarge(material, arguments.enlarge, stack), show)
        stack, project = None, None
    credits = Credits(arguments.title, arguments.author, arguments.license, source=arguments.origin)
    settings = Settings(arguments.preset, arguments.coding, arguments.normal, width_mm, arguments.tiling_mode, credits)
    if arguments.proof:
        from engine.proof.proof import prove

        return _select_reported(material, drain(prove(arguments.output, material, stack), show))
    names = list(dict.fromkeys(arguments.to))
    known = _find_measured_before(arguments, project) if project is not None else Known()
    exporting = export(
        arguments.output,
        material,
        names,
        settings=settings,
        stack=stack,
        error=arguments.error,
        known=find_known_entries(known),
        own=own_errors(material, known),
    )
    record = drain(exporting, show)
    return _select_reported(material, record)


def _refuse_unused(arguments: argparse.Namespace) -> None:
    """UsageError for an option that no target uses; then the defaults of those that were not given."""
    names = tuple(EXPORTERS) if arguments.proof else tuple(arguments.to or ())
    needs = {"--error": "auto", "--tiling-mode": "materialx"}
    rules = [(flag, target in names, f"--to {target}") for flag, target in needs.items()]
    of_textures = bool({"textures", "auto"} & set(names))
    rules += [(flag, of_textures, "--to textures") for flag in ("--preset", "--coding", "--normal")]
    refuse_unused(arguments, rules)
    for name, default in {"error": 0.05, "preset": PRESETS[0], "coding": CODINGS[0], "tiling_mode": "grid"}.items():
        if getattr(arguments, name) is None:
            setattr(arguments, name, default)


def _find_width_mm(source: str, material: Material) -> float | None:
    """The width that the provenance of a bundle tells, None for anything else."""
    from engine.bundle.manifest import MAPS_PROCESS, describe_bundle
    from engine.exchange.readers.read import holds_material

    if is_project(source) or not material.has_map or holds_material(source):
        return None
    size = mm_per_texel(describe_bundle(source, MAPS_PROCESS)["provenance"])
    return None if size is None else size * material.size[1]


def _select_reported(material: Material, record: dict[str, Any]) -> dict[str, Any]:
    """The part of a record that scripts and users are told."""
    names = ("folder", "material", "targets", "auto", "proof")
    return {
        **{name: record[name] for name in names if name in record},
        "warnings": [
            *(material.health.warnings if material.pbr is not None else ()),
            *_group(record["targets"]),
        ],
    }


def _group(targets: list[dict[str, Any]]) -> list[str]:
    """Warnings of targets, each once behind the names of those that it holds for."""
    said: dict[str, list[str]] = {}
    for made in targets:
        for words in made["warnings"]:
            said.setdefault(words, []).append(made["target"])
    return [f"{', '.join(names)}: {words}" for words, names in said.items()]


def _find_measured_before(arguments: argparse.Namespace, project: Project) -> Known:
    """Errors that the window measured for the project and kept beside it; none of them is written here."""
    from app.commands.export_elsewhere import find_measured_before

    textures = Exporting(preset=arguments.preset, coding=arguments.coding, normal=arguments.normal or "")
    asked = replace(project, exporting=textures)
    return drain(find_measured_before(asked, tuple(EXPORTERS), [data_folder(Path(arguments.source))]))


def _open(arguments: argparse.Namespace) -> tuple[Material, ImageStack | None, Project | None]:
    """The material of a bundle or a project, the photographs where they are at hand, and the project.

    A project whose photographs are not at hand, or others than its own, counts as none: its errors are others.
    """
    from engine.exchange.readers.read import open_material

    stack = open_stack(arguments.stack) if arguments.stack else None
    if not is_project(arguments.source):
        return open_material(arguments.source, search=arguments.search), stack, None
    project = set_up_whole(Path(arguments.source)).project
    if not project.has_map:
        raise InputError(arguments.source, "has no material yet", "Build one in the window, or with lightarc shade")
    own = drain(readable_stack(project)) if stack is None else None
    return material_with_surface(project), stack or own, project if own is project.stack else None


def report(result: dict[str, Any]) -> str:
    lines = [f"{'target':<11}{'size':>10}{'photographs':>13}{'reference':>11}{'FLIP':>10}"]
    for made in result["targets"]:
        errors = [_percent(made[name]) for name in ("rmse_rel", "rmse_rel_reference")]
        flip = "–" if made["flip"] is None else number(made["flip"], 3)
        lines.append(f"{made['target']:<11}{size_text(made['bytes']):>10}{errors[0]:>13}{errors[1]:>11}{flip:>10}")
    if "auto" in result:
        for other in result["auto"]["candidates"]:
            is_chosen, by = (
                other["target"] == result["auto"]["chosen"],
                f" by its {other['by']}" if "by" in other else "",
            )
            size, error = size_text(other["bytes"]), _percent(other["rmse_rel_reference"])
            lines.append(f"{'chosen' if is_chosen else 'not chosen'}: {other['target']}{by}, {size}, {error}")
    lines.append("Errors are relative: against the photographs, and against the material under three environments.")
    if any(made["target"] == "brdf" for made in result["targets"]):
        lines.append(
            "Of brdf they compare a ball of the BRDF alone, as its .mtlx shows it, with that of the BRDF itself."
        )
    own = result["material"]
    if own["rmse_rel"] is not None:
        lines.append(f"The material itself shows the photographs to {percent(own['rmse_rel'], 3)}.")
    if own["brdf_fit_rmse_rel"] is not None:
        error = percent(own["brdf_fit_rmse_rel"], 3)
        lines.append(f"Shaders and pages hold a model in place of the measured BRDF, {error} away from it.")
    lines.append(f"Written to {result['folder']}.")
    if "proof" in result:
        for row in result["proof"]["consumers"]:
            error = "" if row["rmse_rel"] is None else f"{percent(row['rmse_rel'], 3)} from our image. "
            lines.append(f"{row['consumer']}: {error}{row['words']}")
        lines.append(f"The sheet is {result['proof']['sheet']}.")
    return "\n".join(lines)


def _percent(value: float | None) -> str:
    return "–" if value is None else percent(value, 3)
