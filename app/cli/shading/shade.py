"""`lightarc shade`: a stack of photographs becomes a shading map, its power-law compression and a bundle.

The record of a material that `lightarc shade` made, and the lines that tell of it.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.arguments.quantities import share
from app.arguments.results import Input, Output, image_by, material_at, software
from app.cli.import_ import azimuth_range
from app.cli.shading import arcs, comparison
from engine.brdf.brdf import MODELS, brdf_to_text
from engine.brdf.models.microfacet import Ggx
from engine.brdf.readers.read import open_brdf
from engine.brdf.readers.table_file import keep_table
from engine.bundle.bundle import save_bundle
from engine.bundle.manifest import MANIFEST, describe_bundle
from engine.capture.diffuse_part import PARTS, take_part
from engine.capture.evenness import even_out
from engine.capture.lights.file_names import as_text
from engine.capture.object_part import take_object
from engine.capture.stack import open_stack
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent, size_text, time_text
from engine.core.health import Health
from engine.core.steps import Step, Steps, drain, part
from engine.figures.contact_sheet import error_image, tile_preview
from engine.images.encode import encode_png
from engine.scene.material import Material, error_figures
from engine.shading.compile import prepare_kernels
from engine.shading.mixed import keep_tiles
from engine.shading.power_law import fit
from engine.shading.power_law_error import worst_texels
from engine.shading.quantise import quantise
from engine.shading.representation import check_worth, choose, has_sides
from engine.shading.shading_map import ShadingMap, include
from engine.shading.tile import make_tile, tile_health, tile_planes
from engine.storage.atomic import write_bytes
from engine.storage.records import MAX_PLANES

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.capture.stack import ImageStack
    from engine.shading.directional.planes import DirectionalMap
    from engine.shading.fidelity import Fidelity
    from engine.shading.power_law import PowerLawMap
    from engine.shading.power_law_error import Texel
    from engine.shading.representation import Chosen


def report_of(result: dict[str, Any]) -> str:
    """Lines for users on one material, of the record that `--json` prints."""
    if result["representation"] == "directional":
        size = size_text(result["size_bytes"])
        first = f"{result['planes']} planes of {result['photographs']} photographs, as many bytes a texel, {size}"
        return "\n".join(
            [f"{first}, fitted in {time_text(result['fit_s'])}", *_tile_line(result), *_errors(result), _where(result)]
        )
    size = size_text(result["size_bytes_slices"])
    lines = [f"{len(result['slice_mean_radiance'])} slices, {size}, linearised in {time_text(result['linearise_s'])}"]
    lines += _tile_line(result)
    if result["rms"] is not None:
        compressed = size_text(result["size_bytes_compressed"])
        lines.append(
            f"power law, {compressed}, fitted in {time_text(result['fit_s'])}, RMS error {number(result['rms'])}"
        )
    if result["exponent_bits"] not in (None, 32):
        change = (
            f"{number(result['quantisation_error_radiance'])}, at most {number(result['quantisation_bound_radiance'])}"
        )
        lines.append(f"exponents in {result['exponent_bits']} bits change radiance by {change}")
    if result["kept_tile_fraction"] is not None:
        kept = f"{percent(result['kept_tile_fraction'], 3)} of the tiles keep their slices"
        lines.append(f"{kept}, no texel's error reaches {number(result['max_error_radiance'], 3)}")
    if result["brdf_fit_rmse_rel"] is not None:
        lines.append(
            f"the model in place of the measured BRDF is {percent(result['brdf_fit_rmse_rel'], 3)} away from it"
        )
    return "\n".join([*lines, *_errors(result), _where(result)])


def write(path: str) -> dict[str, Any]:
    """The path that was written, its members and bytes."""
    output = Path(path)
    members = [*describe_bundle(output)["members"], MANIFEST]
    files = [output] if output.is_file() else [output / name for name in members]
    return {"output": str(output), "members": members, "bundle_bytes": sum(file.stat().st_size for file in files)}


def _where(result: dict[str, Any]) -> str:
    return f"Written to {result['output']}: {len(result['members'])} members, {size_text(result['bundle_bytes'])}."


def tile_record(seam_error: float, size: tuple[int, ...]) -> dict[str, Any]:
    """The error of a tile's seams and its `size` (H, W)."""
    return {"seam_error": seam_error, "tile_width_px": size[1], "tile_height_px": size[0]}


