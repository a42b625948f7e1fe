"""Directions of lamps from nothing but photographs of a matte surface: an estimate, up to what has to be assumed.

Brightness I (N, T) of T texels under N distant lamps is S B, the lamps S (N, 3) times reflectance and normals B (3, T),
where nothing is in a shadow (Hayakawa1994). The factors follow by least squares, in turn for texels and lamps, with
shadows and highlights as missing values. S A and A⁻¹ B show the same photographs for every 3 × 3 matrix A. Fixed by:

1. Lamps are equally bright: sᵀ A Aᵀ s = 1 for each, which is linear in A Aᵀ and leaves a rotation and a mirror image.
2. The sample lies flat: its mean slope is zero, which leaves a turn about the view.
3. Slopes are those of a surface: their curl is least (Yuille1999), in closed form, which leaves hills or valleys.
4. Deep texels see fewer lamps; where shadows do not tell that, the surface is taken to bulge towards the camera.

On generated domes lamps are found within 1° for matte surfaces and within some 10° for glossy ones, as long as shadows
or the assumption tell hills from valleys.
Cost: some seconds for 16,384 texels under 64 lamps.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from engine.capture.lights.azimuth_spread import about_azimuth
from engine.capture.lights.light_angles import ASSUMED, FROM_NAMES
from engine.capture.lights.sources import Sources
from engine.capture.lights.sphere_lights import luminances
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.core.slopes import integrate_slopes
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.images.decode import TransferChoice

Array = NDArray[np.float64]

#: Lamps without which six numbers of a symmetric matrix are not told.
MIN_LAMPS = 8

#: Texels along the longer side, and rounds of least squares.
SIDE, ROUNDS = 128, 40

#: Value of `angle_source` for lights that are estimated so.
FROM_PHOTOGRAPHS = "photographs"

#: Brightness over an upper one of a texel that counts as a shadow, over its fit as a highlight, and below it as shadow.
SHADOW, HIGHLIGHT, CAST = 0.08, 1.15, 0.8

#: Share of the photographs, the brightest of a texel, that do not count at first.
HIGHLIGHTS = 0.2

#: Standard deviation of directions in degrees, and its growth with the residual, found on generated domes.
SIGMA_DEG, SIGMA_BY_RESIDUAL_DEG = 1.0, 300.0

#: Condition of the equations up to which that holds, and the deviation (radians) above which the lamps are not told.
USUAL_CONDITION, MAX_SIGMA = 2.5, math.radians(20.0)

#: Largest condition of the equations for equal lamps, and correlation of depth and shadows that decides.
MAX_CONDITION, MIN_CORRELATION = 2e3, 0.05


class NotTold(ValueError):
    """The photographs do not tell their lamps; the text says why."""


def estimate_lights(sources: Sources, transfer: TransferChoice) -> Steps[Sources]:
    """`sources` with the directions that their photographs tell, by rising elevation.

    Each photograph is decoded once more. Raises InputError where the photographs do not tell their lamps.
    """
    import cv2

    images = yield from luminances(sources, transfer)
    scale = min(1.0, SIDE / max(images.shape[1:]))
    size = (max(1, round(images.shape[2] * scale)), max(1, round(images.shape[1] * scale)))
    small = np.stack([cv2.resize(np.asarray(image), size, interpolation=cv2.INTER_AREA) for image in images])
    yield Step(0.9, "Estimating the lights")
    try:
        found = estimate_lamps(small)
    except NotTold as error:
        problem = f"does not show where its lamps stood: {error}"
        raise InputError(sources.photographs[0].parent, problem, "Give a list of lights (.lp)") from None
    elevation = np.arcsin(np.clip(found.directions[:, 2], 0.0, 1.0))
    azimuth = np.arctan2(found.directions[:, 1], found.directions[:, 0])
    order = np.argsort(elevation, kind="stable")
    text = (
        f"The lights were estimated from the photographs alone, to {math.degrees(found.sigma):.0f}° (1 sigma), as "
        "those of equally bright distant lamps over a matte sample that lies flat"
    )
    if found.is_convex_assumed:
        text += (
            ". Hills and valleys were distinguished by assumption: the sample bulges towards the camera; if it is "
            "hollow, all slopes are reversed"
        )
    kept = [finding for finding in sources.findings if not finding.text.startswith((ASSUMED, FROM_NAMES))]
    return replace(
        sources.reorder(order),
        elevation=elevation[order],
        azimuth=azimuth[order],
        angle_source=FROM_PHOTOGRAPHS,
        lamp_sigma={
            **sources.lamp_sigma,
            "directions": found.sigma,
            **({"convexity": 1.0} if found.is_convex_assumed else {}),
        },
        findings=(*kept, Finding(Verdict.WARNING, text), *about_azimuth(azimuth)),
    )


@dataclass(frozen=True, eq=False)
class EstimatedLamps:
    """Lamps that photographs tell.

    Attributes
    ----------
    directions : (N, 3) unit vectors: x to the right, y up, z to the camera.
    residual : root mean square of what the factors leave, over the mean brightness.
    condition : condition number of the equations for equal lamps, 2 for lamps of a whole dome.
    is_convex_assumed : whether hills were told from valleys by assumption, not by shadows.
    """

    directions: Array
    residual: float
    condition: float
    is_convex_assumed: bool

    @property
    def sigma(self) -> float:
        """Standard deviation of the directions in radians.

        Gloss, which leaves a residual, bends the factors, the more so the smaller the part of the sky with lamps is.
        """
        spread = max(1.0, self.condition / USUAL_CONDITION)
        return math.radians(SIGMA_DEG + SIGMA_BY_RESIDUAL_DEG * self.residual) * spread


def estimate_lamps(images: NDArray[np.float32]) -> EstimatedLamps:
    """The lamps of linear images (N, H, W) of one matte surface. Raises NotTold."""
    count, height, width = images.shape
    if count < MIN_LAMPS:
        raise NotTold(f"{count} photographs are fewer than the {MIN_LAMPS} from which lamps can be estimated")
    values = images.reshape(count, -1).astype(np.float64)
    upper = np.quantile(values, 0.9, axis=0)
    lit = upper > 0.05 * np.quantile(upper, 0.9)
    if lit.sum() < 256:
        raise NotTold("too few texels are lit")
    lamps, texels, cast, residual = _factorise(values[:, lit] / upper[lit])
    if not (np.isfinite(lamps).all() and np.isfinite(texels).all()):
        raise NotTold("some of them show too little")
    between, condition = _equal_lamps(lamps)
    lamps, texels = lamps @ between, np.linalg.inv(between).astype(np.float64) @ texels
    normals = texels / np.maximum(np.linalg.norm(texels, axis=0), 1e-9)
    turn = _upright(normals, lamps)
    lamps, normals = lamps @ turn.T, turn @ normals
    slopes = np.full((2, height * width), np.nan)
    steep = np.maximum(normals[2], 0.15)
    slopes[:, lit] = -normals[:2] / steep  # dh/dx and dh/dy
    mirrored, angle = _integrable(slopes.reshape(2, height, width))
    flip = np.diag([mirrored, 1.0])
    rotation = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    plane = rotation @ flip
    slopes = plane @ slopes
    shadows = np.zeros(height * width)
    shadows[lit] = cast
    sign, is_assumed = _tell_hills(
        slopes.reshape(2, height, width), shadows.reshape(height, width), lit.reshape(height, width)
    )
    directions = lamps.copy()
    directions[:, :2] = sign * lamps[:, :2] @ plane.T
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    if np.quantile(directions[:, 2], 0.2) < 0.05:
        raise NotTold("the lamps that would explain them stand behind the sample")
    directions[:, 2] = np.maximum(directions[:, 2], 0.02)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    found = EstimatedLamps(directions, residual, condition, is_assumed)
    if found.sigma > MAX_SIGMA:
        raise NotTold(f"the directions would be uncertain by {math.degrees(found.sigma):.0f}°")
    return found


def _factorise(values: Array) -> tuple[Array, Array, Array, float]:
    """Lamps (N, 3), texels (3, T), the share of lamps (T,) that are hidden, and the relative residual."""
    upper = np.quantile(values, 0.9, axis=0)
    bright = values > SHADOW * upper
    start = bright & (values <= np.quantile(values, 1.0 - HIGHLIGHTS, axis=0))
    start |= bright & (start.mean(axis=1) < 0.3)[:, None]  # the highest lamps are the brightest of a matte surface
    weight = start.astype(np.float64)
    left, size, right = np.linalg.svd(values, full_matrices=False)
    lamps, texels = left[:, :3] * size[:3], right[:3]
    ridge = 1e-9 * np.eye(3)
    shown = values
    for turn in range(ROUNDS):
        products = np.einsum("nt,ni,nj->tij", weight, lamps, lamps) + ridge
        texels = np.linalg.solve(products, np.einsum("nt,ni,nt->ti", weight, lamps, values)[..., None])[..., 0].T
        products = np.einsum("nt,it,jt->nij", weight, texels, texels) + ridge
        lamps = np.linalg.solve(products, np.einsum("nt,it,nt->ni", weight, texels, values)[..., None])[..., 0]
        shown = lamps @ texels
        if turn >= 5:
            seen = (values > SHADOW * upper) & (values > CAST * shown) & (values < HIGHLIGHT * np.maximum(shown, 0.05))
            weight = np.where(seen.sum(axis=0) >= 5, seen, start).astype(np.float64)
        scale = np.sqrt((lamps**2).mean(axis=0))
        lamps, texels = lamps / scale, texels * scale[:, None]
    cast = ((values < 0.5 * shown) & (shown > 0.2 * upper)).mean(axis=0)
    counted = weight > 0.0
    residual = float(np.sqrt(np.mean((values - shown)[counted] ** 2)) / np.mean(values[counted]))
    return lamps, texels, cast, residual


def _equal_lamps(lamps: Array) -> tuple[Array, float]:
    """A (3, 3) with which all lamps S A have the length one, as nearly as they can, and the equations' condition."""
    scale = float(np.sqrt((lamps**2).sum(axis=1).mean()))
    x, y, z = (lamps / scale).T
    system = np.stack([x * x, y * y, z * z, 2.0 * x * y, 2.0 * x * z, 2.0 * y * z], axis=1)
    condition = float(np.linalg.cond(system))
    if condition > MAX_CONDITION:
        raise NotTold("the lamps stand at one elevation or in one plane")
    weight = np.ones(len(lamps))
    for _ in range(20):  # lamps that differ count less
        found = np.linalg.lstsq(system * weight[:, None], weight, rcond=None)[0]
        off = np.abs(system @ found - 1.0)
        weight = 1.0 / np.sqrt(1.0 + (off / max(1.4826 * float(np.median(off)), 1e-3)) ** 2)
    xx, yy, zz, xy, xz, yz = found
    metric = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    size, axes = np.linalg.eigh(metric)
    if size[0] <= 1e-4 * size[2]:
        raise NotTold("no lamps of equal brightness explain them")
    return np.asarray(axes * np.sqrt(size) / scale), condition


