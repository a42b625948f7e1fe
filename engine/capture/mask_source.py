"""The mask of a capture from a file, from the alpha of the photographs, or from an outline that was drawn.

It is drawn on a photograph, so it goes the way of the photograph that the others are aligned to.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from engine.capture.mask import Mask
from engine.capture.object_outline import ObjectOutline
from engine.capture.output_region import View
from engine.capture.registration.warp import warp
from engine.core.errors import InputError, UsageError
from engine.images.decode import read_image
from engine.storage.untrusted import decode_in_child

#: Value of the setting that takes the alpha of the photographs.
ALPHA = "alpha"


def read_mask(source: Path | ObjectOutline, is_alpha: bool, size: tuple[int, int], view: View) -> Mask:
    """(H, W) True where an image, or an outline, shows the object, in the pixels that a stack shows.

    The object is white, or opaque where `is_alpha`, or inside the outline. `size` is the height and width of the
    photographs. Raises InputError for an image of another size, without an alpha channel, or that leaves nothing, and
    UsageError for an outline that leaves nothing.
    """
    if isinstance(source, ObjectOutline):
        filled = np.zeros(size, np.uint8)
        points = np.rint(16.0 * np.asarray(source.points)).astype(np.int32)
        cv2.fillPoly(filled, [points], 1, shift=4)
        mask = _project(filled > 0, size, view)
        if not mask.any():
            raise UsageError("the outline of the object leaves nothing of the photographs; draw it around the object")
        return mask
    path = source
    if is_alpha:
        values = decode_in_child("engine.images.decode:decode_alpha", path)["alpha"]
    else:
        values = read_image(path, transfer="linear").pixels
        values = values.reshape(*values.shape[:2], -1).mean(axis=2)
    if values.shape[:2] != size:
        own, theirs = (f"{width} × {height}" for height, width in (values.shape[:2], size))
        problem = f"is a mask of {own} pixels for photographs of {theirs}"
        raise InputError(path, problem, "Draw the mask on one of the photographs")
    mask = _project(np.asarray(values > 0.5 * float(values.max(initial=0.0))), size, view)
    if not mask.any():
        raise InputError(path, "is a mask that leaves nothing of the photographs", "Draw the object white")
    return mask


def _project(drawn: Mask, size: tuple[int, int], view: View) -> Mask:
    """A mask in pixels of the photographs as the stack shows it."""
    image = np.repeat(np.asarray(drawn, np.float32)[..., None], 3, axis=2)
    found, _ = warp(image, np.zeros(size, np.bool_), view.matrix, view.region, samples=view.samples)
    return np.asarray(found[..., 0] > 0.5)
