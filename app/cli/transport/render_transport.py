"""`lightarc render` of a transport file: any light and any view of what `lightarc bake` made."""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.options import settings_from
from app.arguments.results import software
from app.cli.doubts import doubts_of_light, doubts_of_scene
from app.cli.transport import render_textured, render_turntable
from app.cli.transport.method_options import add_options, strange_options
from app.cli.transport.options import light_of, near_lamp_argument
from app.cli.transport.render_output import ON_CPU, check_background, off_screen, record_of, teach_relit
from app.commands.images import write_image
from app.document.bake_request import bake, choices_for, make_request
from app.document.bake_request import estimate as estimate_bake
from app.document.variation import light_with, select_shown
from app.project.bakes import keep
from app.project.project_file import data_folder
from app.session.cache import visibility_folder
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import percent
from engine.core.steps import Step, drain, part
from engine.core.stopwatch import read_clock
from engine.factor.factor_file import open_reflectance
from engine.geometry.camera import parse
from engine.geometry.shapes import SHAPES
from engine.gl.draw import relight_off_screen
from engine.light.environment_file import open_environment
from engine.render.background import in_front_of
from engine.render.transported import image_of
from engine.render.turntable import middle
from engine.scene.mode import DIRECT, REFERENCE
from engine.scene.scene import brdfs_of_parts
from engine.storage.readers import suffixes
from engine.transport import method as transport
from engine.transport.baking.check import NOT_COMPARED, warnings_at_render
from engine.transport.baking.file import SUFFIX, holds_transport, open_transport
from engine.transport.method import Method
from engine.transport.relight import light_of as light_of_scene
from engine.transport.reuse import Reused, with_brdf

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from app.project.setup import Setup
    from engine.geometry.camera import Camera
    from engine.render.display import Display
    from engine.transport.baking.file import TransportFile
    from engine.transport.relight import Illuminated, Light, RelightTransport


def is_baked(arguments: argparse.Namespace) -> bool:
    """True if the image is one of baked transport: by its mode, or by the file to draw."""
    looks_baked = holds_transport(arguments.mesh) or arguments.mesh.lower().endswith(SUFFIX)
    return arguments.mode in transport.names() or (arguments.mode is None and looks_baked)


def run(arguments: argparse.Namespace, display: Display, show: Callable[[Step], None]) -> dict[str, Any]:
    _check(arguments)
    started = time.perf_counter()
    _check_baked(arguments.mesh, arguments.mode)
    file = open_transport(arguments.mesh)
    mode = arguments.mode or file.kind
    if mode not in transport.names():
        raise UsageError(f"{arguments.mesh} holds transport of the mode {mode}, which cannot be drawn")
    method = transport.method_of(mode)
    check_absent(arguments, mode)
    asked = settings_from(arguments, method.light)
    light = light_of(arguments)
    behind = check_background(arguments, light.environment)
    other, reused = arguments.brdf, None
    if other is not None and _is_part_of_bake(file, method):
        tested = light.environment or open_environment(UNLIT)
        steps_to_it = with_brdf(file, open_reflectance(other), visibility_folder(), tested)
        reused = drain(part(steps_to_it, 0.0, 0.2), show)
        file, arguments.brdf = reused.file, None
    steps = method.baking.illuminate(file, light, asked, arguments.brdf)
    found: Illuminated = drain(part(steps, 0.2, 0.3), show)
    relit: RelightTransport = found.relit
    model = relit.mesh.positions[: relit.transport.ground_vertex]
    camera = parse(arguments.camera or "", render_turntable.frame_turntable(model, arguments))
    scene, brdf, doubts = None, None, list[str]()
    if arguments.material is not None:
        scene = render_textured.scene_of_bake(file, relit, light, camera, arguments)
        brdf, doubts = render_textured.brdf_of_bake(file, arguments)
    unchecked = [] if reused is not None else _list_unchecked(file, other)
    if arguments.turntable:
        textured = None if scene is None else (scene, brdf)
        made = render_turntable.run_baked(
            file, method, light, asked, camera, middle(model), arguments, display, show, behind, textured
        )
        facts = {**_describe_error(reused), "skipped": unchecked}
        return {**made, **facts, "warnings": [*made["warnings"], *doubts]}
    image, drawn = _draw(relit, camera, arguments, show)
    negative_rel = drawn.pop("negative_rel", None)
    negative_rel = found.negative_rel(camera.eye) if negative_rel is None else negative_rel
    if scene is not None:
        drawn["warnings"] += doubts
        reflects = bool(file.settings.get("bounces") or file.settings.get("indirect"))
        image, drawn = render_textured.with_texels((image, drawn), scene, arguments, show, brdf, reflects=reflects)
    shown = image if behind is None else in_front_of(image, camera, behind, light.rotation, light.factor)
    write_image(arguments.output, shown, display, None, arguments.background, software("render"))
    return {
        "image": arguments.output,
        "mode": mode,
        "vertices": len(relit.mesh.positions),
        **found.figures,
        **_describe_error(reused),
        **drawn,
        "negative_rel": negative_rel,
        **record_of(image),
        "skipped": unchecked,
        "warnings": [
            *doubts_of_light(light.environment),
            *found.warnings,
            *_differences(file, light, other),
            *drawn["warnings"],
            *_negative(negative_rel, found.remedy),
        ],
        "time_s": time.perf_counter() - started,
    }


