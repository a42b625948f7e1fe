"""Error of a few chosen directions against the whole environment, on the view that is shown.

The reference is the sum over all of the map in cells of `REFERENCE_ROWS` rows, each as a light in the mean direction of
what it holds, with the look-up inside the sum, at pixel centres drawn evenly among those that show the model. About 1 s
per million pixels times cells: 2 s for the defaults and 256 pixels. With 256 rows instead of 64 the errors of up to 512
lights change by no more than 0.04 % of the image on a diffuse and 0.5 % on a shiny material (Phong, exponent 100).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.steps import Step, Steps
from engine.light.environment import DistantLights, all_lights
from engine.light.lamps import lights_of_all
from engine.render.direct import Shader
from engine.scene.scene import Scene

REFERENCE_ROWS = 64
PIXELS = 256

#: Lights of one step, about 50 ms of work for `PIXELS`.
_LIGHTS_OF_A_STEP = 128


@dataclass(frozen=True)
class DirectionsError:
    """The root of the mean square difference relative to that of the reference, over pixels and channels.

    Attributes
    ----------
    rmse_rel : relative error, no unit; 0 where the reference is black too.
    pixels : how many were compared; reference_size : (width, height) of the reference in cells.
    """

    directions: int
    rmse_rel: float
    pixels: int
    reference_size: tuple[int, int]


def environment_error(
    scene: Scene, size: tuple[int, int], *, pixels: int = PIXELS, seed: int = 0
) -> Steps[DirectionsError]:
    """The error of `scene.directions` lights in the image of `size` (width, height)."""
    (error,) = yield from error_ladder(scene, size, (scene.directions,), pixels=pixels, seed=seed)
    return error


def error_ladder(
    scene: Scene, size: tuple[int, int], counts: Sequence[int], *, pixels: int = PIXELS, seed: int = 0
) -> Steps[list[DirectionsError]]:
    """The errors of several numbers of directions against one reference."""
    if scene.environment is None:
        raise ValueError("a scene without an environment has no directions to choose")
    shade = Shader(dataclasses.replace(scene, near_lamps=()), size)  # directions do not stand for near lamps
    row, column = _pixels(shade, size, pixels, seed)
    lights = all_lights(scene.environment, REFERENCE_ROWS)
    dense = DistantLights(lights.direction, lights.irradiance * scene.irradiance).rotate(scene.environment_rotation)
    dense = dense.beside(lights_of_all(scene.lamps))
    dense_sum = yield from _sum_up(shade, row, column, dense)
    size_of_reference = (2 * REFERENCE_ROWS, REFERENCE_ROWS)
    errors = []
    for count in counts:
        chosen = dataclasses.replace(scene, directions=count).lights
        shown = yield from _sum_up(shade, row, column, chosen)
        errors.append(DirectionsError(count, _relative(shown, dense_sum), len(row), size_of_reference))
    return errors


def _pixels(shade: Shader, size: tuple[int, int], count: int, seed: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """At most `count` pixels that show the model."""
    width, height = size
    drawn = np.random.default_rng(seed).choice(width * height, min(width * height, 16 * count), replace=False)
    row, column = np.divmod(drawn, width)
    covered = np.flatnonzero(shade(row, column, DistantLights(np.zeros((0, 3)), np.zeros((0, 3))))[:, 3])[:count]
    return row[covered], column[covered]


def _sum_up(
    shade: Shader, row: NDArray[np.int64], column: NDArray[np.int64], lights: DistantLights
) -> Steps[NDArray[np.float64]]:
    """Radiance (N, 3) of the pixels; sums of lights add up, but not where the look-up is outside the sum."""
    count = len(lights.direction)
    step = count if shade.scene.lookup == "outgoing" else _LIGHTS_OF_A_STEP
    value = np.zeros((len(row), 3))
    for start in range(0, count, step):
        part = slice(start, start + step)
        value += shade(row, column, DistantLights(lights.direction[part], lights.irradiance[part]))[:, :3]
        yield Step(min(start + step, count) / count, "Measuring the error of the directions")
    return value


def _relative(shown: NDArray[np.float64], dense_sum: NDArray[np.float64]) -> float:
    size = float(np.linalg.norm(dense_sum))
    return float(np.linalg.norm(shown - dense_sum)) / size if size > 0.0 else 0.0
