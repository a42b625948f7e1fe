"""Colour spaces of stored samples: a curve for each channel and primaries, or a table, to linear Rec. 709.

Linear Rec. 709 (the primaries of sRGB, white D65) is the working space. Colours outside its gamut keep their negative
values and those above 1. The white of a space becomes (1, 1, 1): other whites are adapted by Bradford's matrix
(Lam1985; ICC.1:2022, annex E). Curves have the form of ICC's parametric type 4, which holds gamma, sRGB and BT.709, or
are sampled. Tables of profiles are left to Little CMS, which evaluates them in floating point.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import D65, REC_2020, SRGB_FROM_XYZ, WORKING_SPACES, adaptation, srgb_decode

Floats = NDArray[np.floating[Any]]

#: A curve is taken as sRGB or as linear where it differs from it by at most this: steps of 16-bit samples in profiles.
_SAME_CURVE = 2e-4

#: Primaries are taken as those of Rec. 709 where colours differ by at most this: profiles round them to 16 bits, and
#: several adaptations of D65 to D50 are in use.
_SAME_PRIMARIES = 1e-3

#: Pixels that Little CMS converts at once.
_BLOCK = 1 << 20

#: The relative colorimetric intent: the white of the medium is white.
_COLORIMETRIC = 1

#: XYZ of the white of ICC's connection space.
D50 = np.array([0.9642, 1.0, 0.8249])


@dataclass(frozen=True, eq=False)
class Curve:
    """Linear value of a sample, both 1 at full scale; odd-symmetric below 0.

    Attributes
    ----------
    power : g, a, b, c, d, e, f of y = (a x + b)^g + e from x = d on, and y = c x + f below.
    samples : y at equal steps of x from 0 to 1, linear in between, in place of `power`. Above 1 the curve goes on as
        the power of x that fits its end.
    """

    power: tuple[float, float, float, float, float, float, float] = (1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    samples: NDArray[np.float64] | None = None

    def linear(self, values: Floats) -> NDArray[np.float64]:
        if self is SRGB_CURVE:
            return srgb_decode(np.asarray(values, np.float64)).astype(np.float64, copy=False)
        size = np.abs(np.asarray(values, np.float64))
        return np.copysign(self._sampled(size) if self.samples is not None else self._powered(size), values)

    def _powered(self, size: NDArray[np.float64]) -> NDArray[np.float64]:
        g, a, b, c, d, e, f = self.power
        if (g, a, b, d, e) == (1.0, 1.0, 0.0, 0.0, 0.0):
            return size
        with np.errstate(all="ignore"):
            return np.where(size >= d, np.maximum(a * size + b, 0.0) ** g + e, c * size + f)

    def _sampled(self, size: NDArray[np.float64]) -> NDArray[np.float64]:
        samples = self.samples
        assert samples is not None
        inside: NDArray[np.float64] = np.interp(size, np.linspace(0.0, 1.0, len(samples)), samples)
        beyond = size > 1.0
        if beyond.any():
            last = len(samples) - 1
            start = samples[last - max(1, last // 16)]
            exponent = math.log(start / samples[last]) / math.log(1.0 - max(1, last // 16) / last) if start > 0 else 1.0
            inside[beyond] = samples[last] * size[beyond] ** exponent
        return inside

    def is_like(self, other: Curve) -> bool:
        """Return whether both give the same values but for the rounding of a profile."""
        at = np.linspace(0.0, 1.0, 257)
        return bool(np.abs(self.linear(at) - other.linear(at)).max() <= _SAME_CURVE)


def gamma(exponent: float) -> Curve:
    return Curve((exponent, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0))


LINEAR_CURVE = Curve()
SRGB_CURVE = Curve((2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045, 0.0, 0.0))
BT709_CURVE = Curve((1 / 0.45, 1 / 1.099, 0.099 / 1.099, 1 / 4.5, 0.081, 0.0, 0.0))


@dataclass(frozen=True, eq=False)
class ColourSpace:
    """Meaning of the samples of an image.

    Attributes
    ----------
    name : in words, of a profile its description.
    curves : one for all channels, or those of red, green and blue.
    matrix : (3, 3) from linear colours of the space to linear Rec. 709; None for those primaries.
    table : an ICC profile with a table, in place of curves and matrix; else empty.
    is_grey : True for a space without colours.
    """

    name: str
    curves: tuple[Curve, ...] = (SRGB_CURVE,)
    matrix: NDArray[np.float64] | None = None
    table: bytes = b""
    is_grey: bool = False

    @property
    def transfer(self) -> str:
        """'srgb' or 'linear' where all curves are that, else 'profile'."""
        for name, curve in (("srgb", SRGB_CURVE), ("linear", LINEAR_CURVE)):
            if not self.table and all(each.is_like(curve) for each in self.curves):
                return name
        return "profile"

    @property
    def is_rec709(self) -> bool:
        """True for linear Rec. 709 itself."""
        return self.transfer == "linear" and self.matrix is None

    def linear(self, samples: Floats) -> NDArray[np.float32]:
        """Linear Rec. 709 (…, 3) of samples (…, 3), 1 at full scale."""
        if self.table:
            return apply_table(self.table, samples)
        curves = self.curves * (3 // len(self.curves))
        values = np.stack([curve.linear(samples[..., at]) for at, curve in enumerate(curves)], axis=-1)
        return (values if self.matrix is None else values @ self.matrix.T).astype(np.float32)


def from_xyz(primaries: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Matrix to linear Rec. 709 of a space whose red, green and blue are the columns of `primaries` (3, 3) in XYZ.

    None for the primaries of Rec. 709 themselves. White is their sum, whatever its colour and luminance.
    """
    matrix: NDArray[np.float64] = SRGB_FROM_XYZ @ adaptation(primaries.sum(axis=1), D65) @ primaries
    return None if np.abs(matrix - np.eye(3)).max() <= _SAME_PRIMARIES else matrix


