"""Lobes numbered alike on both sides of a border where fronts of the flood met in disagreement."""

from __future__ import annotations

import numpy as np
import pytest

from engine.core.steps import drain
from engine.transport.gaussian.fitting import lobe_matching
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, TransportSamples, _repair, run_here
from engine.transport.gaussian.fitting.flood_fill import flood
from engine.transport.gaussian.fitting.lobes import Lobes, gaussian
from engine.transport.gaussian.fitting.views import VIEWS, view_directions
from tests.engine.transport.gaussian.gaussian_lobes import gather, icosphere, places, unit


def lay_lobes(normals: np.ndarray, count: int) -> Lobes:
    """Lobes that turn slowly with the normal and the view, of different widths, all seen."""
    towards = view_directions()[None, :, None] + 0.5 * normals[:, None, None]
    apart = np.linspace(-0.15, 0.15, count)[None, None, :, None] * np.array([0.2, 1.0, 0.5])
    mean = unit(2.0 * towards + apart).astype(np.float32)
    sigma = np.broadcast_to(np.linspace(0.2, 0.4, count), mean.shape[:3]).astype(np.float32)
    return Lobes(np.ones(mean.shape, np.float32), mean, np.ascontiguousarray(sigma))


def exchange(lobes: Lobes, vertices: np.ndarray, seed: int) -> Lobes:
    """The same lobes in another order at some vertices, all views of each alike."""
    random, changed = np.random.default_rng(seed), Lobes(lobes.weight.copy(), lobes.mean.copy(), lobes.sigma.copy())
    for vertex in vertices:
        order = random.permutation(lobes.count)
        for array in (changed.weight, changed.mean, changed.sigma):
            array[vertex] = array[vertex][:, order]
    return changed


@pytest.mark.parametrize("count", [2, 3])
def test_whole_regions_that_are_numbered_otherwise_come_to_agree(count: int) -> None:
    mesh = icosphere(3)
    order = flood(mesh)
    lobes = lay_lobes(mesh.normals.astype(np.float64), count)
    assert lobe_matching.flips(lobes, order).vertices == 0
    half = np.flatnonzero(mesh.positions[:, 0] > 0.1)
    region = Lobes(lobes.weight.copy(), lobes.mean.copy(), lobes.sigma.copy())
    for array in (region.weight, region.mean, region.sigma):
        array[half] = array[half][:, :, ::-1]
    lobe_matching.renumber(region, order, 20)
    border = lobe_matching.flips(region, order).vertices
    assert border > VIEWS, "view by view the border stays"
    assert lobe_matching.align(region, order).any()
    assert lobe_matching.flips(region, order).vertices == 0
    scrambled = exchange(lobes, np.arange(len(lobes)), 4)
    lobe_matching.align(scrambled, order)
    assert lobe_matching.flips(scrambled, order).vertices == 0
    assert np.array_equal(np.sort(scrambled.sigma), np.sort(lobes.sigma)), "no lobe is lost"
    assert not lobe_matching.align(scrambled, order).any()


def test_parts_that_do_not_touch_are_numbered_each_by_itself() -> None:
    """A vertex without neighbours stays as it is."""
    mesh = icosphere(1)
    alone = type(mesh)(mesh.positions, mesh.normals, mesh.uv, mesh.faces[:1], "one face and other vertices")
    order = flood(alone)
    lobes = exchange(lay_lobes(mesh.normals.astype(np.float64), 2), np.arange(0, len(mesh.positions), 2), 5)
    lonely = np.setdiff1d(np.arange(len(mesh.positions)), mesh.faces[0])
    before = lobes.mean[lonely].copy()
    assert not lobe_matching.align(lobes, order)[lonely].any()
    assert np.array_equal(lobes.mean[lonely], before)
    assert lobe_matching.flips(lobes, order).vertices == 0


def test_a_single_view_in_another_arrangement_is_fitted_anew() -> None:
    """Two views of one vertex with their lobes the wrong way round and elsewhere; the data have them as beside."""
    mesh = icosphere(2)
    normals = mesh.normals.astype(np.float64)
    order = flood(mesh)
    whole = Fit.empty(len(normals), 2)
    truth = lay_lobes(normals, 2)
    for own, array in zip((whole.lobes.weight, whole.lobes.mean, whole.lobes.sigma), vars(truth).values(), strict=True):
        own[:] = array
    whole.norm[:], whole.error_rel[:], whole.energy[:] = 1.0, 0.001, truth.energy()
    for view in (3, 40):
        whole.lobes.mean[7, view] = whole.lobes.mean[7, view, ::-1]
        whole.lobes.sigma[7, view] = 0.3
        whole.error_rel[7, view] = 0.2
    assert lobe_matching.flips(whole.lobes, order).vertices > 4
    asked: list[int] = []

    def sample(vertices: np.ndarray) -> TransportSamples:
        asked.extend(vertices.tolist())
        direction, area = places([], 3000)
        value = [
            gaussian(direction[:, None], truth.mean[v, view].astype(np.float64), truth.sigma[v, view]) @ np.ones((2, 3))
            for v in vertices
            for view in range(VIEWS)
        ]
        return gather([(direction, each, area) for each in value])

    changed = drain(_repair(whole, order, lambda ask: run_here(sample, FitSettings(lobes=2), ask)))
    assert np.flatnonzero(changed).tolist() == [7]
    assert set(asked) <= {7, *order.neighbours(7).tolist()}, "no other vertex is looked at"
    assert lobe_matching.flips(whole.lobes, order).vertices == lobe_matching.flips(whole.lobes, order).views == 0
    assert np.abs(whole.lobes.mean[7] - truth.mean[7]).max() < 0.05
    assert whole.error_rel[7].max() < 0.05
