"""TIFF 6.0 and BigTIFF through tifffile, with the checks that tifffile leaves to its caller.

tifffile fills missing strips with zeros. Here every strip and tile must lie inside the file and be as long as its
pixels need before the image is decoded.
"""

from __future__ import annotations

import io
import logging
import math
import struct
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import cv2
import imagecodecs
import numpy as np
import tifffile
from numpy.typing import NDArray

from engine.core.colour import CHROMATICITIES
from engine.core.errors import InputError
from engine.images.colour_space import LINEAR_CURVE, SRGB_CURVE, ColourSpace, Curve, from_chromaticities
from engine.images.icc import InvalidProfile, check_curve, settle_curves
from engine.images.jpeg import check_jpeg
from engine.images.raster import UNWANTED, Raster, Transfer, check_size, white_code
from engine.images.tiff_directories import TYPE_BYTES, check_directories
from engine.storage.decoder_child import complaints
from engine.storage.shared_memory import result_array
from engine.storage.untrusted import AGAIN

SIGNATURES = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")

#: Mark of our own linear TIFFs in ImageDescription.
LINEAR_MARK = '"transfer": "linear"'

_WHITE_POINT, _PRIMARIES, _TRANSFER_FUNCTION = 318, 319, 301
_STRIP_OFFSETS, _TILE_OFFSETS, _EXIF_DIRECTORY = 273, 324, 34665
_NONE, _JPEG, _JPEGS, _LOGLUV = 1, 7, (6, 7), (34676, 34677)

#: Most directories that are walked, of images and their parts.
DIRECTORIES_LIMIT = 10_000

#: Strips and tiles may overlap, where they are alike, but not so that the file is walked more often than this.
_OVERLAPS_LIMIT = 16

#: Decoded length of a segment, for codings that do not state it.
_LENGTHS: dict[int, Callable[[memoryview], int]] = {
    _NONE: len,
    5: lambda segment: len(imagecodecs.lzw_decode(bytes(segment))),
    32773: lambda segment: len(imagecodecs.packbits_decode(bytes(segment))),
}

_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE, _YCBCR = 0, 1, 2, 3, 6
_PHOTOMETRIC_NAMES = {4: "a mask", 5: "CMYK", 8: "CIE L*a*b*", 9: "ICC L*a*b*", 10: "ITU L*a*b*", 32844: "LogL"}
_UNSIGNED, _SIGNED, _FLOAT = 1, 2, 3
_ASSOCIATED = 1
RAW_PHOTOMETRICS = (32803, 34892)

logging.getLogger("tifffile").setLevel(logging.CRITICAL)


def is_raw_tiff(content: bytes, name: str) -> bool:
    """True for DNG and camera files that are TIFFs outside and sensor data inside; InputError for endless ones."""
    if content[8:10] == b"CR":
        return True
    check_directories(content, name, DIRECTORIES_LIMIT)
    with tifffile.TiffFile(io.BytesIO(content)) as file:
        first = file.pages[0]
        if "DNGVersion" in first.tags:
            return True
        return any(page.photometric in RAW_PHOTOMETRICS for page in (first, *(first.pages or ())))


def cut_images(content: bytes) -> bytes:
    """The content of a TIFF without the samples of its images; previews stay, as a JPEG may hold what a file says."""
    with tifffile.TiffFile(io.BytesIO(content)) as file:
        pages = [page for top in file.pages for page in (top, *(top.pages or ()))]
        samples = [page for page in pages if page.compression not in _JPEGS or page.photometric in RAW_PHOTOMETRICS]
        segments = [each for page in samples for each in zip(page.dataoffsets, page.databytecounts, strict=False)]
    kept, end = [], 0
    for offset, count in sorted(segments):
        kept.append(content[end:offset])
        end = max(end, offset + count)
    return b"".join([*kept, content[end:]])