def run_project(
    setup: Setup, arguments: argparse.Namespace, display: Display, show: Callable[[Step], None]
) -> dict[str, Any]:
    """The image of a project in a baked mode: of the bake that lies beside it, or of one with the settings that the
    user chose, which is gone afterwards."""
    if arguments.measure_error:
        raise UsageError("--measure-error needs chosen directions; baked transport uses the whole environment")
    if arguments.turntable:
        raise UsageError("--turntable of a baked mode needs a transport file; make one with lightarc bake")
    scene = setup.scene
    if scene.near_lamps:
        _check_near_lamps(arguments.mode)
    behind = check_background(arguments, scene.environment)
    started = time.perf_counter()
    choices = choices_for(arguments.mode, **setup.project.bakes.get(arguments.mode, {}))
    varied = setup.project.variations
    parts = brdfs_of_parts(scene.mesh, scene.material)
    wanted = make_request(scene.mesh, scene.ground, scene.brdf, choices, None, varied, parts)
    found = keep(wanted, data_folder(setup.path))
    with tempfile.TemporaryDirectory() as folder:
        if found is None:
            estimate = drain(part(estimate_bake(wanted), 0.0, 0.1), show)
            if estimate.why_not:
                raise UsageError(estimate.why_not)
            own = () if scene.environment is None else (scene.environment,)
            made = drain(part(bake(Path(folder) / "scene.transport", estimate, own), 0.1, 0.8), show)
        else:
            made = found
        asked = light_with(choices.light, select_shown(choices.method, scene.brdf, varied))
        relighting = made.relighter(light_of_scene(scene), asked, scene.brdf)
        relit = drain(part(relighting, 0.8, 0.9), show)
        baked_image = _draw(relit, scene.camera, arguments, show)
    reflects = bool(getattr(choices.settings, "interreflection", False))
    image, drawn = render_textured.with_texels(baked_image, scene, arguments, show, reflects=reflects)
    shown = render_turntable.with_background(image, scene, behind)
    write_image(arguments.output, shown, display, None, arguments.background, software("render"))
    return {
        "image": arguments.output,
        "mode": arguments.mode,
        "vertices": len(relit.mesh.positions),
        "bake_s": made.bake_s,
        "baked_before": found is not None,
        **drawn,
        **record_of(image),
        "skipped": _say_unchecked() if made.check is None else [],
        "warnings": [*doubts_of_scene(scene), *made.differences(scene), *drawn["warnings"]],
        "time_s": time.perf_counter() - started,
    }


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of all methods."""
    parser.add_argument(
        "--near-lamp",
        type=near_lamp_argument,
        action="append",
        default=[],
        metavar="TEXT",
        help="one more light, near the model and in its coordinates; can be given several times: "
        "x=1,y=2,z=0.5,radius=0.1,power=40,colour=1:0.8:0.6, a sphere of irradiance power / (4 π d²) at the distance "
        "d; shape=rectangle,x=0,y=2,z=0,width=1,height=0.5,facing_theta_deg=180,facing_phi_deg=0,rotation_deg=0,"
        "power=10 shines to one side (180: down) with irradiance power / (π d²) straight ahead; shape=disc has a "
        f"radius. Of baked modes {_names_with('near_light')} shows it",
    )
    add_options(parser, _light)


def _light(method: Method) -> type[Any]:
    return method.light


def _names_with(attribute: str) -> str:
    return " or ".join(method.name for method in transport.methods_with(attribute))


def check_absent(arguments: argparse.Namespace, mode: str | None = None) -> None:
    """UsageError where an option is given that belongs to another mode than `mode`, or to any where that is None."""
    if arguments.near_lamp and mode:
        _check_near_lamps(mode)
    for flag, modes in strange_options(arguments, _light, mode):
        raise UsageError(f"{flag} is for bakes of --mode {modes}")


def _check_near_lamps(mode: str) -> None:
    """UsageError for lights near the model in a baked mode that leaves them out."""
    if not transport.method_of(mode).near_light:
        others = ", ".join((*(method.name for method in transport.methods_with("near_light")), DIRECT.name))
        raise UsageError(
            f"--mode {mode} shows no --near-lamp; choose --mode {others} or {REFERENCE.name}, or a distant --lamp"
        )


def _is_part_of_bake(file: TransportFile, method: Method) -> bool:
    """True if another BRDF takes another transport."""
    return not method.takes_brdf or bool(method.baking.why_baked_for_one(method.baking.transport_of(file)))


def _describe_error(reused: Reused | None) -> dict[str, Any]:
    """The error of transport that was made for another BRDF."""
    return {} if reused is None else reused.error


def _check(arguments: argparse.Namespace) -> None:
    if arguments.layers:
        raise UsageError("--layers are those of a model; a transport file has no BRDF to take an albedo of")
    if arguments.ground is not None:
        raise UsageError("--ground is part of the bake; bake again with another")
    if arguments.orient is not None:
        raise UsageError("--orient is part of the bake; bake again with another")
    if arguments.brushing is not None:
        raise UsageError("--brushing is part of the bake; bake again with another")
    if arguments.measure_error:
        raise UsageError("--measure-error needs chosen directions; baked transport uses the whole environment")


def _check_baked(mesh: str, mode: str) -> None:
    """InputError, with the way to bake, where `mesh` is a model in place of what was baked."""
    is_model = mesh in SHAPES or (Path(mesh).is_file() and mesh.lower().endswith(suffixes("mesh")))
    if holds_transport(mesh) or not is_model:
        return
    command = f"lightarc bake {mesh} --brdf TEXT --mode {mode} -o {Path(mesh).stem}{SUFFIX}"
    raise InputError(
        mesh, f"is not a transport file, which --mode {mode} draws", f"Make one of a model with: {command}"
    )


#: Environment that the error of transport for another BRDF is measured under if there is no other.
UNLIT = "studio"

#: An image (height, width, 4), and how it was made: frame_s, gl_renderer, warnings, perhaps negative_rel.
Drawn = tuple["NDArray[np.float32]", dict[str, Any]]


def _draw(
    relit: RelightTransport, camera: Camera, arguments: argparse.Namespace, show: Callable[[Step], None]
) -> Drawn:
    size = (arguments.width, arguments.height)
    warnings: list[str] = []
    since = read_clock()
    drawn = off_screen(
        arguments.renderer,
        lambda context: relight_off_screen(context, relit, camera, size, arguments.samples),
        warnings,
    )
    if drawn is not None:
        teach_relit(relit, camera, arguments, drawn[1]["frame_s"], since, drawn[1]["gl_renderer"])
        return drawn
    since, start = read_clock(), time.perf_counter()
    found = drain(part(image_of(relit, camera, size, arguments.samples), 0.3, 1.0), show)
    frame_s = time.perf_counter() - start
    teach_relit(relit, camera, arguments, frame_s, since)
    return found.image, {
        "frame_s": frame_s,
        "gl_renderer": ON_CPU,
        "warnings": warnings,
        "negative_rel": found.negative_rel,
    }


def _list_unchecked(file: TransportFile, other: str | None) -> list[str]:
    """Return the sentence that this bake, or the BRDF in place of its own, was not compared with the reference."""
    if file.check is not None and other is None:
        return []
    return _say_unchecked(" with this BRDF" if other is not None else "")


def _say_unchecked(end: str = "") -> list[str]:
    return [f"{NOT_COMPARED[:1].upper()}{NOT_COMPARED[1:]}{end}."]


def _differences(file: TransportFile, light: Light, other: str | None) -> list[str]:
    """Return what the check of the bake says of this light; nothing of another BRDF, which was not checked."""
    name = None if light.environment is None else light.environment.name
    return [] if other is not None else warnings_at_render(file.check, file.kind, name)


def _negative(negative_rel: float, remedy: str) -> list[str]:
    if negative_rel < 0.01:
        return []
    return [f"Sums below 0 were taken as 0, which adds {percent(negative_rel, 3)} to the light; {remedy}."]
