"""PBR maps are checked once, where they are made."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from engine.surface.pbr_maps import ObservedSlopes, PbrMaps, Uncertainty

SIZE = (3, 4)


def maps() -> PbrMaps:
    plane, colour = np.full(SIZE, 0.5, np.float32), np.full((*SIZE, 3), 0.5, np.float32)
    normal = np.zeros((*SIZE, 3), np.float32)
    normal[..., 2] = 1.0
    return PbrMaps(colour, normal, plane, plane, plane)


def test_maps_of_one_size_are_accepted_and_then_cannot_be_written() -> None:
    made = maps()
    assert made.size == SIZE
    assert not made.roughness.flags.writeable


@pytest.mark.parametrize("name", ["base_colour", "roughness", "metallic", "f0", "occlusion"])
@pytest.mark.parametrize("wrong", [-0.1, 1.1, np.nan])
def test_values_outside_their_range_are_refused(name: str, wrong: float) -> None:
    values = np.full((*SIZE, 3) if name == "base_colour" else SIZE, 0.5, np.float32)
    values[1, 1] = wrong
    changed: dict[str, Any] = {name: values}
    with pytest.raises(ValueError, match=name):
        replace(maps(), **changed)


def test_normals_that_are_no_unit_vectors_are_refused() -> None:
    with pytest.raises(ValueError, match="unit vectors"):
        replace(maps(), normal=np.full((*SIZE, 3), 0.5, np.float32))


def test_a_map_of_another_size_or_kind_is_refused() -> None:
    with pytest.raises(ValueError, match="f0 must be float32"):
        replace(maps(), f0=np.zeros((4, 3), np.float32))
    with pytest.raises(ValueError, match="f0 must be float32"):
        replace(maps(), f0=cast(Any, np.zeros(SIZE)))


def test_an_uncertainty_belongs_to_each_map_that_is_known() -> None:
    plane, colour = np.zeros(SIZE, np.float32), np.zeros((*SIZE, 3), np.float32)
    known = Uncertainty(colour, plane, plane, plane, plane)
    assert replace(maps(), uncertainty=known).uncertainty is known
    with pytest.raises(ValueError, match="height and its uncertainty"):
        replace(maps(), uncertainty=known, height=plane)
    with pytest.raises(ValueError, match="uncertainty of f0"):
        replace(maps(), uncertainty=replace(known, f0=np.full(SIZE, -1.0, np.float32)))


def test_only_an_arc_has_a_direction() -> None:
    assert ObservedSlopes("along the arc", 0.0).azimuth == 0.0
    with pytest.raises(ValueError, match="azimuth"):
        ObservedSlopes("along the arc")
    with pytest.raises(ValueError, match="azimuth"):
        ObservedSlopes("both", 1.0)
