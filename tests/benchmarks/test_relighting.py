"""The rivals of directional maps, and maps of generated captures against them."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.relighting import _compare, generate, polynomial_functions, ridge
from engine.core.steps import drain


def test_a_ridge_leaves_out_as_refits_do() -> None:
    """The least error over the strengths is that of one of them, each photograph left out and all fitted again."""
    lights, codes = generate("lambert", 12, False, 0.01, 3)
    functions, values = polynomial_functions(lights), codes.reshape(12, -1)
    size, errors = np.mean(functions**2) * 6, []
    for strength in np.geomspace(1e-6, 10, 40):
        apart = []
        for out in range(12):
            others = np.delete(np.arange(12), out)
            inner = functions[others].T @ functions[others] + size * strength * np.eye(6)
            fitted = np.linalg.solve(inner, functions[others].T @ values[others])
            apart.append(functions[out] @ fitted - values[out])
        errors.append(np.sqrt(np.mean(np.square(apart))))
    assert ridge(functions, codes) == pytest.approx(min(errors), rel=1e-4)


@pytest.mark.parametrize(("surface", "count", "rings"), [("lambert", 12, False), ("shadowed", 48, True)])
def test_a_map_errs_no_more_than_the_best_rival(surface: str, count: int, rings: bool) -> None:
    ratio, figures = drain(_compare(*generate(surface, count, rings, 0.01, 11)))
    assert ratio == pytest.approx(figures["map"] / min(figures[name] for name in ("polynomial", "harmonic", "process")))
    assert ratio <= 1.0
