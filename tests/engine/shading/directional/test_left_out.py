"""Photographs that are left out, as representations show them, against errors that follow from moments."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from engine.core.steps import drain
from engine.shading.compare import Candidate, compare
from engine.shading.directional.left_out import Texels
from tests.engine.domes import dome

STACK = dome(10, 12, 14)
ALL = np.arange(10)


@pytest.fixture(scope="module")
def candidates() -> list[Candidate]:
    return drain(compare(STACK, ALL))


def texels() -> Texels:
    height, width = STACK.radiance.shape[1:3]
    rows, columns = np.mgrid[:height, :width]
    usable = np.ones((10, height * width), np.bool_)
    return Texels(np.asarray(STACK.radiance).reshape(10, -1, 3), usable, rows.ravel(), columns.ravel())


def test_what_is_shown_has_the_error_that_is_told(candidates: list[Candidate]) -> None:
    seen = texels()
    assert {"mean", "ptm", "hsh", "kriging-of-all", "shading-map"} <= {each.name for each in candidates}
    for each in candidates:
        squares = [np.mean((each.predict(seen, out) - seen.codes[out]) ** 2) for out in range(10)]
        assert np.sqrt(np.mean(squares)) == pytest.approx(each.leave_one_out, rel=0.01), each.name


def test_a_photograph_does_not_help_to_show_itself(candidates: list[Candidate]) -> None:
    seen = texels()
    changed = seen.radiance.copy()
    changed[4] = 0.3
    other = dataclasses.replace(seen, radiance=changed)
    for each in candidates:
        assert np.array_equal(each.predict(seen, 4), each.predict(other, 4)), each.name
