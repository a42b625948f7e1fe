"""Photographs become a stack: read, compared, aligned, cut to what all show, written, and reported on.

One photograph is in memory at a time: it is read into a scratch file, and from there, once all motions are known,
warped in bands of rows into `radiance.npy`. Every number is independent of the height of the bands.
Cost: for ten photographs of 24 megapixels some 100 s on two cores, 1.3 GiB (0.7 GiB more in the decoder process) and
twice the disk space of the result.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Hashable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import engine
from engine.capture.align import MOTIONS, Alignment, Grey, align, reduced, reduction
from engine.capture.assumptions import compare_azimuths
from engine.capture.decode import Photograph, WhiteBalance, read_photograph
from engine.capture.report import BLACK, Quality, grid_step, leave_one_out, noise_and_sharpness, report
from engine.capture.sources import ONE_ARC, Sources, azimuth_spread
from engine.capture.stack import RADIANCE, RECORD, SATURATED, ImageStack, StackRecord, npy_header, open_stack
from engine.capture.warp import Region, valid_region, warp
from engine.colour import LUMINANCE, to_display8
from engine.errors import InputError
from engine.files.atomic import atomic_file, atomic_folder, write_bytes
from engine.files.manifest import HealthRecord
from engine.files.scratch import release, scratch_array
from engine.health import Finding, Health, Verdict
from engine.steps import Step, Steps, part

_BAND_PIXELS = 1 << 20
_THUMBNAIL_SIDE = 256


@dataclass(frozen=True)
class ImportSettings:
    """Choices of an import.

    Attributes
    ----------
    motion : one of `align.MOTIONS`, 'none' for a camera that stood still, or 'auto': Euclidean for lights on one arc,
        none for lights all around, whose pictures are too unlike and come from rigs with a fixed camera.
    white_balance : of RAW files: 'camera', 'none', or multipliers of red, green, blue.
    transfer : of 8- and 16-bit files: 'auto', 'srgb' or 'linear'.
    crop : (left, top, width, height) in pixels of the upright photographs, None for all that they share.
    """

    motion: str = "auto"
    white_balance: WhiteBalance = "camera"
    transfer: str = "auto"
    crop: tuple[int, int, int, int] | None = None

    def __post_init__(self) -> None:
        if self.motion not in ("auto", "none", *MOTIONS):
            raise ValueError(f"unknown motion {self.motion!r}; known are auto, none, {', '.join(MOTIONS)}")
        if self.transfer not in ("auto", "srgb", "linear"):
            raise ValueError(f"unknown transfer {self.transfer!r}; known are auto, srgb, linear")
        if self.crop is not None and (min(self.crop[:2]) < 0 or min(self.crop[2:]) < 1):
            raise ValueError(f"crop {self.crop} needs left and top from 0, width and height from 1")


@dataclass(frozen=True, eq=False)
class ThumbnailReady:
    """A photograph has been read: uint8 sRGB `thumbnail` (h, w, 3), its light's `elevation` in radians."""

    path: Path
    elevation: float
    thumbnail: NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class _Read:
    """What is kept of the photographs when they have been read: pixels in scratch arrays, the rest in memory."""

    radiance: NDArray[np.float32]
    saturated: NDArray[np.bool_]
    photographs: list[Photograph]
    greys: list[Grey]
    noise_and_sharpness: list[tuple[float, float]]


@dataclass(eq=False)
class _Sums:
    """What is summed over one photograph while it is written, by rows so that bands of any height agree."""

    rows: list[NDArray[np.float64]] = field(default_factory=list)
    clipped: int = 0
    black: int = 0
    grid: list[NDArray[np.float32]] = field(default_factory=list)

    def add(self, band: NDArray[np.float32], mask: NDArray[np.bool_], first: int, step: int) -> None:
        self.rows.append(band.sum(axis=1, dtype=np.float64))
        self.clipped += int(np.count_nonzero(mask))
        self.black += int(np.count_nonzero(_luminance(band) < BLACK))
        self.grid.append(band[-first % step :: step, ::step].copy())

    def mean_radiance(self, pixels: int) -> float:
        total = [math.fsum(channel) for channel in np.concatenate(self.rows).T]
        return float(np.dot(total, LUMINANCE)) / pixels


