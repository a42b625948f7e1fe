"""Photographs become a stack: read, calibrated, merged, aligned, cut to what all show, written, and reported on.

The order of steps is that of the light's way back: decode, dark frame, flat field, near lamp, exposure, merge, align
and cut. One light is in memory at a time, while the next photographs are decoded. Photographs of a camera that stood
still are written at once where nothing is estimated, unless they are pairs under polarisers; others wait
(`engine.capture.waiting`) until all motions and the rig are known, and are then corrected and warped in bands of rows
into `radiance.npy`, each while the one before is written. Every number is independent of the height of the bands.

Of a camera that stood still the codes of the photographs are written as they are read, in place of radiance, as far as
each pixel is corrected by itself: what is found of the rig goes into the record, and is applied whenever they are read
(`engine.capture.coded_pixels`). Where they turn out to be moved, or to show room light, radiance is made of them.

Of pairs the crossed photograph is read after the parallel one. What brings both together is found in small copies of
all (`engine.capture.calibration.polarisation`), and the parts are taken apart as they are written: the stack shows the
sample without polarisers, and `diffuse.npy` its diffuse part.

Radiance 1 is the white level of the reference exposure (`engine.capture.photograph.exposures`).
Cost: without alignment that of decoding the photographs on two cores; ten of 24 megapixels need 1.8 GiB, decoders
included. What is estimated adds some 5 s for 64 photographs, and for 24 megapixels 0.4 s a photograph. A light that is
written gives its scratch files back, so that needs the disk space of the result and of one light more.
"""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

import engine
from engine.capture import import_codes
from engine.capture.ahead import AheadLight, Begun, take_begun
from engine.capture.assumptions import compare_azimuths
from engine.capture.calibration.correction import Correction, room_light, room_share
from engine.capture.calibration.estimate import Estimate, Term, describe_undecided, estimate, levels, sample_texels
from engine.capture.calibration.light_list import ListCheck, check_list
from engine.capture.calibration.motion import camera_motion
from engine.capture.calibration.polarisation import PairTexels, separate, texel_grid
from engine.capture.calibration.rig import TERMS, Rig, lamp_vectors
from engine.capture.calibration.separation import gain_text
from engine.capture.calibration.transfer import check_transfer
from engine.capture.coded_pixels import Curve, Decoding
from engine.capture.decoded import Kept, find_kept
from engine.capture.detail import about_detail
from engine.capture.doubts import check_angles, without_empty, without_unreadable
from engine.capture.empty import empty
from engine.capture.file_facts import decide_files
from engine.capture.gamut import about_gamut, gamut_record, measure_gamut
from engine.capture.import_plan import ImportSettings, Plan, about_camera_scale
from engine.capture.import_plan import plan as plan_import
from engine.capture.import_record import (
    about_lights,
    contradictions,
    profiles,
    qualities,
    refuse_different_sizes,
    refuse_equal_images,
)
from engine.capture.lights.file_names import printable
from engine.capture.lights.list_forms import LISTED, name_order
from engine.capture.lights.sources import Sources, name_members
from engine.capture.mask import Mask, pack
from engine.capture.mask_source import ALPHA, read_mask
from engine.capture.noted import Noted, note, reduce_luminance, small
from engine.capture.object_outline import ObjectOutline
from engine.capture.output import BAND_PIXELS, RECORD_BYTES, CodeForm, CorrectRows, Output, Written, find_form
from engine.capture.output_region import View, view_of
from engine.capture.photograph.bayer import Mosaic
from engine.capture.photograph.decode import Photograph, ReadAhead, Unreadable
from engine.capture.photograph.exposures import Exposure
from engine.capture.photograph.radiometry import ExposureMerge
from engine.capture.registration.align import align
from engine.capture.registration.control_points import choose_marked_kind, with_control_points
from engine.capture.registration.pair_motion import Alignment
from engine.capture.registration.polarised_shift import decide_shifts, measure_shift
from engine.capture.registration.texture import Grey, reduction
from engine.capture.registration.warp import Region, move_points, sample_points
from engine.capture.report import (
    grain,
    grid_step,
    leave_one_out,
    noise_beside_grain,
    report,
)
from engine.capture.scale import magnification_of, scale_text
from engine.capture.stack import CODES, DIFFUSE, RADIANCE, RECORD, ROOM, SATURATED, ImageStack, kinds_of, open_stack
from engine.capture.stack_record import CodesRecord, StackRecord, find_version, write_record
from engine.capture.waiting import PAIR_BYTES, PIXEL_BYTES, CalibrateRows, CodedPixels, Pixels, WaitingLight
from engine.core.colour import to_display8
from engine.core.directions import surface_direction
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import number, percent
from engine.core.health import Finding, Health, Verdict
from engine.core.median import find_median
from engine.core.steps import Step, Steps, part
from engine.images.codes import Coded
from engine.images.credits import join_credits
from engine.images.decode import refuse_larger
from engine.storage.atomic import atomic_folder, discard, require_space, write_bytes
from engine.storage.records import HealthRecord
from engine.storage.scratch import array_in, find_results_folder, release, scratch_place

__all__ = ["ImportSettings", "ThumbnailReady", "import_stack", "printable"]

#: Small photographs and shares of clipped samples.
_Small = tuple[list[NDArray[np.float32]], list[NDArray[np.float32]]]


@dataclass(frozen=True, eq=False)
class ThumbnailReady:
    """A photograph has been read: uint8 sRGB `thumbnail` (h, w, 3), its light's `elevation` in radians."""

    path: Path
    elevation: float
    thumbnail: NDArray[np.uint8]


