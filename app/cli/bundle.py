"""`lightarc bundle`: check a bundle, show what is in it, take it apart, look at it, or make one of a project."""

from __future__ import annotations

import argparse
import tempfile
import webbrowser
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from app.arguments.options import add_search
from app.arguments.results import Input, Output, material_at
from app.arguments.usage import BAD_FILE, DONE
from app.commands.export_bundle import export
from app.commands.rebuilding import set_up_whole
from app.project.project_file import read
from app.project.report import chain_of, identity
from engine.bundle.bundle import check_replaceable, extract_bundle, open_bundle, save_bundle, verify_bundle
from engine.bundle.manifest import MAPS_PROCESS, describe_bundle
from engine.bundle.page import make_page
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import size_text
from engine.core.steps import Step, drain
from engine.exchange.readers.read import holds_material, open_material
from engine.storage.atomic import discard, write_bytes

NAME = "bundle"
EXAMPLE = "lightarc bundle verify woven.lightarc --json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "action",
        choices=("verify", "show", "extract", "view", "make"),
        help="verify: check everything; show: print the manifest; extract: write the members into a folder; view: open "
        "the material in a browser; make: write the material of a project, or PBR maps of others",
    )
    parser.add_argument(
        "path",
        type=Input(),
        metavar="BUNDLE",
        help="a .lightarc file or a bundle folder; for make a project (.lap), a "
        "folder or zip of PBR textures, a MaterialX document, a glTF file or an RTI file",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Output(material_at),
        metavar="FILE",
        help="make: the .lightarc file or folder to write; extract: the folder",
    )
    add_search(parser)


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """`ok`, `members`, `problems`, `unchecked`, `size_bytes`, `schema_version` of a bundle; exit code 3 where it is not
    sound. Members that another version wrote for other programs are `unchecked`, which is no fault of the bundle.

    One that is made of a project is checked in the same way. Of extract and view, `folder` with `files`, and `page`.
    """
    if (arguments.action in ("make", "extract")) != (arguments.output is not None):
        raise UsageError("make and extract, and these alone, need -o, the bundle or the folder to write")
    if arguments.action == "extract":
        return _extract(Path(arguments.path), Path(arguments.output), show)
    if arguments.action == "view":
        return _view(Path(arguments.path), show)
    if arguments.action == "make":
        _make(Path(arguments.path), Path(arguments.output), arguments.search, show)
        arguments.path = arguments.output
    show(Step(0.0, "reading the bundle"))
    if arguments.action == "show":
        return describe_bundle(arguments.path)
    verification = verify_bundle(arguments.path)
    return {
        "path": str(arguments.path),
        "ok": verification.ok,
        "members": list(verification.members),
        "problems": list(verification.problems),
        "unchecked": list(verification.unchecked),
        "size_bytes": verification.size_bytes,
        "schema_version": verification.schema_version,
        "warnings": [
            *verification.problems,
            *verification.unchecked,
            *(describe_bundle(arguments.path)["warnings"] if verification.ok else ()),
        ],
        "exit_code": DONE if verification.ok else BAD_FILE,
    }


def _extract(bundle: Path, folder: Path, show: Callable[[Step], None]) -> dict[str, Any]:
    """Write the members of a bundle, each as its manifest says, into a folder, which is a bundle again."""
    if folder.suffix.lower() == ".lightarc":
        raise UsageError(f"extract writes a folder, and {folder.name} names a bundle file")
    show(Step(0.0, "reading the bundle"))
    files = extract_bundle(bundle, folder)
    return {"folder": str(folder), "files": files, "warnings": describe_bundle(folder, MAPS_PROCESS)["warnings"]}


def _view(bundle: Path, show: Callable[[Step], None]) -> dict[str, Any]:
    """Open a page of the material in the browser of this machine; it is made anew, whoever made the bundle."""
    show(Step(0.0, "reading the bundle"))
    material = open_bundle(bundle)
    if material.pbr is not None:
        raise UsageError("PBR maps have no page; lightarc export --to gltf writes what any viewer of glTF shows")
    page = Path(tempfile.mkdtemp(prefix="lightarc-view-")) / "index.html"
    try:
        write_bytes(page, make_page(material))
    except BaseException:
        discard(page.parent)
        raise
    opened = webbrowser.open(page.as_uri())
    return {"page": str(page), "opened": opened, "warnings": material.health.warnings}


def _make(source: Path, output: Path, search: str | None, show: Callable[[Step], None]) -> None:
    """Write PBR maps of others, or the material of a project: InputError where it has none, or its data are gone."""
    if holds_material(source):
        check_replaceable(output)
        show(Step(0.0, "reading the maps"))
        drain(save_bundle(output, open_material(source, search=search), provenance={"source": source.name}), show)
        return
    _make_of_project(source, output, show)


def _make_of_project(project: Path, output: Path, show: Callable[[Step], None]) -> None:
    show(Step(0.0, "reading the project"))
    setup = set_up_whole(project)
    if not setup.project.has_map:
        raise InputError(project, "has no material yet", "Build one in the window, or with lightarc shade")
    opened = read(project)
    chain = chain_of(project, setup.project, opened.steps[: opened.position])
    drain(export(setup.project, output, setup.scene, origin={"project": identity(project), **chain}), show)


def report(result: dict[str, Any]) -> str:
    if "files" in result:
        return "\n".join([f"Written to {result['folder']}:", *(f"  {name}" for name in result["files"])])
    if "page" in result:
        return f"Opened {result['page']}" if result["opened"] else f"No browser was found. The page: {result['page']}"
    if "ok" not in result:
        return "\n".join(_summary(result))
    if result["ok"]:
        counted = f"{len(result['members'])} members with the manifest, {result['size_bytes']:,} bytes"
        if result["unchecked"]:
            return f"The material in {result['path']} is whole: {counted}."
        return f"{result['path']} is sound: {counted}."
    return "\n".join(["The bundle is not sound:", *(f"- {problem}" for problem in result["problems"])])


def _summary(manifest: dict[str, Any]) -> Iterator[str]:
    """Lines on a bundle that answer what a user asks first; --json prints all of the manifest."""
    provenance, elevations = manifest["provenance"], manifest["elevation_deg"]
    photographs = len(provenance.get("photographs") or [])
    yield f"{manifest['name']}, written by lightarc {manifest['software'].get('lightarc', 'of an unknown version')}"
    if photographs:
        lights = f", lights at {min(elevations):.3g}° to {max(elevations):.3g}° used" if elevations else ""
        excluded = len(provenance.get("excluded_photographs") or [])
        yield f"photographs: {photographs}{f', {excluded} excluded' if excluded else ''}{lights}"
    for kind in ("shading_map", "power_law", "directional", "pbr"):
        if manifest.get(kind) is not None:
            yield f"{kind.replace('_', ' ')}: {_size(manifest[kind])}"
    yield f"BRDF: {manifest['brdf']}"
    project = provenance.get("project")
    if project:
        yield f"project: {project['name']}, {project['history_steps']} steps, state {project['state']}"
    yield "members:"
    width = max(map(len, manifest["members"]), default=0)
    for name, member in sorted(manifest["members"].items()):
        yield f"  {name:{width}}  {size_text(member['size_bytes'])}"
    yield "The whole manifest: lightarc bundle show --json"


def _size(maps: dict[str, Any]) -> str:
    """Texels of maps, and the count of those that lie over each other."""
    texels = f"{maps['width_px']} × {maps['height_px']} texels"
    layers = next((f"{maps[name]} {name} of " for name in ("slices", "planes") if isinstance(maps.get(name), int)), "")
    return f"{layers}{texels}"
