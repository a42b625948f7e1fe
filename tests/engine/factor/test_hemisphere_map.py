"""Maps of the hemisphere: centres, masks, and look-ups that stay inside the disk."""

from __future__ import annotations

from typing import Any, cast, get_args

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.core.directions import dot, normalize, surface_direction
from engine.factor.hemisphere_map import HemisphereMap, MapKind

KINDS = get_args(MapKind)


def hemisphere(count: int, seed: int = 0) -> np.ndarray:
    directions = normalize(np.random.default_rng(seed).normal(size=(count, 3)))
    return np.abs(directions) * np.sign(directions * (1, 1, 0) + (0, 0, 1))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("size", [1, 2, 5, 16, 48])
def test_texels_are_where_their_directions_are_looked_up(kind: MapKind, size: int) -> None:
    hemisphere_map = HemisphereMap(kind, size)
    directions = hemisphere_map.directions
    assert np.abs(dot(directions, directions) - 1.0).max() <= 1e-15
    values = np.random.default_rng(1).random((len(directions), 2))
    texture = hemisphere_map.image(values)
    assert texture.shape == (*hemisphere_map.shape, 2)
    assert np.abs(hemisphere_map.look_up(texture, directions) - values).max() <= 1e-12
    rows, columns = np.nonzero(hemisphere_map.mask)
    centres = (np.stack([columns, rows], axis=-1) + 0.5) / size
    assert np.abs(hemisphere_map.coordinates(directions) - centres).max() <= 1e-14


@pytest.mark.parametrize("kind", KINDS)
def test_solid_angles_add_up_to_the_hemisphere(kind: MapKind) -> None:
    sums = [HemisphereMap(kind, size).solid_angles.sum() / (2.0 * np.pi) for size in (32, 256)]
    assert abs(sums[1] - 1.0) <= (0.02 if kind == "orthographic" else 0.001)


def test_M8_the_last_texel_spans_16_degrees_of_elevation_in_the_orthographic_map_and_2_in_the_parabolic() -> None:
    edge = 1.0 - 2.0 / 48
    assert np.degrees(np.arccos(edge)) == pytest.approx(16.6, abs=0.05)
    assert 90.0 - np.degrees(2.0 * np.arctan(edge)) == pytest.approx(2.4, abs=0.05)
    for kind, span in (("orthographic", 16.6), ("parabolic", 2.4)):
        hemisphere_map = HemisphereMap(cast(Any, kind), 48)
        inner = surface_direction(np.radians(90.0 - span))
        assert hemisphere_map.coordinates(inner)[0] * 48 == pytest.approx(47.0, abs=0.02)


@pytest.mark.parametrize("kind", ["orthographic", "parabolic"])
def test_M9_texels_outside_the_disk_have_no_part_in_any_look_up(kind: MapKind) -> None:
    for size in (2, 5, 16, 47, 48):
        hemisphere_map = HemisphereMap(kind, size)
        texture = hemisphere_map.image(np.ones((len(hemisphere_map.directions), 1)))
        texture[~hemisphere_map.mask] = 1e9
        rim = surface_direction(np.radians(np.linspace(0.0, 90.0, 91))[:, None], np.linspace(0.0, 2.0 * np.pi, 721))
        rim[..., 2] = np.maximum(rim[..., 2], 1e-12)
        values = hemisphere_map.look_up(texture, rim)
        assert np.isfinite(values).all()
        assert np.abs(values - 1.0).max() <= 1e-12
    assert np.isfinite(HemisphereMap(kind, 48).directions).all()


@pytest.mark.parametrize("size", [3, 48])
def test_M10_the_polar_map_does_not_cancel_at_the_pole_and_has_one_value_there(size: int) -> None:
    hemisphere_map = HemisphereMap("polar", size)
    small = np.array([np.sin(1e-9), 0.0, np.cos(1e-9)])
    assert hemisphere_map.coordinates(small)[1] == pytest.approx(np.sqrt(2.0) * np.sin(0.5e-9), rel=1e-14)
    assert np.array_equal(hemisphere_map.coordinates((0.0, 0.0, 1.0)), (0.0, 0.0))
    texture = hemisphere_map.image(np.random.default_rng(2).random((size * size, 1)))
    around = hemisphere_map.look_up(texture, surface_direction(1e-12, np.linspace(0.0, 6.0, 20)))
    assert np.ptp(around) <= 1e-10
    assert around[0, 0] == pytest.approx(texture[1, :, 0].mean(), abs=1e-10)


def test_M10_the_polar_map_closes_on_itself_at_the_seam() -> None:
    hemisphere_map = HemisphereMap("polar", 16)
    texture = hemisphere_map.image(np.random.default_rng(3).random((256, 1)))
    for seam in (0.0, np.pi):
        for epsilon in (1e-3, 1e-6, 1e-9, 0.0):
            sides = hemisphere_map.look_up(texture, surface_direction(1.0, np.array([seam - epsilon, seam + epsilon])))
            assert abs(sides[1, 0] - sides[0, 0]) <= 16 / (2 * np.pi) * 2 * epsilon + 1e-12


def test_M11_parabolic_coordinates_refuse_the_opposite_of_the_normal() -> None:
    with pytest.raises(ValueError, match="opposite"):
        HemisphereMap("parabolic", 8).coordinates((0.0, 0.0, -1.0))
    assert np.isfinite(HemisphereMap("parabolic", 8).coordinates((0.6, 0.0, -0.8))).all()


@given(kind=st.sampled_from(KINDS), size=st.integers(1, 20), seed=st.integers(0, 1000))
def test_a_look_up_lies_between_the_texels(kind: MapKind, size: int, seed: int) -> None:
    hemisphere_map = HemisphereMap(kind, size)
    values = np.random.default_rng(seed).random((len(hemisphere_map.directions), 1))
    found = hemisphere_map.look_up(hemisphere_map.image(values), hemisphere(200, seed))
    assert found.min() >= values.min() - 1e-12
    assert found.max() <= values.max() + 1e-12


@pytest.mark.parametrize("kind", KINDS)
def test_a_look_up_is_continuous(kind: MapKind) -> None:
    """Near the rim, too: small steps along great circles never jump."""
    hemisphere_map = HemisphereMap(kind, 8)
    texture = hemisphere_map.image(np.random.default_rng(5).random((len(hemisphere_map.directions), 1)))
    theta = np.linspace(1e-6, 0.5 * np.pi - 1e-6, 40_001)
    for phi in np.linspace(0.0, 2.0 * np.pi, 13):
        assert np.abs(np.diff(hemisphere_map.look_up(texture, surface_direction(theta, phi))[:, 0])).max() <= 0.01


@pytest.mark.parametrize("kind", KINDS)
def test_flips_lead_to_the_mirrored_direction(kind: MapKind) -> None:
    hemisphere_map = HemisphereMap(kind, 8)
    assert hemisphere_map.flips is not None
    for flip, sign in zip(hemisphere_map.flips, ((-1, 1, 1), (1, -1, 1)), strict=True):
        assert np.abs(hemisphere_map.directions[flip] - hemisphere_map.directions * sign).max() <= 1e-15
    assert HemisphereMap(kind, 5).flips is None
    assert (HemisphereMap(kind, 6).flips is None) == (kind == "polar"), "two columns lie on the y axis"


@pytest.mark.parametrize(("kind", "size"), [("square", 8), ("polar", 0), ("polar", 5000)])
def test_unknown_maps_are_refused(kind: MapKind, size: int) -> None:
    with pytest.raises(ValueError, match="map"):
        HemisphereMap(kind, size)
