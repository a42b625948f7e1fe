"""`lightarc render` of transport in spherical harmonics."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from engine.steps import Step, drain, part

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.render.display import Display
    from engine.transport.sh_transfer import ShTransport
    from engine.transport.transport_file import TransportFile


def run(
    file: TransportFile, arguments: argparse.Namespace, display: Display, show: Callable[[Step], None]
) -> dict[str, Any]:
    from app.cli import usage
    from app.verbs.render import _write
    from engine.camera import frame, parse
    from engine.colour import luminance
    from engine.render.transported import transported
    from engine.transport.sh_bake import transport_of
    from engine.transport.sh_transfer import transferred

    started = time.perf_counter()
    transport = transport_of(file)
    brdf = arguments.brdf or file.settings["brdf"]
    if arguments.brdf:
        transport = _with_brdf(transport, arguments.brdf, show)
    model = transport.mesh.positions[: transport.ground_vertex]
    camera = usage(parse, arguments.camera or "", frame(model, arguments.width / arguments.height))
    before = time.perf_counter()
    light = _light(arguments, transport.order)
    projected = time.perf_counter()
    rows = transferred(transport, light)
    transferred_at = time.perf_counter()
    size = (arguments.width, arguments.height)
    found = drain(part(transported(transport, rows, camera, size, arguments.samples), 0.3, 1.0), show)
    frame_s = time.perf_counter() - transferred_at
    _write(arguments.output, found.picture, {}, display)
    return {
        "image": arguments.output,
        "width_px": arguments.width,
        "height_px": arguments.height,
        "mode": "sh",
        "brdf": brdf,
        "vertices": len(transport.mesh.positions),
        "order": transport.order,
        "interreflection": transport.interreflection,
        "table_error_rel": transport.table.error_rel,
        "light_s": projected - before,
        "relight_s": transferred_at - projected,
        "frame_s": frame_s,
        "gl_renderer": "none (drawn on the processor)",
        "negative_rel": found.negative_rel,
        "mean_radiance": float(luminance(found.picture[..., :3].astype("f8")).mean()),
        "covered_fraction": float(found.picture[..., 3].mean(dtype="f8")),
        "warnings": _warnings(found.negative_rel),
        "time_s": time.perf_counter() - started,
    }


def _with_brdf(transport: ShTransport, text: str, show: Callable[[Step], None]) -> ShTransport:
    from app.cli import usage
    from engine.factor.factor_file import open_reflectance
    from engine.transport.sh_table import tabulate
    from engine.transport.sh_transfer import with_table

    table = drain(part(tabulate(usage(open_reflectance, text), transport.order), 0.0, 0.3), show)
    try:
        return with_table(transport, table)
    except ValueError as reason:
        problem = f"--brdf cannot be changed without another bake: {reason}"
        refused: ShTransport = usage(_refuse, problem)
        return refused


def _refuse(problem: str) -> None:
    raise ValueError(problem)


def _light(arguments: argparse.Namespace, order: int) -> NDArray[np.float64]:
    """The coefficients (order², 3) of all that shines: a turned environment or a light, and lamps in closed form."""
    import numpy as np

    from app.cli import usage
    from app.verbs.render import LIGHT_DEG
    from engine.directions import world_direction
    from engine.environment_file import open_environment
    from engine.lamps import Lamp
    from engine.transport.sh import windowed
    from engine.transport.sh_lighting import lamp_coefficients, project, turned_about_y

    lamps = list(arguments.lamp)
    total = np.zeros((order**2, 3))
    if not (math.isfinite(arguments.intensity) and arguments.intensity >= 0.0):
        usage(_refuse, f"--intensity {arguments.intensity} is not a number from 0")
    if arguments.env:
        environment = open_environment(arguments.env)
        around = turned_about_y(project(environment, order), math.radians(arguments.env_rotation_deg))
        total += arguments.intensity * around
    elif arguments.light_deg is not None or not lamps:
        x, y, z = world_direction(*map(math.radians, arguments.light_deg or LIGHT_DEG))
        lamps.append(usage(Lamp, (x, y, z), (arguments.intensity,) * 3))
    return windowed(total + sum(lamp_coefficients(lamp, order) for lamp in lamps), arguments.window)


def _warnings(negative_rel: float) -> list[str]:
    if negative_rel < 0.01:
        return []
    share = f"{100.0 * negative_rel:.1f} %"
    return [f"Sums below 0 were taken as 0, which adds {share} to the light; a higher order or --window rings less."]
