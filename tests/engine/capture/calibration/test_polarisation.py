"""Gain and leak of pairs under polarisers, from photographs of materials that are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from engine.capture.calibration.polarisation import PairTexels, separate, texel_grid
from engine.capture.calibration.separation import Separation, gain_text
from engine.core.errors import UsageError
from tests.engine.capture.calibration import polarised
from tests.engine.capture.calibration.polarised import Array, Pairs, Photographs, photograph


def separation_of(found: Photographs, gain: float | None = None) -> Separation:
    rows, columns, block = texel_grid(*found.parallel.shape[1:3])
    parallel, crossed = (each[:, rows, columns].swapaxes(0, 1) for each in (found.parallel, found.crossed))
    usable = np.maximum(parallel, crossed).max(axis=-1) < 1.0
    return separate(PairTexels(parallel, crossed, usable, found.directions[:, None], block), gain)


@pytest.mark.parametrize(
    "pairs",
    [
        Pairs(size=48, leak=0.01, gain=(0.5, 0.43, 0.38)),
        pytest.param(Pairs(size=48, roughness=0.7, lamps=12), marks=pytest.mark.long),
        pytest.param(Pairs(size=48, roughness=0.3, spread=0.1, noise=0.01), marks=pytest.mark.long),
        Pairs(size=48, f0=0.08, roughness=0.5, metallic=0.1),
    ],
)
def test_gain_and_leak_are_those_of_the_filters(pairs: Pairs) -> None:
    found = separation_of(photograph(pairs))
    error = found.gain / np.array(pairs.gain) - 1.0
    assert np.abs(error).max() < 0.006
    assert (np.abs(error) < 2.0 * found.gain_sigma / found.gain).all()
    assert found.leak == pytest.approx(pairs.leak, abs=0.001)
    assert "95 % interval" in gain_text(found.as_json())


def test_photographs_without_a_diffuse_part_do_not_tell_the_gain_and_a_stated_one_is_used() -> None:
    metal = photograph(Pairs(size=48, metallic=1.0, leak=0.01))
    with pytest.raises(UsageError, match="known to"):
        separation_of(metal)
    stated = separation_of(metal, 0.43)
    assert stated.gain.tolist() == [0.43] * 3
    assert stated.stated


def test_lobes_of_another_shape_are_no_diffuse_light(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two lobes, as of wax on stone, err by up to 6 % where their difference to one lobe passes for diffuse light."""
    one = polarised._reflect

    def two(normals: Array, towards: Array, base: Array, roughness: Array, pairs: Pairs) -> tuple[Array, Array]:
        diffuse, narrow = one(normals, towards, base, roughness, pairs)
        return diffuse, 0.6 * narrow + 0.4 * one(normals, towards, base, 1.9 * roughness, pairs)[1]

    monkeypatch.setattr(polarised, "_reflect", two)
    found = separation_of(photograph(Pairs(size=48, roughness=0.45)))
    np.testing.assert_allclose(found.gain, 0.43, rtol=0.003)


def test_a_specular_part_of_the_colour_of_the_diffuse_one_is_refused() -> None:
    with pytest.raises(UsageError, match="known to"):
        separation_of(photograph(Pairs(size=48, metallic=0.5)))


def test_parts_of_a_pair_come_back() -> None:
    random = np.random.default_rng(3)
    diffuse, specular = random.random((2, 5, 7, 3))
    gain, leak = np.array([0.5, 0.4, 0.3]), 0.02
    crossed = gain * (diffuse + 2.0 * leak * specular)
    found = Separation(gain, np.zeros(3), leak)
    whole, part = found.apply((diffuse + 2.0 * specular).astype(np.float32), crossed.astype(np.float32))
    np.testing.assert_allclose(part, diffuse, atol=1e-6)
    np.testing.assert_allclose(whole, diffuse + specular, atol=1e-6)
    assert replace(found, leak=0.0).apply(whole, part)[1].min() >= 0.0
