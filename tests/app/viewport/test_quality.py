"""Quality of the next frame: no number of lights leaves an image coarse, and pieces do not make a frame look dear."""

from __future__ import annotations

import pytest

from app.viewport.refining import IDLE_S, MANY_LIGHTS, ONE_LIGHT, Cost


@pytest.mark.parametrize("lights", [1, 2, 3, 5, 7, 16, 23, 25, 64, 97, 257, 1024])
def test_every_image_becomes_the_finest_step_by_step(lights: int) -> None:
    levels, pixels, cost = (ONE_LIGHT if lights == 1 else MANY_LIGHTS), 500_000, Cost()
    at = len(levels) - 1
    for _ in range(20):
        cost.learn(levels[at].evaluations(pixels, lights), 1e-3 + 1e-9 * levels[at].evaluations(pixels, lights))
        best = cost.best(levels, pixels, lights, IDLE_S)
        if best >= at:
            break
        at = best
    assert at == 0


def test_what_pieces_repeat_is_not_taken_for_the_cost_of_the_frame() -> None:
    cost = Cost()
    cost.learn(1000, 0.02)
    cost.learn(5000, 50 * 0.02 + 0.08, pieces=50)
    assert cost.predicted(5000) == pytest.approx(0.1)
    cost.learn(5000, 50 * 0.01, pieces=50)
    assert cost.predicted(5000) == pytest.approx(0.01), "never less than one piece"
