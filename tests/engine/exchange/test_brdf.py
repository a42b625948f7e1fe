"""BRDFs as files: read again by this program, by parsers written here, and by Mitsuba."""

from __future__ import annotations

import dataclasses
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.fit import fit_data
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.readers.merl import SCALE, encode_merl, read_merl, write_merl
from engine.brdf.readers.read import open_brdf, read_measurement
from engine.core.figure_text import percent
from engine.core.steps import drain
from engine.exchange import loss
from engine.exchange.brdf import contents, materialx, rgl
from engine.exchange.loss import ENVIRONMENTS, brdf_shown, environment_lights, sphere
from engine.exchange.subject import Contents, Settings

from .materials import woven_subject

BRDF = "ggx:alpha=0.35,kd=0.3/0.2/0.1"


@pytest.fixture(scope="module")
def made() -> Contents:
    subject = woven_subject()
    material = dataclasses.replace(subject.material, brdf=BRDF)
    return drain(contents(dataclasses.replace(subject, material=material), Settings(), ""))


@pytest.fixture
def folder(made: Contents, tmp_path: Path) -> Path:
    for name, content in made.files.items():
        (tmp_path / name).write_bytes(content)
    return tmp_path


def unit(theta_deg: Any, phi_deg: Any) -> Any:
    theta, phi = np.radians(theta_deg), np.radians(phi_deg)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def test_the_figures_are_those_of_a_sphere_of_the_model(made: Contents) -> None:
    """The nearest model and the BRDF itself, each on a ball, are compared here anew."""
    nearest, wanted = brdf_from_text(made.record["fitted"]), brdf_from_text(BRDF)
    view, errors = sphere(3, 4, loss.DIAMETER), []
    for name in ENVIRONMENTS:
        shown, own = (brdf_shown(each)(view, environment_lights(name)) for each in (nearest, wanted))
        errors.append(np.sqrt(np.sum((shown - own) ** 2) / np.sum(own**2)))
        assert made.record["by_environment"][name]["rmse_rel"] == pytest.approx(errors[-1], rel=1e-5)
    assert made.record["rmse_rel_reference"] == pytest.approx(np.sqrt(np.mean(np.square(errors))), rel=1e-5)
    assert 0.0 < made.record["flip"] < 1.0
    assert made.record["rmse_rel_by_file"]["A_cloth_woven.csv"] == 0.0
    assert "as A_cloth_woven.mtlx shows it" in made.record["errors_are"]


def test_a_plain_parser_reads_the_csv(folder: Path) -> None:
    lines = (folder / "A_cloth_woven.csv").read_text().splitlines()
    assert lines[0] == "theta_i,phi_i,theta_o,phi_o,r,g,b"
    rows = np.array([[float(word) for word in line.split(",")] for line in lines[1:]])
    wanted = brdf_from_text(BRDF).f(unit(rows[:, 0], rows[:, 1]), unit(rows[:, 2], rows[:, 3]))
    np.testing.assert_allclose(rows[:, 4:], wanted, rtol=1e-5)


def test_a_plain_parser_reads_alta(folder: Path) -> None:
    lines = (folder / "A_cloth_woven_alta.dat").read_text().splitlines()
    assert lines[:3] == ["#DIM 6 3", "#PARAM_IN CARTESIAN", "#PARAM_OUT RGB_COLOR"]
    rows = np.array([line.split() for line in lines if not line.startswith("#")], np.float64)
    wanted = brdf_from_text(BRDF).f(rows[:, 3:6], rows[:, :3])
    np.testing.assert_allclose(rows[:, 6:], wanted, rtol=1e-5)


def test_every_file_has_its_error_beside_it(folder: Path, made: Contents) -> None:
    """MERL and CSV have no place for words, ALTA has comments."""
    first, *lines = (folder / "loss.txt").read_text().splitlines()
    assert first == f"{BRDF} alone: the texels of the material are not in these files."
    stated = dict(line.split(": ", 1) for line in lines)
    assert set(stated) == set(made.files) - {"loss.txt"}
    for name, error in made.record["rmse_rel_by_file"].items():
        assert ("exact there" if error == 0.0 else percent(error, 3)) in stated[name]
    pairs = len((folder / "A_cloth_woven.csv").read_text().splitlines()) - 1
    words = f"Values at {pairs} pairs of directions, exact there to nine digits."
    assert words in stated["A_cloth_woven.csv"]
    assert words in (folder / "A_cloth_woven_alta.dat").read_text()


def test_our_readers_read_the_lists(folder: Path) -> None:
    """The BRDF that one of them becomes keeps its samples; the other is only read."""
    some = (folder / "A_cloth_woven.csv").read_text().splitlines(keepends=True)
    (folder / "some.csv").write_text("".join([some[0], *some[1::8]]))
    for data in (
        fit_data(open_brdf(str(folder / "some.csv"))),
        read_measurement(folder / "A_cloth_woven_alta.dat"),
    ):
        np.testing.assert_allclose(data.value, brdf_from_text(BRDF).f(data.wi, data.wo), rtol=1e-5)


