"""Error of the acquisition against ground truth: captures of the virtual light arc, measured against it.

Radiance is compared where its signal-to-noise ratio is `SNR` or more in one photograph, and errors are root mean
squares of relative differences. A material is rendered between its photographs as the paper does (Kautz2004 Sec. 4),
and compared with what the virtual arc itself shows under that lamp; that error is the method's, and is
relative to the mean radiance of the image.
Cost: some 40 s on two cores, and 40 MB in the working folder.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Accuracy
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.mirror_sphere import Circle, find_highlight, light_direction
from engine.capture.lights.sources import find
from engine.capture.photograph.calibrate import flat_field_gain, near_lamp_gain
from engine.capture.photograph.decode import Photograph, read_photograph
from engine.capture.photograph.radiometry import mean_radiance, merge_exposures
from engine.capture.stack import ImageStack
from engine.core.colour import luminance
from engine.core.steps import Steps, part
from engine.images.decode import read_image
from engine.shading.power_law import fit
from engine.shading.shading_map import ShadingMap, build
from engine.simulate.arc import EXPOSURE_S, MARKER, LightArc, calibration_file, sphere
from engine.simulate.height_fields import SAMPLES
from engine.simulate.simulate import renderings, simulate

SIZE, SPHERE_SIZE, SLICES = 256, 512, 8
SNR = 100.0
BORDER = 8
BETWEEN_DEG = (7.5, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 85.0)
GOAL = 0.01


def measures(folder: Path) -> Steps[list[Accuracy]]:
    """All errors; `folder` is a working folder, in which captures and stacks are left."""
    found: list[Accuracy] = []
    steps = [_material(name, folder) for name in SAMPLES]
    steps += [
        _flat_field(folder / "flat"),
        _near_lamp(folder / "near"),
        _merge(folder / "merge"),
        _sphere(folder / "ball"),
    ]
    for index, step in enumerate(steps):
        found += yield from part(step, index / len(steps), (index + 1) / len(steps))
    return found


def _material(name: str, folder: Path) -> Steps[list[Accuracy]]:
    """Import as from a tripod, shade, compress; and render between the photographs."""
    arc = LightArc(name, size=SIZE, misalignment_px=0.0)
    capture = yield from part(simulate(arc, folder / name), 0.0, 0.3)
    stack: ImageStack = yield from part(
        import_stack(find([capture.folder]), ImportSettings(motion="none"), folder / f"{name}-stack"), 0.3, 0.6
    )
    truths = [clean for _, clean in _truths(capture.folder)]
    errors = [_squares(found, clean, arc.noise) for found, clean in zip(stack.radiance, truths, strict=True)]
    shading_map = yield from part(build(stack, SLICES), 0.6, 0.65)
    power_law = yield from part(fit(shading_map), 0.65, 0.7)
    seen = yield from part(renderings(arc, [math.radians(angle) for angle in BETWEEN_DEG]), 0.7, 1.0)
    return [
        Accuracy(f"radiance-{name}", _rms(errors), f"recovered radiance where SNR >= {SNR:g}, relative", GOAL),
        Accuracy(
            f"rendering-{name}", _prediction(shading_map, seen), "at angles not photographed, relative to the mean"
        ),
        Accuracy(
            f"compression-{name}", power_law.rms, "root mean square of the power laws; the paper's 0.040 to 0.065"
        ),
    ]


def _prediction(shading_map: ShadingMap, seen: list[NDArray[np.float32]]) -> float:
    """Relative error of the shading map, looked up at the mean radiance of each image."""
    squares = []
    for image in seen:
        mean = mean_radiance(image)
        difference = shading_map.slice_image(mean, above="scale") - image
        squares.append(np.mean(difference * difference, dtype=np.float64) / mean**2)
    return float(np.sqrt(np.mean(squares)))


def _flat_field(folder: Path) -> Steps[list[Accuracy]]:
    arc = LightArc(size=SIZE, misalignment_px=0.0, elevation=_elevations(30, 60, 90), corner_loss=0.4, dark=0.02,
                   calibration=True)  # fmt: skip
    yield from simulate(arc, folder)
    dark, flat = (read_photograph(folder / calibration_file(arc, name)).radiance for name in ("dark", "flat"))
    gain, _ = flat_field_gain(flat, dark)
    errors, scales = [], []
    for photograph, clean in _photographs(folder):
        even = (photograph.radiance - dark) * gain
        scales.append(float(np.median(even / np.maximum(clean, 1e-3))))
        errors.append(_squares(even / np.float32(np.median(scales)), clean, arc.noise))
    return [Accuracy("flat-field", _rms(errors), f"radiance with 40 % fall-off, where SNR >= {SNR:g}, relative", GOAL)]


def _near_lamp(folder: Path) -> Steps[list[Accuracy]]:
    """An even card must look even. The border is left out, where the lens of the arc blurs opposite sides together."""
    arc = LightArc("plain", size=SIZE, misalignment_px=0.0, noise=0.0, lamp_distance=1.5, azimuth=(0.5,))
    capture = yield from simulate(arc, folder)
    worst = 0.0
    for shot, (photograph, _) in zip(capture.shots, _photographs(folder), strict=True):
        gain = near_lamp_gain(SIZE, SIZE, 1.5, shot.elevation, shot.azimuth)
        even, known = (map_[BORDER:-BORDER, BORDER:-BORDER] for map_ in (photograph.radiance, ~photograph.saturated))
        inside = (even * gain[BORDER:-BORDER, BORDER:-BORDER, None])[known]
        worst = max(worst, float(inside.std(dtype=np.float64) / inside.mean(dtype=np.float64)))
    return [Accuracy("near-lamp", worst, "unevenness of a card lit from 1.5 widths, worst elevation, relative", GOAL)]


def _merge(folder: Path) -> Steps[list[Accuracy]]:
    arc = LightArc("hammered", size=SIZE, misalignment_px=0.0, exposure=(0.25, 1.0, 4.0))
    capture = yield from simulate(arc, folder)
    pairs = list(_photographs(folder))
    errors = []
    for start in range(0, len(pairs), len(arc.exposure)):
        group = list(zip(capture.shots, pairs, strict=True))[start : start + len(arc.exposure)]
        merged = merge_exposures((p.radiance, p.saturated, shot.exposure_s) for shot, (p, _) in group)
        clean = group[0][1][1]
        errors.append(_squares(merged.radiance * np.float32(EXPOSURE_S), clean, arc.noise, ~merged.saturated))
    return [
        Accuracy("exposure-merge", _rms(errors), f"radiance of three exposures, where SNR >= {SNR:g}, relative", GOAL)
    ]


def _sphere(folder: Path) -> Steps[list[Accuracy]]:
    lamp: dict[str, Any] = {"elevation": _elevations(10, 40, 70, 90), "azimuth": (2.0,), "lamp_distance": 2.0}
    arc = LightArc(size=SPHERE_SIZE, misalignment_px=0.0, sphere=True, **lamp)
    yield from simulate(arc, folder)
    ball: Circle = sphere(arc)
    worst = 0.0
    for record in _records(folder):
        image = luminance(read_photograph(folder / record["file"]).radiance).astype(np.float32)
        found = light_direction(ball, *find_highlight(image, ball))
        worst = max(worst, math.acos(min(1.0, float(found @ record["sphere_light"]))))
    return [Accuracy("sphere-direction-deg", math.degrees(worst), "worst direction from a mirror sphere, degrees", 1.0)]


def _elevations(*degrees: float) -> tuple[float, ...]:
    return tuple(math.radians(angle) for angle in degrees)


def _records(folder: Path) -> list[dict[str, Any]]:
    records: list[dict[str, Any]] = json.loads((folder / MARKER).read_text())["photographs"]
    return records


def _truths(folder: Path) -> Iterator[tuple[dict[str, Any], NDArray[np.float32]]]:
    for record in _records(folder):
        yield record, read_image(folder / "truth" / record["radiance"]).pixels


def _photographs(folder: Path) -> Iterator[tuple[Photograph, NDArray[np.float32]]]:
    for record, clean in _truths(folder):
        yield read_photograph(folder / record["file"]), clean


def _squares(
    found: NDArray[np.float32], clean: NDArray[np.float32], noise: float, known: NDArray[np.bool_] | None = None
) -> NDArray[np.float32]:
    """Squared relative errors of the samples that are not clipped and have a high signal-to-noise ratio."""
    strong = (clean >= SNR * noise * np.sqrt(0.99 * clean + 0.01)) & (
        (clean < 1) if known is None else known[..., None]
    )
    relative: NDArray[np.float32] = found[strong] / clean[strong] - 1
    return relative * relative


def _rms(squares: list[NDArray[np.float32]]) -> float:
    return float(np.sqrt(np.concatenate(squares).mean(dtype=np.float64)))
