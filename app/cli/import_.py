"""`lightarc import`: photographs become a stack that everything after it works on."""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import psutil

from app.arguments.quantities import Degrees
from app.arguments.results import CHART, LENS, LIGHTS, STACK, Input, Output
from app.session.settings import close_session, open_session
from engine.capture.calibration.separation import gain_text
from engine.capture.chart.file import save_chart
from engine.capture.chart.file import text_of as chart_text
from engine.capture.gamut import CHOICES, gamut_text
from engine.capture.import_plan import CALIBRATED
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.light_file import save_lights
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.lights.selection import Arc, Azimuth, Listed
from engine.capture.lights.sources import Sources, find_packed
from engine.capture.photograph.grey_patch import GreyPatch
from engine.capture.photograph.lens import save_lens
from engine.capture.registration.framing import Framing
from engine.capture.registration.framing import crop as crop_to_size
from engine.capture.registration.warp import Region
from engine.capture.scale import CameraDistance, ChartPitch, KnownLength, ScaleChoice, scale_text
from engine.capture.stack import ImageStack, lights_of
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent, time_text
from engine.core.steps import Step, Steps, drain
from engine.storage.unpack import is_archive

EXAMPLE = "lightarc import photographs -o stack --angles-deg 10,20,30,40,50,60,70,80,90"

_MOTIONS = ("auto", "translation", "euclidean", "affine", "homography")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "photographs",
        nargs="+",
        type=Input(Path, "beside"),
        metavar="FOLDER",
        help="a folder, the photographs, or a zip or tar of them",
    )
    parser.add_argument(
        "-o", "--output", required=True, type=Output(STACK, Path), metavar="STACK", help="folder of the stack"
    )
    add_choices(parser)
    parser.add_argument(
        "--write-chart",
        type=Output(CHART, Path),
        metavar="FILE",
        help="also write the correction by the chart: .chart for later captures under the same lamps, or .html as a "
        "report of all patches",
    )
    parser.add_argument(
        "--write-lens",
        type=Output(LENS, Path),
        metavar="FILE",
        help="also write the lens that was measured, as a .lens file for later captures with it",
    )
    parser.add_argument(
        "--write-lights",
        type=Output(LIGHTS, Path),
        metavar="FILE",
        help="also write the lights as they were found: .lights with directions, distance and intensity of each lamp, "
        "which later captures under the same lamps name beside their photographs, or .lp with directions alone",
    )
    parser.epilog = f"{parser.epilog}\n\n{JSON_HELP}"


