"""Preparation of an import, before its photographs are read for good.

The lights (from a mirror sphere), the exposures, the white balance and the calibration frames.
Cost: nothing for a plain capture whose exposures `capture.toml` states; else a look at the head of every photograph,
and with a mirror sphere or a grey patch each is decoded once more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.capture import scale as physical
from engine.capture.calibration.estimate import Term
from engine.capture.calibration.rig import TERMS
from engine.capture.calibration.separation import MIN_GAIN, Separation
from engine.capture.chart.correction import ColourCorrection
from engine.capture.chart.file import as_json as chart_json
from engine.capture.chart.file import read_chart
from engine.capture.chart.file import text_of as chart_text
from engine.capture.chart.find import Chart, find_chart
from engine.capture.decoded import note_exposure
from engine.capture.gamut import CHOICES, SpaceChoice
from engine.capture.lights.azimuth_spread import ONE_ARC, azimuth_spread, usual_motion
from engine.capture.lights.file_names import join_names, natural, printable, stem_of
from engine.capture.lights.lamp_gains import lamp_gains
from engine.capture.lights.list_forms import LISTED, check_form, in_form
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.lights.selection import Selection, select
from engine.capture.lights.sources import Pairs, Sources, photographs_in
from engine.capture.lights.sphere_lights import measure_lights
from engine.capture.lights.uncalibrated import estimate_lights
from engine.capture.object_outline import ObjectOutline
from engine.capture.photograph.calibration import Calibration, measure_level, read_calibration
from engine.capture.photograph.decode import Photograph, Unreadable, WhiteBalance, read_photograph
from engine.capture.photograph.exposures import Exposure, Noted, Scale, exposure_scale
from engine.capture.photograph.grey_patch import GreyPatch, balance_of
from engine.capture.photograph.lens import Lens, measure_lens, read_lens
from engine.capture.registration.framing import Corners, Framing
from engine.capture.registration.pair_motion import MOTIONS
from engine.capture.registration.polarised_shift import PairShift
from engine.capture.scale import (
    CameraDistance,
    ChartPitch,
    ScaleChoice,
    check_scale,
    scale_of,
    scale_of_camera,
    scale_of_chart,
)
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import number
from engine.core.health import Finding, Verdict
from engine.core.steps import Step, Steps, part

if TYPE_CHECKING:
    from engine.images.decode import TransferChoice
    from engine.images.raster import Transfer

#: What can be estimated from the photographs themselves.
CALIBRATED = (*TERMS, "motion", "lights")

#: Photographs in which a colour chart is looked for, from the highest lamp.
CHART_TRIES = 5

_NO_CHART = (
    "shows no colour chart whose patches can be measured",
    "Photograph a classic chart of 24 patches, wholly in the image, sharp, and neither clipped nor mirroring a lamp; "
    "name that photograph with --chart",
)


@dataclass(frozen=True)
class ImportSettings:
    """Choices of an import.

    Attributes
    ----------
    motion : one of `align.MOTIONS`, 'none' for a camera that stood still, or 'auto': Euclidean for lights on one arc,
        none for lights all around, whose images are too unlike and come from rigs with a fixed camera.
    white_balance : of RAW files: 'camera', 'none', or multipliers of red, green, blue; of all files: a grey patch.
    transfer : of 8- and 16-bit files: 'auto', 'srgb' or 'linear'.
    crop : (left, top, width, height) in pixels of the upright photographs, None for all that they share.
    framing : instead of a crop, the part of the reference photograph that becomes the image, and its size; four
        corners alone are those of a rectangle, whose aspect is estimated and which becomes as large as it is seen.
    reference : file name of the photograph that the others are aligned to; None for what the sources say, else the
        best textured.
    control_points : by file name, pairs (x and y in the reference photograph, x and y in this one) that a user
        marked where alignment fails; they are added to those that the sources give, or replace them. No pairs for a
        name take those away that the sources give.
    dark, flat : calibration frames: 'auto' for those found among the sources, 'none', a file, or a folder with a frame
        of each lamp, named as the photographs or in their order.
    lamp_distance : of a near lamp in widths of the image, infinite for a distant one; None for what the sources say.
    lights : the lights that are kept, None for all.
    second_sphere : outline of a second mirror sphere, or 'auto'; with it the lamps are near, and their positions known.
    equalise : divide out that lamps differ in intensity, by a white patch or by the 'object' itself; None for not.
    trust_angles : take angles that nobody stated also where the photographs do not grow brighter with them.
    strict : refuse photographs that cannot be read or show nothing, also where enough remain without them.
    use_all : use photographs that show nothing too: black ones, and ones that are clipped all over.
    calibrate : what is estimated from the photographs themselves where it is not stated: 'auto' for all, 'none', or
        some of `CALIBRATED`.
    bands : of images of several bands, from 1: one that becomes grey, or three that become red, green and blue; the
        colours of the files without any.
    lights_form : the form in which the list of lights is taken, see `engine.capture.lights.list_forms`.
    chart : the colour chart by which colours are corrected: 'auto' for one that a photograph of the capture shows, the
        file of another photograph under the same lamps, or a `.chart` file; None for no correction.
    mask : an image whose white pixels show the object, 'alpha' for the opaque pixels of the photographs, or an outline
        around the object in pixels of the reference photograph; None where all is object.
    estimate_lights : estimate the lights from the photographs alone (`engine.capture.lights.uncalibrated`).
    scale : millimetres per pixel of the photographs, or a length or chart that tells it (`engine.capture.scale`); None
        where it is not known.
    lens : a `.lens` file, or a folder of photographs of a chessboard by the same lens, whose distortion is taken off;
        None for none.
    working_space : the space in which maps of the capture are made, 'auto' for Rec.2020 where colours go beyond Rec.709
        (`engine.capture.gamut`).
    pair_gain : of pairs under polarisers, the brightness of crossed photographs over the diffuse part of parallel ones,
        as measured on a matte white patch; None to estimate it.
    """

    motion: Literal["auto", "none", "translation", "euclidean", "affine", "homography"] = "auto"
    white_balance: WhiteBalance | GreyPatch = "camera"
    transfer: Literal["auto", "srgb", "linear"] = "auto"
    crop: tuple[int, int, int, int] | None = None
    framing: Framing | Corners | None = None
    reference: str | None = None
    control_points: Mapping[str, Pairs] = field(default_factory=dict)
    dark: Path | Literal["auto", "none"] = "auto"
    flat: Path | Literal["auto", "none"] = "auto"
    lamp_distance: float | None = None
    lights: Selection | None = None
    second_sphere: Circle | Literal["auto"] | None = None
    equalise: GreyPatch | Literal["object"] | None = None
    trust_angles: bool = False
    strict: bool = False
    use_all: bool = False
    calibrate: Literal["auto", "none"] | tuple[str, ...] = "auto"
    lights_form: str = LISTED
    bands: tuple[int, ...] = ()
    chart: Path | Literal["auto"] | None = None
    mask: Path | Literal["alpha"] | ObjectOutline | None = None
    estimate_lights: bool = False
    pair_gain: float | None = None
    scale: ScaleChoice | None = None
    lens: Path | None = None
    working_space: SpaceChoice = "rec709"

    def __post_init__(self) -> None:
        check_scale(self.scale)
        if self.working_space not in CHOICES:
            raise UsageError(f"unknown working space {self.working_space!r}; choose from {', '.join(CHOICES)}")
        if isinstance(self.scale, ChartPitch) and self.chart is None:
            raise UsageError("a scale by the chart needs a photograph that shows one: give chart as well")
        check_form(self.lights_form)
        if self.calibrate not in ("auto", "none") and not set(self.calibrate) <= set(CALIBRATED):
            raise UsageError(f"unknown calibration {self.calibrate!r}; choose from auto, none, {', '.join(CALIBRATED)}")
        if len(self.bands) not in (0, 1, 3) or min(self.bands, default=1) < 1:
            raise UsageError(f"bands {self.bands} are not one or three, which count from 1")
        if self.motion not in ("auto", "none", *MOTIONS):
            raise UsageError(f"unknown motion {self.motion!r}; choose from auto, none, {', '.join(MOTIONS)}")
        if self.transfer not in ("auto", "srgb", "linear"):
            raise UsageError(f"unknown transfer {self.transfer!r}; choose from auto, srgb, linear")
        if self.crop is not None and (min(self.crop[:2]) < 0 or min(self.crop[2:]) < 1):
            raise UsageError(f"crop {self.crop} needs left and top from 0, width and height from 1")
        if self.crop is not None and self.framing is not None:
            raise UsageError("a crop and a framing cannot both be followed")
        if self.framing is not None and not isinstance(self.framing, Framing):
            Framing(self.framing, 1, 1)
        if self.equalise is not None and self.equalise != "object" and not isinstance(self.equalise, GreyPatch):
            raise UsageError(f"lamps are equalised by a white patch or by the object, not by {self.equalise!r}")
        if self.pair_gain is not None and not MIN_GAIN <= self.pair_gain <= 1.0 / MIN_GAIN:
            raise UsageError(f"pair_gain {self.pair_gain:g} is not between {MIN_GAIN:g} and {1.0 / MIN_GAIN:g}")
        if self.lamp_distance is not None and not self.lamp_distance > 0.5:
            raise UsageError(f"lamp_distance {self.lamp_distance:g} is not above half a width of the image")


@dataclass(frozen=True, eq=False)
class Plan:
    """Settled choices of an import, before the first photograph is kept; `as_codes` where these may be what is kept."""

    sources: Sources
    settings: ImportSettings
    dark: Path | None
    flat: Path | None
    calibration: Calibration
    scale: Scale
    options: Mapping[str, Any]
    gains: NDArray[np.float64]
    terms: tuple[Term, ...] = ()
    room_light: tuple[float, ...] | None = None
    held_out: float | None = None
    undecided_deg: tuple[float, float] | None = None
    rival_deg: float = 0.0
    suggested_form: str = LISTED
    suggested_transfer: Transfer | None = None
    chart: tuple[ColourCorrection, str] | None = None
    separation: Separation | None = None
    size_of_pixel: physical.Scale | None = None
    pair_shift: PairShift | None = None
    as_codes: bool = True

    @property
    def nearness(self) -> float:
        """Inverse distance of the lamps in widths of the image, 0 for distant ones."""
        if not self.calibration.flats:
            return 1.0 / self.calibration.lamp_distance
        return 1.0 / (self.settings.lamp_distance or self.sources.lamp_distance or math.inf)

    @property
    def has_pairs(self) -> bool:
        """True where the photographs are pairs under parallel and crossed polarisers."""
        return bool(self.sources.crossed)

    def crossed_matrices(self, matrices: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """(N, 3, 3) from pixels of the reference to those of crossed photographs, of those to parallel ones; None where
        both lie on each other."""
        if self.pair_shift is None or not self.pair_shift.shifts.any():
            return None
        beside = np.tile(np.eye(3), (len(matrices), 1, 1))
        beside[:, :2, 2] = self.pair_shift.shifts
        return np.asarray(beside @ matrices)

    @property
    def files(self) -> list[Path]:
        """All photographs in the order in which they are read."""
        return [path for light in range(len(self.sources.photographs)) for path in self.sources.files(light)]

    @property
    def names(self) -> list[str]:
        return [printable(path) for path in self.sources.photographs]

    def as_json(self) -> dict[str, Any]:
        """The settled choices as JSON, for the provenance."""
        patch, sphere, distance = self.settings.white_balance, self.sources.sphere, self.calibration.lamp_distance
        if self.calibration.flats:
            distance = 1.0 / self.nearness if self.nearness else math.inf
        marked, unpacked = self.settings.control_points, self.sources.unpacked
        return {
            "notes": self.sources.notes,
            "angle_source": self.sources.angle_source,
            "archive": printable(unpacked.archive) if unpacked else None,
            "sphere_px": [sphere.column, sphere.row, sphere.radius] if isinstance(sphere, Circle) else None,
            "highlights_px": self._highlights(),
            "dark": printable(self.dark) if self.dark else None,
            "flat": printable(self.flat) if self.flat else None,
            "flat_of_lamps": self._names_of_frames(self.calibration.flats),
            "dark_of_lamps": self._names_of_frames(self.calibration.darks),
            "lamp_distance_widths": distance if math.isfinite(distance) else None,
            "reference_exposure_s": self.scale.reference,
            "grey_patch_px": [patch.left, patch.top, patch.width, patch.height]
            if isinstance(patch, GreyPatch)
            else None,
            "picture_balance": list(self.calibration.balance),
            "motion": self.settings.motion,
            "lamp_gains": [float(gain) for gain in self.gains] if (self.gains != 1.0).any() else None,
            "lights_form": self.settings.lights_form,
            "suggested_lights_form": self.suggested_form if self.suggested_form != LISTED else None,
            "suggested_transfer": self.suggested_transfer,
            "bands": list(self.settings.bands),
            "lights_sigma_deg": math.degrees(self.sources.lamp_sigma["directions"])
            if "directions" in self.sources.lamp_sigma
            else None,
            "lights_convex_assumed": "convexity" in self.sources.lamp_sigma or None,
            "chart": chart_json(*self.chart) if self.chart else None,
            "room_light": list(self.room_light) if self.room_light else None,
            "lens": self.calibration.lens.as_json() if self.calibration.lens is not None else None,
            "polarisation": self._polarisation(),
            "calibration": [term.as_json() for term in self.terms],
            "calibration_held_out": self.held_out,
            "calibration_undecided_deg": self.undecided_deg,
            "calibration_rival_deg": self.rival_deg,
            "control_points_px": {name: [list(map(float, one)) for one in pairs] for name, pairs in marked.items()},
        }

    def _names_of_frames(self, frames: Mapping[Path, Path]) -> dict[str, str] | None:
        return {printable(path): printable(frames[path]) for path in self.sources.photographs if path in frames} or None

    def _polarisation(self) -> dict[str, Any] | None:
        if self.separation is None:
            return None
        shift = self.pair_shift.as_json() if self.pair_shift is not None else {}
        crossed = {printable(one): printable(other) for one, other in self.sources.crossed.items()}
        return {**self.separation.as_json(), **shift, "crossed": {name: crossed[name] for name in self.names}}

    def _highlights(self) -> dict[str, list[float]]:
        """The lamp's reflections that a user corrected, where they counted."""
        spots = self.sources.highlights_px if self.sources.sphere is not None else ()
        return {name: list(spot) for name, spot in zip(self.names, spots, strict=False) if spot is not None}

    def reduced(self, sources: Sources) -> Plan:
        """The same for `sources`, some of the lights; what was chosen for the others goes with them."""
        names = [printable(path) for path in sources.photographs]
        settings = replace(
            self.settings,
            reference=self.settings.reference if self.settings.reference in names else None,
            control_points={name: pairs for name, pairs in self.settings.control_points.items() if name in names},
        )
        kept = np.array([name in names for name in self.names])
        return replace(self, sources=sources, settings=settings, gains=self.gains[kept])

    @property
    def reference(self) -> int | None:
        """The index of the photograph that the others are to be aligned to, if one was named."""
        return self.names.index(self.settings.reference) if self.settings.reference else None

    @property
    def shows_codes(self) -> bool:
        """True if radiance is the decoded code of one file: nothing was divided out, and no exposures merged."""
        frames, lights = self.calibration, self.sources.exposures
        is_plain = (
            self.chart is None
            and not self.has_pairs
            and frames.dark is None
            and frames.gain is None
            and frames.lens is None
            and not frames.flats
            and not frames.darks
            and not math.isfinite(frames.lamp_distance)
        )
        factors = [*self.scale.factor.values(), *frames.balance, *self.gains.tolist()]
        return is_plain and all(len(light) == 1 for light in lights) and all(factor == 1.0 for factor in factors)

    @property
    def still_camera(self) -> bool:
        """True if the camera may be taken to have stood still, but for small motion that is taken off."""
        return not self.settings.control_points and self.settings.motion in ("none", "translation")

    @property
    def still(self) -> bool:
        return self.settings.motion == "none" and not self.settings.control_points

    @property
    def calibrated(self) -> tuple[str, ...]:
        """Terms to estimate: chosen, not stated otherwise, and told by lamps on several sides."""
        if self.settings.calibrate == "none" or azimuth_spread(self.sources.azimuth) <= ONE_ARC:
            return ()
        chosen = CALIBRATED if self.settings.calibrate == "auto" else self.settings.calibrate
        if self.settings.estimate_lights:  # whose assumptions are those of the terms
            return ()
        stated = {
            "distance": self.settings.lamp_distance is not None
            or self.sources.lamp_distance is not None
            or bool(self.calibration.flats),
            "gains": self.settings.equalise is not None
            or bool(self.sources.lamp_gains)
            or bool(self.calibration.flats),
            "ambient": self.dark is not None or bool(self.calibration.darks),
            "motion": bool(self.settings.control_points),
            "lights": self.sources.sphere is not None or self.settings.lights_form != LISTED,
        }
        if self.suggested_form != LISTED:  # what is estimated under wrong lights is wrong
            chosen = tuple(term for term in chosen if term == "lights")
        if (
            self.suggested_transfer and self.options["transfer"] == "auto"
        ):  # what is estimated of a wrong curve is wrong
            chosen = tuple(term for term in chosen if term not in TERMS)
        return tuple(term for term in chosen if not stated.get(term, False))


