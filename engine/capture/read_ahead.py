"""Photographs one after the other: while one is worked on the next is decoded, and two while one is waited for.

Cost: as decoding on two cores; at most two photographs are in memory.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from engine.capture.decode import Photograph, Reading
from engine.files.untrusted import CHILDREN
from engine.steps import Step, Steps

#: How often a step is made while a photograph is waited for, in seconds.
PATIENCE_S = 0.05


class ReadAhead:
    """Reads `paths` in order, with the options of `read_photograph`; to be closed, which stops the decoders."""

    def __init__(self, paths: Sequence[Path], **options: Any) -> None:
        self._paths: Iterator[Path] = iter(paths)
        self._options = options
        self._readings: deque[Reading] = deque()
        for _ in range(CHILDREN):
            self._start_one()

    def _start_one(self) -> None:
        path = next(self._paths, None)
        if path is not None:
            self._readings.append(Reading(path, **self._options))

    def next_photograph(self, done: float, note: str) -> Steps[Photograph]:
        """The next photograph; while it is waited for there are steps that say `done` and `note`."""
        if len(self._readings) < CHILDREN:
            self._start_one()
        reading = self._readings[0]
        yield Step(done, note)
        while not reading.wait(PATIENCE_S):
            yield Step(done, note)
        photograph = reading.photograph()
        self._readings.popleft()
        return photograph

    def close(self) -> None:
        """Stop what is still being read."""
        for reading in self._readings:
            reading.close()
        self._readings.clear()