def read_tiff(content: bytes, name: str) -> Raster:
    check_directories(content, name, DIRECTORIES_LIMIT)
    with tifffile.TiffFile(io.BytesIO(content)) as file:
        page, count = _find_page(file)
        _check_page(page, content, name)
        warnings: tuple[str, ...] = ()
        if count > 1:
            warnings += (f"has {count} pages, of which the first is used",)
        if page.compression in _LOGLUV:
            return Raster(_read_logluv(content, name), None, 16, "linear", "TIFF", warnings)
        bands = _planes(page)
        if page.photometric == _WHITE_IS_ZERO:
            bands = _full_scale(page) - bands
        bands = bands.astype(np.uint8) if bands.dtype.kind == "b" else bands
        if page.photometric == _PALETTE:
            warnings += ("has an extra channel, which is ignored",) if bands.shape[2] > 1 else ()
            return _raster(page, _look_up(page, bands[..., 0], name), warnings)
        samples = bands[..., :3] if page.photometric in (_RGB, _YCBCR) else bands[..., 0]
        if _ASSOCIATED in page.extrasamples[:1] and page.photometric != _WHITE_IS_ZERO:
            alpha = bands[..., 3 if samples.ndim == 3 else 1]
            if (alpha < _full_scale(page)).any():
                samples = _divide(samples, alpha, _full_scale(page))
                warnings += ("has colours that were multiplied by its alpha channel, which was undone",)
        raster = replace(_raster(page, samples, warnings), is_grey=samples.ndim == 2)
        return replace(raster, bands=bands) if bands[0, 0].size > samples[0, 0].size else raster


def _find_page(file: tifffile.TiffFile) -> tuple[tifffile.TiffPage, int]:
    """The first image of full size, and the number of those: cameras put a thumbnail before it, which may hold it.

    Where all say that they are reduced, these are the first of them and their number.
    """
    pages = list(file.pages)
    whole = [each for each in pages if not each.is_reduced]
    if not whole:
        whole = [part for each in pages for part in each.pages or () if not part.is_reduced]
    return (whole or pages)[0], len(whole or pages)


def _divide(samples: NDArray[Any], alpha: NDArray[Any], white: Any) -> NDArray[Any]:
    """Samples (H, W) or (H, W, 3) by the alpha (H, W) that they were multiplied by, up to `white` where they are codes;
    black where it is 0."""
    share = np.maximum(alpha if samples.ndim == 2 else alpha[..., None], 0).astype(np.float64) / white
    whole = np.divide(samples, share, out=np.zeros(samples.shape), where=share > 0.0)
    return (whole if samples.dtype.kind == "f" else np.rint(np.minimum(whole, white))).astype(samples.dtype)


def _planes(page: tifffile.TiffPage) -> NDArray[Any]:
    """Samples as (H, W, S), whatever their planar configuration and byte order."""
    samples = page.asarray(squeeze=False, out=result_array(page.shaped, page.dtype))
    samples = samples.reshape(samples.shape[-5:])
    planes, _, height, width, contiguous = samples.shape
    samples = samples.reshape(planes, height, width, contiguous)
    samples = np.moveaxis(samples, 0, -1).reshape(height, width, -1) if planes > 1 else samples[0]
    return samples.astype(samples.dtype.newbyteorder("="), copy=False)


def _check_page(page: tifffile.TiffPage, content: bytes, name: str) -> None:
    bytes_per_pixel = max(1, math.ceil(page.samplesperpixel * page.bitspersample / 8))
    check_size(name, page.imagewidth, page.imagelength, bytes_per_pixel, len(content))
    if page.is_tiled:
        check_size(name, page.tilewidth, page.tilelength, bytes_per_pixel, len(content))
    if page.imagedepth != 1:
        raise InputError(name, f"is a TIFF volume of {page.imagedepth} slices", UNWANTED)
    _check_kind(page, name)
    check_segments(page, content, name)


def _check_kind(page: tifffile.TiffPage, name: str) -> None:
    """Refuse by name what is not converted."""
    kind = page.photometric
    known = (_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE)
    if kind not in known and not (kind == _YCBCR and page.compression == _JPEG) and page.compression not in _LOGLUV:
        raise InputError(
            name, f"is a TIFF in {_PHOTOMETRIC_NAMES.get(int(kind), f'colour space {int(kind)}')}", UNWANTED
        )
    if page.compression in _LOGLUV:
        return
    if page.sampleformat not in (_UNSIGNED, _FLOAT) or page.dtype is None:
        what = "signed integers" if page.sampleformat == _SIGNED else f"sample format {page.sampleformat}"
        raise InputError(name, f"is a TIFF of {what}", UNWANTED)
    expected = 3 if kind in (_RGB, _YCBCR) else 1
    if not expected <= page.samplesperpixel <= expected + len(page.extrasamples) or page.samplesperpixel > 8:
        raise InputError(name, f"is a TIFF of {page.samplesperpixel} samples per pixel", UNWANTED)


