"""Every model against its printed definition in 50 digits.

The definitions are those of the table of models, written down as they are printed. A direction in float64 is known to
its last place only, and a sharp lobe multiplies that; so the bound is the arithmetic's own error plus what the printed
value changes when each component changes by three units in its last place.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text, model_name
from engine.brdf.models.multiple_scattering import SEPARABLE
from engine.core.directions import normalize
from engine.core.params import parameters
from tests.engine.brdf.all_models import TEXTS, pairs

Number = Any
Direction = tuple[Number, Number, Number]

U = 2.0**-53


class Frame:
    """The quantities of which definitions are made, for directions normalised in 50 digits."""

    def __init__(self, wi: Direction, wo: Direction) -> None:
        self.i, self.o = unit(wi), unit(wo)
        self.sum = tuple(a + b for a, b in zip(self.i, self.o, strict=True))
        self.h = unit(self.sum)
        self.hi = dot(self.h, self.i)
        self.nl, self.nv, self.nh = self.i[2], self.o[2], self.h[2]


def unit(w: Direction) -> Direction:
    length = mpmath.sqrt(dot(w, w))
    return (w[0] / length, w[1] / length, w[2] / length)


def dot(a: Direction, b: Direction) -> Number:
    return sum(p * q for p, q in zip(a, b, strict=True))


def power(base: Number, exponent: Number) -> tuple[Number, Number]:
    """max(0, base)^exponent and what its relative error is measured in: |exponent ln base|.

    A base that is small is known no better than 1 − base, to which exponent / base adds; the power is tiny there.
    """
    if exponent == 0:
        return mpmath.mpf(1), mpmath.mpf(0)
    if base <= 0:
        return mpmath.mpf(0), mpmath.mpf(0)
    return base**exponent, exponent * (abs(mpmath.log(base)) + max(1 / base - 2, 0))


def schlick(f0: Number, cosine: Number) -> Number:
    return f0 + (1 - f0) * (1 - cosine) ** 5


def lambert(w: Frame, albedo: Number) -> tuple[Number, Number]:
    return albedo / mpmath.pi, 0


def oren_nayar(w: Frame, albedo: Number, sigma_deg: Number) -> tuple[Number, Number]:
    s2 = mpmath.radians(sigma_deg) ** 2
    a, b = 1 - 0.5 * s2 / (s2 + mpmath.mpf("0.33")), mpmath.mpf("0.45") * s2 / (s2 + mpmath.mpf("0.09"))
    ti, to = mpmath.acos(w.nl), mpmath.acos(w.nv)
    dphi = mpmath.atan2(w.i[1], w.i[0]) - mpmath.atan2(w.o[1], w.o[0])
    term = max(0, mpmath.cos(dphi)) * mpmath.sin(max(ti, to)) * mpmath.tan(min(ti, to))
    return albedo / mpmath.pi * (a + b * term), 0


def phong(w: Frame, kd: Number, ks: Number, exponent: Number) -> tuple[Number, Number]:
    lobe, steps = power(-w.i[0] * w.o[0] - w.i[1] * w.o[1] + w.nl * w.nv, exponent)
    return kd / mpmath.pi + ks * (exponent + 2) / (2 * mpmath.pi) * lobe, steps


def blinn_phong(w: Frame, kd: Number, ks: Number, exponent: Number) -> tuple[Number, Number]:
    n = exponent
    lobe, steps = power(w.nh, n)
    return kd / mpmath.pi + ks * (n + 2) * (n + 4) / (8 * mpmath.pi * (mpmath.mpf(2) ** (-n / 2) + n)) * lobe, steps


def lafortune(w: Frame, kd: Number, ks: Number, cxy: Number, cz: Number, exponent: Number) -> tuple[Number, Number]:
    m = max(abs(cxy), abs(cz))
    lobe, steps = power((cxy * (w.i[0] * w.o[0] + w.i[1] * w.o[1]) + cz * w.nl * w.nv) / m, exponent)
    return kd / mpmath.pi + ks * (exponent + 2) / (2 * mpmath.pi) * lobe, steps


def three_lobes(w: Frame, kd: Number, **lobes: Number) -> tuple[Number, Number]:
    value, most = kd / mpmath.pi, mpmath.mpf(0)
    for k in (1, 2, 3):
        cxy, cz = lobes[f"cxy{k}"], lobes[f"cz{k}"]
        base = cxy * (w.i[0] * w.o[0] + w.i[1] * w.o[1]) + cz * w.nl * w.nv
        lobe, _ = power(base, lobes[f"exponent{k}"])
        _, steps = power(base / max(abs(cxy), abs(cz)), lobes[f"exponent{k}"])
        value, most = value + lobe, max(most, steps)
    return value, most + 100


def ward(w: Frame, kd: Number, ks: Number, alpha_x: Number, alpha_y: Number) -> tuple[Number, Number]:
    x, y, z = w.sum
    steps = ((x / alpha_x) ** 2 + (y / alpha_y) ** 2) / z**2
    lobe = mpmath.exp(-steps) * dot(w.sum, w.sum) / z**4 / (mpmath.pi * alpha_x * alpha_y)
    return kd / mpmath.pi + ks * lobe, steps


def ashikhmin_shirley(w: Frame, kd: Number, ks: Number, nu: Number, nv: Number) -> tuple[Number, Number]:
    across = 1 - w.nh**2
    lobe, steps = power(w.nh, (nu * w.h[0] ** 2 + nv * w.h[1] ** 2) / across if across > 1e-40 else mpmath.mpf(0))
    lobe *= mpmath.sqrt((nu + 1) * (nv + 1)) / (8 * mpmath.pi) / (w.hi * max(w.nl, w.nv))
    under = 28 * kd / (23 * mpmath.pi) * (1 - ks) * (1 - (1 - w.nl / 2) ** 5) * (1 - (1 - w.nv / 2) ** 5)
    return lobe * schlick(ks, w.hi) + under, steps


def cook_torrance(w: Frame, kd: Number, ks: Number, m: Number, f0: Number) -> tuple[Number, Number]:
    tangent2 = (1 - w.nh**2) / w.nh**2
    distribution = mpmath.exp(-tangent2 / m**2) / (mpmath.pi * m**2 * w.nh**4)
    grooves = min(mpmath.mpf(1), 2 * w.nh * w.nv / w.hi, 2 * w.nh * w.nl / w.hi)
    lobe = schlick(f0, w.hi) * distribution * grooves / (4 * w.nl * w.nv)
    return kd / mpmath.pi + ks * lobe, tangent2 / m**2


def ggx(w: Frame, kd: Number, f0: Number, alpha_x: Number, alpha_y: Number) -> tuple[Number, Number]:
    def smith(d: Direction) -> Number:
        return (mpmath.sqrt(1 + ((alpha_x * d[0]) ** 2 + (alpha_y * d[1]) ** 2) / d[2] ** 2) - 1) / 2

    width = (w.h[0] / alpha_x) ** 2 + (w.h[1] / alpha_y) ** 2 + w.nh**2
    distribution = 1 / (mpmath.pi * alpha_x * alpha_y * width**2)
    g2 = 1 / (1 + smith(w.i) + smith(w.o))
    return kd / mpmath.pi + schlick(f0, w.hi) * distribution * g2 / (4 * w.nl * w.nv), 0


def ggx_isotropic(w: Frame, kd: Number, alpha: Number, f0: Number) -> tuple[Number, Number]:
    return ggx(w, kd, f0, alpha, alpha)


def metallic_roughness(
    w: Frame,
    coat_weight: Number,
    coat_roughness: Number,
    sheen_color: Number,
    sheen_roughness: Number,
    **base: Number,
) -> tuple[Number, Number]:
    """KHR_materials_clearcoat over the base: the mixture by the weight times Schlick's term at the viewer's cosine."""
    assert sheen_color == 0  # of which test_sheen.py is
    del sheen_roughness
    value, steps = under_coat(w, **base)
    a2 = max(coat_roughness, mpmath.mpf(0.02)) ** 4
    distribution = a2 / (mpmath.pi * (w.nh**2 * (a2 - 1) + 1) ** 2)
    shadowing = [2 * c / (c + mpmath.sqrt(a2 + (1 - a2) * c**2)) for c in (w.nl, w.nv)]
    coat = distribution * shadowing[0] * shadowing[1] / (4 * w.nl * w.nv)
    share = coat_weight * schlick(mpmath.mpf(0.04), w.nv)
    return (1 - share) * value + share * coat, steps


def under_coat(
    w: Frame, base_color: Number, metallic: Number, roughness: Number, multiple_scattering: Number
) -> tuple[Number, Number]:
    a2 = roughness**4
    c_diff = base_color * (1 - metallic)
    f0 = mpmath.mpf(0.04) * (1 - metallic) + base_color * metallic
    fresnel = schlick(f0, w.hi)
    distribution = a2 / (mpmath.pi * (w.nh**2 * (a2 - 1) + 1) ** 2)

    def half_g(c: Number) -> Number:
        return 2 * c / (c + mpmath.sqrt(a2 + (1 - a2) * c**2))

    specular = fresnel * distribution * half_g(w.nl) * half_g(w.nv) / (4 * w.nl * w.nv)
    single = (1 - fresnel) / mpmath.pi * c_diff + specular

    def loss(c: Number) -> tuple[Number, Number]:
        """The polynomial, and how much larger the sum of its terms' sizes is, by which rounding grows."""
        s = c / (c + roughness**2)
        terms = [mpmath.mpf(float(SEPARABLE.lost[i, j])) * s**i * roughness**j for i in range(6) for j in range(5)]
        return (1 - s) ** 2 * mpmath.fsum(terms), mpmath.fsum(map(abs, terms)) / abs(mpmath.fsum(terms))

    if multiple_scattering == 0:
        return single, 0
    terms = [
        *(mpmath.mpf(c) * roughness**j for j, c in enumerate(SEPARABLE.mean_lost)),
        SEPARABLE.mean_log * mpmath.log(roughness),
    ]
    mean, growth = mpmath.fsum(terms), mpmath.fsum(map(abs, terms)) / mpmath.fsum(terms)
    average = f0 + (1 - f0) / 21
    again = average**2 * (1 - a2 * mean) / (1 - average * a2 * mean)
    (light, light_growth), (viewer, viewer_growth) = loss(w.nl), loss(w.nv)
    lobe = multiple_scattering * again * light * viewer / (mpmath.pi * a2 * mean)
    return single + lobe, growth + light_growth + viewer_growth


