"""The declarations of the transport methods: what they allow is what the bakes take."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.params import Parameter, parameters
from engine.core.steps import drain
from engine.factor.hemisphere_map import KINDS
from engine.factor.separable import WEIGHTINGS
from engine.light.sky import make_built_in
from engine.planning.effects.estimates import EFFECTS
from engine.transport.gaussian.fitting.fit import MAX_LOBES
from engine.transport.gaussian.fitting.views import VIEWS
from engine.transport.gaussian_method import bake_settings as gaussian_settings
from engine.transport.method import METHODS, Baking, Method, Subject, method_of
from engine.transport.relight import Light
from engine.transport.sh.basis import WINDOWS
from engine.transport.sh.brdf_table_varying import MAX_VARIATIONS
from engine.transport.sh_method import bake_settings as sh_settings
from engine.transport.wavelet.haar import EDGES
from engine.transport.wavelet.transfer import MAX_COEFFICIENTS, MAX_TERMS
from engine.transport.wavelet_method import bake_settings as wavelet_settings
from tests.engine.transport.sh.test_transfer import small

BAKES: dict[str, Callable[[Any], object]] = {
    "sh": sh_settings,
    "wavelet": wavelet_settings,
    "gaussian": gaussian_settings,
}


def declare(method: str, name: str) -> Parameter:
    of = method_of(method)
    return next(each for each in (*parameters(of.settings), *parameters(of.light)) if each.name == name)


def test_declarations_are_those_of_the_engine() -> None:
    assert set(declare("wavelet", "map").values) == set(KINDS)
    assert declare("wavelet", "weighting").values == WEIGHTINGS
    assert declare("wavelet", "cube").values == EDGES
    assert (declare("wavelet", "terms").high, declare("wavelet", "coefficients").high) == (
        MAX_TERMS,
        MAX_COEFFICIENTS,
    )
    assert declare("gaussian", "views").values or declare("gaussian", "views").low == VIEWS
    assert declare("gaussian", "lobes").high == MAX_LOBES
    assert declare("sh", "window").values == WINDOWS
    assert method_of("sh").variations == MAX_VARIATIONS


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_a_bake_takes_every_value_that_a_plan_or_a_form_may_choose(method: Method) -> None:
    settings_of: Any = method.settings
    for parameter in parameters(method.settings):
        ends = (parameter.low, parameter.high) if parameter.kind == "whole" and not parameter.values else ()
        for value in (*ends, *parameter.values, *(value for value, _ in parameter.offered)):
            BAKES[method.name](settings_of(**{parameter.name: value}))
        for value in parameter.sweep:
            BAKES[method.name](method.with_values({parameter.name: value}))


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.name)
def test_every_method_offers_what_the_others_do(method: Method) -> None:
    assert method.shows <= set(EFFECTS)
    assert method.always <= method.shows
    for name in (name for name in vars(Baking) if not name.startswith("_")):
        assert callable(getattr(method.baking, name)), name
    assert method.drawing.Textures.SOURCE.endswith(".glsl")
    assert len({each.key for each in METHODS}) == len(METHODS)
    assert all(parameter.doc for parameter in (*parameters(method.settings), *parameters(method.light)))


def test_values_that_are_not_declared_are_refused() -> None:
    wrong = (("sh", "order", 2), ("sh", "order", True), ("wavelet", "cube", 48), ("wavelet", "coefficients", 5000))
    for method, name, value in (*wrong, ("gaussian", "weights", "loud"), ("gaussian", "compress", 1)):
        with pytest.raises(ValueError, match=name):
            method_of(method).settings(**{name: value})


@pytest.mark.parametrize(
    ("mode", "settings"), [("sh", {"order": 3, "cube": 8}), ("wavelet", {"terms": 1, "cube": 8, "coefficients": 16})]
)
def test_times_of_the_light_and_of_relighting_are_those_between_looks_at_the_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: str, settings: dict[str, Any]
) -> None:
    method = method_of(mode)
    work = drain(method.baking.prepare(Subject(small(), brdf_from_text("lambert"), None), method.settings(**settings)))
    file = drain(method.baking.bake(tmp_path / "a.transport", work)).file
    looks = iter((10.0, 12.0, 17.0))
    clock = SimpleNamespace(perf_counter=lambda: next(looks))
    monkeypatch.setattr(f"engine.transport.{mode}_method.time", clock)
    reported = drain(method.baking.illuminate(file, Light(make_built_in("sky")), method.light(), None)).figures
    assert (reported["light_s"], reported["relight_s"]) == (2.0, 5.0)