def evenness_record(evenness: Health) -> dict[str, Any]:
    """The slow change of brightness that was divided out of the most uneven photograph; None where none was."""
    return {"unevenness": evenness.figures.get("unevenness")}


def _tile_line(result: dict[str, Any]) -> list[str]:
    if result.get("seam_error") is None:
        return []
    tile = f"{result['tile_width_px']} x {result['tile_height_px']} texels"
    lines = [f"tile of {tile}, steps across its seams are {number(result['seam_error'])} times those within"]
    if result["unevenness"] is not None:
        lines.append(f"slow changes of brightness, up to {percent(result['unevenness'])}, were evened out before")
    return lines


def _errors(result: dict[str, Any]) -> list[str]:
    """Lines on the errors of what was chosen and of what was not."""
    if result["leave_one_out_rmse_srgb8"] is None:
        return []
    ours, mean = (number(result[f"{name}_rmse_srgb8"]) for name in ("leave_one_out", "mean_picture"))
    lines = [f"held-out photographs: error {ours} 8-bit levels, of their mean image {mean}"]
    for other in result["candidates"]:
        if other["representation"] != result["representation"]:
            lines.append(f"{other['representation']}, not chosen: error {number(other['leave_one_out_rmse_srgb8'])}")
    return lines


def choose_record(chosen: Chosen, bytes_per_texel: float) -> dict[str, Any]:
    """The errors of what was chosen and of all candidates, and the verdict."""

    def errors_of(shown: Fidelity) -> dict[str, Any]:
        known = not math.isnan(shown.leave_one_out)
        return {
            "leave_one_out_rmse_srgb8": shown.leave_one_out if known else None,
            "in_sample_rmse_srgb8": shown.in_sample,
            "mean_picture_rmse_srgb8": shown.mean_picture if known else None,
        }

    candidates = {chosen.name: chosen.shown, **chosen.others}
    return {
        "representation": chosen.name,
        **errors_of(chosen.shown),
        "bytes_per_texel": bytes_per_texel,
        "verdict": "warning" if chosen.shown.is_no_better else "good",
        "candidates": [{"representation": name, **errors_of(shown)} for name, shown in candidates.items()],
    }


EXAMPLE = "lightarc shade woven.stack -o woven.lightarc --slices 8 --compress power-law --max-error 0.05"

#: Those of `engine.shading.representation`, which loads compiled code.
REPRESENTATIONS = ("auto", "shading-map", "directional")

#: That of `engine.shading.directional.planes`, which loads compiled code too.
BYTES_PER_TEXEL = 96

#: Options that one representation alone uses, and what they are where they are not given.
OF_FIT = ("scale", "max_error", "exponent_bits", "worst", "error_map")
DEFAULTS: dict[str, Any] = {
    "bytes_per_texel": BYTES_PER_TEXEL,
    "slices": 8,
    "compress": "power-law",
    "scale": "last-slice",
    "max_error": None,
    "exponent_bits": 32,
    "worst": 10,
    "error_map": None,
}

