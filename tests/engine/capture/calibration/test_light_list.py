"""Lists of lights that do not belong to their photographs."""

from __future__ import annotations

import numpy as np
import pytest

from engine.capture.calibration.light_list import check_list
from engine.capture.lights.list_forms import change, check_form
from engine.core.errors import UsageError
from tests.engine.capture.calibration.generated import LISTS, Capture, draw, join_names, render

#: What is named for each fault of a list.
NAMED = {
    "right": "listed",
    "shifted": "shifted",
    "reversed": "reversed",
    "mirrored x": "mirrored-x",
    "mirrored y": "mirrored-y",
    "swapped": "swapped-xy",
}


def _clipped(photographs: np.ndarray) -> list[np.ndarray]:
    return [(each >= 0.99).any(axis=-1).astype(np.float32) for each in photographs]


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


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_wrong_lists_of_generated_captures_are_named_in_95_of_100_and_no_right_one_is() -> None:
    right, false = 0, 0
    for seed in range(100):
        rendered = render(draw(seed, list(LISTS)[1 + seed % 5]))
        clipped, photographs = _clipped(rendered.photographs), list(rendered.photographs)
        named = check_list(photographs, clipped, rendered.listed).form
        right += named.startswith(NAMED[rendered.capture.light_list])
        false += check_list(photographs, clipped, rendered.directions).form != "listed"
    assert right >= 95
    assert false == 0
