"""Laws that every model obeys, its printed value in 50 digits, and its GLSL twin."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, brdf_to_text, model_name
from engine.directions import normalize, surface_direction
from engine.gl.program import load_program, set_uniforms
from engine.params import parameters

TEXTS = (
    "lambert:albedo=0.2/0.5/0.9",
    "phong:kd=0.3/0.2/0.1,ks=0.4,exponent=20",
    "phong:exponent=0",
    "phong:exponent=10000",
    "blinn-phong:kd=0.1,ks=0.6/0.3/0.2,exponent=50",
    "blinn-phong:exponent=1000000",
    "ggx:kd=0.2,alpha=0.3,f0=0.04/0.5/1",
    "ggx:kd=0,alpha=0.0001,f0=0.5",
    "ggx:kd=0,alpha=1,f0=1",
)


def pairs(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions on the upper hemisphere; half of the pairs near their mirror direction, where lobes are."""
    rng = np.random.default_rng(seed)
    wi, wo = (normalize(rng.normal(size=(count, 3))) for _ in range(2))
    wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
    near = wi[::2] * (-1, -1, 1) + 10.0 ** -rng.uniform(0, 4, (len(wi[::2]), 1)) * rng.normal(size=wi[::2].shape)
    wo[::2] = normalize(near)
    wo[:, 2] = np.abs(wo[:, 2])
    return wi, wo


def printed(brdf: Any, wi: np.ndarray, wo: np.ndarray) -> list[mpmath.mpf]:
    """The definition as it is printed in the table of models, at 50 digits, directions normalised there."""
    mpmath.mp.dps = 50
    i, o = (mpmath.matrix([mpmath.mpf(float(x)) for x in w]) for w in (wi, wo))
    i, o = i / mpmath.norm(i), o / mpmath.norm(o)
    h = (i + o) / mpmath.norm(i + o)
    name, pi = model_name(brdf), mpmath.pi
    values = []
    for channel in range(3):
        p = {
            q.name: mpmath.mpf(v[channel] if isinstance(v := getattr(brdf, q.name), tuple) else v)
            for q in parameters(brdf)
        }
        if name == "lambert":
            values.append(p["albedo"] / pi)
        elif name == "phong":
            cosine = max(mpmath.mpf(0), -i[0] * o[0] - i[1] * o[1] + i[2] * o[2])
            n = p["exponent"]
            values.append(p["kd"] / pi + p["ks"] * (n + 2) / (2 * pi) * cosine**n)
        elif name == "blinn-phong":
            n = p["exponent"]
            norm = (n + 2) * (n + 4) / (8 * pi * (mpmath.mpf(2) ** (-n / 2) + n))
            values.append(p["kd"] / pi + p["ks"] * norm * h[2] ** n)
        else:
            a2 = p["alpha"] ** 2
            d = a2 / (pi * (h[2] ** 2 * (a2 - 1) + 1) ** 2)

            def smith(c: mpmath.mpf, a2: mpmath.mpf = a2) -> mpmath.mpf:
                return (mpmath.sqrt(1 + a2 * (1 - c**2) / c**2) - 1) / 2

            g2 = 1 / (1 + smith(i[2]) + smith(o[2]))
            fresnel = p["f0"] + (1 - p["f0"]) * (1 - (i.T * h)[0]) ** 5
            values.append(p["kd"] / pi + fresnel * d * g2 / (4 * i[2] * o[2]))
    return values


@pytest.mark.parametrize("text", TEXTS)
def test_BR4_value_equals_the_printed_definition(text: str) -> None:
    brdf = brdf_from_text(text)
    wi, wo = pairs(60, seed=4)
    exponent = getattr(brdf, "exponent", 0.0)
    steepness = 1.0 / getattr(brdf, "alpha", 1.0)
    for value, i, o in zip(brdf.f(wi, wo), wi, wo, strict=True):
        cosine = max(float(i @ (o * (-1, -1, 1))), 1e-300) if exponent else 1.0
        bound = (100.0 + 10.0 * exponent * abs(np.log(cosine)) + 20.0 * steepness + exponent) * 1.2e-16
        assert [float(v) for v in printed(brdf, i, o)] == pytest.approx(value, rel=bound, abs=1e-300)


