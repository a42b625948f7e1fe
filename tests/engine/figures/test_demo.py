"""The demo goes the whole path, and what fails on the way costs itself alone."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import pytest

from engine.bundle.bundle import open_bundle, verify_bundle
from engine.core.errors import InputError, MissingCapability, OutputError
from engine.core.steps import drain
from engine.figures import demo as demos
from engine.figures.demo import Demo, demo
from engine.simulate.arc import LightArc
from tests.present import present

STAGES = ["simulate", "import", "shade", "compress", "render", "bundle", "contact sheet"]


#: Rounds in which the demo is cancelled at every step; the first is in the ordinary suite.
ROUNDS = 40


@pytest.fixture(scope="module")
def small() -> Iterator[LightArc]:
    """A capture and images small enough for a test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(demos, "IMAGE_SIZE", (160, 100))
        yield LightArc(size=64, elevation=tuple(math.radians(angle) for angle in (10, 30, 50, 70, 90)))


@pytest.fixture(scope="module")
def whole(small: LightArc, tmp_path_factory: pytest.TempPathFactory) -> tuple[Demo, Path]:
    """The demo as it is without faults, and its folder."""
    folder = tmp_path_factory.mktemp("demo") / "d"
    return drain(demo(folder, small)), folder


def failures(made: Demo) -> dict[str, str]:
    return {stage.name: stage.error for stage in made.stages if stage.error}


def test_everything_is_made(whole: tuple[Demo, Path]) -> None:
    made, folder = whole
    assert [stage.name for stage in made.stages] == STAGES
    assert failures(made) == {}
    assert [image.name for image in made.images] == ["cloth_power-law.png", "cloth_slices.png", "contact_sheet.png"]
    assert all(present(cv2.imread(str(image))).std() > 5 for image in made.images)
    assert made.bundle is not None
    assert verify_bundle(made.bundle).ok
    assert len(present(open_bundle(made.bundle).shading_map).slices) == 8
    record = json.loads((folder / "demo.json").read_text())
    assert [stage["name"] for stage in record["stages"]] == STAGES


def test_images_from_slices_and_from_the_pair_are_alike(whole: tuple[Demo, Path]) -> None:
    made, folder = whole
    slices, pair = (cv2.imread(str(folder / f"cloth_{source}.png")) for source in ("slices", "power-law"))
    assert made.images
    assert cv2.absdiff(slices, pair).mean() < 6


def test_GL5_without_opengl_the_cpu_renders(
    tmp_path: Path, small: LightArc, whole: tuple[Demo, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse() -> None:
        raise MissingCapability("OpenGL 3.3 is not available", "Install it")

    with_gl, _ = whole
    monkeypatch.setattr("engine.figures.demo.create_context", refuse)
    without = drain(demo(tmp_path / "cpu", small))
    assert failures(without) == {}
    for one, other in zip(with_gl.images[:2], without.images[:2], strict=True):
        assert cv2.absdiff(cv2.imread(str(one)), cv2.imread(str(other))).mean() < 0.5


def test_a_failed_stage_costs_only_what_needs_it(
    tmp_path: Path, small: LightArc, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(shading_map: Any) -> Iterator[None]:
        raise InputError("stack", "cannot be compressed", "Use more slices")
        yield

    monkeypatch.setattr(demos, "fit", refuse)
    made = drain(demo(tmp_path / "d", small))
    assert failures(made) == {"compress": "stack: cannot be compressed. Use more slices."}
    assert made.bundle is not None
    assert made.bundle.is_file()
    assert [image.name for image in made.images] == ["cloth_slices.png", "contact_sheet.png"]


def test_without_an_import_the_rest_says_that_it_was_left_out(
    tmp_path: Path, small: LightArc, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(sources: Any, settings: Any, folder: Path) -> Iterator[None]:
        raise InputError(folder, "is damaged", "Copy it again")
        yield

    monkeypatch.setattr(demos, "import_stack", refuse)
    made = drain(demo(tmp_path / "d", small))
    assert set(failures(made)) == {"import", "shade", "compress", "render", "bundle"}
    assert failures(made)["import"] == f"{tmp_path / 'd' / 'stack'}: is damaged. Copy it again."
    assert made.bundle is None
    assert [image.name for image in made.images] == ["contact_sheet.png"]
    assert (tmp_path / "d" / "capture" / "capture.toml").is_file()


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault_17_cancelling_leaves_nothing(tmp_path: Path, small: LightArc, seed: int) -> None:
    total = sum(1 for _ in demo(tmp_path / "whole", small))
    assert total > ROUNDS
    for stop in range(1 + seed % ROUNDS, total, ROUNDS):
        steps = demo(tmp_path / "cancelled", small)
        for _ in range(stop):
            next(steps)
        steps.close()
        assert [path.name for path in tmp_path.iterdir()] == ["whole"]


def test_folder_of_somebody_else_is_left_alone(tmp_path: Path, small: LightArc) -> None:
    (tmp_path / "letter.txt").write_text("dear")
    with pytest.raises(OutputError, match="not ours"):
        drain(demo(tmp_path, small))
    assert [path.name for path in tmp_path.iterdir()] == ["letter.txt"]
