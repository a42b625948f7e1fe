"""The record of a material that `lightarc shade` made, and the lines that tell of it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.bundle.manifest import MANIFEST, describe_bundle
from engine.core.figure_text import number, percent, size_text, time_text
from engine.core.health import Health

if TYPE_CHECKING:
    from engine.shading.fidelity import Fidelity
    from engine.shading.representation import Chosen


def report_of(result: dict[str, Any]) -> str:
    """Lines for users on one material, of the record that `--json` prints."""
    if result["representation"] == "directional":
        size = size_text(result["size_bytes"])
        first = f"{result['planes']} planes of {result['photographs']} photographs, {size}"
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
        "verdict": "warning" if chosen.shown.is_worse else "good",
        "candidates": [{"representation": name, **errors_of(shown)} for name, shown in candidates.items()],
    }