@pytest.mark.parametrize("text", TEXTS)
def test_BR9_reciprocity(text: str) -> None:
    brdf = brdf_from_text(text)
    wi, wo = pairs(100_000)
    there, back = brdf.f(wi, wo), brdf.f(wo, wi)
    assert brdf.reciprocal
    assert np.all(np.abs(there - back) <= 16 * 1.2e-16 * there)


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize("cosine", [0.0, -0.0, -1e-8, -1.0])
def test_BR1_nothing_is_reflected_at_and_below_the_horizon(text: str, cosine: float) -> None:
    brdf = brdf_from_text(text)
    low = np.array([np.sqrt(1 - cosine**2), 0.0, cosine])
    up = normalize((0.3, -0.2, 0.9))
    for wi, wo in ((low, up), (up, low), (low, low)):
        assert brdf.f(wi, wo).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("text", TEXTS)
def test_BR1_BR2_values_just_above_the_horizon_and_at_the_normal_are_finite(text: str) -> None:
    brdf = brdf_from_text(text)
    grazing = np.array([np.sqrt(1 - 1e-16), 0.0, 1e-8])
    normal = np.array([0.0, 0.0, 1.0])
    for wi, wo in ((grazing, normal), (normal, normal), (grazing, grazing * (-1, 1, 1)), (grazing, grazing)):
        value = brdf.f(wi, wo)
        assert np.isfinite(value).all()
        assert (value >= 0).all()


@pytest.mark.parametrize("text", TEXTS)
def test_BR3_opposite_directions_give_zero_and_no_nan(text: str) -> None:
    brdf = brdf_from_text(text)
    wi = surface_direction(np.array([np.pi / 2, 1.0, 0.0, 2.0]), 0.3)
    value = brdf.f(wi, -wi) * np.maximum(wi[:, 2:], 0.0)
    assert np.array_equal(value, np.zeros_like(value))


def test_BR4_exponent_zero_is_diffuse() -> None:
    wi, wo = pairs(100)
    assert brdf_from_text("phong:kd=0.2,ks=0.3,exponent=0").f(wi, wo) == pytest.approx(0.5 / np.pi, rel=1e-14)


def test_BR6_fresnel_ends_are_exact() -> None:
    ggx: Any = brdf_from_text("ggx:kd=0,alpha=0.5,f0=0.04")
    white: Any = brdf_from_text("ggx:kd=0,alpha=0.5,f0=1")
    normal = np.array([0.0, 0.0, 1.0])
    assert (ggx.f(normal, normal) / white.f(normal, normal)).tolist() == [0.04] * 3
    grazing = np.array([1.0, 0.0, 1e-9])
    ratio = ggx.f(grazing, grazing * (-1, 1, 1)) / white.f(grazing, grazing * (-1, 1, 1))
    assert ratio == pytest.approx([1.0] * 3, abs=1e-8)


@pytest.mark.parametrize("alpha", [1e-4, 1e-3, 0.03, 0.3, 1.0])
def test_BR7_normal_distribution_integrates_to_one(alpha: float) -> None:
    """With wo = wi = h and F = 1: f = D G₂ / (4 cos²); 2π ∫ D cos sin dθ = 1, in t = ln tan θ."""
    brdf = brdf_from_text(f"ggx:kd=0,alpha={alpha},f0=1")
    t = np.linspace(np.log(alpha) - 12, 14, 20_001)
    theta = np.arctan(np.exp(t))
    w = surface_direction(theta)
    w = w[w[:, 2] > 1e-5]
    theta = theta[: len(w)]
    sine2 = w[:, 0] ** 2
    g2 = w[:, 2] / np.sqrt(w[:, 2] ** 2 + alpha**2 * sine2)
    distribution = brdf.f(w, w)[:, 0] * 4 * w[:, 2] ** 2 / g2
    integrand = 2 * np.pi * distribution * w[:, 2] * np.sin(theta) * np.sin(theta) * np.cos(theta)
    assert np.sum(integrand) * (t[1] - t[0]) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("text", TEXTS)
def test_BR10_models_that_say_so_conserve_energy(text: str) -> None:
    brdf = brdf_from_text(text)
    if "10000" in text or "0.0001" in text:
        pytest.skip("the lobe is narrower than the quadrature; its normalisation is tested above")
    brightest = max(albedo(brdf, theta).max() for theta in np.linspace(0, np.radians(89.9), 16))
    if brdf.energy_conserving:
        assert brightest <= 1.0 + 1e-3


@pytest.mark.parametrize("text", ["phong:kd=0.7,ks=0.5", "blinn-phong:kd=0.7,ks=0.5", "ggx:kd=0.9,alpha=0.1,f0=0.9"])
def test_BR10_models_that_do_not_are_flagged(text: str) -> None:
    brdf = brdf_from_text(text)
    assert not brdf.energy_conserving
    assert max(albedo(brdf, theta).max() for theta in (0.0, 1.2)) > 1.0


