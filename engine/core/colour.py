"""Colour: sRGB coding, RGB and XYZ, camera matrices, tone mapping and the last step to the display.

Radiance is linear Rec.709, which is linear sRGB (primaries of IEC 61966-2-1, white D65), arrays of shape (…, 3).
Negative and large values are legal everywhere except in what `to_display8` returns, so that radiance holds colours
beyond the gamut without loss. Reflectance between 0 and 1 cannot; maps of it are made in a `WorkingSpace`. Khronos PBR
Neutral: Khronos 3D Commerce working group 2024, "Khronos PBR Neutral Tone Mapper". ACES: the fit by S. Hill of the RRT
and sRGB ODT (BakingLab, 2017).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.floating[Any]]
Operator = Literal["none", "neutral", "aces"]
OPERATORS: tuple[Operator, ...] = ("none", "neutral", "aces")

#: Rows of the linear sRGB → CIE XYZ (D65) matrix, from the chromaticities of IEC 61966-2-1.
_PRIMARIES_XY = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]])
_WHITE_XY = np.array([0.3127, 0.3290])


def _xyz(xy: NDArray[np.float64]) -> NDArray[np.float64]:
    """XYZ with Y = 1 of chromaticities (…, 2)."""
    return np.stack([xy[..., 0] / xy[..., 1], np.ones(xy.shape[:-1]), (1 - xy.sum(-1)) / xy[..., 1]], -1)


def _xyz_from_primaries() -> NDArray[np.float64]:
    primaries = _xyz(_PRIMARIES_XY).T
    return primaries * np.linalg.solve(primaries, _xyz(_WHITE_XY))


XYZ_FROM_SRGB = _xyz_from_primaries()
SRGB_FROM_XYZ = np.linalg.inv(XYZ_FROM_SRGB)
LUMINANCE = XYZ_FROM_SRGB[1]

#: x and y of red, green, blue and white, as OpenEXR's `chromaticities` attribute lists them.
CHROMATICITIES = tuple(float(v) for v in (*_PRIMARIES_XY.ravel(), *_WHITE_XY))

D65 = XYZ_FROM_SRGB.sum(axis=1)

_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def adaptation(white: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix (3, 3) by which XYZ seen under `white` looks alike under `target`, by Bradford (Lam1985)."""
    scale = (_BRADFORD @ target) / (_BRADFORD @ white)
    adapted: NDArray[np.float64] = np.linalg.inv(_BRADFORD) @ (scale[:, None] * _BRADFORD)
    return adapted


@dataclass(frozen=True)
class WorkingSpace:
    """A linear space in which reflectance is bounded.

    Attributes
    ----------
    name : as options and functions take it. label : as records and users see it.
    chromaticities : x and y of red, green, blue and white.
    """

    name: str
    label: str
    chromaticities: tuple[float, ...]

    @property
    def to_rec709(self) -> NDArray[np.float64]:
        """Matrix (3, 3) from colours of the space to linear Rec.709, whites adapted by Bradford."""
        if self.chromaticities == CHROMATICITIES:
            return np.eye(3)
        points = _xyz(np.array(self.chromaticities).reshape(4, 2))
        primaries = points[:3].T
        scaled = primaries * np.linalg.solve(primaries, points[3])
        return np.asarray(SRGB_FROM_XYZ @ adaptation(points[3], D65) @ scaled, np.float64)

    @property
    def from_rec709(self) -> NDArray[np.float64]:
        """Matrix (3, 3) from linear Rec.709 to colours of the space."""
        return np.asarray(np.linalg.inv(self.to_rec709), np.float64)


REC_709 = WorkingSpace("rec709", "linear Rec.709", CHROMATICITIES)
REC_2020 = WorkingSpace("rec2020", "linear Rec.2020", (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, *CHROMATICITIES[6:]))
ACESCG = WorkingSpace("acescg", "ACEScg", (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767))
WORKING_SPACES = (REC_709, REC_2020, ACESCG)


def working_space(name: str) -> WorkingSpace:
    """The working space of this name or label; ValueError for another."""
    found = next((space for space in WORKING_SPACES if name in (space.name, space.label)), None)
    if found is None:
        names = ", ".join(space.name for space in WORKING_SPACES)
        raise ValueError(f"unknown working space {name!r}; choose from {names}")
    return found


def _floating(values: ArrayLike) -> Floats:
    array: NDArray[Any] = np.asarray(values)
    return array if array.dtype in (np.float32, np.float64) else array.astype(np.float64)


def srgb_decode(coded: ArrayLike) -> Floats:
    """Linear value of an sRGB-coded value (1 = white), IEC 61966-2-1; odd-symmetric below 0, float dtype kept."""
    coded = _floating(coded)
    size = np.abs(coded)
    high = ((np.maximum(size, 0.04045) + 0.055) / 1.055) ** 2.4
    linear: Floats = np.copysign(np.where(size <= 0.04045, size / 12.92, high), coded).astype(coded.dtype)
    return linear


def srgb_encode(linear: ArrayLike) -> Floats:
    """sRGB-coded value of a linear value: inverse of `srgb_decode`; not clipped, NaN stays NaN."""
    linear = _floating(linear)
    size = np.abs(linear)
    high = 1.055 * np.maximum(size, 0.0031308) ** (1 / 2.4) - 0.055
    coded: Floats = np.copysign(np.where(size <= 0.0031308, size * 12.92, high), linear).astype(linear.dtype)
    return coded


def luminance(rgb: ArrayLike) -> Floats:
    """Y of linear sRGB (…, 3) → (…), in the dtype of the input."""
    rgb = _floating(rgb)
    return rgb @ LUMINANCE.astype(rgb.dtype)