def plan(sources: Sources, settings: ImportSettings, white_code: int = 0) -> Steps[Plan]:
    """Measure the lights, the exposures and the white balance, and read the calibration frames.

    `white_code` is the full scale of files of 16 bits, where it is known and not 0.
    """
    transfer: TransferChoice = settings.transfer
    if transfer == "auto":
        transfer = sources.transfer or "auto"
    reading: dict[str, Any] = {"transfer": transfer, "bands": settings.bands}
    if white_code:
        reading["white_code"] = white_code
    if sources.sphere is not None:
        sources = yield from part(measure_lights(sources, transfer, settings.second_sphere), 0.0, 0.5)
    elif settings.estimate_lights:
        sources = yield from part(estimate_lights(sources, transfer), 0.0, 0.5)
    elif settings.second_sphere is not None:
        place, remedy = sources.photographs[0].parent, "Give --sphere COLUMN,ROW,RADIUS or auto as well"
        raise InputError(place, "has no first mirror sphere that a second could add to", remedy)
    _refuse_incomplete_pairs(sources, settings)
    sources = in_form(sources, settings.lights_form)
    if settings.lights is not None:
        sources = select(sources, settings.lights)
    settings = _decide(settings, sources)
    noted = yield from part(_note(sources), 0.5, 0.6)
    crossed = [(Exposure(sources.crossed[path], None),) for path in sources.photographs if path in sources.crossed]
    scale = exposure_scale([*sources.exposures, *crossed], noted)
    _refuse_unknown_exposures(sources, scale)
    _refuse_unknown_names(settings, sources)
    gains = np.array([sources.lamp_gains.get(printable(path), 1.0) for path in sources.photographs])
    if settings.equalise is not None:
        gains = yield from part(lamp_gains(sources, settings.equalise, scale, reading), 0.6, 0.7)
        sources = replace(sources, findings=(*sources.findings, _about_gains(settings, gains)))
    darks, flats = (_frames_of_lamps(choice, sources) for choice in (settings.dark, settings.flat))
    dark, flat = (
        None if apart else _frame(choice, found)
        for apart, choice, found in ((darks, settings.dark, sources.dark), (flats, settings.flat, sources.flat))
    )
    if flats and dark is not None:
        darks, dark = dict.fromkeys(sources.photographs, dark), None
    balance: WhiteBalance = "none"
    for_images = (1.0, 1.0, 1.0)
    if isinstance(settings.white_balance, GreyPatch):
        paths = list(sources.photographs)
        for_images = yield from part(balance_of(paths, settings.white_balance, reading), 0.7, 0.9)
        balance = for_images
    elif settings.white_balance == "camera" and (dark or flat):
        yield Step(0.6, "Reading the white balance")
        balance = read_photograph(sources.photographs[0], half_size=True).white_balance
    else:
        balance = settings.white_balance
    distance = settings.lamp_distance or sources.lamp_distance or math.inf
    sources = replace(sources, findings=(*sources.findings, *_about_near_lamp(distance, sources.azimuth)))
    options = {"white_balance": balance, **reading}
    fall_off = math.inf if flats else distance  # which the flat field of a lamp shows as well
    calibration = yield from part(read_calibration(dark, flat, fall_off, for_images, options), 0.9, 0.95)
    if flats or darks:
        of_pairs = [(one, other) for one, other in sources.crossed.items() if one in sources.photographs]
        flats, darks = (
            {**frames, **{other: frames[one] for one, other in of_pairs if one in frames}} for frames in (flats, darks)
        )
        calibration = replace(calibration, flats=flats, darks=darks, options=options)
    if flats:
        elevations = dict(zip(sources.photographs, sources.elevation.tolist(), strict=True))
        own = {path: flats[path] for path in sources.photographs}
        level = yield from part(measure_level(own, darks, elevations, options), 0.95, 0.97)
        calibration = replace(calibration, level=level)
        text = "Each lamp was divided by its own flat field, so that all are equally bright and even over the sample"
        sources = replace(sources, findings=(*sources.findings, Finding(Verdict.NOTE, text)))
    if settings.lens is not None:
        lens = yield from part(_read_lens(settings.lens, options), 0.95, 0.97)
        calibration = replace(calibration, lens=lens)
        sources = replace(sources, findings=(*sources.findings, Finding(Verdict.NOTE, lens.text())))
    chart, size_of_pixel = None, None
    if settings.chart is not None:
        chart, found = yield from part(_read_chart(settings.chart, sources, calibration, options), 0.95, 1.0)
        if isinstance(settings.scale, ChartPitch):
            size_of_pixel = _scale_by_chart(settings.scale, found, Path(chart[1]))
        sources = replace(sources, findings=(*sources.findings, Finding(Verdict.NOTE, chart_text(chart_json(*chart)))))
    if isinstance(settings.scale, CameraDistance):
        yield Step(1.0, "Reading the scale")
        first = sources.photographs[0]
        size_of_pixel = _scale_by_camera(settings.scale, read_photograph(first, half_size=True, **reading))
    elif settings.scale is not None and not isinstance(settings.scale, ChartPitch):
        size_of_pixel = scale_of(settings.scale)
    terms = _stated_terms(sources, settings)
    plan = Plan(sources, settings, dark, flat, calibration, scale, options, gains, terms, chart=chart)
    return replace(plan, size_of_pixel=size_of_pixel)


