"""Balls of few pixels, on which exports are compared."""

from __future__ import annotations

from collections.abc import Iterator

import pytest


@pytest.fixture(scope="module", autouse=True)
def _small_balls() -> Iterator[None]:
    """Few pixels are compared: what holds of the errors holds for any ball."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("engine.exchange.loss.DIAMETER", 40)
        yield