def check_tags(content: bytes, directory: int, name: str) -> None:
    """The values of all tags of the directory at this place, and of its EXIF directory, lie in the file (not BigTIFF).

    tifffile and LibRaw leave out a tag whose value is missing, and with it a white balance or an exposure time.
    """
    order = "<" if content.startswith(b"II") else ">"
    (count,) = struct.unpack_from(f"{order}H", content, directory)
    for entry in range(count):
        tag, kind, length, value = struct.unpack_from(f"{order}HHII", content, directory + 2 + 12 * entry)
        size_bytes = TYPE_BYTES.get(kind, 0) * length
        if size_bytes > 4 and value + size_bytes > len(content):
            raise InputError(name, f"is an incomplete TIFF: the value of its tag {tag} is missing", AGAIN)
        if tag == _EXIF_DIRECTORY and value != directory:
            check_tags(content, value, name)


def check_segments(page: tifffile.TiffPage, content: bytes, name: str) -> None:
    """Every strip or tile is there, inside the file, and long enough where its length is known beforehand."""
    offsets, counts = page.dataoffsets, page.databytecounts
    width, height = page.imagewidth, page.imagelength
    if page.is_tiled:
        expected = math.ceil(width / page.tilewidth) * math.ceil(height / page.tilelength)
    else:
        expected = math.ceil(height / min(page.rowsperstrip, height))
    expected *= page.samplesperpixel if page.planarconfig == 2 else 1
    listed = (page.tags.get(_TILE_OFFSETS) or page.tags[_STRIP_OFFSETS]).count
    if not listed == len(offsets) == len(counts) == expected:
        problem = f"is a damaged TIFF (its size needs {expected} strips or tiles, {listed} are listed)"
        raise InputError(name, problem, AGAIN)
    for offset, count in zip(offsets, counts, strict=True):
        if count <= 0 or offset <= 0 or offset + count > len(content):
            raise InputError(name, "is an incomplete TIFF: it ends before its image does", AGAIN)
    if sum(counts) > _OVERLAPS_LIMIT * len(content):
        raise InputError(name, "is a damaged TIFF (its strips or tiles overlap)", AGAIN)
    _check_lengths(page, content, name)


def _check_lengths(page: tifffile.TiffPage, content: bytes, name: str) -> None:
    """Check that strips or tiles hold what the image's size needs: tifffile cuts or pads what does not fit."""
    tiled = page.is_tiled
    width, rows = page.imagewidth, min(page.rowsperstrip, page.imagelength)
    if tiled:
        width, rows = page.tilewidth, page.tilelength
    samples = page.samplesperpixel if page.planarconfig == 1 else 1
    row_bytes = math.ceil(width * samples * page.bitspersample / 8)
    last = len(page.dataoffsets) - 1
    for index, (offset, count) in enumerate(zip(page.dataoffsets, page.databytecounts, strict=True)):
        segment = memoryview(content)[offset : offset + count]
        if page.compression == _JPEG:
            fits = check_jpeg(bytes(segment), name).width == width or page.photometric in RAW_PHOTOMETRICS
        elif page.compression in _LENGTHS and page.fillorder == 1 and (page.compression == _NONE or index == last):
            first_row = index % math.ceil(page.imagelength / rows) * rows
            needed = row_bytes * (rows if tiled else min(rows, page.imagelength - first_row))
            fits = needed <= _LENGTHS[page.compression](segment) <= needed + 3
        else:
            fits = True
        if not fits:
            raise InputError(name, "is a damaged TIFF (its strips or tiles do not fit its size)", AGAIN)


def _look_up(page: tifffile.TiffPage, indices: NDArray[Any], name: str) -> NDArray[Any]:
    """The colours (H, W, 3) that `indices` name in a palette."""
    palette = np.asarray(page.colormap)
    if indices.max(initial=0) >= palette.shape[1]:
        raise InputError(name, "is a damaged TIFF (its palette is too short)", AGAIN)
    return palette[:, indices].transpose(1, 2, 0)


