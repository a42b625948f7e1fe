"""`lightarc import` as a user or a script meets it."""

import argparse
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest
import tifffile

from app.cli import import_
from engine.capture.chart.find import find_chart
from engine.capture.stack import open_stack
from engine.core.colour import LUMINANCE
from engine.images.encode import encode_png
from tests.app.command import replace_options
from tests.engine.capture.chart.chart_images import photograph
from tests.engine.images import profiles

KEYS = [
    "images", "height_px", "width_px", "elevations_deg", "angle_source", "alignment_residual_px", "clipped_fraction",
    "black_fraction", "mean_radiance", "working_space", "gamut", "profiles", "chart", "lens", "polarisation", "scale",
    "calibration", "warnings", "time_s", "peak_memory_bytes",
]  # fmt: skip


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("photographs")
    noise = np.random.default_rng(0).normal(size=(90, 110)).astype(np.float32)
    surface = 1 + 0.2 * cv2.GaussianBlur(noise, (0, 0), 2.0) / 0.14
    for number, level in enumerate((20, 60, 255, 110)):
        codes = np.clip(level * np.repeat(surface[..., None], 3, axis=2), 0, 255).astype(np.uint8)
        codes[:10] = 0
        (folder / f"IMG_{number:04}.png").write_bytes(cv2.imencode(".png", codes)[1].tobytes())
    return folder


def test_json_has_the_promised_keys_and_photographs_in_the_order_of_elevation(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path
) -> None:
    done = lightarc("import", photographs, "-o", tmp_path / "s", "--angles-deg", "10,30,70,50", "--no-align", "--json")
    assert done.code == 0
    result = json.loads(done.out)
    assert list(result) == KEYS
    assert (result["images"], result["height_px"], result["width_px"]) == (4, 90, 110)
    assert result["elevations_deg"] == pytest.approx([10, 30, 50, 70])
    assert result["angle_source"] == "user"
    assert result["mean_radiance"] == sorted(result["mean_radiance"])
    assert result["alignment_residual_px"] == [None] * 4
    assert result["black_fraction"] == pytest.approx([10 / 90] * 4, abs=1e-3)
    assert result["clipped_fraction"][:2] == [0, 0]
    assert 0.3 < result["clipped_fraction"][3] < 0.6
    assert any("IMG_0002.png" in warning and "clipped" in warning for warning in result["warnings"])
    assert result["peak_memory_bytes"] > 50e6


def test_a_band_becomes_a_stack_of_its_own(lightarc: Callable[..., SimpleNamespace], tmp_path: Path) -> None:
    surface = np.random.default_rng(1).uniform(0.2, 0.4, (48, 64, 8)) * np.linspace(0.3, 1.0, 8)
    folder = tmp_path / "bands"
    folder.mkdir()
    for angle in (20, 50, 80):
        codes = np.rint(65535 * surface * np.sin(np.radians(angle))).astype(np.uint16)
        tifffile.imwrite(folder / f"leaf_{angle}deg.tif", codes, photometric="minisblack", planarconfig="contig")
    arguments = ("import", folder, "--no-align", "--transfer", "linear", "--json", "--bands")
    done = lightarc(*arguments, "7", "-o", tmp_path / "infrared")
    assert done.code == 0
    result = json.loads(done.out)
    assert not any("band" in warning for warning in result["warnings"])
    expected = [surface[..., 6].mean() * np.sin(np.radians(angle)) for angle in (20, 50, 80)]
    assert result["mean_radiance"] == pytest.approx(expected, rel=1e-4)
    refused = lightarc(*arguments, "7,8,9", "-o", tmp_path / "none")
    assert refused.code == 3
    assert "leaf_20deg.tif: holds 8 bands, and no band 9" in refused.err
    assert lightarc(*arguments, "1,x,3", "-o", tmp_path / "none").code == 2