def import_stack(sources: Sources, settings: ImportSettings, folder: str | os.PathLike[str]) -> Steps[ImageStack]:
    """Import `sources` into the stack folder `folder`, which is complete or absent, and open it.

    Steps carry a `ThumbnailReady` when a photograph has been read. Raises InputError for photographs that cannot be
    read or do not fit together, OutputError where the folder cannot be written.
    """
    names = [printable(path) for path in sources.photographs]
    read = yield from part(_read_all(sources, settings, names), 0.0, 0.55)
    findings = [*sources.findings, *_contradictions(names, read.photographs)]
    settings = _decided(settings, sources)
    alignment = yield from part(_aligned(read.greys, names, settings.motion, read.saturated.shape), 0.55, 0.75)
    region = _region(sources, settings, alignment, read.saturated.shape[1:])
    shape = (len(names), region.height, region.width)
    size_bytes = math.prod(shape) * 13 + (1 << 20)
    with atomic_folder(folder, RECORD, size_bytes) as place:
        sums = yield from part(_write_pixels(place, read, alignment, region), 0.75, 1.0)
        mean_radiance = np.array([one.mean_radiance(region.width * region.height) for one in sums])
        grid = np.stack([np.concatenate(one.grid) for one in sums])
        qualities = _qualities(read, alignment, sums, leave_one_out(grid, mean_radiance), region)
        azimuths = compare_azimuths(grid, mean_radiance, sources.azimuth)
        findings += [azimuths.finding()] if azimuths else []
        health = Health(findings=(*findings, *alignment.findings)).merged(report(names, mean_radiance, qualities))
        record = StackRecord(
            lightarc_stack=1,
            height_px=region.height,
            width_px=region.width,
            sources=names,
            elevations_deg=[float(angle) for angle in np.degrees(sources.elevation)],
            azimuths_deg=None if sources.azimuth is None else [float(a) for a in np.degrees(sources.azimuth)],
            angle_source=sources.angle_source,  # type: ignore[arg-type]
            mean_radiance=[float(mean) for mean in mean_radiance],
            quality=qualities,
            provenance=_provenance(sources, settings, names, read.photographs, alignment, region),
            health=HealthRecord.of(health),
        )
        write_bytes(place / RECORD, record.model_dump_json(indent=1).encode())
    return open_stack(folder)


def printable(path: Path) -> str:
    """The file name as text that can be stored: bytes that are no UTF-8 become replacement characters."""
    return os.fsencode(path.name).decode("utf-8", "replace")


def _read_all(sources: Sources, settings: ImportSettings, names: Sequence[str]) -> Steps[_Read]:
    count = len(names)
    read: _Read | None = None
    sizes: list[tuple[int, int]] = []
    for index, path in enumerate(sources.photographs):
        yield Step(index / count, f"Reading {index + 1} of {count}")
        photograph = _photograph(path, sources, settings)
        yield Step((index + 0.7) / count, f"Looking at {index + 1} of {count}")
        height, width = photograph.saturated.shape
        sizes.append((width, height))
        if read is None:
            shape = (count, height, width)
            read = _Read(scratch_array((*shape, 3), np.float32), scratch_array(shape, np.bool_), [], [], [])
        if sizes[index] == sizes[0]:
            _keep(read, index, photograph, sources.exposure_s[index])
            ready = ThumbnailReady(path, float(sources.elevation[index]), _thumbnail(photograph.radiance))
            yield Step((index + 1) / count, f"Read {index + 1} of {count}", ready)
        del photograph
    _refuse_different_sizes(sources, names, sizes)
    assert read is not None
    _refuse_equal_pictures(sources, names, read.greys)
    return read


def _photograph(path: Path, sources: Sources, settings: ImportSettings) -> Photograph:
    transfer: Any = settings.transfer if settings.transfer != "auto" else sources.transfer or "auto"
    return read_photograph(path, white_balance=settings.white_balance, transfer=transfer)


def _keep(read: _Read, index: int, photograph: Photograph, exposure_s: float | None) -> None:
    """Put the pixels into the scratch files and keep the small things."""
    read.radiance[index], read.saturated[index] = photograph.radiance, photograph.saturated
    release(read.radiance)
    release(read.saturated)
    luminance = _luminance(photograph.radiance)
    read.noise_and_sharpness.append(noise_and_sharpness(luminance))
    read.greys.append(reduced(luminance, reduction(*luminance.shape)).copy())
    nothing = np.empty((0, 0, 3), np.float32)
    known = exposure_s if exposure_s is not None else photograph.exposure_s
    read.photographs.append(replace(photograph, radiance=nothing, saturated=nothing[..., 0] > 0, exposure_s=known))


