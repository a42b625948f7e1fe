"""What workers see: it comes back to the record, as a bake here leaves it, and goes to them from there."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.ground import Ground
from engine.transport.baking import visibility_record
from engine.transport.baking.carried_visibility import Carrier, carry
from engine.transport.baking.chunks import Chunk
from engine.transport.baking.visibility import Receivers
from engine.transport.baking.visibility_record import VisibilityRecord, is_kept, keep_visibility
from engine.transport.wavelet import bake as wavelet_bake
from tests.engine.transport.gaussian.gaussian_lobes import icosphere

EDGE, FINE = 4, 2


@pytest.fixture(scope="module")
def work() -> Iterator[wavelet_bake.Work]:
    """A ball on a ground in chunks of 10 vertices, of which the record has blocks of 7."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(wavelet_bake, "CHUNK_TEXELS", 10 * 6 * EDGE * EDGE)
        patch.setattr(visibility_record, "TEXELS", 7 * 6 * EDGE * EDGE)
        even = np.full((1, 4, 4, 3), 0.4, np.float32)
        factors = SeparableFactors(HemisphereMap("orthographic", 4), "in-out", even, even, True, True, "even")
        settings = wavelet_bake.BakeSettings(EDGE, 8, FINE)
        yield wavelet_bake.prepare(icosphere(1), factors, settings, Ground(cells=4))


def contents(record: Any) -> list[Any]:
    with closing(sqlite3.connect(record.path(EDGE, FINE))) as file:
        return file.execute("SELECT * FROM blocks ORDER BY number").fetchall()


class Blind:
    """Meets nothing, and says so."""

    def occluded(self, *_words: Any, **_more: Any) -> Any:
        raise AssertionError("a ray is cast")


def make_all(work: wavelet_bake.Work, of: Receivers, worker: Receivers) -> list[Chunk]:
    """All chunks in falling order, as a worker makes them; the record of `of` gets what it sees."""
    recipe = wavelet_bake.recipe_of(work, of)
    carrier = Carrier(of, EDGE, FINE, recipe["bounds"])
    make: Callable[[Any], Chunk] = carry(lambda own: wavelet_bake.Baker(recipe, own), replace(worker, record=None))
    found = []
    for number in reversed(range(len(carrier.sizes))):
        found.append(make(carrier.load(number)))
        carrier.unload(found[-1])
    return found[::-1]


def test_what_a_worker_sees_goes_to_the_record_and_from_there_to_the_next(
    work: wavelet_bake.Work, tmp_path: Path
) -> None:
    bare = work.occluder.receivers(work.surface)
    here, there = (keep_visibility(bare, tmp_path / name) for name in ("here", "there"))
    expected = [wavelet_bake.baker_of(work, here)(number) for number in range(work.plan.chunks)]
    first = make_all(work, there, bare)
    assert isinstance(there.record, VisibilityRecord)
    assert contents(there.record) == contents(here.record)
    assert is_kept(there, EDGE, FINE)
    again = make_all(work, there, replace(bare, caster=Blind()))  # type: ignore[arg-type]
    assert not any(chunk.seen for chunk in again)
    for found in (first, again):
        for one, other in zip(found, expected, strict=True):
            for name, rows in other.rows.items():
                np.testing.assert_array_equal(one.rows[name], rows)


def test_a_damaged_block_is_found_anew(work: wavelet_bake.Work, tmp_path: Path) -> None:
    bare = work.occluder.receivers(work.surface)
    of = keep_visibility(bare, tmp_path)
    make_all(work, of, bare)
    assert isinstance(of.record, VisibilityRecord)
    whole = contents(of.record)
    with closing(sqlite3.connect(of.record.path(EDGE, FINE))) as file, file:
        file.execute("UPDATE blocks SET data = ? WHERE number = 2", (b"broken",))
    make_all(work, of, bare)
    assert contents(of.record) == whole


def test_without_a_record_nothing_is_carried(work: wavelet_bake.Work) -> None:
    bare = work.occluder.receivers(work.surface)
    assert not any(chunk.seen for chunk in make_all(work, bare, bare))