def test_a_colour_profile_is_applied_and_named_once(lightarc: Callable[..., SimpleNamespace], tmp_path: Path) -> None:
    surface = np.random.default_rng(1).uniform(0.2, 0.4, (48, 64, 3))
    folder = tmp_path / "prophoto"
    folder.mkdir()
    profile = profiles.matrix_profile("ProPhoto RGB", "ProPhoto RGB")
    levels = [surface * np.sin(np.radians(angle)) for angle in (20, 50, 80)]
    for angle, level in zip((20, 50, 80), levels, strict=True):
        codes = np.rint(65535 * level).astype(np.uint16)
        tifffile.imwrite(folder / f"leaf_{angle}deg.tif", codes, photometric="rgb", iccprofile=profile)
    arguments = ("import", folder, "--no-align", "-o", tmp_path / "stack")
    result = json.loads(lightarc(*arguments, "--json").out)
    assert (result["profiles"], result["working_space"]) == (["ProPhoto RGB with ProPhoto RGB curve"], "linear Rec.709")
    assert not any("rofile" in warning for warning in result["warnings"])
    truth = [profiles.matrix_truth("ProPhoto RGB", "ProPhoto RGB", level).mean(axis=(0, 1)) for level in levels]
    assert result["mean_radiance"] == pytest.approx([colour @ LUMINANCE for colour in truth], rel=1e-3)
    record = json.loads((tmp_path / "stack" / "stack.json").read_text())
    assert {each["profile"] for each in record["provenance"]["photographs"]} == set(result["profiles"])
    shutil.rmtree(tmp_path / "stack")
    text = lightarc(*arguments, "--transfer", "linear").out
    assert "profile: ProPhoto RGB with ProPhoto RGB curve, applied" in text


def test_a_colour_chart_corrects_this_capture_and_the_next(
    lightarc: Callable[..., SimpleNamespace], tmp_path: Path
) -> None:
    image, _ = photograph(np.random.default_rng(4), "A")
    folder = tmp_path / "chart"
    folder.mkdir()
    for angle in (20, 50, 80):
        codes = np.rint(65535 * np.clip(image * np.sin(np.radians(angle)), 0, 1)).astype(np.uint16)
        tifffile.imwrite(folder / f"leaf_{angle}deg.tif", codes, photometric="rgb")
    arguments = ("import", folder, "--no-align", "--transfer", "linear", "--json", "-o", tmp_path / "stack")
    done = lightarc(*arguments, "--chart", "auto", "--write-chart", tmp_path / "lamps.chart")
    result = json.loads(done.out)
    assert result["chart"]["photograph"] == "leaf_80deg.tif"
    assert result["chart"]["summary"]["after"]["mean"] < 1.0 < result["chart"]["summary"]["before"]["mean"]
    stack = open_stack(tmp_path / "stack")
    corrected = np.array(stack.radiance[-1], np.float64)
    chart = find_chart(corrected.astype(np.float32), np.asarray(stack.saturated[-1]))
    assert chart is not None
    assert np.nanmean(chart[1].before) < 2.0  # the light on the chart is uneven, colours are right
    done = lightarc(
        *(*arguments, "--overwrite", "--chart", tmp_path / "lamps.chart", "--write-chart", tmp_path / "page.html")
    )
    assert json.loads(done.out)["chart"] == result["chart"]
    np.testing.assert_array_equal(open_stack(tmp_path / "stack").radiance[-1], corrected)
    assert "yellow green" in (tmp_path / "page.html").read_text()
    none = lightarc(*arguments, "--overwrite", "--crop", "0,0,20,20", "--chart", folder / "leaf_20deg.tif", "--strict")
    assert none.code == 0  # a crop is of the photographs of the sample, not of the chart's
    refused = lightarc(*arguments, "--overwrite", "--write-chart", tmp_path / "a.chart")
    assert refused.code == 2
    assert "--chart" in refused.err


def test_table_for_users(lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path) -> None:
    done = lightarc("import", photographs, "-o", tmp_path / "s", "--crop", "0,20,100,60", "--trust-angles")
    assert done.code == 0
    assert "4 photographs" in done.out
    assert "are assumed" in done.out
    assert "because a user said so" in done.out
    assert " px" in done.out