def _read_lens(choice: Path, options: Mapping[str, Any]) -> Steps[Lens]:
    if choice.is_dir():
        return (yield from measure_lens(photographs_in(choice), choice, dict(options)))
    yield Step(0.0, "Reading the lens")
    return read_lens(choice)


def _scale_by_chart(choice: ChartPitch, found: Chart | None, place: Path) -> physical.Scale:
    if found is None:
        problem = "does not say where the patches of the chart are in the photographs"
        raise InputError(place, problem, "Name a photograph that shows the chart with --chart, not a .chart file")
    try:
        return scale_of_chart(found.positions, choice.pitch_mm)
    except UsageError as error:
        raise InputError(place, f"does not show the scale: {error}", "Lay it flat next to the sample") from None


def _scale_by_camera(choice: CameraDistance, photograph: Photograph) -> physical.Scale:
    distance_mm = choice.distance_mm
    if distance_mm is None and photograph.distance_m is not None:
        distance_mm = 1000.0 * photograph.distance_m
    known = {"focal length": photograph.focal_mm, "size of the sensor's pixels": photograph.pitch_mm}
    missing = [name for name, value in {**known, "distance": distance_mm}.items() if value is None]
    if photograph.focal_mm is None or photograph.pitch_mm is None or distance_mm is None:
        remedy = "State the scale, mark a known length, or show a chart"
        if missing == ["distance"]:
            remedy = "Measure the distance from the sample to the sensor and give it with --scale exif=MM"
        problem = f"does not note the {' and the '.join(missing)}, from which a scale could be estimated"
        raise InputError(photograph.path, problem, remedy)
    try:
        is_measured = choice.distance_mm is not None
        return scale_of_camera(photograph.focal_mm, photograph.pitch_mm, distance_mm, is_measured=is_measured)
    except UsageError as error:
        raise InputError(photograph.path, f"does not show the scale: {error}", "Measure the distance again") from None


