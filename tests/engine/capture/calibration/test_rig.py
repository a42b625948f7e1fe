"""Steps of the fit of a rig, against normal equations of all unknowns."""

from __future__ import annotations

import numpy as np
import pytest

from engine.capture.calibration import rig
from engine.capture.calibration.rig import Fit, Model, Rig, Sample

TEXELS, LAMPS, BLOCKS = 6, 20, 3


@pytest.mark.parametrize(("parameters", "terms"), [(3, rig.TERMS), (5, rig.TERMS), (3, ("distance", "ambient"))])
def test_a_step_is_that_of_the_normal_equations_of_all_unknowns(parameters: int, terms: tuple[str, ...]) -> None:
    random = np.random.default_rng(parameters)
    shape = TEXELS, LAMPS
    values, usable, block = random.random(shape), np.ones(shape, bool), random.integers(0, BLOCKS, TEXELS)
    sample = Sample(values, usable, random.random((TEXELS, 2)), np.ones(TEXELS), block)
    arrays = [random.standard_normal(each) for each in (shape, (*shape, parameters), shape, shape, (TEXELS, 3))]
    model, weights = Model(*arrays), random.random(shape) * (random.random(shape) < 0.9)
    before = Rig(0.3, random.uniform(-0.2, 0.2, LAMPS), random.uniform(0.0, 0.2, 3))
    free = rig._free(terms, LAMPS)
    after, inverse, scores = rig._step(sample, model, before, weights, free)

    root = np.sqrt(weights)
    normal, expected, left = np.zeros((4 + LAMPS, 4 + LAMPS)), np.zeros((int(block.max()) + 1, 4 + LAMPS)), 0.0
    for texel in range(TEXELS):
        ambient = np.tile(model.albedo_normals[texel], (LAMPS, 1))
        of_rig = np.column_stack([model.by_nearness[texel], ambient, np.diag(model.lit[texel])]) * root[texel, :, None]
        basis = np.linalg.qr(model.tangent[texel] * root[texel, :, None])[0]
        outside = np.eye(LAMPS) - basis @ basis.T
        residuals = outside @ (root[texel] * (values - model.values)[texel])
        normal += of_rig.T @ outside @ of_rig
        expected[block[texel]] += of_rig.T @ residuals
        left += float(residuals @ residuals)
    assert scores == pytest.approx(expected[:, free], rel=1e-4, abs=1e-5)
    variance = left / (weights.sum() - parameters * TEXELS)
    deviations = [rig.PRIOR_NEARNESS, *[rig.PRIOR_AMBIENT] * 3, *[rig.PRIOR_GAIN] * LAMPS]
    prior = variance / np.array(deviations) ** 2
    normal += np.diag(prior)
    normal[4:, 4:] += np.abs(np.diag(normal)[4:]).mean()
    assert inverse == pytest.approx(np.linalg.inv(normal[np.ix_(free, free)]), rel=1e-3, abs=1e-5)
    state = np.array([before.nearness, *before.ambient, *before.log_gains])
    state[free] += np.clip((inverse @ (expected.sum(axis=0) - prior * state)[free]), -0.3, 0.3)
    assert after.nearness == pytest.approx(np.clip(state[0], 0.0, rig.MAX_NEARNESS), abs=1e-4)
    assert after.ambient == pytest.approx(state[1:4], abs=1e-4)
    assert after.log_gains == pytest.approx(state[4:] - state[4:].mean(), abs=1e-4)


def test_weights_are_those_of_the_median_of_usable_residuals() -> None:
    random = np.random.default_rng(7)
    residuals = random.standard_normal((40, LAMPS))
    usable = random.random(residuals.shape) < np.linspace(0.0, 1.0, 40)[:, None]
    usable[0], residuals[1] = False, 0.0
    sample = Sample(residuals, usable, np.zeros((40, 2)), np.ones(40), np.zeros(40, np.int64))
    expected = np.zeros_like(residuals)
    for texel, (left, seen) in enumerate(zip(residuals, usable, strict=True)):
        deviation = max(1.4826 * float(np.median(np.abs(left[seen]))), 2e-3) if seen.any() else 2e-3
        off = left / (deviation * np.where(left < 0.0, rig.BELOW, rig.ABOVE))
        expected[texel] = np.where(seen & (np.abs(off) < 1.0), (1.0 - off**2) ** 2, 0.0)
    assert rig._biweights(sample, residuals) == pytest.approx(expected, rel=1e-12, abs=1e-15)


def test_residuals_that_are_held_out_are_those_of_fits_of_the_others() -> None:
    """With equal weights, as those of a fit change with the photograph."""
    random = np.random.default_rng(9)
    values, tangent = random.random((TEXELS, LAMPS)), random.standard_normal((TEXELS, LAMPS, 3))
    sample = Sample(values, values > -1.0, random.random((TEXELS, 2)), np.ones(TEXELS), np.zeros(TEXELS, np.int64))
    solved = np.stack([np.linalg.lstsq(each, value)[0] for each, value in zip(tangent, values, strict=True)])
    shown = np.einsum("tni,ti->tn", tangent, solved)
    model, ones = Model(shown, tangent, shown, shown, solved), np.ones(values.shape)
    found = rig.measure_held_out(sample, np.eye(3), Rig.plain(LAMPS), found=Fit(Rig.plain(LAMPS), model, ones, ones))
    for texel in range(TEXELS):
        for out in range(LAMPS):
            others = np.arange(LAMPS) != out
            alone = np.linalg.lstsq(tangent[texel, others], values[texel, others])[0]
            assert found[texel, out] == pytest.approx(values[texel, out] - tangent[texel, out] @ alone, rel=1e-4)
