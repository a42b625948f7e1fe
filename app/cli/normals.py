"""`lightarc normals`: normals, height and PBR maps from photographs of lamps on several sides."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from app.arguments.results import MAPS, Input, Output, software
from engine.capture.stack import open_stack
from engine.core.colour import REC_709
from engine.core.figure_text import number, percent
from engine.core.steps import Step, drain, part
from engine.shading.shading_map import include
from engine.surface.recover import check_white, recover
from engine.surface.write import record, write_surface

EXAMPLE = "lightarc normals dome.stack -o dome.maps"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "stack", type=Input(), metavar="STACK", help="folder that 'lightarc import' made, of lamps on several sides"
    )
    parser.add_argument(
        "-o", "--output", required=True, type=Output(MAPS, Path), metavar="FOLDER", help="folder of the maps"
    )
    parser.add_argument(
        "--exclude", action="append", default=[], type=str, metavar="NAME", help="leave a photograph out (repeatable)"
    )
    parser.add_argument(
        "--white",
        type=float,
        metavar="R",
        help="radiance of a white reference that faces a lamp, 1 = white level of the photographs (1, or more where "
        "the "
        "material is brighter); base colour and specular are relative to it",
    )
    parser.add_argument(
        "--no-errors", action="store_true", help="do not compare with the photographs, which takes a fit for each"
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    check_white(arguments.white, "--white")
    stack = open_stack(arguments.stack)
    used = include(stack, arguments.exclude)
    finding = recover(stack, used, white=arguments.white, left_out=not arguments.no_errors)
    surface = drain(part(finding, 0.0, 0.95), show)
    provenance = {**stack.provenance, "stack": str(arguments.stack), "excluded_photographs": arguments.exclude}
    writing = write_surface(arguments.output, surface, provenance, software("normals"))
    files = drain(part(writing, 0.95, 1.0), show)
    return {"folder": str(arguments.output), "files": files, **record(surface, provenance)}


def report(result: dict[str, Any]) -> str:
    size = f"{result['width_px']} × {result['height_px']} texels"
    lines = [f"maps of {size} in {result['folder']}, from {result['photographs']} photographs"]
    if result["observed_slopes"] == "both":
        count = result["height_regions"]
        regions = f" of {count} regions, the steps between which are unknown" if count > 1 else ""
        lines.append(f"normals to {number(result['normal_sigma_deg'])}° (median), and the height{regions}")
    else:
        azimuth = number(result["arc_azimuth_deg"])
        lines.append(f"the slope along {azimuth}° to {number(result['normal_sigma_deg'])}° (median); no height")
    for name, found in result["maps"].items():
        sigma = found["median_sigma"]
        if sigma is not None and name != "normal":
            lines.append(f"{name.replace('_', ' '):12} median error {number(sigma)}")
    if result["height_range_mm"] is not None:
        low, high = result["height_range_mm"]
        texel = number(result["texel_mm"], 4)
        estimate = " (an estimate from the camera's notes)" if result["texel_mm_is_estimate"] else ""
        lines.append(f"heights from {number(low)} to {number(high)} mm, {texel} mm per texel{estimate}")
    if result["working_space"] != REC_709.label:
        beyond = "none of them beyond Rec.709"
        if result["beyond_rec709_share"] > 0.0:
            share = percent(result["beyond_rec709_share"])
            beyond = f"{share} of them beyond Rec.709, clipped in the PNG previews"
        lines.append(f"base colours in {result['working_space']}, {beyond}")
    if result["in_sample_rmse_srgb8"] is not None:
        own, mean = number(result["in_sample_rmse_srgb8"]), number(result["mean_picture_rmse_srgb8"])
        lines.append(f"photographs: error {own} 8-bit levels, of their mean image {mean}")
    if result["leave_one_out_rmse_srgb8"] is not None:
        lines.append(f"photographs that are left out to {number(result['leave_one_out_rmse_srgb8'])}")
    if not math.isclose(result["white_radiance"], 1.0):
        lines.append(f"white reference: estimated at {number(result['white_radiance'])} times the white level")
    return "\n".join(lines)
