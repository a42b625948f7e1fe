"""`lightarc simulate`: photographs of a procedural sample on the virtual light arc, with the truth beside them."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from engine.steps import Step, drain

HELP = "Photograph a procedural sample on the virtual light arc, with the truth beside the photographs."
EXAMPLE = "lightarc simulate -o woven --sample woven --elevations-deg 5,20,40,60,80,90"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-o", "--output", required=True, type=Path, metavar="FOLDER", help="folder of the capture")
    parser.add_argument("--sample", default="woven", choices=("woven", "hammered", "leather", "plain"))
    parser.add_argument(
        "--elevations-deg",
        type=_angles,
        default=(5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0),
        metavar="A,B,…",
        help="elevations of the lamp above the sample (5,10,20,…,90)",
    )
    parser.add_argument(
        "--azimuths-deg", type=_angles, default=(0.0,), metavar="A,B,…", help="0 = right, 90 = up in the picture (0)"
    )
    parser.add_argument("--size", type=int, default=512, metavar="PX", help="width and height of a photograph (512)")
    parser.add_argument("--format", default="tiff", choices=("tiff", "exr", "dng"), help="16-bit sRGB TIFF by default")
    parser.add_argument("--noise", type=float, default=0.004, help="deviation of the noise at the white level (0.004)")
    parser.add_argument(
        "--misalignment-px", type=float, default=0.6, metavar="PX", help="largest shift of a photograph (0.6)"
    )
    parser.add_argument("--no-interreflection", action="store_true", help="leave out light that bounces in the relief")
    parser.add_argument("--seed", type=int, default=1, help="equal seeds give equal files (1)")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import usage
    from engine.render.simulate import MARKER, LightArc, simulate

    start = time.perf_counter()
    arc = usage(
        lambda: LightArc(
            sample=arguments.sample,
            elevation=tuple(map(math.radians, arguments.elevations_deg)),
            azimuth=tuple(map(math.radians, arguments.azimuths_deg)),
            size=arguments.size,
            format=arguments.format,
            interreflection=not arguments.no_interreflection,
            seed=arguments.seed,
            noise=arguments.noise,
            misalignment_px=arguments.misalignment_px,
        )
    )
    capture = drain(simulate(arc, arguments.output), show)
    return {
        "folder": str(capture.folder),
        "images": len(capture.shots),
        "photographs": [str(path) for path in capture.photographs],
        "elevations_deg": [round(math.degrees(shot.elevation), 9) for shot in capture.shots],
        "azimuths_deg": [round(math.degrees(shot.azimuth), 9) for shot in capture.shots],
        "shifts_px": [[shot.right_px, shot.down_px] for shot in capture.shots],
        "truth": str(capture.folder / MARKER),
        "time_s": time.perf_counter() - start,
    }


def report(result: dict[str, Any]) -> str:
    return f"{result['images']} photographs in {result['folder']}, the truth in {result['truth']}"


def _angles(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(angle) for angle in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of angles such as 5,20,40") from None
