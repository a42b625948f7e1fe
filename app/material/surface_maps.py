"""A map of a surface, or its uncertainty, as an image with a scale, and its error in words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from app.widgets.image_view import Image, pixels_image, scalar_map
from app.widgets.plots import colour_table
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from engine.surface.recover import Surface

#: Maps in the order in which they are offered: a name, its label, and what it is.
MAPS = (
    ("normal", "Normals", "Directions of the surface: red to the right, green up, blue out of the image"),
    ("height", "Height", "Height of the surface in texels, from its lowest to its highest"),
    ("base_colour", "Base colour", "Colour of the surface without light: of diffuse reflection, or of metal"),
    ("roughness", "Roughness", "Roughness of the surface: 0 reflects like a mirror, 1 has the broadest highlights"),
    ("specular", "Specular", "F0 of a non-metal, its reflectance at normal incidence; plastic has 0.04"),
    ("metallic", "Metallic", "1 where highlights have the colour of metal"),
    ("occlusion", "Sky visibility", "Share of the light of an even sky that relief leaves"),
)

#: Name of the values of a map, their unit, and the factor from the unit of the map to that one.
UNITS = {
    "normal": ("normal", "°", math.degrees(1.0)),
    "height": ("height", " texel", 1.0),
    "base_colour": ("colour", " of full white", 1.0),
    "roughness": ("roughness", "", 1.0),
    "specular": ("F0", "", 1.0),
    "metallic": ("metallic", "", 1.0),
    "occlusion": ("occlusion", "", 1.0),
}

#: Texels at most of which shares are taken.
SAMPLED = 1 << 18

GREY = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)

Values = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Shown:
    """An image, its colours from 0 to `high` (0: no scale) with a caption, the values of the map and its error."""

    image: Image
    table: NDArray[np.uint8]
    high: float
    caption: str
    values: str
    error: str


def show(surface: Surface, name: str, of_error: bool) -> Steps[Shown]:
    """The map `name`, or its standard deviation."""
    yield Step(0.0, "preparing the map")
    from engine.surface.write import find_known_maps, preview  # with scipy, 40 MB

    known = find_known_maps(surface.maps)
    values, sigma = known[name], known[f"{name}_sigma"]
    _, unit, factor = UNITS[name]
    said = (_range(name, values), error_words(name, sigma))
    if of_error:
        spread = factor * (sigma.mean(axis=2) if sigma.ndim == 3 else sigma)
        high = max(float(np.quantile(_sample(spread), 0.99)), 1e-6)
        image = yield from scalar_map(spread, high, colour_table())
        return Shown(image, colour_table(), high, f"± {unit.split()[-1]}" if unit.strip() else "±", *said)
    if values.ndim == 3:
        return Shown(pixels_image(preview(name, values)), GREY, 0.0, "", *said)
    low, high = 0.0, 1.0
    if name == "height":
        low, high = (float(each) for each in np.quantile(_sample(values), (0.001, 0.999)))
    elif name == "specular":
        high = max(float(np.quantile(_sample(values), 0.995)), 1e-3)
    span = max(high - low, 1e-6)
    image = yield from scalar_map(np.asarray(values - np.float32(low), np.float32), span, GREY)
    return Shown(image, GREY, span, "texels" if name == "height" else "", *said)


def error_words(name: str, sigma: Values) -> str:
    """Median and 95th percentile of the standard deviations of a map, as a sentence."""
    what, unit, factor = UNITS[name]
    sample = factor * _sample(sigma)
    half, most = (float(each) for each in np.quantile(np.minimum(sample, 1e9), (0.5, 0.95)))
    if half >= 1e9:
        return f"The {what} is unknown at most texels."
    further = f"95\u00a0% below {number(most)}{unit}" if most < 1e9 else "unknown at more than 5\u00a0% of the texels"
    return f"Median {what} uncertainty {number(half)}{unit} (1 sigma), {further}."


def _range(name: str, values: Values) -> str:
    """The values that all but two in a thousand texels have."""
    if name == "normal":
        tilt = np.degrees(np.arccos(np.clip(_sample(values[..., 2]), -1.0, 1.0)))
        return f"tilted by {number(float(np.median(tilt)))}° (median)"
    if name == "base_colour":
        return f"{percent(float(values.mean(dtype=np.float64)))} on average"
    low, high = (float(each) for each in np.quantile(_sample(values), (0.001, 0.999)))
    return f"{number(low)} to {number(high)}"


def _sample(values: Values) -> NDArray[np.float64]:
    """Texels on a regular grid, as one row."""
    step = max(1, math.isqrt(values.shape[0] * values.shape[1] // SAMPLED))
    return np.asarray(values[::step, ::step], np.float64).ravel()
