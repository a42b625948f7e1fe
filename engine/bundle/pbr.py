"""The PBR maps of a bundle: one OpenEXR of 32-bit floats, which gives every bit back.

Its channels are base_colour.R, G, B, normal.R, G, B (x, y, z), roughness, metallic and f0, height and occlusion where
they are known, and with `sigma.` before their names one standard deviation of each, where that is. Base colours in a
wider space than Rec.709 are `wide.base_colour` beside them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text, brdf_to_text
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import OpenPbr
from engine.bundle.manifest import PBR
from engine.bundle.maps import Produce, maps_member
from engine.core.errors import InputError, UsageError
from engine.images.exr_strips import Planes
from engine.storage.archive import Archive
from engine.storage.records import Manifest, PbrErrorsRecord, PbrRecord, WideColoursRecord
from engine.surface.pbr_maps import MapErrors, ObservedSlopes, PbrMaps, Uncertainty, WideColours, space_of

_ALWAYS, _WHERE_KNOWN = ("base_colour", "normal", "roughness", "metallic", "f0"), ("height", "occlusion")
_SIGMA = "sigma."

#: Maps of three channels; of the uncertainties, that of normals is one angle.
_WIDE = "wide.base_colour"
_COLOURS = ("base_colour", "normal", f"{_SIGMA}base_colour", _WIDE, f"{_SIGMA}{_WIDE}")

_UNITS = "base_colour: linear sRGB; normal: x right, y up, z out; roughness: alpha is its square; height: texels"

Maps = NDArray[np.float32]


def pbr_members(maps: PbrMaps) -> dict[str, Produce]:
    """Producer of the member."""
    units = _UNITS if maps.wide is None else f"{_UNITS}; {_WIDE}: {space_of(maps).label}"
    return {PBR: lambda: Planes(_channels(maps), {"unit": units})}


def pbr_record(maps: PbrMaps | None, white: float | None = None) -> PbrRecord | None:
    """The record of `maps`; `white` is the radiance of their white card where they are of photographs."""
    if maps is None:
        return None
    errors = {name: _number(getattr(maps.errors, name)) for name in PbrErrorsRecord.model_fields}
    return PbrRecord(
        height_px=maps.size[0],
        width_px=maps.size[1],
        maps=[name for name in (*_ALWAYS, *_WHERE_KNOWN) if getattr(maps, name) is not None],
        uncertainty=maps.uncertainty is not None,
        observed_slopes=maps.observed.kind,
        observed_azimuth=None if maps.observed.azimuth is None else float(maps.observed.azimuth),
        errors=PbrErrorsRecord(**errors),
        multiple_scattering=maps.multiple_scattering,
        layers=None if maps.layers is None else brdf_to_text(maps.layers),
        white_radiance=white,
        wide=_wide_record(maps.wide),
        tiles=maps.tiles,
    )


def _wide_record(wide: WideColours | None) -> WideColoursRecord | None:
    if wide is None:
        return None
    share, distance = wide.clipped
    known = wide.sigma is not None
    return WideColoursRecord(space=wide.space, sigma=known, beyond_rec709=share, distance=distance)  # type: ignore[arg-type]


def read_pbr(archive: Archive, manifest: Manifest) -> PbrMaps | None:
    """The PBR maps of a bundle, bit for bit; None where it holds none. ValueError for values that no maps have."""
    record = manifest.pbr
    if record is None:
        return None
    if set(record.maps) != {*_ALWAYS, *(set(record.maps) & set(_WHERE_KNOWN))} or len(set(record.maps)) < len(
        record.maps
    ):
        raise InputError(archive.path, f"{PBR} has other maps than those of a BRDF", "Export the bundle again")
    names = [*record.maps, *(f"{_SIGMA}{name}" for name in record.maps if record.uncertainty)]
    wide = record.wide
    if wide is not None:
        names += [_WIDE, f"{_SIGMA}{_WIDE}"] if wide.sigma else [_WIDE]
    planes = [channel for name in names for channel in _names(name)]
    pixels = dict(
        zip(planes, maps_member(archive, manifest, PBR, planes, record.height_px, record.width_px), strict=True)
    )
    found = {name: _join([pixels[channel] for channel in _names(name)]) for name in names}
    sigma = {name: found.get(f"{_SIGMA}{name}") for name in record.maps}
    errors = {name: np.nan if value is None else value for name, value in record.errors.model_dump().items()}
    maps: dict[str, Maps] = {name: found[name] for name in record.maps}
    return PbrMaps(
        **maps,
        uncertainty=Uncertainty(**sigma) if record.uncertainty else None,  # type: ignore[arg-type]
        observed=ObservedSlopes(record.observed_slopes, record.observed_azimuth),
        errors=MapErrors(**errors),
        multiple_scattering=record.multiple_scattering,
        layers=None if record.layers is None else _layers(archive, record.layers),
        tiles=record.tiles,
        wide=None
        if wide is None
        else WideColours(wide.space, found[_WIDE], found.get(f"{_SIGMA}{_WIDE}"), (wide.beyond_rec709, wide.distance)),
    )


def _layers(archive: Archive, text: str) -> OpenPbr | MetallicRoughness:
    """The layers that a record says; InputError for another model."""
    try:
        found = brdf_from_text(text)
    except UsageError as error:
        raise InputError(
            archive.path, f"states layers that there are not ({error})", "Export the bundle again"
        ) from None
    if not isinstance(found, OpenPbr | MetallicRoughness):
        raise InputError(archive.path, "states layers of a model that has none", "Export the bundle again")
    return found


def _channels(maps: PbrMaps) -> dict[str, Maps]:
    sources = {"": maps} if maps.uncertainty is None else {"": maps, _SIGMA: maps.uncertainty}
    channels: dict[str, Maps] = {}
    for prefix, source in sources.items():
        for name in (*_ALWAYS, *_WHERE_KNOWN):
            values = getattr(source, name)
            if name == "height" and source is maps.uncertainty and maps.region is not None:
                # bundles hold no regions: heights of others than the largest are unknown to it
                values = np.where(maps.region == 0.0, values, np.float32(np.inf))
            if values is not None:
                planes = np.moveaxis(values, 2, 0) if values.ndim == 3 else [values]
                channels |= zip(_names(f"{prefix}{name}"), planes, strict=True)
    if maps.wide is not None:
        for prefix, values in (("", maps.wide.base_colour), (_SIGMA, maps.wide.sigma)):
            if values is not None:
                channels |= zip(_names(f"{prefix}{_WIDE}"), np.moveaxis(values, 2, 0), strict=True)
    return channels


def _names(name: str) -> list[str]:
    return [f"{name}.{channel}" for channel in "RGB"] if name in _COLOURS else [name]


def _join(planes: list[Maps]) -> Maps:
    return np.ascontiguousarray(np.stack(planes, axis=2) if len(planes) > 1 else planes[0])


def _number(value: float) -> float | None:
    """A figure of the record; None for one that is not known."""
    return float(value) if np.isfinite(value) else None