def test_a_near_lamp_on_an_unknown_side_is_warned_of(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path
) -> None:
    done = lightarc("import", photographs, "-o", tmp_path / "s", "--no-align", "--lamp-distance", "2", "--trust-angles")
    assert done.code == 0
    assert "- The lamp is near, but nothing says on which side it stood" in done.out
    assert "which side" not in lightarc("import", photographs, "-o", tmp_path / "t", "--no-align", "--trust-angles").out


@pytest.mark.parametrize(
    ("words", "size"),
    [
        (("--corners", "5,12,95,12,95,72,5,72"), (60, 90)),
        (("--corners", "5,12,95,14,90,72,8,70", "--size", "40x30"), (30, 40)),
        (("--crop", "10,20,60,40", "--size", "30x20"), (20, 30)),
    ],
)
def test_images_are_framed(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path, words: Any, size: Any
) -> None:
    done = lightarc("import", photographs, "-o", tmp_path / "s", "--no-align", "--trust-angles", "--json", *words)
    assert done.code == 0
    result = json.loads(done.out)
    assert (result["height_px"], result["width_px"]) == size


@pytest.mark.parametrize(
    "words",
    [("--corners", "0,0,1,1"), ("--corners", "0,0,0,9,9,9,9,0"), ("--size", "3"), ("--size", "30x20"),
     ("--corners", "5,12,95,12,95,72,5,72", "--crop", "1,1,9,9")],
)  # fmt: skip
def test_impossible_frames_are_wrong_usage(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path, words: Any
) -> None:
    done = lightarc("import", photographs, "-o", tmp_path / "s", *words)
    assert (done.code, done.out) == (2, "")
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("--angles-deg", "10,x"), ("--crop", "1,2,3"), ("--crop", "0,0,0,5"), ("--motion", "spline"),
        ("--white-balance", "1,2"), ("--white-balance", "1,0,nan"), ("--transfer", "gamma"),
        ("--azimuth", "up"), ("--azimuth", "400"), ("--azimuth", "90±200"), ("--lights", "1,,3"),
    ],
)  # fmt: skip
def test_wrong_usage(lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path, words: Any) -> None:
    done = lightarc("import", photographs, "-o", tmp_path / "s", *words)
    assert done.code == 2
    assert words[0] in done.err
    assert not (tmp_path / "s").exists()


def test_bad_input_names_file_and_remedy(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path
) -> None:
    for words in ((tmp_path / "nowhere",), (photographs, "--angles-deg", "1,2"), (photographs, "-o", photographs)):
        done = lightarc("import", *replace_options(("-o", tmp_path / "s"), words), *words)
        assert (done.code, done.out) == (3, "")
        assert done.err.count("\n") == 1
    assert not (tmp_path / "s").exists()
    assert len(list(photographs.iterdir())) == 4


def leave(folder: Path) -> list[Any]:
    return sorted(path.name for path in folder.rglob("*") if path.is_file())


