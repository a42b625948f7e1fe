"""Photographs that leave a capture, and files that take the place of others, with what is known of each."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from app.document.document import ImportChoices
from app.document.import_choices import choices_without, with_file, without
from engine.capture.lights.sources import Sources
from engine.capture.photograph.exposures import Exposure
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict

FILES = tuple(Path(f"/capture/{name}.png") for name in "abc")


@pytest.fixture
def sources() -> Sources:
    return Sources(
        photographs=FILES,
        elevation=np.array([0.2, 0.6, 1.2]),
        azimuth=np.array([0.0, 1.0, 2.0]),
        angle_source="lp",
        exposure_s=(1.0, 0.5, 0.25),
        exposures=tuple((Exposure(path, None),) for path in FILES),
        highlights_px=((1.0, 2.0), None, (3.0, 4.0)),
        reference=FILES[1],
        control_points={FILES[1]: ((1.0, 1.0, 2.0, 2.0),), FILES[2]: ((3.0, 3.0, 4.0, 4.0),)},
        findings=(Finding(Verdict.WARNING, "blurred", "b.png"), Finding(Verdict.NOTE, "of all")),
    )


def test_what_is_known_of_a_photograph_leaves_with_it(sources: Sources) -> None:
    left = without(sources, {1})
    assert left.photographs == (FILES[0], FILES[2])
    assert left.elevation.tolist() == [0.2, 1.2]
    assert left.azimuth is not None
    assert left.azimuth.tolist() == [0.0, 2.0]
    assert left.exposure_s == (1.0, 0.25)
    assert [one.path for (one,) in left.exposures] == [FILES[0], FILES[2]]
    assert left.highlights_px == ((1.0, 2.0), (3.0, 4.0))
    assert left.reference is None
    assert set(left.control_points) == {FILES[2]}
    assert [finding.text for finding in left.findings] == ["of all"]
    assert left.angle_source == "lp"


def test_two_photographs_stay(sources: Sources) -> None:
    with pytest.raises(InputError, match="At least two"):
        without(sources, {0, 2})


def test_another_file_comes_under_the_same_light(sources: Sources) -> None:
    other = Path("/elsewhere/new.png")
    changed = with_file(sources, 1, other)
    assert changed.photographs == (FILES[0], other, FILES[2])
    assert changed.elevation.tolist() == sources.elevation.tolist()
    assert changed.exposures[1] == (Exposure(other, None),)
    assert changed.exposure_s == (1.0, None, 0.25)
    assert changed.reference is None
    assert set(changed.control_points) == {FILES[2]}
    assert [finding.text for finding in changed.findings] == ["of all"]


def test_names_stay_unique_but_the_same_name_from_elsewhere_may_come(sources: Sources) -> None:
    with pytest.raises(InputError, match="has the name of another photograph"):
        with_file(sources, 1, Path("/elsewhere/c.png"))
    assert with_file(sources, 1, Path("/elsewhere/b.png")).photographs[1] == Path("/elsewhere/b.png")


def test_a_photograph_without_reflections_known_has_none_after(sources: Sources) -> None:
    bare = dataclasses.replace(sources, highlights_px=(), azimuth=None)
    assert with_file(bare, 0, Path("/d.png")).highlights_px == ()
    assert without(bare, {0}).azimuth is None


def test_choices_forget_what_is_gone() -> None:
    pairs = ((1.0, 1.0, 2.0, 2.0),)
    choices = ImportChoices(
        motion="none",
        reference="b.png",
        highlights={"b.png": (1.0, 2.0), "c.png": (1.0, 3.0)},
        control_points={"b.png": pairs, "c.png": pairs},
    )
    kept = choices_without(choices, {"b.png"})
    assert kept == ImportChoices(motion="none", highlights={"c.png": (1.0, 3.0)}, control_points={"c.png": pairs})