MAX_SLICES = 256
MAX_WORST_TEXELS = 10_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("stack", type=Input(), metavar="STACK", help="folder that 'lightarc import' made")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        type=Output(material_at),
        metavar="MATERIAL",
        help="bundle: a .lightarc file or a folder",
    )
    parser.add_argument(
        "--representation",
        default="auto",
        choices=REPRESENTATIONS,
        help="what the material knows of the light: its brightness (shading-map), its direction (directional), or "
        "what shows photographs better that are left out (auto)",
    )
    parser.add_argument("--slices", type=int, metavar="N", help="slices of the shading map (8)")
    parser.add_argument(
        "--bytes-per-texel",
        type=int,
        metavar="N",
        help=f"most bytes of a texel of a directional map, one for each plane ({BYTES_PER_TEXEL}); it has as many as "
        "lower the error of photographs that are left out",
    )
    parser.add_argument(
        "--exclude", type=str, nargs="+", action="extend", default=[], metavar="NAME", help="photographs to leave out"
    )
    lamps = parser.add_mutually_exclusive_group()
    lamps.add_argument(
        "--azimuth",
        type=azimuth_range,
        metavar="DEGREES",
        help="use the lamps of this azimuth alone, in degrees, 0 = right, 90 = up in the image (±2.5); 90±10 sets "
        "the tolerance",
    )
    lamps.add_argument(
        "--arc", action="store_true", help="use the lamps of one arc: the azimuth ±10° with most elevations"
    )
    lamps.add_argument(
        "--per-arc",
        action="store_true",
        help="write a folder with a shading map of each arc of lamps, azimuth ±10°: arc-000.lightarc, arc-045.lightarc",
    )
    parser.add_argument(
        "--brdf",
        type=Input(),
        metavar="TEXT",
        help="the BRDF: phong:exponent=20, or a measured file, which the bundle stores as a table",
    )
    parser.add_argument(
        "--compare",
        action="store_true",
        help="write no material, but the errors of its possible representations into a folder (lamps of many azimuths)",
    )
    parser.add_argument(
        "--force",
        action="store_true",
        help="write the material also where the mean of its photographs is nearer",
    )
    compression = parser.add_argument_group("compression")
    compression.add_argument(
        "--compress", choices=("power-law", "none"), help="the compression of the shading map (power-law)"
    )
    compression.add_argument(
        "--scale",
        choices=("last-slice", "least-squares"),
        help="scale k_s of the power law: that of the last slice, or least squares (last-slice)",
    )
    compression.add_argument(
        "--max-error",
        type=share,
        metavar="E",
        help="keep the slices of every tile of 16 x 16 texels in which the error of a texel (root mean square over "
        "slices and channels) reaches E times r_max; 0 keeps all",
    )
    compression.add_argument(
        "--exponent-bits",
        type=int,
        choices=(8, 16, 32),
        help="bits of a stored exponent; with 8 or 16 the scale is stored as half floats (32)",
    )
    compression.add_argument("--worst", type=int, metavar="N", help="list the N worst texels (10)")
    images = image_by("shade", ".png")
    compression.add_argument(
        "--error-map", type=Output(images), metavar="FILE.png", help="image of the error of each texel"
    )
    parser.add_argument(
        "--part",
        choices=PARTS,
        help="of pairs under polarisers, the light that the map is made of: the diffuse part, to which the BRDF adds "
        "highlights, or the whole (diffuse)",
    )
    tiling = parser.add_argument_group("tiling")
    tiling.add_argument("--tileable", action="store_true", help="cut the material so that it repeats without seams")
    tiling.add_argument(
        "--overlap",
        type=int,
        metavar="N",
        help="texels over which opposite edges are joined (an eighth of the shorter side)",
    )
    tiling.add_argument(
        "--brightness",
        choices=("evened", "as-it-is"),
        help="divide the slow change of brightness over the sample out of the photographs, which repeated makes bands, "
        "before the tile is cut (evened)",
    )
    tiling.add_argument("--tile-preview", type=Output(images), metavar="FILE.png", help="image of 3 x 3 tiles")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    given = _take_defaults(arguments)
    _check(arguments, given)
    stack, evenness = open_stack(arguments.stack), Health()
    _refuse_unused(arguments, given, stack)
    if arguments.compare:
        arguments.exclude = arcs.exclude(arguments, stack)
        stack, _, _ = drain(part(take_object(stack), 0.0, 0.02), show)
        return comparison.run(arguments, stack, show)
    if arguments.part is not None and stack.diffuse is None:
        raise UsageError("--part needs a stack of pairs under polarisers")
    stack, light = drain(part(take_part(stack, arguments.part or "diffuse"), 0.0, 0.02), show)
    stack, mask, masked = drain(part(take_object(stack, to_tile=arguments.tileable), 0.0, 0.04), show)
    if arguments.tileable and arguments.brightness != "as-it-is":
        stack, evenness = drain(part(even_out(stack), 0.0, 0.05), show)
    make = partial(_make, evenness=evenness, light=light.merge(masked), mask=mask)
    if arguments.per_arc:
        return arcs.run(arguments, stack, make, show)
    arguments.exclude = arcs.exclude(arguments, stack)
    return make(arguments, stack, show)


