"""Depth edges and the regions between them, against scenes of objects before a background whose heights are known."""

from __future__ import annotations

import numpy as np
import pytest

from engine.core.steps import drain
from engine.surface import depth_edges
from engine.surface.depth_edges import Division, ShadowEdges, divide, doubt_open_outlines, find_depth_edges
from engine.surface.lamps import lamps
from engine.surface.pbr_maps import PbrMaps, count_regions
from engine.surface.recover import recover
from tests.engine.capture.calibration.generated import Capture, render
from tests.engine.surface.objects import Scene, draw_scene
from tests.engine.surface.photographs import stack


def errors(scene: Scene, maps: PbrMaps) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of heights, from the mean of each region that was found, their deviation, and the texels that show one
    surface alone."""
    assert maps.height is not None
    assert maps.uncertainty is not None
    assert maps.uncertainty.height is not None
    region = np.zeros(maps.size, np.int64) if maps.region is None else maps.region.astype(np.int64)
    sigma, off = maps.uncertainty.height, maps.height - scene.height
    pure = scene.surface >= 0
    for each in range(count_regions(maps)):
        known = pure & (region == each) & np.isfinite(sigma)
        off[region == each] -= off[known].mean() if known.any() else 0.0
    return np.abs(off)[pure], sigma[pure], region[pure]


def test_heights_of_objects_are_within_their_intervals() -> None:
    scene = draw_scene(0, size=(64, 72))
    maps = drain(recover(scene.stack, np.arange(len(scene.stack.sources)), left_out=False)).maps
    error, sigma, _ = errors(scene, maps)
    known = np.isfinite(sigma)
    assert np.mean(error <= 1.96 * sigma) >= 0.97
    assert known.mean() > 0.85
    assert np.sqrt(np.mean(error[known] ** 2)) < 0.3
    assert count_regions(maps) >= 3


@pytest.mark.long
def test_heights_of_twenty_scenes() -> None:
    """Scenes of which less is covered have an edge that hardly casts a shadow along most of an outline."""
    covered = []
    for seed in range(20):
        scene = draw_scene(seed)
        maps = drain(recover(scene.stack, np.arange(len(scene.stack.sources)), left_out=False)).maps
        error, sigma, _ = errors(scene, maps)
        covered.append(float(np.mean(error <= 1.96 * sigma)))
        on_edges = float(np.isinf(sigma).mean())
        print(f"{seed}: {covered[-1]:.3f} covered, {on_edges:.3f} on edges, {count_regions(maps)} regions", flush=True)
        assert on_edges < 0.25
    assert np.mean(covered) >= 0.92
    assert np.sum(np.array(covered) >= 0.95) >= 14


def test_a_smooth_relief_has_no_edges() -> None:
    scene = draw_scene(3, objects=0, size=(56, 64))
    maps = drain(recover(scene.stack, np.arange(len(scene.stack.sources)), left_out=False)).maps
    assert maps.region is None
    error, sigma, _ = errors(scene, maps)
    assert np.isfinite(sigma).all()
    assert np.mean(error <= 1.96 * sigma) >= 0.95


def test_blocks_of_rows_give_the_edges_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = draw_scene(0, size=(40, 48))
    used = np.arange(len(scene.stack.sources))
    directions = lamps(scene.stack, used).direction
    whole = drain(find_depth_edges(scene.stack, used, directions))
    assert len(whole.places) > 50
    monkeypatch.setattr(depth_edges, "BLOCK_VALUES", 1)
    parts = drain(find_depth_edges(scene.stack, used, directions))
    np.testing.assert_array_equal(parts.places, whole.places)
    np.testing.assert_array_equal(parts.shadowed, whole.shadowed)


def test_a_steep_surface_that_turns_away_from_lamps_is_no_edge() -> None:
    """Grains of slopes up to two texels a texel, whose shadows begin as sharply as those of edges."""
    capture = Capture(seed=1, surface="grains", material="plastic", lamps=28, steepness=0.45)
    rendered = render(capture)
    towards = rendered.directions
    photographs = rendered.photographs.astype(np.float64)
    made = stack(photographs, np.arcsin(towards[:, 2]), np.arctan2(towards[:, 1], towards[:, 0]))
    maps = drain(recover(made, np.arange(28), left_out=False)).maps
    height = rendered.heights * capture.width
    assert maps.height is not None
    assert np.sqrt(np.mean((maps.height - (height - height.mean())) ** 2)) < 0.08
    seen = drain(find_depth_edges(made, np.arange(28), towards)).mark((80, 96))
    assert seen.mean() > 0.02  # which only the fit tells from edges


def test_outlines_with_small_gaps_divide_and_cracks_do_not() -> None:
    edges = np.zeros((80, 100), np.bool_)
    edges[20:60, [30, 70]] = edges[[20, 59], 30:71] = True
    edges[38:42, 30] = False
    found = divide(edges)
    assert found is not None
    assert found.count == 2
    assert (found.region[25:55, 35:65] == 1).all()
    assert (found.region[:15] == 0).all()
    assert found.edges[38:42, 26:35].any(axis=1).all()  # the gap is unknown as well
    edges[20:60, 30:50] = False  # half of the outline
    found = divide(edges)
    assert found is not None
    assert found.count == 1
    assert divide(np.zeros((5, 6), np.bool_)) is None


def test_an_outline_that_ends_within_a_region_makes_its_heights_doubtful() -> None:
    """A lamp at 45° on the right shows the shadow of a wall along a column, of which the height knows, or does not."""
    rows = np.arange(5, 35)
    places = np.stack([rows, np.full(30, 20)], axis=1)
    lamps_at = np.array([[1.0, 0.0, 1.0], [0.9, 0.1, 1.0], [-1.0, 0.0, 1.0]])
    directions = lamps_at / np.linalg.norm(lamps_at, axis=1, keepdims=True)
    shadowed = np.tile([True, True, False], (30, 1))
    edges = ShadowEdges(places, shadowed, directions, np.ones((40, 40), np.float32))
    slope = np.broadcast_to(np.linspace(0.0, 1.0, 40), (40, 40))
    wall = slope + 8.0 * (np.arange(40) > 20)
    inside = np.zeros((40, 40), np.bool_)
    for height, is_contradicted in ((slope, True), (wall, False), (-wall, True)):
        found = edges.find_contradicted(height)
        assert found[rows, 20].all() == found.any() == is_contradicted
        doubt = doubt_open_outlines(found, None, height, inside)
        assert (doubt > 0.8).all() == doubt.any() == is_contradicted
    # along the border of two regions an outline is closed, and a short one counts for nothing
    division = Division(inside, np.asarray(np.broadcast_to(np.arange(40) > 20, (40, 40)), np.int32))
    marked = edges.find_contradicted(slope)
    assert not doubt_open_outlines(marked, division, slope, inside).any()
    marked[15:] = False
    assert not doubt_open_outlines(marked, None, slope, inside).any()


def test_regions_are_numbered_by_their_size() -> None:
    edges = np.zeros((60, 100), np.bool_)
    edges[:, [20, 50]] = True
    found = divide(edges)
    assert found is not None
    assert [found.region[30, column] for column in (10, 35, 80)] == [2, 1, 0]