PRINTED: dict[str, Callable[..., tuple[Number, Number]]] = {
    "lambert": lambert,
    "oren-nayar": oren_nayar,
    "phong": phong,
    "blinn-phong": blinn_phong,
    "lafortune": lafortune,
    "lafortune-three-lobes": three_lobes,
    "ward": ward,
    "ashikhmin-shirley": ashikhmin_shirley,
    "cook-torrance": cook_torrance,
    "ggx": ggx_isotropic,
    "ggx-anisotropic": ggx,
    "metallic-roughness": metallic_roughness,
}


#: All but Poulin–Fournier, which is defined by integrals and has a test of its own.
CLOSED = [
    *(text for text in TEXTS if not text.startswith("poulin-fournier")),
    "metallic-roughness:base_color=0.2/0.5/0.9,metallic=0.4,roughness=0.5,coat_weight=0.8,coat_roughness=0.3",
]


def evaluate_definition(brdf: Any, wi: Direction, wo: Direction, channel: int) -> tuple[Number, Number]:
    """The definition's value, and the |exponent ln base| within it."""
    values = {
        p.name: mpmath.mpf(v[channel] if isinstance(v := getattr(brdf, p.name), tuple) else v) for p in parameters(brdf)
    }
    return PRINTED[model_name(brdf)](Frame(wi, wo), **values)


