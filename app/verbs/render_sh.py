"""`lightarc render` of transport in spherical harmonics."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from app.verbs.lights import Illuminated, Light, near_lamp_argument
from engine.steps import Step, drain, part

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.camera import Vector
    from engine.transport.sh_transfer import ShTransport
    from engine.transport.transport_file import TransportFile


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--window",
        default="none",
        choices=("none", "hanning", "lanczos"),
        help="sh: damp high bands against ringing, at the price of blurred light (none)",
    )
    parser.add_argument(
        "--near-lamp",
        type=near_lamp_argument,
        action="append",
        default=[],
        metavar="TEXT",
        help="sh: a sphere that shines near the model, in its own coordinates; can be given several times: "
        "x=1,y=2,z=0.5,radius=0.1,power=40,colour=1:0.8:0.6, of irradiance power / (4 π d²) at the distance d",
    )
    parser.add_argument(
        "--near-points",
        type=int,
        metavar="N",
        help="sh: points along the longest side of the grid at which light of near lamps is found, 1 to 33; between "
        "them it is interpolated (as many as keep the error below 1 %%)",
    )
    parser.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="PARAMETER=FROM:TO:SOURCE",
        help="sh: let a parameter of the reflectance vary over the model, as in lightarc bake; twice at most",
    )


def check_absent(arguments: argparse.Namespace) -> None:
    """ValueError where something is given that other modes do not have."""
    given = {"--near-lamp": arguments.near_lamp, "--near-points": arguments.near_points, "--vary": arguments.vary}
    for name, value in given.items():
        if value:
            raise ValueError(f"{name} is for what was baked with --mode sh; --lamp is a light far away")


def illuminate(
    file: TransportFile, arguments: argparse.Namespace, light: Light, show: Callable[[Step], None]
) -> Illuminated:
    """What the rows of `file`, with the reflectance of --brdf and --vary where they are given, make of `light`."""
    from engine.transport.lit import LitHarmonics
    from engine.transport.sh import window, windowed
    from engine.transport.sh_bake import transport_of
    from engine.transport.sh_transfer import transferred

    transport = transport_of(file)
    brdf = arguments.brdf or str(file.settings["brdf"])
    if arguments.brdf or arguments.vary:
        transport = _with_brdf(transport, brdf, arguments.vary, show)
    before = time.perf_counter()
    coefficients = windowed(_coefficients(light, transport.order), arguments.window)
    nearby, figures = _nearby(transport, light, arguments.near_points)
    if nearby is not None:
        coefficients = coefficients + nearby * window(transport.order, arguments.window)[:, None]
    projected = time.perf_counter()
    rows = transferred(transport, coefficients)
    figures |= {
        "brdf": brdf,
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
        _warnings(figures),
    )


def _nearby(
    transport: ShTransport, light: Light, points: int | None
) -> tuple[NDArray[np.float32] | None, dict[str, Any]]:
    """(V, order², 3) of near lamps, and how they were found: by a grid about the model and one on the ground."""
    import numpy as np

    from app.cli import WrongUsage, usage
    from engine.transport.sh_near_light import near_light

    if not light.near_lamps:
        if points is not None:
            raise WrongUsage("--near-points needs --near-lamp.")
        return None, {}
    places, first = transport.mesh.positions, transport.ground_vertex
    found = [
        usage(near_light, light.near_lamps, some, transport.order, points) for some in (places[:first], places[first:])
    ]
    counts = [some.points for some in found if len(some.coefficients)]
    figures = {"near_points": counts, "near_error_rel": max(some.error_rel for some in found)}
    return np.concatenate([some.coefficients for some in found]), figures


def _warnings(figures: dict[str, Any]) -> tuple[str, ...]:
    from engine.transport.sh_near_light import TOLERANCE

    error = figures.get("near_error_rel", 0.0)
    if error <= 1.5 * TOLERANCE:
        return ()
    return (f"Between the points where it was found, the light of near lamps is off by {100.0 * error:.1f} % RMS.",)


def _with_brdf(transport: ShTransport, text: str, varied: Sequence[str], show: Callable[[Step], None]) -> ShTransport:
    from app.cli import WrongUsage, usage
    from engine.factor.factor_file import open_reflectance
    from engine.transport.sh_transfer import with_table
    from engine.transport.sh_varied import table_of
    from engine.transport.variation import variation_from_text

    variations = usage(lambda: [variation_from_text(one) for one in varied])
    making = table_of(
        usage(open_reflectance, text), transport.order, variations, transport.mesh, transport.ground_vertex
    )
    table = usage(drain, part(making, 0.0, 0.3), show)
    try:
        return with_table(transport, table)
    except ValueError as reason:
        raise WrongUsage(f"The reflectance cannot be changed without another bake: {reason}.") from None


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