def add_choices(parser: argparse.ArgumentParser) -> None:
    """Add the options that say how photographs are imported."""
    parser.add_argument(
        "--angles-deg",
        type=Degrees(0, "10,20,30"),
        metavar="A,B,…",
        help="elevations of the light in degrees, one per photograph in the order of the file names; "
        "without it they come from capture.toml, an .lp file or the file names",
    )
    parser.add_argument("--no-align", action="store_true", help="do not align; for a camera that did not move")
    parser.add_argument(
        "--motion",
        default="auto",
        choices=_MOTIONS,
        help="motion model of the alignment; auto: euclidean for lights on one arc, none for lights all around",
    )
    parser.add_argument(
        "--white-balance",
        default="camera",
        type=_white_balance,
        metavar="camera|none|R,G,B|patch:LEFT,TOP,WIDTH,HEIGHT",
        help="white balance of RAW files (camera); a grey patch of the image balances all files",
    )
    parser.add_argument(
        "--transfer",
        default="auto",
        choices=("auto", "srgb", "linear"),
        help="transfer function of 8- and 16-bit files (auto: of their colour profile, else sRGB); a stated one "
        "overrides the curve of a profile, not its primaries",
    )
    parser.add_argument(
        "--working-space",
        default="rec709",
        choices=CHOICES,
        help="linear space in which maps of the capture are made, since colours beyond it do not fit between 0 and 1; "
        "auto: rec2020 where colours go beyond Rec.709, else rec709 (rec709)",
    )
    parser.add_argument(
        "--bands",
        default=(),
        type=_bands,
        metavar="BAND|R,G,B",
        help="of images with more bands than colours, the one that becomes grey, or the three that become red, green "
        "and blue; the first is 1",
    )
    parser.add_argument(
        "--chart",
        type=Input(Path),
        metavar="auto|FILE",
        help="correct colours by a classic chart of 24 patches: in a photograph of the capture (auto), in another one "
        "under the same lamps, or as --write-chart has saved it",
    )
    parser.add_argument(
        "--lens",
        type=Input(Path),
        metavar="FOLDER|FILE",
        help="take off the distortion of the lens: a folder of photographs of a chessboard in five tilted positions or "
        "more, or a .lens file; other options are then in pixels of the straight photographs",
    )
    parser.add_argument(
        "--scale",
        type=_scale,
        metavar="MM|X,Y,X,Y=MM|chart=MM|exif[=MM]",
        help="millimetres per pixel of the photographs; or two points of the photograph that the others are aligned "
        "to, and the millimetres between them; or the millimetres between the middles of neighbouring patches of the "
        "chart, with --chart; or exif for an estimate from the focal length, the sensor and the distance that the "
        "camera notes, or the millimetres from the sample to the sensor as measured (exif=620)",
    )
    parser.add_argument(
        "--pair",
        default="auto",
        type=_pair,
        metavar="auto|none|FOLDER",
        help="pairs under parallel and crossed polarisers: told by names of files or folders (auto: par and cross, "
        "parallel and crossed, and the like), or the folder of the crossed photographs where the others are parallel; "
        "none: each photograph by itself",
    )
    parser.add_argument(
        "--pair-gain",
        type=float,
        metavar="GAIN",
        help="brightness of a matte white patch in crossed photographs over that in parallel ones; without it, it is "
        "estimated from the pairs",
    )
    parser.add_argument(
        "--crop", type=_crop, metavar="LEFT,TOP,WIDTH,HEIGHT", help="part to keep, in pixels of the photographs"
    )
    parser.add_argument(
        "--corners",
        type=_corners,
        metavar="X,Y,X,Y,X,Y,X,Y",
        help="corners of a rectangle to rectify, in pixels of the photograph that the others are aligned to, "
        "clockwise from its top left",
    )
    parser.add_argument(
        "--size", type=_size, metavar="WIDTHxHEIGHT", help="size of the images in the stack, with --corners or --crop"
    )
    parser.add_argument(
        "--estimate-lights",
        action="store_true",
        help="estimate the lights from the photographs alone, as equally bright lamps on several sides over a matte "
        "sample that lies flat; marked as an estimate",
    )
    parser.add_argument(
        "--mask",
        type=Input(Path),
        metavar="FILE|alpha",
        help="an image, drawn on a photograph, whose white pixels show the object, or the alpha channel of the "
        "photographs; 'lightarc normals' makes no maps of the background",
    )
    parser.add_argument(
        "--dark",
        type=Input(Path),
        metavar="FILE|FOLDER",
        help="photograph without light, which is subtracted; or a folder with one of each lamp, named as the "
        "photographs or in their order",
    )
    flat = parser.add_mutually_exclusive_group()
    flat.add_argument(
        "--flat",
        type=Input(Path),
        metavar="FILE|FOLDER",
        help="photograph of an even white surface, which is divided out; or a folder with one under each lamp, which "
        "divides out the intensity and the fall-off of each as well",
    )
    flat.add_argument("--no-flat", action="store_true", help="do not use the flat field beside the photographs")
    parser.add_argument(
        "--lamp-distance",
        type=float,
        metavar="WIDTHS",
        help="distance of a near lamp from the middle of the image, in image widths; inf: a distant lamp",
    )
    parser.add_argument(
        "--sphere",
        type=_sphere,
        metavar="COLUMN,ROW,RADIUS|auto",
        help="measure the lights on the mirror sphere with this outline in the image",
    )
    parser.add_argument(
        "--second-sphere",
        type=_sphere,
        metavar="COLUMN,ROW,RADIUS|auto",
        help="a second mirror sphere on the sample, which with the first tells where near lamps stand",
    )
    parser.add_argument(
        "--equalise",
        type=_equalise,
        metavar="object|LEFT,TOP,WIDTH,HEIGHT",
        help="divide out that lamps differ in intensity, by a white patch of the image, or by the object itself, "
        "of which differences that change smoothly from lamp to lamp stay",
    )
    parser.add_argument(
        "--calibrate",
        default="auto",
        type=_calibrate,
        metavar="none|auto|distance,gains,ambient,motion,lights",
        help="what the photographs themselves tell of lamps on several sides, where no other option states it: the "
        "distance of the lamps, the intensity of each, room light, motion of the camera, and whether the list of "
        "lights belongs to them; each is used only where it shows photographs better that are held out (auto: all)",
    )
    parser.add_argument(
        "--lights-form",
        default="listed",
        type=str,
        metavar="listed|mirrored-x|mirrored-y|swapped-xy|turned|reversed|shifted+1|…",
        help="form in which the list of lights is taken, as the report of an import suggests: with an axis turned "
        "round, both (turned), x and y exchanged, or for the photographs in another order (shifted+1: each has the "
        "light of the next one)",
    )
    lights = parser.add_mutually_exclusive_group()
    lights.add_argument(
        "--azimuth",
        type=azimuth_range,
        metavar="DEGREES[±TOLERANCE]",
        help="keep the lights of this azimuth alone, in degrees, 0 = right, 90 = up in the image (±2.5); "
        "+- stands for ±: 90+-10",
    )
    lights.add_argument(
        "--arc", action="store_true", help="keep the lights of one arc: the azimuth ±10° with most elevations"
    )
    lights.add_argument(
        "--lights",
        type=_lights,
        metavar="LIST",
        help="keep these photographs alone: numbers from 1 in the order of the file names, or file names: 1,4-9",
    )
    parser.add_argument(
        "--trust-angles",
        action="store_true",
        help="take angles from bare numbers in file names, or even steps, also where the photographs do not grow "
        "brighter with them",
    )
    parser.add_argument(
        "--strict",
        action="store_true",
        help="refuse a capture of which a photograph cannot be read or shows nothing, in place of leaving that one out",
    )
    parser.add_argument(
        "--use-all",
        action="store_true",
        help="use photographs that show nothing too: black ones, and ones that are clipped all over",
    )


