"""Memory that the undo history keeps: arrays that earlier states of the project hold and later ones do not.

States share what they have in common, so each array is counted at the step that gave it up.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from itertools import accumulate
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

#: Arrays that only earlier states hold take so many bytes at most together: some five materials of 1024 × 1024 texels
#: and eight slices. What the last step gave up is kept whatever its size.
KEPT_BYTES = 512 * 2**20

#: Steps that can be undone at most, however small they are.
KEPT_STEPS = 500


def count_freed_bytes(old: DataclassInstance, new: DataclassInstance) -> int:
    """Size of the arrays that `old` holds and `new` does not; both are values of one frozen dataclass."""
    pairs = [(getattr(old, part.name), getattr(new, part.name)) for part in fields(old)]
    pairs = [pair for pair in pairs if pair[0] is not pair[1]]
    before, after = _arrays(one for one, _ in pairs), _arrays(other for _, other in pairs)
    return sum(array.nbytes for identity, array in before.items() if identity not in after)


def steps_to_keep(sizes: Sequence[int], max_bytes: int) -> int:
    """Number of the latest steps that give up `max_bytes` together, at least 1; `sizes` begin at the oldest."""
    return max(1, sum(total <= max_bytes for total in accumulate(reversed(sizes))))


def _arrays(values: Iterable[Any]) -> dict[int, NDArray[Any]]:
    """Arrays within `values`, by identity; for a part of an array, the whole one that it keeps in memory."""
    found: dict[int, NDArray[Any]] = {}
    seen: set[int] = set()
    waiting = list(values)
    while waiting:
        value = waiting.pop()
        if id(value) in seen:
            continue
        seen.add(id(value))
        if isinstance(value, np.ndarray):
            while isinstance(value.base, np.ndarray):
                value = value.base
            found[id(value)] = value
        elif isinstance(value, Mapping):
            waiting.extend(value.values())
        elif isinstance(value, tuple | list):
            waiting.extend(value)
        elif is_dataclass(value) and not isinstance(value, type):
            waiting.extend(vars(value).values())  # with what was worked out once and is kept, as tangents of a mesh
    return found