def _make(
    arguments: argparse.Namespace,
    stack: ImageStack,
    show: Callable[[Step], None],
    evenness: Health,
    light: Health,
    mask: NDArray[np.bool_] | None,
) -> dict[str, Any]:
    """The material of a stack, written as the arguments say.

    `evenness` tells what was divided out of it before, and `light` which part of its light it shows; `mask` (H, W) is
    that of its object.
    """
    fixed = {**_brdf(arguments, show), "mask": mask}
    drain(part(prepare_kernels(), 0.0, 0.1), show)
    wanted, most = arguments.representation, arguments.bytes_per_texel
    choosing = choose(stack, arguments.slices, excluded=arguments.exclude, wanted=wanted, most=most)
    chosen, choose_s = _time(part(choosing, 0.1, 0.45), show)
    chosen = dataclasses.replace(chosen, remarks=(*chosen.remarks, *light.findings))
    if not arguments.force:
        check_worth(stack, chosen)
    if isinstance(chosen.map, ShadingMap):
        return _with_shading_map(arguments, stack, chosen, chosen.map, evenness, fixed, show)
    return _with_planes(arguments, stack, chosen, chosen.map, evenness, fixed, choose_s, show)


def _with_shading_map(
    arguments: argparse.Namespace,
    stack: ImageStack,
    chosen: Chosen,
    shading_map: ShadingMap,
    evenness: Health,
    fixed: dict[str, Any],
    show: Callable[[Step], None],
) -> dict[str, Any]:
    """Tile, compress and write a shading map, and tell about it."""
    if arguments.tileable:
        making = make_tile(stack, shading_map, overlap=arguments.overlap, excluded=arguments.exclude)
        shading_map = drain(part(making, 0.45, 0.5), show).shading_map
        shading_map = dataclasses.replace(shading_map, health=shading_map.health.merge(evenness))
    power_law, fit_s = _compress(arguments, shading_map, show)
    material = dataclasses.replace(_material(arguments, stack, shading_map, power_law), **fixed)
    material = dataclasses.replace(material, health=material.health.merge(chosen.health))
    figures = error_figures(material)
    provenance = {
        **stack.provenance,
        "excluded_photographs": arguments.exclude,
        "power_law_scale": arguments.scale if power_law else None,
    }
    saving = save_bundle(arguments.output, material, provenance=provenance, figures=figures)
    drain(part(saving, 0.7, 1.0), show)
    worst = _images(arguments, shading_map, power_law)
    size_bytes = power_law.size_bytes if power_law is not None else shading_map.slices.nbytes
    return {
        "slice_mean_radiance": shading_map.mean_radiance.tolist(),
        "slice_target_radiance": shading_map.target_radiance.tolist(),
        "rms": figures["rms"],
        "rms_per_channel": power_law.rms_per_channel.tolist() if power_law else None,
        "size_bytes_slices": shading_map.slices.nbytes,
        "size_bytes_compressed": power_law.size_bytes if power_law else None,
        "linearise_s": chosen.fit_s,
        "fit_s": fit_s,
        **evenness_record(evenness),
        **choose_record(chosen, size_bytes / (shading_map.slices.shape[1] * shading_map.slices.shape[2])),
        **figures,
        **write(arguments.output),
        "warnings": material.health.warnings,
        "worst_texels": [{"row": t.row, "column": t.column, "error_radiance": t.error} for t in worst],
    }


