"""Numbers and colours at vertices: positions, images at texture coordinates, and the parameters that they move."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.brdf.brdf import brdf_from_text
from engine.core.colour import srgb_decode
from engine.core.errors import InputError
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.images.encode import encode_png, rgb_channels, write_exr
from engine.transport.baking.spatially_varying import (
    Variation,
    check_variations,
    variation_from_text,
    variation_to_text,
    vary_brdf,
    vertex_colours,
    vertex_values,
)


def strip(uv: list[tuple[float, float]]) -> Mesh:
    """Vertices at the texture coordinates `uv`, of triangles that fan out."""
    count = len(uv)
    angle = np.linspace(0.0, 2.0, count)
    positions = np.stack([np.cos(angle), np.sin(angle), np.zeros(count)], axis=-1)
    faces = np.array([[0, k, k + 1] for k in range(1, count - 1)], np.int32)
    normals = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (count, 1))
    return Mesh(positions, normals, np.array(uv, np.float32), faces, "strip")


@pytest.fixture
def checks(tmp_path: Path) -> Path:
    """2 × 2 pixels of codes 0, 51 over 102, 255: row 0 on top."""
    codes = np.array([[0, 51], [102, 255]], np.uint8)
    path = tmp_path / "checks.png"
    path.write_bytes(encode_png(np.repeat(codes[..., None], 3, axis=2)))
    return path


@pytest.mark.parametrize(("axis", "number"), [("x", 0), ("y", 1), ("z", 2)])
def test_an_axis_runs_from_0_to_1_across_the_bounding_box(axis: str, number: int) -> None:
    mesh = shape("torus-knot")
    values = vertex_values(mesh, axis)
    along = mesh.positions[:, number]
    assert (values.min(), values.max()) == (0.0, 1.0)
    np.testing.assert_allclose(values, (along - along.min()) / np.ptp(along), atol=1e-15)


def test_a_model_without_extent_along_an_axis_is_0_there() -> None:
    np.testing.assert_array_equal(vertex_values(shape("plane"), "z"), 0.0)


def test_centres_of_pixels_show_the_codes_as_they_are_stored_and_v_points_up(checks: Path) -> None:
    mesh = strip([(0.25, 0.75), (0.75, 0.75), (0.25, 0.25), (0.75, 0.25)])
    np.testing.assert_allclose(vertex_values(mesh, checks), np.array([0, 51, 102, 255]) / 255.0, atol=1e-7)


def test_between_pixels_values_are_bilinear_and_beyond_the_edges_the_image_repeats(checks: Path) -> None:
    mesh = strip([(0.5, 0.75), (0.25, 0.5), (0.5, 0.5), (0.0, 0.75), (1.0, 0.75), (7.5, -3.25), (-0.75, 5.75)])
    expected = np.array([25.5, 51.0, 102.0, 25.5, 25.5, 25.5, 0.0]) / 255.0
    np.testing.assert_allclose(vertex_values(mesh, checks), expected, atol=1e-6)


def test_colours_are_decoded_and_numbers_are_not(checks: Path) -> None:
    mesh = strip([(0.75, 0.75), (0.25, 0.25), (0.75, 0.25)])
    colours = vertex_colours(mesh, str(checks))
    np.testing.assert_allclose(
        colours, np.repeat(srgb_decode(np.array([51, 102, 255]) / 255.0)[:, None], 3, 1), atol=1e-6
    )
    assert (colours.shape, colours.dtype) == ((3, 3), np.float64)


def test_values_outside_0_to_1_are_clipped(tmp_path: Path) -> None:
    pixels = np.full((2, 2, 3), 7.0, np.float32)
    pixels[0] = -1.0
    write_exr(tmp_path / "wide.exr", rgb_channels(pixels))
    mesh = strip([(0.25, 0.75), (0.75, 0.25), (0.5, 0.25)])
    np.testing.assert_array_equal(vertex_values(mesh, tmp_path / "wide.exr"), [0.0, 1.0, 1.0])
    np.testing.assert_array_equal(vertex_colours(mesh, tmp_path / "wide.exr")[0], 0.0)


def test_what_is_no_image_is_refused(tmp_path: Path) -> None:
    (tmp_path / "words.png").write_text("no image")
    for name in ("words.png", "absent.png", "w"):
        with pytest.raises(InputError):
            vertex_values(shape("plane"), tmp_path / name)


@given(
    st.sampled_from(["alpha", "nu"]),
    st.floats(-1e9, 1e9),
    st.floats(-1e9, 1e9),
    st.sampled_from(["x", "map.png", "C:/maps/a.png"]),
)
def test_a_variation_becomes_text_and_back(name: str, start: float, stop: float, source: str) -> None:
    variation = Variation(name, start, stop, source)
    assert variation_from_text(variation_to_text(variation)) == variation


@pytest.mark.parametrize("text", ["", "alpha", "alpha=1", "alpha=1:2", "alpha=a:2:x", "=1:2:x", "a=1:2:", "a=nan:2:x"])
def test_other_texts_are_refused_with_the_form(text: str) -> None:
    with pytest.raises(ValueError, match="PARAMETER=FROM:TO:SOURCE"):
        variation_from_text(text)


def test_ends_are_exact_and_the_last_variation_runs_fastest() -> None:
    brdf = brdf_from_text("ggx:kd=0.5,alpha=0.3,f0=0.04")
    variations = (Variation("alpha", 0.1, 0.7, "x"), Variation("kd", 0.9, 0.3, "y"))
    grid = vary_brdf(brdf, variations, [[0.0, 1.0], [0.0, 0.5, 1.0]])
    assert [(b.alpha, b.kd) for b in grid] == [  # type: ignore[attr-defined]
        (alpha, (kd,) * 3) for alpha in (0.1, 0.7) for kd in (0.9, 0.5 * 0.9 + 0.5 * 0.3, 0.3)
    ]


@pytest.mark.parametrize(
    ("variations", "reason"),
    [
        ([Variation("gloss", 0.0, 1.0, "x")], "no parameter 'gloss'; it has"),
        ([Variation("alpha", 0.1, 7.0, "x")], "alpha = 7 is outside"),
        ([Variation("alpha", 0.1, 0.2, "x"), Variation("alpha", 0.1, 0.2, "y")], "twice"),
    ],
)
def test_what_a_brdf_does_not_have_is_refused(variations: list[Variation], reason: str) -> None:
    with pytest.raises(ValueError, match=reason):
        check_variations(brdf_from_text("ggx:alpha=0.3"), variations)


def test_measured_brdfs_have_nothing_to_vary() -> None:
    class Measured:
        isotropic = reciprocal = energy_conserving = True

    with pytest.raises(ValueError, match="only analytic models"):
        check_variations(Measured(), [Variation("alpha", 0.1, 0.2, "x")])  # type: ignore[arg-type]
    assert check_variations(Measured(), []) == ()  # type: ignore[arg-type]