def sensitivity(brdf: Any, wi: Direction, wo: Direction, channel: int) -> Number:
    """Sum of the changes of the value when each component changes by three units in its last place."""
    value, _ = evaluate_definition(brdf, wi, wo, channel)
    total = mpmath.mpf(0)
    for k in range(6):
        moved = [*wi, *wo]
        moved[k] = moved[k] * (1 + 6 * mpmath.mpf(U))
        total += abs(
            evaluate_definition(brdf, (moved[0], moved[1], moved[2]), (moved[3], moved[4], moved[5]), channel)[0]
            - value
        )
    return total


def check(brdf: Any, wi: np.ndarray, wo: np.ndarray, channels: tuple[int, ...] = (0, 1, 2)) -> None:
    """The value at each pair is the printed one, up to (8 + 2 |n ln x|) u and the sensitivity."""
    mpmath.mp.dps = 50
    for value, i, o in zip(brdf.f(wi, wo), wi, wo, strict=True):
        exact_i, exact_o = (tuple(mpmath.mpf(float(x)) for x in w) for w in (i, o))
        for channel in channels:
            expected, steps = evaluate_definition(brdf, exact_i, exact_o, channel)
            bound = (8 + 2 * steps) * U * expected + sensitivity(brdf, exact_i, exact_o, channel) + 1e-300
            assert abs(mpmath.mpf(float(value[channel])) - expected) <= bound, (i, o, value[channel], float(expected))