def _with_planes(
    arguments: argparse.Namespace,
    stack: ImageStack,
    chosen: Chosen,
    directional: DirectionalMap,
    evenness: Health,
    fixed: dict[str, Any],
    choose_s: float,
    show: Callable[[Step], None],
) -> dict[str, Any]:
    """Write a directional map, and tell about it. A BRDF that nobody named is Lambert's, which adds no highlight."""
    health, tile = chosen.health.merge(evenness), None
    if arguments.tileable:
        sample = directional.planes.shape[1:]
        making = tile_planes(directional, overlap=arguments.overlap, name=stack.folder or "the stack")
        directional, tile = drain(part(making, 0.45, 0.5), show)
        health = health.merge(tile_health(tile, (sample[0], sample[1])))
    material = Material(
        None,
        None,
        elevation_deg=_elevation_deg(arguments, stack),
        name=as_text(Path(arguments.output).stem),
        health=health,
        directional=directional,
        **{"brdf": "lambert", **fixed},
    )
    record = choose_record(chosen, directional.bytes_per_texel) | evenness_record(evenness)
    if tile is not None:
        record |= tile_record(tile.seam_error, tile.row.shape)
    provenance = {**stack.provenance, "excluded_photographs": arguments.exclude}
    saving = save_bundle(arguments.output, material, provenance=provenance, figures=record)
    drain(part(saving, 0.5, 1.0), show)
    if arguments.tile_preview:
        _write_preview(arguments, directional.image(directional.lights[directional.lights[:, 2].argmax()]))
    return {
        "planes": len(directional.planes),
        "photographs": len(directional.lights),
        "size_bytes": directional.planes.nbytes,
        "choose_s": choose_s,
        "fit_s": chosen.fit_s,
        **record,
        **write(arguments.output),
        "warnings": material.health.warnings,
    }


def report(result: dict[str, Any]) -> str:
    if "files" in result:
        return comparison.report(result)
    if "arcs" in result:
        return "\n".join(arcs.heading(arc) + report_of(arc) for arc in result["arcs"])
    return report_of(result)


def _take_defaults(arguments: argparse.Namespace) -> list[str]:
    """Fill in what was not given of `DEFAULTS`; returns the names of what was."""
    given = [name for name in DEFAULTS if getattr(arguments, name) is not None]
    for name, value in DEFAULTS.items():
        if name not in given:
            setattr(arguments, name, value)
    return given


def _refuse_unused(arguments: argparse.Namespace, given: list[str], stack: ImageStack) -> None:
    """UsageError for options that the representation does not use, which would be passed over without a word."""
    of_shading_maps = [name for name in given if name != "bytes_per_texel"]
    if arguments.compare:
        unused = [name for name in of_shading_maps if name != "slices"]
        if unused:
            raise UsageError(f"--compare writes no material: leave out {_options(unused)}")
        return
    wanted = "shading-map" if arguments.per_arc else arguments.representation
    sides = wanted == "auto" and has_sides(stack, include(stack, arcs.exclude(arguments, stack)))
    if of_shading_maps and (wanted == "directional" or sides):
        remedy = "leave out" if wanted == "directional" else "add --representation shading-map, or leave out"
        raise UsageError(f"a directional map has no slices and no compression: {remedy} {_options(of_shading_maps)}")
    if "bytes_per_texel" in given and wanted != "directional" and not sides:
        raise UsageError("--bytes-per-texel is of directional maps, and this is a shading map: leave it out")


def _options(names: list[str]) -> str:
    return " and ".join("--" + name.replace("_", "-") for name in names)


