"""`lightarc render` of a transport file: any light and any view of what `lightarc bake` made."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from app.verbs import render_sh
from engine.steps import Step, drain

if TYPE_CHECKING:
    from engine.render.display import Display
    from engine.transport.wavelet_lighting import Lighting

#: Modes of `lightarc render` that draw a transport file.
BAKED = ("wavelet", "sh")


def is_baked(arguments: argparse.Namespace) -> bool:
    """Whether the picture is one of baked transport: by its mode, or by what is to be drawn."""
    from engine.transport.transport_file import holds_transport

    return arguments.mode in BAKED or (arguments.mode is None and holds_transport(arguments.mesh))


def run(arguments: argparse.Namespace, display: Display, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import usage
    from app.verbs.render import _write
    from engine.camera import frame, parse
    from engine.colour import luminance
    from engine.render.transported import transported
    from engine.transport.transport_file import open_transport
    from engine.transport.wavelet_bake import transport_of
    from engine.transport.wavelet_lighting import tuples

    usage(_check, arguments)
    started = time.perf_counter()
    file = open_transport(arguments.mesh)
    if (arguments.mode or file.kind) == "sh":
        return render_sh.run(file, arguments, display, show)
    usage(_check_wavelet, arguments)
    transport = transport_of(file)
    model = transport.mesh.positions[: transport.ground_vertex]
    camera = usage(parse, arguments.camera or "", frame(model, arguments.width / arguments.height))
    lighting, light_s = _timed(lambda: _lighting(arguments, transport.edge))
    rows, relight_s = _timed(lambda: tuples(transport, lighting))
    size = (arguments.width, arguments.height)
    found, frame_s = _timed(lambda: drain(transported(transport, rows, camera, size, arguments.samples), show))
    _write(arguments.output, found.picture, {}, display)
    return {
        "image": arguments.output,
        "width_px": arguments.width,
        "height_px": arguments.height,
        "mode": "wavelet",
        "brdf": transport.factors.name,
        "vertices": len(transport.mesh.positions),
        "terms": transport.factors.terms,
        "cube": transport.edge,
        "light_coefficients": lighting.light.kept,
        "light_rmse_rel": lighting.light.rmse_rel,
        "sky_energy_error_rel": lighting.light.energy_error_rel,
        "directional_lights": len(lighting.directional.direction),
        "light_s": light_s,
        "relight_s": relight_s,
        "frame_s": frame_s,
        "gl_renderer": "none (drawn on the processor)",
        "negative_rel": found.negative_rel,
        "mean_radiance": float(luminance(found.picture[..., :3].astype("f8")).mean()),
        "covered_fraction": float(found.picture[..., 3].mean(dtype="f8")),
        "warnings": _warnings(found.negative_rel),
        "time_s": time.perf_counter() - started,
    }


def _check(arguments: argparse.Namespace) -> None:
    given = {"--material": arguments.material, "--ground": arguments.ground}
    for name, value in given.items():
        if value is not None:
            raise ValueError(f"{name} is part of what was baked; bake again with another")
    if arguments.renderer == "gl":
        raise ValueError("--renderer gl cannot draw baked transport yet; leave it out")
    if arguments.measure_error:
        raise ValueError("--measure-error compares directions of an environment, which baked transport has all")


def _check_wavelet(arguments: argparse.Namespace) -> None:
    if arguments.brdf is not None:
        raise ValueError("--brdf is part of what was baked; bake again with another")
    if arguments.window != "none":
        raise ValueError("--window is for the mode sh")


def _lighting(arguments: argparse.Namespace, edge: int) -> Lighting:
    from app.cli import usage
    from app.verbs.render import LIGHT_DEG
    from engine.directions import world_direction
    from engine.environment_file import open_environment
    from engine.lamps import Lamp
    from engine.transport.wavelet_lighting import dark, lighting_of

    lamps = tuple(arguments.lamp)
    if arguments.env:
        rotation = math.radians(arguments.env_rotation_deg)
        environment = open_environment(arguments.env)
        options = {"rotation": rotation, "factor": arguments.intensity, "lamps": lamps}
        lighting: Lighting = usage(lambda: lighting_of(environment, edge, **options))
        return lighting
    if arguments.light_deg is not None or not lamps:
        x, y, z = world_direction(*map(math.radians, arguments.light_deg or LIGHT_DEG))
        lamps = (usage(Lamp, (x, y, z), (arguments.intensity,) * 3), *lamps)
    return dark(edge, lamps)


def _timed(work: Callable[[], Any]) -> tuple[Any, float]:
    started = time.perf_counter()
    return work(), time.perf_counter() - started


def _warnings(negative_rel: float) -> list[str]:
    if negative_rel < 0.01:
        return []
    return [
        f"Sums below 0 were taken as 0, which adds {100.0 * negative_rel:.1f} % to the light; bake with more terms."
    ]
