"""Settings are values: complete, checked, equal where they say the same."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.planning.costs.setting import Setting, modes, parameters_of, setting_of, sweep
from engine.scene.mode import ModeParameter


def test_unnamed_parameters_have_their_default() -> None:
    assert dict(Setting("wavelet").parameters) == {"terms": 4, "coefficients": 96, "interreflection": 0, "cube": 64}
    assert Setting("sh", {"order": 5}) == Setting("sh")
    assert len({Setting("sh", {"order": 5}), Setting("sh"), Setting("sh", {"order": 8})}) == 2


def values_of(parameter: ModeParameter) -> st.SearchStrategy[int]:
    return (
        st.sampled_from(parameter.values) if parameter.values else st.integers(int(parameter.low), int(parameter.high))
    )


@given(st.sampled_from(modes()), st.data())
def test_every_setting_survives_its_record(mode: str, data: st.DataObject) -> None:
    parameters = {name: data.draw(values_of(parameter)) for name, parameter in parameters_of(mode).items()}
    setting = Setting(mode, parameters)
    assert setting_of(setting.as_json()) == setting
    assert hash(setting_of(setting.as_json())) == hash(setting)


@pytest.mark.parametrize(
    ("mode", "parameters"),
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
def test_what_is_no_setting_is_refused(mode: str, parameters: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=r"unknown mode|not a parameter|number"):
        Setting(mode, parameters)


@pytest.mark.parametrize("record", [None, [], {"mode": "sh", "knobs": 3}, {"knobs": {}}])
def test_what_is_no_record_is_refused(record: object) -> None:
    with pytest.raises(ValueError, match=r"setting|mode"):
        setting_of(record)


def test_sweeps_stay_in_range_and_keep_the_other_parameters() -> None:
    base = Setting("wavelet", {"terms": 8})
    assert [each["coefficients"] for each in sweep("wavelet", "coefficients", base)] == [24, 48, 96, 192, 384]
    assert {each["terms"] for each in sweep("wavelet", "coefficients", base)} == {8}
    assert all(list(sweep(mode, parameter)) for mode in modes() for parameter in parameters_of(mode))
