"""Two halves of a capture that are joined are the capture, whatever says where the lights are."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from engine.capture.lights.joined import join
from engine.capture.lights.sources import Sources, find
from engine.core.errors import InputError

ANGLES = (10, 20, 35, 50, 65, 80)


def folder(path: Path, names: list[str]) -> Path:
    path.mkdir()
    for name in names:
        (path / name).write_bytes(b"x")
    return path


def assert_same(one: Sources, other: Sources) -> None:
    """All that an import reads."""
    for name in ("photographs", "angle_source", "exposure_s", "exposures", "dark", "flat", "control_points"):
        assert getattr(one, name) == getattr(other, name), name
    assert np.array_equal(one.elevation, other.elevation)
    assert (one.azimuth is None) == (other.azimuth is None)
    if one.azimuth is not None and other.azimuth is not None:
        assert np.array_equal(one.azimuth, other.azimuth)


@pytest.mark.parametrize("names", ["felt_{0}deg.png", "felt_{1}.png"], ids=["file names", "assumed"])
@pytest.mark.parametrize("first", [(0, 1, 2), (0, 2, 4), (5, 1)])
def test_halves_that_are_joined_are_the_whole(tmp_path: Path, names: str, first: tuple[int, ...]) -> None:
    files = [names.format(angle, at) for at, angle in enumerate(ANGLES)]
    place = folder(tmp_path / "all", [*files, "dark.png"])
    half = find([place / files[at] for at in first])
    rest = find([*(place / name for at, name in enumerate(files) if at not in first), place / "dark.png"])
    whole = find([place])
    assert_same(join(half, rest), whole)
    assert_same(join(rest, half), whole)


def test_directions_all_around_stay_with_their_photographs(tmp_path: Path) -> None:
    place = folder(tmp_path / "all", [f"a{at}.png" for at in range(6)])
    both = dataclasses.replace(find([place], angles_deg=ANGLES), azimuth=np.radians([0.0, 90, 180, 270, 45, 135]))
    halves = [
        dataclasses.replace(
            both,
            photographs=both.photographs[at::2],
            elevation=both.elevation[at::2],
            azimuth=both.azimuth[at::2] if both.azimuth is not None else None,
            exposure_s=both.exposure_s[at::2],
            exposures=both.exposures[at::2],
        )
        for at in range(2)
    ]
    assert_same(join(halves[1], halves[0]), both)


def test_what_comes_twice_is_refused_by_name(tmp_path: Path) -> None:
    one = find([folder(tmp_path / "one", ["a_10deg.png", "a_30deg.png"])])
    same = find([folder(tmp_path / "same", ["a_30deg.png", "a_50deg.png"])])
    light = find([folder(tmp_path / "light", ["b_30deg.png", "b_50deg.png"])])
    with pytest.raises(InputError, match=r"a_30deg\.png"):
        join(one, same)
    with pytest.raises(InputError, match=r"a_30deg\.png and b_30deg\.png"):
        join(one, light)
    with pytest.raises(InputError, match="another source"):
        join(one, dataclasses.replace(light, sphere="auto"))
