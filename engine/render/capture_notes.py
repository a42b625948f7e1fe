"""What is known of a simulated capture: `capture.toml` for the import, and `truth/truth.json` to measure it by."""

from __future__ import annotations

import hashlib
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.colour import LUMINANCE
from engine.render.arc import LightArc, Shot, calibration_file, degrees, radiance_file, shots, sphere
from engine.render.sensor import LEVELS
from engine.render.table import LAMP_RADIUS, LENS_BLUR_PX, Table, light_at_sphere

#: By this file a folder is known to be a simulated capture, which a later one may replace.
MARKER = "truth/truth.json"


def capture_toml(arc: LightArc) -> str:
    """What a photographer would note: angles and exposures, and where the calibration is."""
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


def truth(arc: LightArc, records: list[dict[str, Any]]) -> dict[str, Any]:
    """The content of `truth.json`; lengths in pixels of the photographs, radiance in units of the white level."""
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
        "photographs": records,
    }


def record(
    table: Table, shot: Shot, radiance: NDArray[np.float32], arriving: NDArray[np.float32], content: bytes
) -> dict[str, Any]:
    """What is known of a photograph: of its light `radiance`, of what was `arriving` at the sensor, of the file."""
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
