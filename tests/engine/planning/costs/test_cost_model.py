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

from engine.core.steps import Step, Steps, drain
from engine.core.stopwatch import background_load, read_clock
from engine.planning.costs import machine_profile
from engine.planning.costs.cost_model import (
    FRAME_TEACHES_S,
    MAX_CORRECTED,
    NAMES,
    REMEMBERED,
    TEACHES_S,
    CostModel,
    load_model,
    machine_name,
    save,
)
from engine.planning.costs.load import MAP_POWER, PROFILE_FACES, RAY_POWER, Load
from engine.planning.costs.setting import Setting, parameters_of, sweep


@pytest.fixture
def model() -> CostModel:
    """Rates of a machine that never was: each doubles where its parameter does."""
    tables = dict.fromkeys(NAMES, ((1.0, 1e-06), (16.0, 1.6e-05), (64.0, 6.4e-05)))
    return CostModel(machine_name(), "processor", tables)


def test_rates_between_measured_parameters_are_a_power_law(model: CostModel) -> None:
    assert model.rate("visibility", 16) == pytest.approx(16e-6, rel=1e-12)
    assert model.rate("visibility", 32) == pytest.approx(32e-6, rel=1e-12)
    assert model.rate("visibility", 128) == pytest.approx(128e-6, rel=1e-12)
    assert model.rate("visibility", 0.5) == pytest.approx(0.5e-6, rel=1e-12)


def test_rates_of_any_file_stay_finite(model: CostModel) -> None:
    tables = {**model.tables, "visibility": ((1e-8, 1e-300), (1.000001e-8, 1e8))}
    assert math.isfinite(replace(model, tables=tables).rate("visibility", 32))


def test_a_rate_of_zero_is_interpolated_too(model: CostModel) -> None:
    tables = {**model.tables, "visibility": ((16.0, 0.0), (32.0, 1.0))}
    assert replace(model, tables=tables).rate("visibility", 24) == pytest.approx(0.5)
    assert replace(model, tables=tables).rate("visibility", 8) == 0.0


@given(st.sampled_from(["reference", "direct", "shading-map", "sh", "wavelet", "gaussian"]), st.data())
def test_T7_a_turned_up_parameter_never_costs_less(mode: str, data: st.DataObject) -> None:
    tables = dict.fromkeys(NAMES, ((1.0, 1e-06), (16.0, 1.6e-05)))
    model = CostModel("machine", "processor", tables)
    parameter = data.draw(st.sampled_from(list(parameters_of(mode))))
    diffuse = data.draw(st.booleans())
    costs = [model.predict(each, 5000, 100_000, diffuse=diffuse) for each in sweep(mode, parameter)]
    if parameter != "power_law":
        for before, after in itertools.pairwise(costs):
            assert all(getattr(after, name) >= getattr(before, name) for name in ("bake_s", "frame_s", "size_bytes"))
    assert all(math.isfinite(cost.bake_s + cost.relight_s + cost.frame_s) for cost in costs)


def test_T5_open_vertices_cost_no_rays(model: CostModel) -> None:
    closed, open_ = (model.predict(Setting("sh"), 1000, 1000, occluded=share) for share in (1.0, 0.0))
    scale = (2000 / PROFILE_FACES) ** MAP_POWER
    assert closed.bake_s - open_.bake_s == pytest.approx(1000 * scale * model.rate("visibility", 32))


def test_another_brdf_costs_no_rays(model: CostModel) -> None:
    """The price is that of an open model, where no ray is cast, but for finding that it is open."""
    size = 20_000, 500_000
    receivers_s = size[0] * model.rate("receivers")
    for setting in (
        Setting("wavelet", {"terms": 4, "coefficients": 96, "cube": 64}),
        Setting("gaussian", {"lobes": 1, "interreflection": 0}),
    ):
        closed = model.predict(setting, *size)
        assert closed.another_s == pytest.approx(model.predict(setting, *size, occluded=0.0).bake_s - receivers_s)
        assert closed.another_s is not None
        assert 0.0 < closed.another_s < closed.bake_s
    sh = {"order": 5, "interreflection": 0}
    assert model.predict(Setting("sh", sh), *size).another_s is None
    bounced = model.predict(Setting("sh", {**sh, "interreflection": 1}), *size)
    assert bounced.another_s == bounced.bake_s


def test_a_kept_model_is_found_again(model: CostModel, tmp_path: Path) -> None:
    scaled = replace(model, calibrated=False, measured_at_s=1e9, bakes={"sh": (0.3, 2)}, frames={"direct": (-0.2, 3)})
    save(scaled, tmp_path / "new" / "cost.json")
    assert load_model(tmp_path / "new" / "cost.json") == scaled


