"""`lightarc render` of transport in spherical harmonics."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from app.verbs.lights import Illuminated, Light
from engine.steps import Step, drain, part

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.camera import Vector
    from engine.transport.sh_transfer import ShTransport
    from engine.transport.transport_file import TransportFile


def illuminate(
    file: TransportFile, arguments: argparse.Namespace, light: Light, show: Callable[[Step], None]
) -> Illuminated:
    """What the rows of `file`, with the reflectance of --brdf where one is given, make of `light`."""
    from engine.transport.lit import LitHarmonics
    from engine.transport.sh import windowed
    from engine.transport.sh_bake import transport_of
    from engine.transport.sh_transfer import transferred

    transport = transport_of(file)
    if arguments.brdf:
        transport = _with_brdf(transport, arguments.brdf, show)
    before = time.perf_counter()
    coefficients = windowed(_coefficients(light, transport.order), arguments.window)
    projected = time.perf_counter()
    rows = transferred(transport, coefficients)
    figures = {
        "brdf": arguments.brdf or file.settings["brdf"],
        "order": transport.order,
        "interreflection": transport.interreflection,
        "table_error_rel": transport.table.error_rel,
        "light_s": projected - before,
        "relight_s": time.perf_counter() - projected,
    }
    return Illuminated(
        LitHarmonics(transport, rows),
        figures,
        lambda eye: _negative_rel(transport, rows, eye),
        "a higher order or --window rings less",
    )


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


def _coefficients(light: Light, order: int) -> NDArray[np.float64]:
    """(order², 3) of all that shines: a turned environment, and lamps in closed form."""
    import numpy as np

    from engine.transport.sh_lighting import lamp_coefficients, project, turned_about_y

    total = np.zeros((order**2, 3))
    if light.environment is not None:
        total += light.factor * turned_about_y(project(light.environment, order), light.rotation)
    return np.asarray(total + sum(lamp_coefficients(lamp, order) for lamp in light.lamps))


def _negative_rel(transport: ShTransport, rows: NDArray[np.float32], eye: Vector) -> float:
    """How much of the vertices' radiance towards `eye` is below 0, over what is not."""
    import numpy as np

    from engine.transport.sh_transfer import local_views, signed_radiance

    everything = np.arange(len(transport.mesh.positions))
    signed = signed_radiance(transport, rows, local_views(transport, eye), everything)
    kept = float(np.maximum(signed, 0.0).sum())
    return float(np.maximum(-signed, 0.0).sum()) / kept if kept > 0.0 else 0.0
