"""The diffuse part of Gaussian transport: gains and albedos against quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import surface_direction
from engine.transport.baking.diffuse_specular import DiffusePart
from engine.transport.gaussian.diffuse import even_albedo, mean_gain
from engine.transport.gaussian.samples import material_of


def test_the_mean_gain_is_that_over_all_views() -> None:
    grazing = DiffusePart((0.5, 0.5, 0.5), grazing=True)
    exact = quad(lambda cosine: 2.0 * float(grazing.gain(np.array([cosine]))[0]) * cosine, 0.0, 1.0)[0]
    assert mean_gain(grazing) == pytest.approx(exact, rel=1e-9)
    assert mean_gain(DiffusePart((0.5, 0.5, 0.5))) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "ashikhmin-shirley:kd=0.6/0.3/0.1,ks=0.05,nu=10,nv=10",
        "ggx:kd=0.5,alpha=0.3,f0=0.04",
        "ggx:kd=0,alpha=0.4,f0=0.8",
    ],
)
def test_the_albedo_is_the_share_of_even_light_that_is_sent_back(text: str) -> None:
    """Against the sum over a grid of both directions; 256 drawn directions for each of 16 views are good for 2 %."""
    brdf, steps = brdf_from_text(text), 64
    theta = np.arcsin(np.sqrt((np.arange(steps) + 0.5) / steps))
    wi = surface_direction(theta[:, None], (np.arange(2 * steps) + 0.5) * np.pi / steps).reshape(-1, 3)
    exact = np.pi * np.mean([brdf.f(wi, wo[None]).mean(axis=0) for wo in surface_direction(theta)], axis=0)
    assert even_albedo(material_of(brdf)) == pytest.approx(exact, rel=0.02)