@pytest.mark.parametrize("text", CLOSED)
def test_BR4_BR5_BR6_BR7_values_equal_the_printed_definition(text: str) -> None:
    brdf = brdf_from_text(text)
    check(brdf, *pairs(12, seed=4))


@pytest.mark.parametrize("text", CLOSED)
def test_BR1_BR5_values_near_the_horizon_and_at_the_half_vector_equal_the_printed_definition(text: str) -> None:
    brdf = brdf_from_text(text)
    low = normalize([[1.0, 0.2, 1e-8], [1.0, -0.3, 1e-4], [0.3, 0.2, 1.0], [1e-9, 0.0, 1.0], [0.6, 0.0, 0.8]])
    other = normalize([[-1.0, -0.2, 2e-8], [0.1, 0.3, 1.0], [-0.3, -0.2, 1.0], [0.0, 1e-9, 1.0], [0.6, 1e-7, 0.8]])
    check(brdf, low, other, (0,))


def test_BR6_fresnel_term_near_head_on_equals_the_printed_definition() -> None:
    """Without f0 nothing but (1 − h·wi)⁵ is left, of a number that is next to 1."""
    wi = normalize([[0.6, 0.0, 0.8], [0.3, 0.2, 1.0], [0.1, 0.0, 1.0]])
    wo = normalize([[0.6, 1e-3, 0.8], [0.3, 0.25, 1.0], [0.1, 1e-2, 1.0]])
    check(brdf_from_text("ggx:kd=0,alpha=0.5,f0=0"), wi, wo, (0,))


def test_BR5_ashikhmin_shirley_at_the_half_vector_itself() -> None:
    """h = n exactly: the power is 1 and the exponent, which is 0/0, does not matter."""
    wi = np.array([0.6, 0.0, 0.8])
    value = brdf_from_text("ashikhmin-shirley:kd=0,ks=1,nu=10,nv=1000").f(wi, wi * (-1, -1, 1))
    assert value == pytest.approx(np.sqrt(11 * 1001) / (8 * np.pi) / 0.8**2, rel=1e-15)


def test_BR8_lafortune_lobes_with_a_negative_base_are_zero() -> None:
    """Backward lobes seen forward: (−x)^2.5 would be NaN and (−x)^2 a highlight on the wrong side."""
    wi, wo = normalize((0.8, 0.0, 0.4)), normalize((-0.8, 0.0, 0.4))
    for exponent in (2.0, 2.5, 3.0):
        value = brdf_from_text(f"lafortune:kd=0,ks=1,cxy=0.7,cz=0.3,exponent={exponent}").f(wi, wo)
        assert value.tolist() == [0.0, 0.0, 0.0]


def test_lafortune_with_opposite_weights_is_phong() -> None:
    wi, wo = pairs(200)
    same = brdf_from_text("phong:kd=0.2,ks=0.3,exponent=40").f(wi, wo)
    assert brdf_from_text("lafortune:kd=0.2,ks=0.3,cxy=-0.5,cz=0.5,exponent=40").f(wi, wo) == pytest.approx(same)


def test_ggx_of_equal_widths_is_isotropic() -> None:
    wi, wo = pairs(200)
    same = brdf_from_text("ggx:kd=0.2,alpha=0.3,f0=0.1").f(wi, wo)
    assert brdf_from_text("ggx:kd=0.2,alpha_x=0.3,alpha_y=0.3,f0=0.1").f(wi, wo) == pytest.approx(same, rel=1e-14)


def test_metallic_roughness_mixes_as_gltf_prescribes_at_both_ends() -> None:
    """Appendix B.2: a dielectric is mix(diffuse, specular, F of 0.04), a metal is specular times F of its colour."""
    wi, wo = pairs(200)
    half = normalize(wi + wo)
    grazing = (1.0 - np.sum(half * wi, axis=-1, keepdims=True)) ** 5
    white = brdf_from_text("metallic-roughness:base_color=1,metallic=1,roughness=0.5").f(wi, wo)
    metal = brdf_from_text("metallic-roughness:base_color=0.7/0.2/0.4,metallic=1,roughness=0.5").f(wi, wo)
    colour = np.array((0.7, 0.2, 0.4))
    assert metal == pytest.approx(white * (colour + (1 - colour) * grazing), rel=1e-12)
    fresnel = 0.04 + 0.96 * grazing
    dielectric = brdf_from_text("metallic-roughness:base_color=0.7/0.2/0.4,metallic=0,roughness=0.5").f(wi, wo)
    assert dielectric == pytest.approx((1 - fresnel) * colour / np.pi + fresnel * white, rel=1e-12)
