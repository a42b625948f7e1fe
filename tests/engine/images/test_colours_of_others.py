"""Colours against the library colour-science: differences, L*a*b*, spaces and references of the chart."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.capture.chart.reference import LAB, NAMES
from engine.core.colour import REC_2020, WORKING_SPACES, WorkingSpace
from engine.core.colour_difference import delta_e_2000, lab_from_xyz
from engine.core.errors import InputError
from engine.images.colour_space import ADOBE_RGB, BT709_CURVE, D50, P3, SRGB_CURVE, from_chromaticities
from engine.images.decode import read_image
from engine.images.encode import rgb_channels, write_exr

RNG = np.random.default_rng(2000)


@pytest.fixture(scope="module")
def colour() -> Any:
    """The library, which takes 2 s to load: not while tests are collected, which each worker does."""
    return pytest.importorskip("colour", reason="colour-science is the independent reference")


def test_differences_of_random_colours(colour: Any) -> None:
    one = RNG.uniform((0, -100, -100), (100, 100, 100), (5000, 3))
    other = one + RNG.normal(0, (4, 8, 8), one.shape) * RNG.choice([0.1, 1.0, 5.0], (5000, 1))
    np.testing.assert_allclose(delta_e_2000(one, other), colour.delta_E(one, other, method="CIE 2000"), atol=1e-9)


def test_lightness_and_chroma_under_d50(colour: Any) -> None:
    xyz = RNG.uniform(0, 1, (1000, 3)) * D50
    white = colour.XYZ_to_xy(D50)
    np.testing.assert_allclose(lab_from_xyz(xyz), colour.XYZ_to_Lab(xyz, white), atol=1e-6)


@pytest.mark.parametrize(
    ("name", "matrix"),
    [
        ("Adobe RGB (1998)", ADOBE_RGB.matrix),
        ("ITU-R BT.2020", from_chromaticities(REC_2020.chromaticities)),
        ("Display P3", from_chromaticities((*P3, 0.3127, 0.3290))),
        ("ProPhoto RGB", from_chromaticities((0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001, 0.3457, 0.3585))),
    ],
)
def test_matrices_of_spaces(colour: Any, name: str, matrix: Any) -> None:
    """With Bradford's adaptation, to the digits to which standards round their whites."""
    source, target = colour.RGB_COLOURSPACES[name], colour.RGB_COLOURSPACES["sRGB"]
    wanted = colour.matrix_RGB_to_RGB(source, target, chromatic_adaptation_transform="Bradford")
    np.testing.assert_allclose(matrix, wanted, atol=5e-4)
    np.testing.assert_allclose(matrix.sum(axis=1), 1.0, atol=1e-6)


def test_curves_of_spaces(colour: Any) -> None:
    """But at 0.081, where the two branches of BT.709 do not meet."""
    codes = np.delete(np.linspace(0, 1, 1001), 81)
    np.testing.assert_allclose(SRGB_CURVE.linear(codes), colour.models.eotf_sRGB(codes), atol=2e-6)
    np.testing.assert_allclose(BT709_CURVE.linear(codes), colour.models.oetf_inverse_BT709(codes), atol=2e-5)


def test_references_of_the_chart(colour: Any) -> None:
    chart = colour.CCS_COLOURCHECKERS["ColorChecker24 - After November 2014"]
    wanted = [colour.XYZ_to_Lab(colour.xyY_to_XYZ(xyy), chart.illuminant) for xyy in chart.data.values()]
    assert len(NAMES) == len(wanted)
    assert np.max(delta_e_2000(LAB, np.array(wanted))) < 0.05


@pytest.mark.parametrize(("space", "name"), list(zip(WORKING_SPACES, ("sRGB", "ITU-R BT.2020", "ACEScg"), strict=True)))
def test_working_spaces(colour: Any, space: WorkingSpace, name: str, tmp_path: Path) -> None:
    """Their matrices, and images in OpenEXR that state their primaries."""
    source, target = colour.RGB_COLOURSPACES[name], colour.RGB_COLOURSPACES["sRGB"]
    wanted = colour.matrix_RGB_to_RGB(source, target, chromatic_adaptation_transform="Bradford")
    np.testing.assert_allclose(space.to_rec709, wanted, atol=3e-4)
    image = RNG.uniform(0, 1, (5, 7, 3)).astype(np.float32)
    write_exr(tmp_path / "image.exr", rgb_channels(image), half=False, space=space)
    found = read_image(tmp_path / "image.exr")
    np.testing.assert_allclose(found.pixels, image @ wanted.T, atol=1e-3)
    assert (found.profile, found.warnings) == ("" if name == "sRGB" else space.label, ())


def test_primaries_of_openexr_that_no_colour_has_are_refused(tmp_path: Path) -> None:
    image = RNG.uniform(0, 1, (5, 7, 3)).astype(np.float32)
    flat = WorkingSpace("flat", "flat", (0.3, 0.3, 0.3, 0.3, 0.3, 0.3, 0.3127, 0.3290))
    write_exr(tmp_path / "image.exr", rgb_channels(image), space=flat)
    with pytest.raises(InputError, match="primaries without extent"):
        read_image(tmp_path / "image.exr")
