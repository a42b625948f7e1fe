"""Positions of photographs that arrive, by which a motion of the camera is seen while a capture is being taken.

Each photograph is aligned with the first one. Relief and highlights seem to move with the light, though, so that a
motion counts only where photographs of the nearest lamps show one too: of the positions that these tell, the middle one
is taken. Photographs that seem to have moved are looked at again once one of a nearer lamp is there. Where lamps are
unknown or the camera drifts, a position can be out by a third of itself: whether a photograph has moved is told by it,
and how far is not.

Bound by the alignments, each some 30 ms: one for a photograph that lies where the first does, four for another, and one
for each that seems to have moved and has the new photograph among those of its nearest lamps.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from engine.capture.decoded import Kept, Mark
from engine.capture.registration.align import align
from engine.capture.registration.texture import reduction
from engine.core.steps import drain

Array = NDArray[np.float64]

#: Pixels of the images that are compared from which on a photograph counts as moved, photographs of the nearest lamps
#: that are asked besides the first one, and pixels from which on a position is another one.
MOVES_PX, NEAREST, OTHER_PX = 2.0, 3, 0.5


class Positions:
    """By how many pixels photographs lie right of the first one and below it; a photograph is known by its `Mark`.

    One that is too unlike all others that are asked counts as not moved.
    """

    def __init__(self) -> None:
        self._kept: dict[Mark, Kept] = {}
        self._lamps: dict[Mark, Array] = {}
        self._positions: dict[Mark, Array] = {}
        self._shifts: dict[tuple[Mark, Mark], Array | None] = {}

    def follow(self, photographs: Mapping[Mark, Kept], lamps: Mapping[Mark, Array]) -> None:
        """Find the positions of those of the `photographs` that are new, in their order, or of all without the first.

        `lamps` are unit vectors (3,) towards the lamps that are known. Where a lamp has become known, as by a list that
        comes after its photographs, the positions of those that seem to have moved are found again.
        """
        first = next(iter(self._kept), None)
        for mark in self._kept.keys() - photographs.keys():
            self._forget(mark)
        if first not in self._kept:
            self._kept, self._positions = {}, {}
        before, self._lamps = self._lamps, dict(lamps)
        if any(not np.array_equal(before.get(mark, 0.0), lamps.get(mark, 0.0)) for mark in self._kept):
            self._find_again(self._kept)
        for mark, kept in photographs.items():
            if mark not in self._kept:
                self._kept[mark] = kept
                self._positions[mark] = self._find(mark)
                self._find_again([mark])

    def measure_px(self, mark: Mark) -> float:
        """The distance of a photograph from the first one; 0 where nothing tells of it."""
        return float(np.hypot(*self._positions[mark]))

    def _forget(self, mark: Mark) -> None:
        del self._kept[mark], self._positions[mark]
        self._shifts = {pair: shift for pair, shift in self._shifts.items() if mark not in pair}

    def _find_again(self, marks: Iterable[Mark]) -> None:
        """Find the positions of moved photographs again that depend on those of `marks`, and so on."""
        changed, left = deque(marks), [each for each in self._kept if self._is_far(self._positions[each], each)]
        while changed:
            one = changed.popleft()
            for other in [each for each in left if one in self._ask(each)]:
                position, before = self._find(other), self._positions[other]
                if np.hypot(*(position - before)) >= OTHER_PX:
                    self._positions[other] = position
                    left.remove(other)  # each changes once, as positions depend on each other
                    changed.append(other)

    def _is_far(self, position: Array, mark: Mark) -> bool:
        kept = self._kept[mark]
        return float(np.hypot(*position)) >= MOVES_PX * reduction(kept.height, kept.width)

    def _find(self, mark: Mark) -> Array:
        """The position (2,) that the first photograph and those of the nearest lamps tell: the first that is no motion,
        else the middle one."""
        positions: list[Array] = []
        for other in self._ask(mark):
            if (other, mark) not in self._shifts:
                self._shifts[other, mark] = find_shift(self._kept[other], self._kept[mark])
            if (shift := self._shifts[other, mark]) is None:
                continue
            positions.append(self._positions[other] + shift)
            if not self._is_far(positions[-1], mark):
                return positions[-1]
        if not positions:
            return np.zeros(2)
        apart = np.linalg.norm(np.array(positions)[:, None] - positions, axis=2)
        return positions[int(apart.sum(axis=1).argmin())]

    def _ask(self, mark: Mark) -> list[Mark]:
        """The first photograph, and those of the nearest lamps, or the latest where these are not known."""
        first, *others = self._kept
        if mark == first:
            return []
        others = [each for each in reversed(others) if each != mark]
        if mark in self._lamps:
            lamp = self._lamps[mark]
            others.sort(key=lambda each: -float(self._lamps[each] @ lamp) if each in self._lamps else 2.0)
        return [first, *others[:NEAREST]]


def find_shift(other: Kept, kept: Kept) -> Array | None:
    """Pixels (2,) by which a photograph lies right of another and below it; None where they are too unlike to say."""
    greys = [other.noted.grey, kept.noted.grey]
    if greys[0] is None or greys[1] is None or (other.width, other.height) != (kept.width, kept.height):
        return None
    factor = reduction(other.height, other.width)
    found = drain(align([greys[0], greys[1]], ["first", "second"], "translation", factor, 0))
    return np.asarray(found.matrix[1][:2, 2]) if found.aligned[1] else None
