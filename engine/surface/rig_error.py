"""Errors of normals by what is not known of the rig: of its calibration, and where there was none.

An error δ of the inverse distance of lamps, in widths, turns the normal at the distance p from the middle by some
2.5 δ p: 1 by the direction of the light and 1.5 by its fall-off, for lamps at 45°. Gains that err by σ turn normals by
σ √(4 / N), N lamps being averaged, and room light that errs by σ by 2 σ. What the model of the calibration leaves of
photographs held out, over the brightness, is an angle of the same size in normals: light that bounces, gloss and
relief beside near lamps err alike over many texels. So do terms that the photographs do not decide: normals change by
the angles that the calibration states when these are fitted all the same.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.calibration.estimate import describe_undecided, estimate
from engine.capture.calibration.rig import Rig, Sample, lamp_vectors
from engine.capture.stack import ImageStack
from engine.core.health import Finding, Verdict
from engine.surface.lamps import Lamps
from engine.surface.reflectance import texels

Array = NDArray[np.float64]

#: Angle of a normal over an error of the inverse distance times the position, and over one of room light.
BY_DISTANCE, BY_AMBIENT = 2.5, 2.0

#: Angle over the held-out error, and its largest value (radians): gloss is seen by the fit of the surface.
BY_HELD_OUT, MAX_HELD_OUT = 1.2, 0.03

#: Texels that are looked at where there was no calibration.
SAMPLE = 1000


def rig_error(stack: ImageStack, used: NDArray[np.int64], seen: Lamps) -> tuple[Array, list[Finding]]:
    """(H, W) standard deviation of normals in radians, and what was found of a rig that nobody corrected for."""
    height, width = stack.radiance.shape[1:3]
    if seen.observed.kind != "both" or stack.folder is None:
        return np.zeros((height, width)), []
    recorded = stack.provenance.get("calibration")
    terms = [term for term in recorded if isinstance(term, dict)] if isinstance(recorded, list) else []
    held_out = stack.provenance.get("calibration_held_out")
    alike, apart = _sum_terms(terms, len(used))
    findings: list[Finding] = []
    if terms and held_out is not None:
        more_alike, more_apart = _read_rivals(stack.provenance.get("calibration_undecided_deg"))
        rival = stack.provenance.get("calibration_rival_deg")
        findings = _about_rival(float(rival) if isinstance(rival, int | float) else 0.0)
    else:
        more_alike, more_apart, held_out, findings = _examine_photographs(stack, used, seen)
    misfit = min(BY_HELD_OUT * held_out, MAX_HELD_OUT) if isinstance(held_out, int | float) else 0.0
    x = (np.arange(width) + 0.5) / width - 0.5
    y = (0.5 * height - 0.5 - np.arange(height)) / width
    distance = np.hypot(x[None], y[:, None])
    estimated = stack.provenance.get("lights_sigma_deg")
    if isinstance(estimated, int | float):
        alike = math.hypot(alike, math.radians(estimated))
        text = (
            "The lights were estimated from the photographs alone: normals may share an error of "
            f"{estimated:.0f}° (1 sigma)"
        )
        findings = [*findings, Finding(Verdict.WARNING, text)]
    squares = (apart**2 + more_apart**2) * distance**2 + alike**2 + more_alike**2 + misfit**2
    return np.sqrt(squares), findings


def _sum_terms(terms: list[dict[str, Any]], count: int) -> tuple[float, float]:
    """Deviation of normals (radians) by what is not known of the terms: everywhere, and for each width of distance from
    the middle of the image."""
    sigma = {str(term.get("name")): float(term.get("sigma") or 0.0) for term in terms}
    alike = math.hypot(sigma.get("gains", 0.0) * math.sqrt(4.0 / count), BY_AMBIENT * sigma.get("ambient", 0.0))
    return alike, BY_DISTANCE * sigma.get("distance", 0.0)


def _read_rivals(recorded: Any) -> tuple[float, float]:
    """The same by terms that the photographs do not decide; stacks of earlier versions hold one angle alone."""
    both = recorded if isinstance(recorded, list) else [recorded, 0.0]
    alike, apart = (math.radians(angle) if isinstance(angle, int | float) else 0.0 for angle in (*both, 0.0, 0.0)[:2])
    return alike, apart


def _examine_photographs(
    stack: ImageStack, used: NDArray[np.int64], seen: Lamps
) -> tuple[float, float, float | None, list[Finding]]:
    """The same, and the held-out error, where what the photographs tell of the rig was not corrected for."""
    height, width = stack.radiance.shape[1:3]
    step = max(1, math.ceil(math.sqrt(height * width / SAMPLE)))
    some = texels(stack, used, step // 2, height, step)
    radiance, rows, columns = some.radiance if some.diffuse is None else some.diffuse, some.rows, some.columns
    values = radiance.mean(axis=-1, dtype=np.float64).T
    mean = values.mean(axis=1)
    positions = np.stack([(columns + 0.5) / width - 0.5, (0.5 * height - 0.5 - rows) / width], axis=1)
    block = (rows * 5 // height) * 6 + columns * 6 // width
    lit = mean > max(0.003, 0.03 * float(np.quantile(mean, 0.98)))
    if lit.sum() < 40:
        return 0.0, 0.0, None, []
    sample = Sample(values[lit] / mean[lit, None], some.usable.T[lit], positions[lit], mean[lit], block[lit])
    start = Rig(seen.nearness, np.zeros(len(used)), np.zeros(3))
    if seen.nearness:  # the import has taken the fall-off off the photographs
        length = np.linalg.norm(lamp_vectors(seen.direction, sample.positions, seen.nearness), axis=-1)
        sample = Sample(sample.values * length**1.5, sample.usable, sample.positions, sample.brightness, sample.block)
    terms = [term for term in ("distance", "gains", "ambient") if term != "distance" or not seen.nearness]
    found = estimate(sample, seen.direction, terms, start)
    is_estimated = isinstance(stack.provenance.get("lights_sigma_deg"), int | float)
    findings = _about_uncorrected([term.text for term in found.terms if term.accepted], is_estimated)
    suggested = stack.provenance.get("suggested_transfer")
    if findings and isinstance(suggested, str):  # of which all follow
        text = f"The samples of the photographs seem to be {suggested}: import again with --transfer {suggested}"
        findings = [Finding(Verdict.WARNING, text)]
    changes = [
        math.radians(term.normals_change_deg) for term in found.terms if term.accepted and term.name != "distance"
    ]
    alike, apart = _read_rivals(list(found.undecided_deg))
    near = found.rig.nearness if "distance" in found.accepted else 0.0
    held_out = found.held_out if math.isfinite(found.held_out) else None
    findings = findings or _about_rival(found.rival_deg)
    return math.hypot(alike, *changes), math.hypot(apart, BY_DISTANCE * near), held_out, findings


def _about_rival(angle_deg: float) -> list[Finding]:
    text = describe_undecided(angle_deg)
    return [Finding(Verdict.WARNING, text)] if text else []


def _about_uncorrected(texts: list[str], is_estimated: bool) -> list[Finding]:
    """Warnings about terms of the rig that the photographs tell; estimated lights have taken up a part of them."""
    if is_estimated and texts:
        text = (
            "The lights were estimated as distant, equally bright lamps in a dark room, which the photographs "
            f"contradict ({'; '.join(texts)}). Estimated lights cannot be calibrated: import again with a list of "
            "lights or a mirror sphere"
        )
        return [Finding(Verdict.WARNING, text)]
    again = "Import again with --calibrate auto"
    return [Finding(Verdict.WARNING, f"Not corrected for: {text}. {again}") for text in texts]