def about_camera_scale(photograph: Photograph) -> tuple[Finding, ...]:
    """A finding on the scale that the camera's notes suggest, which is not used unless a user asks for it."""
    if photograph.distance_m is None or photograph.focal_mm is None or photograph.pitch_mm is None:
        return ()
    try:
        found = scale_of_camera(
            photograph.focal_mm, photograph.pitch_mm, 1000.0 * photograph.distance_m, is_measured=False
        )
    except UsageError:
        return ()
    low, high = (number(found.mm_per_pixel + side * 2.0 * found.sigma) for side in (-1.0, 1.0))
    size = f"{number(found.mm_per_pixel)} mm per pixel (95 % interval {low} to {high})"
    text = f"The camera's notes suggest {size}, which is not used: --scale exif takes this estimate"
    return (Finding(Verdict.NOTE, text),)


def _read_chart(
    chosen: Path | str, sources: Sources, calibration: Calibration, options: Mapping[str, Any]
) -> Steps[tuple[tuple[ColourCorrection, str], Chart | None]]:
    """The correction by a chart and the name of what shows it, and the chart where a photograph shows it.

    Raises InputError where no chart is found.
    """
    if isinstance(chosen, Path) and chosen.suffix.lower() == ".chart":
        return read_chart(chosen), None
    if isinstance(chosen, Path):
        yield Step(0.0, "Looking for the colour chart")
        plain = replace(calibration, lamp_distance=math.inf)
        photograph = plain.applied(read_photograph(chosen, **options), 0.5 * math.pi, 0.0, 1.0)
        found = find_chart(photograph.radiance, photograph.saturated)
        if found is not None:
            return (found[1], printable(chosen)), found[0]
        raise InputError(chosen, *_NO_CHART)
    order = np.argsort(-sources.elevation, kind="stable")[:CHART_TRIES]
    for tried, index in enumerate(order):
        yield Step(tried / len(order), "Looking for the colour chart")
        path = sources.photographs[index]
        azimuth = 0.0 if sources.azimuth is None else float(sources.azimuth[index])
        photograph = calibration.applied(
            read_photograph(path, **options), float(sources.elevation[index]), azimuth, 1.0
        )
        found = find_chart(photograph.radiance, photograph.saturated)
        if found is not None:
            return (found[1], printable(path)), found[0]
    raise InputError(sources.photographs[0].parent, *_NO_CHART)


