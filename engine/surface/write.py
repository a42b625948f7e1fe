"""The folder of maps: an EXR for each map and each standard deviation, PNG previews, and `surface.json`.

EXR maps are linear: colours are in the working space that the record and the chromaticities of the files state, normals
components in [−1, 1] (x right, y up, z out of the image), heights widths of a texel, whose size in millimetres the
record states where it is known. Where depth edges divide the surface into regions, between which the height steps by an
unknown amount, `region` holds their numbers from 0. Previews are for looking: colours, also that of the highlight, in
sRGB codes (a specular of 0.04 is code 56), normals as (n + 1) / 2, and height from its lowest to its highest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.scale import is_estimate, mm_per_texel
from engine.core.colour import REC_709, srgb_encode
from engine.core.steps import Step, Steps, part
from engine.images.encode import rgb_channels
from engine.images.exr_strips import Planes, write_exr_strips
from engine.images.png_rows import write_png
from engine.storage.atomic import atomic_file, atomic_folder, write_json
from engine.surface.pbr_maps import PbrMaps, count_regions, space_of
from engine.surface.recover import Surface

#: By this file a folder of maps is known.
RECORD = "surface.json"

#: Names of the files by the fields of `PbrMaps`.
FILES = {
    "base_colour": "base_colour",
    "normal": "normal",
    "roughness": "roughness",
    "metallic": "metallic",
    "f0": "specular",
    "height": "height",
    "occlusion": "occlusion",
    "region": "region",
    "mask": "mask",
}

#: Standard deviations at which previews of uncertainty are white.
WHITE_SIGMA = {"normal": math.radians(10.0), "height": 1.0}


def find_known_maps(maps: PbrMaps) -> dict[str, NDArray[np.float32]]:
    """The maps that are known by the names of their files, and their deviations as `NAME_sigma`.

    Colours are in the working space.
    """
    found = {}
    for field, name in FILES.items():
        values = getattr(maps, field)
        if values is None:
            continue
        found[name] = values
        if maps.uncertainty is not None and field not in ("region", "mask"):
            found[f"{name}_sigma"] = getattr(maps.uncertainty, field)
    if maps.wide is not None:
        found["base_colour"] = maps.wide.base_colour
        if maps.wide.sigma is not None:
            found["base_colour_sigma"] = maps.wide.sigma
    return found


def preview(name: str, values: NDArray[np.float32]) -> NDArray[np.uint8]:
    """(H, W) or (H, W, 3) codes of a map by the name of its file."""
    if name in ("base_colour", "specular"):
        shown = srgb_encode(values)
    elif name == "normal":
        shown = 0.5 + 0.5 * values
    elif name == "height":
        low, high = np.quantile(values, (0.001, 0.999))
        shown = (values - low) / max(float(high - low), 1e-9)
    elif name == "region":
        # neighbouring numbers get grey levels that are far apart
        shown = np.where(values > 0.0, 0.25 + 0.75 * (0.618034 * values % 1.0), 0.0)
    elif name.endswith("_sigma"):
        shown = values / WHITE_SIGMA.get(name.removesuffix("_sigma"), 0.25)
    else:
        shown = values
    return np.asarray(np.rint(255.0 * np.clip(np.nan_to_num(shown, posinf=1.0), 0.0, 1.0)), np.uint8)


def record(surface: Surface, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """The figures of a surface, as `surface.json` and `--json` state them."""
    maps, known = surface.maps, find_known_maps(surface.maps)
    texel_mm = mm_per_texel(provenance)
    errors, azimuth = maps.errors, maps.observed.azimuth
    return {
        "lightarc_surface": 1,
        "height_px": maps.size[0],
        "width_px": maps.size[1],
        "photographs": len(surface.lamps.direction),
        "observed_slopes": maps.observed.kind,
        "arc_azimuth_deg": None if azimuth is None else math.degrees(azimuth),
        "lamp_distance_widths": 1.0 / surface.lamps.nearness if surface.lamps.nearness else None,
        "white_radiance": surface.white,
        "working_space": space_of(maps).label,
        "beyond_rec709_share": 0.0 if maps.wide is None else maps.wide.clipped[0],
        "texel_mm": texel_mm,
        "texel_mm_is_estimate": is_estimate(provenance),
        "height_range_mm": None
        if texel_mm is None or maps.height is None
        else [texel_mm * float(maps.height.min()), texel_mm * float(maps.height.max())],
        "in_sample_rmse_srgb8": _finite(errors.in_sample),
        "leave_one_out_rmse_srgb8": _finite(errors.left_out),
        "mean_picture_rmse_srgb8": _finite(errors.mean_picture),
        "background_share": None if maps.mask is None else float(1.0 - maps.mask.mean(dtype=np.float64)),
        "height_regions": None if maps.height is None else count_regions(maps),
        "normal_sigma_deg": _finite(math.degrees(errors.normal_sigma)),
        "maps": {
            name: {
                "file": f"{name}.exr",
                "mean": _finite(float(values.mean(dtype=np.float64))),
                "median_sigma": _median(known[f"{name}_sigma"], maps.mask) if f"{name}_sigma" in known else None,
            }
            for name, values in known.items()
            if not name.endswith("_sigma") and name not in ("region", "mask")
        },
        "seconds": surface.seconds,
        "warnings": surface.health.warnings,
        "notes": [finding.text for finding in surface.health.findings],
        "provenance": dict(provenance),
    }


def write_surface(folder: Path, surface: Surface, provenance: Mapping[str, Any], software: str) -> Steps[list[str]]:
    """Write maps, previews and record into `folder`, complete or not at all; returns the names of the files.

    Raises OutputError where the folder cannot be written, or exists and is none of maps.
    """
    known = find_known_maps(surface.maps)
    files = []
    with atomic_folder(folder, RECORD) as partial:
        for index, (name, values) in enumerate(known.items()):
            start, stop, note = index / len(known), (index + 1) / len(known), f"writing {name}"
            yield Step(start, note)
            channels = rgb_channels(values) if values.ndim == 3 else {"Y": values}
            half = name in ("base_colour", "roughness", "metallic", "specular", "occlusion")
            space = space_of(surface.maps) if name.startswith("base_colour") else REC_709
            planes = Planes(channels, {"chromaticities": space.chromaticities}, half)
            with atomic_file(partial / f"{name}.exr") as file:
                late = yield from part(write_exr_strips(planes, file.write, note), start, stop)
                file.seek(late.place)
                file.write(late.content)
            shown = surface.maps.base_colour if name == "base_colour" else values
            write_png(partial / f"{name}.png", preview(name, shown), software=software)
            files += [f"{name}.exr", f"{name}.png"]
        write_json(partial / RECORD, record(surface, provenance))
    return [RECORD, *files]


def _median(sigma: NDArray[np.float32], mask: NDArray[np.float32] | None) -> float | None:
    """The median over the surface, None where it is not known."""
    return _finite(float(np.median(sigma if mask is None else sigma[mask > 0.0])))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
