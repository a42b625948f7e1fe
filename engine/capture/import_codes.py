"""Decisions of an import on the codes of photographs: where they are kept, and what makes radiance of them.

Codes wait in place of pixels where what is done to a pixel can be done again; they are written in place of radiance
where a record can say what it is (`engine.capture.coded_pixels`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.capture.coded_pixels import Curve, Decoding, FallOff, is_same
from engine.capture.import_plan import Plan
from engine.capture.photograph.bayer import Mosaic, Sensor
from engine.capture.photograph.decode import Photograph
from engine.capture.waiting import CalibrateRows
from engine.images.codes import Coded


def is_direct(plan: Plan) -> bool:
    """True if photographs are written as they are read: nothing moves them, and nothing is to be estimated."""
    return plan.still and not plan.calibrated and not plan.has_pairs


def waits_as_codes(plan: Plan) -> bool:
    """True if codes of photographs are kept: what is done to each pixel can be done again, and cheaply."""
    return not is_direct(plan) and not plan.has_pairs and plan.chart is None and plan.calibration.is_by_pixel


def writes_codes(plan: Plan) -> bool:
    """True if codes may be what is written: photographs stay where they are, and few numbers correct their pixels."""
    frames = plan.calibration
    is_plain = frames.is_by_pixel and frames.dark is None and frames.gain is None and plan.chart is None
    return plan.as_codes and is_plain and plan.still and plan.settings.framing is None and not plan.has_pairs


def writes_at_once(plan: Plan) -> bool:
    """True if lights are written as they are read; those that may still be moved are needed beyond a crop."""
    return is_direct(plan) or (writes_codes(plan) and plan.settings.crop is None)


def find_angles(plan: Plan, index: int) -> tuple[float, float]:
    """Elevation and azimuth of a lamp in radians, the azimuth 0 where it is not known."""
    azimuth = plan.sources.azimuth
    return float(plan.sources.elevation[index]), 0.0 if azimuth is None else float(azimuth[index])


def find_factor(plan: Plan, index: int, path: Path) -> float:
    """The factor that brings the photograph at `path` of a lamp to the scale of the stack."""
    return plan.scale.factor.get(path, 1.0) / float(plan.gains[index])


def describe_decoding(
    plan: Plan, index: int, photograph: Photograph, coded: Coded | Mosaic, others: Sequence[Decoding]
) -> Decoding:
    """The steps from the codes of the photograph of light number `index` to its radiance; `others` are those of other
    photographs, of which it has the curve where that is the same."""
    distance = plan.calibration.lamp_distance
    stated = FallOff(distance, *find_angles(plan, index)) if math.isfinite(distance) else None
    red, green, blue = plan.calibration.factors(photograph, find_factor(plan, index, photograph.path)).tolist()
    curve: Curve | Sensor
    if isinstance(coded, Mosaic):
        curve = coded.sensor
    else:
        matrix = None if coded.matrix is None else coded.matrix.copy()
        curve = Curve(coded.tables.copy(), coded.white, matrix)  # a view would keep alive in what the decoder answered
    known = next((each.curve for each in others if is_same(each.curve, curve)), curve)
    return Decoding(known, (red, green, blue), stated)


def find_calibration(plan: Plan, index: int, photograph: Photograph, height: int) -> CalibrateRows:
    """Function that calibrates rows of the photograph of light number `index`, which has one exposure and this
    `height`."""
    angles, factor = find_angles(plan, index), find_factor(plan, index, photograph.path)
    calibration = plan.calibration

    def calibrate(radiance: NDArray[np.float32], saturated: NDArray[np.bool_], first: int) -> None:
        calibration.correct_rows((radiance, saturated), first, photograph, height, *angles, factor)

    return calibrate
