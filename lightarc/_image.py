"""The image that the library returns: an array that a notebook shows."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from engine.images.encode import encode_png
from engine.render.display import Display, display


class Image(np.ndarray[Any, Any]):
    """An image (height, width, 4) of linear sRGB radiance times coverage, and coverage; a float32 array.

    It is an array in every respect. A notebook shows it tone-mapped, and `repr` says what it is in one line.
    """

    def __repr__(self) -> str:
        if self.ndim != 3:
            return np.ndarray.__repr__(self.view(np.ndarray))
        height, width, channels = self.shape
        return f"Image({width} × {height} pixels, {channels} channels, {self.dtype})"

    def _repr_png_(self) -> bytes | None:
        """Return the image as PNG for a notebook; None for what is none, as a single row of it."""
        if self.ndim != 3 or self.shape[2] not in (3, 4) or not self.size:
            return None
        values = np.asarray(self, np.float32)
        if values.shape[2] == 3:
            values = np.concatenate([values, np.ones_like(values[..., :1])], axis=2)
        with np.errstate(all="ignore"):
            return encode_png(display(np.nan_to_num(values), Display()))


def as_shown(values: ArrayLike) -> Image:
    """Return an array as an `Image`; the pixels are not copied."""
    return np.asarray(values).view(Image)
