"""Lists of lights that do not belong to their photographs."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from engine.capture.calibration.light_list import check_list
from engine.capture.lights.list_forms import change, check_form
from engine.core.errors import UsageError
from tests.engine.capture.calibration.campaign import NAMED
from tests.engine.capture.calibration.generated import LISTS, Capture, dome, find_lit, join_names, render


def _clipped(photographs: Iterable[np.ndarray]) -> list[np.ndarray]:
    return [np.any(each >= 0.99, axis=-1).astype(np.float32) for each in photographs]


def test_forms_of_a_list_of_three_lights() -> None:
    lights = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]])
    assert change(lights, "mirrored-y").tolist() == [[1, -2, 3], [4, -5, 6], [7, -8, 9]]
    assert change(lights, "swapped-xy")[0].tolist() == [2, 1, 3]
    assert change(lights, "reversed")[0].tolist() == [7, 8, 9]
    assert change(lights, "shifted+1")[:, 0].tolist() == [4, 7, 1]  # each photograph has the light of the next
    with pytest.raises(UsageError, match="unknown form"):
        check_form("mirrored")


def test_wrong_lists_are_named_and_the_right_one_is_not_doubted() -> None:
    rendered = render(Capture(seed=11, height=48, width=56, lamps=20, distance=6.0, surface="domes"))
    for how in LISTS:
        wrong = join_names(rendered.directions, how, np.random.default_rng(1))
        found = check_list(list(rendered.photographs), _clipped(rendered.photographs), wrong)
        assert found.form.startswith(NAMED[how]), how
        if how != "right":
            assert np.allclose(change(wrong, found.form), rendered.directions)


def test_shadows_of_a_thing_that_stands_out_tell_hills_from_valleys() -> None:
    """Near lamps bend to explain such shadows, and said of five right lists in six that they were turned."""
    side = 48
    rows, columns = np.mgrid[:side, :side] - (side - 1) / 2
    out = np.hypot(rows, columns)
    height = np.where(out < 15, 0.6 * np.sqrt(np.maximum(18.0**2 - out**2, 0.0)), 0.0) / side
    down, right = np.gradient(height, 1.0 / side)
    normals = np.stack([-right, down, np.ones_like(right)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    places = np.stack([columns / side, -rows / side, height], axis=-1)
    capture, lights = Capture(height=side, width=side), dome(14, np.random.default_rng(2))
    photographs = [
        find_lit(places, normals, np.full((side, side, 3), 0.5), light, capture, 1.0 / side).astype(np.float32)
        for light in lights
    ]
    for how in ("right", "mirrored x"):
        wrong = join_names(lights, how, np.random.default_rng(1))
        assert check_list(photographs, _clipped(photographs), wrong).form == NAMED[how], how


def test_a_list_is_only_said_to_be_turned_where_shadows_or_near_lamps_tell() -> None:
    rendered = render(Capture(seed=11, height=48, width=56, lamps=20, surface="relief", steepness=0.1))
    for how in ("right", "turned"):
        listed = join_names(rendered.directions, how, np.random.default_rng(1))
        found = check_list(list(rendered.photographs), _clipped(rendered.photographs), listed)
        assert found.form == "listed"
        assert "turned by half a circle" in found.doubt