def _stated_terms(sources: Sources, settings: ImportSettings) -> tuple[Term, ...]:
    """What a file of lights states with its deviations and `settings` do not override, as an estimation finds it."""
    near = sources.lamp_distance or math.inf
    overridden = {"distance": settings.lamp_distance is not None, "gains": settings.equalise is not None}
    texts = {
        "distance": f"The file of lights states that the lamps are {near:.3g} image widths away",
        "gains": "The file of lights states the intensity of each lamp",
    }
    stated = {name: sigma for name, sigma in sources.lamp_sigma.items() if not overridden.get(name, True)}
    return tuple(Term(name, True, texts[name], 0.0, 0.0, 0.0, sigma) for name, sigma in stated.items())


def _about_gains(settings: ImportSettings, gains: NDArray[np.float64]) -> Finding:
    of_object = (
        ""
        if isinstance(settings.equalise, GreyPatch)
        else ("; differences that change smoothly over the lamps cannot be separated from the reflectance and stay")
    )
    source = "the object" if of_object else "the white patch"
    text = (
        f"Lamps were equalised by {source}: their intensities were {gains.min():.2f} to {gains.max():.2f} of the median"
    )
    return Finding(Verdict.NOTE, text + of_object)


def _frames_of_lamps(choice: Path | str, sources: Sources) -> dict[Path, Path]:
    """The frame of each lamp by its photograph, from a folder; empty where a choice is no folder.

    InputError for a folder whose files do not belong to the photographs.
    """
    if not isinstance(choice, Path) or not choice.is_dir():
        return {}
    if any(len(light) > 1 for light in sources.exposures):
        problem = "holds frames of each lamp, and the photographs are several exposures of each"
        raise InputError(choice, problem, "Give one frame for all, or one exposure of each light")
    frames = photographs_in(choice)
    names = {stem_of(frame): frame for frame in frames}
    if len(names) == len(frames) and {stem_of(path) for path in sources.photographs} <= names.keys():
        return {path: names[stem_of(path)] for path in sources.photographs}
    if len(frames) != len(sources.photographs):
        problem = f"holds {len(frames)} frames for {len(sources.photographs)} photographs, with other names"
        raise InputError(choice, problem, "Give one frame for each photograph, with its name or in the same order")
    ordered = sorted(sources.photographs, key=lambda path: natural(path.name))
    return dict(zip(ordered, frames, strict=True))


