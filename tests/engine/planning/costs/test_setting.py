"""Settings are values: complete, checked, equal where they say the same."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.planning.costs.setting import Knob, Setting, knobs_of, ladder, modes, setting_of


def test_unnamed_knobs_have_their_default() -> None:
    assert dict(Setting("wavelet").knobs) == {"terms": 4, "coefficients": 96, "cube": 64}
    assert Setting("sh", {"order": 5}) == Setting("sh")
    assert len({Setting("sh", {"order": 5}), Setting("sh"), Setting("sh", {"order": 8})}) == 2


def values_of(knob: Knob) -> st.SearchStrategy[int]:
    return st.sampled_from(knob.values) if knob.values else st.integers(int(knob.low), int(knob.high))


@given(st.sampled_from(modes()), st.data())
def test_every_setting_survives_its_record(mode: str, data: st.DataObject) -> None:
    knobs = {name: data.draw(values_of(knob)) for name, knob in knobs_of(mode).items()}
    setting = Setting(mode, knobs)
    assert setting_of(setting.as_json()) == setting
    assert hash(setting_of(setting.as_json())) == hash(setting)


@pytest.mark.parametrize(
    ("mode", "knobs"),
    [
        ("ptex", {}),
        ("sh", {"terms": 4}),
        ("sh", {"order": 0}),
        ("sh", {"order": 2}),
        ("sh", {"order": 16}),
        ("wavelet", {"cube": 48}),
        ("wavelet", {"coefficients": 5000}),
        ("sh", {"order": 4.5}),
        ("sh", {"order": float("nan")}),
        ("sh", {"order": True}),
        ("sh", {"order": "5"}),
        ("gaussian", {"lobes": 4}),
    ],
)
def test_what_is_no_setting_is_refused(mode: str, knobs: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=r"no mode|no knob|number"):
        Setting(mode, knobs)


@pytest.mark.parametrize("record", [None, [], {"mode": "sh", "knobs": 3}, {"knobs": {}}])
def test_what_is_no_record_is_refused(record: object) -> None:
    with pytest.raises(ValueError, match=r"setting|mode"):
        setting_of(record)


def test_ladders_stay_in_range_and_keep_the_other_knobs() -> None:
    base = Setting("wavelet", {"terms": 8})
    assert [each["coefficients"] for each in ladder("wavelet", "coefficients", base)] == [24, 48, 96, 192, 384]
    assert {each["terms"] for each in ladder("wavelet", "coefficients", base)} == {8}
    assert all(list(ladder(mode, knob)) for mode in modes() for knob in knobs_of(mode))
