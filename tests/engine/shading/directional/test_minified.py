"""Small sizes of directional maps against the mean radiance of the whole, by brute force."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core.colour import srgb_decode
from engine.core.steps import drain
from engine.shading.directional.minified import spread_lights
from engine.shading.directional.planes import DirectionalMap, fit
from tests.engine.domes import dome


def contrasting(height: int, width: int) -> DirectionalMap:
    """Dark and bright texels side by side, each under slopes of its own, that shine where they face the lamp."""
    stack, random = dome(24), np.random.default_rng(2)
    assert stack.azimuth is not None
    towards = np.stack(
        [np.cos(stack.elevation) * of(stack.azimuth) for of in (np.cos, np.sin)] + [np.sin(stack.elevation)], axis=1
    )
    slope = 0.3 * random.standard_normal((height, width, 2))
    normal = np.dstack([slope, np.ones((height, width))])
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    cosine = np.maximum(np.einsum("hwc,nc->nhw", normal, towards), 0.0)
    albedo = random.choice([0.02, 0.8], (height, width, 1)) * np.array([1.0, 0.8, 0.6])
    radiance = (cosine[..., None] * albedo + 0.3 * cosine[..., None] ** 20).astype(np.float32)
    changed = {"radiance": radiance, "saturated": np.zeros(radiance.shape[:3], np.bool_)}
    stack = dataclasses.replace(stack, **changed, mean_radiance=radiance.mean(axis=(1, 2, 3), dtype=np.float64))
    return drain(fit(stack, np.arange(len(radiance)), most=12))


def observe(directional: DirectionalMap, planes: NDArray[np.float64], light: int) -> NDArray[np.float64]:
    """(h, w, 3) radiance of planes under a lamp of the capture."""
    functions = directional.functions(directional.lights[light][None])[0]
    codes = np.tensordot(planes, functions[:, 1:], axes=(0, 1)) + functions[:, 0]
    return np.asarray(srgb_decode(np.maximum(codes, 0.0) / 255.0))


def test_small_sizes_show_the_mean_radiance_which_means_of_planes_do_not() -> None:
    directional = contrasting(32, 48)
    levels = directional.smaller
    assert [level.shape[1:] for level in levels] == [(16, 24), (8, 12), (4, 6), (2, 3), (1, 1)]
    errors, of_means = [], []
    for light in range(len(directional.lights)):
        whole = observe(directional, directional.planes.astype(np.float64), light)
        for index, level in enumerate(levels[:4], start=1):
            side = 2**index
            blocks = (level.shape[1], side, level.shape[2], side)
            mean = whole.reshape(*blocks, 3).mean(axis=(1, 3))
            averaged = directional.planes.reshape(-1, *blocks).mean(axis=(2, 4))
            errors.append(observe(directional, level.astype(np.float64), light) / mean - 1.0)
            of_means.append(observe(directional, averaged, light) / mean - 1.0)
    off, off_of_means = (np.concatenate([each.ravel() for each in lists]) for lists in (errors, of_means))
    assert np.mean(off_of_means) < -0.15
    assert abs(np.mean(off)) < 0.03
    assert np.sqrt(np.mean(off**2)) < 0.15


@pytest.mark.parametrize("shape", [(5, 3), (1, 7), (1, 1)])
def test_odd_sides_are_halved_down_to_one_texel(shape: tuple[int, int]) -> None:
    directional = contrasting(8, 8)
    even = np.repeat(np.repeat(directional.planes[:, :1, :1], shape[0], axis=1), shape[1], axis=2)
    levels = dataclasses.replace(directional, planes=even).smaller
    assert len(levels) == int(np.log2(max(shape)))
    for level in levels:
        np.testing.assert_allclose(level, np.broadcast_to(even[:, :1, :1], level.shape), atol=1.0)


def test_lights_are_spread_over_the_dome() -> None:
    directional = contrasting(8, 8)
    chosen = spread_lights(directional.lights, 6)
    apart = np.degrees(np.arccos(np.clip(chosen @ chosen.T, -1.0, 1.0)))[np.triu_indices(6, 1)]
    assert len(np.unique(chosen, axis=0)) == 6
    assert apart.min() > 30.0
    assert len(spread_lights(directional.lights, 100)) == len(directional.lights)