def _frame(choice: Path | str, found: Path | None) -> Path | None:
    if isinstance(choice, Path):
        return choice
    return found if choice == "auto" else None


def _decide(settings: ImportSettings, sources: Sources) -> ImportSettings:
    stated = {printable(path): pairs for path, pairs in sources.control_points.items()}
    calibrate = settings.calibrate
    if settings.motion != "auto" and calibrate != "none":
        chosen = CALIBRATED if calibrate == "auto" else calibrate
        calibrate = tuple(term for term in chosen if term != "motion")
    return replace(
        settings,
        calibrate=calibrate,
        motion=settings.motion if settings.motion != "auto" else usual_motion(sources.azimuth),
        reference=settings.reference or (printable(sources.reference) if sources.reference else None),
        control_points={name: pairs for name, pairs in {**stated, **settings.control_points}.items() if len(pairs)},
    )


def _about_near_lamp(distance: float, azimuth: NDArray[np.float64] | None) -> list[Finding]:
    if not math.isfinite(distance) or azimuth is not None:
        return []
    text = (
        "The lamp is near, but nothing says on which side it stood: its fall-off is corrected as if it stood on the "
        "right. State azimuth_deg in capture.toml, give an .lp file, or measure the lights on a mirror sphere"
    )
    return [Finding(Verdict.WARNING, text)]


