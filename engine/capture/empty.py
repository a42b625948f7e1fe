"""Photographs that show nothing of the sample: black ones, whose lamp did not light, and ones clipped all over.

Both claims are relative to the other photographs, so that a capture that is dark as a whole, a lamp at grazing
elevation and a glossy sample lose nothing. On a flat sample the brightest pixels of a photograph go with the sine of
the lamp's elevation, and relief or gloss make them brighter still at grazing ones: of generated captures down to 1° and
of real domes no photograph had less than a third of what the others lead to expect by that law.

Cost: none worth mentioning, on images of at most 256 pixels along a side.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.core.colour import LUMINANCE
from engine.core.figure_text import percent

#: The share of the light to expect below which a photograph may be black, and what its brightest pixels then are at
#: most: an 8-bit code of 6, or so many standard deviations of its noise.
DARK, BLACK, OF_NOISE = 1.0 / 20.0, 1.0 / 512.0, 5.0

#: The share of the lit pixels that are clipped in a photograph that is clipped all over, and in the usual one at most.
CLIPPED, USUAL = 0.9, 0.25

#: A pixel is lit whose median over all photographs has this share of that of the brightest ones.
LIT = 1.0 / 50.0

#: The percentile that stands for the brightest pixels, and the least elevation that the law is asked for.
BRIGHTEST, GRAZING_DEG = 99.9, 1.0


def empty(
    images: Sequence[NDArray[np.float32]],
    clipped: Sequence[NDArray[np.float32]],
    noise: Sequence[float],
    elevation: NDArray[np.float64],
) -> dict[int, tuple[str, str]]:
    """The problem of each photograph that shows nothing, and what to do, by its place in the list.

    Parameters
    ----------
    images, clipped : small images of all N photographs (h, w, 3), linear, and the share of clipped pixels (h, w)
        in each of their pixels. noise : (N,) its standard deviation in each photograph, in the units of `images`.
    elevation : (N,) of their lamps above the sample, in radians.
    """
    luminance = np.stack([image @ np.asarray(LUMINANCE, np.float32) for image in images])
    brightest = np.percentile(luminance.reshape(len(images), -1), BRIGHTEST, axis=1)
    expected = np.sin(np.maximum(elevation, np.radians(GRAZING_DEG)))
    expected *= float(np.median(brightest / expected))
    usual = np.median(luminance, axis=0)
    lit = usual >= LIT * np.percentile(usual, BRIGHTEST)
    shares = np.array([float(of_one[lit].mean()) for of_one in clipped])
    found = {}
    for place, (light, wanted, share) in enumerate(zip(brightest, expected, shares, strict=True)):
        if light < DARK * wanted and light < max(BLACK, OF_NOISE * noise[place]) and wanted > BLACK:
            part = percent(max(float(light), 0.0) / float(wanted))
            problem = f"is black, with {part} of the light in its brightest pixels that the others lead to expect"
            found[place] = problem, "Check that its lamp lit, and photograph it again"
        elif share > CLIPPED and float(np.median(shares)) < USUAL:
            problem = (
                f"is overexposed, with {percent(share)} of its lit pixels clipped where others have "
                f"{percent(float(np.median(shares)))}"
            )
            found[place] = problem, "Photograph it again with a shorter exposure"
    return found
