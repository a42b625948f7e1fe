"""BRDFs that a user writes in GLSL: known models written anew against the program's own, and hostile texts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.brdf import written as module
from engine.brdf.brdf import Brdf
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.microfacet import Ggx
from engine.brdf.models.phong import BlinnPhong
from engine.brdf.readers.read import read_brdf
from engine.brdf.resample import random_pairs, table_from
from engine.brdf.written import SourceError, parse, with_value, write
from engine.core.errors import MissingCapability

HEAD = "vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)"

LAMBERT = f"""analytic
# the simplest
::begin parameters
color albedo 0.5 0.25 1   # of each channel
::end parameters
::begin shader
{HEAD} {{ return albedo / 3.14159265358979; }}
::end shader
"""

BLINN_PHONG = f"""analytic
::begin parameters
float n 1 1000 40
bool diffuse 1
::end parameters
::begin shader
const float PI = 3.14159265358979;
{HEAD}
{{
    vec3 H = normalize(L + V);
    float norm = (n + 2) * (n + 4) / (8 * PI * (pow(2, -n / 2) + n));
    return vec3(0.3 * pow(dot(N, H), n) * norm + (diffuse ? 0.2 / PI : 0.0));
}}
::end shader
"""

GGX = f"""analytic
::begin parameters
float alpha 0.001 1 0.3
::end parameters
::begin shader
float lambda(float c) {{ return 0.5 * (sqrt(1 + alpha * alpha * (1 - c * c) / (c * c)) - 1); }}
{HEAD}
{{
    vec3 H = normalize(L + V);
    float a2 = alpha * alpha, t = dot(N, H) * dot(N, H) * (a2 - 1) + 1;
    float D = a2 / (3.14159265358979 * t * t);
    float F = 0.04 + 0.96 * pow(1 - dot(L, H), 5);
    return vec3(0.2 / 3.14159265358979 + D * F / (1 + lambda(L.z) + lambda(V.z)) / (4 * L.z * V.z));
}}
::end shader
"""


def make(text: str) -> module.WrittenBrdf:
    try:
        return write(text, "made", "made.brdf")
    except MissingCapability as missing:
        pytest.skip(str(missing))


@pytest.mark.parametrize(
    ("text", "own"),
    [
        (LAMBERT, Lambert(albedo=(0.5, 0.25, 1.0))),
        (BLINN_PHONG, BlinnPhong(kd=(0.2,) * 3, ks=(0.3,) * 3, exponent=40.0)),
        (GGX, Ggx(kd=(0.2,) * 3, alpha=0.3, f0=(0.04,) * 3)),
    ],
    ids=["lambert", "blinn-phong", "ggx"],
)
def test_a_known_model_has_the_values_of_our_own(text: str, own: Brdf) -> None:
    brdf = make(text)
    wi, wo = random_pairs(3000)
    ours = own.f(wi, wo)
    assert brdf.isotropic
    assert brdf.reciprocal
    np.testing.assert_allclose(brdf.f(wi, wo), ours, rtol=2e-4, atol=1e-6 * float(ours.max()))
    assert table_from(brdf, (24, 24, 24)).health.figures["resampling_rms_rel"] < 0.05


def test_values_are_0_below_the_horizon_and_have_the_shape_of_the_directions() -> None:
    brdf = make(LAMBERT)
    wi = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8]])
    values = brdf.f(wi[:, None], np.array([0.0, 0.0, 1.0]))
    assert values.shape == (3, 1, 3)
    np.testing.assert_allclose(values[0, 0], np.array([0.5, 0.25, 1.0]) / np.pi, rtol=1e-6)
    assert np.all(values[1:] == 0.0)


def test_tangent_and_exchange_are_noticed() -> None:
    assert not make(LAMBERT.replace("albedo /", "albedo * dot(normalize(L + V), X) /")).isotropic
    assert not make(LAMBERT.replace("albedo /", "albedo * L.z /")).reciprocal


def test_doubtful_values_count_as_0_and_are_told() -> None:
    brdf = make(LAMBERT.replace("albedo /", "(V.z > 0.7 ? albedo : -albedo) * (L.z > 0.9 ? sqrt(-L.z) : 1.0) /"))
    assert len(brdf.health.warnings) == 2
    wi, wo = random_pairs(500)
    values = brdf.f(wi, wo)
    assert np.all(np.isfinite(values))
    assert np.all(values >= 0.0)


def test_a_value_is_changed_in_the_text_and_nothing_else() -> None:
    changed = with_value(LAMBERT, "albedo", (1.0, 0.5, 0.125))
    assert changed == LAMBERT.replace("0.5 0.25 1 ", "1 0.5 0.125 ")
    assert parse(with_value(BLINN_PHONG, "n", 7.5)).parameters[0].value == 7.5
    assert parse(with_value(BLINN_PHONG, "diffuse", False)).parameters[1].value is False


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", 1, "does not begin with the word analytic"),
        (LAMBERT.replace("color", "vec9"), 4, "not a kind of parameter"),
        (LAMBERT.replace("0.25 1", "nan 1"), 4, "is not a parameter"),
        (LAMBERT.replace("albedo 0.5", "gl_albedo 0.5"), 4, "not a name"),
        (LAMBERT.replace("::end parameters\n", ""), 5, "has not ended"),
        (LAMBERT.replace("::end shader\n", ""), 6, "never ends"),
        (LAMBERT.replace("vec3 BRDF", "vec3 OTHER"), 7, "no function BRDF"),
        (BLINN_PHONG.replace("1 1000", "5 5"), 3, "range of n is empty"),
        (BLINN_PHONG.replace("bool diffuse", "bool n"), 4, "again"),
        (LAMBERT.replace(HEAD, f'# include "/etc/passwd"\n{HEAD}'), 7, "#include is not allowed"),
        (LAMBERT + "/" * module.LIMIT_BYTES, 0, "bytes of text"),
        (LAMBERT.replace("albedo /", "\0"), 7, "zero byte"),
    ],
)
def test_a_text_that_is_no_brdf_is_refused_at_its_line(text: str, line: int, words: str) -> None:
    with pytest.raises(SourceError, match=words) as caught:
        parse(text, "made.brdf")
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("albedo /", "albode /", 7),
        ("color albedo", "color sampler2D", 4),
        ("; }", "; } /*", 8),
        ("return", "return return", 7),
    ],
)
def test_what_does_not_compile_is_told_at_its_line(old: str, new: str, line: int) -> None:
    make(LAMBERT)
    with pytest.raises(SourceError) as caught:
        write(LAMBERT.replace(old, new), "made", "made.brdf")
    assert caught.value.line <= line or old == "; }"
    assert "\n" not in str(caught.value)


def test_what_hangs_is_ended_and_the_next_one_works(monkeypatch: pytest.MonkeyPatch) -> None:
    make(LAMBERT)
    loops = "float z = 0.0; for (int i = 0; i < 50000; i++) z += sin(z + L.x * float(i)) + pow(abs(z), 0.3);"
    slow = LAMBERT.replace("return albedo", f"{loops} return z * albedo")
    monkeypatch.setattr(module, "HANG_S", 0.3)
    with pytest.raises(SourceError, match=r"hangs|takes more than"):
        write(slow, "slow", "slow.brdf")
    monkeypatch.undo()
    assert make(LAMBERT).isotropic


def looping(loops: str) -> str:
    """A text whose value is the number that `loops` leave in `count`, divided by 1,000."""
    body = f"int count = 0; int n = int(L.z) + 30; {loops} return vec3(float(count) / 1000.0)"
    return LAMBERT.replace("return albedo / 3.14159265358979", body)


@pytest.mark.parametrize(
    ("loops", "value"),
    [
        ("for (int i = 0; i < n; i++) count++;", 0.03),
        ("for (int i = 0; i < n; i++) for (int j = 0; j < n; j++) { if (j == 2) continue; count++; }", 0.87),
        ("for (int i = 0, j = (n); (i < j) && (j > 0); i++, j--) count += i; // for (;\n", 0.105),
        ("int i = 0; while (i < n) { i++; count += 2; /* while ( */ }", 0.06),
        ("int i = 0; do { i++; count++; } while (i < n && count > 0); for (;;) { if (count++ > 40) break; }", 0.042),
        (
            "#define EACH for (int i = 0; i < n; i++)\n EACH count++; float waterfor = 1.0; count *= int(waterfor);",
            0.03,
        ),
    ],
)
def test_loops_count_as_they_are_written(loops: str, value: float) -> None:
    make(LAMBERT)
    wi, wo = random_pairs(8)
    assert np.allclose(make(looping(loops.replace("#define", "\n#define"))).f(wi, wo), value, rtol=1e-6)


@pytest.mark.parametrize(
    "loops",
    [
        "for (int i = 0; i < 2000 * n; i++) count++;",
        "for (int i = 0; i < 9 * n; i++) for (int j = 0; j < 9 * n; j++) count++;",
        "int i = 0; while (true) { i++; count += i; }",
        "int i = 0; do { i++; count++; } while (i < 2001 * n);",
        "for (int i = 0; i < 2000000000; i++) for (int j = 0; j < 2000000000; j++) count += i * j;",
    ],
)
def test_loops_that_the_driver_would_cut_off_are_refused(loops: str) -> None:
    """Mesa's software renderer ends them after 65,535 iterations, and the sum so far looks like a result."""
    make(LAMBERT)
    with pytest.raises(SourceError, match="more than 60,000 iterations"):
        write(looping(loops), "long", "long.brdf")


