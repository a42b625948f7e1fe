"""The virtual light arc: a capture of a procedural sample as a photographer would bring it home, and its ground truth.

The sample is lit (`table`), exposed alike in all photographs of one relative exposure, dimmed towards the corners by
the lens, and recorded by a sensor (`sensor`). A folder holds the photographs, a dark frame and a flat field where asked
for, `capture.toml`, and `truth/`: `truth.json`, `height.exr` (pixels of the photographs), the maps of `rig` as EXR, and
one noise-free radiance EXR to a light (1 = white level at relative exposure 1), without fall-off to the corners and
without dark signal. Equal settings give equal bytes.
Cost: 6 s of CPU time and 270 MB for ten photographs of 512 x 512; a near lamp adds up to a second to each.
"""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import LUMINANCE
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, part
from engine.images.encode import rgb_channels, write_exr
from engine.simulate.arc import (
    EXPOSURE_S,
    MARKER,
    LightArc,
    Shot,
    calibration_file,
    capture_toml,
    degrees,
    radiance_file,
    shots,
)
from engine.simulate.camera import LEVELS, dim, write_photograph
from engine.simulate.rig import (
    LAMP_RADIUS,
    LENS_BLUR_PX,
    Table,
    height_px,
    light_at_sphere,
    light_up,
    photograph,
    prepare,
    reference_maps,
)
from engine.storage.atomic import atomic_folder, make_folder, write_bytes, write_json

#: Maps of the surface beside the height.
MAPS = ("normal", "albedo", "specular", "roughness")


def truth(arc: LightArc, records: list[dict[str, Any]], gain: np.float32) -> dict[str, Any]:
    """The content of `truth.json`; lengths in pixels of the photographs, radiance in units of the white level.

    `gain` is the irradiance of each lamp in the middle of the image, on what faces it, in these units.
    """
    levels = LEVELS[arc.raw_bits] if arc.format == "dng" else None
    return {
        "sample": arc.sample,
        "size_px": arc.size,
        "seed": arc.seed,
        "format": arc.format,
        "interreflection": arc.interreflection,
        "lamp_radius_deg": degrees(LAMP_RADIUS),
        "lamp_distance_widths": arc.lamp_distance,
        "lens_blur_px": LENS_BLUR_PX,
        "lens_corner_loss": arc.corner_loss,
        "noise": arc.noise,
        "noise_variance": "noise^2 (0.99 x + 0.01) of a signal x, 1 = white level",
        "dark_signal": arc.dark,
        "black_level": levels.black if levels else 0,
        "white_level": levels.white if levels else (65535 if arc.format == "tiff" else 1.0),
        "neutral": levels.neutral if levels else (1.0, 1.0, 1.0),
        "height": "height.exr",
        "maps": [f"{name}.exr" for name in MAPS],
        "lamp_irradiance": float(gain),
        "photographs": records,
    }


def record(
    table: Table, shot: Shot, radiance: NDArray[np.float32], arriving: NDArray[np.float32], content: bytes
) -> dict[str, Any]:
    """Record of a photograph: of its light `radiance`, of the light `arriving` at the sensor, of the file."""
    arc = table.arc
    known = {
        "file": shot.file,
        "sha256": hashlib.sha256(content).hexdigest(),
        "radiance": radiance_file(shot),
        "elevation_deg": degrees(shot.elevation),
        "azimuth_deg": degrees(shot.azimuth),
        "exposure_s": shot.exposure_s,
        "shift_right_px": shot.right_px,
        "shift_down_px": shot.down_px,
        "turn_deg": degrees(shot.turn),
        "alignment_matrix": shot.alignment_matrix(arc.size).tolist(),
        "mean_radiance": float(radiance.mean(axis=(0, 1), dtype=np.float64) @ LUMINANCE),
        "clipped_fraction": float((arriving >= 1).any(axis=-1).mean()),
    }
    if arc.sphere:
        known["sphere_light"] = light_at_sphere(table, shot.elevation, shot.azimuth).tolist()
    return known


#: A dark frame or flat field is the mean of as many exposures.
CALIBRATION_FRAMES = 16
FLAT_LEVEL = 0.8

#: Share of clipped pixels above which a photograph is said to be clipped.
CLIPPED = 0.01


@dataclass(frozen=True)
class Capture:
    """A simulated capture on disk, with the share of clipped pixels of each photograph."""

    folder: Path
    shots: tuple[Shot, ...]
    clipped: tuple[float, ...]

    @property
    def warnings(self) -> list[str]:
        """A sentence where photographs are clipped in more pixels than highlights have."""
        many = [share for share in self.clipped if share > CLIPPED]
        if not many:
            return []
        worst = self.shots[int(np.argmax(self.clipped))].file
        words = f"{len(many)} of {len(self.shots)} photographs are clipped in more than {percent(CLIPPED)} of pixels"
        return [f"{words}, {worst} in {percent(max(many))}"]

    @property
    def photographs(self) -> tuple[Path, ...]:
        return tuple(self.folder / shot.file for shot in self.shots)


