"""`lightarc render` of wavelet transport."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from app.verbs.lights import Illuminated, Light
from engine.steps import Step

if TYPE_CHECKING:
    from engine.transport.transport_file import TransportFile


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--weight",
        action="append",
        metavar="SOURCE",
        help="wavelet: of the second reflectance of a bake with --blend (again for the third), in place of what was "
        "baked: x, y, z or a picture",
    )
    parser.add_argument(
        "--albedo",
        metavar="IMAGE",
        help="wavelet: multiply what the model sends out by a picture at its texture coordinates, in place of what was "
        "baked",
    )


def check_absent(arguments: argparse.Namespace) -> None:
    """ValueError where something is given that other modes do not have."""
    for name, value in {"--weight": arguments.weight, "--albedo": arguments.albedo}.items():
        if value is not None:
            raise ValueError(f"{name} is for what was baked with --mode wavelet")


def illuminate(
    file: TransportFile, arguments: argparse.Namespace, light: Light, _show: Callable[[Step], None]
) -> Illuminated:
    """The K-tuples of `file` under `light`."""
    from app.cli import usage
    from engine.transport.lit import LitWavelets
    from engine.transport.wavelet import radiance_from, remixed
    from engine.transport.wavelet_bake import transport_of
    from engine.transport.wavelet_lighting import dark, lighting_of, tuples

    usage(_check, arguments)
    transport = transport_of(file)
    if arguments.weight is not None or arguments.albedo is not None:
        transport = usage(remixed, transport, arguments.weight, arguments.albedo)
    before = time.perf_counter()
    if light.environment is None:
        lighting = dark(transport.edge, light.lamps)
    else:
        around, turn, factor = light.environment, light.rotation, light.factor
        lighting = lighting_of(around, transport.edge, rotation=turn, factor=factor, lamps=light.lamps)
    encoded = time.perf_counter()
    rows = tuples(transport, lighting)
    figures = {
        "brdf": transport.factors.name,
        "terms": transport.factors.terms,
        "cube": transport.edge,
        "light_coefficients": lighting.light.kept,
        "light_rmse_rel": lighting.light.rmse_rel,
        "sky_energy_error_rel": lighting.light.energy_error_rel,
        "directional_lights": len(lighting.directional.direction),
        "light_s": encoded - before,
        "relight_s": time.perf_counter() - encoded,
    }
    return Illuminated(
        LitWavelets(transport, rows),
        figures,
        lambda eye: radiance_from(transport, rows, eye).negative_rel,
        "bake with more terms",
    )


def _check(arguments: argparse.Namespace) -> None:
    if arguments.brdf is not None:
        raise ValueError("--brdf is part of what was baked; bake again with another")
    if arguments.window != "none":
        raise ValueError("--window is for the mode sh")
