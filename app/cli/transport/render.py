"""`lightarc render`: an image of a material on a model, off screen, through the same GL code as the window."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from app.arguments.options import add_search, refuse_unused
from app.arguments.quantities import Degrees
from app.arguments.results import Input, Output, software
from app.cli.doubts import doubts_of_scene, mean_in_place_of_maps, means_of_parts
from app.cli.transport import project_input, render_auto, render_transport, render_turntable, scene_options
from app.cli.transport.options import lamp_argument
from app.cli.transport.render_output import (
    ON_CPU,
    add_background_arguments,
    check_background,
    check_memory,
    join,
    lights_of,
    off_screen,
    record_of,
    teach,
)
from app.commands.images import write_image
from engine.brdf.brdf import MODELS
from engine.core.errors import UsageError
from engine.core.figure_text import percent, time_text
from engine.core.steps import Step, drain
from engine.core.stopwatch import read_clock
from engine.factor.factor_file import open_reflectance
from engine.geometry.camera import parse
from engine.gl.brdf_textures import factor_source
from engine.gl.draw import draw_off_screen
from engine.light.environment_file import open_environment
from engine.render.direct import radiance
from engine.render.display import Display
from engine.render.environment_error import environment_error
from engine.render.layers import layers as all_layers
from engine.render.path import check_scene
from engine.render.reference import reference
from engine.scene.material import set_multiple_scattering
from engine.scene.mode import DIRECT, MODES, REFERENCE, is_traced
from engine.scene.scene import TILING_MODES, Scene, make_scene
from engine.scene.settings import DEFAULTS as scene_defaults
from engine.transport import method as transport
from engine.transport.baking.radiance_error import error_lines

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from app.project.setup import Setup
    from engine.scene.material import Material

EXAMPLE = "lightarc render cloth --brdf phong:exponent=20 --light-deg 45,30 -o cloth.png"

#: Most pixels of an image; its linear radiance takes 16 bytes for each.
MAX_PIXELS = 2**28

#: Samples of a pixel unless something else is said, and the most of them: sub-pixels along a side, and paths.
SUB_PIXELS, MAX_SUB_PIXELS = 2, 16
PATHS, MAX_PATHS = 64, 2**20

#: Values of the options of a model unless something else is said; a project says them itself.
DEFAULTS = {
    "intensity": scene_defaults.irradiance,
    "env_rotation_deg": scene_defaults.environment_rotation_deg,
    "directions": 64,
    "source": "slices",
    "lookup": "radiance",
    "above": "clamp",
    "tile": scene_defaults.repeats,
    "tiling_mode": "grid",
    "exposure": 0.0,
    "tone_map": "neutral",
}

#: Most points of the surface that a path may touch.
MAX_DEPTH = 1000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    scene_options.add_mesh(parser)
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Output(render_turntable.output_at),
        metavar="IMAGE",
        help=".png (tone-mapped) or .exr (radiance); with --turntable .mp4, .webp or a folder of PNG",
    )
    parser.add_argument(
        "--material",
        type=Input(),
        metavar="MATERIAL",
        help=f"{scene_options.MATERIAL_HELP}; without it the BRDF alone is shown. On a bake it shows its "
        "texels in the light that the bake lets through",
    )
    add_search(parser)
    parser.add_argument(
        "--brdf",
        type=Input(),
        metavar="TEXT",
        help="BRDF: phong:exponent=20, a measured file or factors; otherwise the material's own; of a "
        "bake, another one, made from the visibility that is kept on this machine",
    )
    parser.add_argument(
        "--light-deg",
        type=Degrees(2),
        metavar="THETA,PHI",
        help="direction of the light in the world: THETA from +Y (up), PHI from +Z (the viewer's side of the plane) "
        "towards +X (right); 90,0 shines along -Z (50,30; none if a --lamp or --near-lamp is given)",
    )
    parser.add_argument("--intensity", type=float, metavar="L", help="irradiance of the light, or factor on --env (1)")
    parser.add_argument(
        "--env",
        type=Input(reach="file"),
        metavar="FILE",
        help="environment in place of the light: an equirectangular .hdr, .exr or .pfm, ball:FILE or "
        "angular:FILE for a mirror ball or an angular map, or one of studio, sky, noon, "
        "afternoon, evening, sunset, overcast, softboxes, ring-light, strip-lights, window",
    )
    parser.add_argument(
        "--env-rotation-deg",
        type=Degrees(1, "90"),
        metavar="A",
        help="rotation of the environment about +Y, anticlockwise from above (0)",
    )
    parser.add_argument(
        "--lamp",
        type=lamp_argument,
        action="append",
        default=[],
        metavar="TEXT",
        help="one more light, beside --env or --light-deg; can be given several times: "
        "theta_deg=40,phi_deg=20,irradiance=2,radius_deg=5,colour=1:0.8:0.6, a disc of that angular radius, with 0 a "
        "directional light",
    )
    scene_options.add_ground(parser)
    scene_options.add_brushing(parser)
    parser.add_argument(
        "--single-scattering",
        action="store_true",
        help="draw PBR maps without the light that rough facets scatter more than once, as glTF's own formula has it",
    )
    parser.add_argument(
        "--directions",
        type=int,
        metavar="N",
        help="number of lights that represent the environment, and of points of a --near-lamp for other BRDFs than GGX "
        "(64)",
    )
    parser.add_argument(
        "--measure-error",
        action="store_true",
        help="measure the error against the sum over all directions; needs --env",
    )
    parser.add_argument(
        "--mode",
        choices=("auto", *MODES, *transport.names()),
        help="'direct' shows the material's BRDF alone, with the shadows of lamps and suns, and is the mode without "
        "--material; 'reference' traces paths, "
        "with shadows and the whole --env; "
        "'auto' takes of these two the one that the plan chooses; "
        f"{', '.join(transport.names())} draw a transport file of lightarc bake, given in place of the MESH",
    )
    render_auto.add_arguments(parser.add_argument_group("--mode auto"))
    render_turntable.add_arguments(parser)
    add_background_arguments(parser)
    render_transport.add_arguments(parser)
    parser.add_argument("--from", dest="source", choices=("slices", "power-law"))
    parser.add_argument("--lookup", choices=("radiance", "texture", "outgoing", "angle"))
    parser.add_argument("--above", choices=("clamp", "scale"), help="lookup beyond the brightest photograph (clamp)")
    parser.add_argument("--tile", type=float, metavar="N", help="repeats of the material over one uv (4)")
    parser.add_argument(
        "--tiling-mode",
        choices=TILING_MODES,
        help="how maps repeat: the same in a grid, or in hexagonal cells that all differ, without a visible "
        "period, which suits materials without a regular pattern (grid)",
    )
    parser.add_argument("--width", type=int, default=1024, metavar="PX", help="width of the image (1024)")
    parser.add_argument("--height", type=int, default=768, metavar="PX", help="height of the image (768)")
    parser.add_argument(
        "--camera",
        type=str,
        metavar="TEXT",
        help="'eye=0,0,4 target=0,0,0 up=0,1,0 fov_deg=35' in the mesh's own coordinates, vertical field of view; "
        "parts left out are chosen to frame the model",
    )
    parser.add_argument("--exposure", type=float, metavar="EV", help="exposure in stops (0)")
    parser.add_argument("--tone-map", choices=("neutral", "none", "aces"))
    parser.add_argument(
        "--samples",
        type=int,
        metavar="N",
        help="N × N sub-pixels, 1 = pixel centres (2); in the reference mode N random paths for each pixel (64)",
    )
    parser.add_argument(
        "--max-depth",
        type=int,
        default=1,
        metavar="D",
        help="reference: largest path depth: surface points on a path; 1 is direct light with shadows, more adds "
        "interreflection (1)",
    )
    parser.add_argument("--seed", type=int, metavar="S", help="reference: seed of the random numbers (0)")
    parser.add_argument(
        "--renderer",
        default="auto",
        choices=("auto", "gl", "cpu"),
        help="auto: OpenGL if present, otherwise the CPU",
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    doubts = scene_options.take_own_material(arguments)
    _refuse_unused(arguments)
    setup = _setup(arguments)
    found = _draw_scene(setup, arguments, show)
    doubts += project_input.list_left_out(setup, arguments.mode) if setup is not None else []
    return {**found, "warnings": [*found.get("warnings", ()), *doubts]} if doubts else found


def _refuse_unused(arguments: argparse.Namespace) -> None:
    """UsageError for an option that changes nothing in this image."""
    is_project, is_random = project_input.is_given(arguments), is_traced(arguments.mode)
    has_env = bool(arguments.env) or is_project
    may_have_own = Path(arguments.mesh).is_file()  # a model with materials
    has_material = arguments.material is not None or is_project or may_have_own
    rules = [
        ("--env-rotation-deg", has_env, "--env"),
        ("--directions", has_env or bool(arguments.near_lamp), "--env or --near-lamp"),
        ("--seed", is_random or is_project or arguments.mode == "auto", f"--mode {REFERENCE.name}"),
        *((flag, has_material, "--material") for flag in ("--from", "--lookup", "--above", "--tile", "--tiling-mode")),
    ]
    refuse_unused(argparse.Namespace(**{**vars(arguments), "from": arguments.source}), rules)
    if is_random and arguments.renderer == "gl":
        raise UsageError(f"--renderer gl is not for --mode {REFERENCE.name}, which is traced on the CPU")


def _draw_scene(setup: Setup | None, arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """Draw the scene of the arguments and write it; the record."""
    start = time.perf_counter()
    arguments.seed = arguments.seed or 0
    _check(arguments)
    render_turntable.check(arguments)
    display = Display(arguments.exposure, arguments.tone_map)
    if setup is not None and arguments.mode in transport.names():
        return render_transport.run_project(setup, arguments, display, show)
    if render_transport.is_baked(arguments):
        return render_transport.run(arguments, display, show)
    render_transport.check_absent(arguments)
    material = scene_options.material_of(setup, arguments)
    scene = setup.scene if setup is not None else _scene(arguments, material)
    by_mean: dict[str, Any] = {}
    mode = MODES.get(arguments.mode)
    if mode is not None and not mode.shows_texels and material is not None and material.pbr is not None:
        keeps_parts = scene.material is not None
        seen = replace(scene, material=material)
        by_mean = (
            {"warnings": means_of_parts([each.material for each in seen.parts if each.material is not None])}
            if keeps_parts
            else mean_in_place_of_maps(material, show)
        )
    plan: dict[str, Any] = {}
    if arguments.mode == "auto":
        scene, arguments, plan = render_auto.plan(scene, arguments, show)
        _check(arguments)
    behind = check_background(arguments, scene.environment)
    if arguments.turntable:
        return join({**plan, **render_turntable.run(scene, arguments, display, show, behind)}, by_mean)
    draw = _draw_reference if is_traced(arguments.mode) else _draw
    image, layers, drawn = draw(scene, arguments, show)
    if arguments.layers:
        layers |= drain(all_layers(scene, (arguments.width, arguments.height)), show)
    error = _error(scene, arguments, show) if arguments.measure_error else {}
    shown = render_turntable.with_background(image, scene, behind)
    write_image(arguments.output, shown, display, layers, arguments.background, software("render"))
    record = {
        "image": arguments.output,
        **plan,
        **drawn,
        **record_of(image),
        "sigma": scene.sigma,
        **_materials(scene),
        **lights_of(scene),
        **error,
        "time_s": time.perf_counter() - start,
    }
    return join(record, by_mean)


def _materials(scene: Scene) -> dict[str, Any]:
    """`materials`, the names of those of the parts of the model, where it has several."""
    parts = [each.material.name for each in scene.parts if each.material is not None]
    return {"materials": parts} if len(parts) > 1 else {}


def _setup(arguments: argparse.Namespace) -> Setup | None:
    """The project in the place of the model, whose mode and display hold where nothing else was asked for."""
    if not project_input.is_given(arguments):
        own = {name: value for name, value in DEFAULTS.items() if name != "tile"}  # which a bake by part says itself
        project_input.with_defaults(arguments, own if render_transport.is_baked(arguments) else DEFAULTS)
        return None
    setup = project_input.setup_of(arguments)
    look = setup.project.look
    project_input.with_defaults(
        arguments, {"mode": setup.mode, "exposure": look.exposure_ev, "tone_map": look.tone_map}
    )
    if _needs_map(arguments) and setup.scene.material is None:
        raise UsageError(f"--mode {arguments.mode} needs a project with a material")
    if arguments.mode == "auto":
        raise UsageError("--mode auto is for a model with a --brdf; a project has its mode")
    if arguments.measure_error:
        project_input.needs_environment(setup.scene, "--measure-error")
    return replace(setup, scene=_adapt(setup.scene, arguments))


def _needs_map(arguments: argparse.Namespace) -> bool:
    return arguments.mode in MODES and MODES[arguments.mode].needs_map


def _adapt(scene: Scene, arguments: argparse.Namespace) -> Scene:
    """The scene as the mode draws it, with the PBR maps that are asked for."""
    if arguments.single_scattering:
        if scene.material is None or scene.pbr is None:
            raise UsageError("--single-scattering needs a material of PBR maps")
        if scene.pbr.openpbr is not None:
            raise UsageError("--single-scattering is for PBR maps without layers: OpenPBR always scatters again")
        scene = replace(scene, material=set_multiple_scattering(scene.material, on=False))
    mode = arguments.mode or ("direct" if scene.material is None else "")
    return MODES[mode].adapt(scene) if mode in MODES else scene


def report(result: dict[str, Any]) -> str:
    return "\n".join([_line(result), *result.get("skipped", ())])


def _line(result: dict[str, Any]) -> str:
    """The image, its time, and what drew it."""
    if "frames" in result:
        return f"{result['image']}: {result['frames']} frames, {time_text(result['time_s'])}"
    if "noise" in result:
        noise = "unknown" if result["noise"] is None else percent(result["noise"])
        return f"{result['image']}: {result['samples']} samples, noise {noise}, {time_text(result['frame_s'])}"
    device = "the CPU" if result["gl_renderer"].startswith("none") else result["gl_renderer"]
    drawn = f"{result['image']}: {time_text(result['frame_s'])} a frame on {device}"
    return "\n".join([drawn, *(error_lines(result) if "error_env" in result else [])])


def _check(arguments: argparse.Namespace) -> None:
    if arguments.width < 1 or arguments.height < 1 or arguments.width * arguments.height > MAX_PIXELS:
        raise UsageError(f"an image of {arguments.width} × {arguments.height} pixels is not possible")
    render_auto.check(arguments)
    is_reference = is_traced(arguments.mode)
    if arguments.samples is None and arguments.mode != "auto":
        arguments.samples = PATHS if is_reference else SUB_PIXELS
    most = MAX_PATHS if is_reference else MAX_SUB_PIXELS
    if arguments.samples is not None and not 1 <= arguments.samples <= most:
        raise UsageError(f"--samples {arguments.samples} is outside 1 … {most}")
    if not 1 <= arguments.max_depth <= MAX_DEPTH:
        raise UsageError(f"--max-depth {arguments.max_depth} is outside 1 … {MAX_DEPTH}")
    if arguments.seed < 0:
        raise UsageError(f"--seed {arguments.seed} is negative")
    if arguments.max_depth > 1 and not is_reference:
        raise UsageError("--max-depth needs --mode reference")
    is_project = project_input.is_given(arguments)
    if arguments.measure_error and not arguments.env and not is_project:
        raise UsageError("--measure-error needs --env")
    if _needs_map(arguments) and not arguments.material and not is_project:
        raise UsageError(f"--mode {arguments.mode} needs --material")


def _scene(arguments: argparse.Namespace, material: Material | None) -> Scene:
    brdf = open_reflectance(arguments.brdf) if arguments.brdf else None
    if brdf is not None and material is not None and material.pbr is not None:
        raise UsageError("PBR maps are a BRDF for each texel; --brdf is for a material that is looked up by one")
    mesh = scene_options.mesh_of(arguments)
    environment = open_environment(arguments.env) if arguments.env else None
    camera = parse(arguments.camera or "", render_turntable.frame_turntable(mesh.positions, arguments))
    scene = make_scene(
        mesh,
        camera,
        brdf=brdf,
        material=material,
        light_deg=arguments.light_deg,
        irradiance=arguments.intensity,
        environment=environment,
        environment_rotation_deg=arguments.env_rotation_deg,
        lamps=arguments.lamp,
        near_lamps=arguments.near_lamp,
        ground_albedo=arguments.ground,
        brushing=arguments.brushing,
        source=arguments.source,
        lookup=arguments.lookup,
        above=arguments.above,
        repeats=arguments.tile,
        tiling_mode=arguments.tiling_mode,
        directions=arguments.directions,
    )
    return _adapt(scene, arguments)


#: An image (height, width, 4), what is stored beside it (height, width, 3), and how it was made.
Drawn = tuple["NDArray[np.float32]", dict[str, "NDArray[np.float32]"], dict[str, Any]]


def _draw_reference(scene: Scene, arguments: argparse.Namespace, show: Callable[[Step], None]) -> Drawn:
    """The reference, its standard error, and its figures."""
    size = (arguments.width, arguments.height)
    check_memory(size)
    check_scene(scene)
    since, start = read_clock(), time.perf_counter()
    options = {"samples": arguments.samples, "max_depth": arguments.max_depth, "seed": arguments.seed}
    found = drain(reference(scene, size, **options), show)
    frame_s = time.perf_counter() - start
    teach(scene, arguments, REFERENCE.name, frame_s, since)
    warnings = doubts_of_scene(scene)
    if found.rejected:
        warnings.append(f"{found.rejected} samples were not finite and count as black.")
    layers = {}
    if found.variance is not None:
        layers["standard_error"] = np.sqrt(found.variance).clip(0.0, np.finfo(np.float32).max).astype(np.float32)
    figures = {
        "frame_s": frame_s,
        "gl_renderer": ON_CPU,
        "warnings": warnings,
        **options,
        "passes": found.passes,
        "noise": found.uncertainty_rmse_rel,
        "uncertainty_rmse_rel": found.uncertainty_rmse_rel,
        "rejected_samples": found.rejected,
        "rays": found.rays,
        "rays_per_s": found.rays / frame_s,
    }
    return found.image, layers, figures


def _draw(scene: Scene, arguments: argparse.Namespace, show: Callable[[Step], None]) -> Drawn:
    """The image, and how it was made: frame_s, gl_renderer, warnings."""
    size = (arguments.width, arguments.height)
    warnings, renderer = doubts_of_scene(scene), arguments.renderer
    has_shader = type(scene.brdf) in MODELS.values() or factor_source(scene.brdf) is not None
    if renderer == "auto" and not scene.brdf.isotropic and not has_shader:
        renderer = "cpu"
        warnings.append("The measured BRDF is anisotropic and drawn on the CPU, which shows it exactly.")
    since = read_clock()
    drawn = off_screen(renderer, lambda context: draw_off_screen(context, scene, size, arguments.samples), warnings)
    if drawn is not None:
        teach(scene, arguments, DIRECT.name, drawn[1]["frame_s"], since, drawn[1]["gl_renderer"])
        return drawn[0], {}, drawn[1]
    since, start = read_clock(), time.perf_counter()
    image = drain(radiance(scene, size, samples=arguments.samples), show)
    frame_s = time.perf_counter() - start
    teach(scene, arguments, DIRECT.name, frame_s, since)
    return image, {}, {"frame_s": frame_s, "gl_renderer": ON_CPU, "warnings": warnings}


def _error(scene: Scene, arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """The error of the chosen directions against the sum over the whole map, on pixels of this view."""
    error = drain(environment_error(scene, (arguments.width, arguments.height)), show)
    return {
        "error_rmse_rel": error.rmse_rel,
        "error_pixels": error.pixels,
        "error_reference_width_texels": error.reference_size[0],
        "error_reference_height_texels": error.reference_size[1],
    }
