"""Readers of scattered measurements: the same numbers from every spelling, and a sentence for every wrong file."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.brdf.half_difference import half_difference
from engine.brdf.readers.alta import PARAMETRISATIONS, read_alta
from engine.brdf.readers.cornell import read_cornell
from engine.brdf.readers.csv_samples import read_csv_samples
from engine.brdf.readers.curet import read_curet
from engine.brdf.readers.read import open_brdf, read_measurement
from engine.brdf.readers.samples_child import read_directions
from engine.brdf.samples import BrdfSamples, samples_from_rows
from engine.brdf.spectrum import srgb_from_spectra
from engine.core.directions import surface_direction
from engine.core.errors import InputError
from tests.engine.brdf.fitted import fit_scattered_brdf

TABLE = """# a paint
3
400 550
700
# theta_i phi_i theta_s phi_s
0.5 0.0 0.25 1.0  0.1 0.2 0.3
1.0 0.0 0.75 -1.0  0.4 0.5 0.6
"""
ASTM = """LAB_NAME Somewhere
NUM_POINTS 2
VARS theta_i,phi_i,theta_s,phi_s,400nm,550nm,700nm

0.5,0.0,0.25,1.0,0.1,0.2,0.3
1.0,0.0,0.75,-1.0,0.4,0.5,0.6
"""
CSV = """theta_i,phi_i,theta_o,phi_o,R,G,B
10,0,20,30,0.1,0.2,0.3
40,50,60,-70,1e-3,2.5,0
"""
ALTA = """#ALTA HEADER BEGIN
#DIM 3 1
#VS 0
#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI
#PARAM_OUT INV_STERADIAN
#ALTA HEADER END
0.2 0.1 0.3 0.5
0.3 -0.4 0.0 0.25
"""


def write(folder: Path, content: str | bytes, name: str = "paint.txt") -> Path:
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def curet(folder: Path, materials: int = 2, channels: str = "rgb") -> Path:
    """CUReT tables as published, with invented values: material m has (m + channel/10 + k/1000) at direction k."""
    random = np.random.default_rng(4)
    angles = random.uniform(0.0, 1.4, (205, 4)) * (1.0, 2.0, 1.0, -2.0)
    (folder / "table.txt").write_text("\n".join(" ".join(f"{angle:.6f}" for angle in row) for row in angles))
    for number, channel in enumerate(channels):
        rows = (
            f"{material} " + " ".join(f"{material + number / 10 + k / 1000:.4f}" for k in range(205))
            for material in range(1, materials + 1)
        )
        (folder / f"{channel}brdf.dat").write_text("\n".join(rows) + "\n")
    return folder / f"{channels[0]}brdf.dat"


def test_cornell_spectra_become_linear_srgb(tmp_path: Path) -> None:
    samples = read_cornell(write(tmp_path, TABLE, "paint.brdf"))
    np.testing.assert_array_equal(samples.wavelengths_nm, [400, 550, 700])
    np.testing.assert_allclose(samples.wi[1], [math.sin(1.0), 0.0, math.cos(1.0)])
    np.testing.assert_allclose(samples.wo, surface_direction(np.array([0.25, 0.75]), np.array([1.0, -1.0])))
    expected = srgb_from_spectra([400, 550, 700], [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    np.testing.assert_allclose(samples.value, np.maximum(expected, 0.0))
    assert (samples.name, samples.samples, samples.invalid_samples) == ("paint", 2, 0)


def same(one: BrdfSamples, two: BrdfSamples) -> None:
    for part in ("wi", "wo", "value", "wavelengths_nm", "spectra"):
        np.testing.assert_array_equal(getattr(one, part), getattr(two, part))


def test_cornell_spellings_agree(tmp_path: Path) -> None:
    plain = read_cornell(write(tmp_path, TABLE))
    same(plain, read_cornell(write(tmp_path, ASTM)))
    same(plain, read_cornell(write(tmp_path, TABLE.replace("\n", "\r\n"))))
    same(plain, read_cornell(write(tmp_path, TABLE.replace("0.25 1.0 ", "0.25\n1.0 ").encode("utf-16"))))
    same(plain, read_cornell(write(tmp_path, ("# Größe\n" + TABLE).encode("latin-1"))))
    turned = ASTM.replace("400nm,550nm,700nm", "700nm,550 nm,400NM")
    for row in ("0.1,0.2,0.3", "0.4,0.5,0.6"):
        turned = turned.replace(row, ",".join(reversed(row.split(","))))
    same(plain, read_cornell(write(tmp_path, turned)))


def test_angles_of_astm_are_in_the_unit_that_the_file_says(tmp_path: Path) -> None:
    body = "20,0,30,90,1,2,3\n"
    by_size = read_cornell(write(tmp_path, "VARS theta_i,phi_i,theta_r,phi_r,R,G,B\n" + body))
    by_name = read_cornell(write(tmp_path, "VARS theta_i_deg,phi_i_deg,theta_s_deg,phi_s_deg,R,G,B\n" + body))
    by_key = read_cornell(write(tmp_path, "ANGLE_UNITS degrees\nVARS theta_i,phi_i,theta_o,phi_o,R,G,B\n" + body))
    for samples in (by_size, by_name, by_key):
        np.testing.assert_allclose(samples.wi[0], surface_direction(math.radians(20), 0.0))
        np.testing.assert_allclose(samples.wo[0], surface_direction(math.radians(30), math.radians(90)), atol=1e-15)
        np.testing.assert_array_equal(samples.value, [[1, 2, 3]])


def test_real_cornell_files_in_both_spellings_are_identical(shared_data: Callable[[str], Path]) -> None:
    one = read_measurement(shared_data("brdf/cornell/cayman.brdf"))
    two = read_measurement(shared_data("brdf/cornell/cayman.astm"))
    same(one, two)
    assert (one.samples, one.invalid_samples, len(one.wavelengths_nm)) == (1439, 0, 31)


def test_csv_in_every_dress(tmp_path: Path) -> None:
    plain = read_csv_samples(write(tmp_path, CSV))
    np.testing.assert_allclose(plain.wi[1], surface_direction(math.radians(40), math.radians(50)))
    np.testing.assert_array_equal(plain.value, [[0.1, 0.2, 0.3], [1e-3, 2.5, 0.0]])
    body = CSV.split("\n", 1)[1]
    dresses: list[str | bytes] = [
        body,
        "# comment\n" + CSV,
        "\ufeff" + CSV,
        CSV.encode("utf-16"),
        CSV.replace("\n", "\r\n"),
        CSV.replace(",", "\t"),
        CSV.replace(",", "; ").replace(".", ","),
        CSV.replace("theta_i,", "Theta_i (deg),").replace("theta_o", '"ThetaOut"'),
        "R,G,B,phi_o,theta_o,phi_i,theta_i\n0.1,0.2,0.3,30,20,0,10\n1e-3,2.5,0,-70,60,50,40\n",
        body.replace(",", " "),
    ]
    for dress in dresses:
        same(plain, read_csv_samples(write(tmp_path, dress)))
    grey = read_csv_samples(write(tmp_path, "10,0,20,30,0.5\n"))
    np.testing.assert_array_equal(grey.value, [[0.5, 0.5, 0.5]])


def test_directions_alone(tmp_path: Path) -> None:
    path = write(tmp_path, "theta_i,phi_i,theta_o,phi_o\n10,0,20,30\n40,50,120,-70\n")
    wi, wo = read_directions(path)
    np.testing.assert_allclose(wi, surface_direction(np.radians([10, 40]), np.radians([0, 50])))
    np.testing.assert_allclose(wo, surface_direction(np.radians([20, 120]), np.radians([30, -70])))
    np.testing.assert_array_equal(read_directions(write(tmp_path, CSV))[0][0], wi[0])
    with pytest.raises(InputError, match="not finite in row 2"):
        read_directions(write(tmp_path, "1,2,3,4\n1,2,nan,4\n"))
    with pytest.raises(InputError, match="no values R,G,B"):
        read_csv_samples(path)


def test_angles_that_look_like_radians_are_remarked(tmp_path: Path) -> None:
    samples = read_csv_samples(write(tmp_path, "0.5,0,1.2,3.1,1,1,1\n"))
    assert any("radians" in warning for warning in samples.health.warnings)


def test_invalid_rows_are_dropped_and_counted(tmp_path: Path) -> None:
    rows = ["10,0,20,0,1,1,1", "95,0,20,0,1,1,1", "10,0,90,0,1,1,1", "10,0,20,0,1,-1,1", "10,0,20,0,nan,1,1"]
    rows += ["inf,0,20,0,1,1,1", "10,0,20,0,1e999,1,1", "10,0,20,0,1e40,1,1"]
    samples = read_csv_samples(write(tmp_path, "\n".join(rows)))
    assert (len(samples.value), samples.samples, samples.invalid_samples) == (1, 8, 7)
    assert samples.health.figures["dropped: not finite"] == 3
    assert samples.health.figures["dropped: negative"] == 1
    assert samples.health.figures["dropped: at or below the horizon"] == 2
    assert any("7 of 8 measurements" in finding.text for finding in samples.health.findings)


def test_a_negative_channel_of_a_positive_colour_counts_as_0(tmp_path: Path) -> None:
    """Rows of a film: one in gamut, two outside it, and one that is dark; CUReT marks what failed by any channel."""
    rows = ["10,0,20,0,1,2,3", "10,0,30,0,-0.25,0.54,-0.46", "10,0,40,0,0.1,0.2,-1e-9", "10,0,50,0,0.1,-0.5,0.1"]
    samples = read_csv_samples(write(tmp_path, "\n".join(rows)))
    np.testing.assert_array_equal(samples.value, [[1, 2, 3], [0, 0.54, 0], [0.1, 0.2, 0]])
    assert samples.invalid_samples == samples.health.figures["dropped: negative"] == 1
    assert "2 of 4 measurements have a negative channel, which is taken as 0" in samples.health.warnings
    colours = np.array([[1.0, 1.0, 1.0], [1.0, 2.0, -0.1]])
    of = samples_from_rows("a.dat", "samples", samples.wi[:2], samples.wo[:2], colours, negative_is_missing=True)
    assert of.invalid_samples == 1


def test_CO3_colours_outside_srgb_keep_their_negative_channel_and_their_luminance(tmp_path: Path) -> None:
    """At its own directions the smooth BRDF has the colour of the spectrum, luminance and all."""
    rows = "".join(f"0.1 0 {0.2 + 0.1 * k} 0 0 0 {1 + k} 0 0\n" for k in range(6))
    samples = read_cornell(write(tmp_path, f"5\n400 500 520 540 700\n{rows}"))
    assert (samples.value[:, 0] < -1e-3).all()
    assert (samples.positive >= 0.0).all()
    assert samples.health.figures["outside sRGB"] == 6
    smooth = fit_scattered_brdf(samples)
    np.testing.assert_allclose(smooth.f(samples.wi, samples.wo), samples.value, rtol=1e-6, atol=1e-9)


def test_curet_tables(tmp_path: Path) -> None:
    path = curet(tmp_path)
    samples = read_measurement(f"{path}#2")
    assert (samples.samples, samples.name) == (205, "CUReT 2")
    np.testing.assert_allclose(samples.value[17], [2.017, 2.117, 2.217])
    angles = np.loadtxt(tmp_path / "table.txt")
    np.testing.assert_allclose(samples.wo, surface_direction(angles[:, 0], angles[:, 1]))
    np.testing.assert_allclose(samples.wi, surface_direction(angles[:, 2], angles[:, 3]))
    with pytest.raises(InputError, match=r"holds 2 materials; their numbers are 1 to 2\. Name one, as rbrdf\.dat#1"):
        read_curet(path)
    with pytest.raises(InputError, match="has no material 3"):
        open_brdf(f"{path}#3")
    (tmp_path / "gbrdf.dat").unlink()
    grey = read_curet(tmp_path / "bbrdf.dat#1")
    np.testing.assert_allclose(grey.value[3], 1.203)
    assert any("grey" in finding.text for finding in grey.health.findings)
    degrees = "theta_v phi_v theta_i phi_i\n" + "\n".join(
        f"{k} " + " ".join(f"{angle:.9f}" for angle in row) for k, row in enumerate(np.degrees(angles), 1)
    )
    (tmp_path / "table.txt").write_text(degrees)
    np.testing.assert_allclose(read_curet(tmp_path / "bbrdf.dat#1").wi, samples.wi, atol=1e-9)
    (tmp_path / "table.txt").unlink()
    with pytest.raises(InputError, match=r"needs the directions .* Put CUReT's table\.txt next to it"):
        read_curet(tmp_path / "bbrdf.dat#1")


def test_a_curet_file_of_one_material_needs_no_number(tmp_path: Path) -> None:
    assert read_measurement(curet(tmp_path, 1, "a")).name == "CUReT 1"


def alta(folder: Path, name: str, coordinates: str, out: str = "") -> BrdfSamples:
    header = f"#DIM {len(coordinates.split())} 1\n#PARAM_IN {name}\n{out}"
    return read_alta(write(folder, header + coordinates + " 0.5\n"))


def test_alta_rows_of_the_tape_are_light_and_projected_view(tmp_path: Path) -> None:
    samples = read_alta(write(tmp_path, ALTA))
    np.testing.assert_allclose(samples.wi, surface_direction(np.array([0.2, 0.3]), np.zeros(2)))
    expected = surface_direction(np.array([math.hypot(0.1, 0.3), 0.4]), np.array([math.atan2(0.3, 0.1), math.pi]))
    np.testing.assert_allclose(samples.wo, expected, atol=1e-15)


@pytest.mark.parametrize(
    ("name", "coordinates"),
    [
        ("RUSIN_TH_PH_TD_PD", "0.3 0.7 0.4 1.1"),
        ("RUSIN_TH_TD_PD", "0.3 0.4 1.1"),
        ("RUSIN_TH_PH_TD", "0.3 0.7 0.4"),
        ("RUSIN_TH_TD", "0.3 0.4"),
        ("COS_TH_TD", f"{math.cos(0.3)} {math.cos(0.4)}"),
        ("COS_TH", f"{math.cos(0.3)}"),
        ("RUSIN_VH", f"{math.sin(0.3)} 0 {math.cos(0.3)}"),
    ],
)
def test_alta_half_angles_come_back(tmp_path: Path, name: str, coordinates: str) -> None:
    samples = alta(tmp_path, name, coordinates)
    angles = half_difference(samples.wo, samples.wi)
    assert angles.theta_h[0] == pytest.approx(0.3)
    if "TD" in name:
        assert angles.theta_d[0] == pytest.approx(0.4)
    if "PH" in name:
        assert angles.phi_h[0] == pytest.approx(0.7)
    if "PD" in name:
        assert angles.phi_d[0] == pytest.approx(1.1)
    assert bool(samples.health.warnings) == (name in ("RUSIN_TH_TD", "COS_TH_TD", "COS_TH", "RUSIN_VH"))


def test_alta_directions(tmp_path: Path) -> None:
    view, light = surface_direction(0.4, 1.0), surface_direction(0.2, 0.5)
    samples = alta(tmp_path, "SPHERICAL_TL_PL_TV_PV", "0.2 0.5 0.4 1.0")
    np.testing.assert_allclose([samples.wi[0], samples.wo[0]], [light, view])
    samples = alta(tmp_path, "CARTESIAN", " ".join(str(float(x)) for x in (*view, *light)))
    np.testing.assert_allclose([samples.wi[0], samples.wo[0]], [light, view])
    samples = alta(tmp_path, "ISOTROPIC_TV_TL_DPHI", "0.4 0.2 0.5")
    np.testing.assert_allclose([samples.wi[0], samples.wo[0]], [surface_direction(0.2, 0.5), surface_direction(0.4)])
    retro = alta(tmp_path, "RETRO_TL_TVL_PROJ_DPHI", "0.5 0.0 0.1")
    assert np.arccos((retro.wi * retro.wo).sum()) == pytest.approx(0.1)
    schlick = alta(tmp_path, "SCHLICK_TL_TK_PROJ_DPHI", "0.5 0.0 0.0")
    np.testing.assert_allclose(schlick.wo, schlick.wi, atol=1e-15)
    neumann = alta(tmp_path, "NEUMANN_3D", "0.2 0.3 1.2")
    half = (neumann.wi + neumann.wo)[0] / 2
    np.testing.assert_allclose(half[:2], [0.2, 0.0], atol=1e-15)
    assert np.hypot(*((neumann.wi - neumann.wo)[0, :2] / 2)) == pytest.approx(0.3)


def test_alta_values(tmp_path: Path) -> None:
    weighted = alta(tmp_path, "SPHERICAL_TL_PL_TV_PV", "0.2 0 1.0 0", "#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n")
    np.testing.assert_allclose(weighted.value, 0.5 / math.cos(1.0))
    rgb = "#DIM 4 3\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n#PARAM_OUT {}\n0.2 0 1.0 0 {}\n"
    colour = read_alta(write(tmp_path, rgb.format("RGB_COLOR", "1 2 3")))
    np.testing.assert_array_equal(colour.value, [[1, 2, 3]])
    white = read_alta(write(tmp_path, rgb.format("XYZ_COLOR", "0.950456 1 1.089058")))
    np.testing.assert_allclose(white.value, 1.0, atol=1e-3)
    segments = ALTA.replace("#VS 0", "#VS 2").replace("0.3 0.5\n", "0.3 0.5 0.4 0.6\n")
    same(read_alta(write(tmp_path, ALTA)), read_alta(write(tmp_path, segments.replace("0.25\n", "0.25 0.2 0.3\n"))))


def test_every_alta_parametrisation_is_finite_at_ordinary_angles(tmp_path: Path) -> None:
    for name, (count, _) in PARAMETRISATIONS.items():
        if name not in ("CARTESIAN", "RUSIN_VH"):
            samples = alta(tmp_path, name, " ".join(["0.9" if "COS" in name else "0.3"] * count))
            np.testing.assert_allclose(np.linalg.norm(samples.wi, axis=1), 1.0)


def test_the_real_tape_reflects_back(shared_data: Callable[[str], Path]) -> None:
    samples = read_measurement(shared_data("brdf/alta/retro-gray-tape.dat"))
    assert (samples.samples, samples.invalid_samples) == (7405, 86)
    brightest = samples.value[:, 0].argmax()
    assert (samples.wi[brightest] * samples.wo[brightest]).sum() > 0.999


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (TABLE.replace("0.6\n", "\n"), "line 7 has 6 values where 7 are needed"),
        (TABLE.replace("0.4 ", "0.4x "), "line 7 has '0.4x' where a number is needed"),
        (TABLE.replace("0.4 ", "0,4 "), "line 7 has a decimal comma in '0,4'. Write decimal points"),
        (TABLE.replace("0.4 ", "1_0 "), "line 7 has '1_0' where a number"),
        (TABLE.replace("3\n400 550\n700", "3\n400 700\n550"), "line 3 has wavelengths that do not rise"),
        (TABLE[:20], "wavelengths, but 3 are announced|holds no measurement"),
        (ASTM.replace("NUM_POINTS 2", "NUM_POINTS 1000000000000"), "announces 1000000000000 points, but 2 follow"),
        (ASTM.replace("NUM_POINTS 2", "NUM_POINTS 1"), "announces 1 points, but 2 follow"),
        (ASTM.replace("phi_s", "psi"), "names phi_s 0 times"),
        (ASTM.replace("400nm", "haze"), "names a column 'haze'"),
        (ASTM[: ASTM.index("VARS")], "no line VARS"),
        (CSV.replace("60,-70", "60,5000"), "line 3 has phi_o = 5000 degrees"),
        ("10,5,0,0,20,5,30,0,0,1,0,2,0,3\n", "If these are decimal commas"),
        (CSV.replace("theta_i", "theta_i_rad"), "'theta_i_rad' is in radians. Write degrees"),
        (CSV.replace(",0\n", "\n"), "line 3 has 6 columns where 7 are needed"),
        (
            ALTA.replace("ISOTROPIC_TL", "BARYCENTRIC_TL"),
            "names unknown coordinates 'BARYCENTRIC_TL_TV_PROJ_DPHI'; choose from",
        ),
        (ALTA.replace("INV_STERADIAN", "ENERGY"), "names unknown values 'ENERGY'; choose from"),
        (ALTA.replace("#DIM 3 1", "#DIM 2 1"), "has 3 coordinates, but #DIM says 2"),
        (ALTA.replace("#DIM 3 1", "#DIM 3 40"), "says 40 values per sample"),
        (ALTA.replace("0.0 0.25", "0.25"), "line 8 has 3 values where 4 are needed"),
        (ALTA.replace("#VS 0", "#FORMAT binary"), "is ALTA's binary form"),
        ("10,0,20,30,-1,-1,-1\n", "has no valid measurement among its 1"),
        (CSV.encode() * 100 + b"\0\1\2", "is not text"),
        (b"\xff\xfe" + CSV.encode("utf-16-le") + b"\0\xd8", "begins as utf-16 text and does not go on"),
        ("theta_i,phi_i,theta_o,phi_o,R,G,B\n" + "1" * (1 << 21) + "\n", "line 2 has 2097152 characters"),
        ("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 12\n", "is a git-lfs pointer, not the data"),
        ("analytic\n::begin parameters\nfloat m 0 1 .1\n", "line 2: parameters never ends"),
    ],
)
def test_fault_5_wrong_files_are_refused_in_a_sentence(tmp_path: Path, content: str | bytes, problem: str) -> None:
    with pytest.raises(InputError, match=problem):
        read_measurement(write(tmp_path, content))
