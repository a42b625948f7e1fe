"""Predicted costs follow the rates that were measured, and a kept model is used on its own machine only."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.effects.cost_model import MATT_ORDER, NAMES, CostModel, Load, load_model, machine_name, save
from engine.effects.setting import KNOBS, Setting, ladder


@pytest.fixture
def model() -> CostModel:
    """Rates of a machine that never was: each doubles where its knob does."""
    tables = dict.fromkeys(NAMES, ((1.0, 1e-06), (16.0, 1.6e-05), (64.0, 6.4e-05)))
    return CostModel(machine_name(), "processor", tables)


def test_rates_between_measured_knobs_are_a_power_law(model: CostModel) -> None:
    assert model.rate("visibility", 16) == pytest.approx(16e-6, rel=1e-12)
    assert model.rate("visibility", 32) == pytest.approx(32e-6, rel=1e-12)
    assert model.rate("visibility", 128) == pytest.approx(128e-6, rel=1e-12)
    assert model.rate("visibility", 0.5) == pytest.approx(0.5e-6, rel=1e-12)


def test_a_rate_of_zero_is_interpolated_too(model: CostModel) -> None:
    tables = {**model.tables, "visibility": ((16.0, 0.0), (32.0, 1.0))}
    assert replace(model, tables=tables).rate("visibility", 24) == pytest.approx(0.5)
    assert replace(model, tables=tables).rate("visibility", 8) == 0.0


@pytest.mark.parametrize("mode", ["sh", "wavelet", "gaussian"])
def test_T7_sizes_are_those_of_the_files(model: CostModel, mode: str) -> None:
    """By counting: 4 bytes for a number of a matrix, 6 for a wavelet and 14 for the vector it is in, 28 for a lobe."""
    load = Load(1000, 10_000, faces=2000)
    for setting in ladder(mode, {"sh": "order", "wavelet": "terms", "gaussian": "lobes"}[mode]):
        own = model.predict(setting, 1000, 10_000, load=load).size_bytes - load.mesh_bytes
        if mode == "sh":
            assert own == 1000 * 4 * setting["order"] ** 4
        elif mode == "gaussian":
            assert own == 1000 * (92 * 28 * setting["lobes"] + 4 * MATT_ORDER**2)
        else:
            assert own == 1000 * setting["terms"] * (6 * 96 + 14)


@given(st.sampled_from(["reference", "direct", "shading-map", "sh", "wavelet", "gaussian"]), st.data())
def test_T7_a_turned_up_knob_never_costs_less(mode: str, data: st.DataObject) -> None:
    tables = dict.fromkeys(NAMES, ((1.0, 1e-06), (16.0, 1.6e-05)))
    model = CostModel("machine", "processor", tables)
    knob = data.draw(st.sampled_from(list(KNOBS[mode])))
    diffuse = data.draw(st.booleans())
    costs = [model.predict(each, 5000, 100_000, diffuse=diffuse) for each in ladder(mode, knob)]
    if knob != "power_law":
        for before, after in itertools.pairwise(costs):
            assert all(getattr(after, name) >= getattr(before, name) for name in ("bake_s", "frame_s", "size_bytes"))
    assert all(math.isfinite(cost.bake_s + cost.relight_s + cost.frame_s) for cost in costs)


def test_T5_open_vertices_cost_no_rays(model: CostModel) -> None:
    closed, open_ = (model.predict(Setting("sh"), 1000, 1000, occluded=share) for share in (1.0, 0.0))
    assert closed.bake_s - open_.bake_s == pytest.approx(1000 * model.rate("visibility", 32))


def test_a_kept_model_is_found_again(model: CostModel, tmp_path: Path) -> None:
    save(model, tmp_path / "new" / "cost.json")
    assert load_model(tmp_path / "new" / "cost.json") == model


@pytest.mark.parametrize("content", ["", "{", "[]", "null", '{"machine": 1}', '{"tables": {"sh": 3}}', "[" * 100_000])
def test_a_damaged_model_is_measured_anew(tmp_path: Path, content: str) -> None:
    (tmp_path / "cost.json").write_text(content)
    assert load_model(tmp_path / "cost.json") is None
    assert load_model(tmp_path / "absent.json") is None
    assert load_model(tmp_path) is None


def test_foreign_and_senseless_models_are_measured_anew(model: CostModel, tmp_path: Path) -> None:
    path = tmp_path / "cost.json"
    save(replace(model, machine="another"), path)
    assert load_model(path) is None
    save(model, path)
    record = json.loads(path.read_text())
    for damage in ({"visibility": [[16, -1.0]]}, {"visibility": [[16, 1.0], [8, 1.0]]}, {"visibility": []}):
        path.write_text(json.dumps({**record, "tables": {**record["tables"], **damage}}))
        assert load_model(path) is None


def test_loads_that_cannot_be_are_refused(model: CostModel) -> None:
    with pytest.raises(ValueError, match="make no load"):
        model.predict(Setting("sh"), 0, 100)
    with pytest.raises(ValueError, match="make no load"):
        model.predict(Setting("sh"), 10, 100, occluded=1.5)
