"""Separable factors of whole BRDFs: optimal, whatever the method, the map and the symmetry."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import dot, normalize
from engine.core.steps import drain
from engine.factor.brdf_matrix import brdf_matrix
from engine.factor.errors import reference, rms_cosine_weighted
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable import Separated, separate, texel_weights
from engine.factor.separable_factors import SeparableFactors

PAINT = "lafortune:preset=blue-paint"
BRUSHED = "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=100"


@dataclass(frozen=True)
class Skewed:
    """Neither reciprocal nor the same under any mirror."""

    isotropic = False
    reciprocal = False
    energy_conserving = False
    slope: float = 0.6

    def f(self, wi: Any, wo: Any) -> np.ndarray:
        wi, wo = np.broadcast_arrays(np.asarray(wi, float), np.asarray(wo, float))
        base = np.exp(3.0 * (wi[..., 0] * wo[..., 1] - wi[..., 1]) * self.slope + wo[..., 0])
        lit = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
        return np.where(lit[..., None], base[..., None] * (1.0, 0.5, 0.25) + dot(wi, wo)[..., None] ** 2, 0.0)


def separate_terms(brdf: Any, terms: int = 6, kind: Any = "orthographic", size: int = 12, **more: Any) -> Separated:
    brdf = brdf_from_text(brdf) if isinstance(brdf, str) else brdf
    return drain(separate(brdf, HemisphereMap(kind, size), terms, **{"weighting": "plain", **more}))


def whole(brdf: Any, hemisphere_map: HemisphereMap) -> np.ndarray:
    """(3, n, n): every entry of the matrix, by brute force."""
    return np.moveaxis(brdf.f(hemisphere_map.directions[None], hemisphere_map.directions[:, None]), -1, 0)


@pytest.mark.parametrize("text", [PAINT, BRUSHED, "oren-nayar", "skewed"])
@pytest.mark.parametrize("method", ["symmetric", "svd", "power"])
@pytest.mark.parametrize("kind", ["orthographic", "polar", "parabolic"])
@pytest.mark.parametrize("weighting", ["plain", "cosine"])
def test_W3_W6_the_factors_are_those_of_eckart_and_young(text: str, method: str, kind: Any, weighting: Any) -> None:
    brdf = Skewed() if text == "skewed" else brdf_from_text(text)
    hemisphere_map = HemisphereMap(kind, 12)
    if text == "skewed" and method == "symmetric":
        return
    found = separate_terms(brdf, 5, kind, 12, method=method, weighting=weighting)
    rows, columns = texel_weights(hemisphere_map, "in-out", weighting)
    matrix = whole(brdf, hemisphere_map) * rows[:, None] * columns
    factors = found.factors
    inside = np.broadcast_to(hemisphere_map.mask, (factors.terms, 12, 12))
    first, second = (
        side[:, -12:][inside].reshape(factors.terms, -1, 3).astype(float) for side in (factors.first, factors.second)
    )
    approximation = np.einsum("kac,kbc->cab", first * rows[:, None], second * columns[:, None])
    sigma = np.linalg.svd(matrix, compute_uv=False)
    best = np.sqrt((sigma[:, 5:] ** 2).sum())
    rounding = 1e-6 * np.linalg.norm(matrix) if factors.terms < 5 else 4e-7 * np.linalg.norm(matrix)
    assert np.linalg.norm(matrix - approximation) <= best * (1.0 + 1e-6) + rounding
    assert found.optimum_ratio <= 1.0 + 1e-6
    assert found.converged


def test_X3_the_asymmetry_is_measured_and_decides_the_method() -> None:
    found = separate_terms(PAINT)
    assert (found.method, found.factors.reciprocal) == ("symmetric", True)
    assert found.asymmetry <= 1e-12
    found = separate_terms(Skewed())
    assert (found.method, found.factors.reciprocal) == ("svd", False)
    matrix = whole(Skewed(), HemisphereMap("orthographic", 12))
    wanted = np.linalg.norm(matrix - matrix.transpose(0, 2, 1)) / np.linalg.norm(matrix)
    assert found.asymmetry == pytest.approx(wanted, rel=1e-12)
    with pytest.raises(ValueError, match="not symmetric"):
        separate_terms(Skewed(), method="symmetric")


def test_the_optimum_of_matrices_too_large_for_lapack_is_known_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the terms hold all but rounding, so that a difference of squares would say anything."""
    checked = [separate_terms(brdf, terms, size=16).optimum_ratio for brdf, terms in ((Skewed(), 3), (Skewed(), 24))]
    monkeypatch.setattr("engine.factor.separable.CHECKED", 0)
    found = [separate_terms(brdf, terms, size=16).optimum_ratio for brdf, terms in ((Skewed(), 3), (Skewed(), 24))]
    assert found == pytest.approx(checked, abs=1e-6)
    assert found == pytest.approx([1.0, 1.0], abs=1e-6)


