"""The virtual light arc: a capture of a procedural sample as a photographer would bring it home, and its truth.

The sample is lit on a grid twice as fine as the photographs (`light_arc`), blurred by the lens and moved by a known
fraction of a pixel in one Fourier transform (`lens`), exposed once for all photographs, given sensor noise and
quantised. Noise of a signal x (1 = white level) has variance noise^2 (0.99 x + 0.01): photons, and a floor of reading.

A folder holds the photographs, `capture.toml` with the angles, and `truth/`: `truth.json`, `height.exr` (pixels of the
photographs) and one noise-free radiance EXR to a photograph (1 = white level). Equal settings give equal bytes.
Cost: 7 s of processor time and 270 MB for ten photographs of 512 x 512, a third of it in the lens.
"""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.colour import LUMINANCE, srgb_encode
from engine.files.atomic import atomic_folder, make_folder, write_bytes, write_json
from engine.images.encode import rgb_channels, write_exr, write_tiff16
from engine.params import check, param
from engine.render import dng, height_fields, light_arc
from engine.render.lens import blurred
from engine.steps import Step, Steps, part

FORMATS = {"tiff": ".tif", "exr": ".exr", "dng": ".dng"}
ELEVATIONS_DEG = (5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0)

#: By this file a folder is known to be a simulated capture, which a later one may replace.
MARKER = "truth/truth.json"

EXPOSURE_S = 1 / 60
LAMP_RADIUS = math.radians(1.0)
LENS_BLUR_PX = 0.45
LEVELS = dng.Levels()
_FINE = 2
_READING_SHARE = 0.01


@dataclass(frozen=True)
class LightArc:
    """What is photographed, and how. Angles in radians; every azimuth is photographed at every elevation."""

    sample: str = "woven"
    elevation: tuple[float, ...] = tuple(math.radians(angle) for angle in ELEVATIONS_DEG)
    azimuth: tuple[float, ...] = (0.0,)
    size: int = 512
    format: str = "tiff"
    interreflection: bool = True
    seed: int = 1
    noise: float = param(0.004, 0.0, 0.2, doc="Standard deviation of the noise at the white level.", log=True)
    misalignment_px: float = param(0.6, 0.0, 16.0, unit="px", doc="Largest shift of a photograph along each axis.")

    def __post_init__(self) -> None:
        check(self)
        if self.sample not in height_fields.SAMPLES:
            raise ValueError(f"unknown sample {self.sample!r}; known are {', '.join(height_fields.SAMPLES)}")
        if self.format not in FORMATS:
            raise ValueError(f"unknown format {self.format!r}; known are {', '.join(FORMATS)}")
        if not 16 <= self.size <= 2048:
            raise ValueError(f"size {self.size} px is outside [16, 2048]")
        if not self.elevation or not all(math.radians(1) <= angle <= math.pi / 2 for angle in self.elevation):
            raise ValueError("elevations must lie in [1, 90] degrees")
        if not self.azimuth or not all(0 <= angle < 2 * math.pi for angle in self.azimuth):
            raise ValueError("azimuths must lie in [0, 360) degrees")
        names = [shot.file for shot in shots(self)]
        if len(set(names)) < len(names):
            raise ValueError("two photographs have the same angles")


@dataclass(frozen=True)
class Shot:
    """One photograph: its file, its lamp (rad), and how far its picture lies to the right and down (pixels)."""

    file: str
    elevation: float
    azimuth: float
    right_px: float
    down_px: float


@dataclass(frozen=True)
class Capture:
    """A simulated capture on disk."""

    folder: Path
    shots: tuple[Shot, ...]

    @property
    def photographs(self) -> tuple[Path, ...]:
        return tuple(self.folder / shot.file for shot in self.shots)


def shots(arc: LightArc) -> tuple[Shot, ...]:
    """The photographs in the order in which they are taken; the first is where it should be, the others wander."""
    lamps = [(elevation, azimuth) for azimuth in arc.azimuth for elevation in arc.elevation]
    wander = np.random.default_rng((arc.seed, 1)).uniform(-1, 1, (len(lamps), 2)) * arc.misalignment_px
    wander[0] = 0.0
    return tuple(
        Shot(_file_name(arc, elevation, azimuth), elevation, azimuth, float(right), float(down))
        for (elevation, azimuth), (right, down) in zip(lamps, wander, strict=True)
    )


