"""Our table file: every bit back, distinguished from images, hostile records refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.microfacet import Ggx
from engine.brdf.readers.read import read_brdf
from engine.brdf.readers.table_file import FINGERPRINT, RECORD, _fingerprint, read_table, write_table
from engine.brdf.resample import random_pairs, table_from
from engine.brdf.table import DirectionTable, HalfDifferenceTable, missing_health
from engine.core.errors import InputError
from engine.images.encode import encode_exr
from tests.engine.brdf.test_table import direction_table, random_table


def make_holed_table(dtype: Any = np.float32) -> HalfDifferenceTable:
    table = random_table((7, 5, 12), dtype)
    missing = np.random.default_rng(1).random((7, 5, 12)) < 0.2
    return HalfDifferenceTable(table.values, missing, "blue, “quoted” \n paint", "MERL table", missing_health(missing))


def test_a_float32_table_comes_back_bit_for_bit(tmp_path: Path) -> None:
    table = make_holed_table()
    written = write_table(tmp_path / "paint.exr", table)
    again = read_brdf(tmp_path / "paint.exr")
    assert isinstance(again, HalfDifferenceTable)
    for one in (written, again):
        assert one.values.dtype == np.float32
        assert np.array_equal(one.values, table.values)
        assert np.array_equal(one.missing, table.missing)
        assert (one.name, one.kind) == (table.name, table.kind)
        assert one.health == table.health
    wi, wo = random_pairs(1000)
    assert np.array_equal(again.f(wi, wo), table.f(wi, wo))


def test_float64_is_rounded_once_and_says_so(tmp_path: Path) -> None:
    table = make_holed_table(np.float64)
    written = write_table(tmp_path / "paint.exr", table)
    again = read_table(tmp_path / "paint.exr")
    assert np.array_equal(again.values, table.values.astype(np.float32))
    assert "rounded from float64" in again.health.findings[-1].text
    assert write_table(tmp_path / "twice.exr", again).health == written.health
    assert (tmp_path / "twice.exr").read_bytes() == (tmp_path / "paint.exr").read_bytes()


def test_a_table_in_four_angles_comes_back(tmp_path: Path) -> None:
    table = direction_table()
    single = DirectionTable(
        table.theta_i, table.phi_i, table.theta_o, table.phi_o, table.values.astype(np.float32), table.missing
    )
    write_table(tmp_path / "cloth.exr", single)
    again = read_brdf(tmp_path / "cloth.exr")
    assert isinstance(again, DirectionTable)
    for name in ("theta_i", "phi_i", "theta_o", "phi_o", "values", "missing"):
        assert np.array_equal(getattr(again, name), getattr(single, name))


def test_any_model_becomes_a_table_with_a_measured_error(tmp_path: Path) -> None:
    exact = table_from(Lambert(albedo=(0.2, 0.5, 0.8)), (10, 10, 10))
    assert exact.health.figures["resampling_rms_rel"] <= 1e-15
    assert exact.name == "lambert"
    model = Ggx(alpha=0.3)
    fine = table_from(model, name="shiny", dtype=np.float32)
    coarse = table_from(model, (30, 30, 60))
    figures = [table.health.figures["resampling_rms_rel"] for table in (fine, coarse)]
    assert figures[0] < 0.01
    assert figures[1] / figures[0] > 4.0
    wi, wo = random_pairs(20_000, seed=5)
    measured = np.sqrt(np.mean((fine.f(wi, wo) - model.f(wi, wo)) ** 2) / np.mean(model.f(wi, wo) ** 2))
    assert measured == pytest.approx(figures[0], rel=0.3)
    write_table(tmp_path / "shiny.exr", fine)
    assert np.array_equal(read_table(tmp_path / "shiny.exr").values, fine.values)


def test_an_anisotropic_brdf_is_averaged_with_a_warning() -> None:
    table = table_from(direction_table(), (6, 6, 8))
    assert any("anisotropic" in warning for warning in table.health.warnings)
    assert any("not reciprocal" in finding.text for finding in table.health.findings)


def parts(path: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: np.array(channel.pixels) for name, channel in file.parts[0].channels.items()}
        return channels, json.loads(file.parts[0].header[RECORD])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"shape": [7, 5, 13]}, "has no channel R of 13 × 35 floats"),
        ({"shape": [1 << 20, 1 << 20, 1 << 20]}, "states an impossible table"),
        ({"shape": [7, 5, 0]}, "faulty attribute brdfTable: shape.2"),
        ({"shape": [7, 5]}, "faulty attribute brdfTable: shape"),
        ({"shape": [7, 5, 3, 4]}, "states an impossible table"),
        ({"layout": "directions", "shape": [7, 5, 3, 4]}, "states 0 grids"),
        ({"layout": "directions", "shape": [7, 5, 3, 4], "grids": [[0.0]] * 4}, "holds a table that cannot be"),
        ({"layout": "directions", "shape": [7, 5, 3, 4], "grids": [[1e400]] * 4}, "faulty attribute brdfTable: grids"),
        ({"missing": 3}, "holds a table that cannot be: 3 entries are said to be missing"),
        ({"version": 2}, "faulty attribute brdfTable: version"),
        ({"name": "x" * 2000}, "faulty attribute brdfTable: name"),
        ({"surprise": 1}, "faulty attribute brdfTable: surprise"),
    ],
)
def test_a_hostile_record_is_refused(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    path = tmp_path / "table.exr"
    write_table(path, make_holed_table())
    channels, record = parts(path)
    text = json.dumps(record | change)
    path.write_bytes(
        encode_exr(channels, half=False, attributes={RECORD: text, FINGERPRINT: _fingerprint(text, channels)})
    )
    with pytest.raises(InputError) as error:
        read_brdf(path)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0, 1e31])
def test_values_that_cannot_be_are_refused(tmp_path: Path, value: float) -> None:
    path = tmp_path / "table.exr"
    write_table(path, make_holed_table())
    channels, record = parts(path)
    channels["G"][3, 4] = value
    text = json.dumps(record)
    path.write_bytes(
        encode_exr(channels, half=False, attributes={RECORD: text, FINGERPRINT: _fingerprint(text, channels)})
    )
    with pytest.raises(InputError, match="holds a table that cannot be: the values must lie in"):
        read_table(path)


def test_a_changed_pixel_is_noticed_and_a_image_is_no_table(tmp_path: Path) -> None:
    path = tmp_path / "table.exr"
    write_table(path, make_holed_table())
    channels, record = parts(path)
    attributes = {RECORD: json.dumps(record), FINGERPRINT: _fingerprint(json.dumps(record), channels)}
    channels["B"][0, 0] += 1e-3
    path.write_bytes(encode_exr(channels, half=False, attributes=attributes))
    with pytest.raises(InputError, match="its fingerprint does not fit"):
        read_table(path)
    path.write_bytes(encode_exr(channels, half=False))
    with pytest.raises(InputError, match="is not a measured BRDF of a known format"):
        read_brdf(path)
    with pytest.raises(InputError, match="without the attribute brdfTable"):
        read_table(path)
