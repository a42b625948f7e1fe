"""`lightarc normals` as a user or a script meets it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import OpenEXR
import pytest

from app.cli.normals import report
from app.command_line import main
from engine.core.errors import UsageError
from lightarc import recover_normals

Run = Callable[..., SimpleNamespace]


@pytest.fixture(scope="module")
def dome(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The stack of a simulated dome of 24 lamps; no test changes it."""
    folder = tmp_path_factory.mktemp("dome")
    settings = ("--sample", "leather", "--size", "48", "--azimuths", "8", "--elevations", "3", "--misalignment-px", "0")
    assert main(["simulate", "-o", str(folder / "capture"), *settings]) == 0
    assert main(["import", str(folder / "capture"), "-o", str(folder / "stack")]) == 0
    return folder / "stack"


def test_maps_of_a_dome_are_written_with_their_errors(lightarc: Run, dome: Path, tmp_path: Path) -> None:
    done = lightarc("normals", dome, "-o", tmp_path / "maps", "--json")
    assert done.code == 0, done.err
    result = json.loads(done.out)
    assert result["observed_slopes"] == "both"
    assert sorted(result["files"]) == sorted(path.name for path in (tmp_path / "maps").iterdir())
    assert 0.0 < result["in_sample_rmse_srgb8"] < result["mean_picture_rmse_srgb8"]
    assert result["leave_one_out_rmse_srgb8"] < result["mean_picture_rmse_srgb8"]
    for name in ("normal", "height", "base_colour", "roughness", "specular", "metallic", "occlusion"):
        assert {f"{name}.exr", f"{name}_sigma.exr", f"{name}.png"} <= set(result["files"])
    with OpenEXR.File(str(tmp_path / "maps" / "normal.exr"), separate_channels=True) as file:
        normal = np.stack([file.channels()[name].pixels for name in "RGB"], axis=-1)
    assert normal.shape == (48, 48, 3)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=-1), 1.0, atol=1e-5)
    again = lightarc("normals", dome, "-o", tmp_path / "maps", "--no-errors")
    assert again.code == 0
    assert "normals to" in again.out


def test_maps_are_made_in_the_working_space_of_the_import(lightarc: Run, dome: Path, tmp_path: Path) -> None:
    wide = tmp_path / "stack"
    done = lightarc("import", dome.parent / "capture", "-o", wide, "--working-space", "acescg", "--calibrate", "none")
    assert done.code == 0, done.err
    assert "maps of the surface are made in ACEScg; no colours lie beyond Rec.709" in done.out
    plain, other = (
        lightarc("normals", stack, "-o", tmp_path / f"maps{number}", "--no-errors", "--json")
        for number, stack in enumerate((dome, wide))
    )
    assert (plain.code, other.code) == (0, 0)
    assert "base colours in" not in report(json.loads(plain.out))
    result = json.loads(other.out)
    for share, said in (
        (0.02, "2 % of them beyond Rec.709, clipped in the PNG previews"),
        (0.0, "none of them beyond"),
    ):
        assert f"base colours in ACEScg, {said}" in report({**result, "beyond_rec709_share": share})


def test_one_arc_gives_the_slope_along_it_and_says_so(lightarc: Run, dome: Path, tmp_path: Path) -> None:
    names = [f"leather_azimuth{azimuth:03}_{rise}.tif" for azimuth in range(0, 360, 45) for rise in (15, 45, 75)]
    others = [word for name in names if "azimuth045" not in name for word in ("--exclude", name)]
    done = lightarc("normals", dome, "-o", tmp_path / "maps", *others)
    assert done.code == 0, done.err
    assert "the slope along 45°" in done.out
    assert "shown as flat" in done.out
    assert not (tmp_path / "maps" / "height.exr").exists()


def test_two_lamps_are_refused_and_nothing_is_written(lightarc: Run, dome: Path, tmp_path: Path) -> None:
    names = [f"leather_azimuth{azimuth:03}_{rise}.tif" for azimuth in range(0, 360, 45) for rise in (15, 45, 75)]
    others = [word for name in names[2:] for word in ("--exclude", name)]
    done = lightarc("normals", dome, "-o", tmp_path / "maps", *others)
    assert done.code == 3
    assert "three directions" in done.err
    assert "Traceback" not in done.err
    assert not (tmp_path / "maps").exists()
    assert lightarc("normals", dome, "-o", tmp_path / "maps", "--white", "-1").code == 2


def test_a_level_of_8_bits_is_no_radiance_of_a_card() -> None:
    with pytest.raises(UsageError, match="white 255 seems to be an 8- or 16-bit level; the white level is 1"):
        recover_normals(np.full((12, 4, 4, 3), 0.3, np.float32), lights=np.ones((12, 3)), white=255)
