"""What photographs tell of the rig that lit them, on captures of known truth."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.capture.calibration.estimate import Estimate, estimate, sample_texels
from engine.capture.calibration.motion import camera_motion
from engine.capture.calibration.rig import TERMS
from engine.capture.import_plan import ImportSettings
from engine.core.steps import drain
from tests.engine.capture.calibration.generated import Capture, Rendered, draw, render
from tests.engine.capture.calibration.measured import measure

SMALL: dict[str, Any] = {"height": 48, "width": 56, "lamps": 18}


def _estimated(rendered: Rendered) -> Estimate:
    clipped = [(each >= 0.99).any(axis=-1).astype(np.float32) for each in rendered.photographs]
    return estimate(sample_texels(list(rendered.photographs), clipped, 400), rendered.directions, TERMS)


def test_near_and_unequal_lamps_are_found_within_their_intervals() -> None:
    rendered = render(Capture(seed=3, distance=3.0, gains=(0.5, 1.5), **SMALL))
    found = _estimated(rendered)
    assert set(found.accepted) == {"distance", "gains"}
    assert 1.0 / found.rig.nearness == pytest.approx(3.0, rel=0.02)
    off = found.rig.log_gains - np.log(rendered.gains)
    assert np.std(off) < 0.01
    distance = next(term for term in found.terms if term.name == "distance")
    assert abs(found.rig.nearness - 1.0 / 3.0) < 3.0 * distance.sigma + 1e-3
    assert distance.held_out_after < 0.5 * distance.held_out_before


def test_a_lamp_far_weaker_than_the_others_is_heard() -> None:
    rendered = render(Capture(seed=5, **SMALL))
    photographs = rendered.photographs.copy()
    photographs[4] *= 0.3
    clipped = [np.zeros(each.shape[:2], np.float32) for each in photographs]
    found = estimate(sample_texels(list(photographs), clipped, 400), rendered.directions, ("gains",))
    gains = np.exp(found.rig.log_gains - np.median(found.rig.log_gains))
    assert gains[4] == pytest.approx(0.3, rel=0.03)
    assert np.delete(gains, 4) == pytest.approx(np.ones(17), rel=0.03)


def test_room_light_from_one_side_is_found() -> None:
    found = _estimated(render(Capture(seed=8, room=0.15, distance=4.0, **SMALL)))
    assert set(found.accepted) == {"distance", "ambient"}
    assert np.linalg.norm(found.rig.ambient) == pytest.approx(0.13, abs=0.04)


@pytest.mark.parametrize("material", ["matte", "satin metal"])
def test_distant_equal_lamps_in_a_dark_room_are_left_as_they_are(material: str) -> None:
    assert _estimated(render(Capture(seed=2, material=material, **SMALL))).accepted == ()


def test_a_camera_that_moved_is_followed_and_one_that_stood_still_is_not() -> None:
    for step in (0.0, 0.4):
        rendered = render(Capture(seed=4, motion_px=step, surface="coin", **SMALL))
        images = [np.ascontiguousarray(each.mean(axis=-1)) for each in rendered.photographs]
        found = drain(camera_motion(images, rendered.directions))
        assert found.moved == (step > 0.0)
        off = np.hypot(*(found.shifts - (rendered.shifts - rendered.shifts[0])).T)
        assert np.median(off) < 0.15
        assert off.max() < 0.6


def test_an_import_without_options_recovers_normals_of_a_near_unequal_dome(tmp_path: Path) -> None:
    rendered = render(Capture(seed=3, distance=2.5, gains=(0.6, 1.3), **SMALL))
    measured = measure(rendered, tmp_path)
    assert np.median(measured.error_deg) < 0.5  # 10 degrees without calibration
    provenance = measured.stack.provenance
    assert provenance["lamp_distance_widths"] == pytest.approx(2.5, rel=0.03)
    assert len(provenance["lamp_gains"]) == 18
    assert {term["name"] for term in provenance["calibration"] if term["accepted"]} == {"distance", "gains"}


def test_normals_of_near_lamps_that_nobody_corrected_for_are_doubted(tmp_path: Path) -> None:
    rendered = render(Capture(seed=3, distance=2.5, **SMALL))
    measured = measure(rendered, tmp_path, ImportSettings(calibrate="none"))
    assert np.median(measured.error_deg) > 4.0
    assert measured.covered > 0.9
    assert any("Not corrected for: Lamps 2.5" in warning for warning in measured.surface.health.warnings)


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_captures_that_go_wrong_in_every_way_are_recovered(tmp_path: Path) -> None:
    """100 captures without an option, see `tests.engine.capture.calibration.measured`."""
    medians, covered = [], []
    for seed in range(100):
        measured = measure(render(draw(seed)), tmp_path / str(seed))
        medians.append(float(np.median(measured.error_deg)))
        covered.append(measured.covered)
        shutil.rmtree(tmp_path / str(seed))
    assert np.median(medians) <= 1.0
    assert np.mean(np.array(medians) <= 2.0) >= 0.9
    assert np.mean(np.array(covered) >= 0.95) >= 0.95
