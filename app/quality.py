"""How finely to draw next, learnt from what frames have cost so far.

A frame has evaluations: sub-pixels times lights. Coarser frames have fewer pixels and, under an environment, fewer
lights, each of which then stands for a larger region (`engine.light_tree`). No graphics card is asked what it is: a
fast one reaches the finest level within the first frames.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from engine.scene import Scene

#: How long a frame may hold up the window's thread, and how long one piece of a finer picture may.
MOVING_S, PIECE_S = 0.03, 0.03

#: How long a finer picture may take altogether, in pieces: while a heavy job runs, and when none does.
STILL_S, IDLE_S = 0.3, 60.0

#: A frame has at most so many times the evaluations of one whose cost is known.
STEP = 5

#: How much more a piece of the picture may cost than the average one, which shows background as well.
DENSE = 2.5


@dataclass(frozen=True)
class Quality:
    """Sub-pixels along a side of a pixel; pixels along a side that share one; lights of which one is drawn."""

    samples: int
    reduction: int = 1
    fewer: int = 1

    @property
    def is_coarse(self) -> bool:
        """Whether it has fewer pixels than the screen, or fewer lights than the scene."""
        return self.reduction > 1 or self.fewer > 1

    def evaluations(self, pixels: int, lights: int) -> int:
        """Of a picture with so many pixels on screen."""
        return round(max(1, pixels * self.samples**2 // self.reduction**2) * max(1.0, lights / self.fewer))

    def of(self, scene: Scene) -> Scene:
        """`scene` with the lights of this quality; round lamps are single directions where there are to be fewer."""
        if self.fewer == 1:
            return scene
        fewer = max(1, scene.directions // self.fewer) if scene.environment is not None else scene.directions
        return replace(scene, directions=fewer, lamps=tuple(replace(lamp, radius=0.0) for lamp in scene.lamps))


#: From best to quickest: under one light, and under many.
ONE_LIGHT = tuple(Quality(*at) for at in ((2, 1), (1, 1), (1, 2), (1, 3), (1, 4), (1, 6), (1, 9)))
MANY_LIGHTS = (*ONE_LIGHT[:5], *(Quality(1, *at) for at in ((4, 4), (6, 4), (6, 16), (9, 16), (9, 64))))


class Cost:
    """What frames of one kind of scene have taken, by their evaluations."""

    def __init__(self) -> None:
        self._seconds: dict[int, float] = {}
        self._kind: tuple[object, ...] = ()

    def about(self, *kind: object) -> None:
        """What is drawn from now on; everything learnt is forgotten when it is something else."""
        if len(kind) != len(self._kind) or any(new is not old for new, old in zip(kind, self._kind, strict=True)):
            self._kind = kind
            self._seconds.clear()

    @property
    def is_new(self) -> bool:
        """Whether nothing is known: the next frame compiles its shader first, which says nothing of frames."""
        return not self._seconds

    def learn(self, evaluations: int, seconds: float, pieces: int = 1) -> None:
        """A frame of so many `evaluations` took `seconds`, in `pieces` of which each draws all triangles anew."""
        again = (pieces - 1) * min(self._seconds.values(), default=0.0)
        self._seconds[evaluations] = max(seconds - again, seconds / pieces)

    def predicted(self, evaluations: int) -> float:
        """Seconds that a frame will take: between those that are known, or in proportion to the largest of them."""
        if not self._seconds:
            return float("inf")
        known = sorted(self._seconds)
        beyond = max(1.0, evaluations / known[-1])
        return float(np.interp(evaluations, known, [self._seconds[at] for at in known])) * beyond

    def best(self, levels: tuple[Quality, ...], pixels: int, lights: int, budget_s: float) -> int:
        """The finest of `levels` that fits `budget_s` and is not a leap; the last where none does."""
        most = STEP * max(self._seconds, default=0)
        for at, level in enumerate(levels):
            evaluations = level.evaluations(pixels, lights)
            if evaluations <= most and self.predicted(evaluations) <= budget_s:
                return at
        return len(levels) - 1

    def rows(self, evaluations: int, height: int) -> int:
        """How many of `height` rows a first piece of a picture of so many `evaluations` should have."""
        fixed_s = min(self._seconds.values(), default=0.0)
        whole_s = max(self.predicted(evaluations) - fixed_s, 1e-6)
        if not np.isfinite(whole_s):
            return 1
        return int(np.clip(height * max(PIECE_S - fixed_s, PIECE_S / 3) / (DENSE * whole_s), 1, height))


def next_rows(rows: int, seconds: float, first: int) -> int:
    """Rows of the piece after one of `rows` that took `seconds`: fewer where it was late, more where it was early."""
    if seconds > PIECE_S:
        return max(1, int(rows * PIECE_S / seconds))
    return min(round(1.5 * rows + 0.5), 3 * first) if seconds < PIECE_S / 2 else rows
