"""Correction of photographs for what was estimated of a rig: room light, intensities of lamps, and their distance.

    radiance = (photograph - room light) / gain * near-lamp gain

Room light is a share of the mean photograph. That share follows from the normals of small photographs and is enlarged,
so that the detail of the reflectance is that of the photographs themselves.
Cost: for 24 megapixels 0.3 s a photograph; with room light each is read once more.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from engine.capture.calibration.rig import Array, Kind, Rig, Sample, fit
from engine.capture.photograph.calibrate import near_lamp_gain
from engine.core.kernels import serial_kernels
from engine.core.one_thread import one_thread
from engine.core.side_by_side import side_by_side
from engine.core.steps import Step, Steps
from engine.storage.scratch import release, scratch_array

_BAND_ROWS = 128

#: Function from the first row and the one after the last to radiance (rows, W, 3), for several threads at once.
Take = Callable[[int, int], NDArray[np.float32]]

#: Longer side in which the share of room light is found, and texels that are solved at once.
_SHARE_SIDE, _AT_ONCE = 160, 2048


@dataclass(frozen=True, eq=False)
class Correction:
    """What photographs are corrected for.

    Attributes
    ----------
    gains : (N,) intensity of each lamp.
    nearness : inverse of the distance of lamps in widths of the image.
    elevation, azimuth : (N,) of the lamps, radians.
    room : (H, W, 3) radiance by room light as the reference shows it, or None.
    matrix : (N, 3, 3) from pixels of the reference to those of each photograph, None where all show the same.
    """

    gains: Array
    nearness: float
    elevation: Array
    azimuth: Array
    room: NDArray[np.float32] | None = None
    matrix: Array | None = None

    def apply(self, index: int, radiance: NDArray[np.float32], first: int, height: int) -> None:
        """Correct rows of photograph number `index` in place: `radiance` (rows, W, 3) from the row `first` of `height`.

        Where the camera moved, and there is room light, all rows at once are cheaper than many times some.
        """
        room = self.room
        if room is not None and self.matrix is not None and not np.array_equal(self.matrix[index], np.eye(3)):
            room = _warp(room, np.linalg.inv(self.matrix[index]))
        for start in range(0, len(radiance), _BAND_ROWS):
            band = radiance[start : start + _BAND_ROWS]
            rows = (first + start, first + start + len(band))
            if room is not None:
                band -= room[slice(*rows)]
                np.maximum(band, 0.0, out=band)
            if self.nearness > 0.0:
                angles = float(self.elevation[index]), float(self.azimuth[index])
                factor = near_lamp_gain(height, band.shape[1], 1.0 / self.nearness, *angles, rows)
                factor *= np.float32(1.0 / self.gains[index])
                band *= factor[..., None]
            elif self.gains[index] != 1.0:
                band *= np.float32(1.0 / self.gains[index])
        if self.room is not None:
            release(self.room)


def room_share(
    photographs: Sequence[NDArray[np.float32]], directions: Array, rig: Rig, kind: Kind = "matte"
) -> NDArray[np.float32]:
    """(h, w, 3) share of room light in the mean of small photographs (h, w, 3) under lamps in `directions` (N, 3).

    `kind` is the model of a texel by which the colour of the room light is found.
    """
    height, width = photographs[0].shape[:2]
    scale = min(1.0, _SHARE_SIDE / max(height, width))
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    small = np.stack([cv2.resize(each, size, interpolation=cv2.INTER_AREA) for each in photographs], axis=2)
    values = small.reshape(-1, len(photographs), 3).astype(np.float64)
    columns, rows = (each.ravel() for each in np.meshgrid(np.arange(size[0]), np.arange(size[1])))
    positions = np.stack([(columns + 0.5) / size[0] - 0.5, (0.5 * size[1] - 0.5 - rows) / size[0]], axis=1)
    share = np.empty((len(values), 3))
    with one_thread(), serial_kernels():
        every = slice(None, None, {"matte": 8, "glossy": 32}[kind])
        room = [_fit(values[:, :, band], positions, directions, rig, every, kind)[1] for band in range(3)]
        for first in range(0, len(values), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            normals, _ = _fit(values.mean(axis=2), positions, directions, rig, part)
            for band, ambient in enumerate(room):
                share[part, band] = normals @ ambient
    return np.clip(share, 0.0, 0.95).astype(np.float32).reshape(size[1], size[0], 3)


def _fit(
    values: Array, positions: Array, directions: Array, rig: Rig, part: slice, kind: Kind | None = None
) -> tuple[Array, Array]:
    """Albedo times normal over the mean, and the room light, which is fitted to the values where a `kind` is given."""
    some = values[part]
    mean = np.maximum(some.mean(axis=1), 1e-9)
    sample = Sample(some / mean[:, None], some > 0.0, positions[part], mean, np.zeros(len(some), np.int64))
    found = fit(sample, directions, ("ambient",) if kind else (), rig, kind or "matte")
    return found.albedo_normals, found.rig.ambient


def _warp(image: NDArray[np.float32], matrix: Array) -> NDArray[np.float32]:
    """`image` as a camera sees it whose pixels `matrix` takes to those of the image."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = image.shape[1::-1]
    return cv2.warpPerspective(image, matrix, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def room_light(
    photographs: Sequence[Take],
    share: NDArray[np.float32],
    size: tuple[int, int],
    matrix: Array | None = None,
) -> Steps[NDArray[np.float32]]:
    """(H, W, 3) radiance by room light, from whole photographs and its share in their mean.

    Each of `photographs` gives (rows, W, 3) from one row up to another; `size` is their height and width.
    """
    height, width = size
    room, count = scratch_array((height, width, 3), np.float32), np.float32(len(photographs))
    bands = [(first, min(first + _BAND_ROWS, height)) for first in range(0, height, _BAND_ROWS)]

    def add_all(rows: tuple[int, int]) -> None:
        for take in photographs:
            room[slice(*rows)] += take(*rows) / count

    if matrix is None:
        with closing(side_by_side(add_all, bands)) as added:
            for done, _ in enumerate(added):
                yield Step(done / len(bands), "Separating the room light")
                release(room)
    else:
        for index, (take, moved) in enumerate(zip(photographs, matrix, strict=True)):
            yield Step(index / len(photographs), "Separating the room light")
            seen = _warp(take(0, height), moved)
            for rows in bands:
                room[slice(*rows)] += seen[slice(*rows)] / count
                release(room)
    enlarged = cv2.resize(share, (width, height), interpolation=cv2.INTER_LINEAR)
    for rows in bands:
        room[slice(*rows)] *= enlarged[slice(*rows)]
    return room
