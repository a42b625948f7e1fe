"""`lightarc shade` as a user or a script meets it."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import cv2
import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.microfacet import Ggx
from engine.brdf.readers.table_file import write_table
from engine.brdf.resample import table_from
from engine.bundle.bundle import open_bundle
from engine.bundle.manifest import describe_bundle
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.stack import open_stack
from engine.core.steps import drain
from engine.images.encode import encode_png, write_exr
from engine.simulate.arc import LightArc
from engine.simulate.simulate import simulate
from tests.present import present

KEYS = [
    "slice_mean_radiance", "slice_target_radiance", "rms", "rms_per_channel", "size_bytes_slices",
    "size_bytes_compressed", "linearise_s", "fit_s", "unevenness", "representation", "leave_one_out_rmse_srgb8",
    "in_sample_rmse_srgb8", "mean_picture_rmse_srgb8", "bytes_per_texel", "verdict", "candidates", "exponent_bits",
    "quantisation_bound_radiance", "quantisation_error_radiance", "max_error_radiance", "kept_tile_fraction",
    "seam_error", "tile_width_px",
    "tile_height_px",
    "brdf_fit_rmse_rel", "output", "members", "bundle_bytes", "warnings", "worst_texels",
]  # fmt: skip


#: The photographs are taken as they are: what can be estimated from them is tested with the import.
SETTINGS = ImportSettings(motion="none", calibrate="none")


def make_stack(folder: Path, levels: Any, darker: float = 0.0) -> Any:
    """A stack folder of photographs of the given mean sRGB codes, whose lowest row is `darker` than the highest."""
    photographs = folder / "photographs"
    photographs.mkdir()
    surface = np.random.default_rng(0).uniform(0.7, 1.3, (24, 30, 3))
    surface *= np.linspace(1.0, 1.0 - darker, 24)[:, None, None]
    for index, level in enumerate(levels):
        codes = np.clip(level * surface, 0, 255).astype(np.uint8)
        (photographs / f"cloth_{10 * (index + 1)}deg.png").write_bytes(encode_png(codes))
    return drain(import_stack(find([photographs]), SETTINGS, folder / "stack")).folder


@pytest.fixture(scope="module")
def stack(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return make_stack(tmp_path_factory.mktemp("capture"), (20, 60, 90, 150, 190))


@pytest.fixture(scope="module")
def dome(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A stack of rough relief under twelve lamps all around, all at two elevations."""
    folder = tmp_path_factory.mktemp("dome")
    rng = np.random.default_rng(2)
    normal = rng.normal(size=(20, 24, 3)) * 0.5 + (0.0, 0.0, 1.0)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    lines = []
    for number in range(12):
        elevation, azimuth = (30.0, 50.0)[number % 2], 30.0 * number
        turn, rise = np.radians(azimuth), np.radians(elevation)
        light = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
        shaded = np.maximum(normal @ light, 0.02)[..., None] * (0.6, 0.5, 0.4)
        channels = {name: shaded[..., index].astype(np.float32) for index, name in enumerate("RGB")}
        write_exr(folder / f"lamp{number:02}.exr", channels, half=False)
        lines.append(f'[[photographs]]\nfile = "lamp{number:02}.exr"\n')
        lines.append(f"elevation_deg = {elevation}\nazimuth_deg = {azimuth}\n")
    (folder / "capture.toml").write_text("".join(lines))
    found = drain(import_stack(find([folder]), SETTINGS, folder / "stack")).folder
    assert found is not None
    return found


@pytest.mark.parametrize("suffix", [".lightarc", ""])
def test_json_has_the_promised_keys_and_the_bundle_holds_both_forms(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path, suffix: str
) -> None:
    target = tmp_path / f"cloth{suffix}"
    done = lightarc("shade", stack, "-o", target, "--slices", 6, "--json")
    assert done.code == 0, done.err
    result = json.loads(done.out)
    assert list(result) == KEYS
    assert result["slice_mean_radiance"] == pytest.approx(result["slice_target_radiance"], rel=4 * 2**-24)
    assert result["size_bytes_slices"] == 6 * 24 * 30 * 3 * 4
    assert result["size_bytes_compressed"] == 2 * 24 * 30 * 3 * 4
    material = open_bundle(target)
    assert material.name == "cloth"
    assert material.shading_map is not None
    assert material.shading_map.slices.shape == (6, 24, 30, 3)
    assert material.power_law is not None
    rebuilt = np.stack([material.power_law.slice_image(r) for r in material.shading_map.target_radiance])
    assert result["rms"] == pytest.approx(np.sqrt(((rebuilt - material.shading_map.slices) ** 2).mean()), rel=1e-4)
    assert material.elevation_deg == pytest.approx((10, 20, 30, 40, 50))


