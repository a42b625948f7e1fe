"""Predictions of costs that do not depend on the load of the machine."""

from __future__ import annotations

import pytest


@pytest.fixture(autouse=True)
def _steady_rays(steady_rays: None) -> None:
    """Costs of rays are made up, so that predictions of two settings can be compared."""
