"""Distortion of a lens, found on photographs of a chessboard, and taken off photographs.

The model is OpenCV's (Brown1971): a point at x, y of the image plane, r² = x² + y², is seen at

    x (1 + k1 r² + k2 r⁴ + k3 r⁶) + 2 p1 x y + p2 (r² + 2 x²),   and y with p1 and p2 exchanged.

`cv2.calibrateCamera` (Zhang2000) fits it to boards in several positions. Photographs keep their size and the scale of
their middle; what a photograph does not show is marked as clipped. Weights are bilinear, which make no light.

The database of Lensfun would know some lenses by name; what it knows is of another copy of the lens, at distances and
focal lengths between which it interpolates, so that a board is asked for.
Cost: 0.05 s for a megapixel.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.capture.photograph.decode import ReadAhead
from engine.core.colour import luminance, to_display8
from engine.core.errors import InputError
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps
from engine.storage.atomic import write_bytes
from engine.storage.text import utf8
from engine.storage.untrusted import decode_in_child

#: Photographs of a board that are needed, and the largest residual of its corners in pixels.
MIN_BOARDS, MAX_RESIDUAL_PX = 5, 1.0

#: Part of the half diagonal of the image that corners of boards have to reach: beyond them, nothing is known.
MIN_REACH = 0.6

#: Corners along the sides of the smallest board, and the longest side of the image in which a board is looked for.
_SMALLEST, _SIDE = (5, 4), 2000

_BAND_ROWS = 128
_LIMIT_BYTES = 1 << 16

#: Displacement over the width of an image beyond which no lens is believed.
_MAX_SHIFT = 0.25


@dataclass(frozen=True, eq=False)
class Lens:
    """Distortion of a lens in photographs of one size.

    Attributes
    ----------
    width, height : of the photographs, pixels.
    camera : focal lengths and middle (fx, fy, cx, cy), pixels.
    distortion : k1, k2, p1, p2, k3.
    residual_px : root mean square of the corners of boards.
    boards : photographs of boards that were used.
    """

    width: int
    height: int
    camera: tuple[float, float, float, float]
    distortion: tuple[float, float, float, float, float]
    residual_px: float
    boards: int

    def distort(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[Any, Any]:
        """Positions in a photograph of points of the image without distortion, both in pixels."""
        fx, fy, cx, cy = self.camera
        k1, k2, p1, p2, k3 = self.distortion
        u, v = (x - cx) / fx, (y - cy) / fy
        r2 = u * u + v * v
        radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
        across = u * radial + 2.0 * p1 * u * v + p2 * (r2 + 2.0 * u * u)
        down = v * radial + p1 * (r2 + 2.0 * v * v) + 2.0 * p2 * u * v
        return fx * across + cx, fy * down + cy

    def largest_shift_px(self) -> float:
        """The largest distance by which the lens moves a point of the image's border."""
        x = np.concatenate([np.linspace(0, self.width - 1, 33)] * 2 + [np.zeros(33), np.full(33, self.width - 1.0)])
        y = np.concatenate([np.zeros(33), np.full(33, self.height - 1.0)] + [np.linspace(0, self.height - 1, 33)] * 2)
        shown = self.distort(x, y)
        return float(np.hypot(shown[0] - x, shown[1] - y).max())

    def straighten(
        self, radiance: NDArray[np.float32], saturated: NDArray[np.bool_]
    ) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
        """A photograph (H, W, 3) and its saturation mask (H, W) without the distortion."""
        height, width = saturated.shape
        straight, mask = np.empty_like(radiance), np.empty_like(saturated)
        clipped = saturated.astype(np.uint8)
        for first in range(0, height, _BAND_ROWS):
            rows = np.arange(first, min(first + _BAND_ROWS, height), dtype=np.float64)
            found = self.distort(*np.meshgrid(np.arange(width, dtype=np.float64), rows))
            x, y = (np.asarray(each, np.float32) for each in found)
            band = np.s_[first : first + len(rows)]
            cv2.remap(radiance, x, y, cv2.INTER_LINEAR, dst=straight[band], borderMode=cv2.BORDER_REPLICATE)
            touched = [
                cv2.remap(clipped, np.floor(x) + i, np.floor(y) + j, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE)
                for i in (0, 1)
                for j in (0, 1)
            ]
            outside = (x < 0.0) | (y < 0.0) | (x > width - 1.0) | (y > height - 1.0)
            mask[band] = np.any(touched, axis=0) | outside
        return straight, mask

    def as_json(self) -> dict[str, Any]:
        """Return the record, which is also the content of a `.lens` file."""
        return {
            "lightarc_lens": 1,
            "width_px": self.width,
            "height_px": self.height,
            "camera_px": list(self.camera),
            "distortion": list(self.distortion),
            "residual_px": self.residual_px,
            "boards": self.boards,
        }

    def text(self) -> str:
        """Return a sentence for the user."""
        return (
            f"The lens moved points by up to {number(self.largest_shift_px(), 2)} px, which was taken off "
            f"({self.boards} photographs of a board, residual {number(self.residual_px, 2)} px)"
        )


