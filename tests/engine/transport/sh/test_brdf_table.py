"""Tables of BRDFs in spherical harmonics: closed forms, brute-force integrals, symmetry, and the reported error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.diffuse import Lambert
from engine.brdf.readers.read import open_brdf
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.factor.hemisphere_map import HemisphereMap
from engine.transport.sh.basis import cosine_zonal, evaluate
from engine.transport.sh.brdf_table import GRAZING, BrdfTable, tabulate

ISOTROPIC = ("phong:exponent=20", "ggx:kd=0.5,alpha=0.3,f0=0.04", "ggx:kd=0,alpha=0.1,f0=1")
ANISOTROPIC = "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=100"


def table_of(text: str, order: int) -> BrdfTable:
    return drain(tabulate(brdf_from_text(text), order))


def views(count: int, least: float = 0.1) -> np.ndarray:
    wo = np.random.default_rng(3).normal(size=(count, 3))
    wo[:, 2] = np.abs(wo[:, 2]) + least
    return normalize(wo)


def brute(brdf: Any, order: int, wo: np.ndarray) -> np.ndarray:
    """(order², 3) by Gauss in cos θ and even steps in azimuth, 400 × 800 directions."""
    z, share = np.polynomial.legendre.leggauss(400)
    z, share = 0.5 + 0.5 * z, 0.5 * share
    phi = 2.0 * np.pi * np.arange(800) / 800
    across = np.sqrt(1.0 - z * z)[:, None]
    wi = np.stack(np.broadcast_arrays(across * np.cos(phi), across * np.sin(phi), z[:, None]), axis=-1).reshape(-1, 3)
    weight = np.repeat(share * z, 800) * 2.0 * np.pi / 800
    return np.asarray(evaluate(order, wi).T @ (brdf.f(wi, wo) * weight[:, None]))


def test_lamberts_table_is_its_closed_form_and_reads_like_the_sum_over_directions() -> None:
    table = table_of("lambert:albedo=0.2/0.5/0.8", 6)
    expected = np.zeros((36, 3))
    for degree, value in enumerate(cosine_zonal(6)):
        expected[degree * (degree + 1)] = value * np.array([0.2, 0.5, 0.8]) / np.pi
    assert np.abs(table.at(views(20)) - expected).max() < 1e-15
    assert table.diffuse
    assert table.error_rel == 0.0
    direct = brute(Lambert((0.2, 0.5, 0.8)), 6, np.array([0.0, 0.6, 0.8]))
    assert np.abs(direct - expected).max() < 2e-6


@pytest.mark.parametrize("order", [3, 5, 15])
def test_H10_constant_light_on_white_lambert_is_radiance_one(order: int) -> None:
    table = drain(tabulate(Lambert((1.0, 1.0, 1.0)), order))
    light = np.zeros((50, order**2, 3))
    light[:, 0] = np.sqrt(4.0 * np.pi)
    assert np.abs(table.radiance(light, views(50, GRAZING)) - 1.0).max() < 1e-6


@pytest.mark.parametrize(
    ("order", "text"),
    [
        *((5, text) for text in ISOTROPIC),
        *(pytest.param(15, text, marks=pytest.mark.long) for text in ISOTROPIC[:2]),
        (15, ISOTROPIC[2]),
    ],
)
def test_isotropic_tables_are_the_integral_at_every_azimuth(order: int, text: str) -> None:
    table = table_of(text, order)
    for wo in views(3):
        expected = brute(brdf_from_text(text), order, wo)
        error = np.linalg.norm(table.at(wo[None])[0] - expected) / np.linalg.norm(expected)
        assert error < max(3.0 * table.error_rel, 2e-3)


def test_anisotropic_tables_are_the_integral_in_every_quarter() -> None:
    table = table_of(ANISOTROPIC, 5)
    assert table.values.shape == (128, 128, 25, 3)
    for signs in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
        wo = normalize(np.array([0.3 * signs[0], 0.5 * signs[1], 0.6]))
        expected = brute(brdf_from_text(ANISOTROPIC), 5, wo)
        assert np.linalg.norm(table.at(wo[None])[0] - expected) / np.linalg.norm(expected) < 0.012


@dataclass(frozen=True)
class Leaning:
    """A BRDF that no mirror leaves as it is."""

    isotropic: bool = False
    reciprocal: bool = False
    energy_conserving: bool = True

    def f(self, wi: Any, wo: Any) -> np.ndarray:
        wi, wo = np.broadcast_arrays(wi, wo)
        up = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
        value = 0.2 + 0.1 * wi[..., 0] + 0.05 * wi[..., 1] * wo[..., 0]
        return np.repeat(np.where(up, value, 0.0)[..., None], 3, axis=-1)


def test_what_has_no_mirrors_is_worked_out_everywhere(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.transport.sh.brdf_table.MAP_SIZE", 16)
    table = drain(tabulate(Leaning(), 4))
    for wo in HemisphereMap("parabolic", 16).directions[[20, 70, 110, 160]]:
        expected = brute(Leaning(), 4, wo)
        assert (
            np.linalg.norm(table.at(wo[None])[0] - expected) / np.linalg.norm(expected) < 4.0 * table.error_rel < 0.05
        )


def test_radiance_is_the_product_of_table_and_light_and_nothing_comes_from_below() -> None:
    rng = np.random.default_rng(0)
    light = rng.normal(size=(40, 25, 3))
    wo = np.concatenate([views(39), [[0.0, 0.6, -0.8]]])
    for text in (ISOTROPIC[1], "lambert"):
        table = table_of(text, 5)
        assert np.abs(table.radiance(light, wo) - np.einsum("nic,nic->nc", table.at(wo), light)).max() < 1e-14
        assert not table.radiance(light, wo)[-1].any()


def test_the_mean_over_views_is_the_integral_of_the_table() -> None:
    table = table_of(ISOTROPIC[1], 4)
    z, share = np.polynomial.legendre.leggauss(200)
    phi = 2.0 * np.pi * np.arange(64) / 64
    z, share = 0.5 + 0.5 * z, 0.5 * share
    across = np.sqrt(1.0 - z * z)[:, None]
    wo = np.stack(np.broadcast_arrays(across * np.cos(phi), across * np.sin(phi), z[:, None]), axis=-1).reshape(-1, 3)
    expected = np.einsum("n,nic->ic", np.repeat(2.0 * share * z, 64) / 64, table.at(wo))
    assert np.abs(table.mean - expected).max() < 1e-4 * np.abs(expected).max()
    white = drain(tabulate(Lambert((1.0, 1.0, 1.0)), 4))
    assert np.abs(white.mean - white.values[0]).max() < 1e-15


def test_fewer_coefficients_are_those_of_a_lower_order() -> None:
    table = table_of(ISOTROPIC[0], 6)
    assert np.array_equal(table.reduce_order(4).at(views(5)), table.at(views(5))[:, :16])
    with pytest.raises(ValueError, match="no coefficients of order 7"):
        table.reduce_order(7)
    with pytest.raises(ValueError, match="does not fit"):
        table.reduce_order(4).radiance(np.zeros((1, 25, 3)), views(1))  # H12


@pytest.mark.parametrize("name", ["satin_rosaline", pytest.param("cc_ibiza_sunset", marks=pytest.mark.long)])
def test_measured_lobes_are_the_integral_down_to_the_horizon(shared_data: Callable[[str], Path], name: str) -> None:
    """A lone direction of light on the edge of a lobe's table must not outweigh all others."""
    brdf = open_brdf(str(shared_data(f"brdf/rgl/{name}_rgb.bsdf")))
    order, rows = 5, np.array([60, 180, 240])
    table = drain(tabulate(brdf, order))
    assert table.error_rel < 0.02
    for row in rows:
        cosine = (1.0 - (row / 255) ** 2) / (1.0 + (row / 255) ** 2)
        wanted = brute(brdf, order, np.array([np.sqrt(1.0 - cosine**2), 0.0, cosine]))
        assert np.linalg.norm(table.values[row] - wanted) <= 0.02 * np.linalg.norm(wanted)