def test_merl_is_read_by_the_published_program(folder: Path, made: Contents) -> None:
    """`BRDFRead.cpp` of MERL: indices of theta_half, theta_diff and phi_diff, written here anew."""
    content = (folder / "A_cloth_woven.binary").read_bytes()
    assert struct.unpack("<3i", content[:12]) == (90, 90, 180)
    values = np.frombuffer(content, "<f8", offset=12).reshape(3, 90, 90, 180)
    theta_h, theta_d, phi_d = np.radians(20.0), np.radians(30.0), np.radians(70.0)
    index = (int(np.sqrt(theta_h / (np.pi / 2)) * 90), int(theta_d / (np.pi / 2) * 90), int(phi_d / np.pi * 180))
    half = np.array([np.sin(theta_h), 0.0, np.cos(theta_h)])
    difference = unit(30.0, 70.0)
    turn = np.array([[np.cos(theta_h), 0, np.sin(theta_h)], [0, 1, 0], [-np.sin(theta_h), 0, np.cos(theta_h)]])
    wi = turn @ difference
    wo = 2.0 * (half @ wi) * half - wi
    wanted = brdf_from_text(BRDF).f(wi, wo)
    np.testing.assert_allclose([values[c][index] * SCALE[c] for c in range(3)], wanted, rtol=0.05)
    assert 0.0 < made.record["rmse_rel_by_file"]["A_cloth_woven.binary"] < 0.1


def test_a_merl_table_leaves_byte_for_byte(folder: Path, tmp_path: Path) -> None:
    table = read_merl(folder / "A_cloth_woven.binary")
    assert encode_merl(table) == (folder / "A_cloth_woven.binary").read_bytes()
    write_merl(tmp_path / "again.binary", table)
    assert (tmp_path / "again.binary").read_bytes() == (folder / "A_cloth_woven.binary").read_bytes()
    subject = woven_subject()
    measured = dataclasses.replace(subject, material=dataclasses.replace(subject.material, measured=table))
    again = drain(contents(measured, Settings(), "")).files["A_cloth_woven.binary"]
    assert again == (folder / "A_cloth_woven.binary").read_bytes()


def test_our_reader_of_rgl_reads_the_table(folder: Path, made: Contents) -> None:
    brdf: Any = open_brdf(str(folder / "A_cloth_woven.bsdf"))
    assert brdf.isotropic
    assert 0.0 < made.record["rmse_rel_by_file"]["A_cloth_woven.bsdf"] < 0.02
    wi, wo = unit([10.0, 40.0, 60.0], [0.0, 20.0, 100.0]), unit([30.0, 45.0, 20.0], [180.0, 200.0, 310.0])
    np.testing.assert_allclose(brdf.f(wi, wo), brdf_from_text(BRDF).f(wi, wo), rtol=0.05)


def test_mitsuba_reads_the_table_of_rgl(folder: Path) -> None:
    mi = pytest.importorskip("mitsuba", reason="Mitsuba is not installed")
    if "scalar_rgb" not in mi.variants():
        pytest.skip("this Mitsuba has no variant scalar_rgb")
    mi.set_variant("scalar_rgb")
    plugin = mi.load_dict({"type": "measured", "filename": str(folder / "A_cloth_woven.bsdf")})
    wi, wo = unit(30.0, 0.0), unit(40.0, 165.0)
    interaction = mi.SurfaceInteraction3f()
    interaction.wi = mi.Vector3f(*wi)
    value = np.array(plugin.eval(mi.BSDFContext(), interaction, mi.Vector3f(*wo)))
    np.testing.assert_allclose(value / wo[2], brdf_from_text(BRDF).f(wi, wo), rtol=0.03)


def test_the_fit_states_its_error_and_materialx_finds_it_valid(folder: Path, made: Contents) -> None:
    error = made.record["rmse_rel_by_file"]["A_cloth_woven.mtlx"]
    assert any("nearest metallic-roughness" in warning for warning in made.warnings)
    fitted: Any = brdf_from_text(made.record["fitted"])
    data = fit_data(brdf_from_text(BRDF))
    apart = (fitted.f(data.wi, data.wo) - data.value) * data.wi[:, 2:]
    assert np.sqrt((apart**2).sum() / ((data.value * data.wi[:, 2:]) ** 2).sum()) == pytest.approx(error)
    mx = pytest.importorskip("MaterialX", reason="MaterialX is not installed")
    document = mx.createDocument()
    mx.loadLibraries(mx.getDefaultDataLibraryFolders(), mx.getDefaultDataSearchPath(), document)
    mx.readFromXmlFile(document, str(folder / "A_cloth_woven.mtlx"))
    assert document.validate() == (True, "")
    assert "relative RMSE" in document.getDocString()


def test_constants_of_the_fit_are_those_of_the_document() -> None:
    text = materialx("x", MetallicRoughness((0.1, 0.2, 0.3), 0.25, 0.5, coat_weight=0.6), 0.125).decode()
    assert 'name="clearcoat" type="float" value="0.6"' in text
    assert 'value="0.1, 0.2, 0.3"' in text
    assert 'name="metallic" type="float" value="0.25"' in text
    assert "12.5 %" in text


def test_an_isotropic_table_of_rgl_is_a_table_of_values() -> None:
    brdf = brdf_from_text("lambert:albedo=0.5")
    _, error = rgl(brdf, fit_data(brdf))
    assert error < 0.01