def from_chromaticities(xy: Sequence[float]) -> NDArray[np.float64] | None:
    """As `from_xyz`, of x and y of red, green, blue and white; ValueError for a space without extent."""
    x, y = np.asarray(xy, np.float64).reshape(4, 2).T
    if not (np.isfinite(x) & np.isfinite(y)).all() or y[3] <= 0.0:
        raise ValueError("chromaticities that no colour has")
    primaries = np.stack([x, y, 1.0 - x - y])[:, :3]
    if abs(np.linalg.det(primaries)) < 1e-3:
        raise ValueError("primaries without extent")
    white = np.array([x[3], y[3], 1.0 - x[3] - y[3]]) / y[3]
    return from_xyz(primaries * np.linalg.solve(primaries, white))


_D65_XY = REC_2020.chromaticities[6:]
P3 = (0.680, 0.320, 0.265, 0.690, 0.150, 0.060)

ADOBE_RGB = ColourSpace(
    "Adobe RGB (1998)", (gamma(563 / 256),), from_chromaticities((0.64, 0.33, 0.21, 0.71, 0.15, 0.06, *_D65_XY))
)


def linear_space(xy: Sequence[float]) -> ColourSpace:
    """The linear space of these chromaticities, named where it is a working space; ValueError as above."""
    known = next((space for space in WORKING_SPACES if np.allclose(xy, space.chromaticities, atol=1e-3)), None)
    return ColourSpace(known.label if known else "other primaries", (LINEAR_CURVE,), from_chromaticities(xy))


def apply_table(profile: bytes, samples: Floats) -> NDArray[np.float32]:
    """Linear Rec. 709 of samples (…, 3) from 0 to 1, to which others are limited, by the table of a profile.

    Little CMS raises ValueError or RuntimeError for tables that it cannot read.
    """
    from imagecodecs import cms_profile, cms_transform

    flat = samples.reshape(-1, 3)
    linear = np.empty(flat.shape, np.float32)
    connection, matrix = cms_profile("xyz"), (SRGB_FROM_XYZ @ adaptation(D50, D65)).astype(np.float32)
    for first in range(0, len(flat), _BLOCK):
        block = np.nan_to_num(np.ascontiguousarray(flat[first : first + _BLOCK], np.float32), copy=False)[None]
        xyz = cms_transform(
            block, profile, connection, colorspace="rgb", outcolorspace="xyz", outdtype=np.float32, intent=_COLORIMETRIC
        )
        linear[first : first + _BLOCK] = xyz[0] @ matrix.T
    return linear.reshape(samples.shape)


def prepare() -> None:
    """Load Little CMS, before the process gives up what loading needs."""
    from imagecodecs import cms_profile

    apply_table(cms_profile("srgb"), np.zeros((1, 3), np.float32))