def _full_scale(page: tifffile.TiffPage) -> Any:
    return page.dtype.type(1 if page.dtype.kind in "fb" else (1 << page.bitspersample) - 1)


def _raster(page: tifffile.TiffPage, samples: NDArray[Any], warnings: tuple[str, ...]) -> Raster:
    profile = bytes(page.iccprofile or b"")
    if samples.dtype.kind == "f":
        return Raster(samples, None, page.bitspersample, "linear", "TIFF", warnings, profile=profile)
    if page.bitspersample == 1:
        warnings += ("has 1 bit per pixel: black and white only",)
    bits = 16 if page.photometric == _PALETTE else page.bitspersample
    white = white_code(samples, bits) if bits == 16 and page.photometric != _PALETTE else (1 << bits) - 1
    space, invalid = None, ""
    try:
        space = None if profile else _space_of_tags(page)
    except InvalidProfile as error:
        invalid = str(error)
    return Raster(
        samples,
        white,
        page.bitspersample,
        _transfer(page),
        "TIFF",
        warnings,
        profile=profile,
        space=space,
        invalid_space=invalid,
    )


def _space_of_tags(page: tifffile.TiffPage) -> ColourSpace | None:
    """The space of the tags WhitePoint, PrimaryChromaticities and TransferFunction (TIFF 6.0, section 20) of an image
    without an ICC profile, None where they state no other than sRGB; InvalidProfile for one that no image has."""
    if page.photometric not in (_RGB, _BLACK_IS_ZERO):
        return None
    primaries = _rationals(page, _PRIMARIES, 6) if page.photometric == _RGB else None
    white = _rationals(page, _WHITE_POINT, 2) if page.photometric == _RGB else None
    curves = _transfer_functions(page)
    matrix = None
    if primaries is not None or white is not None:
        rgb = CHROMATICITIES[:6] if primaries is None else primaries
        try:
            matrix = from_chromaticities((*rgb, *(CHROMATICITIES[6:] if white is None else white)))
        except ValueError:
            raise InvalidProfile("states primaries that no colours have") from None
    if curves is None and matrix is None:
        return None
    plain = LINEAR_CURVE if _transfer(page) == "linear" else SRGB_CURVE
    return ColourSpace("the colour tags of the TIFF", curves or (plain,), matrix)


def _rationals(page: tifffile.TiffPage, tag: int, count: int) -> tuple[float, ...] | None:
    """The numbers of a tag of fractions, None where there is none; InvalidProfile where it holds others."""
    found = page.tags.get(tag)
    if found is None:
        return None
    values = np.asarray(found.value, np.float64).ravel()
    if len(values) != 2 * count or (values[1::2] == 0.0).any():
        raise InvalidProfile("states primaries that no colours have")
    return tuple((values[::2] / values[1::2]).tolist())


def _transfer_functions(page: tifffile.TiffPage) -> tuple[Curve, ...] | None:
    """Curves of the tag TransferFunction: one table of the linear values of all codes, or three."""
    found = page.tags.get(_TRANSFER_FUNCTION)
    if found is None or page.sampleformat != _UNSIGNED or page.bitspersample > 16:
        return None
    values = np.asarray(found.value, np.float64).ravel()
    size = 1 << page.bitspersample
    if len(values) not in (size, 3 * size):
        raise InvalidProfile("has a transfer function (TIFF tag 301) of another length than its samples need")
    tables = values.reshape(-1, size) / 65535.0
    if len(tables) == 3 and page.photometric != _RGB:
        tables = tables[:1]
    curves = tuple(check_curve(Curve(samples=table)) for table in tables)
    curves = curves[:1] if all(curve.is_like(curves[0]) for curve in curves) else curves
    return settle_curves(curves)


def _transfer(page: tifffile.TiffPage) -> Transfer:
    return "linear" if LINEAR_MARK in (page.description or "") else "srgb"


def _read_logluv(content: bytes, name: str) -> NDArray[np.float32]:
    """LogLuv (WardLarson1998) through libtiff, which tifffile does not decode."""
    with complaints() as said:
        samples = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    if samples is None or samples.dtype != np.float32 or samples.ndim != 3 or said:
        raise InputError(name, f"is a damaged LogLuv TIFF ({' '.join(said)[:100] or 'it cannot be decoded'})", AGAIN)
    return samples[..., 2::-1]