def simulate(arc: LightArc, folder: Path) -> Steps[Capture]:
    """Photograph the sample into `folder`, which is complete at the end or as it was before.

    Raises OutputError where the folder cannot be written, or exists and is not a simulated capture.
    """
    taken = shots(arc)
    with atomic_folder(folder, MARKER) as partial:
        make_folder(partial / "truth")
        table = yield from part(_prepared(arc), 0.0, 0.3)
        brightest = _seen(table, Shot("", max(arc.elevation), arc.azimuth[0], 0.0, 0.0))
        gain = np.float32(0.9 / np.percentile(brightest, 99.9))
        records = []
        for index, shot in enumerate(taken):
            yield Step(0.3 + 0.7 * index / len(taken), f"Photographing {shot.file}")
            radiance = gain * _seen(table, shot)
            yield Step(0.3 + 0.7 * (index + 0.5) / len(taken), f"Developing {shot.file}", radiance)
            _write_photograph(arc, partial / shot.file, radiance, index)
            write_exr(partial / "truth" / _radiance_file(shot), rgb_channels(radiance), half=False)
            records.append(_record(shot, radiance, (partial / shot.file).read_bytes()))
        write_exr(partial / "truth" / "height.exr", {"Y": _height_px(table)}, half=False)
        write_json(partial / MARKER, _truth(arc, records))
        write_bytes(partial / "capture.toml", capture_toml(arc, taken).encode())
        yield Step(1.0, "Captured")
    return Capture(Path(folder), taken)


def with_noise(signal: NDArray[np.float32], noise: float, key: tuple[int, ...]) -> NDArray[np.float32]:
    """`signal` (1 = white level) with sensor noise; negative values stay. `key` seeds the generator."""
    if noise == 0.0:
        return signal
    variance = (1 - _READING_SHARE) * signal + _READING_SHARE
    draw = np.random.default_rng(key).standard_normal(signal.shape, np.float32)
    return signal + np.float32(noise) * np.sqrt(variance) * draw


def capture_toml(arc: LightArc, taken: tuple[Shot, ...]) -> str:
    """The angle table that the import reads."""
    lines = [f"notes = {json.dumps(f'{arc.sample} sample on the virtual light arc')}"]
    if arc.format == "tiff":
        lines += ['transfer = "srgb"']
    for shot in taken:
        lines += [
            "",
            "[[photographs]]",
            f"file = {json.dumps(shot.file)}",
            f"elevation_deg = {_degrees(shot.elevation)}",
            f"azimuth_deg = {_degrees(shot.azimuth)}",
            f"exposure_s = {EXPOSURE_S}",
        ]
    lines += [
        "",
        "[simulation]",
        f"sample = {json.dumps(arc.sample)}",
        f"seed = {arc.seed}",
        'truth = "truth/truth.json"',
    ]
    return "\n".join(lines) + "\n"


@dataclass(frozen=True, eq=False)
class _Table:
    """The sample on the table: what is the same for all photographs. `open_part` is None without interreflection."""

    sample: height_fields.Sample
    slope: NDArray[np.float32]
    open_part: NDArray[np.float32] | None
    horizons: dict[float, NDArray[np.float32]]


def _prepared(arc: LightArc) -> Steps[_Table]:
    yield Step(0.0, f"Making the {arc.sample} sample")
    sample = height_fields.sample(arc.sample, arc.size * _FINE, arc.seed)
    yield Step(0.4, "Finding what hides the sky")
    open_part = light_arc.openness(sample.height) if arc.interreflection else None
    lowest = max(min(arc.elevation) - LAMP_RADIUS, math.radians(0.5))
    horizons = {}
    for index, azimuth in enumerate(arc.azimuth):
        yield Step(0.7 + 0.3 * index / len(arc.azimuth), "Finding what casts shadows")
        horizons[azimuth] = light_arc.horizon_slope(sample.height, azimuth, lowest)
    return _Table(sample, light_arc.surface_slope(sample.height), open_part, horizons)


