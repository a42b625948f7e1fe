"""Normals where plain least squares are hard to beat: three lamps, and lamps on one ring over a matte surface."""

from __future__ import annotations

import numpy as np
import pytest

from engine.capture.stack import ImageStack
from engine.core.steps import drain
from engine.surface.recover import recover
from tests.engine.capture.calibration import generated
from tests.engine.capture.calibration.generated import Capture, render


def _ring(count: int) -> np.ndarray:
    azimuth, rise = 0.3 + np.arange(count) * 2.0 * np.pi / count, np.radians(45.0)
    across = np.cos(rise)
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.full(count, np.sin(rise))], axis=1)


@pytest.mark.parametrize("count", [3, 6, 12])
def test_normals_are_not_worse_than_by_least_squares(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generated, "dome", lambda count, random: _ring(count))
    made = render(Capture(seed=1, height=48, width=56, lamps=count, steepness=0.2))
    directions = made.directions
    rise, azimuth = np.arcsin(directions[:, 2]), np.arctan2(directions[:, 1], directions[:, 0])
    clipped = np.any(made.photographs >= 0.9999, axis=-1)
    means, names = made.photographs.mean(axis=(1, 2, 3)), tuple(made.names)
    stack = ImageStack(made.photographs, clipped, rise, azimuth, means, names, "lp")
    normals = drain(recover(stack, np.arange(count), left_out=False)).maps.normal
    flat = made.photographs.mean(axis=-1, dtype=np.float64).reshape(count, -1)
    plain = np.linalg.lstsq(directions, flat, rcond=None)[0].T
    plain /= np.linalg.norm(plain, axis=1, keepdims=True)
    ours, theirs = (
        np.degrees(np.arccos(np.clip((each.reshape(-1, 3) * made.normals.reshape(-1, 3)).sum(axis=1), -1.0, 1.0)))
        for each in (normals, plain)
    )
    assert ours.mean() <= 1.05 * theirs.mean()