@pytest.mark.parametrize("model", ["phong", "blinn-phong"])
def test_lobe_reflects_ks_at_normal_incidence(model: str) -> None:
    assert albedo(brdf_from_text(f"{model}:kd=0,ks=0.5,exponent=20"), 0.0) == pytest.approx([0.5] * 3, rel=1e-3)


def albedo(brdf: Brdf, theta_o: float) -> np.ndarray:
    """∫ f cos(theta_i) dwi by the midpoint rule over cos² theta_i and azimuth."""
    u, phi = np.meshgrid((np.arange(400) + 0.5) / 400, 2 * np.pi * (np.arange(400) + 0.5) / 400)
    wi = surface_direction(np.arccos(np.sqrt(u)), phi)
    return np.pi * brdf.f(wi, surface_direction(theta_o)).mean(axis=(0, 1))


@pytest.mark.parametrize("name", MODELS)
@given(data=st.data())
@settings(max_examples=50, deadline=None)
def test_every_allowed_parameter_gives_finite_values(name: str, data: st.DataObject) -> None:
    model = MODELS[name]
    values = {}
    for p in parameters(model):
        number = st.floats(p.low, p.high)
        values[p.name] = data.draw(st.tuples(number, number, number) if p.is_colour else number)
    brdf = model(**values)
    value = brdf.f(*pairs(64, seed=data.draw(st.integers(0, 99))))
    assert np.isfinite(value).all()
    assert (value >= 0).all()
    assert brdf_from_text(brdf_to_text(brdf)) == brdf


@pytest.mark.parametrize(
    "text", ["velvet", "phong:shine=2", "phong:exponent=-1", "phong:exponent=nan", "ggx:alpha=0", ""]
)
def test_bad_text_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError, match=r"known are|outside"):
        brdf_from_text(text)


@pytest.mark.parametrize("text", TEXTS)
def test_glsl_twin_agrees_to_1e_5(gl: Any, tmp_path: Any, text: str, shader: Callable[[str, str], None]) -> None:
    brdf = brdf_from_text(text)
    wi, wo = (w.astype(np.float32) for w in pairs(100_000, seed=9))
    on_gpu = evaluate_on_gpu(gl, brdf, wi, wo, shader)
    expected = brdf.f(wi, wo)
    lobe = expected > 1e-6 * expected.max()
    assert np.isfinite(on_gpu).all()
    assert np.abs(on_gpu[lobe] / expected[lobe] - 1.0).max() <= 1e-5
    assert np.abs(on_gpu[~lobe] - expected[~lobe]).max(initial=0.0) <= 1e-5 * expected.max()


def evaluate_on_gpu(gl: Any, brdf: Brdf, wi: np.ndarray, wo: np.ndarray, shader: Any) -> np.ndarray:
    source = (
        "#version 330 core\n#include BRDF\nin vec3 wi;\nin vec3 wo;\nout vec3 value;\n"
        "void main()\n{\n    value = brdf(wi, wo);\n}\n"
    )
    folder = shader("evaluate.vert", source)
    definitions = {"BRDF": f"brdf/{model_name(brdf)}.glsl"}
    program = load_program(gl, "evaluate.vert", None, definitions, folder=folder, varyings=["value"])
    set_uniforms(program, {f"brdf_{p.name}": getattr(brdf, p.name) for p in parameters(brdf)})
    given_ = gl.buffer(np.concatenate([wi, wo], axis=1).astype("f4").tobytes())
    result = gl.buffer(reserve=12 * len(wi))
    array = gl.vertex_array(program, [(given_, "3f 3f", "wi", "wo")])
    framebuffer = gl.simple_framebuffer((1, 1))
    framebuffer.use()
    array.transform(result, gl.POINTS, vertices=len(wi))
    values = np.frombuffer(result.read(), np.float32).reshape(-1, 3)
    for item in (framebuffer, array, result, given_, program):
        item.release()
    return values


def test_luminance_in_the_shader_is_the_engine_s() -> None:
    from engine.colour import LUMINANCE
    from engine.gl.program import SHADERS

    line = next(line for line in (SHADERS / "direct.frag").read_text().splitlines() if "LUMINANCE = vec3" in line)
    numbers = [float(number) for number in line.split("(")[1].split(")")[0].split(",")]
    assert [struct.pack("f", n) for n in numbers] == [struct.pack("f", n) for n in LUMINANCE]