def _seen(table: _Table, shot: Shot) -> NDArray[np.float32]:
    """(H, W, 3) what reaches the sensor of a photograph, for an irradiance of one."""
    light = light_arc.light_direction(shot.elevation, shot.azimuth)
    visible = light_arc.visibility(table.horizons[shot.azimuth], shot.elevation, LAMP_RADIUS)
    image = light_arc.radiance(table.sample, table.slope, visible, light)
    if table.open_part is not None:
        image += light_arc.bounce(image, table.sample.albedo, table.open_part, len(image) / 100)
    to_pixel_centre = 0.5 * (_FINE - 1)
    right, down = (shift * _FINE - to_pixel_centre for shift in (shot.right_px, shot.down_px))
    return np.ascontiguousarray(blurred(image, LENS_BLUR_PX * _FINE, right, down)[::_FINE, ::_FINE])


def _height_px(table: _Table) -> NDArray[np.float32]:
    """(H, W) height in pixels of the photographs."""
    size = len(table.sample.height) // _FINE
    mean: NDArray[np.float32] = table.sample.height.reshape(size, _FINE, size, _FINE).mean(axis=(1, 3))
    return mean / np.float32(_FINE)


def _write_photograph(arc: LightArc, path: Path, radiance: NDArray[np.float32], index: int) -> None:
    key = (arc.seed, 2, index)
    if arc.format == "dng":
        signal = with_noise(dng.mosaic(radiance, LEVELS.neutral), arc.noise, key)
        write_bytes(path, dng.dng_bytes(dng.quantised(signal, LEVELS), LEVELS, exposure_s=EXPOSURE_S))
        return
    noisy = with_noise(radiance, arc.noise, key)
    if arc.format == "exr":
        write_exr(path, rgb_channels(noisy))
        return
    coded = srgb_encode(np.clip(noisy.astype(np.float64), 0, 1))
    write_tiff16(path, np.rint(coded * 65535).astype(np.uint16), transfer="srgb")


def _truth(arc: LightArc, records: list[dict[str, Any]]) -> dict[str, Any]:
    raw = arc.format == "dng"
    return {
        "sample": arc.sample,
        "size_px": arc.size,
        "seed": arc.seed,
        "format": arc.format,
        "interreflection": arc.interreflection,
        "lamp_radius_deg": _degrees(LAMP_RADIUS),
        "lens_blur_px": LENS_BLUR_PX,
        "noise": arc.noise,
        "noise_variance": "noise^2 (0.99 x + 0.01) of a signal x, 1 = white level",
        "black_level": LEVELS.black if raw else 0,
        "white_level": LEVELS.white if raw else (65535 if arc.format == "tiff" else 1.0),
        "neutral": LEVELS.neutral if raw else (1.0, 1.0, 1.0),
        "height": "height.exr",
        "photographs": records,
    }


def _record(shot: Shot, radiance: NDArray[np.float32], content: bytes) -> dict[str, Any]:
    return {
        "file": shot.file,
        "sha256": hashlib.sha256(content).hexdigest(),
        "radiance": _radiance_file(shot),
        "elevation_deg": _degrees(shot.elevation),
        "azimuth_deg": _degrees(shot.azimuth),
        "exposure_s": EXPOSURE_S,
        "shift_right_px": shot.right_px,
        "shift_down_px": shot.down_px,
        "mean_radiance": float(radiance.mean(axis=(0, 1), dtype=np.float64) @ LUMINANCE),
        "clipped_fraction": float((radiance >= 1).any(axis=-1).mean()),
    }


def _file_name(arc: LightArc, elevation: float, azimuth: float) -> str:
    turn = f"_azimuth{_number(azimuth, 3)}" if len(arc.azimuth) > 1 else ""
    return f"{arc.sample}{turn}_{_number(elevation, 2)}{FORMATS[arc.format]}"


def _radiance_file(shot: Shot) -> str:
    return f"radiance_{Path(shot.file).stem}.exr"


def _number(angle: float, digits: int) -> str:
    """Whole degrees padded with zeros, so that names sort by angle; a fraction only where there is one."""
    text = f"{_degrees(angle):g}"
    whole, point, fraction = text.partition(".")
    return whole.zfill(digits) + point + fraction


def _degrees(angle: float) -> float:
    return round(math.degrees(angle), 9)
