"""The measures of the Gaussian fit, on few pairs of vertex and view."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.transport import gaussian_fit
from engine.core.steps import drain
from tests.engine.transport.gaussian.gaussian_lobes import icosphere, one_gaussian


def test_the_search_finds_a_gaussian() -> None:
    direction, value, area = one_gaussian()
    found = gaussian_fit.search(direction, value, area, 1, np.random.default_rng(0))
    assert found is not None
    assert found <= 1e-4


@pytest.mark.parametrize("lobes", [1, pytest.param(2, marks=pytest.mark.long)])
def test_the_fit_is_no_worse_than_the_search(lobes: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gaussian_fit, "SAMPLES", 128)
    monkeypatch.setattr(gaussian_fit, "STARTS", 5)
    monkeypatch.setattr(gaussian_fit, "BRDFS", gaussian_fit.BRDFS[:1])
    pairs = drain(gaussian_fit.compare_with([icosphere(1)], lobes, 4))
    assert len(pairs.fitted) >= 2  # some have no lobe that so few samples resolve
    assert pairs.fitted.mean() <= 1.05 * pairs.searched.mean()
    assert 0.0 < pairs.searched.min() < 1.0