def test_a_profile_expires(model: CostModel) -> None:
    quiet = replace(model, measured_at_s=1e9)
    assert not quiet.is_expired(1e9)
    assert not quiet.is_expired(1e9 + 29 * 86_400)
    assert quiet.is_expired(1e9 + 31 * 86_400)
    assert quiet.is_expired(1e9 - 1.0), "a clock that was set back says nothing of the age"
    assert replace(quiet, calibrated=False).within > quiet.within


def test_bakes_teach_what_they_take(model: CostModel) -> None:
    """Bakes that take twice the predicted time are predicted by then, whatever the first one took."""
    asked = Setting("sh"), 200_000, 1000
    learned, usual = model, model.predict(*asked)
    for _ in range(12):
        learned = learned.learn("sh", learned.predict(*asked).bake_s, 2.0 * usual.bake_s)
    found = learned.predict(*asked)
    assert usual.bake_s > TEACHES_S
    assert found == replace(usual, bake_s=found.bake_s)
    assert found.bake_s == pytest.approx(2.0 * usual.bake_s)
    assert learned.bakes["sh"][1] == REMEMBERED
    wavelets = Setting("wavelet")
    assert learned.predict(wavelets, 1000, 1000) == model.predict(wavelets, 1000, 1000)


def test_frames_teach_what_they_take(model: CostModel) -> None:
    """Frames of half the predicted time are predicted by then, and nothing of a bake or of another mode changes."""
    for mode in ("sh", "direct", "reference"):
        asked = Setting(mode), 5000, 4_000_000
        learned, usual = model, model.predict(*asked)
        assert usual.frame_s > FRAME_TEACHES_S
        for _ in range(12):
            learned = learned.learn_frame(mode, learned.predict(*asked).frame_s, 0.5 * usual.frame_s)
        found = learned.predict(*asked)
        assert found == replace(usual, frame_s=found.frame_s)
        assert found.frame_s == pytest.approx(0.5 * usual.frame_s)
        assert learned.predict(Setting("wavelet"), 1000, 1000) == model.predict(Setting("wavelet"), 1000, 1000)
    assert model.learn_frame("sh", 1e-3, 2e-3) is model


def test_short_bakes_teach_nothing_and_odd_ones_little(model: CostModel) -> None:
    assert model.learn("sh", 0.1, 0.3) is model
    assert model.learn("sh", 1.0, 1e6).bakes["sh"][0] == pytest.approx(math.log(MAX_CORRECTED))


