"""Choice of lights from a dome: an azimuth, the best arc, a list."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.capture.lights.selection import Arc, Azimuth, Listed, arcs, select
from engine.capture.lights.sources import Sources, find
from engine.core.errors import InputError, UsageError

#: Elevation and azimuth in degrees of a small dome; photograph n stands in line n.
DOME = [(20, 350), (20, 80), (30, 90), (40, 5), (50, 95), (60, 200), (65, 85), (70, 355), (89.5, 123)]


@pytest.fixture
def dome(tmp_path: Path) -> Sources:
    lines = [str(len(DOME))]
    for number, (elevation, azimuth) in enumerate(np.radians(DOME), 1):
        (tmp_path / f"shot{number}.png").write_bytes(b"x")
        flat = np.cos(elevation)
        lines.append(f"shot{number}.png {flat * np.cos(azimuth)} {flat * np.sin(azimuth)} {np.sin(elevation)}")
    (tmp_path / "dome.lp").write_text("\n".join(lines))
    return find([tmp_path])


def numbers(sources: Sources) -> list[Any]:
    return sorted(int(path.stem[4:]) for path in sources.photographs)


@pytest.mark.parametrize(
    ("selection", "expected"),
    [
        (Azimuth(90, 10), [2, 3, 5, 7, 9]),
        (Azimuth(90, 5), [3, 5, 7, 9]),
        (Azimuth(-1, 9.1), [1, 4, 8, 9]),
        (Azimuth(720 - 361, 9.1), [1, 4, 8, 9]),
        (Arc(), [2, 3, 5, 7, 9]),
        (Listed(("1", "3-5", "shot8.png")), [1, 3, 4, 5, 8]),
    ],
)
def test_lights_by_azimuth_arc_and_list(dome: Sources, selection: Any, expected: Any) -> None:
    kept = select(dome, selection)
    assert numbers(kept) == expected
    elevations = np.degrees(kept.elevation)
    assert elevations == pytest.approx(sorted(DOME[number - 1][0] for number in expected))
    assert len(kept.exposures) == len(kept.exposure_s) == len(kept.highlights_px) == len(expected)
    assert [light[0].path for light in kept.exposures] == list(kept.photographs)
    assert any(f"{len(expected)} of 9 lights are used" in finding.text for finding in kept.findings)


def test_the_warning_of_many_azimuths_goes_with_their_lights(dome: Sources) -> None:
    def warn(sources: Sources) -> bool:
        return any("lights spread over" in finding.text for finding in sources.findings)

    assert warn(dome)
    assert not warn(select(dome, Listed(("2", "7"))))


@pytest.mark.parametrize(
    ("selection", "words"),
    [
        (Azimuth(270, 10), "has one light only at azimuth 270° ± 10°"),
        (Listed(("0",)), "has lights 1 to 9, but 0 was asked for"),
        (Listed(("8-10",)), "but 8-10 was asked for"),
        (Listed(("9-8",)), "but 9-8 was asked for"),
        (Listed(("other.png",)), "no light called other.png"),
        (Listed(("4", "shot4.png")), "keeps one light of the list only"),
    ],
)
def test_choices_that_leave_no_capture_are_refused(dome: Sources, selection: Any, words: str) -> None:
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        select(dome, selection)


def test_an_azimuth_is_not_chosen_where_none_is_known(tmp_path: Path) -> None:
    for angle in (10, 40, 80):
        (tmp_path / f"x_{angle}deg.png").write_bytes(b"x")
    with pytest.raises(InputError, match="has no azimuths"):
        select(find([tmp_path]), Arc())
    assert len(select(find([tmp_path]), Listed(("1", "3"))).photographs) == 2


def test_impossible_azimuths_are_wrong_usage() -> None:
    for azimuth, tolerance in ((400, 1), (float("nan"), 1), (90, -1), (90, 181)):
        with pytest.raises(UsageError):
            Azimuth(azimuth, tolerance)


def test_arcs_of_a_dome_share_the_light_above() -> None:
    """Three arcs, one of them a degree askew, a light above all, and two lights that make no arc."""
    azimuth = [0.0, 1.0, 359.0, 120.0, 121.0, 119.0, 240.0, 240.0, 240.0, 77.0, 60.0, 61.0]
    elevation = [20.0, 45.0, 70.0, 20.0, 45.0, 70.0, 20.0, 45.0, 70.0, 90.0, 30.0, 30.5]
    found = arcs(np.radians(azimuth), np.radians(elevation))
    assert [list(own) for _, own in found] == [[0, 1, 2, 9], [3, 4, 5, 9], [6, 7, 8, 9]]
    np.testing.assert_allclose([near.middle_deg % 360.0 for near, _ in found], [0.0, 120.0, 240.0], atol=0.6)


def test_lights_of_one_elevation_are_no_arc() -> None:
    assert arcs(np.radians(np.arange(0.0, 360.0, 5.0)), np.full(72, np.radians(40.0))) == []
