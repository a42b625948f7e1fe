"""The radiance and motion that the import recovers from a simulated capture, against those simulated."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.core.steps import drain
from engine.simulate.arc import LightArc
from engine.simulate.simulate import simulate


def capture(folder: Path, degrees: Any, **settings: Any) -> Any:
    arc = LightArc(**{"elevation": tuple(math.radians(angle) for angle in degrees), **settings})
    drain(simulate(arc, folder))
    return json.loads((folder / "truth" / "truth.json").read_text())["photographs"]


def import_capture(folder: Path, motion: Any) -> Any:
    return drain(import_stack(find([folder]), ImportSettings(motion=motion), folder.parent / "stack"))


def clean(folder: Path, record: Any) -> Any:
    with OpenEXR.File(str(folder / "truth" / record["radiance"]), separate_channels=True) as file:
        return np.stack([file.channels()[name].pixels for name in "RGB"], axis=-1)


@pytest.mark.parametrize("format_", ["tiff", "exr", "dng"])
def test_angles_and_mean_radiance_are_recovered(tmp_path: Path, format_: str) -> None:
    folder = tmp_path / "c"
    records = capture(folder, (7.5, 30, 62, 90), size=96, format=format_, misalignment_px=0.0)
    stack = import_capture(folder, "none")
    assert stack.angle_source == "capture.toml"
    np.testing.assert_allclose(stack.elevation_deg, [7.5, 30, 62, 90], atol=1e-9)
    means = [record["mean_radiance"] for record in records]
    np.testing.assert_allclose(stack.mean_radiance, means, rtol=0.01)


def test_radiance_is_the_truth_within_the_noise(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    records = capture(folder, (30, 60, 90), size=96, noise=0.01, misalignment_px=0.0)
    stack = import_capture(folder, "none")
    for radiance, record in zip(stack.radiance, records, strict=True):
        truth = clean(folder, record).astype(float)
        normal = ((radiance - truth) / (0.01 * np.sqrt(0.99 * truth + 0.01)))[(truth > 0.05) & (truth < 0.9)]
        assert abs(normal.mean()) < 5 / math.sqrt(normal.size)
        assert abs(normal.std() - 1) < 5 / math.sqrt(2 * normal.size)


def test_shifts_are_recovered_where_the_shading_hardly_changes(tmp_path: Path) -> None:
    """A sinking lamp makes relief seem to move, so that photographs under nearly the same lamp are compared."""
    folder = tmp_path / "c"
    records = capture(folder, (88, 89, 90), size=256, misalignment_px=1.5)
    stack = import_capture(folder, "translation")
    shift = np.array([[record["shift_right_px"], record["shift_down_px"]] for record in records])
    matrices = [photograph["alignment_matrix"] for photograph in stack.provenance["photographs"]]
    found = np.array([np.reshape(matrix, -1)[[2, 5]] for matrix in matrices])
    assert np.abs((found - found[2]) - (shift - shift[2])).max() <= 0.05


def test_an_import_from_two_azimuths_tells_what_they_change(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    capture(folder, (15, 40, 65), size=96, azimuth=(0.0, math.pi / 2), misalignment_px=0.0)
    findings = [finding.text for finding in import_capture(folder, "none").health.findings]
    assert any(text.startswith("Lit from 0° and 90° of azimuth") for text in findings)
