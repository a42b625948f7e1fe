"""One positive term: exact where one is enough, and near the best one elsewhere."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.factor.brdf_matrix import brdf_matrix
from engine.factor.errors import reference
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.normalised import NORMS, normalise, whole
from engine.factor.normalised import _term as term_of
from engine.factor.separable import separate


class Product:
    """g(wo) h(wi): one term says it all."""

    isotropic = False
    reciprocal = False
    energy_conserving = False

    def f(self, wi: Any, wo: Any) -> np.ndarray:
        wi, wo = np.broadcast_arrays(np.asarray(wi, float), np.asarray(wo, float))
        value = (1.0 + wi[..., 0] ** 2 + 0.5 * wi[..., 1]) * (2.0 + wo[..., 0] - wo[..., 1])
        return value[..., None] * (1.0, 0.5, 0.2)


@pytest.mark.parametrize("text", ["lafortune:preset=blue-paint", "ashikhmin-shirley"])
def test_the_whole_matrix_is_put_together_from_its_sectors(text: str) -> None:
    brdf, hemisphere_map = brdf_from_text(text), HemisphereMap("orthographic", 8)
    matrix = drain(brdf_matrix(brdf, hemisphere_map, "in-out"))
    wanted = brdf.f(hemisphere_map.directions[None], hemisphere_map.directions[:, None])
    for channel in range(3):
        assert np.abs(whole(matrix, channel) - wanted[..., channel]).max() <= 1e-13 * wanted.max()


def test_a_product_is_found_exactly() -> None:
    hemisphere_map = HemisphereMap("parabolic", 8)
    brdf = Product()
    factors = drain(normalise(brdf, hemisphere_map, "in-out", reference(brdf, 1000)))
    wi, wo = hemisphere_map.directions, hemisphere_map.directions[::-1]
    wanted = brdf.f(wi, wo)
    assert np.abs(factors.f(wi, wo) - wanted).max() <= 1e-6 * wanted.max()
    assert (factors.terms, factors.negative_energy(wi, wo)) == (1, 0.0)


@pytest.mark.parametrize("form", ["in-out", "half-diff"])
def test_it_is_positive_and_not_far_from_the_best_term(form: Any) -> None:
    brdf, hemisphere_map = brdf_from_text("ggx:alpha=0.3,kd=0.1"), HemisphereMap("parabolic", 20)
    pairs = reference(brdf, 20_000)
    factors = drain(normalise(brdf, hemisphere_map, form, pairs))
    best = drain(separate(brdf, hemisphere_map, 1, method="svd", parametrisation=form, reference=pairs)).factors
    assert min(factors.first.min(), factors.second.min()) >= 0.0
    assert pairs.rms(factors)[0] <= 1.5 * pairs.rms(best)[0]


@pytest.mark.parametrize("norm", NORMS)
def test_one_number_fits_the_product_by_least_squares(norm: float) -> None:
    """The residual is orthogonal to the product, in the norm of the weights."""
    rng = np.random.default_rng(0)
    values, rows, columns = rng.random((9, 9)) ** 2, rng.random(9) + 0.1, rng.random(9) + 0.1
    first, second = term_of(values, rows, columns, norm)
    weight = rows[:, None] ** 2 * columns**2
    product = np.outer(first, second)
    assert abs((weight * product * (values - product)).sum()) <= 1e-13 * (weight * product * values).sum()


def test_black_is_black() -> None:
    brdf = brdf_from_text("lambert:albedo=0")
    factors = drain(normalise(brdf, HemisphereMap("polar", 4), "in-out", reference(brdf, 100)))
    assert not factors.f((0.0, 0.0, 1.0), (0.0, 0.0, 1.0)).any()