def _luminance(radiance: NDArray[np.float32]) -> Grey:
    luminance = radiance[..., 0] * np.float32(LUMINANCE[0])
    for channel in (1, 2):
        luminance += radiance[..., channel] * np.float32(LUMINANCE[channel])
    return luminance


def _thumbnail(radiance: NDArray[np.float32]) -> NDArray[np.uint8]:
    height, width = radiance.shape[:2]
    scale = min(1.0, _THUMBNAIL_SIDE / max(height, width))
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    return to_display8(cv2.resize(radiance, size, interpolation=cv2.INTER_AREA))


def _refuse_different_sizes(sources: Sources, names: Sequence[str], sizes: Sequence[tuple[int, int]]) -> None:
    (usual, usual_count), *others = Counter(sizes).most_common()
    if not others:
        return
    odd = [f"{name} has {w} × {h}" for name, (w, h) in zip(names, sizes, strict=True) if (w, h) != usual]
    more = f" and {len(odd) - 8} more differ" if len(odd) > 8 else ""
    problem = (
        f"{usual_count} of {len(names)} photographs have {usual[0]} × {usual[1]} px, but {', '.join(odd[:8])}{more}"
    )
    remedy = "Leave these out, or crop them to the size of the others"
    raise InputError(sources.photographs[0].parent, problem, remedy)


def _refuse_equal_pictures(sources: Sources, names: Sequence[str], greys: Sequence[Grey]) -> None:
    """Two lights never give the same pixels, unless these are all alike (black, or white)."""
    seen: dict[Hashable, str] = {}
    for name, grey in zip(names, greys, strict=True):
        if grey.size and grey.min() < grey.max():
            first = seen.setdefault(grey.tobytes(), name)
            if first != name:
                problem = f"{first} and {name} are the same picture"
                raise InputError(sources.photographs[0].parent, problem, "Leave one of them out")


def _contradictions(names: Sequence[str], photographs: Sequence[Photograph]) -> list[Finding]:
    """What differs between photographs that should be alike, and what the decoder had to say."""
    exposure = "exposures differ: {}. Radiance is not scaled for them; bring them to one exposure first"
    findings = [
        Finding(Verdict.WARNING if verdict else Verdict.NOTE, text, name)
        for name, photograph in zip(names, photographs, strict=True)
        for verdict, text in ((True, warning) for warning in photograph.warnings)
    ]
    for text, key in (
        ("bit depths differ: {}. Each is scaled by its own white level", lambda p: f"{p.bit_depth} bit"),
        ("cameras differ: {}", lambda p: p.camera or "unknown"),
        ("transfer functions differ: {}", lambda p: p.transfer),
        (exposure, _exposure),
    ):
        groups = _groups(names, photographs, key)
        if len(groups) > 1:
            findings.append(Finding(Verdict.WARNING, text.format(_table(groups)).capitalize()))
    return findings


def _exposure(photograph: Photograph) -> str:
    known = [
        f"{photograph.exposure_s:g} s" if photograph.exposure_s else "",
        f"f/{photograph.aperture:g}" if photograph.aperture else "",
        f"ISO {photograph.iso:g}" if photograph.iso else "",
    ]
    return " ".join(filter(None, known)) or "unknown"


def _groups(
    names: Sequence[str], photographs: Sequence[Photograph], key: Callable[[Photograph], str]
) -> dict[str, list[str]]:
    groups: dict[str, list[str]] = {}
    for name, photograph in zip(names, photographs, strict=True):
        groups.setdefault(key(photograph), []).append(name)
    return dict(sorted(groups.items(), key=lambda item: -len(item[1])))


def _table(groups: dict[str, list[str]]) -> str:
    """'8 × 16 bit; 8 bit: a.png, b.png': the usual value by its count, the odd ones by name."""
    (usual, names), *odd = groups.items()
    named = [f"{value}: {', '.join(some[:4])}{' …' if len(some) > 4 else ''}" for value, some in odd]
    return "; ".join([f"{len(names)} × {usual}", *named])