def test_interrupted_import_leaves_nothing(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from engine.capture import import_stack

    def interrupt(*_arguments: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(import_stack, "_record", interrupt)
    assert lightarc("import", photographs, "-o", tmp_path / "s", "--trust-angles").code == 4
    assert leave(tmp_path) == []


def test_help_says_what_the_lists_mean() -> None:
    parser = argparse.ArgumentParser(epilog="example")
    import_.add_arguments(parser)
    for key in KEYS:
        assert key in parser.format_help()


def test_an_archive_is_imported_and_nothing_of_it_is_left_behind(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path
) -> None:
    archive = Path(shutil.make_archive(str(tmp_path / "shots"), "gztar", photographs))
    words = ("--angles-deg", "10,30,70,50", "--no-align", "--json")
    done = lightarc("import", archive, "-o", tmp_path / "s", *words)
    assert done.code == 0
    assert json.loads(done.out)["images"] == 4
    provenance = json.loads((tmp_path / "s" / "stack.json").read_text())["provenance"]
    assert provenance["archive"] == "shots.tar.gz"
    assert [one["member"] for one in provenance["photographs"]] == [f"IMG_{n:04}.png" for n in (0, 1, 3, 2)]
    assert leave(tmp_path) == ["codes.npy", "shots.tar.gz", "stack.json"]


def test_a_damaged_archive_is_refused_in_a_sentence(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, tmp_path: Path
) -> None:
    archive = Path(shutil.make_archive(str(tmp_path / "shots"), "zip", photographs))
    archive.write_bytes(archive.read_bytes()[:-40])
    done = lightarc("import", archive, "-o", tmp_path / "s")
    assert done.code == 3
    assert "shots.zip: is cut short" in done.err
    assert not (tmp_path / "s").exists()


@pytest.mark.parametrize("below", ["", "stack", "a/b"])
@pytest.mark.parametrize("as_files", [False, True])
def test_nothing_is_written_into_the_folder_of_photographs(
    lightarc: Callable[..., SimpleNamespace], photographs: Path, below: str, as_files: bool
) -> None:
    before = sorted(photographs.rglob("*"))
    given = sorted(photographs.glob("*.png")) if as_files else [photographs]
    done = lightarc("import", *given, "-o", photographs / below)
    assert done.code == 3
    assert "is read by this command" in done.err
    assert sorted(photographs.rglob("*")) == before


@pytest.mark.parametrize(("size", "motion"), [((31, 40), "auto"), ((1, 1), "homography")])
def test_photographs_too_small_to_be_aligned_stay_as_they_were(
    lightarc: Callable[..., SimpleNamespace], tmp_path: Path, size: Any, motion: str
) -> None:
    (tmp_path / "small").mkdir()
    for angle in (10, 30, 50, 70, 90):
        codes = np.random.default_rng(angle).integers(0, 600 * angle, (*size, 3), dtype=np.uint16)
        (tmp_path / "small" / f"x_{angle}deg.png").write_bytes(encode_png(codes))
    done = lightarc("import", tmp_path / "small", "-o", tmp_path / "s", "--motion", motion, "--json")
    assert done.code == 0, done.err
    found = json.loads(done.out)
    assert (found["height_px"], found["width_px"]) == size
    assert any("smaller than 32" in text for text in found["warnings"])
    assert found["alignment_residual_px"] == [None] * 5


@pytest.mark.parametrize(
    ("words", "elevations"),
    [
        (("--azimuth", "90±10"), [20, 40, 60]),
        (("--azimuth", "90+-10"), [20, 40, 60]),
        (("--azimuth", "0"), [30, 50]),
        (("--arc",), [20, 40, 60]),
        (("--lights", "1-2,IMG_0004.png"), [20, 40, 50]),
    ],
)
def test_lights_of_a_dome_are_chosen(
    lightarc: Callable[..., SimpleNamespace], tmp_path: Path, words: Any, elevations: Any
) -> None:
    (tmp_path / "dome").mkdir()
    lights = [(20, 90), (40, 95), (60, 84), (50, 0), (30, 1)]
    lines = [str(len(lights))]
    for number, (elevation, azimuth) in enumerate(lights, 1):
        codes = np.random.default_rng(number).integers(0, 65536, (20, 20, 3), dtype=np.uint16)
        (tmp_path / "dome" / f"IMG_{number:04}.png").write_bytes(encode_png(codes))
        flat, up, height = (f(np.radians(a)) for f, a in ((np.cos, elevation), (np.sin, azimuth), (np.sin, elevation)))
        lines.append(f"IMG_{number:04}.png {flat * np.cos(np.radians(azimuth))} {flat * up} {height}")
    (tmp_path / "dome" / "dome.lp").write_text("\n".join(lines))
    done = lightarc("import", tmp_path / "dome", "-o", tmp_path / "s", "--no-align", "--trust-angles", "--json", *words)
    assert done.code == 0, done.err
    assert json.loads(done.out)["elevations_deg"] == pytest.approx(elevations)
