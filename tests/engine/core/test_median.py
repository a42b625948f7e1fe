"""The median of several arrays is that of one array that holds them all, to the bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core import median
from engine.core.median import find_median


def _make(kind: str, shape: tuple[int, int], count: int) -> list[NDArray[Any]]:
    random = np.random.default_rng(count)
    arrays = [random.lognormal(size=shape).astype(np.float32) for _ in range(count)]
    if kind == "ties":
        return [np.round(each) for each in arrays]
    if kind == "constant":
        return [np.full(shape, np.float32(0.1))] * count
    if kind == "apart":  # samples of the grid say nothing of the others
        for each in arrays:
            each[:: median.STEP, :: median.STEP] += np.float32(100.0)
    if kind == "infinite":
        arrays[0][:, ::2] = np.inf
    if kind == "not a number":
        arrays[-1][1, 1] = np.nan
    if kind == "two halves":
        return [np.full(shape, np.float32(at % 2 + 0.1)) for at in range(count)]
    return arrays


@pytest.mark.parametrize("kind", ["plain", "ties", "constant", "apart", "infinite", "not a number", "two halves"])
@pytest.mark.parametrize(("shape", "count"), [((63, 81), 3), ((40, 64), 4), ((2, 3), 2)])
def test_it_is_that_of_all(kind: str, shape: tuple[int, int], count: int) -> None:
    arrays = _make(kind, shape, count)
    expected = float(np.median(np.stack(arrays)))
    assert np.array_equal(find_median(arrays), expected, equal_nan=True)


def test_few_numbers_are_sorted(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []
    partition = np.partition

    def note(numbers: NDArray[Any], places: Any) -> NDArray[Any]:
        sizes.append(len(numbers))
        return partition(numbers, places)

    monkeypatch.setattr(np, "partition", note)
    arrays = _make("plain", (400, 500), 4)
    find_median(arrays)
    assert len(sizes) == 1
    assert sizes[0] < 0.04 * 4 * arrays[0].size
