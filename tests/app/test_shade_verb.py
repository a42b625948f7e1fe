"""`lightarc shade` as a person or a script meets it."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from app import cli
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.sources import find
from engine.files.bundle import open_bundle
from engine.images.encode import encode_png
from engine.steps import drain

KEYS = [
    "slice_mean_radiance", "slice_target_radiance", "rms", "rms_per_channel", "size_bytes_slices",
    "size_bytes_compressed", "linearise_s", "fit_s",
]  # fmt: skip


@pytest.fixture
def lightarc(capsys, monkeypatch):
    """Runs the command line with this verb alone; gives exit code, standard output and standard error."""
    monkeypatch.setattr(cli, "VERBS", (("shade", "app.verbs.shade"),))

    def run(*words):
        try:
            code = cli.main(list(map(str, words)))
        except SystemExit as stop:
            code = stop.code
        return SimpleNamespace(code=code, **dict(zip(("out", "err"), capsys.readouterr(), strict=True)))

    return run


def make_stack(folder, levels):
    """A stack folder of photographs of the given mean sRGB codes."""
    photographs = folder / "photographs"
    photographs.mkdir()
    surface = np.random.default_rng(0).uniform(0.7, 1.3, (24, 30, 3))
    for index, level in enumerate(levels):
        codes = np.clip(level * surface, 0, 255).astype(np.uint8)
        (photographs / f"cloth_{10 * (index + 1)}deg.png").write_bytes(encode_png(codes))
    return drain(import_stack(find([photographs]), ImportSettings(motion="none"), folder / "stack")).folder


@pytest.fixture(scope="module")
def stack(tmp_path_factory):
    return make_stack(tmp_path_factory.mktemp("capture"), (20, 60, 90, 150, 190))


@pytest.mark.parametrize("suffix", [".lightarc", ""])
def test_json_has_the_promised_keys_and_the_bundle_holds_both_forms(lightarc, stack, tmp_path, suffix):
    target = tmp_path / f"cloth{suffix}"
    done = lightarc("shade", stack, "-o", target, "--slices", 6, "--json")
    assert done.code == 0, done.err
    result = json.loads(done.out)
    assert list(result) == KEYS
    assert result["slice_mean_radiance"] == pytest.approx(result["slice_target_radiance"], rel=4 * 2**-24)
    assert result["size_bytes_slices"] == 6 * 24 * 30 * 3 * 4
    assert result["size_bytes_compressed"] == 2 * 24 * 30 * 3 * 4
    material = open_bundle(target)
    assert material.shading_map.slices.shape == (6, 24, 30, 3)
    rebuilt = np.stack([material.power_law.slice_image(r) for r in material.shading_map.target_radiance])
    assert result["rms"] == pytest.approx(np.sqrt(((rebuilt - material.shading_map.slices) ** 2).mean()), rel=1e-4)
    assert material.elevation_deg == pytest.approx((10, 20, 30, 40, 50))


def test_the_least_squares_scale_is_not_worse(lightarc, stack, tmp_path):
    results = {
        scale: json.loads(lightarc("shade", stack, "-o", tmp_path / scale, "--scale", scale, "--json").out)
        for scale in ("last-slice", "least-squares")
    }
    assert results["least-squares"]["rms"] <= results["last-slice"]["rms"]


def test_without_compression_the_bundle_holds_slices_alone(lightarc, stack, tmp_path):
    done = lightarc("shade", stack, "-o", tmp_path / "plain.lightarc", "--compress", "none", "--json")
    result = json.loads(done.out)
    assert list(result) == KEYS
    assert result["rms"] is None
    assert result["fit_s"] is None
    assert open_bundle(tmp_path / "plain.lightarc").power_law is None


@pytest.mark.parametrize("slices", ["1", "0", "-4", "257", "many"])
def test_a_wrong_number_of_slices_is_wrong_usage(lightarc, stack, tmp_path, slices):
    done = lightarc("shade", stack, "-o", tmp_path / "m.lightarc", "--slices", slices)
    assert done.code == 2
    assert not (tmp_path / "m.lightarc").exists()


def test_S4_a_black_stack_is_bad_input_that_names_the_stack(lightarc, tmp_path):
    stack = make_stack(tmp_path, (0, 0, 0))
    done = lightarc("shade", stack, "-o", tmp_path / "m.lightarc")
    assert done.code == 3
    assert str(stack) in done.err
    assert "no light" in done.err
    assert "Traceback" not in done.err
    assert not (tmp_path / "m.lightarc").exists()


def test_what_is_no_stack_and_what_may_not_be_replaced_is_refused(lightarc, stack, tmp_path):
    assert lightarc("shade", tmp_path / "absent", "-o", tmp_path / "m.lightarc").code == 3
    (tmp_path / "letter.lightarc").write_text("Dear reader")
    done = lightarc("shade", stack, "-o", tmp_path / "letter.lightarc")
    assert done.code == 3
    assert (tmp_path / "letter.lightarc").read_text() == "Dear reader"


def test_a_person_reads_two_lines(lightarc, stack, tmp_path):
    done = lightarc("shade", stack, "-o", tmp_path / "cloth.lightarc")
    assert "8 slices" in done.out
    assert "RMS error" in done.out
