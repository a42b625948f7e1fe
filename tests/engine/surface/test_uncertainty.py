"""Stated deviations against the errors on generated materials, and reflectances that photographs tell well."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from benchmarks.surface import errors_over_sigma, generate
from engine.core.steps import drain
from engine.surface.height import LENS, estimate_unresolved, lens_variance, shift_variance
from engine.surface.recover import recover
from engine.surface.reflectance import metallic_roughness


def test_texels_err_as_they_say() -> None:
    """Shares of texels of two dielectrics; the deviations of many materials are counted by the bench."""
    within = []
    for seed in (101, 104):
        made = generate(seed, size=20)
        used = np.arange(len(made.stack.sources))
        maps = drain(recover(made.stack, used, white=made.white, left_out=False)).maps
        ratio = errors_over_sigma(made, maps)
        within.append(
            [
                [np.mean(ratio[name] < limit) for limit in (1.0, 2.0)]
                for name in ("roughness", "f0", "height", "base_colour")
            ]
        )
    print(np.round(within, 2).tolist())
    for one, two in np.mean(within, axis=0):
        assert 0.5 < one < 0.95
        assert two > 0.8


def test_normals_of_few_photographs_err_as_they_say() -> None:
    """A highlight in one of so few photographs passes for a slope; of 24 such stacks 96 % of texels are covered."""
    covered = []
    for seed, count in ((105, 4), (105, 7), (107, 5), (108, 6)):
        made = generate(seed, size=20)
        used = np.linspace(0, len(made.stack.sources) - 1, count).astype(int)
        maps = drain(recover(made.stack, used, white=made.white, left_out=False)).maps
        covered.append(np.mean(errors_over_sigma(made, maps)["normal"] < 1.73))
    assert np.mean(covered) > 0.95
    assert min(covered) > 0.9


@pytest.mark.parametrize("f0", [0.025, 0.04, 0.08])
def test_a_dielectric_that_is_told_well_keeps_its_reflectance_and_deviation(f0: float) -> None:
    """Of ρ and F whose errors go together, as those of a diffuse part and a broad lobe do."""
    base, sigma = np.array([[0.5, 0.3, 0.1]]), (0.006, 0.004)
    variance = np.array([[sigma[0] ** 2, sigma[1] ** 2, -0.97 * sigma[0] * sigma[1]]])
    found = metallic_roughness(base * (1.0 - f0), np.full((1, 3), f0), variance)
    assert found.metallic[0] == 0.0
    assert found.f0[0] == pytest.approx(f0, rel=1e-6)
    assert found.f0_sigma[0] == pytest.approx(sigma[1], rel=0.01)
    np.testing.assert_allclose(found.base_colour, base, rtol=1e-6)
    # base = ρ / (1 − F), to first order in both
    moved = sigma[0] ** 2 - 2.0 * 0.97 * base * sigma[0] * sigma[1] + (base * sigma[1]) ** 2
    np.testing.assert_allclose(found.base_colour_sigma, np.sqrt(moved) / (1.0 - f0), rtol=0.02)


def test_a_metal_is_told_from_a_dielectric() -> None:
    base, variance = np.array([[0.9, 0.6, 0.3]]), np.array([[1e-4, 1e-4, 0.0]])
    found = metallic_roughness(np.zeros((1, 3)), base, variance)
    assert found.metallic[0] == pytest.approx(1.0)
    np.testing.assert_allclose(found.base_colour, base, rtol=1e-3)


def test_a_little_diffuse_light_makes_no_mixture_and_much_does() -> None:
    """ρ a deviation above that of a pure metal, and those of a half metal."""
    base, variance = np.array([[0.8, 0.5, 0.3]]), np.array([[4e-4, 4e-4, 0.0]])
    pure = metallic_roughness(np.full((1, 3), 0.02), base, variance)
    assert pure.metallic[0] == 1.0
    np.testing.assert_allclose(pure.base_colour, base, rtol=1e-6)
    specular = 0.5 * 0.04 + 0.5 * base
    half = metallic_roughness(0.5 * base * (1.0 - specular), specular, 0.01 * variance)
    assert half.metallic[0] == pytest.approx(0.5, abs=0.03)


def test_a_metal_is_found_where_no_texel_alone_tells_its_highlight() -> None:
    """Highlights of 4° under 18 lamps: a texel sees one of them at most, and is black otherwise."""
    made = generate(102, size=20)
    maps = drain(recover(made.stack, np.arange(18), white=made.white, left_out=False)).maps
    off = np.linalg.norm(np.cross(maps.normal, made.truth["normal"]), axis=-1)
    assert made.is_metal
    assert np.median(maps.metallic) > 0.9
    assert np.degrees(off.mean()) < 2.5
    assert np.abs(maps.base_colour - made.truth["specular"]).mean() < 0.2


def test_slopes_within_a_texel_spread_as_samples_of_them_do() -> None:
    """A cylinder's slope, of gradient g across and none along, sampled as the lens and a square texel weigh it."""
    gradient, random = 0.2, np.random.default_rng(1)
    place = LENS * random.standard_normal(200_000) + random.uniform(-0.5, 0.5, 200_000)
    drawn = float(2.0 * np.mean([np.var(gradient * place), 0.0]))  # of both axes
    slope = np.zeros((9, 9, 2), np.float32)
    slope[..., 0] = gradient * np.arange(9)
    found = estimate_unresolved(slope)
    np.testing.assert_allclose(found, np.full(found.shape, drawn), rtol=0.02)


