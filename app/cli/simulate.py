"""`lightarc simulate`: photographs of a procedural sample on a virtual light arc or dome, with reference data."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from app.arguments.options import refuse_unused
from app.arguments.quantities import Degrees, share
from app.arguments.results import CAPTURE, Output
from engine.core.steps import Step, drain
from engine.simulate.arc import MARKER, LightArc, dome_azimuths_deg, dome_elevations_deg
from engine.simulate.simulate import simulate
from engine.storage.text import whole_number

EXAMPLE = """lightarc simulate -o woven --sample woven --elevations-deg 5,20,40,60,80,90
         lightarc simulate -o dome --sample leather --azimuths 8 --elevations 5"""

#: Lamps of a dome along each circle or arc, at most.
MAX_LAMPS = 360


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o", "--output", required=True, type=Output(CAPTURE, Path), metavar="FOLDER", help="folder of the capture"
    )
    parser.add_argument("--sample", default="woven", choices=("woven", "hammered", "leather", "medal", "plain"))
    elevations, azimuths = parser.add_mutually_exclusive_group(), parser.add_mutually_exclusive_group()
    elevations.add_argument(
        "--elevations", type=_count, metavar="M", help="M elevations evenly from 15 to 75 degrees, as lamps of a dome"
    )
    azimuths.add_argument("--azimuths", type=_count, metavar="N", help="N arcs of lamps evenly around the sample")
    elevations.add_argument(
        "--elevations-deg",
        type=Degrees(0, "5,20,40"),
        default=(5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0),
        metavar="A,B,…",
        help="elevations of the lamp above the sample (5,10,20,…,90)",
    )
    azimuths.add_argument(
        "--azimuths-deg",
        type=Degrees(0, "0,90"),
        default=(0.0,),
        metavar="A,B,…",
        help="azimuths of the lamp: 0 = right, 90 = up in the image (0)",
    )
    parser.add_argument("--size", type=int, default=512, metavar="PX", help="width and height of a photograph (512)")
    parser.add_argument(
        "--format", default="tiff", choices=("tiff", "exr", "dng"), help="file format: tiff is 16-bit sRGB (tiff)"
    )
    parser.add_argument(
        "--noise", type=share, default=0.004, help="standard deviation of the noise at the white level (0.004)"
    )
    parser.add_argument(
        "--misalignment-px", type=float, default=0.6, metavar="PX", help="largest shift of a photograph (0.6)"
    )
    parser.add_argument(
        "--turn-deg",
        type=Degrees(1, "0.5", is_small=True),
        default=0.0,
        metavar="A",
        help="largest rotation of a photograph about its centre (0)",
    )
    parser.add_argument(
        "--exposures", type=_numbers, default=(1.0,), metavar="A,B,…", help="relative exposures of every light (1)"
    )
    parser.add_argument(
        "--lamp-distance", type=float, metavar="D", help="distance of a near lamp, in image widths (infinite)"
    )
    parser.add_argument(
        "--corner-loss", type=share, default=0.0, help="share of the light that the lens loses in the corners (0)"
    )
    parser.add_argument("--dark", type=share, default=0.0, help="mean signal without light, 1 = white level (0)")
    parser.add_argument("--calibration", action="store_true", help="photograph a dark frame and a flat field too")
    parser.add_argument("--sphere", action="store_true", help="put a mirror sphere into the lower left corner")
    parser.add_argument("--raw-bits", type=int, choices=(12, 14), help="bits of DNG samples (14)")
    parser.add_argument("--no-interreflection", action="store_true", help="leave out interreflection in the relief")
    parser.add_argument("--seed", type=int, default=1, help="seed: equal seeds give equal files (1)")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    start = time.perf_counter()
    refuse_unused(arguments, [("--raw-bits", arguments.format == "dng", "--format dng")])
    rising, around = arguments.elevations_deg, arguments.azimuths_deg
    if arguments.elevations:
        rising = dome_elevations_deg(arguments.elevations)
    if arguments.azimuths:
        around = dome_azimuths_deg(arguments.azimuths)
    arc = LightArc(
        sample=arguments.sample,
        elevation=tuple(map(math.radians, rising)),
        azimuth=tuple(map(math.radians, around)),
        size=arguments.size,
        format=arguments.format,
        interreflection=not arguments.no_interreflection,
        seed=arguments.seed,
        noise=arguments.noise,
        misalignment_px=arguments.misalignment_px,
        turn=math.radians(arguments.turn_deg),
        exposure=arguments.exposures,
        lamp_distance=arguments.lamp_distance,
        corner_loss=arguments.corner_loss,
        dark=arguments.dark,
        calibration=arguments.calibration,
        sphere=arguments.sphere,
        raw_bits=arguments.raw_bits or 14,
    )
    capture = drain(simulate(arc, arguments.output), show)
    return {
        "folder": str(capture.folder),
        "images": len(capture.shots),
        "photographs": [str(path) for path in capture.photographs],
        "elevations_deg": [round(math.degrees(shot.elevation), 9) for shot in capture.shots],
        "azimuths_deg": [round(math.degrees(shot.azimuth), 9) for shot in capture.shots],
        "exposures_s": [shot.exposure_s for shot in capture.shots],
        "turns_deg": [round(math.degrees(shot.turn), 9) for shot in capture.shots],
        "shifts_px": [[shot.right_px, shot.down_px] for shot in capture.shots],
        "truth": str(capture.folder / MARKER),
        "warnings": capture.warnings,
        "time_s": time.perf_counter() - start,
    }


def report(result: dict[str, Any]) -> str:
    return f"{result['images']} photographs in {result['folder']}, the reference data in {result['truth']}"


def _numbers(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(angle) for angle in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of numbers such as 5,20,40") from None


def _count(text: str) -> int:
    count = whole_number(text, MAX_LAMPS)
    if not count:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number from 1 to {MAX_LAMPS}")
    return count