def _note(sources: Sources) -> Steps[dict[Path, Noted]]:
    """Exposures that cameras noted, if `capture.toml` does not give all of them."""
    paths = [path for light in range(len(sources.photographs)) for path in sources.files(light)]
    if not sources.crossed and all(one.exposure_s for light in sources.exposures for one in light):
        return {}
    noted = {}
    for index, path in enumerate(paths):
        yield Step(index / len(paths), "Reading exposures")
        try:
            noted[path] = note_exposure(path)
        except InputError as error:
            raise Unreadable(error.path, error.problem, error.remedy) from None
    return noted


def _refuse_unknown_names(settings: ImportSettings, sources: Sources) -> None:
    """Marks are of photographs that are there, one for each light, and not of the reference itself."""
    known, reference = [printable(path) for path in sources.photographs], settings.reference
    place = sources.photographs[0].parent
    if reference is not None and reference not in known:
        problem = f"holds no {reference}, to which the others are to be aligned"
        raise InputError(place, problem, "Name a photograph that is there, the shortest exposure of its light")
    if reference in settings.control_points:
        problem = f"gives control points for {reference}, to which the others are aligned"
        raise InputError(place, problem, "Remove them, or name another reference")
    unknown = [name for name in settings.control_points if name not in known]
    if unknown:
        problem = f"holds no {', '.join(unknown)}, for which control points are given"
        raise InputError(sources.photographs[0].parent, problem, "Mark points in the photographs that are there")


def _refuse_incomplete_pairs(sources: Sources, settings: ImportSettings) -> None:
    place = sources.photographs[0].parent
    alone = [printable(path) for path in sources.photographs if path not in sources.crossed]
    if sources.crossed and alone:
        problem = f"holds pairs under polarisers, but {join_names(alone)} has no crossed photograph"
        raise InputError(place, problem, "Add it, or take the parallel one out")
    if settings.pair_gain is not None and not sources.crossed:
        raise InputError(place, "holds no pairs under polarisers, of which a gain is stated", "Import it without")


def _refuse_unknown_exposures(sources: Sources, scale: Scale) -> None:
    for light in sources.exposures:
        unknown = [one.path.name for one in light if one.path not in scale.relative]
        if len(light) > 1 and (unknown or not scale.factor):
            problem = f"{' and '.join(one.path.name for one in light)} cannot be merged: not all exposures are known"
            raise InputError(light[0].path.parent, problem, "State exposure_s of all photographs in capture.toml")
