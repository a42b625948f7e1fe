"""Error of a shading map against the photographs that it was made of, beside that of their mean image.

A shading map shows photographs of equal mean radiance alike, whatever their azimuth. Where that is not so, as with a
dome of lamps over a relief, it may be further from the photographs than one image that knows no light at all. Errors
are root mean squares over texels, channels and photographs, in codes of 8-bit sRGB, as tools for domes state them; on a
regular grid of at most 65,536 texels, of which alone the rows are read.
"""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.capture.report import bracket, grid_step
from engine.capture.stack import ImageStack
from engine.core.colour import srgb_encode
from engine.core.figure_text import number
from engine.core.health import Finding, Verdict
from engine.core.side_by_side import side_by_side
from engine.core.steps import Step, Steps
from engine.shading.shading_map import sample_slices

#: Share of the mean image's error from which a representation tells hardly more of the light than that image.
HARDLY_BETTER = 0.9

#: Photographs of which some are left out and the others still tell how the light changes them.
FEWEST = 4


@dataclass(frozen=True)
class Fidelity:
    """Errors in codes of 8-bit sRGB.

    Attributes
    ----------
    leave_one_out : of each photograph as the shading map of the others shows it, at its mean radiance.
    in_sample : of the shading map itself at their mean radiances.
    mean_picture : of the mean of the others in place of each; NaN where there is one photograph.
    photographs : their number.
    """

    leave_one_out: float
    in_sample: float
    mean_picture: float
    photographs: int

    @property
    def is_worse(self) -> bool:
        """True if the mean of the photographs shows them better; few photographs do not tell."""
        return self.photographs >= FEWEST and self.leave_one_out > self.mean_picture

    @property
    def is_no_better(self) -> bool:
        """True if the mean of the photographs shows them nearly as well, or better."""
        return self.photographs >= FEWEST and self.leave_one_out > HARDLY_BETTER * self.mean_picture

    def over(self, share: float) -> Fidelity:
        """The errors over this share of the texels, where all errors are."""
        root = float(np.sqrt(share))
        return replace(
            self,
            leave_one_out=self.leave_one_out / root,
            in_sample=self.in_sample / root,
            mean_picture=self.mean_picture / root,
        )

    def finding(self, knows: str = "brightness alone") -> Finding:
        """The verdict in words, on a representation that `knows` this of the light."""
        ours, mean = number(self.leave_one_out), number(self.mean_picture)
        text = f"held-out photographs: error {ours} 8-bit levels, of their mean image {mean}"
        if self.is_no_better:
            return Finding(Verdict.WARNING, f"{text}: {knows} does not distinguish these photographs")
        return Finding(Verdict.GOOD, text)


def fidelity(stack: ImageStack, used: NDArray[np.int64], slices: int) -> Steps[Fidelity]:
    """The errors of the shading map of so many `slices` of the photographs `used`; black ones do not count.

    That map is made of the texels of the grid alone. One of the photographs has a positive mean.
    """
    means = stack.mean_radiance[used]
    used, means = used[means > 0.0], means[means > 0.0]
    height, width = stack.radiance.shape[1:3]
    step = grid_step(height, width)
    rows, columns = slice(step // 2, height, step), slice(step // 2, width, step)
    radiance = np.empty((len(used), len(range(height)[rows]), len(range(width)[columns]), 3), np.float32)
    wanted = np.empty_like(radiance)

    def read(place: int) -> int:
        radiance[place] = stack.radiance[int(used[place]), rows, columns]
        wanted[place] = _codes(radiance[place])
        return place

    with closing(side_by_side(read, range(len(used)))) as places:
        for place in places:
            yield Step(0.5 * place / len(used), "comparing with the photographs")
    sampled = sample_slices(radiance, means, slices)
    order = np.argsort(means, kind="stable")
    mean = wanted.mean(axis=0, dtype=np.float64)

    def judge(place: int) -> tuple[float, float, float]:
        """Mean squares of the shading map, of that of the others, and of their mean image."""
        inside = _square(_codes(sampled.slice_image(float(means[place]))), wanted[place])
        others = [int(other) for other in order if other != place]
        if not others:
            return inside, 0.0, 0.0
        left = _square(_codes(bracket(radiance, means, others, float(means[place]))), wanted[place])
        return inside, left, _square(mean, wanted[place]) * (len(used) / (len(used) - 1)) ** 2

    squares = np.empty((3, len(used)))
    with closing(side_by_side(judge, range(len(used)))) as judged:
        for place, found in enumerate(judged):
            squares[:, place] = found
            yield Step(0.5 + 0.5 * place / len(used), "comparing with the photographs")
    inside, out, plain = np.sqrt(squares.mean(axis=1))
    alone = len(used) < 2
    return Fidelity(np.nan if alone else float(out), float(inside), np.nan if alone else float(plain), len(used))


def _codes(radiance: NDArray[np.float32]) -> NDArray[np.float32]:
    return np.asarray(255.0 * srgb_encode(np.clip(radiance, 0.0, 1.0)), np.float32)


def _square(one: NDArray[np.floating], other: NDArray[np.float32]) -> float:
    return float(np.mean((one - other) ** 2, dtype=np.float64))
