"""A BRDF measured at scattered pairs of directions: the list itself, before anything is interpolated.

Which measurements are used is one rule for all formats: a row is dropped if a number in it is not finite, if a value
is negative or above `VALUE_LIMIT`, or if one of its directions is at or below the horizon (`HORIZON`), where a BRDF is
0 by definition. Dropped rows are counted in `invalid_samples` and shown. Of RGB whose luminance is positive a negative
channel alone counts as 0, and is shown too: it is noise, or a colour outside sRGB, as of thin films. Spectra become
linear sRGB under D65 (`engine.brdf.spectrum`); a channel is negative where the colour lies outside sRGB, and stays so
up to the display, or the luminance would be wrong: it is counted. RGB columns are taken as linear sRGB, a single column
as grey.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.spectrum import srgb_from_spectra
from engine.core.colour import XYZ_FROM_SRGB, luminance
from engine.core.directions import dot
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Health, Verdict
from engine.core.summary import Summary
from engine.storage.untrusted import AGAIN

Floats = NDArray[np.float64]

#: Directions with a smaller cosine count as grazing: in files, 90° is a rounded number.
HORIZON = 1e-6

#: Share of the measurements of a file that may be unusable, or of its directions that may be negative, before it is
#: a warning.
DOUBTFUL_SHARE = 0.01

#: The figure of health that counts measurements at or below it: a BRDF is 0 there, and they are not faults.
BELOW_HORIZON = "dropped: at or below the horizon"

#: No surface reflects more than this, in 1/sr; what is above it is damage.
VALUE_LIMIT = 1e30

_UNIT_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class BrdfSamples(Summary):
    """Measured values of a BRDF at scattered pairs of directions above the horizon.

    Parameters
    ----------
    wi, wo : (N, 3) unit directions towards light and viewer in the surface frame (normal +z), N > 0.
    value : (N, 3) linear sRGB in 1/sr without the cosine, finite; negative only where spectra are outside the gamut.
    name : what was measured, usually the stem of the file's name.
    kind : how, in a short phrase for a user.
    health : what was counted on the way.
    invalid_samples : rows of the file that were dropped.
    wavelengths_nm, spectra : (L,) and (N, L) where the file holds spectra, else None.
    """

    wi: Floats
    wo: Floats
    value: Floats
    name: str = ""
    kind: str = "samples"
    health: Health = field(default_factory=Health)
    invalid_samples: int = 0
    wavelengths_nm: Floats | None = None
    spectra: Floats | None = None

    def __post_init__(self) -> None:
        for part in ("wi", "wo", "value", "wavelengths_nm", "spectra"):
            array = getattr(self, part)
            if array is not None:
                array = np.array(array, np.float64)
                array.flags.writeable = False
                object.__setattr__(self, part, array)
        count = len(self.value)
        if not count or any(part.shape != (count, 3) for part in (self.wi, self.wo, self.value)):
            raise ValueError("wi, wo and value must have the shape (N, 3) with N > 0")
        for directions in (self.wi, self.wo):
            if not (np.abs(dot(directions, directions) - 1.0) <= _UNIT_TOLERANCE).all():
                raise ValueError("directions must be unit vectors")
            if not (directions[:, 2] > 0.0).all():
                raise ValueError("directions must be above the horizon")
        lowest = 0.0 if self.spectra is None else -VALUE_LIMIT
        if not ((self.value >= lowest) & (self.value <= VALUE_LIMIT)).all():
            raise ValueError(f"values must lie in [{lowest:g}, {VALUE_LIMIT:g}]")
        if (self.spectra is None) != (self.wavelengths_nm is None):
            raise ValueError("spectra need wavelengths, and wavelengths spectra")
        if self.spectra is not None and self.wavelengths_nm is not None:
            expected = (count, len(self.wavelengths_nm))
            if self.spectra.shape != expected or not np.isfinite(self.spectra).all():
                raise ValueError(f"spectra must be finite and of the shape {expected}")

    def part(self, kept: NDArray[np.bool_]) -> BrdfSamples:
        """The samples of this mask (N,), of which there must be some."""
        spectra = None if self.spectra is None else self.spectra[kept]
        return replace(self, wi=self.wi[kept], wo=self.wo[kept], value=self.value[kept], spectra=spectra)

    @property
    def positive_from_srgb(self) -> Floats:
        """(3, 3) matrix to a colour space in which no valid value is negative: XYZ for spectra, else sRGB itself."""
        return np.eye(3) if self.spectra is None else XYZ_FROM_SRGB

    @property
    def positive(self) -> Floats:
        """The values (N, 3) in that space; what rounding makes negative is 0."""
        return np.maximum(self.value @ self.positive_from_srgb.T, 0.0)

    @property
    def samples(self) -> int:
        """Measured directions that the file holds, with those that could not be used."""
        return len(self.value) + self.invalid_samples

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        return {"name": self.name, "kind": self.kind, "samples": len(self.value)}


def samples_from_rows(
    path: str | os.PathLike[str],
    kind: str,
    wi: Floats,
    wo: Floats,
    values: Floats,
    wavelengths_nm: Floats | None = None,
    findings: Sequence[Finding] = (),
    name: str | None = None,
    *,
    negative_is_missing: bool = False,
) -> BrdfSamples:
    """Valid samples among a file's rows, by the rule above.

    `values` are (N, 1) grey, (N, 3) linear sRGB, or (N, L) spectra at `wavelengths_nm`. Directions need not be finite
    or of unit length. `negative_is_missing` of formats in which a negative channel marks a measurement that failed.
    Raises InputError where no row is valid, or no wavelength is visible.
    """
    name = Path(path).stem if name is None else name
    finite = np.isfinite(wi).all(axis=1) & np.isfinite(wo).all(axis=1) & np.isfinite(values).all(axis=1)
    with np.errstate(invalid="ignore"):
        above = (wi[:, 2] > HORIZON) & (wo[:, 2] > HORIZON)
        negative = (values < 0.0).any(axis=1)
        clipped = np.zeros_like(negative)
        if wavelengths_nm is None and values.shape[1] == 3 and not negative_is_missing:
            clipped = negative & (luminance(values) > 0.0)
            values, negative = np.where(clipped[:, None], np.maximum(values, 0.0), values), negative & ~clipped
        usable = finite & above & ~negative & (values <= VALUE_LIMIT).all(axis=1)
    if not usable.any():
        raise InputError(path, f"has no valid measurement among its {len(values)}", AGAIN)
    wi, wo, values = wi[usable], wo[usable], values[usable]
    rgb = np.repeat(values, 3, axis=1) if values.shape[1] == 1 else values
    if wavelengths_nm is not None:
        try:
            rgb = srgb_from_spectra(wavelengths_nm, values)
        except UsageError as error:
            raise InputError(path, f"cannot be turned into a colour: {error}", AGAIN) from None
    figures = {
        "dropped: not finite": float((~finite).sum()),
        "dropped: negative": float((finite & negative).sum()),
        BELOW_HORIZON: float((finite & ~negative & ~above).sum()),
        "outside sRGB": float((rgb < 0.0).any(axis=1).sum()),
        "negative channels": float((usable & clipped).sum()),
    }
    invalid = int((~usable).sum())
    notes = list(findings)
    if invalid:
        faults = invalid - figures[BELOW_HORIZON]
        verdict = Verdict.WARNING if faults > DOUBTFUL_SHARE * len(usable) else Verdict.NOTE
        notes.append(Finding(verdict, _drop(invalid, len(usable), figures)))
    if figures["negative channels"]:
        count = figures["negative channels"]
        text = f"{count:.0f} of {len(usable)} measurements have a negative channel, which is taken as 0"
        verdict = Verdict.WARNING if count > DOUBTFUL_SHARE * len(usable) else Verdict.NOTE
        notes.append(Finding(verdict, text))
    return BrdfSamples(
        wi / np.linalg.norm(wi, axis=1, keepdims=True),
        wo / np.linalg.norm(wo, axis=1, keepdims=True),
        rgb,
        name,
        kind,
        Health(MappingProxyType({key: value for key, value in figures.items() if value}), tuple(notes)),
        invalid,
        wavelengths_nm,
        values if wavelengths_nm is not None else None,
    )


def _drop(invalid: int, total: int, figures: dict[str, float]) -> str:
    reasons = ", ".join(
        f"{count:.0f} {key.removeprefix('dropped: ')}"
        for key, count in figures.items()
        if count and key.startswith("dropped")
    )
    return f"{invalid} of {total} measurements are not used ({reasons or 'absurdly large'})"
