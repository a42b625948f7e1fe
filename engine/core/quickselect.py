"""Order statistics within compiled kernels, in time that grows as the number of values (quickselect, Hoare1961)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.core.kernels import scalar


@scalar
def nth_smallest(values: NDArray[np.floating], length: int, nth: int) -> float:
    """The `nth` smallest (from 0) of the first `length` values, which are reordered; none of them may be NaN."""
    low, high = 0, length - 1
    while low < high:
        a, b, c = values[low], values[(low + high) // 2], values[high]
        pivot = max(min(a, b), min(max(a, b), c))
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if nth <= j:
            high = j
        elif nth >= i:
            low = i
        else:
            break
    return values[nth]