JSON_HELP = """\
JSON: images, height_px, width_px, angle_source, warnings, time_s and peak_memory_bytes are about the stack;
elevations_deg, mean_radiance, clipped_fraction, black_fraction and alignment_residual_px are lists with one entry per
photograph, by rising elevation. A residual is null where it was not measured. profiles are the names of colour profiles
that were applied, working_space is that of maps of the stack, and gamut holds the shares of texels beyond Rec.709 and
beyond that space, and the greatest distance from Rec.709. chart is null without --chart; else it holds the form and
matrix of the correction, ΔE2000 of every patch and in summary before and after, held_out of patches left out, and the
grades of the field's guides. lens is null without --lens; else it holds camera_px, distortion (k1, k2, p1, p2, k3),
residual_px and boards. polarisation is null without pairs; else it holds gain of crossed photographs and
gain_sigma for red, green and blue, leak and leak_sigma, and shifts_px of crossed photographs. scale is null
without --scale; else it holds mm_per_texel, sigma_mm and source. calibration lists what
was looked for in the photographs themselves: name, accepted, text, held_out_before and held_out_after in 8-bit levels,
normals_change_deg, and sigma (of the inverse distance in widths, of the logarithm of gains, of room light over a lamp,
of shifts in pixels). peak_memory_bytes is the largest resident memory of this process plus that of its decoder
processes."""


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    if not any(map(is_archive, arguments.photographs)):
        return _import(arguments, show, None)
    folder = open_session()
    try:
        return _import(arguments, show, folder)
    finally:
        close_session(folder)