def measure_lens(paths: Sequence[Path], place: Path, options: dict[str, Any]) -> Steps[Lens]:
    """The lens that took photographs of a chessboard, read with `options` of `read_photograph`.

    Raises InputError about `place` for too few boards, or such that do not tell the distortion.
    """
    images = []
    with closing(ReadAhead(paths, **options)) as ahead:
        for index, path in enumerate(paths):
            photograph = yield from ahead.next_photograph(index / len(paths), f"Looking for the board in {path.name}")
            grey = luminance(photograph.radiance)
            images.append(to_display8(grey / max(float(np.quantile(grey, 0.98)), 1e-9)))
    yield Step(1.0, "Measuring the lens")
    if len({image.shape for image in images}) > 1:
        raise InputError(place, "holds photographs of different sizes", "Give those of one camera and lens")
    return lens_of_boards(images, place)


def lens_of_boards(images: Sequence[NDArray[np.uint8]], place: Path) -> Lens:
    """The lens of photographs (H, W) of a chessboard, in 8-bit levels; InputError as `measure_lens`."""
    found = [each for each in map(_find_corners, images) if each is not None]
    if len(found) < MIN_BOARDS:
        problem = f"shows a chessboard in {len(found)} photographs only"
        remedy = f"Photograph a flat board of 6 × 5 squares or more, whole and sharp, in {MIN_BOARDS} tilted positions"
        raise InputError(place, problem, remedy)
    height, width = images[0].shape
    middle = np.array([0.5 * (width - 1), 0.5 * (height - 1)])
    reach = max(float(np.hypot(*(corners - middle).T).max()) for _, corners in found) / float(np.hypot(*middle))
    if reach < MIN_REACH:
        problem = f"shows boards within {percent(reach)} of the way to the corners of the image only"
        raise InputError(place, problem, "Photograph the board near the edges of the image as well")
    grids = [grid.astype(np.float32) for grid, _ in found]
    shown = [corners.astype(np.float32) for _, corners in found]
    flags = cv2.CALIB_FIX_K3
    residual, camera, distortion, *_ = cv2.calibrateCamera(grids, shown, (width, height), None, None, flags=flags)
    matrix, numbers = np.asarray(camera, np.float64), np.asarray(distortion, np.float64).ravel()[:5]
    focal = (float(matrix[0, 0]), float(matrix[1, 1]), float(matrix[0, 2]), float(matrix[1, 2]))
    k1, k2, p1, p2, k3 = (float(value) for value in numbers)
    lens = Lens(width, height, focal, (k1, k2, p1, p2, k3), float(residual), len(found))
    if not residual <= MAX_RESIDUAL_PX or not lens.largest_shift_px() <= _MAX_SHIFT * width:
        problem = (
            f"does not determine the lens: corners of the boards are {number(float(residual), 2)} px from the model"
        )
        raise InputError(place, problem, "Use a flat board, sharp photographs, and one setting of focus and zoom")
    return lens


def _find_corners(image: NDArray[np.uint8]) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """The corners (K, 3) of a chessboard in its own plane, in squares, and in the image (K, 2); None without one."""
    scale = min(1.0, _SIDE / max(image.shape))
    small = image if scale == 1.0 else cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    flags = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    try:
        is_found, corners, meta = cv2.findChessboardCornersSBWithMeta(small, _SMALLEST, flags)
    except cv2.error:
        return None
    if not is_found or corners is None or meta is None:
        return None
    rows, columns = meta.shape[:2]
    if rows * columns != len(corners):
        return None
    at = np.asarray(corners, np.float64).reshape(-1, 2)
    x, y = np.meshgrid(np.arange(columns), np.arange(rows))
    grid = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return grid, (at + 0.5) * [image.shape[1] / small.shape[1], image.shape[0] / small.shape[0]] - 0.5


class _File(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    lightarc_lens: Literal[1]
    width_px: int = Field(ge=8, le=1 << 17)
    height_px: int = Field(ge=8, le=1 << 17)
    camera_px: tuple[float, float, float, float]
    distortion: tuple[float, float, float, float, float]
    residual_px: float = Field(ge=0, le=1000)
    boards: int = Field(ge=0, le=100_000)


def save_lens(path: str | os.PathLike[str], record: dict[str, Any]) -> None:
    """Write the record of a lens to a `.lens` file; OutputError where it cannot be written."""
    write_bytes(Path(path), (json.dumps(record, indent=1, allow_nan=False) + "\n").encode())


def read_lens(path: Path) -> Lens:
    """The lens of a `.lens` file; InputError for anything else."""
    decoder, process = "engine.capture.photograph.lens:decode_lens", "engine.capture.photograph.decode"
    record = decode_in_child(decoder, path, limit_bytes=_LIMIT_BYTES, process=process)["record"]
    lens = Lens(
        record["width_px"],
        record["height_px"],
        tuple(record["camera_px"]),
        tuple(record["distortion"]),
        record["residual_px"],
        record["boards"],
    )
    fx, fy, cx, cy = lens.camera
    is_possible = fx > 0.1 * lens.width and fy > 0.1 * lens.width and 0 < cx < lens.width and 0 < cy < lens.height
    if not is_possible or not lens.largest_shift_px() <= _MAX_SHIFT * lens.width:
        raise InputError(path, "states a distortion that no lens has", "Write it again with --write-lens")
    return lens


def decode_lens(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: the checked `record`."""
    try:
        return {"record": _File.model_validate_json(utf8(content)).model_dump(mode="json")}
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        problem = f"does not hold a lens as Lightarc writes it: {first['msg'][:200]}"
        raise InputError(name, problem, "Write it again with --write-lens") from None