def test_mirrors_are_found_and_save_three_quarters_of_the_rows() -> None:
    hemisphere_map = HemisphereMap("orthographic", 12)
    texels = len(hemisphere_map.directions)
    for brdf, parts in ((brdf_from_text(BRUSHED), 4), (Skewed(), 1)):
        matrix = drain(brdf_matrix(brdf, hemisphere_map, "in-out"))
        assert matrix.rows.shape == (3, texels // parts, texels)
        ones = np.ones(texels)
        everything = np.concatenate(
            [np.linalg.svd(sector.matrix, compute_uv=False) for sector in matrix.sectors(0, ones, ones)]
        )
        wanted = np.linalg.svd(whole(brdf, hemisphere_map)[0], compute_uv=False)
        assert np.sort(everything)[::-1] == pytest.approx(wanted, abs=1e-12 * wanted[0])


def test_W11_values_that_are_no_numbers_are_refused_with_their_directions() -> None:
    class Broken(Skewed):
        def f(self, wi: Any, wo: Any) -> np.ndarray:
            values = super().f(wi, wo)
            return np.where(np.broadcast_to(wi, values.shape)[..., 2:] < 0.35, np.nan, values)

    with pytest.raises(ValueError, match=r"light at [78]\d\.\d° and viewer at \d"):
        separate_terms(Broken())


def test_W14_light_and_view_maps_differ_by_sign_and_f_is_reciprocal_to_the_bit() -> None:
    factors = separate_terms(PAINT, 16).factors
    assert np.array_equal(np.abs(factors.first), np.abs(factors.second))
    assert (factors.first * factors.second < 0.0).any()
    pairs = reference(brdf_from_text(PAINT), 5000)
    assert np.array_equal(factors.f(pairs.wi, pairs.wo), factors.f(pairs.wo, pairs.wi))


def test_W15_negative_sums_become_0_and_are_counted() -> None:
    factors = separate_terms("phong:exponent=200,ks=0.5", 3, size=16).factors
    pairs = reference(brdf_from_text(PAINT), 20_000)
    signed = factors.sum_terms(pairs.wi, pairs.wo)
    assert signed.min() < 0.0
    assert np.array_equal(factors.f(pairs.wi, pairs.wo), np.maximum(signed, 0.0))
    energy = signed * pairs.wi[:, 2:]
    assert factors.negative_energy(pairs.wi, pairs.wo) == pytest.approx(
        -energy[energy < 0].sum() / energy[energy > 0].sum()
    )


def test_W16_the_same_seed_gives_the_same_bits() -> None:
    for method in ("symmetric", "svd", "power"):
        one, other = (separate_terms(BRUSHED, size=20, method=method).factors for _ in range(2))
        assert np.array_equal(one.first, other.first)
        assert np.array_equal(one.second, other.second)


def test_W17_the_error_falls_with_the_terms_and_32_texels_are_nearly_as_good_as_64() -> None:
    brdf = brdf_from_text("phong:kd=0.3,ks=0.3,exponent=8")
    pairs = reference(brdf)
    error_lists = []
    for size in (32, 64):
        found = separate_terms(brdf, 8, size=size, weighting="cosine").factors
        error_lists.append([pairs.rms(found.truncate(terms))[0] for terms in range(1, 9)])
    for term_errors in error_lists:
        assert all(after <= before * 1.01 for before, after in itertools.pairwise(term_errors))
    assert error_lists[1][3] == pytest.approx(error_lists[0][3], rel=0.05)


def test_the_rim_takes_the_plain_norm_and_the_automatic_weighting_sees_it() -> None:
    brdf = brdf_from_text(BRUSHED)
    pairs = reference(brdf)
    found = {
        weighting: separate_terms(brdf, 6, "parabolic", 20, weighting=weighting, reference=pairs)
        for weighting in ("plain", "cosine", "auto")
    }
    errors = {weighting: pairs.rms(result.factors)[0] for weighting, result in found.items()}
    assert errors["cosine"] < 0.9 * errors["plain"]
    assert (found["auto"].weighting, errors["auto"]) == ("cosine", errors["cosine"])
    with pytest.raises(ValueError, match="pairs"):
        separate_terms(brdf, weighting="auto")


@pytest.mark.parametrize("kind", ["orthographic", "polar", "parabolic"])
def test_half_and_difference_vectors_serve_narrow_highlights(kind: Any) -> None:
    """Half and difference vectors need few terms for highlights that need many in incident and outgoing directions."""
    brdf = brdf_from_text("ggx:alpha=0.2,kd=0.2")
    pairs = reference(brdf, 20_000)
    errors = [
        pairs.rms(separate_terms(brdf, 4, kind, 24, parametrisation=form, weighting="cosine").factors)[0]
        for form in ("in-out", "half-diff")
    ]
    assert errors[1] < (0.9 if kind == "orthographic" else 0.5) * errors[0]
    with pytest.raises(ValueError, match="half"):
        separate_terms(brdf, parametrisation="half-diff", method="symmetric")


def test_half_difference_factors_agree_with_the_matrix_at_texel_centres() -> None:
    """All terms: what is looked up at the centres of two textures is the BRDF there."""
    from engine.brdf.half_difference import classical_frame

    brdf = brdf_from_text(BRUSHED)
    hemisphere_map = HemisphereMap("orthographic", 6)
    factors = separate_terms(brdf, 32, size=6, parametrisation="half-diff").factors
    half, difference = np.repeat(hemisphere_map.directions, 32, axis=0), np.tile(hemisphere_map.directions, (32, 1))
    x_axis, y_axis = classical_frame(half)
    aside = difference[:, :1] * x_axis + difference[:, 1:2] * y_axis
    wi, wo = difference[:, 2:] * half + aside, difference[:, 2:] * half - aside
    lit = (wi[:, 2] > 0.02) & (wo[:, 2] > 0.02)
    wanted = brdf.f(wi, wo)[lit]
    assert np.abs(factors.f(wi, wo)[lit] - wanted).max() <= 1e-5 * wanted.max()


def test_grey_brdf_is_factored_once_and_black_channels_stay_black() -> None:
    grey = separate_terms("phong:ks=0.3,kd=0.1").factors
    assert np.array_equal(grey.first[..., 0], grey.first[..., 2])
    black = separate_terms("lambert:albedo=0.5/0/0").factors
    assert black.terms == 1
    assert not black.first[..., 1:].any()
    assert separate_terms("lambert:albedo=0").factors.terms == 1


def test_fewer_terms_are_the_first_ones() -> None:
    factors = separate_terms(PAINT, 5).factors
    fewer = factors.truncate(2)
    assert np.array_equal(fewer.first, factors.first[:2])
    assert fewer.size_bytes == 2 * 2 * 12 * 12 * 3 * 4
    assert rms_cosine_weighted(brdf_from_text(PAINT), fewer) > rms_cosine_weighted(brdf_from_text(PAINT), factors)
    for terms in (0, 6):
        with pytest.raises(ValueError, match="terms"):
            factors.truncate(terms)


def test_values_are_0_at_and_below_the_horizon_and_shapes_broadcast() -> None:
    factors = separate_terms(PAINT, 2).factors
    up, level = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
    assert factors.f(up, level).tolist() == [0.0, 0.0, 0.0]
    assert factors.f(-up, up).tolist() == [0.0, 0.0, 0.0]
    assert factors.f(np.tile(up, (2, 4, 1)), up).shape == (2, 4, 3)


def test_textures_that_do_not_fit_are_refused() -> None:
    factors = separate_terms(PAINT, 2).factors
    assert isinstance(factors, SeparableFactors)
    for wrong in (
        {"hemisphere_map": HemisphereMap("orthographic", 11)},
        {"first": factors.first[:1]},
        {"first": np.full_like(factors.first, np.nan)},
        {"parametrisation": "square"},
    ):
        with pytest.raises(ValueError, match=r"textures|parametrisation"):
            replace(factors, **wrong)


@pytest.mark.parametrize("weighting", ["plain", "cosine"])
def test_W2_a_constant_has_one_term_whatever_its_sectors_round_to(weighting: Any) -> None:
    found = drain(
        separate(brdf_from_text("lambert:albedo=0.5"), HemisphereMap("orthographic", 24), 8, weighting=weighting)
    )
    assert found.factors.terms == 1
    assert found.condition_number == 1.0


@pytest.mark.parametrize("parametrisation", ["in-out", "half-diff"])
@pytest.mark.parametrize("text", [BRUSHED, PAINT, "ashikhmin-shirley:kd=0.5,ks=0.75,nu=10,nv=100"])
def test_nonnegative_factors_are_above_zero_everywhere(text: str, parametrisation: Any) -> None:
    """The matrix in one piece is that of the mirrored sectors: the error that the solver states is the brute one."""
    brdf, hemisphere_map = brdf_from_text(text), HemisphereMap("orthographic", 12)
    found = separate_terms(brdf, 4, method="nonnegative", weighting="cosine", parametrisation=parametrisation)
    inside = np.broadcast_to(hemisphere_map.mask, found.factors.first.shape[:3])
    assert (found.factors.first[inside] > 0.0).all()
    assert (found.factors.second[inside] > 0.0).all()
    assert found.optimum_ratio >= 1.0 - 1e-6
    wi, wo = normalize(np.random.default_rng(1).normal(size=(2, 500, 3)))
    wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
    assert (found.factors.sum_terms(wi, wo) > 0.0).all()
    if parametrisation == "in-out":
        rows, columns = texel_weights(hemisphere_map, "in-out", "cosine")
        matrix = whole(brdf, hemisphere_map) * rows[:, None] * columns
        first, second = (side[inside].reshape(4, -1, 3) for side in (found.factors.first, found.factors.second))
        ours = np.einsum("kac,kbc->cab", first * rows[:, None], second * columns[:, None])
        sigma = np.linalg.svd(matrix, compute_uv=False)
        best = np.sqrt((sigma[:, 4:] ** 2).sum())
        assert np.linalg.norm(matrix - ours) == pytest.approx(found.optimum_ratio * best, rel=1e-3)