def xyz_from_srgb(rgb: ArrayLike) -> Floats:
    """CIE XYZ (D65, white Y = 1) of linear sRGB, (…, 3)."""
    rgb = _floating(rgb)
    return rgb @ XYZ_FROM_SRGB.T.astype(rgb.dtype)


def srgb_from_xyz(xyz: ArrayLike) -> Floats:
    """Linear sRGB of CIE XYZ (…, 3); out-of-gamut colours have negative channels."""
    xyz = _floating(xyz)
    return xyz @ SRGB_FROM_XYZ.T.astype(xyz.dtype)


def invertible(matrix: NDArray[np.float64]) -> bool:
    """True for a finite (3, 3) matrix whose condition number is at most 1e4."""
    return matrix.shape == (3, 3) and bool(np.isfinite(matrix).all() and _condition(matrix) <= 1e4)


def _condition(matrix: NDArray[np.float64]) -> float:
    singular = np.linalg.svd(matrix, compute_uv=False)
    return float(singular[0] / singular[-1]) if singular[-1] > 0 else math.inf


def srgb_from_camera(camera_from_xyz: ArrayLike) -> NDArray[np.float64] | None:
    """Matrix (3, 3) from white-balanced camera RGB to linear sRGB, or None where the camera's matrix is unusable.

    Camera (1, 1, 1) becomes neutral (1, 1, 1): the rows of camera-from-sRGB are scaled to the sum 1 before the
    inversion, as dcraw and LibRaw do. None where the (3, 3) input is singular, ill-conditioned or not finite.
    """
    matrix = np.asarray(camera_from_xyz, np.float64)
    if not invertible(matrix):
        return None
    camera_from_srgb = matrix @ XYZ_FROM_SRGB
    sums = camera_from_srgb.sum(axis=1)
    if (np.abs(sums) < 1e-6 * np.abs(camera_from_srgb).max()).any():
        return None
    inverse: NDArray[np.float64] = np.linalg.inv(camera_from_srgb / sums[:, None])
    return inverse


def tone_map(image: ArrayLike, exposure_ev: float = 0.0, operator: Operator = "neutral") -> NDArray[np.float32]:
    """Display-linear image (H, W, 3) ≥ 0 of a radiance image, for `to_display8`.

    `exposure_ev` multiplies by 2^EV. NaN and negative radiance become 0 and infinity a large number here, at the
    display, and nowhere before it.
    """
    if operator not in OPERATORS:
        raise ValueError(f"unknown tone mapping {operator!r}; choose from {', '.join(OPERATORS)}")
    radiance = np.nan_to_num(np.asarray(image, np.float32), nan=0.0, posinf=_BRIGHTEST, neginf=0.0)
    gain = 2.0**exposure_ev
    exposed = np.clip(radiance, 0.0, min(_BRIGHTEST, _BRIGHTEST / gain)) * np.float32(gain)
    if operator == "neutral":
        return _neutral(exposed)
    if operator == "aces":
        return _aces(exposed)
    return exposed


#: Radiance above this is shown as this: its square still fits into float32.
_BRIGHTEST = 1e15


def _neutral(colour: NDArray[np.float32]) -> NDArray[np.float32]:
    start, desaturation, fresnel = np.float32(0.8 - 0.04), np.float32(0.15), np.float32(0.04)
    low = colour.min(-1, keepdims=True)
    offset = np.where(low < 0.08, low - 6.25 * low * low, fresnel)
    colour = colour - offset
    peak = colour.max(-1, keepdims=True)
    compressed = 1 - (1 - start) ** 2 / (np.maximum(peak, start) + 1 - 2 * start)
    scaled = colour * (compressed / np.maximum(peak, start))
    grey = 1 - 1 / (desaturation * (np.maximum(peak, start) - compressed) + 1)
    return np.where(peak < start, colour, scaled + (compressed - scaled) * grey).astype(np.float32)


_ACES_IN = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]], np.float32)
_ACES_OUT = np.array(
    [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]], np.float32
)


def _aces(colour: NDArray[np.float32]) -> NDArray[np.float32]:
    v = colour @ _ACES_IN.T
    fitted = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    return np.clip(fitted @ _ACES_OUT.T, 0.0, 1.0).astype(np.float32)


def to_display8(display: ArrayLike, *, dither: bool = False) -> NDArray[np.uint8]:
    """sRGB-coded uint8 of a display-linear image (H, W, 3), clipped to [0, 1]; NaN becomes 0.

    `dither` adds an ordered 8×8 Bayer pattern of ±½ code: the same image gives the same bytes, always.
    """
    linear = np.nan_to_num(np.asarray(display, np.float32), nan=0.0, posinf=1.0, neginf=0.0)
    coded = srgb_encode(np.clip(linear, 0.0, 1.0)) * np.float32(255)
    if dither:
        height, width = coded.shape[:2]
        threshold = np.tile(_bayer(3), (-(-height // 8), -(-width // 8)))[:height, :width, None]
        return np.clip(np.floor(coded + threshold), 0, 255).astype(np.uint8)
    return np.rint(coded).astype(np.uint8)


def _bayer(order: int) -> NDArray[np.float32]:
    """Ordered-dither thresholds in (0, 1), shape (2^order, 2^order) (Bayer1973)."""
    matrix = np.zeros((1, 1))
    for _ in range(order):
        matrix = np.block([[4 * matrix, 4 * matrix + 2], [4 * matrix + 3, 4 * matrix + 1]])
    return ((matrix + 0.5) / matrix.size).astype(np.float32)
