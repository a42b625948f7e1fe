"""Files of lights: what a capture tells of its lamps, written and used for the next one; and files that are wrong."""

from __future__ import annotations

import contextlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.command_line import main
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.joined import join
from engine.capture.lights.light_file import CalibratedLights, decode_lights, read_lights, save_lights
from engine.capture.lights.light_positions import Light
from engine.capture.lights.sources import find
from engine.capture.stack import ImageStack, lights_of
from engine.core.errors import InputError, UsageError
from engine.core.steps import drain
from engine.images.encode import encode_png
from engine.surface.lamps import lamps
from engine.surface.rig_error import rig_error
from tests.engine.capture.calibration.generated import Capture, render, write

SETTINGS = ImportSettings(motion="none")


def _lit(folder: Path, lights: Path, **choices: Any) -> ImageStack:
    """The photographs of `folder` under the lights of a file elsewhere."""
    sources = find([*folder.glob("*.png"), *folder.glob("*.tif"), *folder.glob("*.jpg"), lights])
    return drain(import_stack(sources, ImportSettings(motion="none", **choices), folder.with_name(lights.stem)))


def test_a_dome_is_calibrated_once(tmp_path: Path) -> None:
    """Near, unequal lamps are estimated in one capture; the next one has their distance and intensities by the file."""
    rendered = render(Capture(seed=3, distance=3.0, gains=(0.5, 1.5), height=48, width=56, lamps=18))
    folder = write(rendered, tmp_path / "photographs")
    first = drain(import_stack(find([folder]), SETTINGS, tmp_path / "first"))
    save_lights(tmp_path / "dome.lights", lights_of(first))
    second = _lit(folder, tmp_path / "dome.lights")
    assert second.angle_source == "lights"
    assert second.provenance["lamp_distance_widths"] == pytest.approx(3.0, rel=0.02)
    for name in ("lamp_distance_widths", "lamp_gains"):
        assert second.provenance[name] == pytest.approx(first.provenance[name], rel=1e-4)
    said = {term["name"]: term for term in second.provenance["calibration"]}
    for term in first.provenance["calibration"]:
        if term["name"] in ("distance", "gains"):
            assert said[term["name"]]["sigma"] == term["sigma"] > 0
            assert "states" in said[term["name"]]["text"]
    assert np.asarray(second.radiance[:]) == pytest.approx(np.asarray(first.radiance[:]), abs=2e-4)
    mirrored = _lit(folder, tmp_path / "dome.lights", lights_form="reversed")
    assert sorted(mirrored.provenance["lamp_gains"]) == pytest.approx(sorted(first.provenance["lamp_gains"]), rel=1e-4)
    save_lights(tmp_path / "dome.lp", lights_of(first))
    third = _lit(folder, tmp_path / "dome.lp", calibrate="none")
    for stack in (second, third):
        by_name, first_by_name = np.argsort(stack.sources), np.argsort(first.sources)
        assert stack.azimuth is not None
        assert first.azimuth is not None
        assert stack.elevation[by_name] == pytest.approx(first.elevation[first_by_name], abs=1e-6)
        assert stack.azimuth[by_name] == pytest.approx(first.azimuth[first_by_name], abs=1e-6)


def test_the_command_line_writes_lights_beside_the_stack(tmp_path: Path) -> None:
    words = "simulate --sample plain --size 32 --elevations-deg 30,60 --azimuths-deg 0,120,240 -o"
    assert main([*words.split(), str(tmp_path / "c")]) == 0
    line = ["import", str(tmp_path / "c"), "-o", str(tmp_path / "s"), "--write-lights", str(tmp_path / "l.lights")]
    assert main(line) == 0
    found = read_lights(tmp_path / "l.lights")
    assert len(found.lights) == 6
    assert sorted(np.degrees([light.elevation for light in found.lights]).round(3)) == [30.0] * 3 + [60.0] * 3


def test_what_is_no_list_of_lights_is_refused_in_words(tmp_path: Path) -> None:
    lamp = {"photograph": "a.png", "elevation_deg": 30.0, "azimuth_deg": 0.0}
    for listed, problem in (
        ([], "lamps"),
        ([lamp, {**lamp, "elevation_deg": 91}], r"lamps\.2\.elevation_deg"),
        ([{**lamp, "gain": 0}], r"lamps\.1\.gain"),
        ([{**lamp, "colour": 1}], r"lamps\.1\.colour"),
    ):
        content = json.dumps({"lightarc_lights": 1, "lamps": listed}).encode()
        with pytest.raises(InputError, match=problem):
            decode_lights(content, "dome.lights")
    for content in (b"", b"[]", b'{"lightarc_lights": 2, "lamps": []}', b"\xff\xfe", b"[" * 100_000):
        with pytest.raises(InputError, match=r"as Lightarc writes|UTF-8"):
            decode_lights(content, "dome.lights")


