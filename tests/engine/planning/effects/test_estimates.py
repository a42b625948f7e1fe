"""Estimates of effects against the measured error of leaving them out: at least 0.83 times, at most 3 times."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.planning.effects.estimates import (
    EFFECTS,
    Estimate,
    Scenery,
    estimates,
    scenery,
    spatially_varying_gloss,
    sun_split,
)
from engine.planning.effects.radiance import radiances
from engine.planning.effects.relative_error import relative_error
from engine.planning.effects.sample import sample
from engine.planning.effects.simplified import Unbrushed, WithoutRetro, WithoutRise, lambertian
from tests.engine.planning.brute_force import (
    bowl,
    brute_force,
    compute_bounced_share,
    gradient_sky,
    lamp_sky,
    sphere,
    spheres,
    sunny_sky,
)

#: Bounds of an estimate over the measured error.
MINIMUM, MAXIMUM = 0.83, 3.0

Place = Callable[[], Mesh]
Sky = Callable[[], EnvironmentMap]

#: Name, mesh, light, BRDF, and the effects that are measured there.
SCENES: tuple[tuple[str, Place, Sky, str, tuple[str, ...]], ...] = (
    ("bowl, gradient", bowl, gradient_sky, "lambert:albedo=0.5", ("self-shadowing",)),
    ("bowl, lamp", bowl, lamp_sky, "lambert:albedo=0.8", ("self-shadowing", "interreflection")),
    ("shallow bowl", lambda: bowl(0.25), gradient_sky, "lambert:albedo=0.3", ("self-shadowing",)),
    ("deep bowl", lambda: bowl(0.7), gradient_sky, "lambert:albedo=0.2", ("self-shadowing", "interreflection")),
    ("balls", lambda: spheres(2.2), lamp_sky, "ggx:kd=0.3,alpha=0.3,f0=0.04", ("self-shadowing", "glossy", "fresnel")),
    ("balls, diffuse", lambda: spheres(2.5), gradient_sky, "lambert:albedo=0.7", ("self-shadowing", "interreflection")),
    ("ball, metal", sphere, lamp_sky, "ggx:kd=0,alpha=0.2,f0=1", ("glossy",)),
    ("ball, faint gloss", sphere, gradient_sky, "phong:kd=0.5,ks=0.02,exponent=20", ("glossy",)),
    ("ball, dust", sphere, lamp_sky, "oren-nayar", ("glossy", "retro-reflection", "fresnel")),
    ("ball, dust, sun", sphere, lambda: sunny_sky(3e3), "oren-nayar", ("glossy", "retro-reflection")),
    ("ball, brushed", sphere, lamp_sky, "ward:alpha_x=0.1,alpha_y=0.4", ("anisotropy", "glossy")),
    ("bowl, brushed", lambda: bowl(0.4), lamp_sky, "ward:alpha_x=0.1,alpha_y=0.4", ("anisotropy",)),
    ("ball, nearly even", sphere, lamp_sky, "ward:alpha_x=0.28,alpha_y=0.32", ("anisotropy",)),
    ("bowl, paint", bowl, lamp_sky, "ggx:kd=0.5,alpha=0.4,f0=0.04", ("self-shadowing", "glossy", "fresnel")),
)


def look_at(mesh: Mesh, sky: EnvironmentMap, text: str) -> Scenery:
    return scenery(mesh, brdf_from_text(text), sky)


#: Every effect once; the other scenes take --long.
ORDINARY = ("bowl, lamp", "ball, dust", "bowl, brushed")


@pytest.mark.parametrize(
    ("place", "sky", "text", "effects"),
    [pytest.param(*row[1:], id=row[0], marks=[] if row[0] in ORDINARY else [pytest.mark.long]) for row in SCENES],
)
def test_T6_estimates_are_what_leaving_out_costs(place: Place, sky: Sky, text: str, effects: tuple[str, ...]) -> None:
    mesh, light, brdf = place(), sky(), brdf_from_text(text)
    found = estimates(look_at(mesh, light, text))
    real = brute_force(mesh, light)
    full = real.radiance(brdf.f)
    without = {
        "glossy": lambda: real.radiance(lambertian(cast(Any, brdf)).f),
        "anisotropy": lambda: real.radiance(Unbrushed(brdf).f),
        "fresnel": lambda: real.radiance(WithoutRise(brdf).f),
        "retro-reflection": lambda: real.radiance(WithoutRetro(brdf).f),
        "self-shadowing": lambda: real.radiance(brdf.f, shadows=False),
    }
    for effect in effects:
        if effect == "interreflection":
            measured = compute_bounced_share(mesh, brdf, light)
        else:
            measured = real.error(without[effect](), full)[0]
        assert measured > 0.0
        assert MINIMUM <= found[effect].error_rel / measured <= MAXIMUM, (
            f"{effect}: {found[effect].error_rel} {measured}"
        )


def test_T6_every_row_states_its_number() -> None:
    found = estimates(look_at(bowl(), lamp_sky(), "ggx:kd=0.5,alpha=0.4,f0=0.04"))
    assert tuple(found) == EFFECTS
    assert all(any(letter.isdigit() for letter in each.text) for each in found.values() if each.error_rel > 0.0)


def test_T1_what_is_not_there_is_exactly_nothing() -> None:
    found = estimates(look_at(sphere(), gradient_sky(), "lambert:albedo=0.5"))
    zero = {name for name, each in found.items() if each.error_rel == 0.0}
    assert zero == set(EFFECTS) - {"all-frequency-light"}
    assert found["all-frequency-light"].error_rel < 0.01


def test_T3_a_sun_is_reported_and_a_sky_has_none() -> None:
    assert sun_split(look_at(sphere(), sunny_sky(1.0), "lambert:albedo=0.5")).error_rel == 0.0
    found = sun_split(look_at(sphere(), sunny_sky(1e5), "ggx:kd=0.1,alpha=0.1,f0=0.5"))
    assert found.error_rel > 0.01
    assert "bright source" in found.text


def test_T4_the_isotropic_path_is_the_general_one() -> None:
    """A BRDF that is isotropic has the same radiance whether or not it says so."""
    some = sample(bowl(), lamp_sky(), points=16)
    round_ = brdf_from_text("ggx:kd=0.2,alpha=0.3,f0=0.5")
    brushed = brdf_from_text("ggx:kd=0.2,alpha_x=0.3,alpha_y=0.3,f0=0.5")
    assert (round_.isotropic, brushed.isotropic) == (True, False)
    one, other = radiances(some, round_), radiances(some, brushed)
    np.testing.assert_allclose(other.full, one.full, rtol=1e-12, atol=1e-12)
    assert other.unbrushed is not None
    rows = slice(None, None, 3)
    np.testing.assert_allclose(other.unbrushed[rows], one.full[rows], rtol=1e-12, atol=1e-12)


def test_the_margin_grows_with_what_is_not_known() -> None:
    shares = [np.ones((64, 2))] * 2
    wanted = np.ones((64, 2, 3))
    even = relative_error(1.1 * wanted, wanted, shares)
    lone = wanted.copy()
    lone[5] *= 1.8
    assert even == pytest.approx(0.12)
    assert relative_error(lone, wanted, shares) == pytest.approx(
        2.0**0.5 * relative_error(lone, wanted, shares, margin=False)
    )
    assert relative_error(wanted, wanted, shares) == 0.0
    assert relative_error(0.0 * wanted, 0.0 * wanted, shares) == 0.0


def test_a_second_look_finds_the_same() -> None:
    one, other = (estimates(look_at(bowl(), lamp_sky(), "lambert:albedo=0.5")) for _ in range(2))
    assert one == other
    assert all(isinstance(each, Estimate) for each in one.values())


def test_maps_of_others_are_not_said_to_be_one_brdf() -> None:
    even = SimpleNamespace(even=None)
    for pbr, words in ((object(), "Texels of the maps differ"), (None, "one BRDF")):
        scene = SimpleNamespace(radiances=even, varied=None, material=SimpleNamespace(pbr=pbr))
        assert words in spatially_varying_gloss(cast("Scenery", scene)).text
