"""Visibility that travels with the chunks of a bake: from its record to the workers of a cluster, and back to it.

A task brings the blocks of the record that its vertices lie in, where the record has them; otherwise its result brings
what the worker found, and the record gets each block once all its vertices are there. A vertex takes 0.5 to 0.7 kB over
a cube map of an edge of 64, which is 7 µs of a gigabit's connection and 25 of a core in place of 2 to 3 ms of rays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.transport.baking.chunks import Chunk, Make
from engine.transport.baking.visibility import Receivers
from engine.transport.baking.visibility_record import (
    Counts,
    Indices,
    VisibilityRecord,
    block_size,
    pack_block,
    unpack_block,
)

#: Number of a chunk, and the packed blocks of the record that its vertices lie in: none where it lacks one of them, and
#: None where there is no record.
Task = tuple[int, Mapping[int, bytes] | None]


class Carrier:
    """Puts visibility into the tasks of a bake, and takes it out of their results.

    `bounds` (chunks + 1,) are the first vertices of the chunks, and the end; `edge` and `fine` are of the cube map.
    """

    def __init__(self, of: Receivers, edge: int, fine: int, bounds: NDArray[np.int64]) -> None:
        self._record = of.record if isinstance(of.record, VisibilityRecord) else None
        self._edge, self._fine, self._bounds, self._vertices = edge, fine, bounds, len(of)
        self._parts = dict[int, dict[int, Counts]]()

    @property
    def sizes(self) -> NDArray[np.int64]:
        """(chunks,) vertices of each chunk."""
        return np.diff(self._bounds)

    def load(self, chunk: int) -> Task:
        """The task of a chunk."""
        if self._record is None:
            return chunk, None
        size = block_size(self._edge)
        numbers = range(int(self._bounds[chunk]) // size, -(-int(self._bounds[chunk + 1]) // size))
        return chunk, self._record.take(self._edge, self._fine, numbers)

    def unload(self, chunk: Chunk) -> None:
        """Keep what a worker found; nothing where the chunk came without."""
        if self._record is None or not chunk.seen:
            return
        start, stop = int(self._bounds[chunk.number]), int(self._bounds[chunk.number + 1])
        size = block_size(self._edge)
        counts = unpack_block(chunk.seen, stop - start, self._edge)
        for number in range(start // size, -(-stop // size)):
            first, last = number * size, min((number + 1) * size, self._vertices)
            parts = self._parts.setdefault(number, {})
            parts[max(first, start)] = counts[max(first, start) - start : min(last, stop) - start]
            if sum(map(len, parts.values())) == last - first:
                whole = np.concatenate([part for _, part in sorted(self._parts.pop(number).items())])
                self._record.put(self._edge, self._fine, number, pack_block(whole))


class CarriedRecord:
    """Record of the chunk that a worker makes (`visibility.Record`)."""

    def __init__(self) -> None:
        self._blocks: Mapping[int, bytes] | None = None
        self._found = b""

    def make(self, make: Make, task: Task) -> Chunk:
        """The chunk of a task, by what makes it from its number and asks this record."""
        (number, self._blocks), self._found = task, b""
        return replace(make(number), seen=self._found)

    def shares(
        self, of: Receivers, edge: int, _fine: int, vertices: Indices, find: Callable[[Indices], Counts]
    ) -> Iterator[tuple[Indices, Counts]]:
        """As `visibility_shares`; `vertices` are those of the chunk."""
        if self._blocks:
            size = block_size(edge)
            first = min(self._blocks) * size
            blocks = [
                unpack_block(data, min((number + 1) * size, len(of)) - number * size, edge)
                for number, data in sorted(self._blocks.items())
            ]
            yield vertices, np.concatenate(blocks)[vertices - first]
            return
        counts = find(vertices)
        if self._blocks is not None:
            self._found = pack_block(counts)
        yield vertices, counts


def carry(make_baker: Callable[[Receivers], Make], of: Receivers) -> Callable[[Any], Chunk]:
    """Maker of the chunks of tasks (`Carrier.load`) by a baker for the vertices `of`."""
    record = CarriedRecord()
    make = make_baker(replace(of, record=record))
    return lambda task: record.make(make, task)
