"""From measured spectra to linear sRGB: the CIE 1931 2° observer under a named illuminant.

The table (resources/spectra/cie1931_d65.csv) holds the colour-matching functions and D65 from 380 to 780 nm at 5 nm.
Reflectance and table are both taken as linear between their wavelengths and multiplied on the wavelengths of both, so
the sparser of the two is interpolated onto the denser; the sum is the trapezoidal rule. Bands that the measurement
lacks take its first or last value, as ASTM E308 has it for truncated spectra; what lies outside 380–780 nm is not seen.
The white of the illuminant becomes the white of sRGB by the linear Bradford transform (for D65 a change of 1e-4, the
rounding of its printed chromaticity) and a last scaling by a rounding error, so that the constant spectrum 1 is
(1, 1, 1). Nothing is clipped: colours outside the gamut have negative channels.
A table of 3 kB, since colour-science (9 MB) would be installed for these 81 rows alone.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.colour import D65, SRGB_FROM_XYZ, adaptation, srgb_from_xyz
from engine.core.errors import UsageError

Illuminant = Literal["D65", "E"]
ILLUMINANTS: tuple[Illuminant, ...] = ("D65", "E")

#: Visible wavelengths in nanometres: the ends of the table.
VISIBLE_NM = (380.0, 780.0)

#: Wavelengths of which a measurement must have one: beyond them lies a thousandth of the luminance of even light.
SEEN_NM = (400.0, 700.0)

_TABLE = Path(__file__).resolve().parents[2] / "resources" / "spectra" / "cie1931_d65.csv"

#: Cone responses of the Bradford transform (Lam1985; ICC.1:2022, annex E).


@cache
def observer() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Wavelengths (81,) in nm, colour-matching functions (81, 3), and D65 (81,) relative to 100 at 560 nm."""
    table = np.loadtxt(_TABLE, delimiter=",", skiprows=4)
    return table[:, 0], table[:, 1:4], table[:, 4]


def srgb_weights(wavelengths_nm: ArrayLike, illuminant: Illuminant = "D65") -> NDArray[np.float64]:
    """Weights (L, 3) with `spectra @ weights` = linear sRGB, for spectra sampled at `wavelengths_nm` (L,).

    Raises UsageError for wavelengths that do not rise strictly, or of which none lies in `SEEN_NM`.
    """
    measured = np.asarray(wavelengths_nm, np.float64)
    if measured.ndim != 1 or not measured.size or not np.isfinite(measured).all() or (np.diff(measured) <= 0).any():
        raise UsageError("wavelengths must be a list of finite numbers in rising order")
    if not ((measured >= SEEN_NM[0]) & (measured <= SEEN_NM[1])).any():
        raise UsageError(f"no wavelength lies between {SEEN_NM[0]:g} and {SEEN_NM[1]:g} nm")
    if illuminant not in ILLUMINANTS:
        raise ValueError(f"unknown illuminant {illuminant!r}; choose from {', '.join(ILLUMINANTS)}")
    grid, functions, d65 = observer()
    power = d65 if illuminant == "D65" else np.ones_like(d65)
    visible = measured[(measured > VISIBLE_NM[0]) & (measured < VISIBLE_NM[1])]
    nodes = np.union1d(grid, visible)
    light = np.stack([np.interp(nodes, grid, column * power) for column in functions.T], axis=-1)
    step = np.gradient(nodes)
    step[[0, -1]] /= 2.0
    light *= step[:, None]
    white = light.sum(axis=0)
    rgb = light / white[1] @ adaptation(white / white[1], D65).T @ SRGB_FROM_XYZ.T
    weights = _transpose_interpolation(nodes, measured, rgb)
    balanced: NDArray[np.float64] = weights / weights.sum(axis=0)
    return balanced


def srgb_from_spectra(
    wavelengths_nm: ArrayLike, spectra: ArrayLike, illuminant: Illuminant = "D65"
) -> NDArray[np.float64]:
    """Linear sRGB (..., 3) of reflectance-like spectra (..., L) at `wavelengths_nm` (L,); 1 at all of them is white.

    Any unit stays what it is: a spectral BRDF in 1/sr gives a BRDF in 1/sr. Raises ValueError as `srgb_weights` does,
    and where the number of bands differs.
    """
    spectra = np.asarray(spectra, np.float64)
    weights = srgb_weights(wavelengths_nm, illuminant)
    if spectra.shape[-1:] != (len(weights),):
        raise ValueError(f"spectra have {spectra.shape[-1:]} bands, wavelengths {len(weights)}")
    rgb: NDArray[np.float64] = spectra @ weights
    return rgb


def srgb_from_measured_xyz(xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Linear sRGB (N, 3) of columns X, Y, Z of a file; rows with a negative number stay as they are, and invalid.

    What lies outside sRGB is a colour, and its negative channel becomes 0; it is not a measurement that failed.
    """
    invalid = (xyz < 0.0).any(axis=1, keepdims=True)
    return np.where(invalid, xyz, np.maximum(srgb_from_xyz(xyz), 0.0))


def _transpose_interpolation(
    nodes: NDArray[np.float64], measured: NDArray[np.float64], rgb: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Weights (L, 3) for values at `measured` from weights (M, 3) for their linear interpolation at `nodes`."""
    place = np.interp(nodes, measured, np.arange(len(measured)))
    left = np.minimum(place.astype(np.intp), max(len(measured) - 2, 0))
    share = (place - left)[:, None]
    weights = np.zeros((len(measured), 3))
    np.add.at(weights, left, rgb * (1.0 - share))
    np.add.at(weights, np.minimum(left + 1, len(measured) - 1), rgb * share)
    return weights