def _import(arguments: argparse.Namespace, show: Callable[[Step], None], scratch: Path | None) -> dict[str, Any]:
    """Import what `arguments` say; archives are unpacked in the folder `scratch`."""
    start = time.perf_counter()
    memory = _Memory(show)
    if arguments.write_chart is not None and arguments.chart is None:
        raise UsageError("--write-chart needs --chart, by which colours are corrected")
    if arguments.write_lens is not None and arguments.lens is None:
        raise UsageError("--write-lens needs --lens, by which it is measured")
    settings = choose_settings(arguments)
    sources = drain(find_sources(arguments, arguments.photographs, scratch), show)
    stack = drain(import_stack(sources, settings, arguments.output), memory)
    if arguments.write_lights is not None:
        save_lights(arguments.write_lights, lights_of(stack))
    if arguments.write_chart is not None:
        save_chart(arguments.write_chart, stack.provenance["chart"])
    if arguments.write_lens is not None:
        save_lens(arguments.write_lens, stack.provenance["lens"])
    return {**describe(stack), "time_s": time.perf_counter() - start, "peak_memory_bytes": memory.peak_bytes()}


def find_sources(arguments: argparse.Namespace, paths: list[Path], scratch: Path | None = None) -> Steps[Sources]:
    """The photographs at `paths` as the options say; archives are unpacked in the folder `scratch`."""
    pair = arguments.pair if arguments.pair in ("auto", "none") else Path(arguments.pair)
    outline, aside = outline_of(arguments.sphere), frames_of(arguments)
    return find_packed(paths, arguments.angles_deg, sphere=outline, aside=aside, pair=pair, scratch=scratch)


def frames_of(arguments: argparse.Namespace) -> list[Path]:
    """Files that the options name, which are not photographs of the sample."""
    chosen = [arguments.dark, arguments.flat, arguments.chart, arguments.mask]
    return [path for path in chosen if path is not None and path not in (Path("auto"), Path("alpha"))]


def choose_settings(arguments: argparse.Namespace) -> ImportSettings:
    """The settings of an import that the options say; UsageError for options that do not fit together."""
    if arguments.no_align and arguments.motion != "auto":
        raise UsageError("--motion is of an alignment, which --no-align leaves out: choose one")
    chart: Path | Literal["auto"] | None = "auto" if arguments.chart == Path("auto") else arguments.chart
    mask: Path | Literal["alpha"] | None = "alpha" if arguments.mask == Path("alpha") else arguments.mask
    return ImportSettings(
        motion="none" if arguments.no_align else arguments.motion,
        white_balance=_balance(arguments.white_balance),
        transfer=arguments.transfer,
        working_space=arguments.working_space,
        bands=arguments.bands,
        crop=arguments.crop if arguments.size is None else None,
        framing=_framing(arguments.crop, arguments.corners, arguments.size),
        dark=arguments.dark or "auto",
        flat="none" if arguments.no_flat else arguments.flat or "auto",
        lamp_distance=arguments.lamp_distance,
        lights=_selection(arguments),
        second_sphere=outline_of(arguments.second_sphere),
        equalise=_balance(arguments.equalise),
        trust_angles=arguments.trust_angles,
        strict=arguments.strict,
        use_all=arguments.use_all,
        calibrate=arguments.calibrate,
        lights_form=arguments.lights_form,
        mask=mask,
        estimate_lights=arguments.estimate_lights,
        chart=chart,
        pair_gain=arguments.pair_gain,
        scale=arguments.scale,
        lens=arguments.lens,
    )


def describe(stack: ImageStack) -> dict[str, Any]:
    """The figures of a stack for JSON."""
    return {
        "images": len(stack.sources),
        "height_px": stack.radiance.shape[1],
        "width_px": stack.radiance.shape[2],
        "elevations_deg": stack.elevation_deg.tolist(),
        "angle_source": stack.angle_source,
        "alignment_residual_px": [quality.alignment_residual_px for quality in stack.quality],
        "clipped_fraction": [quality.clipped_fraction for quality in stack.quality],
        "black_fraction": [quality.black_fraction for quality in stack.quality],
        "mean_radiance": [float(mean) for mean in stack.mean_radiance],
        "working_space": stack.provenance.get("working_space"),
        "gamut": stack.provenance.get("gamut"),
        "profiles": stack.provenance.get("profiles") or [],
        "chart": stack.provenance.get("chart"),
        "lens": stack.provenance.get("lens"),
        "polarisation": stack.provenance.get("polarisation"),
        "scale": stack.provenance.get("scale"),
        "calibration": stack.provenance.get("calibration") or [],
        "warnings": stack.health.warnings,
    }


