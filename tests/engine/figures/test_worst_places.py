"""The worst places of a representation: found as they were made, and shown with the error that is told."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from engine.core.steps import drain
from engine.figures.contact_sheet import WIDTH
from engine.figures.worst_places import PLACES, select_seen_places, worst_places, worst_sheet
from engine.shading.compare import Candidate
from engine.shading.directional.left_out import Texels
from tests.engine.domes import dome

ALL = np.arange(12)
STACK = dome(12, 40, 60)


def off_in(place: tuple[int, int, int], much: float) -> Candidate:
    """A representation that is right but for a square of 4 texels at (photograph, row, column)."""
    photograph, row, column = place

    def predict(texels: Texels, out: int) -> np.ndarray:
        inside = (texels.rows - row) // 4 + (texels.columns - column) // 4 * 100 == 0
        return texels.codes[out] + np.where(inside & (out == photograph), much, 0.0)[:, None]

    return Candidate("planes-1", 1.0, 1.0, 1, 1, 0.0, predict)


def test_the_worst_place_is_where_the_representation_is_off() -> None:
    candidate = off_in((7, 21, 33), 10.0)
    found = drain(worst_places(STACK, ALL, candidate.predict))
    assert len(found) == 1
    first = found[0]
    assert (first.photograph, first.row, first.column, first.edge) == (7, 21, 33, 4)
    (seen,) = drain(select_seen_places(STACK, ALL, [candidate], found))
    assert seen.record["photograph"] == "7"
    assert seen.record["rmse_srgb8"]["planes-1"] == pytest.approx(10.0, abs=0.01)


def test_places_are_apart_and_in_photographs_of_their_own() -> None:
    rng = np.random.default_rng(3)

    def predict(texels: Texels, out: int) -> np.ndarray:
        return texels.codes[out] + rng.normal(0.0, 5.0, texels.codes[out].shape)

    found = drain(worst_places(STACK, ALL, predict))
    assert len(found) == PLACES
    assert len({each.photograph for each in found}) == PLACES
    for at, one in enumerate(found):
        assert 0 <= one.row <= 40 - one.edge
        assert 0 <= one.column <= 60 - one.edge
        assert all(max(abs(one.row - two.row), abs(one.column - two.column)) >= one.edge for two in found[:at])


def test_the_sheet_has_two_rows_for_each_place() -> None:
    candidate = off_in((7, 21, 33), 10.0)
    other = dataclasses.replace(candidate, name="mean")
    places = drain(worst_places(STACK, ALL, candidate.predict))
    one = worst_sheet(drain(select_seen_places(STACK, ALL, [candidate, other], places)), "planes-1")
    two = worst_sheet(drain(select_seen_places(STACK, ALL, [candidate, other], places * 2)), "planes-1")
    assert one.shape[1] == WIDTH
    none = worst_sheet([], "planes-1")
    assert len(two) - len(one) == len(one) - len(none)


@pytest.mark.parametrize("shape", [(211, 219), (210, 214)])
def test_a_place_at_the_border_lies_within_the_photographs(shape: tuple[int, int]) -> None:
    stack = dome(12, *shape)

    def predict(texels: Texels, out: int) -> np.ndarray:
        corner = (texels.rows >= shape[0] - 8) & (texels.columns >= shape[1] - 8) & (out == 3)
        return texels.codes[out] + np.where(corner, 20.0, 0.0)[:, None]

    candidate = Candidate("planes-1", 1.0, 1.0, 1, 1, 0.0, predict)
    (place,) = drain(worst_places(stack, ALL, predict))
    assert place.row + place.edge <= shape[0]
    assert place.column + place.edge <= shape[1]
    assert len(drain(select_seen_places(stack, ALL, [candidate], [place]))) == 1
