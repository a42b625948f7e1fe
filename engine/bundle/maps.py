"""The maps of a bundle: which member holds which, how it is coded, and how it comes back bit for bit.

Maps are 32-bit OpenEXR files. A power law of fewer bits has its scale as half floats and its exponents as codes in a
PNG of 8 or 16 bits, K = code * step, which any graphics device takes as a texture. Kept tiles are stored where they
lie: slices that are 0 elsewhere, and their coverage A, so that
    S(r) = slices(r) + (1 - A) scale (r / r_max)^exponent.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.bundle.manifest import CODES, ERROR, EXPONENT, KEPT, SCALE, SLICES
from engine.core.budget import free_bytes
from engine.core.errors import InputError
from engine.core.figure_text import size_text
from engine.images.encode import encode_png, rgb_channels
from engine.images.exr_strips import Planes
from engine.scene.material import Material
from engine.shading.kept_tiles import KeptTiles, cut_tiles
from engine.shading.power_law import PowerLawMap, Storage
from engine.shading.quantise import quantise_exponent, restore_exponent
from engine.shading.shading_map import ShadingMap
from engine.storage.archive import BUNDLE_LIMIT_BYTES, Archive
from engine.storage.records import (
    UNITS,
    HealthRecord,
    KeptTilesRecord,
    Manifest,
    Member,
    PowerLawRecord,
    ShadingMapRecord,
    StorageRecord,
)
from engine.storage.scratch import find_results_folder

COVERAGE = "A"

_AGAIN = "Export the bundle again"

#: Maps up to this size are decoded without a look at the memory that is free.
_READ_UNASKED_BYTES = 1 << 30

Maps = NDArray[np.float32]
Produce = Callable[[], bytes | Planes]


def map_members(material: Material) -> dict[str, Produce]:
    """Producer of each map of the material, in the order of writing; maps as EXR come as `Planes`, packed as they are
    written."""
    members: dict[str, Produce] = {}
    shading_map, power_law = material.shading_map, material.power_law
    if shading_map is not None:
        attributes = {"unit": UNITS["radiance"], "r_max": repr(shading_map.r_max)}
        members[SLICES] = lambda: Planes(_slice_channels(shading_map), attributes)
    if power_law is not None:
        members |= _power_law_members(power_law)
    return members


def _power_law_members(power_law: PowerLawMap) -> dict[str, Produce]:
    storage, kept = power_law.storage, power_law.kept
    radiance = {"unit": UNITS["radiance"], "r_max": repr(power_law.r_max)}
    members: dict[str, Produce] = {
        SCALE: lambda: Planes(rgb_channels(power_law.scale), radiance, storage.scale_bits == 16)
    }
    if storage.exponent_bits == 32:
        members[EXPONENT] = lambda: Planes(rgb_channels(power_law.exponent), {"unit": "1, data without a colour space"})
    else:
        members[CODES] = lambda: encode_png(_codes(power_law.exponent, storage), transfer="linear")
    members[ERROR] = lambda: Planes({"Y": power_law.error_map}, {"unit": UNITS["radiance"]})
    if kept is not None:
        members[KEPT] = lambda: Planes(_keep_channels(kept, *power_law.error_map.shape), radiance)
    return members


def _codes(exponent: Maps, storage: Storage) -> NDArray[np.unsignedinteger]:
    """The codes that give `exponent` back; ValueError where there are none."""
    codes, step = quantise_exponent(exponent, storage.exponent_bits, storage.exponent_step)
    if not np.array_equal(restore_exponent(codes, step), exponent):
        raise ValueError(f"the exponents are not multiples of the step {step} that their storage names")
    return codes


def _slice_channels(shading_map: ShadingMap) -> dict[str, NDArray[Any]]:
    names = _slice_names(len(shading_map.slices), shading_map.clipped is not None)
    planes: list[NDArray[Any]] = [plane for image in shading_map.slices for plane in np.moveaxis(image, 2, 0)]
    return dict(zip(names, planes + list(shading_map.clipped if shading_map.clipped is not None else ()), strict=True))


def _slice_names(slices: int, clipped: bool) -> list[str]:
    names = [f"slice{index:02d}.{channel}" for index in range(slices) for channel in "RGB"]
    return names + ([f"slice{index:02d}.clipped" for index in range(slices)] if clipped else [])


def _keep_channels(kept: KeptTiles, height: int, width: int) -> dict[str, NDArray[Any]]:
    images = kept.slice_images(height, width)
    planes: list[NDArray[Any]] = [plane for image in images for plane in np.moveaxis(image, 2, 0)]
    coverage = {COVERAGE: kept.covers(height, width)}
    return dict(zip(_slice_names(len(images), clipped=False), planes, strict=True)) | coverage


def shading_map_record(shading_map: ShadingMap | None) -> ShadingMapRecord | None:
    if shading_map is None:
        return None
    slices, height, width = shading_map.slices.shape[:3]
    return ShadingMapRecord(
        slices=slices,
        height_px=height,
        width_px=width,
        r_max=float(shading_map.r_max),
        mean_radiance=shading_map.mean_radiance.tolist(),
        order=[int(place) for place in shading_map.order],
        clipped=shading_map.clipped is not None,
        health=HealthRecord.of(shading_map.health),
    )


def power_law_record(power_law: PowerLawMap | None) -> PowerLawRecord | None:
    if power_law is None:
        return None
    kept = power_law.kept
    return PowerLawRecord(
        height_px=power_law.scale.shape[0],
        width_px=power_law.scale.shape[1],
        r_max=float(power_law.r_max),
        rms=float(power_law.rms),
        rms_per_channel=power_law.rms_per_channel.tolist(),
        health=HealthRecord.of(power_law.health),
        storage=_storage_record(power_law.storage),
        kept_tiles=None if kept is None else KeptTilesRecord(size_px=kept.size, slices=kept.slices.shape[1]),
    )


def _storage_record(storage: Storage) -> StorageRecord:
    return StorageRecord(
        exponent_bits=storage.exponent_bits,
        scale_bits=storage.scale_bits,
        exponent_step=storage.exponent_step,
        bound_radiance=storage.bound,
        measured_radiance=storage.measured,
    )


def _storage(record: StorageRecord) -> Storage:
    return Storage(
        exponent_bits=record.exponent_bits,
        scale_bits=record.scale_bits,
        exponent_step=record.exponent_step,
        bound=record.bound_radiance,
        measured=record.measured_radiance,
    )


def read_shading_map(archive: Archive, manifest: Manifest) -> ShadingMap | None:
    """The shading map of a bundle, bit for bit; None where it holds none."""
    record = manifest.shading_map
    if record is None:
        return None
    names = _slice_names(record.slices, record.clipped)
    maps = maps_member(archive, manifest, SLICES, names, record.height_px, record.width_px)
    colours = maps[: 3 * record.slices].reshape(record.slices, 3, record.height_px, record.width_px)
    return ShadingMap(
        slices=np.ascontiguousarray(np.moveaxis(colours, 1, 3)),
        r_max=record.r_max,
        mean_radiance=np.array(record.mean_radiance, np.float64),
        health=record.health.restored(),
        clipped=maps[3 * record.slices :] != 0 if record.clipped else None,
        order=tuple(record.order),
    )


def read_power_law(archive: Archive, manifest: Manifest) -> PowerLawMap | None:
    """The power law of a bundle, bit for bit; None where it holds none."""
    record = manifest.power_law
    if record is None:
        return None

    size, storage = (record.height_px, record.width_px), _storage(record.storage)
    scale = maps_member(archive, manifest, SCALE, list("RGB"), *size, half=storage.scale_bits == 16)
    if storage.exponent_bits == 32:
        exponent = _image(maps_member(archive, manifest, EXPONENT, list("RGB"), *size))
    else:
        codes = pixels_member(archive, manifest, CODES, "decode_codes", 12, *size, bits=storage.exponent_bits)
        exponent = restore_exponent(codes, storage.exponent_step)
    return PowerLawMap(
        scale=_image(scale),
        exponent=exponent,
        r_max=record.r_max,
        rms=record.rms,
        rms_per_channel=np.array(record.rms_per_channel, np.float64),
        error_map=maps_member(archive, manifest, ERROR, ["Y"], *size)[0],
        health=record.health.restored(),
        storage=storage,
        kept=_keep(archive, manifest, record.kept_tiles, *size) if record.kept_tiles is not None else None,
    )


def _keep(archive: Archive, manifest: Manifest, record: KeptTilesRecord, height: int, width: int) -> KeptTiles:
    names = [*_slice_names(record.slices, clipped=False), COVERAGE]
    maps = maps_member(archive, manifest, KEPT, names, height, width)
    covered = maps[-1] == 1.0
    tiles = covered[:: record.size_px, :: record.size_px]
    slices = np.moveaxis(maps[:-1].reshape(record.slices, 3, height, width), 1, 3)
    kept = cut_tiles(slices, tiles, record.size_px)
    if not np.array_equal(kept.covers(height, width), covered):
        raise InputError(archive.path, f"{KEPT} does not cover whole tiles of {record.size_px} texels", _AGAIN)
    return kept


def _image(planes: Maps) -> Maps:
    return np.ascontiguousarray(np.moveaxis(planes, 0, 2))


def maps_member(
    archive: Archive,
    manifest: Manifest,
    member: str,
    channels: list[str],
    height: int,
    width: int,
    *,
    half: bool = False,
) -> Maps:
    """The channels of an EXR member, (C, height, width) float32."""
    options = {"channels": channels, "half": half}
    maps: Maps = pixels_member(archive, manifest, member, "decode_maps", 4 * len(channels), height, width, **options)
    return maps


def pixels_member(
    archive: Archive,
    manifest: Manifest,
    member: str,
    decoder: str,
    texel_bytes: int,
    height: int,
    width: int,
    **options: Any,
) -> NDArray[Any]:
    """The pixels of a member, after its size and fingerprint have been found right."""
    size_bytes = texel_bytes * height * width
    _check_memory(archive, member, size_bytes)
    known = _look_up(archive, manifest, member)
    reply = archive.decode(
        f"engine.bundle.member_maps:{decoder}",
        member,
        (known.size_bytes, known.sha256),
        memory_bytes=(2 << 30) + 2 * known.size_bytes + 4 * size_bytes,
        timeout_s=60.0 + size_bytes / 10e6,
        height=height,
        width=width,
        **options,
    )
    pixels: NDArray[Any] = reply["maps"]
    return pixels


def _check_memory(archive: Archive, member: str, size_bytes: int) -> None:
    """Refuse pixels that are too many for any bundle, or many and more than the memory that is free would hold."""
    if size_bytes > BUNDLE_LIMIT_BYTES:
        raise InputError(archive.path, f"{member} would have {size_bytes:,} bytes of pixels", "Use a smaller bundle")
    if size_bytes <= _READ_UNASKED_BYTES or find_results_folder() is not None:
        return

    free = free_bytes()
    if size_bytes + archive.sizes.get(member, 0) > free:
        needs = f"{member} needs {size_text(size_bytes)} of memory, and {size_text(free)} are free"
        raise InputError(archive.path, needs, "Open it on a machine with more, or make the material smaller")


def check_fingerprint(archive: Archive, manifest: Manifest, name: str, content: bytes | NDArray[np.uint8]) -> None:
    """Raise InputError unless `content` is what the manifest says that member `name` holds."""
    member = _look_up(archive, manifest, name)
    plain = content if isinstance(content, bytes) else content.data
    if (len(content), hashlib.sha256(plain).hexdigest()) != (member.size_bytes, member.sha256):
        raise InputError(archive.path, f"{name} is not as it was written", "Ask for the bundle again")


def _look_up(archive: Archive, manifest: Manifest, name: str) -> Member:
    """What the manifest says of a member; InputError where it says nothing."""
    member = manifest.members.get(name)
    if member is None:
        raise InputError(archive.path, f"{name} is not in the manifest", _AGAIN)
    return member
