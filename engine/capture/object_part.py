"""The object of a stack before a black background, for maps that are looked up by the mean of photographs.

What lies around an object changes the mean of photographs and their errors, by which a representation is chosen. A
stack of the object alone shows black texels outside its mask and none of them clipped, and its means are those of such
photographs. Errors over all texels are then too small by the root of the share of the object (`object_share`).
Cost: one reading of the photographs; texels in files stay there and are masked as they are read.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.mask import Mask, mask_of
from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.storage.file_array import FileArray, Piece

#: The key of the share of the object in the provenance of a stack that shows it alone.
SHARE = "object_share"

#: Rows of a photograph that are read at once.
ROWS = 256


@dataclass(frozen=True, eq=False)
class _MaskedFile(FileArray):
    """Planes of another array in a file (`of`) that are read as 0 where `mask` (H, W) is False."""

    of: FileArray | None = None
    mask: Mask | None = None

    @property
    def is_there(self) -> bool:
        return self.of is not None and self.of.is_there

    def fill(self, pieces: Sequence[Piece]) -> None:
        assert self.of is not None
        assert self.mask is not None
        self.of.fill(pieces)
        for row, into in pieces:
            first = row % self.shape[1]
            into[~self.mask[first : first + len(into)]] = 0


def take_object(stack: ImageStack, *, to_tile: bool = False) -> Steps[tuple[ImageStack, Mask | None, Health]]:
    """The stack of the object alone, its mask (H, W), and a finding; the stack as it is where it has no mask.

    A tile repeats all of the sample: where one is to be made (`to_tile`), nothing is masked, and the finding says so.
    """
    mask = mask_of(stack)
    if mask is None or mask.all():
        return stack, None, Health()
    if to_tile:
        text = "A tile shows all of the sample: the mask of the object is not used"
        return stack, None, Health(findings=(Finding(Verdict.NOTE, text),))
    share = float(mask.mean())
    radiance, saturated = (_hide(array, mask) for array in (stack.radiance, stack.saturated))
    diffuse = None if stack.diffuse is None else _hide(stack.diffuse, mask)
    count, height, width = stack.radiance.shape[:3]
    means = np.zeros(count)
    for place in range(count):
        yield Step(place / count, "leaving the background out")
        for first in range(0, height, ROWS):
            band = np.asarray(radiance[place, first : first + ROWS])
            means[place] += float(band.sum(axis=(0, 1), dtype=np.float64) @ LUMINANCE) / (height * width)
    provenance = MappingProxyType({**stack.provenance, SHARE: share})
    taken = replace(
        stack,
        radiance=radiance,
        saturated=saturated,
        diffuse=diffuse,
        mean_radiance=means,
        provenance=provenance,
    )
    text = f"Fitted to the object alone, {percent(share)} of the image: the background is transparent"
    return taken, mask, Health(findings=(Finding(Verdict.NOTE, text),))


def object_share(stack: ImageStack) -> float:
    """Share of the texels of a stack that are not black for being background."""
    share = stack.provenance.get(SHARE)
    return float(share) if isinstance(share, float) and 0.0 < share <= 1.0 else 1.0


def object_mask(stack: ImageStack) -> Mask | None:
    """(H, W) True for texels of the object of a stack that shows it alone; None for another."""
    return mask_of(stack) if object_share(stack) < 1.0 else None


def _hide(array: NDArray[Any] | FileArray, mask: Mask) -> NDArray[Any] | FileArray:
    if isinstance(array, FileArray):
        own = {each.name: getattr(array, each.name) for each in fields(FileArray)}
        return _MaskedFile(**own, of=array, mask=mask)
    shown = mask.reshape(1, *mask.shape, *(1,) * (array.ndim - 3))
    return np.asarray(np.where(shown, array, np.zeros((), array.dtype)))