def test_the_least_squares_scale_is_not_worse(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    results = {
        scale: json.loads(lightarc("shade", stack, "-o", tmp_path / scale, "--scale", scale, "--json").out)
        for scale in ("last-slice", "least-squares")
    }
    assert results["least-squares"]["rms"] <= results["last-slice"]["rms"]


def test_without_compression_the_bundle_holds_slices_alone(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    done = lightarc("shade", stack, "-o", tmp_path / "plain.lightarc", "--compress", "none", "--json")
    result = json.loads(done.out)
    assert list(result) == KEYS
    assert result["rms"] is None
    assert result["fit_s"] is None
    assert open_bundle(tmp_path / "plain.lightarc").power_law is None


def test_under_a_bound_tiles_keep_their_slices(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    plain = json.loads(lightarc("shade", stack, "-o", tmp_path / "plain.lightarc", "--json").out)
    relative = plain["worst_texels"][0]["error_radiance"] / plain["slice_target_radiance"][-1]
    target = tmp_path / "mixed.lightarc"
    result = json.loads(lightarc("shade", stack, "-o", target, "--max-error", 0.9 * relative, "--json").out)
    assert 0 < result["kept_tile_fraction"] < 1
    assert result["worst_texels"][0]["error_radiance"] < result["max_error_radiance"]
    assert result["max_error_radiance"] == pytest.approx(0.9 * plain["worst_texels"][0]["error_radiance"])
    assert result["rms"] < plain["rms"]
    kept = present(open_bundle(target).power_law).kept
    assert kept is not None
    assert result["size_bytes_compressed"] == plain["size_bytes_compressed"] + kept.slices.nbytes + kept.place.nbytes
    everything = json.loads(lightarc("shade", stack, "-o", target, "--max-error", 0, "--json").out)
    assert (everything["rms"], everything["kept_tile_fraction"]) == (0.0, 1.0)
    material = open_bundle(target)
    assert material.power_law is not None
    assert material.shading_map is not None
    assert np.array_equal(material.power_law.slice_image(0.1), material.shading_map.slice_image(0.1))


@pytest.mark.parametrize(("bits", "share"), [(8, 24 / 64), (16, 32 / 64)])
def test_fewer_bits_are_fewer_bytes_with_a_bound(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path, bits: int, share: float
) -> None:
    target = tmp_path / "m.lightarc"
    result = json.loads(lightarc("shade", stack, "-o", target, "--exponent-bits", bits, "--json").out)
    assert result["size_bytes_compressed"] == share * 2 * 24 * 30 * 3 * 4
    assert 0 < result["quantisation_error_radiance"] <= result["quantisation_bound_radiance"]
    assert present(open_bundle(target).power_law).storage.exponent_bits == bits


def test_a_tile_comes_with_its_seam_and_a_image(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    target, image = tmp_path / "tile.lightarc", tmp_path / "tile.png"
    done = lightarc("shade", stack, "-o", target, "--tileable", "--overlap", 6, "--tile-preview", image, "--json")
    result = json.loads(done.out)
    size = (result["tile_height_px"], result["tile_width_px"])
    assert result["seam_error"] > 0
    assert present(open_bundle(target).shading_map).slices.shape[1:3] == size
    assert describe_bundle(target)["figures"]["seam_error"] == result["seam_error"]
    shown = cv2.imread(str(image))
    assert shown is not None
    assert shown.shape[:2] == (3 * size[0], 3 * size[1])
    assert np.array_equal(shown[: size[0], : size[1]], shown[size[0] : 2 * size[0], size[1] : 2 * size[1]])


def test_brightness_is_evened_before_the_tile_is_cut_unless_it_is_to_stay(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    uneven = make_stack(tmp_path, (20, 60, 90, 150, 190), darker=0.4)
    spread = {}
    for brightness in ("evened", "as-it-is"):
        target = tmp_path / f"{brightness}.lightarc"
        words = ("--tileable", "--overlap", 6, "--brightness", brightness, "--json")
        done = lightarc("shade", uneven, "-o", target, *words)
        assert done.code == 0, done.err
        unevenness = json.loads(done.out)["unevenness"]
        assert unevenness is None if brightness == "as-it-is" else unevenness > 0.5
        rows = present(open_bundle(target).shading_map).slices[-1].mean(axis=(1, 2))
        spread[brightness] = rows.std() / rows.mean()
    assert spread["evened"] < 0.5 * spread["as-it-is"], spread


def test_worst_texels_and_the_error_map_show_where_the_fit_is_off(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    image = tmp_path / "error.png"
    done = lightarc("shade", stack, "-o", tmp_path / "m.lightarc", "--worst", 3, "--error-map", image, "--json")
    worst = json.loads(done.out)["worst_texels"]
    error_map = present(open_bundle(tmp_path / "m.lightarc").power_law).error_map
    assert [texel["error_radiance"] for texel in worst] == sorted(error_map.ravel().tolist(), reverse=True)[:3]
    assert all(error_map[texel["row"], texel["column"]] == texel["error_radiance"] for texel in worst)
    assert cv2.imread(str(image)) is not None


def test_a_measured_brdf_goes_into_the_bundle_as_a_table(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    truth = Ggx(kd=(0.3, 0.3, 0.3), alpha=0.35, f0=(0.2, 0.2, 0.2))
    table = write_table(tmp_path / "paint.exr", table_from(truth, (30, 30, 60)))
    done = lightarc("shade", stack, "-o", tmp_path / "cloth.lightarc", "--brdf", tmp_path / "paint.exr", "--json")
    assert done.code == 0, done.err
    material = open_bundle(tmp_path / "cloth.lightarc")
    assert material.measured is not None
    assert np.array_equal(cast(Any, material.measured).values, table.values)
    nearest = brdf_from_text(material.brdf)
    assert cast(Any, nearest).alpha == pytest.approx(truth.alpha, rel=0.1)
    assert cast(Any, nearest).kd == pytest.approx(truth.kd, abs=0.02)
    assert lightarc("bundle", "verify", tmp_path / "cloth.lightarc").code == 0


def test_a_model_is_kept_by_its_name_and_nonsense_is_refused_before_the_work(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    assert lightarc("shade", stack, "-o", tmp_path / "a.lightarc", "--brdf", "ggx:alpha=0.2").code == 0
    material = open_bundle(tmp_path / "a.lightarc")
    assert brdf_from_text(material.brdf) == Ggx(alpha=0.2)
    assert material.measured is None
    assert lightarc("shade", stack, "-o", tmp_path / "b.lightarc", "--brdf", "velvet").code == 2
    assert lightarc("shade", stack, "-o", tmp_path / "b.lightarc", "--brdf", "absent.binary").code == 3
    assert not (tmp_path / "b.lightarc").exists()


def test_excluded_photographs_are_left_out_and_recorded(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    target = tmp_path / "m.lightarc"
    done = lightarc("shade", stack, "-o", target, "--exclude", "cloth_20deg.png", "cloth_50deg.png", "--json")
    assert done.code == 0, done.err
    assert open_bundle(target).elevation_deg == pytest.approx((10, 30, 40))
    excluded = describe_bundle(target)["provenance"]["excluded_photographs"]
    assert excluded == ["cloth_20deg.png", "cloth_50deg.png"]
    assert json.loads(done.out)["slice_target_radiance"][-1] < 0.5


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--exclude", "felt.png"], "no photograph called felt.png"),
        (["--max-error", "-1"], "--max-error"),
        (["--max-error", "nan"], "--max-error"),
        (["--overlap", "5"], "--tileable"),
        (["--tileable", "--overlap", "0"], "--overlap"),
        (["--tile-preview", "tile.png"], "--tileable"),
        (["--brightness", "evened"], "--tileable"),
        (["--compress", "none", "--exponent-bits", "8"], "--compress power-law"),
        (["--exponent-bits", "12"], "--exponent-bits"),
        (["--worst", "-1"], "--worst"),
        (["--bytes-per-texel", "0"], "--bytes-per-texel"),
        (["--bytes-per-texel", "9"], "--bytes-per-texel is of directional maps"),
        (["--compress", "none", "--scale", "last-slice"], "--compress power-law"),
        (["--compare", "--worst", "3", "--slices", "4"], "leave out --worst"),
        (["--representation", "directional", "--slices", "8"], "leave out --slices"),
    ],
)
def test_words_that_do_not_fit_together_are_wrong_usage(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path, words: Any, said: str
) -> None:
    done = lightarc("shade", stack, "-o", tmp_path / "m.lightarc", *words)
    assert done.code == 2
    assert said in done.err
    assert not (tmp_path / "m.lightarc").exists()


@pytest.mark.parametrize("slices", ["1", "0", "-4", "257", "many"])
def test_a_wrong_number_of_slices_is_wrong_usage(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path, slices: str
) -> None:
    done = lightarc("shade", stack, "-o", tmp_path / "m.lightarc", "--slices", slices)
    assert done.code == 2
    assert not (tmp_path / "m.lightarc").exists()


def test_S4_a_black_stack_is_bad_input_that_names_the_stack(
    lightarc: Callable[..., SimpleNamespace], tmp_path: Path
) -> None:
    stack = make_stack(tmp_path, (0, 0, 0))
    done = lightarc("shade", stack, "-o", tmp_path / "m.lightarc")
    assert done.code == 3
    assert str(stack) in done.err
    assert "no light" in done.err
    assert "Traceback" not in done.err
    assert not (tmp_path / "m.lightarc").exists()


def test_what_is_no_stack_and_what_may_not_be_replaced_is_refused(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    assert lightarc("shade", tmp_path / "absent", "-o", tmp_path / "m.lightarc").code == 3
    (tmp_path / "letter.lightarc").write_text("Dear reader")
    done = lightarc("shade", stack, "-o", tmp_path / "letter.lightarc")
    assert done.code == 3
    assert (tmp_path / "letter.lightarc").read_text() == "Dear reader"


def test_a_user_reads_two_lines(lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path) -> None:
    done = lightarc("shade", stack, "-o", tmp_path / "cloth.lightarc")
    assert "8 slices" in done.out
    assert "RMS error" in done.out


@pytest.mark.parametrize(("name", "left_bytes"), [("codes.npy", 4_000), ("codes.npy", 0)])
def test_a_stack_that_is_cut_short_while_it_is_open_is_named(
    lightarc: Callable[..., SimpleNamespace],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
    left_bytes: int,
) -> None:
    folder = make_stack(tmp_path, (20, 60, 90))

    def open_path(place: Path) -> Any:
        found = open_stack(place)
        os.truncate(folder / name, left_bytes)
        return found

    monkeypatch.setattr("app.cli.shading.shade.open_stack", open_path)
    done = lightarc("shade", folder, "-o", tmp_path / "cloth.lightarc")
    assert done.code == 3
    assert f"{name}: was cut short while it was open. Check the disk" in done.err
    assert not (tmp_path / "cloth.lightarc").exists()


def test_a_material_that_is_worse_than_a_mean_image_is_refused_unless_forced(
    lightarc: Callable[..., SimpleNamespace], dome: Path, tmp_path: Path
) -> None:
    target = tmp_path / "dome.lightarc"
    words = ("shade", dome, "-o", target, "--slices", 3, "--representation", "shading-map")
    done = lightarc(*words)
    assert done.code == 3
    assert "lights come from several azimuths" in done.err
    assert "--exclude, or write it all the same with --force." in done.err
    assert not target.exists()
    done = lightarc(*words, "--force", "--json")
    assert done.code == 0, done.err
    result = json.loads(done.out)
    assert result["leave_one_out_rmse_srgb8"] > result["mean_picture_rmse_srgb8"]
    assert (result["representation"], result["verdict"]) == ("shading-map", "warning")
    assert any("brightness alone does not distinguish these photographs" in each for each in result["warnings"])


def test_lamps_on_several_sides_become_a_directional_material_by_default(
    lightarc: Callable[..., SimpleNamespace], dome: Path, tmp_path: Path
) -> None:
    target = tmp_path / "dome.lightarc"
    done = lightarc("shade", dome, "-o", target, "--json")
    assert done.code == 0, done.err
    result = json.loads(done.out)
    assert (result["representation"], result["verdict"]) == ("directional", "good")
    assert result["in_sample_rmse_srgb8"] < result["leave_one_out_rmse_srgb8"] < result["mean_picture_rmse_srgb8"]
    assert result["bytes_per_texel"] == result["planes"]
    errors = {each["representation"]: each["leave_one_out_rmse_srgb8"] for each in result["candidates"]}
    assert errors["directional"] < errors["shading-map"]
    material = open_bundle(target)
    assert material.directional is not None
    assert (material.name, material.brdf, len(material.directional.lights)) == ("dome", "lambert", 12)
    assert describe_bundle(target)["figures"]["representation"] == "directional"
    assert lightarc("bundle", "verify", target).code == 0
    again = lightarc("shade", dome, "-o", target)
    assert "shading-map, not chosen: error" in again.out


def test_a_directional_material_draws_left_and_right_light_differently(
    lightarc: Callable[..., SimpleNamespace], dome: Path, tmp_path: Path
) -> None:
    target = tmp_path / "dome.lightarc"
    assert lightarc("shade", dome, "-o", target).code == 0
    images = []
    for side in (50, -50):
        image = tmp_path / f"{side}.png"
        words = ("render", "plane", "--material", target, "--light-deg", f"90,{side}", "-o", image)
        done = lightarc(*words, "--width", 40, "--height", 40)
        assert done.code == 0, done.err
        images.append(np.asarray(cv2.imread(str(image)), np.float64))
    assert np.abs(images[0] - images[1]).mean() > 5.0


def test_a_directional_material_repeats(lightarc: Callable[..., SimpleNamespace], dome: Path, tmp_path: Path) -> None:
    words = ("--tileable", "--overlap", 4, "--tile-preview", tmp_path / "tiles.png", "--json")
    done = lightarc("shade", dome, "-o", tmp_path / "a.lightarc", *words)
    assert done.code == 0, done.err
    result = json.loads(done.out)
    material = open_bundle(tmp_path / "a.lightarc")
    assert (result["representation"], material.size) == (
        "directional",
        (result["tile_height_px"], result["tile_width_px"]),
    )
    assert material.size < (20, 24)
    assert result["seam_error"] > 0.0
    preview = np.asarray(cv2.imread(str(tmp_path / "tiles.png")))
    assert preview.shape[:2] == (3 * result["tile_height_px"], 3 * result["tile_width_px"])


def test_what_a_directional_material_cannot_have_is_wrong_usage(
    lightarc: Callable[..., SimpleNamespace], stack: Any, dome: Path, tmp_path: Path
) -> None:
    for words in (("--max-error", 0.1), ("--representation", "directional", "--exponent-bits", 8)):
        done = lightarc("shade", dome, "-o", tmp_path / "a.lightarc", *words)
        assert done.code == 2
        assert "a directional map has no slices and no compression" in done.err
    done = lightarc("shade", stack, "-o", tmp_path / "a.lightarc", "--representation", "directional")
    assert done.code == 3
    assert "its lamps have no azimuth" in done.err


def test_an_arc_is_shown_better_than_by_its_mean(
    lightarc: Callable[..., SimpleNamespace], stack: Any, tmp_path: Path
) -> None:
    done = lightarc("shade", stack, "-o", tmp_path / "a.lightarc", "--json")
    result = json.loads(done.out)
    assert result["in_sample_rmse_srgb8"] < result["leave_one_out_rmse_srgb8"] < result["mean_picture_rmse_srgb8"]
    assert (result["representation"], result["verdict"]) == ("shading-map", "good")
    assert result["bytes_per_texel"] == pytest.approx(24.0)


@pytest.mark.parametrize(
    "words", [("--slices", "8"), ("--compress", "power-law"), ("--slices", "5", "--exponent-bits", "32")]
)
def test_options_of_shading_maps_are_refused_for_lamps_on_several_sides(
    lightarc: Callable[..., SimpleNamespace], dome: Path, tmp_path: Path, words: tuple[str, ...]
) -> None:
    """They were passed over without a word, also where they named what is the default."""
    done = lightarc("shade", dome, "-o", tmp_path / "m.lightarc", *words)
    assert done.code == 2
    assert "add --representation shading-map, or leave out " + " and ".join(words[::2]) in done.err
    assert not (tmp_path / "m.lightarc").exists()


def test_a_map_keeps_within_the_bytes_of_a_texel(
    lightarc: Callable[..., SimpleNamespace], dome: Path, tmp_path: Path
) -> None:
    done = lightarc("shade", dome, "-o", tmp_path / "m.lightarc", "--bytes-per-texel", 4, "--json")
    assert done.code == 0, done.err
    assert json.loads(done.out)["bytes_per_texel"] <= 4


def test_a_comparison_that_is_cancelled_leaves_nothing(
    lightarc: Callable[..., SimpleNamespace], dome: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def cancel(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("app.cli.shading.comparison.write_json", cancel)
    assert lightarc("shade", dome, "--compare", "-o", tmp_path / "comparison").code != 0
    assert list(tmp_path.iterdir()) == []


def test_representations_are_compared_in_a_folder(
    lightarc: Callable[..., SimpleNamespace], dome: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "comparison"
    done = lightarc("shade", dome, "--compare", "-o", folder, "--json")
    assert done.code == 0, done.err
    result = json.loads(done.out)
    errors = {each["representation"]: each["leave_one_out_rmse_srgb8"] for each in result["candidates"]}
    assert list(errors.values()) == sorted(errors.values())
    assert {"mean", "ptm", "hsh", "shading-map", "kriging-of-all", "pbr-maps", "lambertian"} < set(errors)
    relit = {name: error for name, error in errors.items() if name not in {"pbr-maps", "lambertian"}}
    assert min(relit, key=lambda name: relit[name]).startswith(("planes-", "kriging", "ptm"))
    assert errors["mean"] < errors["shading-map"]
    assert sorted(path.name for path in folder.iterdir()) == sorted(result["files"])
    assert result["worst_of"].startswith("planes-")
    assert all(set(each["rmse_srgb8"]) == set(errors) for each in result["worst"])
    assert result["worst"][0]["rmse_srgb8"][result["worst_of"]] > errors[result["worst_of"]]
    again = lightarc("shade", dome, "--compare", "-o", folder)
    assert again.code == 0
    assert "errors in 8-bit levels of sRGB" in again.out


def test_what_cannot_be_compared_is_refused(
    lightarc: Callable[..., SimpleNamespace], stack: Any, dome: Path, tmp_path: Path
) -> None:
    done = lightarc("shade", stack, "--compare", "-o", tmp_path / "a")
    assert done.code == 3
    assert "its lamps have no azimuth" in done.err
    few = [f"lamp{number:02}.exr" for number in range(9)]
    for option in (("--part", "whole"), ("--tileable",)):
        done = lightarc("shade", dome, "--compare", "-o", tmp_path / "a", *option)
        assert done.code == 2
        assert "leave out --part and --tileable" in done.err
    done = lightarc("shade", dome, "--compare", "-o", tmp_path / "a", "--exclude", *few)
    assert done.code == 3
    assert "3 photographs are too few" in done.err
    assert not (tmp_path / "a").exists()


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated dome of four arcs of three lamps."""
    folder = tmp_path_factory.mktemp("simulated")
    around = tuple(np.radians([0.0, 90.0, 180.0, 270.0]))
    arc = LightArc(elevation=tuple(np.radians([20.0, 45.0, 70.0])), azimuth=around, size=32, misalignment_px=0.0)
    drain(simulate(arc, folder / "capture"))
    drain(import_stack(find([folder / "capture"]), SETTINGS, folder / "stack"))
    return folder / "stack"


def test_each_arc_of_a_dome_becomes_a_material(lightarc: Any, simulated: Path, tmp_path: Path) -> None:
    result = json.loads(lightarc("shade", simulated, "--per-arc", "--slices", 3, "-o", tmp_path / "arcs", "--json").out)
    names = ["arc-000.lightarc", "arc-090.lightarc", "arc-180.lightarc", "arc-270.lightarc"]
    assert [(each["file"], each["photographs"]) for each in result["arcs"]] == [(name, 3) for name in names]
    assert sorted(path.name for path in (tmp_path / "arcs").iterdir()) == [*names, "arcs.json"]
    lightarc("shade", simulated, "--azimuth", "88", "--slices", 3, "-o", tmp_path / "one.lightarc")
    alone, of_arcs = (open_bundle(tmp_path / name).shading_map for name in ("one.lightarc", "arcs/arc-090.lightarc"))
    other = open_bundle(tmp_path / "arcs/arc-270.lightarc").shading_map
    assert alone is not None
    assert of_arcs is not None
    assert other is not None
    np.testing.assert_array_equal(alone.slices, of_arcs.slices)
    assert np.abs(other.slices - of_arcs.slices).max() > 0.02


def test_the_arc_of_most_lamps_is_used_alone(lightarc: Any, simulated: Path, tmp_path: Path) -> None:
    gone = [name for name in open_stack(simulated).sources if "azimuth090" in name][:1]
    lightarc("shade", simulated, "--arc", "--exclude", *gone, "--slices", 3, "-o", tmp_path / "arc.lightarc")
    assert len(open_bundle(tmp_path / "arc.lightarc").elevation_deg) == 3


@pytest.mark.parametrize("option", ["--arc", "--per-arc", "--azimuth=90"])
def test_arcs_need_azimuths(lightarc: Any, stack: Path, tmp_path: Path, option: str) -> None:
    done = lightarc("shade", stack, option, "-o", tmp_path / "out")
    assert done.code == 3
    assert "azimuth" in done.err
    assert not (tmp_path / "out").exists()
