"""The virtual light arc: its settings, and the photographs that follow from them.

Angles are in radians; azimuth 0 = right, pi/2 = up in the image. Every azimuth is photographed at every elevation,
and every light with every exposure. The first light is photographed from where the camera should be, and at the others
it has wandered; the exposures of one light follow so closely that it stands still.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.mirror_sphere import Circle
from engine.core.errors import UsageError
from engine.core.params import check, param
from engine.simulate.height_fields import SAMPLES

FORMATS = {"tiff": ".tif", "exr": ".exr", "dng": ".dng"}
ELEVATIONS_DEG = (5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0)
RAW_BITS = (12, 14)

#: Lowest and highest elevation of the lamps of a dome.
DOME_DEG = (15.0, 75.0)

#: By this file a folder is known to be a simulated capture, which a later one may replace.
MARKER = "truth/truth.json"

#: Exposure time of the relative exposure 1; radiance is in units of what it brings to the white level.
EXPOSURE_S = 1 / 60
NEAREST_LAMP = 0.75


@dataclass(frozen=True)
class LightArc:
    """Settings of the virtual light arc.

    Attributes
    ----------
    elevation, azimuth : of the lamp, seen from the middle of the sample.
    exposure : relative exposures of every light, for captures that are to be merged.
    lamp_distance : from the middle of the image, in its widths; None for a lamp so far away that its light is even.
    calibration : whether a dark frame and a flat field are photographed too.
    sphere : whether a mirror sphere lies in the lower left corner of the image.
    raw_bits : of the samples of RAW files, 12 or 14.
    """

    sample: str = "woven"
    elevation: tuple[float, ...] = tuple(math.radians(angle) for angle in ELEVATIONS_DEG)
    azimuth: tuple[float, ...] = (0.0,)
    size: int = 512
    format: str = "tiff"
    interreflection: bool = True
    seed: int = 1
    exposure: tuple[float, ...] = (1.0,)
    lamp_distance: float | None = None
    calibration: bool = False
    sphere: bool = False
    raw_bits: int = 14
    noise: float = param(0.004, 0.0, 0.2, doc="Standard deviation of the noise at the white level.", log=True)
    misalignment_px: float = param(0.6, 0.0, 16.0, unit="px", doc="Largest shift of a photograph along each axis.")
    turn: float = param(0.0, 0.0, math.pi / 12, unit="rad", doc="Largest turn of a photograph about its middle.")
    corner_loss: float = param(0.0, 0.0, 0.9, doc="Share of the light that the lens loses in the corners.")
    dark: float = param(0.0, 0.0, 0.2, doc="Mean signal of the sensor without light, in units of the white level.")

    def __post_init__(self) -> None:
        check(self)
        if self.sample not in SAMPLES:
            raise UsageError(f"unknown sample {self.sample!r}; choose from {', '.join(SAMPLES)}")
        if self.format not in FORMATS:
            raise UsageError(f"unknown format {self.format!r}; choose from {', '.join(FORMATS)}")
        if not 16 <= self.size <= 2048:
            raise UsageError(f"size {self.size} px is outside [16, 2048]")
        if not self.elevation or not all(math.radians(1) <= angle <= math.pi / 2 for angle in self.elevation):
            raise UsageError("elevations must lie in [1, 90] degrees")
        if not self.azimuth or not all(0 <= angle < 2 * math.pi for angle in self.azimuth):
            raise UsageError("azimuths must lie in [0, 360) degrees")
        if not self.exposure or not all(1e-4 <= exposure <= 1e4 for exposure in self.exposure):
            raise UsageError("exposures must lie in [0.0001, 10000]")
        if len(set(self.exposure)) < len(self.exposure):
            raise UsageError("two exposures are equal")
        if self.lamp_distance is not None and not NEAREST_LAMP <= self.lamp_distance < math.inf:
            raise UsageError(f"the lamp must be at least {NEAREST_LAMP} widths of the image away")
        if self.seed < 0:
            raise UsageError(f"seed {self.seed} is negative")
        if self.raw_bits not in RAW_BITS:
            raise UsageError(f"RAW files have {' or '.join(map(str, RAW_BITS))} bits, not {self.raw_bits}")
        names = [shot.file for shot in shots(self)]
        if len(set(names)) < len(names):
            raise UsageError("two photographs have the same angles")


@dataclass(frozen=True)
class Shot:
    """One photograph: its file, its lamp and exposure, and how its image is turned (counter-clockwise) and moved.

    A point p of the sample, in pixels from the middle of the image, right and down, is seen at R p + shift.
    """

    file: str
    elevation: float
    azimuth: float
    exposure: float
    right_px: float
    down_px: float
    turn: float

    @property
    def exposure_s(self) -> float:
        return self.exposure * EXPOSURE_S

    def alignment_matrix(self, size: int) -> NDArray[np.float64]:
        """(2, 3) from pixels of the sample to pixels of the photograph, pixel centres at integers."""
        cosine, sine, middle = math.cos(self.turn), math.sin(self.turn), (size - 1) / 2
        right = self.right_px + middle * (1 - cosine - sine)
        down = self.down_px + middle * (1 - cosine + sine)
        return np.array([[cosine, sine, right], [-sine, cosine, down]])


def shots(arc: LightArc) -> tuple[Shot, ...]:
    """The photographs in the order in which they are taken, the exposures of a light one after the other."""
    lamps = [(elevation, azimuth) for azimuth in arc.azimuth for elevation in arc.elevation]
    wander = np.random.default_rng((arc.seed, 1)).uniform(-1, 1, (len(lamps), 2)) * arc.misalignment_px
    turn = np.random.default_rng((arc.seed, 3)).uniform(-1, 1, len(lamps)) * arc.turn
    wander[0], turn[0] = 0.0, 0.0
    return tuple(
        Shot(_file_name(arc, *lamp, exposure), *lamp, exposure, float(right), float(down), float(angle))
        for lamp, (right, down), angle in zip(lamps, wander, turn, strict=True)
        for exposure in arc.exposure
    )


def sphere(arc: LightArc) -> Circle:
    """Outline of the mirror sphere in pixels of the sample."""
    return Circle(0.13 * arc.size, 0.87 * arc.size, 0.1 * arc.size)


def calibration_file(arc: LightArc, name: str) -> str:
    """File of the frame `name`, 'dark' or 'flat'."""
    return name + FORMATS[arc.format]


def dome_azimuths_deg(count: int) -> tuple[float, ...]:
    """Azimuths of `count` arcs of lamps evenly around the sample, the first at the right."""
    return tuple(round(360.0 * index / count, 6) for index in range(count))


def dome_elevations_deg(count: int) -> tuple[float, ...]:
    """`count` elevations evenly over `DOME_DEG`, one in their middle."""
    if count == 1:
        return (sum(DOME_DEG) / 2,)
    return tuple(round(float(angle), 6) for angle in np.linspace(*DOME_DEG, count))


def degrees(angle: float) -> float:
    return round(math.degrees(angle), 9)


def _file_name(arc: LightArc, elevation: float, azimuth: float, exposure: float) -> str:
    turn = f"_azimuth{_number(azimuth, 3)}" if len(arc.azimuth) > 1 else ""
    bracket = f"_exposure{arc.exposure.index(exposure) + 1}" if len(arc.exposure) > 1 else ""
    return f"{arc.sample}{turn}_{_number(elevation, 2)}{bracket}{FORMATS[arc.format]}"


def radiance_file(shot: Shot) -> str:
    """File of the noise-free radiance of a photograph, one for all exposures of a light."""
    return f"radiance_{Path(shot.file).stem.partition('_exposure')[0]}.exr"


def _number(angle: float, digits: int) -> str:
    """Whole degrees padded with zeros, so that names sort by angle; a fraction only where there is one."""
    text = f"{degrees(angle):g}"
    whole, point, fraction = text.partition(".")
    return whole.zfill(digits) + point + fraction


def capture_toml(arc: LightArc) -> str:
    """A photographer's notes: angles and exposures, and the calibration files."""
    lines = [f"notes = {json.dumps(f'{arc.sample} sample on the virtual light arc')}"]
    if arc.format == "tiff":
        lines += ['transfer = "srgb"']
    if arc.calibration:
        lines += [f"{name} = {json.dumps(calibration_file(arc, name))}" for name in ("dark", "flat")]
    if arc.lamp_distance is not None:
        lines += [f"lamp_distance = {arc.lamp_distance}"]
    for shot in shots(arc):
        lines += [
            "",
            "[[photographs]]",
            f"file = {json.dumps(shot.file)}",
            f"elevation_deg = {degrees(shot.elevation)}",
            f"azimuth_deg = {degrees(shot.azimuth)}",
            f"exposure_s = {shot.exposure_s}",
        ]
    if arc.sphere:
        ball = sphere(arc)
        lines += ["", "[sphere]"]
        lines += [f"column_px = {ball.column}", f"row_px = {ball.row}", f"radius_px = {ball.radius}"]
    lines += ["", "[simulation]", f"sample = {json.dumps(arc.sample)}", f"seed = {arc.seed}", f'truth = "{MARKER}"']
    return "\n".join(lines) + "\n"
