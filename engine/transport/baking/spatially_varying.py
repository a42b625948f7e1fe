"""Reflectances that are not the same all over a model: a number or a colour at each vertex, and what it moves.

A number comes from where a vertex lies in the bounding box, or from an image that is looked up at its texture
coordinates: bilinear between the centres of pixels, repeated beyond the edges, v up. A `Variation` says which parameter
of a BRDF a number moves between which two values:

    parameter at the vertex = start + (stop − start) · number

An image of numbers is read as it is stored, codes over the highest code, because such images hold no colours; an
image of colours is decoded as any other image is (sRGB where nothing says otherwise).
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import MODELS, Brdf
from engine.core.colour import luminance
from engine.core.errors import UsageError
from engine.core.params import parameters
from engine.geometry.mesh import Mesh

#: Sources that are not image: the coordinates across the bounding box.
AXES = ("x", "y", "z")

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Variation:
    """A parameter that goes from `start` to `stop` where the number of `source` goes from 0 to 1.

    `source` is as in `vertex_values`. A parameter that is a colour is grey. UsageError where a value is not finite.
    """

    parameter: str
    start: float
    stop: float
    source: str

    def __post_init__(self) -> None:
        if not (math.isfinite(self.start) and math.isfinite(self.stop)):
            raise UsageError(f"{self.parameter} cannot go from {self.start} to {self.stop}")
        if not self.parameter or not self.source:
            raise UsageError("a variation needs the name of a parameter and a source")

    def at(self, number: ArrayLike) -> Array:
        """The parameter's value for numbers in [0, 1]."""
        share = np.asarray(number, np.float64)
        return np.asarray((1.0 - share) * self.start + share * self.stop)


def variation_from_text(text: str) -> Variation:
    """`PARAMETER=FROM:TO:SOURCE` as a variation, say `alpha=0.1:0.5:y` or `nu=10:100:map.png`; else UsageError."""
    name, _, rest = text.partition("=")
    pieces = rest.split(":", 2)
    try:
        start, stop = float(pieces[0]), float(pieces[1])
        return Variation(name.strip(), start, stop, pieces[2].strip())
    except (IndexError, ValueError):
        raise UsageError(f"{text!r} is not of the form PARAMETER=FROM:TO:SOURCE, say alpha=0.1:0.5:y") from None


def variation_to_text(variation: Variation) -> str:
    """The text that `variation_from_text` turns back into `variation`."""
    return f"{variation.parameter}={variation.start!r}:{variation.stop!r}:{variation.source}"


def vertex_values(mesh: Mesh, source: str | os.PathLike[str], count: int | None = None) -> Array:
    """(V,) numbers in [0, 1] of the vertices of `mesh`, or of the first `count`, which are a model on a ground.

    `source` is 'x', 'y' or 'z', the coordinate across the bounding box, 0 at its low side and all over a model without
    extent; or the path of an image, whose luminance is clipped to [0, 1]. InputError for what is not an image.
    """
    if source in AXES:
        along = mesh.positions[:count, AXES.index(str(source))]
        low, high = float(along.min()), float(along.max())
        size = high - low
        return np.asarray(np.clip((along - low) / size, 0.0, 1.0)) if size > 0.0 else np.zeros(len(along))
    from engine.images.decode import read_image  # with its decoders, 25 MB that few scenes need

    colours = _look_up(read_image(source, transfer="linear").pixels, mesh.uv[:count])
    return np.asarray(np.clip(luminance(colours), 0.0, 1.0))


def vertex_colours(mesh: Mesh, path: str | os.PathLike[str]) -> Array:
    """(V, 3) linear RGB of the vertices of `mesh` from an image, clipped to [0, 1]; InputError for what is none."""
    from engine.images.decode import read_image

    return np.clip(_look_up(read_image(path).pixels, mesh.uv), 0.0, 1.0)


def _look_up(pixels: NDArray[np.float32], uv: NDArray[np.float32]) -> Array:
    """(V, 3) of an image (H, W, 3), repeated, at texture coordinates (V, 2)."""
    height, width = pixels.shape[:2]
    column, row = (
        uv[:, 0].astype(np.float64) % 1.0 * width - 0.5,
        (1.0 - uv[:, 1].astype(np.float64)) % 1.0 * height - 0.5,
    )
    left, top = np.floor(column), np.floor(row)
    across, down = (column - left)[:, None], (row - top)[:, None]
    x, y = left.astype(np.int64), top.astype(np.int64)

    def line(at: NDArray[np.int64]) -> Array:
        first, second = pixels[at % height, x % width], pixels[at % height, (x + 1) % width]
        return (1.0 - across) * first + across * second

    return (1.0 - down) * line(y) + down * line(y + 1)


def check_variations(brdf: Brdf, variations: Sequence[Variation]) -> tuple[Variation, ...]:
    """`variations`, or UsageError where `brdf` has no such parameter, or not these values, or one is named twice."""
    names = [parameter.name for parameter in parameters(brdf)] if type(brdf) in MODELS.values() else []
    for number, variation in enumerate(variations):
        if not names:
            raise UsageError("only analytic models have parameters that can vary over a surface")
        if variation.parameter not in names:
            raise UsageError(f"the BRDF has no parameter {variation.parameter!r}; it has {', '.join(names)}")
        if variation.parameter in [other.parameter for other in variations[:number]]:
            raise UsageError(f"{variation.parameter} is to vary twice")
        for end in (variation.start, variation.stop):
            with_parameters(brdf, {variation.parameter: end})
    return tuple(variations)


def with_parameters(brdf: Brdf, values: dict[str, float]) -> Brdf:
    """`brdf` with other values of some parameters; UsageError for a value out of range."""
    model: Any = brdf
    changed: Brdf = dataclasses.replace(model, **values)
    return changed


def vary_brdf(brdf: Brdf, variations: Sequence[Variation], numbers: Sequence[ArrayLike]) -> list[Brdf]:
    """`brdf` at every combination of `numbers` in [0, 1], one array for each variation; the last one runs fastest."""
    values = [variation.at(some).tolist() for variation, some in zip(variations, numbers, strict=True)]
    names = [variation.parameter for variation in variations]
    return [with_parameters(brdf, dict(zip(names, combination, strict=True))) for combination in product(*values)]