@pytest.mark.parametrize(
    ("loads", "kept"), [((0.0, 0.9), 0), ((0.4, 0.05, 0.0), 1), ((0.4, 0.5, 0.3, 0.0), 2), ((0.4, 0.5, 0.6), 0)]
)
def test_the_part_counts_that_others_disturbed_least(
    loads: tuple[float, ...], kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    told, rounds = iter(loads), iter(range(len(loads)))
    monkeypatch.setattr(machine_profile, "background_load", lambda _before, _after: next(told))

    def measure(tables: machine_profile.Tables) -> Steps[int]:
        yield Step(0.0, "measuring")
        number = next(rounds)
        tables["ray"] = ((1.0, float(number)),)
        return number

    tables: machine_profile.Tables = {}
    result, share = drain(machine_profile.quietest(measure, tables))
    assert (result, share.load, tables) == (kept, loads[kept], {"ray": ((1.0, float(kept)),)})


def test_other_programs_are_found_from_seconds_of_processors() -> None:
    """Two CPUs for 10 s, 12 s of 20 used, 8 of them by this process."""
    assert background_load((100.0, 30.0, 1000.0), (112.0, 38.0, 1020.0)) == pytest.approx(0.2)
    assert background_load(read_clock(), read_clock()) <= 1.0


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
    for rates in ([[16, -1.0]], [[16, 1.0], [8, 1.0]], [], [[0, 1.0], [8, 1.0]], [[16, math.nan]], [[16, 1e300]]):
        damage = {"visibility": rates}
        path.write_text(json.dumps({**record, "tables": {**record["tables"], **damage}}))
        assert load_model(path) is None


def test_rays_on_a_mesh_of_more_triangles_are_dearer(model: CostModel) -> None:
    """16 times the triangles double the time of a ray; a cube map of them takes the root of that more."""
    few, many = Load(1000, 1, PROFILE_FACES), Load(1000, 1, 16 * PROFILE_FACES)
    assert (few.ray_scale, few.map_scale) == (1.0, 1.0)
    assert many.ray_scale == pytest.approx(16**RAY_POWER) == pytest.approx(2.0)
    assert model.rays_s(32, many) - model.rays_s(32, few) == pytest.approx(
        1000 * model.rate("visibility", 32) * (16**MAP_POWER - 1.0)
    )


def test_T1_the_quick_profile_is_that_of_the_machine_whose_rates_are_shipped(monkeypatch: pytest.MonkeyPatch) -> None:
    """Probes that take twice as long make every bake twice as long; twice the threads halve what they share."""
    shipped = machine_profile.read_shipped()
    slower = {name: 2.0 * seconds for name, seconds in shipped.probes.items()}
    monkeypatch.setattr(machine_profile, "measure_probes", lambda: slower)
    monkeypatch.setattr(machine_profile, "measure_frame", lambda: ("processor", 3.0 * shipped.frame_s["processor"]))
    monkeypatch.setattr(machine_profile, "threads", lambda: 4 * shipped.threads)
    found = drain(machine_profile.quick_profile())
    assert not found.calibrated
    assert found.tables["ray"][0][1] == pytest.approx(2.0 * shipped.tables["ray"][0][1])
    assert found.tables["visibility"][0][1] == pytest.approx(0.5 * shipped.tables["visibility"][0][1])
    kept = shipped.frames["processor"]["direct-base"][0][1]
    assert found.tables["direct-base"][0][1] == pytest.approx(0.75 * kept)


def test_T1_probes_count_the_seconds_of_the_processor_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """A clock that stands still while other programs have the CPU tells the same time beside them."""
    import threading

    def turn(until: threading.Event) -> None:
        while not until.is_set():
            sum(range(1000))

    alone = machine_profile.measure_probes()
    until = threading.Event()
    others = [threading.Thread(target=turn, args=(until,)) for _ in range(3)]
    for each in others:
        each.start()
    beside = machine_profile.measure_probes()
    until.set()
    for each in others:
        each.join()
    assert alone.keys() == beside.keys() == {"rays", "matrices"}
    assert all(beside[name] < 3.0 * alone[name] for name in alone)


def test_a_path_goes_on_as_often_as_hemispheres_are_closed(model: CostModel) -> None:
    """1 + c + c² points where it may touch three, none after the first where all is open."""
    setting, point_s = Setting("reference", {"samples": 10}), model.rate("reference-point")

    def frame_s(closed: float, depth: int) -> float:
        return model.predict(setting, 1000, 100, closed=closed, depth=depth, covered=0.5).frame_s

    assert frame_s(0.3, 3) - frame_s(0.3, 1) == pytest.approx(10 * 100 * 0.5 * (0.3 + 0.09) * point_s)
    assert frame_s(0.0, 3) == frame_s(0.3, 1)
    empty = model.predict(setting, 1000, 100, covered=0.0).frame_s
    assert empty == pytest.approx(model.rate("reference-picture") + 10 * 100 * model.rate("reference-miss"))


@pytest.mark.parametrize("setting", [Setting("sh"), Setting("wavelet"), Setting("gaussian")])
def test_turned_light_grows_with_its_map_and_not_with_pixels(model: CostModel, setting: Setting) -> None:
    small, large, sharp = (
        model.predict(setting, 1000, pixels, texels=texels).relight_s
        for pixels, texels in ((100, 2 * 256**2), (100, 2 * 512**2), (1000, 2 * 512**2))
    )
    parameter = {"sh": 5, "wavelet": 64, "gaussian": 8}[setting.mode]
    name = "light-wavelet-texel" if setting.mode == "wavelet" else "light-sh-texel"
    assert large - small == pytest.approx(2 * (512**2 - 256**2) * model.rate(name, parameter))
    assert sharp == large


def test_tables_that_outlive_a_bake_are_not_made_twice(model: CostModel) -> None:
    first, later = (model.predict(Setting("sh"), 1000, 1000, tables_made=made).bake_s for made in (False, True))
    assert first - later > model.rate("sh-products", 5)


def test_loads_that_cannot_be_are_refused(model: CostModel) -> None:
    with pytest.raises(ValueError, match="make no load"):
        model.predict(Setting("sh"), 0, 100)
    for wrong in ({"occluded": 1.5}, {"covered": math.nan}, {"ground": 11}, {"depth": 0}, {"texels": 0}):
        with pytest.raises(ValueError, match="make no load"):
            model.predict(Setting("sh"), 10, 100, **wrong)