@dataclass(eq=False)
class _Read:
    """Lights of which all photographs have been read: pixels in files, the rest in memory."""

    sizes: list[tuple[int, int]] = field(default_factory=list)
    photographs: list[tuple[Photograph, ...]] = field(default_factory=list)
    noise_and_sharpness: list[tuple[float, float]] = field(default_factory=list)
    windows: list[NDArray[np.float32]] = field(default_factory=list)
    thumbnails: list[NDArray[np.float32]] = field(default_factory=list)
    clipped: list[NDArray[np.float32]] = field(default_factory=list)
    greys: list[Grey] = field(default_factory=list)
    crossed: list[NDArray[np.float32]] = field(default_factory=list)
    crossed_clipped: list[NDArray[np.float32]] = field(default_factory=list)
    pair_shifts: list[NDArray[np.float64]] = field(default_factory=list)
    waiting: deque[WaitingLight] = field(default_factory=deque)
    scratch: Path | None = None
    output: Output | None = None
    begun: Begun | None = None
    form: CodeForm | None = None
    decodings: list[Decoding] = field(default_factory=list)
    room_crc32: int | None = None
    stored: list[Written] = field(default_factory=list)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of the photographs."""
        return self.sizes[0][1], self.sizes[0][0]


class _OtherForms(Exception):
    """Not all photographs have codes of one form, so that radiance is to be kept."""


def import_stack(
    sources: Sources, settings: ImportSettings, folder: str | os.PathLike[str], *, as_codes: bool = True
) -> Steps[ImageStack]:
    """Import `sources` into the stack folder `folder`, which is complete or absent, and open it.

    It keeps radiance unless it may keep codes of the photographs (`as_codes`), of which the same is made.
    Steps carry a `ThumbnailReady` when the photographs of a light have been read. A photograph that cannot be read or
    shows nothing is left out, and the import begins anew without it, where the settings allow that and enough remain.
    Raises InputError for photographs that cannot be read or do not fit together, Doubtful where a user may say that
    they are to be used all the same, OutputError where the folder cannot be written.
    """
    count = len(sources.photographs)
    with atomic_folder(folder, RECORD) as place, name_members(sources.unpacked):
        record: StackRecord | None = None
        while record is None:
            try:
                record = yield from _import(sources, settings, place, as_codes)
            except Unreadable as error:
                sources = without_unreadable(sources, error, count, settings.strict)
            except _OtherForms:
                as_codes = False
        for name in {CODES, ROOM, RADIANCE, SATURATED, DIFFUSE} - kinds_of(record).keys():
            discard(place / name)
        write_bytes(place / RECORD, write_record(record))
    return open_stack(folder, verify=False)


def _import(sources: Sources, settings: ImportSettings, place: Path, as_codes: bool) -> Steps[StackRecord]:
    """Write the pixels of `sources` into the folder `place`."""
    plan = yield from part(plan_import(sources, settings), 0.0, 0.1)
    plan = replace(plan, as_codes=as_codes)
    first, record = len(plan.names), None
    while record is None:
        last = 1.0 if import_codes.is_direct(plan) else 0.55
        with ExitStack() as files:
            read = yield from part(_read_all(plan, place, files), 0.1, last)
            left = decide_files(plan, read.photographs, read.thumbnails)
            if left is plan:
                _refuse_contradictions(plan, read)
                left = _without_empty(plan, read, first)
            if left is plan:
                record = yield from _align_record(plan, read, place, files, last)
        del read
        if record is None:
            left = yield from _read_frames_again(sources, settings, plan, left)
        plan = left
    return record


def _read_frames_again(sources: Sources, settings: ImportSettings, plan: Plan, left: Plan) -> Steps[Plan]:
    """`left`, made anew of `sources` where its files have another white level than those of `plan`, since frames,
    charts and patches were read by that."""
    white = left.options.get("white_code", 0)
    if white == plan.options.get("white_code", 0):
        return left
    said = left.sources.findings[len(plan.sources.findings) :]
    sources = replace(sources, findings=(*sources.findings, *said))
    again = yield from part(plan_import(sources, settings, white), 0.0, 0.1)
    again = replace(again, as_codes=plan.as_codes)
    again = replace(again, options={**again.options, **left.options, "white_balance": again.options["white_balance"]})
    return again if again.names == left.names else again.reduced(left.sources)


def _without_empty(plan: Plan, read: _Read, of_first: int) -> Plan:
    """`plan` without the photographs that show nothing; itself where all show something or are to be used.

    `of_first` is the number of lights before any was left out.
    """
    if plan.settings.use_all:
        return plan
    noise = [each for each, _ in read.noise_and_sharpness]
    found = empty(read.thumbnails, read.clipped, noise, plan.sources.elevation)
    sources = without_empty(plan.sources, found, of_first, plan.settings.strict)
    return plan if sources is plan.sources else plan.reduced(sources)


def _align_record(plan: Plan, read: _Read, place: Path, files: ExitStack, started: float) -> Steps[StackRecord]:
    """Align and write what has been read, unless that was done while it was, and describe it."""
    about_angles = check_angles(plan.sources, read.thumbnails, plan.settings.trust_angles)
    alignment = _find_unmoved(len(plan.names))
    if not import_codes.is_direct(plan):
        alignment = yield from part(_align(plan, read), started, 0.7)
        if "lights" in plan.calibrated:
            plan = _check(plan, read, alignment)
        if "motion" in plan.calibrated:
            plan, alignment = yield from part(_followed(plan, read, alignment), 0.7, 0.75)
        small = _small_aligned(read, alignment)
        plan = _check_transfer(plan, read, small)
        found = _estimate(plan, small)
        plan = _with_estimate(plan, found)
        plan = _with_separation(plan, read, alignment, found)
        correction = yield from part(_correct(plan, read, alignment, small, found), 0.75, 0.8)
        yield from part(_write_aligned(plan, read, alignment, correction, place, files), 0.8, 1.0)
    assert read.output is not None
    plan = replace(plan, sources=replace(plan.sources, findings=(*plan.sources.findings, *about_angles)))
    return _record(plan, read, alignment, read.output)


def _record(plan: Plan, read: _Read, alignment: Alignment, output: Output) -> StackRecord:
    region, sources, names = output.view.region, plan.sources, plan.names
    credits = join_credits(one.credits for light in read.photographs for one in light)
    scale = None
    if plan.size_of_pixel is not None:
        larger = magnification_of(output.view.matrix, region.width, region.height)
        scale = plan.size_of_pixel.as_json(larger)
        said = Finding(Verdict.NOTE, f"Scale: {scale_text(scale, region.width, region.height)}")
        sources = replace(sources, findings=(*sources.findings, said))
    else:
        sources = replace(sources, findings=(*sources.findings, *about_camera_scale(read.photographs[0][0])))
    pixels = region.width * region.height
    mean_radiance = np.array([one.tally.mean_radiance(pixels) for one in output.written])
    grid = np.stack([np.concatenate(one.tally.grid) for one in output.written])
    errors = leave_one_out(grid, mean_radiance)
    mask = _read_mask(plan, read.shape, alignment.reference, output.view)
    step = grid_step(region.height, region.width)
    shown = grid.reshape(len(grid), -1, 3) if mask is None else grid[:, mask[::step, ::step]]
    crc32, codes = output.crc32, _codes_record(read, output)
    space, gamut = measure_gamut(shown, plan.settings.working_space)
    quality = qualities([one.tally for one in output.written], pixels, read.noise_and_sharpness, alignment, errors)
    azimuths = compare_azimuths(grid, mean_radiance, sources.azimuth)
    findings = [*sources.findings, *plan.scale.findings, *contradictions(read.photographs)]
    findings += [*([azimuths.finding()] if azimuths else []), *about_gamut(space, gamut)]
    findings += [] if alignment.aligned.any() else about_detail(read.windows)
    health = Health(findings=(*findings, *alignment.findings)).merge(
        report(names, mean_radiance, quality, sources.azimuth)
    )
    return StackRecord(
        lightarc_stack=find_version(codes),
        height_px=region.height,
        width_px=region.width,
        sources=names,
        elevations_deg=_degrees(sources.elevation),
        azimuths_deg=None if sources.azimuth is None else _degrees(sources.azimuth),
        angle_source=sources.angle_source,  # type: ignore[arg-type]
        mean_radiance=[float(mean) for mean in mean_radiance],
        radiance_crc32=crc32.get(RADIANCE),
        saturated_crc32=crc32.get(SATURATED),
        diffuse_crc32=crc32.get(DIFFUSE),
        codes=codes,
        quality=quality,
        provenance={
            "software": f"lightarc {engine.__version__}",
            **gamut_record(space, gamut),
            "profiles": profiles(read.photographs),
            **({"credits": credits} if credits else {}),
            "cameras": sorted({one.camera for light in read.photographs for one in light if one.camera}),
            **plan.as_json(),
            "aligned_to": names[alignment.reference] if alignment.aligned.any() else None,
            **output.view.as_json(),
            "scale": scale,
            "mask": None if mask is None else pack(mask),
            "photographs": about_lights(
                read.photographs,
                alignment,
                sources.unpacked.members if sources.unpacked else {},
                set(sources.crossed.values()),
            ),
        },
        health=HealthRecord.of(health),
    )


def _codes_record(read: _Read, output: Output) -> CodesRecord | None:
    if output.form is None:
        return None
    checksums = [each.crc32[CODES] for each in output.written]
    try:
        return CodesRecord.describe(output.form, output.window, read.decodings, checksums, read.room_crc32)
    except ValidationError:  # numbers beyond those of a record, or too many curves
        raise _OtherForms from None


def _read_mask(plan: Plan, size: tuple[int, int], reference: int, view: View) -> Mask | None:
    """The mask that the settings ask for, in photographs of `size`, as `view` shows it; None for none."""
    chosen = plan.settings.mask
    if chosen is None:
        return None
    if isinstance(chosen, ObjectOutline):
        return read_mask(chosen, False, size, view)
    path = plan.sources.photographs[reference] if chosen == ALPHA else Path(chosen)
    return read_mask(path, chosen == ALPHA, size, view)


def _check_mask(plan: Plan, read: _Read) -> None:
    """Refuse a mask that does not fit the photographs when one of them has been read, not when all are written."""
    height, width = read.shape
    _read_mask(plan, read.shape, plan.reference or 0, View(Region(0, 0, width, height), np.eye(3)))


def _degrees(angles: NDArray[np.float64]) -> list[float]:
    """Without the last digits, which radians cannot keep: 30, not 29.999999999999996."""
    return [round(float(angle), 9) for angle in np.degrees(angles)]


def _read_all(plan: Plan, place: Path, files: ExitStack) -> Steps[_Read]:
    """Read, calibrate and merge all lights; those of a still camera are written at once."""
    begun = take_begun(plan.settings, place) if import_codes.writes_at_once(plan) else None
    read, lights = _Read(begun=begun), plan.sources.exposures
    known, still = _find_known(plan, begun), plan.still and "motion" not in plan.calibrated
    unknown = [path for path in plan.files if path not in known]
    keep_codes = import_codes.waits_as_codes(plan) or import_codes.writes_codes(plan)
    with closing(ReadAhead(unknown, **plan.options, keep_codes=keep_codes)) as ahead:
        for index, light in enumerate(lights):
            start, stop = index / len(lights), (index + 1) / len(lights)
            if (kept := known.get(light[0].path)) is not None:
                yield from part(_take_known(plan, index, kept, read, place, files, still=still), start, stop)
                continue
            photograph = yield from part(_light(plan, index, light, ahead, read), start, (start + stop) / 2)
            if photograph is not None:
                refuse_larger(light[0].path, photograph.radiance)  # as calibration and exposures have scaled it
                crossed = yield from part(_read_crossed(plan, index, photograph, ahead, read), (start + stop) / 2, stop)
                if index == 0:
                    _check_mask(plan, read)
                _add_noted(read, note(photograph.radiance, photograph.saturated, with_grey=not still))
                yield from part(_keep(plan, read, photograph, crossed, place, files), (start + stop) / 2, stop)
                del photograph, crossed
                yield Step(stop, *_say_ready(plan, index, read))
    grains = [grain(window) for window in read.windows]
    sizes = {len(each) for each in grains}
    comparable = len(sizes) == 1 and 0 not in sizes and len(grains) > 1
    beside_grain = noise_beside_grain(grains) if comparable else [math.inf] * len(grains)
    read.noise_and_sharpness = [
        (min(noise, own), sharpness)
        for (noise, sharpness), own in zip(read.noise_and_sharpness, beside_grain, strict=True)
    ]
    return read


def _say_ready(plan: Plan, index: int, read: _Read) -> tuple[str, ThumbnailReady]:
    path, elevation = plan.sources.photographs[index], float(plan.sources.elevation[index])
    note = f"Read {index + 1} of {len(plan.sources.photographs)}"
    return note, ThumbnailReady(path, elevation, to_display8(read.thumbnails[-1]))


def _find_known(plan: Plan, begun: Begun | None) -> dict[Path, tuple[Kept, AheadLight | None]]:
    """Photographs that have been decoded before, each of which is a light of its own and stays as it is, or lies at its
    place in the files that were `begun`."""
    if plan.has_pairs or plan.chart is not None:
        return {}
    found: dict[Path, tuple[Kept, AheadLight | None]] = {}
    for index, light in enumerate(plan.sources.exposures):
        path = light[0].path
        kept = find_kept(path, plan.options) if len(light) == 1 else None
        if kept is None or kept.pixels is None:
            continue
        factor = import_codes.find_factor(plan, index, path)
        numbers = plan.calibration.numbers(kept.photograph, *import_codes.find_angles(plan, index), factor)
        form = find_form(kept.coded) if kept.coded is not None and import_codes.writes_codes(plan) else None
        is_fit = begun is not None and begun.form == form and (form is not None or import_codes.is_direct(plan))
        there = begun.find(index, kept, numbers) if begun is not None and is_fit else None
        if there is not None or plan.calibration.leaves(kept.photograph, factor):
            found[path] = kept, there
    return found


def _take_known(
    plan: Plan,
    index: int,
    known: tuple[Kept, AheadLight | None],
    read: _Read,
    place: Path,
    files: ExitStack,
    *,
    still: bool,
) -> Steps[None]:
    """Take a light whose photograph has been decoded before, as `_light`, `_add_noted` and `_keep` do of others."""
    (light,), (kept, there) = plan.sources.exposures[index], known
    read.sizes.append((kept.width, kept.height))
    read.photographs.append((_without_pixels(kept.photograph, light.exposure_s),))
    if read.sizes[-1] != read.sizes[0]:
        return
    if index == 0:
        _check_mask(plan, read)
    noted = kept.noted if there is None else there.noted
    _add_noted(read, replace(noted, grey=None) if still else noted)
    coded = kept.coded
    _note_form(plan, read, coded)
    if there is not None and read.form is None:
        _direct_output(plan, read, place, files).adopt(there.written)
    elif coded is not None and read.form is not None and import_codes.writes_at_once(plan):
        yield from _keep_codes(plan, read, coded, place, files, written=None if there is None else there.written)
    else:
        assert kept.pixels is not None
        pixels: Pixels | CodedPixels = CodedPixels(coded, _calibration_of(plan, read)) if coded else kept.pixels  # type: ignore[assignment]
        waiting = WaitingLight(pixels, stays=True)
        if import_codes.is_direct(plan):
            yield from _direct_output(plan, read, place, files).add(waiting, np.eye(3))
        else:
            read.waiting.append(waiting)
    yield Step(1.0, *_say_ready(plan, index, read))


def _note_form(plan: Plan, read: _Read, coded: Coded | Mosaic | None) -> None:
    """Note what makes radiance of the codes of the light that has been read last, if these are what is written.

    Raises _OtherForms where codes have another form than those of the first light.
    """
    form = find_form(coded) if coded is not None and import_codes.writes_codes(plan) else None
    index = len(read.photographs) - 1
    read.form = form if index == 0 else read.form
    if form != read.form:
        raise _OtherForms
    if coded is None or form is None:
        return
    (photograph,) = read.photographs[-1]
    read.decodings.append(import_codes.describe_decoding(plan, index, photograph, coded, read.decodings))


def _keep_codes(
    plan: Plan,
    read: _Read,
    coded: Coded | Mosaic,
    place: Path,
    files: ExitStack,
    *,
    written: Written | None = None,
    photograph: Photograph | None = None,
) -> Steps[None]:
    """Write the codes of the light that has been read last, unless they lie at their place, as is then `written`; they
    wait there where something is to be estimated. `photograph` has its radiance where that is there."""
    index = len(read.photographs) - 1
    output = _direct_output(plan, read, place, files)
    if written is None:
        take = None
        if import_codes.is_direct(plan) and photograph is not None:
            take = output.cut(Pixels(photograph.radiance, photograph.saturated))
        elif import_codes.is_direct(plan):
            take = output.decode(coded, read.decodings[index])
        written = yield from output.write_codes(index, coded, take)
    if import_codes.is_direct(plan):
        output.adopt(written)
        return
    read.stored.append(written)
    curve, there = read.decodings[index].curve, output.read_codes(index)
    if isinstance(coded, Coded) and isinstance(curve, Curve):
        coded = replace(coded, codes=there, tables=curve.tables, matrix=curve.matrix)
    else:
        coded = replace(coded, codes=there)
    read.waiting.append(WaitingLight(CodedPixels(coded, _calibration_of(plan, read)), stays=True))


def _refuse_contradictions(plan: Plan, read: _Read) -> None:
    refuse_different_sizes(plan.files, read.sizes)
    refuse_equal_images(plan.sources.photographs, read.thumbnails)
    if read.crossed and all(np.array_equal(*pair) for pair in zip(read.thumbnails, read.crossed, strict=True)):
        problem = "holds pairs under polarisers of which both photographs are the same image"
        raise InputError(plan.sources.photographs[0].parent, problem, "Give the crossed photographs")


def _light(
    plan: Plan, index: int, light: Sequence[Exposure], ahead: ReadAhead, read: _Read
) -> Steps[Photograph | None]:
    """The photograph of a light, merged from its exposures; None where one has another size than the first of all."""
    sources = plan.sources
    angles = import_codes.find_angles(plan, index)
    merge, originals = ExposureMerge(), []
    photograph: Photograph | None = None
    for place, one in enumerate(light):
        note = f"Reading {index + 1} of {len(sources.exposures)}"
        del photograph
        photograph = yield from ahead.next_photograph(place / len(light), note)
        read.sizes.append((photograph.saturated.shape[1], photograph.saturated.shape[0]))
        originals.append(_without_pixels(photograph, one.exposure_s))
        if read.sizes[-1] != read.sizes[0]:
            read.photographs.append(tuple(originals))
            return None
        factor = import_codes.find_factor(plan, index, one.path) if len(light) == 1 else 1.0
        photograph = plan.calibration.applied(photograph, *angles, factor)
        if plan.chart is not None:
            photograph = replace(photograph, radiance=plan.chart[0].apply(photograph.radiance))
        if len(light) > 1:
            merge.add(photograph.radiance, photograph.saturated, plan.scale.relative[one.path])
    read.photographs.append(tuple(originals))
    if len(light) == 1 or photograph is None:
        return photograph
    assert plan.scale.reference is not None
    merged = merge.merge()
    merged.radiance[...] *= np.float32(plan.scale.reference / plan.gains[index])
    return replace(photograph, radiance=merged.radiance, saturated=merged.saturated, coded=None)


def _read_crossed(
    plan: Plan, index: int, photograph: Photograph, ahead: ReadAhead, read: _Read
) -> Steps[Photograph | None]:
    """The photograph under crossed polarisers that belongs to `photograph`, calibrated alike; None without one."""
    path = plan.sources.crossed.get(plan.sources.photographs[index])
    if path is None:
        return None
    crossed = yield from ahead.next_photograph(0.0, f"Reading {index + 1} of {len(plan.names)}, crossed")
    read.sizes.append((crossed.saturated.shape[1], crossed.saturated.shape[0]))
    read.photographs[-1] = (*read.photographs[-1], _without_pixels(crossed, None))
    if read.sizes[-1] != read.sizes[0]:
        return None
    crossed = plan.calibration.applied(
        crossed, *import_codes.find_angles(plan, index), import_codes.find_factor(plan, index, path)
    )
    if plan.chart is not None:
        crossed = replace(crossed, radiance=plan.chart[0].apply(crossed.radiance))
    refuse_larger(path, crossed.radiance)
    read.crossed.append(small(crossed.radiance))
    read.crossed_clipped.append(small(crossed.saturated))
    if plan.settings.motion != "none" or "motion" in plan.calibrated:
        read.pair_shifts.append(measure_shift(*(reduce_luminance(each.radiance) for each in (photograph, crossed))))
    return crossed


def _without_pixels(photograph: Photograph, exposure_s: float | None) -> Photograph:
    nothing = np.empty((0, 0, 3), np.float32)
    known = exposure_s if exposure_s is not None else photograph.exposure_s
    return replace(photograph, radiance=nothing, saturated=nothing[..., 0] > 0, exposure_s=known, coded=None)


def _add_noted(read: _Read, noted: Noted) -> None:
    """Keep the small things."""
    read.noise_and_sharpness.append(noted.noise_and_sharpness)
    read.windows.append(noted.window)
    read.thumbnails.append(noted.thumbnail)
    read.clipped.append(noted.clipped)
    if noted.grey is not None:
        read.greys.append(noted.grey)


def _keep(
    plan: Plan, read: _Read, photograph: Photograph, crossed: Photograph | None, place: Path, files: ExitStack
) -> Steps[None]:
    """Write the pixels: of a still camera to the stack, else where they wait for the alignment."""
    count = len(plan.names)
    _note_form(plan, read, photograph.coded)
    if photograph.coded is not None and read.form is not None and import_codes.writes_at_once(plan):
        yield from _keep_codes(plan, read, photograph.coded, place, files, photograph=photograph)
        return
    if import_codes.is_direct(plan):
        light = WaitingLight(Pixels(photograph.radiance, photograph.saturated))
        yield from _direct_output(plan, read, place, files).add(light, np.eye(3))
        return
    if plan.has_pairs and crossed is None:
        return  # of another size, which is refused when all are read
    if isinstance(photograph.coded, Mosaic) and read.form is None and find_results_folder() is not None:
        photograph = replace(photograph, coded=None)  # decoders have made the pixels, which lie on the disk
    if photograph.coded is None:
        clipped = photograph.saturated if crossed is None else photograph.saturated | crossed.saturated
        copied: list[NDArray[Any]] = [photograph.radiance, clipped, *([] if crossed is None else [crossed.radiance])]
    else:
        assert isinstance(photograph.coded.codes, np.ndarray)
        copied = [photograph.coded.codes]
    light_bytes = sum(each.nbytes for each in copied)
    if read.scratch is None and all(light.stays for light in read.waiting):
        stack_bytes = count * math.prod(read.shape) * (PAIR_BYTES if plan.has_pairs else PIXEL_BYTES)
        require_space(place, stack_bytes + light_bytes + RECORD_BYTES)
        read.scratch = scratch_place(count * light_bytes, place.parent)
    arrays = [array_in(read.scratch, each.shape, each.dtype) for each in copied]
    rows = max(1, BAND_PIXELS // read.shape[1])
    for first in range(0, read.shape[0], rows):
        band = np.s_[first : first + rows]
        for scratch, pixels in zip(arrays, copied, strict=True):
            scratch[band] = pixels[band]
            release(scratch)
    if photograph.coded is None:
        radiance, saturated, *others = arrays
        second = Pixels(others[0], saturated) if others else None
        read.waiting.append(WaitingLight(Pixels(radiance, saturated), second))
    else:
        coded = replace(photograph.coded, codes=arrays[0])
        if isinstance(coded, Coded):  # what is small would keep all the memory alive in which the decoder answered
            coded = replace(
                coded, tables=coded.tables.copy(), matrix=None if coded.matrix is None else coded.matrix.copy()
            )
        read.waiting.append(WaitingLight(CodedPixels(coded, _calibration_of(plan, read))))


def _calibration_of(plan: Plan, read: _Read) -> CalibrateRows:
    """The calibration of rows of the photograph of the light that has been read last."""
    (photograph,) = read.photographs[-1]
    return import_codes.find_calibration(plan, len(read.photographs) - 1, photograph, read.shape[0])


def _align(plan: Plan, read: _Read) -> Steps[Alignment]:
    alignment = _find_unmoved(len(plan.names), plan.reference or 0)
    if plan.settings.motion != "none":
        factor = reduction(*read.shape)
        alignment = yield from align(read.greys, plan.names, plan.settings.motion, factor, plan.reference)
    return _control_points(plan, alignment)


def _check(plan: Plan, read: _Read, alignment: Alignment) -> Plan:
    """The plan with a warning where the list of lights fits clearly better in another form; nothing else is then
    estimated, since that would be of a wrong list."""
    order = name_order(plan.sources)
    images, clipped = _small_aligned(read, alignment)
    found = check_list([images[at] for at in order], [clipped[at] for at in order], _directions(plan)[order])
    said = [Finding(Verdict.WARNING, _about_list(found))] if found.form != LISTED else []
    said += [Finding(Verdict.NOTE, found.doubt)] if found.doubt else []
    sources = replace(plan.sources, findings=(*plan.sources.findings, *said))
    return replace(plan, sources=sources, suggested_form=found.form)


def _about_list(found: ListCheck) -> str:
    text = (
        f"The list of lights does not seem to belong to the photographs: it fits clearly better {found.form} (residual "
        f"{percent(found.residual[0])} → {percent(found.residual[1])} of the brightness, slopes that belong to no "
        f"surface {percent(found.no_surface[0])} → {percent(found.no_surface[1])}). Nothing was changed or calibrated: "
        f"import again with --lights-form {found.form}, or correct the list"
    )
    if found.form.startswith("mirrored"):
        other = "mirrored-x" if found.form == "mirrored-y" else "mirrored-y"
        text += f". If hills then look like valleys, it is {other}"
    return text


def _check_transfer(plan: Plan, read: _Read, small: _Small) -> Plan:
    """The plan with a warning where the photographs fit clearly better when decoded by the other curve; no rig is then
    estimated unless a user has stated the curve, since that would be of wrong radiance."""
    files = [photograph for light in read.photographs for photograph in light]
    transfer = files[0].transfer
    is_code = all(
        each.largest_code and each.container != "RAW" and each.transfer == transfer and not each.profile
        for each in files
    )
    if transfer == "profile" or not is_code or not plan.shows_codes or not set(plan.calibrated) & set(TERMS):
        return plan
    found = check_transfer(sample_texels(*small), _directions(plan), transfer)
    if found.transfer == transfer or found.held_out is None:
        return plan
    names = {"srgb": "coded as sRGB", "linear": "linear"}
    before, after = (number(each) for each in found.held_out)
    text = (
        f"The samples of the photographs seem to be {names[found.transfer]}, but were read as {names[transfer]}: error "
        f"on photographs held out {before} → {after} levels"
    )
    if plan.options["transfer"] == "auto":
        text += (
            f". No rig was calibrated: import again with --transfer {found.transfer}, or {transfer} if that is right"
        )
    sources = replace(plan.sources, findings=(*plan.sources.findings, Finding(Verdict.WARNING, text)))
    return replace(plan, sources=sources, suggested_transfer=found.transfer)


def _followed(plan: Plan, read: _Read, alignment: Alignment) -> Steps[tuple[Plan, Alignment]]:
    """The plan with what was found about the motion of the camera, and the alignment that follows it."""
    factor, reference = reduction(*read.shape), alignment.reference
    found = yield from camera_motion(read.greys, _directions(plan))
    if plan.reference is None and found.moved:
        reference = int(np.argmin(found.residual_px))  # its error is in all others
    brightness = find_median(read.greys)
    shifts = factor * (found.shifts - found.shifts[reference])
    before, after = levels(found.before, brightness), levels(found.after, brightness)
    held = f"held-out error {number(before)} → {number(after)} levels"
    if found.moved:
        text = (
            f"The camera moved by up to {number(np.hypot(*shifts.T).max())} px: photographs were shifted back, {held}"
        )
    else:
        text = f"The photographs do not show that the camera moved: they stay as they are ({held})"
    sigma = factor * float(np.median(found.residual_px)) if found.moved else 0.0
    term = Term("motion", found.moved, text, before, after, 0.0, sigma)
    plan = replace(plan, terms=(*plan.terms, term))
    if not found.moved:
        return plan, alignment
    matrix = np.tile(np.eye(3), (len(shifts), 1, 1))
    matrix[:, :2, 2] = shifts
    residual = factor * np.hypot(found.residual_px, found.residual_px[reference])
    residual[reference] = 0.0
    return plan, Alignment(matrix, residual, np.ones(len(shifts), bool), np.ones(len(shifts)), reference)


def _directions(plan: Plan) -> NDArray[np.float64]:
    """(N, 3) of the lamps; on the right where the azimuth of their arc is not known."""
    azimuth = plan.sources.azimuth if plan.sources.azimuth is not None else np.zeros(len(plan.names))
    return surface_direction(0.5 * np.pi - plan.sources.elevation, azimuth)


def _with_separation(plan: Plan, read: _Read, alignment: Alignment, rig: Estimate | None) -> Plan:
    """The plan with what takes the parts of pairs apart; InputError where the photographs do not tell it."""
    if not plan.has_pairs:
        return plan
    plan = replace(
        plan, pair_shift=decide_shifts(read.pair_shifts, reduction(*read.shape)) if read.pair_shifts else None
    )
    try:
        found = separate(_pair_texels(plan, read, alignment, rig), plan.settings.pair_gain)
    except UsageError as error:
        problem = f"holds pairs under polarisers whose parts cannot be taken apart: {error}"
        remedy = (
            "State how bright a matte white patch is in a crossed photograph over the parallel one with --pair-gain, "
            "or import the photographs as they are with --pair none"
        )
        raise InputError(plan.sources.photographs[0].parent, problem, remedy) from None
    shift = plan.pair_shift.text() if plan.pair_shift is not None else ""
    said = [Finding(Verdict.NOTE, text) for text in (gain_text(found.as_json()), shift) if text]
    return replace(plan, separation=found, sources=replace(plan.sources, findings=(*plan.sources.findings, *said)))


def _pair_texels(plan: Plan, read: _Read, alignment: Alignment, rig: Estimate | None) -> PairTexels:
    """Texels of the pairs that wait, in whole photographs."""
    height, width = read.shape
    rows, columns, block = texel_grid(height, width)
    crossed = plan.crossed_matrices(alignment.matrix)
    beside = alignment.matrix if crossed is None else crossed
    moved = crossed is not None or bool(alignment.aligned.any())
    values: tuple[list[NDArray[np.float32]], list[NDArray[np.float32]]] = ([], [])
    usable = []
    for index, light in enumerate(read.waiting):
        assert isinstance(light.pixels, Pixels)
        assert light.crossed is not None
        radiance, saturated, other = light.pixels.radiance, light.pixels.saturated, light.crossed.radiance
        for side, (pixels, matrix) in enumerate(((radiance, alignment.matrix[index]), (other, beside[index]))):
            values[side].append(sample_points(pixels, *move_points(columns, rows, matrix)))
            release(pixels)
        if not moved:
            usable.append(~np.asarray(saturated[rows, columns]))
            release(saturated)
            continue
        x, y = move_points(columns, rows, alignment.matrix[index])
        inside = (x >= 1.0) & (y >= 1.0) & (x < width - 2.0) & (y < height - 2.0)
        near = [np.clip(each.astype(np.int64), 1, size - 3) for each, size in ((y, height), (x, width))]
        clipped = np.any([saturated[near[0] + i, near[1] + j] for i in range(-1, 3) for j in range(-1, 3)], axis=0)
        usable.append(inside & ~clipped)
        release(saturated)
    both = [np.stack(each, axis=1).astype(np.float64) for each in values]
    room = None
    if rig is not None and "ambient" in rig.accepted:
        share = room_share(_small_aligned(read, alignment)[0], _directions(plan), rig.rig, rig.kind)
        at = (columns + 0.5) * share.shape[1] / width - 0.5, (rows + 0.5) * share.shape[0] / height - 0.5
        room = sample_points(share, *at) * both[1].mean(axis=1)
    lights = _lights(plan, rows, columns, read.shape)
    return PairTexels(both[0], both[1], np.stack(usable, axis=1), lights, block, room, moved)


def _lights(
    plan: Plan, rows: NDArray[np.int64], columns: NDArray[np.int64], shape: tuple[int, int]
) -> NDArray[np.float64]:
    """(N, T or 1, 3) irradiance over π of texels (T,) of photographs of `shape` by the lamps, as far as nothing of it
    has been taken off yet."""
    directions, (height, width) = _directions(plan), shape
    found = {term.name for term in plan.terms if term.accepted} & set(plan.calibrated)
    gains = plan.gains if "gains" in found else np.ones(len(directions))
    nearness = plan.nearness
    if not nearness:
        return np.asarray((gains[:, None] * directions)[:, None])
    positions = np.stack([(columns + 0.5) / width - 0.5, (0.5 * height - 0.5 - rows) / width], axis=1)
    vectors = lamp_vectors(directions, positions, nearness).swapaxes(0, 1)
    if "distance" not in found:  # photographs were multiplied with the cube of the distance
        vectors = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True) ** 1.5
    return np.asarray(gains[:, None, None] * vectors)


def _estimate(plan: Plan, small: _Small) -> Estimate | None:
    """What the small photographs tell of their rig; None where nothing is to be estimated."""
    terms = [term for term in plan.calibrated if term in TERMS]
    if not terms:
        return None
    directions = _directions(plan)
    start = replace(Rig.plain(len(directions)), nearness=plan.nearness)
    sample = sample_texels(*small)
    if start.nearness:  # the fall-off of stated lamps has been taken off the photographs
        vectors = lamp_vectors(directions, sample.positions, start.nearness)
        sample = replace(sample, values=sample.values * np.linalg.norm(vectors, axis=-1) ** 1.5)
    return estimate(sample, directions, terms, start)


def _with_estimate(plan: Plan, found: Estimate | None) -> Plan:
    """The plan that holds and reports what the calibration found."""
    if found is not None:
        held_out = found.held_out if math.isfinite(found.held_out) else None
        terms = (*plan.terms, *found.terms)
        plan = replace(plan, terms=terms, held_out=held_out, undecided_deg=found.undecided_deg)
        plan = replace(plan, rival_deg=found.rival_deg)
    said = [Finding(Verdict.NOTE, term.text) for term in plan.terms]
    undecided = "" if found is None else describe_undecided(found.rival_deg)
    said += [Finding(Verdict.WARNING, undecided)] if undecided else []
    plan = replace(plan, sources=replace(plan.sources, findings=(*plan.sources.findings, *said)))
    if found is None or not found.accepted:
        return plan
    if "distance" in found.accepted:
        plan = replace(plan, calibration=replace(plan.calibration, lamp_distance=1.0 / found.rig.nearness))
    if "ambient" in found.accepted:
        plan = replace(plan, room_light=tuple(found.rig.ambient.tolist()))
    return replace(plan, gains=plan.gains * _relative_gains(found))


def _relative_gains(found: Estimate) -> NDArray[np.float64]:
    """(N,) over their median."""
    return np.exp(found.rig.log_gains - np.median(found.rig.log_gains))


def _correct(
    plan: Plan, read: _Read, alignment: Alignment, small: _Small, found: Estimate | None
) -> Steps[Correction | None]:
    """The correction of photographs for the terms that were accepted; None for none."""
    azimuth = plan.sources.azimuth
    if found is None or not found.accepted or azimuth is None:
        return None
    yield Step(0.0, "Calibrating")
    room, matrix = None, alignment.matrix if alignment.aligned.any() else None
    if "ambient" in found.accepted:
        share = room_share(small[0], _directions(plan), found.rig, found.kind)
        whole = [_radiance_rows(light) for light in read.waiting]
        room = yield from part(room_light(whole, share, read.shape, matrix), 0.3, 1.0)
    nearness = found.rig.nearness if "distance" in found.accepted else 0.0
    return Correction(_relative_gains(found), nearness, plan.sources.elevation, azimuth, room, matrix)


def _radiance_rows(light: WaitingLight) -> Callable[[int, int], NDArray[np.float32]]:
    """Function from the first row and the one after the last to the radiance in which the rig is seen: of pairs that of
    the crossed photograph, which shows no highlights."""
    pixels = light.pixels if light.crossed is None else light.crossed

    def rows(first: int, last: int) -> NDArray[np.float32]:
        found, _ = pixels.rows(first, last)
        pixels.release()
        return found

    return rows


def _small_aligned(read: _Read, alignment: Alignment) -> _Small:
    """The thumbnails and their shares of clipped samples, as the reference shows the sample; of pairs the crossed ones,
    which show no highlights."""
    images, shares = (read.crossed, read.crossed_clipped) if read.crossed else (read.thumbnails, read.clipped)
    if not alignment.aligned.any():
        return images, shares
    height, width = images[0].shape[:2]
    scale = np.diag([width / read.shape[1], height / read.shape[0], 1.0])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    found: _Small = ([], [])
    for image, clipped, matrix in zip(images, shares, alignment.matrix, strict=True):
        small = scale @ matrix @ np.linalg.inv(scale)
        found[0].append(cv2.warpPerspective(image, small, (width, height), flags=flags))
        found[1].append(cv2.warpPerspective(clipped, small, (width, height), flags=flags, borderValue=1.0))
    return found


def _write_aligned(
    plan: Plan, read: _Read, alignment: Alignment, correction: Correction | None, place: Path, files: ExitStack
) -> Steps[None]:
    is_still = all(np.array_equal(matrix, np.eye(3)) for matrix in alignment.matrix)
    if read.form is not None and is_still:
        yield from _complete_codes(plan, read, correction, place, files)
        return
    if read.output is not None:  # where the codes lie until radiance has been made of them
        left = read.output
        files.callback(left.abandon)
    read.form = None
    given_back = sum(light.size_bytes for light in list(read.waiting)[1:] if not light.stays)
    beside = plan.crossed_matrices(np.tile(np.eye(3), (len(plan.names), 1, 1)))
    both = (correction, correction)
    if correction is not None and correction.room is not None and plan.separation is not None:
        room = correction.room * (1.0 / plan.separation.gain).astype(np.float32)
        both = (replace(correction, room=room), correction)
    read.output = _output(plan, alignment, read.shape, place, files, given_back)
    for index, matrix in enumerate(alignment.matrix):
        light = read.waiting.popleft()  # which goes when it has been written
        of_light = _correct_rows(both[0], index, read.shape[0]), _correct_rows(both[1], index, read.shape[0])
        yield from read.output.add(light, matrix, of_light, None if beside is None else beside[index])


def _complete_codes(
    plan: Plan, read: _Read, correction: Correction | None, place: Path, files: ExitStack
) -> Steps[None]:
    """Write the codes that are not yet in the stack, and note the radiance that is made of them from now on."""
    output = _direct_output(plan, read, place, files)
    room = None if correction is None else correction.room
    if room is not None:
        read.room_crc32 = output.write_room(place, room)
    read.decodings = [each.add_correction(correction, index) for index, each in enumerate(read.decodings)]
    for index, (light, decoding) in enumerate(zip(read.waiting, read.decodings, strict=True)):
        if not read.stored:
            assert isinstance(light.pixels, CodedPixels)
            coded = light.pixels.coded
            output.adopt((yield from output.write_codes(index, coded, output.decode(coded, decoding, room))))
        elif correction is None and read.stored[index].tally.rows:
            output.adopt(read.stored[index])
        else:
            output.adopt((yield from output.note_codes(index, read.stored[index], decoding, room)))
    read.waiting.clear()


def _correct_rows(correction: Correction | None, index: int, height: int) -> CorrectRows | None:
    if correction is None:
        return None
    return lambda radiance, first: correction.apply(index, radiance, first, height)


def _direct_output(plan: Plan, read: _Read, place: Path, files: ExitStack) -> Output:
    """The files to which lights are written as they are read; those that were begun, if there are any."""
    if read.output is None:
        begun = read.begun if read.begun is not None and read.begun.form == read.form else None
        still = _find_unmoved(len(plan.names))
        read.output = _output(plan, still, read.shape, place, files, begun=begun, form=read.form)
    return read.output


def _output(
    plan: Plan,
    alignment: Alignment,
    size: tuple[int, int],
    place: Path,
    files: ExitStack,
    given_back: int = 0,
    begun: Begun | None = None,
    form: CodeForm | None = None,
) -> Output:
    crossed = plan.crossed_matrices(alignment.matrix)
    matrices = alignment.matrix if crossed is None else np.concatenate([alignment.matrix, crossed])
    view = view_of(plan.settings, matrices, size, plan.sources.photographs[0].parent)
    folder = None if begun is None else begun.folder
    if folder is not None:
        given_back += sum(each.stat().st_size for each in folder.iterdir())
    return Output(
        files,
        place,
        len(plan.names),
        view,
        size,
        given_back=given_back,
        separation=plan.separation,
        begun=folder,
        form=form,
    )


def _find_unmoved(count: int, reference: int = 0) -> Alignment:
    nothing = np.full(count, np.nan)
    return Alignment(np.tile(np.eye(3), (count, 1, 1)), nothing, np.zeros(count, bool), np.zeros(count), reference)


def _control_points(plan: Plan, alignment: Alignment) -> Alignment:
    marked = {plan.names.index(name): pairs for name, pairs in plan.settings.control_points.items()}
    if alignment.reference in marked:
        problem = "has control points, but is the one that the others are aligned to"
        remedy = "Say which photograph is the reference: reference in capture.toml"
        raise InputError(plan.sources.photographs[alignment.reference], problem, remedy)
    motion = choose_marked_kind(plan.settings.motion, plan.sources.azimuth)
    return with_control_points(alignment, marked, plan.names, motion) if marked else alignment
