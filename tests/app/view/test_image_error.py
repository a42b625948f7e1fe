"""The error of what is on screen: its words, images of two sizes, and images that are gone meanwhile."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from app.jobs.jobs import Jobs
from app.view.image_error import Comparing, ImageError, Side


@pytest.mark.parametrize(
    ("rmse_rel", "uncertainty", "words"),
    [
        (0.012, 0.001, "1.2 ± 0.1 %"),
        (0.1412, 0.0001, "14.12 ± 0.01 %"),
        (0.3, 1e-7, "30.00 ± 0.01 %"),
        (0.0, 0.004, "0.0 ± 0.4 %"),
        (1.5, 0.2, "150 ± 20 %"),
        (0.01, 0.0, "1 %"),
        (0.0004, 0.0, "0.04 %"),
    ],
)
def test_as_many_digits_as_are_certain(rmse_rel: float, uncertainty: float, words: str) -> None:
    assert ImageError(rmse_rel, uncertainty, None, 1.0, 1, 1.0).text == words


def image(size: int, value: float) -> np.ndarray:
    found = np.full((size, size, 4), value, np.float32)
    found[: size // 2, :, 3] = 1.0
    found[size // 2 :, :, 3] = 0.5
    return found


def test_figures_are_of_what_both_cover_and_a_larger_image_is_averaged(qapp: Any, qtbot: Any) -> None:
    comparing = Comparing(Jobs())
    found: list[Any] = []
    comparing.found.connect(found.append)
    comparing.compare(Side(image(40, 1.2)), Side(image(20, 1.0)), with_flip=True)
    qtbot.waitUntil(lambda: len(found) == 2, timeout=60_000)
    assert found[0].rmse_rel == pytest.approx(0.2, rel=1e-5)
    assert found[0].pixels == 200
    assert found[0].flip is None
    assert 0.0 < found[1].flip < 1.0


def test_what_is_found_of_images_that_are_gone_is_not_shown(qapp: Any, qtbot: Any) -> None:
    jobs = Jobs()
    found: list[Any] = []
    comparing = Comparing(jobs)
    comparing.found.connect(found.append)
    comparing.compare(Side(image(20, 1.2)), Side(image(20, 1.0)), with_flip=True)
    comparing.drop()
    comparing.compare(Side(image(20, 3.0)), Side(image(20, 1.0)), with_flip=False)
    qtbot.waitUntil(lambda: not jobs.active and len(found) > 0, timeout=60_000)
    assert [error.rmse_rel for error in found] == [pytest.approx(2.0, rel=1e-5)]
