"""Order statistics against sorting."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from engine.core.quickselect import nth_smallest


@given(st.lists(st.integers(-4, 4), min_size=1, max_size=30), st.data())
def test_the_nth_smallest_is_that_of_the_sorted_values(values: list[int], data: st.DataObject) -> None:
    """Few different values, so that many are equal; what lies beyond the length does not count."""
    length = data.draw(st.integers(1, len(values)))
    nth = data.draw(st.integers(0, length - 1))
    numbers = np.array(values, np.float64)
    assert nth_smallest(numbers, length, nth) == sorted(values[:length])[nth]
    assert sorted(numbers) == sorted(values)
    assert list(numbers[length:]) == values[length:]
