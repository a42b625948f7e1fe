"""Figures of a BRDF for the BRDF workspace, computed off the window's thread."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.analysis import albedo, half_difference_slice, lobe, maximum_albedo, polar_slice, reciprocity_error
from engine.brdf.brdf import Brdf, brdf_from_text
from engine.brdf.models.sampling import sampler_of
from engine.brdf.resample import SHAPE, resample
from engine.core.colour import luminance, srgb_encode
from engine.core.directions import normalize, surface_direction
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.brdf.analysis import MaximumAlbedo, ReciprocityError

Floats = NDArray[np.float64]

#: Azimuth of the light in the surface frame: it stands on the left of every image.
LIGHT_PHI = float(np.pi)

#: Of the table of a brushed BRDF, which is a mean over many azimuths.
COARSE = (45, 45, 60)

#: Beyond this angle from the normal, in radians, values do not decide the scale of an image.
NEAR_HORIZON = float(np.radians(80.0))

ALBEDO_DEG = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 77.5, 85.0, 89.0, 89.9)


@dataclass(frozen=True, eq=False)
class Curves:
    """Luminance in 1/sr of `brdf` with the light at `theta_i` radians.

    Attributes
    ----------
    wo, lobe : directions (64, 64, 3) over the hemisphere, and values (64, 64).
    theta_o, polar : signed angles (N,) in the plane of incidence, positive on the side away from the light, values.
    half_difference : (90, 90) over theta_h (columns) and theta_d (rows from the bottom), whatever the light.
    """

    brdf: Brdf
    theta_i: float
    wo: Floats
    lobe: Floats
    theta_o: Floats
    polar: Floats
    half_difference: Floats

    @property
    def highest(self) -> float:
        """The largest value with the viewer within `NEAR_HORIZON`; beyond it measured ones may have no bound."""
        theta = np.arccos(np.clip(self.wo[..., 2], -1.0, 1.0))
        near = np.abs(self.theta_o) < NEAR_HORIZON
        return max(float(self.lobe[theta < NEAR_HORIZON].max()), float(self.polar[near].max()))


@dataclass(frozen=True, eq=False)
class Facts:
    """Figures of a BRDF that do not depend on the light."""

    brdf: Brdf
    reciprocity: ReciprocityError
    largest: MaximumAlbedo


def curves(wanted: Sequence[tuple[int, Any, Curves | None]], theta_i: float) -> Steps[dict[int, Curves]]:
    """The curves of each BRDF, by number; known figures that do not depend on the light are kept."""
    found = {}
    for done, (number, brdf, known) in enumerate(wanted):
        yield Step(done / len(wanted), "evaluating")

        wo, values = lobe(brdf, theta_i, LIGHT_PHI)
        theta_o, polar = polar_slice(brdf, theta_i, LIGHT_PHI)
        same = known is not None and known.brdf == brdf
        image = known.half_difference if known is not None and same else _bright(half_difference_slice(brdf))
        found[number] = Curves(brdf, theta_i, wo, _bright(values), theta_o, _bright(polar), image)
    return found


def _bright(values: Floats) -> Floats:
    return np.asarray(luminance(values), np.float64)


def albedos(wanted: Sequence[tuple[int, Any]]) -> Steps[dict[int, tuple[Any, Floats]]]:
    """By number: each BRDF and its albedo, luminance, towards viewers at `ALBEDO_DEG`."""
    found = {}
    for done, (number, brdf) in enumerate(wanted):
        yield Step(done / len(wanted), "integrating")

        sampler, values = sampler_of(brdf), []
        for angle in np.radians(ALBEDO_DEG):
            values.append(albedo(brdf, surface_direction(angle, 0.0), sampler=sampler, count=1024))
            yield Step((done + len(values) / len(ALBEDO_DEG)) / len(wanted), "integrating")
        found[number] = (brdf, _bright(np.array(values)))
    return found


def facts(brdf: Brdf) -> Steps[Facts]:
    """Reciprocity and the largest albedo."""
    yield Step(0.0, "exchanging light and viewer")

    reciprocity = reciprocity_error(brdf)
    yield Step(0.3, "integrating")
    return Facts(brdf, reciprocity, maximum_albedo(brdf))


def drawable(brdf: Brdf) -> Steps[Any]:
    """`brdf` as a table that a viewport draws without delay."""
    yield Step(0.0, "compiling (first use only)")

    return (yield from resample(brdf, SHAPE if brdf.isotropic else COARSE, dtype=np.float32))


def thumbnails(wanted: Sequence[tuple[str, Any]], size: int) -> Steps[None]:
    """A lit sphere of each, `(key, (size, size, 4) uint8)` as partial results; texts name models."""
    for done, (key, brdf) in enumerate(wanted):
        made = thumbnail(brdf_from_text(brdf) if isinstance(brdf, str) else brdf, size)
        yield Step(done / len(wanted), "drawing thumbnails", (key, made))


def thumbnail(brdf: Brdf, size: int) -> NDArray[np.uint8]:
    """(size, size, 4) uint8: a sphere under a light from the upper left and a weaker one beside the camera."""
    fine = 2 * size
    across = (np.arange(fine) + 0.5) / fine * 2.0 - 1.0
    x, y = 1.03 * across[None, :], -1.03 * across[:, None]
    inside = x**2 + y**2 < 1.0
    normal = np.stack([*np.broadcast_arrays(x, y), np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))], axis=-1)[inside]
    tangent = normalize(np.cross((0.0, 1.0, 0.0), normal), (1.0, 0.0, 0.0))
    frame = np.stack([tangent, np.cross(normal, tangent), normal], axis=1)
    radiance = np.zeros((len(normal), 3))
    for light, strength in (((-0.5, 0.62, 0.6), 2.6), ((0.35, 0.1, 1.0), 0.7)):
        wi = normalize(frame @ normalize(np.array(light)))
        radiance += strength * brdf.f(wi, normalize(frame[:, :, 2])) * np.maximum(wi[:, 2:], 0.0)
    image = np.zeros((fine, fine, 4))
    image[inside, :3], image[inside, 3] = np.clip(radiance, 0.0, 1.0), 1.0
    small = image.reshape(size, 2, size, 2, 4).mean(axis=(1, 3))
    small[..., :3] = srgb_encode(small[..., :3] / np.maximum(small[..., 3:], 0.25))
    return np.asarray(np.round(255.0 * small), np.uint8)
