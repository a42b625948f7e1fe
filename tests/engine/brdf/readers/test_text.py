"""Measured files as other programs write them: one list of samples in many dresses reads as the same numbers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.brdf.readers import alta, cornell, csv_samples, curet
from engine.brdf.readers.read import read_measurement
from engine.brdf.readers.samples_child import read_directions
from engine.core.colour import XYZ_FROM_SRGB
from engine.core.directions import surface_direction
from engine.core.errors import InputError

RNG = np.random.default_rng(5)
DEGREES = RNG.random((7, 4)) * (80.0, 360.0, 80.0, 360.0)
RADIANS = np.radians(DEGREES)
RGB = RNG.random((7, 3)) + 0.1
GREY = RGB[:, :1]
NM = np.arange(400.0, 701.0, 50.0)
NAMES = "theta_i,phi_i,theta_o,phi_o,R,G,B"
EXCHANGED = "theta_o,phi_o,theta_i,phi_i,R,G,B"
ASTM_ANGLES = "theta_i,phi_i,theta_s,phi_s"


def rows(*columns: np.ndarray, separator: str = ",", end: str = "") -> str:
    return "\n".join(separator.join(repr(float(x)) for x in row) + end for row in np.hstack(columns)) + "\n"


def fortran(*columns: np.ndarray) -> str:
    return "\n".join(",".join(f"{x:.17E}".replace("E", "D") for x in row) for row in np.hstack(columns))


def spectra() -> np.ndarray:
    return np.repeat(GREY, len(NM), axis=1)


def bands(separator: str, unit: str) -> str:
    return separator.join(f"{nm:g}{unit}" for nm in NM)


CSV = {
    "named in a comment, as numpy.savetxt does": f"# {EXCHANGED}\n" + rows(DEGREES[:, [2, 3, 0, 1]], RGB),
    "comments before and after the names": f"# by hand\n\n# {EXCHANGED}\n# end\n" + rows(DEGREES[:, [2, 3, 0, 1]], RGB),
    "words": "Theta In (deg),Phi In (deg),Theta Out (deg),Phi Out (deg),Red,Green,Blue\n" + rows(DEGREES, RGB),
    "channels of a BRDF": "theta_i,phi_i,theta_r,phi_r,brdf_r,brdf_g,brdf_b\n" + rows(DEGREES, RGB),
    "units of values": "theta_i,phi_i,theta_o,phi_o,R [1/sr],G [1/sr],B [1/sr]\n" + rows(DEGREES, RGB),
    "tristimulus values": "theta_i,phi_i,theta_o,phi_o,X,Y,Z\n" + rows(DEGREES, RGB @ XYZ_FROM_SRGB.T),
    "a comma behind every row": NAMES + ",\n" + rows(DEGREES, RGB, end=","),
    "a comma behind the rows alone": NAMES + "\n" + rows(DEGREES, RGB, end=","),
    "Fortran's exponents": fortran(DEGREES, RGB),
}
OTHERS = {
    "long.astm": "REMARK a long story\n" * 500 + f"VARS {ASTM_ANGLES},R,G,B\n" + rows(RADIANS, RGB),
    "words.astm": f"VARS {ASTM_ANGLES},red,green,blue\n" + rows(RADIANS, RGB),
    "xyz.astm": f"VARS {ASTM_ANGLES},X,Y,Z\n" + rows(RADIANS, RGB @ XYZ_FROM_SRGB.T),
    "blanks.astm": f"VARS {ASTM_ANGLES},R,G,B\n" + rows(RADIANS, RGB, separator="  "),
}
SPECTRA = {
    "blanks.astm": f"VARS {ASTM_ANGLES},{bands(',', 'nm')}\n" + rows(RADIANS, spectra(), separator=" "),
    "comments.brdf": "# a long story\n" * 500
    + f"{len(NM)}\n{bands(' ', '')}\n"
    + rows(RADIANS, spectra(), separator=" "),
    "one_line.brdf": f"{len(NM)} {bands(' ', '')}\n" + rows(RADIANS, spectra(), separator=" "),
}


def check(path: Path, text: str, values: np.ndarray) -> None:
    path.write_text(text)
    samples = read_measurement(path)
    np.testing.assert_allclose(samples.wi, surface_direction(RADIANS[:, 0], RADIANS[:, 1]), atol=1e-15)
    np.testing.assert_allclose(samples.wo, surface_direction(RADIANS[:, 2], RADIANS[:, 3]), atol=1e-15)
    np.testing.assert_allclose(samples.value, np.broadcast_to(values, (7, 3)), rtol=1e-12)
    assert samples.invalid_samples == 0


@pytest.mark.parametrize("dress", CSV)
def test_csv_of_other_programs(tmp_path: Path, dress: str) -> None:
    check(tmp_path / "a.csv", CSV[dress], RGB)


@pytest.mark.parametrize("name", OTHERS)
def test_astm_of_other_programs(tmp_path: Path, name: str) -> None:
    check(tmp_path / name, OTHERS[name], RGB)


@pytest.mark.parametrize("name", SPECTRA)
def test_flat_spectra_are_grey_in_every_spelling(tmp_path: Path, name: str) -> None:
    check(tmp_path / name, SPECTRA[name], GREY)


def test_a_head_that_ends_within_a_wavelength_is_still_recognised(tmp_path: Path) -> None:
    """Thousands of wavelengths are longer than what is looked at."""
    nm = np.linspace(380.0, 780.0, 4000)
    text = f"{len(nm)}\n" + " ".join(f"{x:.16f}" for x in nm) + "\n" + "0.1 0.2 0.3 0.4 " + "0.25 " * len(nm) + "\n"
    for pad in range(20):
        path = tmp_path / f"{pad}.brdf"
        path.write_text("#" + "x" * pad + "\n" + text)
        np.testing.assert_allclose(read_measurement(path).value, 0.25, rtol=1e-12)


def test_names_in_a_comment_that_do_not_fit_the_data_are_a_comment(tmp_path: Path) -> None:
    text = f"# {EXCHANGED},sigma\n" + rows(DEGREES, RGB)
    check(tmp_path / "a.csv", text, RGB)


def test_directions_take_names_from_a_comment(tmp_path: Path) -> None:
    path = tmp_path / "directions.csv"
    path.write_text("# theta_o,phi_o,theta_i,phi_i\n" + rows(DEGREES[:, [2, 3, 0, 1]]))
    np.testing.assert_allclose(read_directions(path)[0], surface_direction(RADIANS[:, 0], RADIANS[:, 1]), atol=1e-15)


@pytest.mark.parametrize("word", ["1D", "D5", "1D5.5", "1DD5", "1_0D2"])
def test_what_only_looks_like_fortran_is_refused(tmp_path: Path, word: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(f"{NAMES}\n{word},0,0,0,1,1,1\n")
    with pytest.raises(InputError, match="where a number is needed"):
        read_measurement(path)


def test_a_column_that_counts_rows_is_not_taken_for_angles(tmp_path: Path) -> None:
    path = tmp_path / "table.txt"
    path.write_text("".join(f"{row + 1} 0.1 0.2 0.3 0.4\n" for row in range(205)))
    with pytest.raises(InputError, match="counts the rows"):
        read_measurement(path)
    path.write_text("".join(f"{row + 1} 10 20 30 0.4\n" for row in (0, 1, 2, 3, 5)))
    assert read_measurement(path).samples == 5


def test_text_is_read_in_the_decoder_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Spec 15, S16: what a stranger wrote is taken apart where nothing else can be reached."""
    (tmp_path / "table.txt").write_text("\n".join(f"0.1 0 0.{n % 8} 0" for n in range(205)))
    for letter in "rgb":
        (tmp_path / f"{letter}brdf.dat").write_text("17 " + " ".join(["0.25"] * 205))
    for module in (alta, cornell, csv_samples, curet):
        monkeypatch.setattr(module, "read_lines", lambda path: pytest.fail(f"{path} was read in this process"))
    assert read_measurement(tmp_path / "rbrdf.dat#17").value.shape == (205, 3)
    (tmp_path / "directions.csv").write_text("10,0,20,0\n")
    assert read_directions(tmp_path / "directions.csv")[1].shape == (1, 3)
    (tmp_path / "table.txt").write_text("0.1 0 0.2\n")
    with pytest.raises(InputError, match="line 1 has 3 values") as caught:
        read_measurement(tmp_path / "rbrdf.dat")
    assert caught.value.path == str(tmp_path / "table.txt")
