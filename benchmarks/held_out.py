"""Error of directional maps under light from directions that no lamp of the capture had.

A simulated dome of `AZIMUTHS` × `ELEVATIONS` lamps is photographed with the noise of `NOISE`, 30 dB at the white level,
and relit from directions between its lamps, for which the simulator gives the truth. The limit is the same error of a
dome with about four times as many lamps and without noise, of which these directions are not lamps either: what is left
of it is that of interpolation and of the planes alone. Errors are root mean squares in codes of 8-bit sRGB.
Cost: some 20 s of CPU time for each sample.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Accuracy
from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE, srgb_encode
from engine.core.directions import surface_direction
from engine.core.steps import Step, Steps, part
from engine.shading.directional.planes import fit
from engine.simulate.arc import LightArc, Shot, dome_azimuths_deg, dome_elevations_deg
from engine.simulate.camera import with_noise
from engine.simulate.rig import Table, light_up, photograph, prepare

SAMPLES = ("woven", "hammered", "leather")
SIZE, AZIMUTHS, ELEVATIONS = 128, 8, 5

#: The dome of the limit: lamps between those of the other dome too.
DENSE = (2 * AZIMUTHS, 2 * ELEVATIONS - 1)

#: Steps of the dense dome, from one of its lamps, at which the directions lie that are held out.
BETWEEN = 0.5

#: 30 dB at the white level, and the largest error over the limit that is promised.
NOISE, OVER_LIMIT = 10.0 ** (-30.0 / 20.0), 1.5

Light = tuple[float, float]


def measure_held_out(_folder: Path) -> Steps[list[Accuracy]]:
    """The error of each sample over its limit; nothing is written."""
    found = []
    for index, name in enumerate(SAMPLES):
        start = index / len(SAMPLES)
        found.append((yield from part(_sample(name), start, start + 1.0 / len(SAMPLES))))
    return found


def _sample(name: str) -> Steps[Accuracy]:
    lamps, dense = _grid(AZIMUTHS, ELEVATIONS), _grid(*DENSE)
    wanted = _between()
    every = {*lamps, *dense, *wanted}
    elevation, azimuth = (tuple(sorted({light[axis] for light in every})) for axis in (0, 1))
    arc = LightArc(name, elevation=elevation, azimuth=azimuth, size=SIZE, noise=0.0, misalignment_px=0.0)
    table = yield from part(prepare(arc), 0.0, 0.2)
    bare = yield from part(_images(table, [(max(elevation), azimuth[0])]), 0.2, 0.22)
    gain = np.float32(0.9 / np.percentile(bare, 99.9))
    truth = gain * (yield from part(_images(table, wanted), 0.22, 0.3))
    clean = gain * (yield from part(_images(table, lamps), 0.3, 0.4))
    noisy = np.stack([with_noise(image, NOISE, (1, 2, at)) for at, image in enumerate(clean)])
    errors = {
        "rmse_srgb8": (yield from part(_error(noisy, lamps, truth, wanted), 0.4, 0.5)),
        "noise_free_rmse_srgb8": (yield from part(_error(clean, lamps, truth, wanted), 0.5, 0.6)),
    }
    many = gain * (yield from part(_images(table, dense), 0.6, 0.8))
    limit = yield from part(_error(many, dense, truth, wanted), 0.8, 1.0)
    lights = f"{AZIMUTHS} × {ELEVATIONS} lamps at 30 dB over {DENSE[0]} × {DENSE[1]} without noise"
    what = f"error of light from directions between lamps, {lights}"
    return Accuracy(
        f"held-out-{name}", errors["rmse_srgb8"] / limit, what, OVER_LIMIT, {**errors, "limit_rmse_srgb8": limit}
    )


def _grid(azimuths: int, elevations: int) -> list[Light]:
    """Elevation and azimuth (radians) of the lamps of a dome, by rising elevation."""
    around = [math.radians(each) for each in dome_azimuths_deg(azimuths)]
    return [(math.radians(up), azimuth) for up in dome_elevations_deg(elevations) for azimuth in around]


def _between() -> list[Light]:
    """Directions in the middle between lamps of the dense dome, around as many azimuths as the other dome has."""
    up, around = dome_elevations_deg(DENSE[1]), dome_azimuths_deg(DENSE[0])
    elevations = [low + BETWEEN * (high - low) for low, high in zip(up[1::2], up[2::2], strict=True)]
    azimuths = [each + BETWEEN * (around[1] - around[0]) for each in around[::2]]
    return [(math.radians(elevation), math.radians(azimuth)) for elevation in elevations for azimuth in azimuths]


def _images(table: Table, lights: Sequence[Light]) -> Steps[NDArray[np.float32]]:
    """(N, H, W, 3) the sample under each light, without noise."""
    images = []
    for at, (elevation, azimuth) in enumerate(lights):
        yield Step(at / len(lights), "lighting the sample")
        image = yield from light_up(table, elevation, azimuth)
        images.append(photograph(table, image, Shot("", elevation, azimuth, 1.0, 0.0, 0.0, 0.0)))
    return np.stack(images)


def _error(
    radiance: NDArray[np.float32], lights: Sequence[Light], truth: NDArray[np.float32], wanted: Sequence[Light]
) -> Steps[float]:
    """Root mean square in codes of the `truth` under the lights `wanted` as a map of the photographs shows it."""
    elevation, azimuth = (np.array(each) for each in zip(*lights, strict=True))
    radiance = np.clip(radiance, 0.0, 1.0)
    names, means = tuple(map(str, range(len(lights)))), radiance.mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE
    stack = ImageStack(radiance, np.zeros(radiance.shape[:3], np.bool_), elevation, azimuth, means, names, "")
    found = yield from fit(stack, np.arange(len(lights)))
    squares = []
    for image, (up, around) in zip(truth, wanted, strict=True):
        shown = found.image(surface_direction(0.5 * math.pi - up, around))
        squares.append(np.mean((_codes(shown) - _codes(image)) ** 2))
    return float(np.sqrt(np.mean(squares)))


def _codes(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(255.0 * srgb_encode(np.clip(radiance, 0.0, 1.0)), np.float32)