def test_what_an_alignment_blurs_and_leaves_is_the_stated_variance() -> None:
    rows, columns = np.mgrid[:64, :64] / 11.0
    values = np.sin(2.0 * np.pi * (rows + 0.3 * columns)).astype(np.float32)
    inner = np.s_[8:-8, 8:-8]
    weights = [
        f * (1.0 - f) / 2.0 for f in np.arange(20) / 20.0
    ]  # of both neighbours, as bilinear ones blur on average
    blurred = np.mean([ndimage.convolve1d(values, [w, 1.0 - 2.0 * w, w], axis=0) for w in weights], axis=0)
    off = np.sqrt(np.mean((blurred - values)[inner] ** 2))  # down alone
    steep = np.sqrt(np.mean(lens_variance(values, 1.0 / 6.0)[inner])) / (1.0 + 0.3**2)
    assert steep == pytest.approx(off, rel=0.1)
    moved = [
        ndimage.shift(values, (0.2 * np.sin(turn), 0.2 * np.cos(turn)), order=3) for turn in np.arange(8) * np.pi / 4
    ]
    off = np.sqrt(np.mean((np.stack(moved) - values)[:, 8:-8, 8:-8] ** 2))
    assert np.sqrt(np.mean(shift_variance(values, 0.2)[inner])) == pytest.approx(off, rel=0.1)


def test_texels_are_converted_alike_alone_and_beside_others() -> None:
    """Of every kind, also those of which nothing is known, over the border between the parts of two threads."""
    random = np.random.default_rng(3)
    diffuse, specular = random.random((2, 700, 3)) ** 2
    variance = 10.0 ** random.uniform(-8.0, 0.0, (700, 3))
    variance[::7] = np.inf
    variance[3::7] = np.nan
    evidence = random.normal(0.0, 20.0, 700)
    together = metallic_roughness(diffuse, specular, variance, evidence)
    for texel in range(0, 700, 9):
        one = slice(texel, texel + 1)
        alone = metallic_roughness(diffuse[one], specular[one], variance[one], evidence[one])
        for name in ("base_colour", "metallic", "f0", "base_colour_sigma", "metallic_sigma", "f0_sigma"):
            np.testing.assert_array_equal(getattr(alone, name), getattr(together, name)[one])
            assert np.isfinite(getattr(alone, name)).all()
    assert 0.2 < (together.metallic > 0.0).mean() < 0.9
