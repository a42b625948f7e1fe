"""Heights of slopes, against a height that is known."""

from __future__ import annotations

import numpy as np

from engine.core.slopes import integrate_slopes


def test_a_plane_and_a_paraboloid_come_back() -> None:
    """The mean of both slopes is the difference of a height of the second order, so that it comes back exactly."""
    y, x = np.mgrid[20.0:0.0:-1.0, 0.0:30.0]
    for height, right, up in (
        (0.3 * x - 0.2 * y, np.full_like(x, 0.3), np.full_like(x, -0.2)),
        (0.01 * x**2 + 0.02 * x * y - 0.03 * y**2, 0.02 * x + 0.02 * y, 0.02 * x - 0.06 * y),
    ):
        np.testing.assert_allclose(integrate_slopes(right, up), height - height.mean(), atol=1e-9)
