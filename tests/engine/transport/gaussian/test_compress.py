"""Compressed lobes: what the codes lose, what is left out, and what cannot be."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.core.directions import normalize
from engine.light.cube_map import cube_of
from engine.light.environment_file import open_environment
from engine.transport.gaussian.compress import CLUSTERS, NAMES, cluster, compress, restore, size_bytes
from engine.transport.gaussian.error import change
from engine.transport.gaussian.fitting.lobes import NARROWEST, WIDEST_LOBE, Lobes
from engine.transport.gaussian.fitting.views import VIEWS, view_directions, view_neighbours


def lobes_of(vertices: int, lobes: int, seed: int, kinds: int | None = None) -> Lobes:
    """Random lobes, half of whose views are dark; widths and energies of so many `kinds`, all different by default."""
    rng = np.random.default_rng(seed)
    shape = (vertices, VIEWS, lobes)
    mean = normalize(rng.normal(size=(*shape, 3)))
    sigma = NARROWEST * (WIDEST_LOBE / NARROWEST) ** rng.random(shape)
    weight = 10.0 ** rng.uniform(-3.0, 1.0, (*shape, 1)) * rng.random((*shape, 3))
    if kinds is not None:
        number = rng.integers(kinds, size=shape)
        sigma, weight = sigma.reshape(-1)[number], weight.reshape(-1, 3)[number]
    weight[rng.random(shape[:2]) < 0.5] = 0.0
    return Lobes(weight.astype(np.float32), mean.astype(np.float32), sigma.astype(np.float32))


def angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray(2.0 * np.arcsin(0.5 * np.linalg.norm(one.astype(np.float64) - other, axis=-1)))


@pytest.mark.parametrize("lobes", [1, 2])
def test_codes_lose_no_more_than_they_say(lobes: int) -> None:
    original = lobes_of(30, lobes, 0)
    arrays = compress(original)
    found = restore(arrays, 30, lobes)
    lit = original.weight.any(axis=(2, 3))
    assert np.array_equal(found.weight.any(axis=(2, 3)), lit)
    assert angles(found.mean[lit], original.mean[lit]).max() < 1.1e-3
    assert np.abs(np.log(found.sigma[lit] / original.sigma[lit])).max() < 0.0142
    energy, exact = found.energy(), original.energy()
    share = np.abs(energy - exact).max(axis=-1) / np.maximum(exact.max(axis=-1), 1e-5)
    assert share.max() < 1.01 / 511.0
    assert size_bytes(arrays) == 30 * 12 + int(lit.sum()) * lobes * 8


@given(st.integers(0, 2**32 - 1))
def test_means_keep_their_direction_all_over_the_sphere(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mean = normalize(rng.normal(size=(1, VIEWS, 1, 3)) * 10.0 ** rng.uniform(-8.0, 0.0, (1, VIEWS, 1, 3)))
    ones = np.ones((1, VIEWS, 1, 3), np.float32)
    found = restore(compress(Lobes(ones, mean.astype(np.float32), ones[..., 0])), 1, 1)
    assert angles(found.mean, mean).max() < 1.1e-3


def test_few_kinds_of_lobes_share_a_book() -> None:
    original = lobes_of(800, 1, 1, kinds=300)
    arrays = compress(original)
    assert arrays["book"].shape == (CLUSTERS, 4)
    assert size_bytes(arrays) < 0.9 * (800 * 12 + int(original.weight.any(axis=(2, 3)).sum()) * 8)
    found = restore(arrays, 800, 1)
    bright = original.energy().max(axis=-1)
    share = np.abs(found.energy() - original.energy()).max(axis=-1) / np.maximum(bright, 1e-9)
    assert np.sqrt((share**2 * bright).sum() / bright.sum()) < 0.02
    assert len(compress(lobes_of(800, 1, 2))["book"]) == 0


def near_kinds(spread: float) -> tuple[np.ndarray, np.ndarray]:
    """Widths (N, 1) and energies (N, 1, 3) about 300 kinds, whose logarithms they are off by `spread` (RMS)."""
    rng = np.random.default_rng(5)
    kind = rng.integers(300, size=40_000)
    sigma, energy = 10.0 ** rng.uniform(-2.0, -0.5, 300)[kind], 10.0 ** rng.uniform(-2.0, 1.0, (300, 3))[kind]
    off = np.exp(spread * rng.normal(size=(40_000, 4)))
    return (sigma * off[:, 0]).astype(np.float32)[:, None], (energy * off[:, 1:])[:, None]


def test_a_book_is_kept_where_it_is_close_and_nowhere_else() -> None:
    assert cluster(*near_kinds(0.005)) is not None
    assert cluster(*near_kinds(0.06)) is None


def test_the_entries_of_a_book_are_the_means_of_what_they_stand_for() -> None:
    sigma, energy = near_kinds(0.01)
    found = cluster(sigma, energy)
    assert found is not None
    book, number = found
    points = np.log(np.concatenate([sigma, energy[:, 0]], axis=1))
    weight = energy.sum(axis=(1, 2))
    total = np.bincount(number[:, 0], weight, CLUSTERS)
    sums = np.stack([np.bincount(number[:, 0], weight * column, CLUSTERS) for column in points.T], axis=-1)
    used = total > 0.0
    apart = sums[used] / total[used, None] - np.log(book[used])
    assert np.sqrt((apart**2).mean()) < 0.1 * 0.01


def test_dark_views_lie_between_those_beside_them() -> None:
    mean = np.broadcast_to(view_directions()[:, None], (1, VIEWS, 1, 3)).astype(np.float32)
    sigma = np.full((1, VIEWS, 1), 0.3, np.float32)
    weight = np.ones((1, VIEWS, 1, 3), np.float32)
    weight[0, view_directions()[:, 1] < 0.0] = 0.0
    found = restore(compress(Lobes(weight, mean, sigma)), 1, 1)
    lit = cast(Any, weight.any(axis=(2, 3)))[0]
    neighbours = view_neighbours()[0]
    beside = [view for view in np.flatnonzero(~lit) if lit[neighbours[view][neighbours[view] >= 0]].any()]
    for view in beside:
        around = [other for other in neighbours[view] if other >= 0 and lit[other]]
        assert angles(found.mean[0, view, 0], normalize(mean[0, around, 0].mean(axis=0))).max() < 2e-3
    assert np.abs(found.sigma - 0.3).max() < 0.3 * 0.0142
    dark = restore(compress(Lobes(0.0 * weight, mean, sigma)), 1, 1)
    assert np.abs(dark.mean[0, :, 0] - view_directions()).max() < 1e-6


def test_the_radiance_changes_by_little() -> None:
    original = lobes_of(40, 2, 3)
    found = restore(compress(original), 40, 2)
    assert 0.0 < change(original, found, cube_of(open_environment("studio"), 16)) < 0.03
    assert change(original, original, cube_of(open_environment("studio"), 16)) == 0.0


def test_arrays_that_cannot_be_are_refused() -> None:
    good = compress(lobes_of(3, 1, 4))
    assert set(good) == set(NAMES)
    bad = {
        "lit": good["lit"][:2],
        "mean": good["mean"][1:],
        "sigma": good["sigma"].astype(np.uint16),
        "energy": good["energy"][:1],
        "book": np.ones((4, 3), np.float32),
    }
    for name, array in bad.items():
        with pytest.raises(ValueError, match="its"):
            restore({**good, name: array}, 3, 1)
    count = len(good["sigma"])
    shared = {**good, "book": np.ones((2, 4), np.float32), "energy": np.zeros((0, 1), np.uint32)}
    with pytest.raises(ValueError, match="clusters"):
        restore({**shared, "sigma": np.full((count, 1), 2, np.uint16)}, 3, 1)
    with pytest.raises(ValueError, match="widths"):
        restore({**shared, "book": np.full((2, 4), -1.0, np.float32), "sigma": np.zeros((count, 1), np.uint16)}, 3, 1)
