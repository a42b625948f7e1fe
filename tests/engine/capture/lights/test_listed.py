"""Lights of a capture whose photographs are not all there."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from engine.capture.lights.listed import COVERS_DEG, coverage, from_names, read_listed
from engine.capture.lights.mirror_sphere import Circle


def test_a_list_is_matched_by_names_numbers_and_order(tmp_path: Path) -> None:
    list_file = tmp_path / "lights.lp"
    list_file.write_text("3\nIMG_7.jpg 1 0 0\nIMG_8.jpg 0 0 1\nIMG_9.jpg 0 0.6 0.8\n")
    listed = read_listed([list_file])
    assert listed is not None
    assert len(listed.directions) == 3
    for names in (["IMG_9.jpg", "IMG_7.jpg"], ["img_9.dng", "img_7.dng"], ["cloth-9.tif", "cloth-007.tif"]):
        high, low = listed.match([Path(name) for name in names])
        assert high == pytest.approx((math.degrees(math.asin(0.8)), 90.0))
        assert low == pytest.approx((0.0, 0.0))
    assert listed.match([Path("other_9.tif"), Path("IMG_7.jpg"), Path("IMG_8.jpg")])[::2] == [None, (90.0, 0.0)]
    ordered = read_listed([], (10.0, 20.0))
    assert ordered is not None
    assert ordered.match([Path("b2.tif"), Path("b10.tif"), Path("b1.tif")]) == [(20.0, None), None, (10.0, None)]


def test_a_sphere_tells_lights_in_place_of_a_list(tmp_path: Path) -> None:
    file = tmp_path / "capture.toml"
    file.write_text(
        "[sphere]\ncolumn_px = 40.0\nrow_px = 50.0\nradius_px = 30.0\n"
        '[[photographs]]\nfile = "a.tif"\n[[photographs]]\nfile = "b.tif"\n'
    )
    listed = read_listed([file])
    assert listed is not None
    assert (listed.directions, listed.count, listed.sphere) == ((), 2, Circle(40.0, 50.0, 30.0))
    assert listed.match([Path("a.tif")]) == [None]


def test_angles_of_names_come_with_each_photograph() -> None:
    assert from_names([Path("cloth_20deg.tif"), Path("white.tif")]) == [(20.0, None), None]
    assert from_names([]) == []


def test_coverage_is_the_solid_angle_near_lamps() -> None:
    cap = 1.0 - math.cos(math.radians(COVERS_DEG))  # of 1, the height of the hemisphere
    assert coverage([(90.0, 0.0)]) == pytest.approx(cap, abs=0.002)
    assert coverage([(90.0, 0.0), (90.0, 10.0)]) == pytest.approx(cap, abs=0.002)
    assert coverage([(0.0, 0.0)]) == pytest.approx(cap / 2.0, abs=0.003)  # half of it lies below the sample
    assert coverage([(0.0, 0.0), (90.0, 0.0)]) == pytest.approx(1.5 * cap, abs=0.004)
    assert coverage([(45.0, None)]) is None
    assert coverage([]) is None
