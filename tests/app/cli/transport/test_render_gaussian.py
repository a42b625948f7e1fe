"""`lightarc render` of baked Gaussians, as a user types it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.images.encode import rgb_channels, write_exr
from tests.app.cli.transport.test_bake_gaussian import QUICK
from tests.app.cli.transport.test_render import exr
from tests.app.command import Command, result

pytestmark = pytest.mark.usefixtures("coarse")

SIZE = ("--width", "60", "--height", "40", "--json")


@pytest.fixture
def baked(lightarc: Command, mesh: Path, tmp_path: Path) -> Path:
    path = tmp_path / "a.transport"
    words = ("--brdf", "ggx:kd=0.3,alpha=0.3,f0=0.2", "--ground", "--ground-cells", "4")
    result(lightarc("bake", mesh, *words, "-o", path, *QUICK))
    return path


def test_any_light_falls_on_baked_gaussians(lightarc: Command, baked: Path, tmp_path: Path) -> None:
    means = {}
    for name, light in {
        "studio": ("--env", "studio"),
        "turned": ("--env", "studio", "--env-rotation-deg", "120"),
        "twice": ("--env", "studio", "--intensity", "2"),
        "lamp": ("--light-deg", "30,40"),
        "disc": ("--lamp", "theta_deg=30,phi_deg=40,radius_deg=10"),
    }.items():
        found = result(lightarc("render", baked, *light, "--renderer", "cpu", "-o", tmp_path / f"{name}.exr", *SIZE))
        assert found["mode"] == "gaussian"
        assert found["lobes"] == 1
        means[name] = found["mean_radiance"]
        assert means[name] > 0.0
    assert means["twice"] == pytest.approx(2.0 * means["studio"], rel=1e-4)
    assert means["turned"] != pytest.approx(means["studio"], rel=1e-3)
    assert np.isfinite(exr(tmp_path / "lamp.exr")).all()


def test_light_that_is_too_bright_for_what_was_baked_gets_a_sentence(
    lightarc: Command, baked: Path, tmp_path: Path
) -> None:
    bright, output = tmp_path / "bright.exr", tmp_path / "a.png"
    write_exr(bright, rgb_channels(np.full((8, 16, 3), 1e15, np.float32)), half=False)
    for light in (
        ("--intensity", "1e39"),
        ("--env", bright, "--intensity", "1e16"),
        ("--env", "studio", "--intensity", "nan"),
    ):
        made = lightarc("render", baked, *light, "-o", output, *SIZE)
        assert made.code == 2, made.err
        assert made.err.count("1e+30") == 1
    beyond = tmp_path / "beyond.exr"
    write_exr(beyond, rgb_channels(np.full((8, 16, 3), 1e38, np.float32)), half=False)
    made = lightarc("render", baked, "--env", beyond, "--intensity", "1e-10", "-o", output, *SIZE)
    assert made.code == 3, made.err
    assert made.err.count("1e+15") == 1
    assert not output.exists()
    for light in (("--intensity", "1e30"), ("--env", bright, "--intensity", "1e-10")):
        drawn = result(lightarc("render", baked, *light, "--renderer", "cpu", "-o", output, *SIZE))
        assert np.isfinite(drawn["mean_radiance"])


def test_sums_below_0_are_reported_with_what_helps(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    path = tmp_path / "low.transport"
    words = ("--brdf", "ggx:kd=0.5,alpha=0.3,f0=0.04", "--order", "3", "--ground", "--ground-cells", "4")
    result(lightarc("bake", mesh, *words, "-o", path, *QUICK))
    lamp = ("--light-deg", "40,60", "--renderer", "gl")
    drawn = result(lightarc("render", path, *lamp, "-o", tmp_path / "a.png", *SIZE))
    assert 0.01 < drawn["negative_rel"] < 0.05
    assert [text for text in drawn["warnings"] if "adds 1." in text and "higher --order" in text]


def test_a_transport_file_that_is_missing_or_damaged_is_said_to_be(
    lightarc: Command, baked: Path, tmp_path: Path
) -> None:
    damaged = tmp_path / "damaged.transport"
    damaged.write_bytes(b"x" + baked.read_bytes()[1:])
    for path, said in ((tmp_path / "missing.transport", "does not exist"), (damaged, "transport")):
        made = lightarc("render", path, "--env", "studio", "-o", tmp_path / "a.png", *SIZE)
        assert made.code == 3, made.err
        assert said in made.err
        assert "mesh" not in made.err


def test_what_was_baked_cannot_be_chosen_again(lightarc: Command, baked: Path, tmp_path: Path) -> None:
    for words, reason in {
        ("--brdf", "lambert"): "no glossy part",
        ("--window", "hanning"): "--window",
        ("--near-lamp", "x=1,y=1,z=1"): "--near-lamp",
    }.items():
        made = lightarc("render", baked, *words, "--env", "studio", "-o", tmp_path / "a.png", *SIZE)
        assert made.code == 2, made.err
        assert reason in made.err