def _check(arguments: argparse.Namespace, given: list[str]) -> None:
    if not 1 <= arguments.bytes_per_texel <= MAX_PLANES:
        raise UsageError(f"--bytes-per-texel {arguments.bytes_per_texel} is outside 1 … {MAX_PLANES}")
    if not 2 <= arguments.slices <= MAX_SLICES:
        raise UsageError(f"--slices {arguments.slices} is outside 2 … {MAX_SLICES}")
    if arguments.max_error is not None and not 0.0 <= arguments.max_error < math.inf:
        raise UsageError(f"--max-error {arguments.max_error} is not a number from 0 upwards")
    if not 0 <= arguments.worst <= MAX_WORST_TEXELS:
        raise UsageError(f"--worst {arguments.worst} is outside 0 … {MAX_WORST_TEXELS}")
    if arguments.overlap is not None and arguments.overlap < 1:
        raise UsageError(f"--overlap {arguments.overlap} is not a positive number of texels")
    if not arguments.tileable and (arguments.overlap is not None or arguments.brightness or arguments.tile_preview):
        raise UsageError("--overlap, --brightness and --tile-preview need --tileable")
    if arguments.per_arc and (arguments.compare or arguments.error_map or arguments.tile_preview):
        raise UsageError("--per-arc writes several materials: leave out --compare, --error-map and --tile-preview")
    if arguments.compare and (arguments.part or arguments.tileable):
        raise UsageError("--compare writes no material, and is of the whole light: leave out --part and --tileable")
    if arguments.per_arc and arguments.representation == "directional":
        raise UsageError("--per-arc writes shading maps: leave out --representation directional")
    of_fit = [name for name in given if name in OF_FIT]
    if arguments.compress == "none" and of_fit:
        raise UsageError(f"{_options(of_fit)} needs --compress power-law")


def _time(work: Steps[Any], show: Callable[[Step], None]) -> tuple[Any, float]:
    """The result of `work` and the seconds that it took."""
    start = time.perf_counter()
    return drain(work, show), time.perf_counter() - start


def _compress(
    arguments: argparse.Namespace, shading_map: ShadingMap, show: Callable[[Step], None]
) -> tuple[PowerLawMap | None, float | None]:
    """The compressed map as it was asked for, and the seconds of the fit alone."""
    if arguments.compress == "none":
        return None, None

    power_law, fit_s = _time(part(fit(shading_map, arguments.scale), 0.5, 0.6), show)
    if arguments.exponent_bits < 32:
        power_law = drain(part(quantise(power_law, shading_map, arguments.exponent_bits), 0.6, 0.65), show)
    if arguments.max_error is not None:
        keeping = keep_tiles(power_law, shading_map, arguments.max_error * shading_map.r_max)
        power_law = drain(part(keeping, 0.65, 0.7), show)
    return power_law, fit_s


def _material(
    arguments: argparse.Namespace, stack: ImageStack, shading_map: ShadingMap, power_law: PowerLawMap | None
) -> Material:
    health = shading_map.health.merge(power_law.health) if power_law else shading_map.health
    elevation_deg, name = _elevation_deg(arguments, stack), as_text(Path(arguments.output).stem)
    return Material(shading_map, power_law, elevation_deg=elevation_deg, name=name, health=health)


def _elevation_deg(arguments: argparse.Namespace, stack: ImageStack) -> tuple[float, ...]:
    return tuple(float(angle) for angle in stack.elevation_deg[include(stack, arguments.exclude)])


def _brdf(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """The fields of a material that say how it reflects: a model, or a measured table and the GGX nearest to it."""
    if not arguments.brdf:
        return {}
    from engine.brdf.fit import fit, fit_data

    brdf = open_brdf(arguments.brdf)
    if type(brdf) in MODELS.values():
        return {"brdf": brdf_to_text(brdf)}
    table = drain(part(keep_table(brdf), 0.0, 0.05), show)
    nearest = drain(part(fit(fit_data(table), Ggx()), 0.05, 0.1), show).brdf
    return {"brdf": brdf_to_text(nearest), "measured": table}


def _images(arguments: argparse.Namespace, shading_map: ShadingMap, power_law: PowerLawMap | None) -> tuple[Texel, ...]:
    """Write the images that were asked for, and find the worst texels."""
    worst = worst_texels(power_law, arguments.worst) if power_law else ()
    if power_law and arguments.error_map:
        write_bytes(arguments.error_map, encode_png(error_image(power_law, worst), software=software("shade")))
    if arguments.tile_preview:
        _write_preview(arguments, shading_map.slices[-1])
    return worst


def _write_preview(arguments: argparse.Namespace, image: NDArray[np.float32]) -> None:
    """Write the image (H, W, 3) of a tile, repeated."""
    write_bytes(arguments.tile_preview, encode_png(tile_preview(image), software=software("shade")))
