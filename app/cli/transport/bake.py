"""`lightarc bake`: precompute light transport for a model, so that light and view can then change at once.

The methods and their settings are those of `engine.transport.method`.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from app.arguments.options import add_cluster, add_search, refuse_plain_cluster, settings_from
from app.arguments.results import TRANSPORT, Input, Output
from app.cli.brdf import BRDF_HELP
from app.cli.doubts import doubts_of_brdf, mean_in_place_of_maps, means_of_parts
from app.cli.transport import bake_auto, project_input, scene_options
from app.cli.transport import options as vary
from app.cli.transport.bake_report import COMPILING, carry_out, subject_of
from app.cli.transport.method_options import add_options, options, strange_options
from app.cli.transport.options import variations_of
from app.document.bake_request import choices_for
from app.process.ending import SENTENCE
from app.session.machine_profile import learn_bake
from engine.accuracy.bake_check import check_file
from engine.core.errors import UsageError
from engine.core.figure_text import percent, size_text, time_text
from engine.core.params import parameters
from engine.core.steps import Step, drain, part
from engine.core.stopwatch import read_clock
from engine.exchange.readers.read import open_material
from engine.light.environment_file import open_environment
from engine.scene.scene import materials_of_parts
from engine.transport import method as transport
from engine.transport.baking.check import BakeCheck, lines_of_check
from engine.transport.baking.parts import text_of
from engine.transport.baking.spatially_varying import variation_to_text
from engine.transport.method import Method

if TYPE_CHECKING:
    from app.document.document import Project
    from engine.geometry.mesh import Mesh
    from engine.scene.material import Material

EXAMPLE = "lightarc bake sphere --brdf ggx:alpha=0.3 --mode wavelet --ground -o sphere.transport"

AUTO = "auto"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    scene_options.add_mesh(parser)
    parser.add_argument("--brdf", type=Input(), metavar="TEXT", help=BRDF_HELP)
    parser.add_argument(
        "--material",
        type=Input(),
        metavar="MATERIAL",
        help=f"{scene_options.MATERIAL_HELP}, whose BRDF is baked; of PBR maps the one at their mean, with the error "
        "of that",
    )
    add_search(parser)
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Output(TRANSPORT),
        metavar="TRANSPORT",
        help="file to write, for example bunny.transport",
    )
    hints = "; ".join(f"{method.name}: {method.hint}" for method in transport.METHODS)
    parser.add_argument(
        "--mode",
        choices=(*transport.names(), AUTO),
        help=f"{hints}; {AUTO}: the mode that 'lightarc plan' chooses ({transport.DEFAULT})",
    )
    scene_options.add_ground(parser)
    scene_options.add_brushing(parser)
    parser.add_argument(
        "--ground-cells", type=int, default=64, metavar="N", help="cells along a side of the ground (64)"
    )
    varied = (_max_variations(method) for method in transport.methods_with("variations"))
    vary.add_argument(parser, f"for {', '.join(varied)} and {AUTO}")
    parser.add_argument(
        "--error-env",
        type=Input(reach="file"),
        metavar="FILE",
        help="measure the error under this environment at 400 vertices, seen from 20 directions (half a minute)",
    )
    parser.add_argument(
        "--no-check",
        action="store_true",
        help="leave out the check at the end, which compares small images of the bake with the reference (seconds) and "
        "keeps the errors in the file",
    )
    parser.add_argument(
        "--restart",
        action="store_true",
        help="discard a cancelled bake, and keep nothing if this one is cancelled",
    )
    add_cluster(parser, "bake")
    add_options(parser, _settings)
    bake_auto.add_arguments(parser.add_argument_group(f"--mode {AUTO}"))


def _max_variations(method: transport.Method) -> str:
    return (
        f"{method.name} ({method.variations} times at most)"
        if method.variations < transport.ANY_NUMBER
        else method.name
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    show(Step(0.0, f"reading {arguments.mesh}"))  # before kernels are compiled, which takes long the first time
    scene_options.take_own_material(arguments)
    material = _take_brdf(arguments, show)
    _choose_mode(arguments)
    _check(arguments)
    if arguments.mode == AUTO:
        made = bake_auto.run(arguments, show)
    else:
        made = _bake(transport.method_of(arguments.mode), arguments, show)
    warnings = dict.fromkeys([*made.get("warnings", ()), *material.get("warnings", ())])
    return {**made, **material, "warnings": list(warnings)}


def _take_brdf(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """Bake the BRDF of the material that is given, and say what it leaves out: `material` and `warnings`."""
    if arguments.material is None or project_input.is_given(arguments):
        return {}
    if arguments.brdf is not None:
        raise UsageError("a bake is of one BRDF: give --brdf or --material")

    show(Step(0.0, "reading the material"))
    material = open_material(arguments.material, parts=True, search=arguments.search)
    if material.measured is not None:
        raise UsageError("the material has a measured BRDF; give the measurement itself as --brdf")
    arguments.brdf = material.brdf
    if material.parts:
        arguments.model = scene_options.mesh_of(arguments)
        if materials_of_parts(arguments.model, material):
            arguments.of_parts = material
            return _describe_parts(arguments.model, material)
    if material.pbr is None:
        words = f"the texels of {material.name} are left out: what is baked is its BRDF, {material.brdf}"
        return {"warnings": [f"{words}; lightarc render BAKE --material shows them in its light"]}
    return mean_in_place_of_maps(material, show, "baked")


def _describe_parts(mesh: Mesh, material: Material) -> dict[str, Any]:
    """The names of the materials of the parts, and what bakes leave out of them."""
    found = {each.name: each for each in materials_of_parts(mesh, material)}
    own = [f"{name}: {text}" for name, each in found.items() for text in each.health.warnings]
    doubts = means_of_parts([*found.values()], "baked")
    if mesh.colours is not None:
        doubts.append("the colours of the vertices are left out; lightarc render BAKE --material shows them")
    return {"materials": list(found), "warnings": [*doubts, *own]}


def _choose_mode(arguments: argparse.Namespace) -> None:
    """Mode and settings of a project where nothing else was asked for, if that is baked; a model needs a BRDF."""
    if not project_input.is_given(arguments):
        if arguments.brdf is None:
            raise UsageError("a model needs --brdf or --material; a project brings its own")
        project_input.with_defaults(arguments, {"mode": transport.DEFAULT})
        return
    setup = project_input.setup_of(arguments)
    mode = setup.mode if setup.mode in transport.names() else transport.DEFAULT
    project_input.with_defaults(arguments, {"mode": mode})
    if arguments.mode != AUTO:
        project_input.with_defaults(arguments, _settings_there(setup.project, transport.method_of(arguments.mode)))


def _settings_there(project: Project, method: Method) -> dict[str, Any]:
    """The settings that a user chose in a project for bakes with `method`, by the names of their options."""
    chosen = choices_for(method.name, **project.bakes.get(method.name, {}))
    return {
        each.flag.removeprefix("--").replace("-", "_"): chosen.values[each.name]
        for each in parameters(method.settings)
        if each.name in chosen.values
    }


def _settings(method: Method) -> type[Any]:
    return method.settings


def _bake(method: Method, arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    settings, baking, subject = settings_from(arguments, method.settings), method.baking, subject_of(arguments)
    left_out = list[str]()
    if project_input.is_given(arguments):
        subject, settings, left_out = project_input.vary(arguments, method, subject, settings)
    else:
        subject = replace(subject, variations=variations_of(arguments, subject.brdf))
    tested = open_environment(arguments.error_env) if arguments.error_env is not None else None
    method.check_parts(subject)
    before = time.perf_counter()
    work = drain(part(baking.prepare(subject, settings, tested), 0.0, 0.05), show)
    prepared_s = time.perf_counter() - before
    error = drain(baking.measure(work, subject, settings, tested), show)
    varied = arguments.vary or [variation_to_text(each) for each in subject.variations]
    parameters = {**baking.parameters(work, settings), **({"vary": varied} if method.variations else {})}
    if subject.parts:
        parameters["brdf"] = " | ".join(dict.fromkeys(map(text_of, subject.parts)))
    own = [] if tested is None else [tested]
    if project_input.is_given(arguments):
        scene = project_input.setup_of(arguments).scene
        own += [] if scene.environment is None else [scene.environment]
    since = read_clock()
    show(Step(0.05, COMPILING))
    baked, record = carry_out(
        arguments,
        show,
        work,
        method.name,
        lambda: baking.bake(arguments.output, work, arguments.cluster),
        estimated_s=baking.estimate_s(work),
        parameters=parameters,
        start=0.05,
        check=lambda done: check_file(arguments.output, done.transport, method, subject, settings, own),
    )
    if baked is None:
        return record
    if not baked.resumed_chunks and arguments.cluster is None:
        learn_bake(subject, method, settings, baked.bake_s, since)
    figures = baking.figures(work, baked, prepared_s)
    return {
        **record,
        **error,
        **figures,
        "skipped": [*figures["skipped"], *record["skipped"]],
        "warnings": [
            *subject.mesh.health.warnings,
            *doubts_of_brdf(subject.brdf),
            *record["warnings"],
            *figures["warnings"],
            *left_out,
        ],
    }


def report(result: dict[str, Any]) -> str:
    if result["cancelled"]:
        return _cancel(result)
    size = size_text(result["size_bytes"])
    share = result["visibility_s"] / result["bake_s"] if result["bake_s"] > 0.0 else 0.0
    lines = [
        f"{result['output']}: {result['knobs']['mode']}, {result['vertices']:,} vertices, {size}, "
        f"{time_text(result['bake_s'])}, {percent(share)} of it for visibility",
        *_lines(result),
        *([] if result["check"] is None else lines_of_check(BakeCheck.model_validate(result["check"]))),
    ]
    if result["chunks_resumed"]:
        lines.append(f"{result['chunks_resumed']} of {result['chunks']} chunks were kept from the cancelled bake")
    return "\n".join([*lines, *result["skipped"]])


def _lines(result: dict[str, Any]) -> list[str]:
    """The lines of the summary that only the method of this bake adds."""
    mode = result["knobs"]["mode"]
    return bake_auto.lines(result) if mode == AUTO else transport.method_of(mode).baking.lines(result)


def _cancel(result: dict[str, Any]) -> str:
    if result["unfinished"] is None:
        return SENTENCE
    left, size = result["unfinished"], size_text(result["unfinished_bytes"])
    return f"Cancelled; the same command goes on from here, with {left} ({size}), which --restart discards."


def _check(arguments: argparse.Namespace) -> None:
    """UsageError where an option is given that belongs to another mode, or an address is none."""
    mode = arguments.mode
    if mode != AUTO:
        for flag in bake_auto.list_given(arguments):
            raise UsageError(f"{flag} needs --mode {AUTO}")
    for flag, modes in strange_options(arguments, _settings, mode):
        if mode != AUTO:
            raise UsageError(f"{flag} needs --mode {modes}")
        if flag not in bake_auto.SHARED:
            has_all = len(options(_settings)[flag]) == len(transport.METHODS)
            raise UsageError(f"{flag} is not for --mode {AUTO}" if has_all else f"{flag} needs --mode {modes}")
    if mode != AUTO:
        _check_method(arguments, transport.method_of(mode))

    refuse_plain_cluster(arguments)


def _check_method(arguments: argparse.Namespace, method: Method) -> None:
    if arguments.vary and not method.variations:
        raise UsageError(f"--vary is not for --mode {method.name}, which is baked for one BRDF")