def _upright(normals: Array, lamps: Array) -> Array:
    """Rotation (3, 3), or its negative, that turns the mean normal (3, T) and the lamps to the camera."""
    axis: Array = normals.mean(axis=1)
    for _ in range(20):
        axis /= np.linalg.norm(axis)
        frame = _frame(axis)
        slopes = (frame @ normals)[:2] / np.maximum((frame @ normals)[2], 0.15)
        middle = np.clip(slopes, -3.0, 3.0).mean(axis=1)
        axis = axis + frame[0] * middle[0] + frame[1] * middle[1]
        if np.hypot(*middle) < 1e-5:
            break
    axis /= np.linalg.norm(axis)
    frame = _frame(axis)
    return frame if (lamps @ axis).mean() > 0.0 else -frame


def _frame(axis: Array) -> Array:
    """Rotation (3, 3) whose last row is the unit vector `axis`."""
    other = np.eye(3)[int(np.argmin(np.abs(axis)))]
    right = np.cross(other, axis)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(axis, right), axis])


def _integrable(slopes: Array) -> tuple[float, float]:
    """Mirror (1 or −1, of x) and turn with which slopes (2, H, W) have the least curl; the turn counts modulo π."""
    best = (math.inf, 1.0, 0.0)
    for mirrored in (1.0, -1.0):
        right, up = mirrored * slopes[0], slopes[1]
        x_right, x_up = np.gradient(right, axis=1), np.gradient(up, axis=1)
        y_right, y_up = -np.gradient(right, axis=0), -np.gradient(up, axis=0)
        curl, divergence = x_up - y_right, x_right + y_up
        known = np.isfinite(curl) & np.isfinite(divergence)
        limit = 3.0 * float(np.median(np.hypot(curl[known], divergence[known]))) + 1e-9
        known &= np.hypot(curl, divergence) < limit
        pair = np.stack([curl[known], divergence[known]])
        size, axes = np.linalg.eigh(pair @ pair.T)
        left = float(size[0] / max(size[1], 1e-30))
        if left < best[0]:
            best = (left, mirrored, math.atan2(axes[1, 0], axes[0, 0]))
    return best[1], best[2]


def _tell_hills(slopes: Array, shadows: Array, lit: NDArray[np.bool_]) -> tuple[float, bool]:
    """1, or −1 where hills are valleys, and whether that was assumed."""
    right, up = np.where(lit, slopes, 0.0)
    height = integrate_slopes(np.nan_to_num(right), np.nan_to_num(up))
    inner = ndimage.binary_erosion(lit, iterations=2)
    wide = 0.1 * max(height.shape)
    depth = height - ndimage.gaussian_filter(height, wide, mode="nearest")
    more = shadows - ndimage.gaussian_filter(shadows, wide, mode="nearest")
    if inner.sum() > 100 and more[inner].std() > 0.0:
        alike = float(np.corrcoef(depth[inner], more[inner])[0, 1])
        if abs(alike) > MIN_CORRELATION:
            return (-1.0 if alike > 0.0 else 1.0), False
    rows, columns = np.mgrid[: height.shape[0], : height.shape[1]]
    out = np.hypot(rows - rows[lit].mean(), columns - columns[lit].mean())
    return (1.0 if np.corrcoef(height[lit], out[lit])[0, 1] < 0.0 else -1.0), True