@settings(max_examples=50)
@given(st.binary(max_size=80), st.integers(0, 400))
def test_damaged_files_are_refused_or_read(noise: bytes, at: int) -> None:
    lamp = {"photograph": "a.png", "elevation_deg": 30.0, "azimuth_deg": 0.0, "gain": 1.1}
    content = json.dumps({"lightarc_lights": 1, "lamp_distance_widths": 3.0, "sigma": {"gains": 0.1}, "lamps": [lamp]})
    damaged = content[:at].encode() + noise + content[at:].encode()
    with contextlib.suppress(InputError):
        assert decode_lights(damaged, "dome.lights")["lights"]


def test_lights_without_azimuths_or_with_another_ending_are_not_written(tmp_path: Path) -> None:
    pixels = np.ones((2, 2, 2, 3), np.float32)
    stack = ImageStack(pixels, pixels[..., 0] > 2, np.array([0.1, 0.2]), None, np.ones(2), ("a", "b"), "user")
    with pytest.raises(UsageError, match="azimuths"):
        lights_of(stack)
    with pytest.raises(UsageError, match=r"\.lights or \.lp"):
        save_lights(tmp_path / "a.txt", lights_of(replace(stack, azimuth=np.zeros(2))))


def test_what_a_file_of_lights_does_not_state_is_not_taken_for_known(tmp_path: Path) -> None:
    """Room light that nobody corrected for widens the deviation of normals, although the file states distance."""
    rendered = render(Capture(seed=8, room=0.15, distance=4.0, height=48, width=56, lamps=18))
    folder = write(rendered, tmp_path / "photographs")
    first = drain(import_stack(find([folder]), SETTINGS, tmp_path / "first"))
    save_lights(tmp_path / "dome.lights", lights_of(first))
    deviations = []
    for choice in ("auto", "none"):
        save_lights(tmp_path / f"{choice}.lights", lights_of(first))
        stack = _lit(folder, tmp_path / f"{choice}.lights", calibrate=choice)
        used = np.arange(len(stack.sources))
        deviation, findings = rig_error(stack, used, lamps(stack, used))
        deviations.append(float(np.median(deviation)))
        assert any("room light" in finding.text.lower() for finding in findings) == (choice == "none")
    assert deviations[1] > 2 * deviations[0]


def test_a_stated_term_that_is_overridden_is_not_reported(tmp_path: Path) -> None:
    rendered = render(Capture(seed=3, distance=3.0, height=32, width=40, lamps=12))
    folder = write(rendered, tmp_path / "photographs")
    lights = tuple(Light(path.name, 0.5, 0.5 * at, at + 1) for at, path in enumerate(sorted(folder.glob("*.*"))))
    lights = tuple(light for light in lights if not light.name.endswith((".lp", ".txt", ".toml")))
    save_lights(tmp_path / "a.lights", CalibratedLights(lights, (1.0,) * len(lights), 3.0, {"distance": 0.01}))
    for stated, said in ((None, ["distance"]), (2.0, [])):
        stack = _lit(folder, tmp_path / "a.lights", calibrate="none", lamp_distance=stated)
        assert [term["name"] for term in stack.provenance["calibration"]] == said


def test_captures_of_which_one_states_no_intensities_state_none_together(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    halves = []
    for half in ("a", "b"):
        names = [f"{half}{number}.png" for number in range(3)]
        for name in names:
            (tmp_path / half).mkdir(exist_ok=True)
            (tmp_path / half / name).write_bytes(encode_png(rng.integers(0, 255, (20, 20, 3)).astype(np.uint8)))
        azimuth = 0.0 if half == "a" else 1.0
        lights = tuple(Light(name, 0.3 + 0.2 * at, azimuth, at + 1) for at, name in enumerate(names))
        known = CalibratedLights(lights, (0.5, 1.0, 1.5), None, {"gains": 0.01})
        save_lights(tmp_path / half / f"{half}{'.lights' if half == 'a' else '.lp'}", known)
        halves.append(find([tmp_path / half]))
    assert halves[0].lamp_gains
    both = join(*halves)
    assert (both.lamp_gains, both.lamp_sigma) == ({}, {})