def report(result: dict[str, Any]) -> str:
    """A table for users."""
    rows = zip(
        result["elevations_deg"],
        result["mean_radiance"],
        result["clipped_fraction"],
        result["black_fraction"],
        result["alignment_residual_px"],
        strict=True,
    )
    lines = [
        f"{result['images']} photographs of {result['width_px']} × {result['height_px']} px, "
        f"angles from {result['angle_source']}, {time_text(result['time_s'])}",
        "elevation   mean radiance   clipped     black   residual",
        *(
            f"{angle:8.1f}°   {number(mean, 4):>13}   {percent(clipped):>7}   {percent(black):>7}   "
            + ("       –" if residual is None else f"{number(residual):>5} px")
            for angle, mean, clipped, black, residual in rows
        ),
        *(f"profile: {name}, applied" for name in result["profiles"]),
        *([f"colours: {said}"] if (said := gamut_text(result)) else []),
        *([f"chart: {chart_text(result['chart'])}"] if result["chart"] else []),
        *(
            [f"scale: {scale_text(result['scale'], result['width_px'], result['height_px'])}"]
            if result["scale"]
            else []
        ),
        *([f"pairs: {gain_text(result['polarisation'])}"] if result["polarisation"] else []),
        *(f"calibration: {term['text']}" for term in result["calibration"]),
    ]
    return "\n".join(lines)


class _Memory:
    """Passes steps on, and notes at each how much memory the decoder processes take."""

    def __init__(self, show: Callable[[Step], None]) -> None:
        self.show = show
        self.children_bytes = 0
        self.own_bytes = 0

    def __call__(self, step: Step) -> None:
        process = psutil.Process()
        self.own_bytes = max(self.own_bytes, process.memory_info().rss)
        self.children_bytes = max(self.children_bytes, sum(map(_peak_bytes, process.children())))
        self.show(step)

    def peak_bytes(self) -> int:
        """An upper bound: the peaks of this process and of its children need not be at one time."""
        return max(self.own_bytes, _peak_bytes(psutil.Process())) + self.children_bytes


def _peak_bytes(process: psutil.Process) -> int:
    """The peak resident memory of a process if the system reports it (Linux, Windows), otherwise the present one."""
    try:
        status = Path(f"/proc/{process.pid}/status")
        if status.exists():
            peak = [line for line in status.read_text().splitlines() if line.startswith("VmHWM")]
            return int(peak[0].split()[1]) * 1024 if peak else 0
        memory = process.memory_info()
        return int(getattr(memory, "peak_wset", memory.rss))
    except (psutil.Error, OSError):
        return 0


def _numbers(text: str) -> list[float]:
    return [float(number) for number in text.split(",")]


def _crop(text: str) -> tuple[int, ...]:
    numbers = tuple(int(number) for number in text.split(","))
    if len(numbers) != 4 or min(numbers[:2]) < 0 or min(numbers[2:]) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not LEFT,TOP,WIDTH,HEIGHT with a size of at least 1 × 1")
    return numbers


def _corners(text: str) -> tuple[tuple[float, float], ...]:
    numbers = _numbers(text)
    if len(numbers) != 8:
        raise argparse.ArgumentTypeError(f"{text!r} is not four corners X,Y,X,Y,X,Y,X,Y")
    return tuple(zip(numbers[::2], numbers[1::2], strict=True))


def _size(text: str) -> tuple[int, ...]:
    numbers = tuple(int(number) for number in text.lower().split("x"))
    if len(numbers) != 2 or min(numbers) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not WIDTHxHEIGHT with a size of at least 1x1")
    return numbers


def _framing(crop: Any, corners: Any, size: Any) -> Any:
    """None without corners and size; the corners alone where the size is to follow from them."""
    if crop is not None and corners is not None:
        raise UsageError("--crop and --corners exclude each other")
    if size is None:
        return corners
    if corners is not None:
        return Framing(corners, *size)
    if crop is None:
        raise UsageError("--size needs --corners or --crop, whose part of the photographs gets this size")
    return crop_to_size(Region(*crop), *size)


