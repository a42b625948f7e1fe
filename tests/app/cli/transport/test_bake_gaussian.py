"""`lightarc bake --mode gaussian`, as a user types it."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import pytest

from app.cli.transport import bake
from tests.app.command import Command, replace_options, result

pytestmark = pytest.mark.usefixtures("coarse")

QUICK = ("--mode", "gaussian", "--samples", "32", "--cube", "16", "--fine", "1", "--json")


def test_a_model_is_baked_with_its_errors_reported(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output = tmp_path / "a.transport"
    words = ("--brdf", "ggx:kd=0.3,alpha=0.3,f0=0.2", "--ground", "--ground-cells", "4", "--views", "92")
    made = lightarc("bake", mesh, *words, "-o", output, *QUICK, "--error-env", "studio")
    found = result(made)
    assert found["vertices"] == 12 + 25
    assert found["size_bytes"] == output.stat().st_size
    assert f"{12 + 25} vertices, about " in made.err
    assert found["knobs"]["lobes"] == 1
    assert found["weights_taken"] in ("plain", "preserving")
    errors = [found[f"error_{name}_rmse_rel"] for name in ("plain", "preserving")]
    assert found["error_rmse_rel"] == min(errors)
    assert 0.0 < abs(found["error_mean_rel"]) < found["error_rmse_rel"]
    assert 0.0 < found["direct_error_rel_mean"] < 1.0
    assert found["direct_flipped_pairs"] == 0.0
    assert any("--indirect" in text for text in found["skipped"])


def test_indirect_light_compression_and_variation(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    output = tmp_path / "small.transport"
    words = ("bake", mesh, "--brdf", "ggx:kd=0.3,alpha=0.3,f0=0.2", "--vary", "alpha=0.2:0.5:y", "--ground")
    words = cast(Any, (*words, "--ground-cells", "2", "--indirect", "--lobes", "2", "--weights", "preserving", *QUICK))
    found = result(lightarc(*words, "-o", output, "--compress"))
    assert found["knobs"]["indirect"]
    assert "indirect_error_rel_mean" in found
    assert found["compressed_bytes"] < 0.5 * found["uncompressed_bytes"]
    assert found["compression_error_rel"] < 0.05
    assert output.stat().st_size == found["size_bytes"] < found["uncompressed_bytes"]
    text = bake.report(found)
    assert "changes the radiance by" in text
    assert "with all their energy" in text


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--views", "42"), "--views 42"),
        (("--lobes", "4"), "--lobes 4 is outside 1 … 3"),
        (("--samples", "1"), "outside"),
        (("--vary", "beta=0:1:y"), "no parameter"),
        (("--vary", "alpha=0:9:y"), "alpha"),
        (("--terms", "3"), "--mode wavelet"),
        (("--order", "1"), "outside"),
    ],
)
def test_what_cannot_be_is_wrong_usage(
    lightarc: Command, mesh: Path, tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    common = replace_options(("--brdf", "ggx:alpha=0.3", "-o", tmp_path / "a.transport", *QUICK), words)
    made = lightarc("bake", mesh, *common, *words)
    assert made.code == 2
    assert said in made.err
    assert not (tmp_path / "a.transport").exists()


def test_a_diffuse_brdf_is_sent_to_the_other_modes(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    made = lightarc("bake", mesh, "--brdf", "lambert:albedo=0.5", "-o", tmp_path / "a.transport", *QUICK)
    assert made.code == 2
    assert "--mode sh" in made.err


def test_options_of_this_mode_belong_to_no_other(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    made = lightarc("bake", mesh, "--brdf", "ggx:alpha=0.3", "-o", tmp_path / "a.transport", "--lobes", "2")
    assert made.code == 2
    assert "--lobes needs --mode gaussian" in made.err
