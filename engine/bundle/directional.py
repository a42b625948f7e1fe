"""The members of a directional map: planes as grey PNG images, its numbers as JSON, its weights as a table.

The JSON gives every number back bit for bit. The table is made of it for shaders, which hold no kriging: OpenEXR floats
of `TILTS` rows, from light overhead to the horizon, and `TURNS` columns of azimuth, with channels c.R, c.G, c.B for the
constant and planeNN.R … for each plane.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from engine.bundle.manifest import NUMBERS, PLANE_FILES, WEIGHTS
from engine.bundle.maps import Produce, check_fingerprint, maps_member, pixels_member
from engine.core.errors import InputError
from engine.images.encode import encode_png
from engine.images.exr_strips import Planes
from engine.shading.directional.effective_light import TILTS, TURNS
from engine.shading.directional.interpolation import Kernel
from engine.shading.directional.planes import DirectionalMap
from engine.storage.archive import Archive, json_of
from engine.storage.records import DirectionalNumbers, DirectionalRecord, Manifest

#: Largest JSON of numbers, in bytes: 1,024 photographs and 128 planes take 10 MB.
_LIMIT_BYTES = 16 << 20

#: Part of the largest weight by which another CPU's may differ.
_LAST_DIGITS = 1e-5

_AGAIN = "Export the bundle again"


def directional_members(directional: DirectionalMap) -> dict[str, Produce]:
    """Producer of each member, in the order of writing."""
    members: dict[str, Produce] = {}
    for name, plane in zip(PLANE_FILES, directional.planes, strict=False):
        members[name] = lambda plane=plane: encode_png(plane, transfer="linear")  # type: ignore[misc]
    members[NUMBERS] = lambda: _json(directional)
    members[WEIGHTS] = lambda: Planes(_weights(directional), {"unit": "8-bit sRGB levels per level of a plane"})
    return members


def directional_record(directional: DirectionalMap | None) -> DirectionalRecord | None:
    if directional is None:
        return None
    planes, height, width = directional.planes.shape
    return DirectionalRecord(
        planes=planes,
        photographs=len(directional.lights),
        height_px=height,
        width_px=width,
        r_max=directional.r_max,
        leave_one_out_rmse_srgb8=_finite(directional.leave_one_out),
        in_sample_rmse_srgb8=_finite(directional.in_sample),
        mean_picture_rmse_srgb8=_finite(directional.mean_picture),
    )


def _finite(error: float) -> float | None:
    return error if math.isfinite(error) else None


def read_directional(archive: Archive, manifest: Manifest) -> DirectionalMap | None:
    """The directional map of a bundle, bit for bit; None where it holds none."""
    record = manifest.directional
    if record is None:
        return None
    numbers = _numbers(archive, manifest, record)
    size = (record.height_px, record.width_px)
    planes = np.empty((record.planes, *size), np.uint8)
    for k in range(record.planes):
        planes[k] = pixels_member(archive, manifest, PLANE_FILES[k], "decode_codes", 1, *size, bits=8, grey=True)
    found = DirectionalMap(
        planes=planes,
        low=np.array(numbers.low),
        step=np.array(numbers.step),
        mean=np.array(numbers.mean),
        vectors=np.array(numbers.vectors),
        lights=np.array(numbers.lights),
        kernel=Kernel(
            numbers.kernel_length,
            numbers.kernel_noise,
            numbers.kernel_power,
            numbers.kernel_upward,
            numbers.kernel_basis,
            numbers.kernel_trend,
        ),
        r_max=record.r_max,
        leave_one_out=_or_nan(record.leave_one_out_rmse_srgb8),
        in_sample=_or_nan(record.in_sample_rmse_srgb8),
        mean_picture=_or_nan(record.mean_picture_rmse_srgb8),
    )
    try:
        usable = bool(np.isfinite(found.table).all()) and bool((found.lights[:, 2] > 0.0).all())
    except np.linalg.LinAlgError:
        usable = False
    if not usable:
        raise InputError(archive.path, f"{NUMBERS} has lights that cannot be interpolated", _AGAIN)
    return found


def _or_nan(error: float | None) -> float:
    return math.nan if error is None else error


def directional_problems(archive: Archive, manifest: Manifest, directional: DirectionalMap | None) -> list[str]:
    """Differences of the table of weights from what this program makes of the numbers."""
    if directional is None:
        return []
    wanted = _weights(directional)
    found = maps_member(archive, manifest, WEIGHTS, list(wanted), TILTS, TURNS)
    made = np.stack(list(wanted.values()))
    if np.allclose(found, made, rtol=0.0, atol=_LAST_DIGITS * float(np.abs(made).max())):
        return []
    return [f"{WEIGHTS} is not what {NUMBERS} gives."]


def _json(directional: DirectionalMap) -> bytes:
    numbers = DirectionalNumbers(
        lights=directional.lights.tolist(),
        kernel_length=directional.kernel.length,
        kernel_noise=directional.kernel.noise,
        kernel_power=directional.kernel.power,
        kernel_upward=directional.kernel.upward,
        kernel_basis=directional.kernel.basis,
        kernel_trend=directional.kernel.trend,
        mean=directional.mean.tolist(),
        vectors=directional.vectors.tolist(),
        low=directional.low.tolist(),
        step=directional.step.tolist(),
    )
    return (json.dumps(numbers.model_dump(), indent=1, allow_nan=False) + "\n").encode()


def _numbers(archive: Archive, manifest: Manifest, record: DirectionalRecord) -> DirectionalNumbers:
    content = archive.read(NUMBERS, _LIMIT_BYTES)
    check_fingerprint(archive, manifest, NUMBERS, content)
    try:
        numbers = DirectionalNumbers.model_validate(json_of(content, archive.path, NUMBERS, archive.process))
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(step) for step in first["loc"])[:120]
        raise InputError(archive.path, f"{NUMBERS}: {where}: {first['msg']}", _AGAIN) from None
    values, planes = 3 * record.photographs, record.planes
    sizes = (len(numbers.lights), len(numbers.mean), len(numbers.vectors), len(numbers.low), len(numbers.step))
    if sizes != (record.photographs, values, values, planes, planes) or {*map(len, numbers.vectors)} != {planes}:
        raise InputError(archive.path, f"{NUMBERS} has other numbers than the manifest says", _AGAIN)
    lengths = np.linalg.norm(np.array(numbers.lights), axis=1)
    if not np.allclose(lengths, 1.0, atol=1e-6):
        raise InputError(archive.path, f"{NUMBERS} has lights that are not unit vectors", _AGAIN)
    return numbers


def _weights(directional: DirectionalMap) -> dict[str, NDArray[Any]]:
    """(TILTS, TURNS) of each channel."""
    names = ["c", *(f"plane{k:02d}" for k in range(len(directional.planes)))]
    table = directional.table
    return {
        f"{name}.{channel}": np.ascontiguousarray(table[:, :, place, k])
        for k, name in enumerate(names)
        for place, channel in enumerate("RGB")
    }