def _decided(settings: ImportSettings, sources: Sources) -> ImportSettings:
    if settings.motion != "auto":
        return settings
    return replace(settings, motion="euclidean" if azimuth_spread(sources.azimuth) <= ONE_ARC else "none")


def _aligned(greys: list[Grey], names: Sequence[str], motion: str, shape: tuple[int, ...]) -> Steps[Alignment]:
    if motion != "none":
        return (yield from align(greys, names, motion, reduction(*shape[1:])))
    count = len(names)
    nothing = np.full(count, np.nan)
    return Alignment(np.tile(np.eye(3), (count, 1, 1)), nothing, np.zeros(count, bool), np.zeros(count), 0)


def _region(sources: Sources, settings: ImportSettings, alignment: Alignment, size: tuple[int, ...]) -> Region:
    shared = valid_region(alignment.matrix, *size)
    if settings.crop is None:
        return shared
    cut = shared.intersected(Region(*settings.crop))
    if cut.width < 1 or cut.height < 1:
        problem = f"the crop {','.join(map(str, settings.crop))} lies outside what all {size[1]} × {size[0]} px show"
        raise InputError(sources.photographs[0].parent, problem, "Give left,top,width,height within the photographs")
    return cut


def _write_pixels(place: Path, read: _Read, alignment: Alignment, region: Region) -> Steps[list[_Sums]]:
    """Warp every photograph, band by band, into the two .npy files."""
    count = len(read.greys)
    step = grid_step(region.height, region.width)
    rows = max(1, _BAND_PIXELS // region.width)
    all_sums = []
    with ExitStack() as files:
        radiance, saturated = (files.enter_context(atomic_file(place / name)) for name in (RADIANCE, SATURATED))
        radiance.write(npy_header((count, region.height, region.width, 3), np.float32))
        saturated.write(npy_header((count, region.height, region.width), np.bool_))
        for index, matrix in enumerate(alignment.matrix):
            sums = _Sums()
            for first in range(0, region.height, rows):
                yield Step((index + first / region.height) / count, f"Writing {index + 1} of {count}")
                stop = min(first + rows, region.height)
                band, mask = warp(read.radiance[index], read.saturated[index], matrix, region, first, stop)
                radiance.write(band.data)
                saturated.write(mask.data)
                sums.add(band, mask, first, step)
            release(read.radiance)
            release(read.saturated)
            all_sums.append(sums)
    return all_sums


def _qualities(
    read: _Read, alignment: Alignment, sums: list[_Sums], errors: list[float | None], region: Region
) -> list[Quality]:
    pixels = region.width * region.height
    residuals = [None if np.isnan(residual) else float(residual) for residual in alignment.residual_px]
    return [
        Quality(one.clipped / pixels, one.black / pixels, noise, sharpness, residual, error)
        for one, (noise, sharpness), residual, error in zip(
            sums, read.noise_and_sharpness, residuals, errors, strict=True
        )
    ]


def _provenance(
    sources: Sources,
    settings: ImportSettings,
    names: Sequence[str],
    photographs: Sequence[Photograph],
    alignment: Alignment,
    region: Region,
) -> dict[str, Any]:
    """JSON values: what was assumed and done."""
    return {
        "software": f"lightarc {engine.__version__}",
        "notes": sources.notes,
        "cameras": sorted({photograph.camera for photograph in photographs if photograph.camera}),
        "angle_source": sources.angle_source,
        "motion": settings.motion,
        "aligned_to": names[alignment.reference] if alignment.aligned.any() else None,
        "crop_px": [region.left, region.top, region.width, region.height],
        "photographs": [
            {
                "file": name,
                "camera": photograph.camera,
                "container": photograph.container,
                "bit_depth": photograph.bit_depth,
                "transfer": photograph.transfer,
                "exposure_s": photograph.exposure_s,
                "iso": photograph.iso,
                "aperture": photograph.aperture,
                "black_level": list(photograph.black_level),
                "white_level": list(photograph.white_level),
                "white_balance": list(photograph.white_balance),
                "alignment_matrix": [float(value) for value in matrix.ravel()],
            }
            for name, photograph, matrix in zip(names, photographs, alignment.matrix, strict=True)
        ],
    }
