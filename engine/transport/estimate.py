"""How long a bake will take, from some vertices of the model and of the ground that lie apart."""

from __future__ import annotations

import os
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

#: Fewest vertices of the model whose bake tells of all others, and of the ground, where vertices differ less.
PROBES, GROUND_PROBES = 48, 16

#: Portions that every thread gets of the vertices of the model, and of those of the ground: few would not share evenly.
PORTIONS, GROUND_PORTIONS = 4, 2


def estimated_s(make: Callable[[NDArray[np.int64]], object], vertices: int, first: int, portion: int = 1) -> float:
    """Seconds that `make` takes for all vertices, of which those from `first` on are ground; it is run on some.

    `make` bakes vertices, all of one kind; what all vertices share is made before. Threads take `portion` vertices at a
    time. Compiling and first touches are not counted. Costs about a hundredth of a bake of many vertices.
    """
    threads = os.cpu_count() or 1
    kinds = (
        (np.arange(first), max(PROBES, PORTIONS * threads * portion)),
        (np.arange(first, vertices), max(GROUND_PROBES, GROUND_PORTIONS * threads * portion)),
    )
    return sum(_estimated_s(make, some, count) for some, count in kinds if len(some))


def _estimated_s(make: Callable[[NDArray[np.int64]], object], vertices: NDArray[np.int64], probes: int) -> float:
    spaces = np.linspace(0, len(vertices), min(probes, len(vertices)) + 1)
    chosen = vertices[((spaces[:-1] + spaces[1:]) / 2.0).astype(np.int64)]
    make(chosen[:1])
    started = time.perf_counter()
    make(chosen)
    return (time.perf_counter() - started) / len(chosen) * len(vertices)
