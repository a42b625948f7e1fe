"""Whether the samples of photographs are coded as the import took them: by the curve of sRGB, or linear.

Many programs write linear TIFF files without saying so. Read as sRGB, all that is dim is too dark, which a calibration
would take for lamps of unequal intensity. So a rig is fitted to the photographs as they were decoded, and as they are
when decoded the other way. All terms of the rig are free, so that none of them explains the difference. Both fits are
judged by their error on photographs that are held out, in levels of the code that the files hold, which both share.

Gloss makes lit texels brighter as a curve does. So texels are matte or glossy under either curve, whichever errs less.
Smooth metals may not tell; the curve in use then stays. In 400 checks of 100 generated captures, half of them of a
wrong curve, none was named wrongly, and 7 wrong ones were not named: 6 of metals, 1 of a glossy dielectric.

Cost: 0.3 s of one core for 60 photographs of matte texels and 0.8 s of glossy ones, whatever their size.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from engine.capture.calibration.estimate import FEWEST, HeldOut
from engine.capture.calibration.rig import TERMS, Array, Kind, Rig, Sample
from engine.core.colour import srgb_decode, srgb_encode
from engine.core.kernels import serial_kernels
from engine.core.one_thread import one_thread
from engine.images.raster import Transfer

#: The error under the other curve, over that under the one in use, below which the other fits clearly better, and the
#: share of blocks of the image in which it has to.
CLEAR, BLOCKS_BETTER = 0.75, 0.6

#: Texels that are fitted as each kind.
TEXELS: dict[Kind, int] = {"matte": 300, "glossy": 150}

#: Held-out error of matte texels over the brightness, and the error under the other curve over that under the one in
#: use, below and above which the one in use is right, whatever is found of glossy texels.
MATTE_FITS, CLEARLY_WORSE = 0.012, 1.3


@dataclass(frozen=True)
class TransferCheck:
    """The curve that fits: the one in use, unless the other fits clearly better.

    `held_out` are the errors on photographs held out, in 8-bit levels of the files, under the curve in use and under
    the other one; None where nothing was compared.
    """

    transfer: Transfer
    held_out: tuple[float, float] | None = None


def check_transfer(sample: Sample, directions: Array, transfer: Transfer) -> TransferCheck:
    """Compare the curves on texels of photographs that were decoded by `transfer`, of lamps in `directions` (N, 3)."""
    terms = tuple(term for term in TERMS if len(directions) >= FEWEST[term])
    if not terms or len(sample.values) < 40:
        return TransferCheck(transfer)
    other: Transfer = "linear" if transfer == "srgb" else "srgb"
    samples = {transfer: sample, other: _recode(sample, transfer)}
    with one_thread(), serial_kernels():
        matte = [_measure(samples[each], directions, terms, each, "matte") for each in (transfer, other)]
        found = [levels for levels, _ in matte]
        if matte[0][1] > MATTE_FITS or np.nanmean(found[1]) < CLEARLY_WORSE * np.nanmean(found[0]):
            for place, each in enumerate((transfer, other)):
                glossy, _ = _measure(samples[each], directions, terms, each, "glossy")
                found[place] = min(found[place], glossy, key=lambda levels: float(np.nanmean(levels)))
    own, another = found
    held_out = float(np.nanmean(own)), float(np.nanmean(another))
    known = np.isfinite(own) & np.isfinite(another)
    is_better = held_out[1] < CLEAR * held_out[0] and (another < own)[known].mean() >= BLOCKS_BETTER
    return TransferCheck(other if is_better else transfer, held_out)


def _measure(
    sample: Sample, directions: Array, terms: tuple[str, ...], transfer: Transfer, kind: Kind
) -> tuple[Array, float]:
    """Mean error of held-out photographs in each block in 8-bit levels, NaN where no texels are; and the mean of all
    over the brightness."""
    some = sample.of(np.arange(len(sample.values)) % max(1, len(sample.values) // TEXELS[kind]) == 0)
    errors = HeldOut(some, directions, Rig.plain(len(directions)), kind)(terms)
    ends = some.brightness, some.brightness * (1.0 + errors)
    low, high = (srgb_encode(each) for each in ends) if transfer == "srgb" else ends
    number = np.bincount(some.block, minlength=int(sample.block.max()) + 1)
    total = np.bincount(some.block, 255.0 * (high - low), minlength=len(number))
    return np.where(number > 0, total / np.maximum(number, 1), np.nan), float(errors.mean())


def _recode(sample: Sample, transfer: Transfer) -> Sample:
    """The texels decoded the other way; `transfer` is how they were decoded."""
    recode = srgb_encode if transfer == "srgb" else srgb_decode
    values = recode(np.maximum(sample.values, 0.0) * sample.brightness[:, None])
    mean = np.maximum(values.mean(axis=1), 1e-9)
    return replace(sample, values=values / mean[:, None], brightness=mean)
