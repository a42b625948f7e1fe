"""Whether the curve of photographs is told by their light, on captures of known truth."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.capture.calibration.estimate import sample_texels
from engine.capture.calibration.transfer import check_transfer
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.core.colour import srgb_decode, srgb_encode
from engine.core.steps import drain
from tests.engine.capture.calibration.generated import Capture, render, write
from tests.engine.capture.calibration.measured import measure

SMALL: dict[str, Any] = {"height": 48, "width": 56, "lamps": 18}


@pytest.mark.parametrize("material", ["matte", "satin metal"])
def test_the_curve_of_the_samples_is_told(material: str) -> None:
    rendered = render(Capture(seed=7, material=material, distance=4.0, gains=(0.6, 1.3), room=0.1, **SMALL))
    linear = rendered.photographs
    clipped = [(each >= 0.99).any(axis=-1).astype(np.float32) for each in linear]

    def find(decoded: Any, transfer: Any) -> str:
        sample = sample_texels([np.asarray(each, np.float32) for each in decoded], clipped)
        return check_transfer(sample, rendered.directions, transfer).transfer

    assert find(linear, "srgb") == "srgb"
    assert find(linear, "linear") == "linear"
    assert find(srgb_decode(linear), "srgb") == "linear"
    assert find(srgb_encode(linear), "linear") == "srgb"


def test_linear_files_that_do_not_say_so_are_named_and_no_rig_is_made_of_them(tmp_path: Path) -> None:
    rendered = render(Capture(seed=3, steepness=0.1, file_format="linear16", **SMALL))
    unsaid = measure(rendered, tmp_path / "unsaid")
    assert unsaid.stack.provenance["suggested_transfer"] == "linear"
    assert not [term for term in unsaid.stack.provenance["calibration"] if term["name"] != "motion"]
    assert any("--transfer linear" in warning for warning in unsaid.stack.health.warnings)
    assert unsaid.covered > 0.95
    assert any("--transfer linear" in warning for warning in unsaid.surface.health.warnings)
    stated = measure(rendered, tmp_path / "stated", ImportSettings(transfer="linear"))
    assert stated.stack.provenance["suggested_transfer"] is None
    assert not [term["name"] for term in stated.stack.provenance["calibration"] if term["accepted"]]
    assert np.median(stated.error_deg) < 0.6 * np.median(unsaid.error_deg)


def test_a_stated_curve_is_doubted_but_followed(tmp_path: Path) -> None:
    rendered = render(Capture(seed=3, file_format="linear16", **{**SMALL, "lamps": 12}))
    sources = find([write(rendered, tmp_path / "photographs")])
    stated = drain(import_stack(sources, ImportSettings(transfer="srgb"), tmp_path / "stack"))
    assert stated.provenance["suggested_transfer"] == "linear"
    assert {term["name"] for term in stated.provenance["calibration"]} > {"gains"}