def test_a_loop_that_declares_in_its_condition_is_refused() -> None:
    make(LAMBERT)
    with pytest.raises(SourceError, match="condition declares"):
        write(looping("while (bool more = count < n) count++;"), "declares", "declares.brdf")


def test_evaluations_of_one_request_share_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    brdf = make(LAMBERT)
    wi, wo = random_pairs(64)
    replies = iter([5.0, 5.0, 1.0])
    from engine.storage.untrusted import decode_content as reply

    def count(*given: object, **options: object) -> dict[str, object]:
        return {**reply(*given, **options), "cpu_s": next(replies)}  # type: ignore[arg-type]

    monkeypatch.setattr(module, "decode_content", count)
    with module.one_request():
        brdf.f(wi, wo)
        brdf.f(wi, wo)
        with pytest.raises(SourceError, match="takes more than 8 s"):
            brdf.f(wi, wo)
    with module.one_request():
        assert np.isfinite(brdf.f(wi, wo)).all()


def test_a_file_is_recognised_by_its_first_word(tmp_path: Path) -> None:
    make(LAMBERT)
    path = tmp_path / "mine.brdf"
    path.write_text(LAMBERT, encoding="utf-8")
    brdf = read_brdf(path)
    assert (brdf.name, brdf.kind) == ("mine", "written in GLSL")
    path.write_bytes(b"analytic\r\n\xff\xfe")
    with pytest.raises(SourceError, match="has no function BRDF"):
        read_brdf(path)