def _white_balance(text: str) -> str | tuple[float, ...]:
    """'camera', 'none', three multipliers, or the four numbers of a patch."""
    if text in ("camera", "none"):
        return text
    if text.startswith("patch:"):
        return _crop(text.removeprefix("patch:"))
    multipliers = tuple(_numbers(text))
    if len(multipliers) != 3 or not all(0.0 < value < float("inf") for value in multipliers):
        raise argparse.ArgumentTypeError(f"{text!r} is neither camera, none, three positive multipliers nor a patch")
    return multipliers


def _bands(text: str) -> tuple[int, ...]:
    bands = tuple(int(band) for band in text.split(",") if re.fullmatch("[0-9]{1,6}", band.strip()))
    if len(bands) not in (1, 3) or len(bands) != text.count(",") + 1 or min(bands) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is neither one band nor three, which count from 1")
    return bands


def _scale(text: str) -> ScaleChoice:
    points, equals, length = text.rpartition("=")
    try:
        if text == "exif":
            return CameraDistance()
        if not equals:
            return float(text)
        if points == "chart":
            return ChartPitch(float(length))
        if points == "exif":
            return CameraDistance(float(length))
        x0, y0, x1, y1 = _numbers(points)
        return KnownLength((x0, y0), (x1, y1), float(length))
    except ValueError as error:
        reason = f": {error}" if isinstance(error, UsageError) else ""
        raise argparse.ArgumentTypeError(
            f"{text!r} is neither millimetres per pixel, X,Y,X,Y=MM, chart=MM, exif nor exif=MM{reason}"
        ) from None


def _pair(text: str) -> str:
    if text not in ("auto", "none") and not Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"{text!r} is neither auto, none nor the folder of the crossed photographs")
    return text


def _balance(choice: Any) -> Any:
    return GreyPatch(*choice) if isinstance(choice, tuple) and len(choice) == 4 else choice


def _equalise(text: str) -> str | tuple[int, ...]:
    return text if text == "object" else _crop(text)


def _calibrate(text: str) -> str | tuple[str, ...]:
    if text in ("auto", "none"):
        return text
    terms = tuple(term.strip() for term in text.split(","))
    if not set(terms) <= set(CALIBRATED):
        raise argparse.ArgumentTypeError(f"{text!r} is neither none, auto nor a list of {', '.join(CALIBRATED)}")
    return terms


def _sphere(text: str) -> str | tuple[float, ...]:
    if text == "auto":
        return text
    outline = tuple(_numbers(text))
    if len(outline) != 3 or not 2.0 < outline[2] < float("inf"):
        raise argparse.ArgumentTypeError(f"{text!r} is neither auto nor COLUMN,ROW,RADIUS with a radius above 2 px")
    return outline


def outline_of(choice: Any) -> Any:
    return Circle(*choice) if isinstance(choice, tuple) else choice


def azimuth_range(text: str) -> tuple[float, ...]:
    """The azimuth, and the tolerance where one is given, in degrees."""
    numbers = tuple(float(number) for number in text.replace("+-", "±").replace("°", "").split("±"))
    if len(numbers) > 2 or not -360.0 <= numbers[0] <= 360.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not an azimuth of -360 to 360 degrees with a tolerance: 90±10")
    if len(numbers) == 2 and not 0.0 <= numbers[1] <= 180.0:
        raise argparse.ArgumentTypeError(f"{text!r} has a tolerance outside 0 to 180 degrees")
    return numbers


def _lights(text: str) -> tuple[str, ...]:
    items = tuple(item.strip() for item in text.split(","))
    if not all(items):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list such as 1,4-9 or a.tif,b.tif")
    return items


def _selection(arguments: argparse.Namespace) -> Any:
    if arguments.azimuth is not None:
        return Azimuth(*arguments.azimuth)
    if arguments.lights is not None:
        return Listed(arguments.lights)
    return Arc() if arguments.arc else None
