"""Roughness and metallic of texels that photographs do not decide, and background without light."""

from __future__ import annotations

import numpy as np

from engine.core.steps import drain
from engine.surface.recover import recover
from engine.surface.regularise import smooth_roughness, weigh_neighbours
from tests.engine.surface.photographs import bump, directions, lights, stack

NOWHERE = np.zeros((40, 40), np.bool_)


def test_grains_of_salt_and_pepper_follow_their_neighbours_and_say_so() -> None:
    random = np.random.default_rng(1)
    roughness = (0.4 + 0.02 * random.standard_normal((40, 40))).astype(np.float32)
    grains = random.random((40, 40)) < 0.1
    roughness[grains] = random.choice([0.05, 0.95], int(grains.sum()))
    found, sigma = smooth_roughness(roughness, np.full((40, 40), 0.05, np.float32), NOWHERE)
    assert np.abs(found - 0.4).max() < 0.25
    assert np.sqrt(np.mean((found - 0.4) ** 2)) < 0.3 * np.sqrt(np.mean((roughness - 0.4) ** 2))
    assert np.mean(np.abs(found - 0.4) < 1.96 * sigma) > 0.9


def test_roughness_that_is_known_keeps_its_borders() -> None:
    truth = np.full((40, 40), 0.3)
    truth[:, 20:] = 0.7
    noise = 0.02 * np.random.default_rng(2).standard_normal(truth.shape)
    found, _ = smooth_roughness((truth + noise).astype(np.float32), np.full((40, 40), 0.02, np.float32), NOWHERE)
    assert np.abs(found - truth)[:, [19, 20]].mean() < 0.15
    assert np.abs(found - truth)[:, 4:14].max() < 0.06
    assert np.abs(found - truth)[:, 26:36].max() < 0.06


def test_a_single_metal_needs_more_evidence_than_one_among_metals() -> None:
    evidence = np.zeros((40, 40), np.float32)
    evidence[:, 25:] = 60.0
    evidence[10, 10] = 25.0
    evidence[30, 10] = 300.0
    evidence[20, 33] = 0.0
    needed = weigh_neighbours(evidence, 9.0, NOWHERE)
    is_metal = evidence > needed
    assert not is_metal[10, 10]
    assert is_metal[30, 10]
    assert is_metal[:, 30:].all()


def test_background_that_no_lamp_lights_is_masked() -> None:
    """A bump on a plate whose left third is a hole with nothing but noise of a photograph of 8 bits in it."""
    random = np.random.default_rng(3)
    _, normal = bump()
    elevation, azimuth = lights((25.0, 45.0, 70.0), tuple(range(0, 360, 60)))
    shown = np.maximum(np.einsum("ijk,nk->nij", normal, directions(elevation, azimuth)), 0.0)
    radiance = np.repeat(0.5 * shown[..., None], 3, axis=-1)
    radiance[:, :, :16] = 0.0006 * random.integers(0, 3, (18, 48, 16, 3))
    surface = drain(recover(stack(radiance, elevation, azimuth), np.arange(18)))
    maps = surface.maps
    assert maps.mask is not None
    assert (maps.mask[:, :15] == 0.0).all()
    assert (maps.mask[:, 17:] == 1.0).all()
    background = maps.mask == 0.0
    assert (maps.normal[background] == (0.0, 0.0, 1.0)).all()
    assert maps.uncertainty is not None
    assert maps.uncertainty.height is not None
    assert (maps.uncertainty.normal[background] > 1.5).all()
    assert np.isinf(maps.uncertainty.height[background]).all()
    assert np.isfinite(maps.uncertainty.height[:, 20:]).all()
    assert np.degrees(maps.errors.normal_sigma) < 2.0
    assert any(
        "33 % of the image is background" in each.text.replace("\u00a0", " ") for each in surface.health.findings
    )
