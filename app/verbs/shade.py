"""`lightarc shade`: a stack of photographs becomes a shading map, its power-law compression and a bundle."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.steps import Step, drain, part

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack
    from engine.material import Material
    from engine.shading.power_law import PowerLawMap
    from engine.shading.shading_map import ShadingMap

HELP = "Linearise a stack into a shading map, compress it and write the material."
EXAMPLE = "lightarc shade woven.stack -o woven.lightarc --slices 8 --compress power-law"

MOST_SLICES = 256


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("stack", metavar="STACK", help="folder that 'lightarc import' made")
    parser.add_argument(
        "-o", "--output", required=True, metavar="MATERIAL", help="bundle: a .lightarc file or a folder"
    )
    parser.add_argument("--slices", type=int, default=8, metavar="N", help="slices of the shading map (8)")
    parser.add_argument("--compress", default="power-law", choices=("power-law", "none"))
    parser.add_argument(
        "--scale", default="last-slice", choices=("last-slice", "least-squares"), help="k_s of the power law"
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import usage
    from engine.capture.stack import open_stack
    from engine.files.bundle import check_replaceable, save_bundle
    from engine.shading.power_law import fit
    from engine.shading.shading_map import build

    usage(_check, arguments.slices)
    check_replaceable(Path(arguments.output))
    stack = open_stack(arguments.stack)
    start = time.perf_counter()
    shading_map = drain(part(build(stack, arguments.slices), 0.0, 0.3), show)
    linearised = time.perf_counter()
    power_law = None
    if arguments.compress == "power-law":
        power_law = drain(part(fit(shading_map, arguments.scale), 0.3, 0.6), show)
    fitted = time.perf_counter()
    material = _material(stack, shading_map, power_law)
    figures = {"rms": power_law.rms} if power_law else {}
    saving = save_bundle(arguments.output, material, provenance=dict(stack.provenance), figures=figures)
    drain(part(saving, 0.6, 1.0), show)
    return {
        "slice_mean_radiance": shading_map.mean_radiance.tolist(),
        "slice_target_radiance": shading_map.target_radiance.tolist(),
        "rms": power_law.rms if power_law else None,
        "rms_per_channel": power_law.rms_per_channel.tolist() if power_law else None,
        "size_bytes_slices": shading_map.slices.nbytes,
        "size_bytes_compressed": power_law.scale.nbytes + power_law.exponent.nbytes if power_law else None,
        "linearise_s": linearised - start,
        "fit_s": fitted - linearised if power_law else None,
    }


def report(result: dict[str, Any]) -> str:
    size = f"{result['size_bytes_slices'] / 2**20:.1f} MiB"
    lines = [f"{len(result['slice_mean_radiance'])} slices, {size}, linearised in {result['linearise_s']:.2f} s"]
    if result["rms"] is not None:
        compressed = f"{result['size_bytes_compressed'] / 2**20:.1f} MiB"
        lines.append(f"power law, {compressed}, fitted in {result['fit_s']:.2f} s, RMS error {result['rms']:.4f}")
    return "\n".join(lines)


def _check(slices: int) -> None:
    if not 2 <= slices <= MOST_SLICES:
        raise ValueError(f"--slices {slices} is outside 2 … {MOST_SLICES}")


def _material(stack: ImageStack, shading_map: ShadingMap, power_law: PowerLawMap | None) -> Material:
    from engine.material import Material

    health = shading_map.health.merged(power_law.health) if power_law else shading_map.health
    elevation_deg = tuple(float(angle) for angle in stack.elevation_deg)
    name = stack.folder.name if stack.folder else "material"
    return Material(shading_map, power_law, elevation_deg=elevation_deg, name=name, health=health)