def simulate(arc: LightArc, folder: Path) -> Steps[Capture]:
    """Photograph the sample into `folder`, which is complete at the end or as it was before.

    Raises OutputError where the folder cannot be written, or exists and is not a simulated capture.
    """
    with atomic_folder(folder, MARKER) as partial:
        make_folder(partial / "truth")
        table = yield from part(prepare(arc), 0.0, 0.2)
        gain = yield from part(_gain(table), 0.2, 0.25)
        records = yield from part(_photographs(table, gain, partial), 0.25, 0.95)
        yield Step(0.95, "Writing what is known")
        if arc.calibration:
            _write_calibration(arc, partial)
        write_exr(partial / "truth" / "height.exr", {"Y": height_px(table)}, half=False)
        for name, values in reference_maps(table).items():
            channels = {"Y": values} if values.ndim == 2 else rgb_channels(values)
            write_exr(partial / "truth" / f"{name}.exr", channels, half=False)
        write_json(partial / MARKER, truth(arc, records, gain))
        write_bytes(partial / "capture.toml", capture_toml(arc).encode())
        yield Step(1.0, "Captured")
    return Capture(Path(folder), shots(arc), tuple(each["clipped_fraction"] for each in records))


def renderings(arc: LightArc, elevations: Sequence[float]) -> Steps[list[NDArray[np.float32]]]:
    """Radiance (H, W, 3) as in the truth of a capture by `arc`, at elevations (rad) that it need not photograph.

    The camera stands where it should, and the lamp at the first azimuth of the arc.
    """
    table = yield from part(prepare(arc), 0.0, 0.3)
    gain = yield from part(_gain(table), 0.3, 0.4)
    images = []
    for index, elevation in enumerate(elevations):
        shot = _still(elevation, arc.azimuth[0])
        start = 0.4 + 0.6 * index / len(elevations)
        images.append((yield from part(_radiance(table, gain, shot), start, start + 0.6 / len(elevations))))
    return images


def _gain(table: Table) -> Steps[np.float32]:
    """Gain of the exposure: nearly white is the brightest in the image under the highest lamp."""
    arc = table.arc
    shot = _still(max(arc.elevation), arc.azimuth[0])
    image = yield from light_up(table, shot.elevation, shot.azimuth)
    bare = replace(table, arc=replace(arc, sphere=False))
    return np.float32(0.9 / np.percentile(photograph(bare, image, shot), 99.9))


def _photographs(table: Table, gain: np.float32, folder: Path) -> Steps[list[dict[str, Any]]]:
    """Write all photographs and the radiance of their lights, and say what is known of each."""
    taken = list(enumerate(shots(table.arc)))
    lights = [list(light) for _, light in itertools.groupby(taken, lambda one: (one[1].azimuth, one[1].elevation))]
    records: list[dict[str, Any]] = []
    for index, light in enumerate(lights):
        steps = _exposures(table, gain, light, folder)
        records += yield from part(steps, index / len(lights), (index + 1) / len(lights))
    return records


def _exposures(
    table: Table, gain: np.float32, light: list[tuple[int, Shot]], folder: Path
) -> Steps[list[dict[str, Any]]]:
    """Photograph one light at all exposures; `light` holds shots and their numbers."""
    arc, shot = table.arc, light[0][1]
    radiance = yield from part(_radiance(table, gain, shot), 0.0, 0.5)
    yield Step(0.5, f"Writing the ground truth of {shot.file}")
    write_exr(folder / "truth" / radiance_file(shot), rgb_channels(radiance), half=False)
    records: list[dict[str, Any]] = []
    for number, shot in light:
        yield Step(0.5 + 0.5 * len(records) / len(light), f"Developing {shot.file}", radiance)
        arriving = dim(arc, radiance * np.float32(shot.exposure))
        write_photograph(arc, folder / shot.file, arriving, shot.exposure_s, (arc.seed, 2, number))
        content = (folder / shot.file).read_bytes()
        records.append(record(table, shot, radiance, arriving, content))
    return records


def _radiance(table: Table, gain: np.float32, shot: Shot) -> Steps[NDArray[np.float32]]:
    """(H, W, 3) what the lens sees for `shot`, 1 = white level at relative exposure 1."""
    image = yield from part(light_up(table, shot.elevation, shot.azimuth), 0.0, 0.6)
    yield Step(0.6, f"Photographing {shot.file}")
    return photograph(table, gain * image, shot)


def _still(elevation: float, azimuth: float) -> Shot:
    return Shot("", elevation, azimuth, 1.0, 0.0, 0.0, 0.0)


def _write_calibration(arc: LightArc, folder: Path) -> None:
    """A dark frame, and an even white card under even light through the same lens."""
    card = np.full((arc.size, arc.size, 3), FLAT_LEVEL, np.float32)
    noise = arc.noise / math.sqrt(CALIBRATION_FRAMES)
    for number, (name, light) in enumerate((("dark", 0 * card), ("flat", dim(arc, card)))):
        write_photograph(arc, folder / calibration_file(arc, name), light, EXPOSURE_S, (arc.seed, 5, number), noise)
