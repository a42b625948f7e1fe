"""Visibility of the vertices of a bake at hand, compressed one by one, for work that asks in an order of its own.

A vertex takes some 0.5 kB of 6 × 64² counts, in memory or, of large models, in an unnamed file; it is written in 0.1 ms
of a core and read in 0.02.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass, replace

import imagecodecs
import numpy as np
from numpy.typing import NDArray

from engine.core.figure_text import count_text
from engine.core.steps import Step, Steps
from engine.storage.scratch import ScratchRows
from engine.transport.baking.visibility import Receivers, visibility_shares
from engine.transport.baking.visibility_record import VisibilityRecord, blocks, pack_block

Indices = NDArray[np.int64]

#: Effort of the compression: counts are none or all nearly everywhere.
LEVEL = 1

#: Vertices between two steps.
CHUNK = 256

#: A block whose visibility is wanted: its number, its vertices, and whether it is wanted as a record holds it as well.
Asked = tuple[int, Indices, bool]

#: The same found: its number, the packed counts of each vertex, and the block as a record holds it, or nothing.
Seen = tuple[int, list[bytes], bytes]

#: Finds the visibility of blocks, in any order.
Look = Callable[[Iterable[Asked]], Generator[Seen, None, None]]


@dataclass(frozen=True, eq=False)
class HeldVisibility:
    """Counts of the `fine`² parts of each texel of a cube map of `edge` that vertices see, `packed` by vertex."""

    edge: int
    fine: int
    packed: Mapping[int, bytes]

    def counts(self, vertices: Indices) -> NDArray[np.uint8]:
        """(B, 6 edge²) of `vertices` (B,), as `visibility_shares` gives them."""
        size = 6 * self.edge * self.edge
        found = np.empty((len(vertices), size), np.uint8)
        for row, vertex in zip(found, vertices.tolist(), strict=True):
            row[:] = np.frombuffer(imagecodecs.zstd_decode(self.packed[vertex], out=size), np.uint8)
        return found

    def choose(self, vertices: Indices) -> list[bytes]:
        """The packed counts of `vertices`."""
        return [self.packed[vertex] for vertex in vertices.tolist()]


def pack_rows(counts: NDArray[np.uint8]) -> list[bytes]:
    """Counts (B, 6 edge²) as `HeldVisibility` holds them, by vertex."""
    return [bytes(imagecodecs.zstd_encode(row, level=LEVEL)) for row in counts]


def merge_texels(counts: NDArray[np.uint8], edge: int) -> NDArray[np.uint8]:
    """Counts (B, 6 edge²) over a cube map of half the edge: sums of four, which must fit into 8 bits."""
    squares = counts.reshape(-1, 6 * edge // 2, 2, edge // 2, 2)
    sums = squares[:, :, 0, :, 0] + squares[:, :, 0, :, 1] + squares[:, :, 1, :, 0] + squares[:, :, 1, :, 1]
    return sums.reshape(len(counts), -1)


def hold_visibility(of: Receivers, edge: int, fine: int, vertices: Indices | None = None) -> Steps[HeldVisibility]:
    """Find the visibility of `vertices` in rising order, all by default, from the record of `of` or by rays."""
    asked, packed = np.arange(len(of)) if vertices is None else vertices, ScratchRows(len(of))
    for start in range(0, len(asked), CHUNK):
        for chunk, counts in visibility_shares(of, edge, fine, asked[start : start + CHUNK]):
            _put(packed, chunk, pack_rows(counts))
        done = min(start + CHUNK, len(asked))
        yield Step(done / len(asked), f"visibility of vertex {count_text(done)} of {count_text(len(asked))}")
    return HeldVisibility(edge, fine, packed)


def gather_visibility(of: Receivers, edge: int, fine: int, look: Look) -> Steps[HeldVisibility]:
    """The visibility of all vertices: blocks from the record of `of`, and others by `look`, which the record then has.

    Blocks are small enough to be found elsewhere (`engine.transport.baking.chunks`).
    """
    parts, packed, done = blocks(of, edge), ScratchRows(len(of)), 0
    record = of.record if isinstance(of.record, VisibilityRecord) else None
    missing = list(range(len(parts))) if record is None else record.missing(of, edge, fine)

    def step(number: int) -> Step:
        nonlocal done
        done += len(parts[number])
        return Step(done / len(of), f"visibility of vertex {count_text(done)} of {count_text(len(of))}")

    for number in sorted(set(range(len(parts))) - set(missing)):
        for chunk, counts in visibility_shares(of, edge, fine, parts[number]):
            _put(packed, chunk, pack_rows(counts))
        yield step(number)
    with closing(look((number, parts[number], record is not None) for number in missing)) as found:
        for number, rows, block in found:
            _put(packed, parts[number], rows)
            if record is not None:
                record.put(edge, fine, number, block)
            yield step(number)
    return HeldVisibility(edge, fine, packed)


def _put(packed: ScratchRows, vertices: Indices, rows: list[bytes]) -> None:
    for vertex, row in zip(vertices.tolist(), rows, strict=True):
        packed.put(vertex, row)


def look_at(of: Receivers, edge: int, fine: int, asked: Asked) -> Seen:
    """Visibility of a block by rays, for `gather_visibility`."""
    number, vertices, as_block = asked
    counts = np.concatenate([some for _, some in visibility_shares(replace(of, record=None), edge, fine, vertices)])
    return number, pack_rows(counts), pack_block(counts) if as_block else b""
