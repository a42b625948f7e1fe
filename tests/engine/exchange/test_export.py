"""The export as a whole: what is measured, and against what."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.core.figure_text import number, percent
from engine.core.steps import drain
from engine.exchange.export import NAMES, RECORD, Offer, choice, export, warn_of_averaged_normals
from engine.exchange.loss import statement
from engine.shading.mixed import keep_tiles
from engine.surface.pbr_maps import PbrMaps

from .materials import R_MAX, dome_material, dome_stack, linear_material, woven_law, woven_material

BLACK = np.zeros((6, 5, 3), np.float32)


def test_photographs_from_all_sides_give_normals_and_height(tmp_path: Path) -> None:
    """The surface is measured where the stack is at hand, and the record has the error against the photographs."""
    material, stack = dome_material(), dome_stack(48, 40)
    record = drain(export(tmp_path / "out", dome_material(48, 40), ["textures", "shaders"], stack=stack))
    textures, shaders = record["targets"]
    assert any(name.endswith("_height.png") for name in textures["files"])
    assert not any("flat" in warning for warning in textures["warnings"])
    assert textures["rmse_rel"] < 0.15
    assert shaders["rmse_rel"] == pytest.approx(record["material"]["rmse_rel"])
    assert shaders["rmse_rel"] < 0.05
    assert material.directional is not None


def test_a_stack_of_another_size_is_not_compared(tmp_path: Path) -> None:
    record = drain(export(tmp_path / "out", woven_material(), ["shaders"], stack=dome_stack()))
    (shaders,) = record["targets"]
    assert shaders["rmse_rel"] is None
    assert any("not compared with the photographs" in warning for warning in shaders["warnings"])
    assert shaders["rmse_rel_reference"] == 0.0
    assert json.loads((tmp_path / "out" / RECORD).read_text())["targets"] == record["targets"]


def test_the_statement_has_the_figures() -> None:
    errors = {
        "rmse_rel": 0.5,
        "rmse_rel_reference": 0.213,
        "flip": 0.38,
        "by_environment": {"studio": {}, "noon": {}},
    }
    words = statement(errors)
    assert "under studio, noon: relative RMSE 21.3 %, FLIP 0.38; against the photographs: relative RMSE 50 %." in words
    assert words.isascii()


def test_unknown_targets_are_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=", ".join(NAMES)):
        drain(export(tmp_path / "out", woven_material(), ["fbx"]))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("error", [0.02, 0.9])
def test_auto_takes_the_smallest_within_the_budget(tmp_path: Path, error: float) -> None:
    """The power law is exact here; the budget of 90 % is kept by all, and the fewest bytes of any target count."""
    record = drain(export(tmp_path / "out", woven_material(), ["auto"], error=error))
    (made,) = record["targets"]
    rows = {row["target"]: row for row in record["auto"]["candidates"]}
    assert set(rows) == set(NAMES) - {"brdf", "rti"}
    kept = [name for name, row in rows.items() if row["rmse_rel_reference"] <= error]
    chosen = min(kept, key=lambda name: int(rows[name]["bytes"]))
    assert made["target"] == record["auto"]["chosen"] == chosen
    assert made["bytes"] == rows[chosen]["bytes"]
    assert made["rmse_rel_reference"] <= error
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted([RECORD, chosen])


def test_slices_count_where_shaders_hold_them(tmp_path: Path) -> None:
    """The power law here says nothing of the slices beside it, which GLSL and HLSL look up without any error."""
    slices = linear_material((0.5, 0.4, 0.3), "lambert")
    law = dataclasses.replace(woven_law(6, 5), r_max=R_MAX)
    record = drain(export(tmp_path / "out", dataclasses.replace(slices, power_law=law), ["auto"], error=0.0))
    (made,) = record["targets"]
    assert (made["target"], record["auto"]["within"]) == ("shaders", True)
    assert [row["target"] for row in record["auto"]["candidates"] if row.get("by") == "slices"] == ["shaders"]
    assert made["slices"]["rmse_rel_reference"] == 0.0
    assert made["rmse_rel_reference"] > 0.3
    assert any("the slices next to it are 0 % away in GLSL and HLSL" in words for words in made["warnings"])


def test_what_files_show_in_place_of_the_material_is_said(tmp_path: Path) -> None:
    """PBR maps are another model; a power law is the material itself, but not where its light is summed up first."""
    record = drain(export(tmp_path / "out", woven_material(), ["gltf", "blender", "shaders", "brdf"]))
    gltf, blender, shaders, brdf = record["targets"]
    for made in (gltf, blender):
        error = percent(made["rmse_rel_reference"], 3)
        assert any(words.startswith(f"what these files show is {error} away") for words in made["warnings"])
    error = percent(blender["power_law"]["rmse_rel_reference"], 3)
    assert blender["power_law"]["rmse_rel_reference"] > 0.01
    assert f"the power law behind Shader to RGB is {error} away from the material" in blender["warnings"]
    assert shaders["warnings"] == []
    assert "rmse_rel: null without photographs" in shaders["errors_are"]
    assert brdf["rmse_rel"] is None
    assert "no texels to compare" in brdf["errors_are"]


def test_kept_tiles_are_not_counted_where_they_are_not_shown(tmp_path: Path) -> None:
    """GLSL looks the slices of tiles up; pages, HLSL and OSL show the power law there, which is far off here."""
    slices = linear_material((0.5, 0.4, 0.3), "lambert", height=8, width=8)
    assert slices.shading_map is not None
    law = dataclasses.replace(woven_law(8, 8), r_max=R_MAX)
    mixed = dataclasses.replace(slices, power_law=drain(keep_tiles(law, slices.shading_map, 0.0, size=8)))
    record = drain(export(tmp_path / "out", mixed, ["shaders", "web"]))
    shaders, web = record["targets"]
    assert shaders["rmse_rel_reference"] < 1e-6
    assert shaders["power_law_alone"]["rmse_rel_reference"] == web["rmse_rel_reference"] > 0.3
    error = percent(web["rmse_rel_reference"], 3)
    assert f"what these files show is {error} away" in web["warnings"][0]
    assert any(f"without the tiles that keep their slices is {error} away" in words for words in shaders["warnings"])


def test_light_in_place_of_a_black_material_has_no_relative_error(tmp_path: Path) -> None:
    """PBR maps of black still reflect four hundredths; shaders are as black as it is, and the choice."""
    black = dataclasses.replace(woven_material(6, 5), power_law=dataclasses.replace(woven_law(6, 5), scale=BLACK))
    record = drain(export(tmp_path / "out", black, ["gltf", "shaders"]))
    gltf, shaders = record["targets"]
    assert (gltf["rmse_rel_reference"], shaders["rmse_rel_reference"]) == (None, 0.0)
    assert gltf["flip"] > 0.0
    assert any("these files show light where the material is black" in words for words in gltf["warnings"])
    assert "which is black" in gltf["errors_are"]
    entries = [Offer(entry["target"], entry, None) for entry in record["targets"]]
    assert choice(entries, 0.5)["chosen"] == "shaders"
    assert choice(entries[:1], 0.5)["within"] is False
    assert "undefined" in statement(gltf)


def test_auto_says_where_nothing_keeps_the_budget(tmp_path: Path) -> None:
    record = drain(export(tmp_path / "out", dome_material(), ["auto"], error=0.0))
    assert record["auto"]["chosen"] == "shaders"
    with pytest.raises(UsageError, match="auto chooses the target: give auto alone"):
        drain(export(tmp_path / "other", dome_material(), ["auto", "gltf"]))
    with pytest.raises(UsageError, match="not a number"):
        drain(export(tmp_path / "other", dome_material(), ["auto"], error=float("nan")))


@pytest.mark.parametrize(("slope", "times"), [(0.0, None), (0.3, 24.0), (0.02, None)])
def test_averaged_normals_are_remarked_on_where_they_matter(slope: float, times: float | None) -> None:
    """Slopes of ± 0.3 in x and y have the covariance 0.09 I; with roughness 0.25 the peak is lower by 1 + 0.18 / α²."""
    p, q = np.meshgrid([slope, -slope] * 4, [slope, -slope] * 4)
    normal = np.stack([-p, -q, np.ones_like(p)], axis=-1) / np.sqrt(1.0 + p * p + q * q)[..., None]
    flat = np.full((8, 8), 0.25, np.float32)
    maps = PbrMaps(np.full((8, 8, 3), 0.5, np.float32), normal.astype(np.float32), flat, 0 * flat, 0 * flat + 0.04)
    found = warn_of_averaged_normals(maps)
    if times is None:
        assert found == []
    else:
        expected = 1.0 + 2.0 * slope**2 / 0.25**4
        assert f"{number(expected, 2)} times" in found[0]


def test_a_single_texel_averages_no_normals() -> None:
    one = np.full((1, 1), 0.25, np.float32)
    up = np.array([[[0.0, 0.0, 1.0]]], np.float32)
    assert warn_of_averaged_normals(PbrMaps(np.full((1, 1, 3), 0.5, np.float32), up, one, one, one)) == []


def test_the_background_of_an_object_counts_in_no_error(tmp_path: Path) -> None:
    material, stack = dome_material(24, 20), dome_stack(24, 20)
    mask = np.zeros(material.size, np.bool_)
    mask[4:16, 6:] = True
    radiance = np.where(mask[..., None], stack.radiance[:], np.float32(3.0))
    of_object = dataclasses.replace(material, mask=mask)
    export_it = export(tmp_path, of_object, ["shaders"], stack=dataclasses.replace(stack, radiance=radiance))
    record = drain(export_it)
    (shaders,) = record["targets"]
    assert record["material"]["rmse_rel"] == shaders["rmse_rel"] < 0.1
