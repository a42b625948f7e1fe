"""Directions of brushing: read, written, and the frames of anisotropic BRDFs that follow from them."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lightarc
from engine.core.directions import frames_along, normalize
from engine.core.errors import UsageError
from engine.geometry.backs import with_backs
from engine.geometry.brushing import Brushing, parse_brushing
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.transport.baking.file import mesh_fingerprint, open_transport

SPHERE = shape("sphere")

#: An anisotropic BRDF, and the same with its axes exchanged.
ALONG, ACROSS = "ward:alpha_x=0.1,alpha_y=0.4", "ward:alpha_x=0.4,alpha_y=0.1"


@given(
    st.none() | st.tuples(*[st.floats(-1e3, 1e3).map(lambda x: float(f"{x:.6g}"))] * 3).filter(any),
    st.floats(-360.0, 360.0).map(lambda x: float(f"{x:.6g}")),
)
def test_a_direction_is_read_as_it_was_written(along: tuple[float, float, float] | None, angle_deg: float) -> None:
    assert parse_brushing(str(Brushing(along, angle_deg))) == Brushing(along, angle_deg)


@pytest.mark.parametrize(
    "text", ["", "w", "0,0,0", "1,2", "1,2,3,4", "nan,0,0", "inf,0,1", "x:", "y:a", "u:400", "u:nan"]
)
def test_what_is_no_direction_is_refused(text: str) -> None:
    if text == "x:":
        assert parse_brushing(text) == Brushing((1.0, 0.0, 0.0))
        return
    with pytest.raises(UsageError, match=r"brushing|angle_deg"):
        parse_brushing(text)


def tangents(mesh: Mesh) -> np.ndarray:
    """The first axes of the frames that renderers make of the tangents of `mesh`."""
    return frames_along(normalize(mesh.normals), mesh.tangents)[..., 0]


def test_a_constant_vector_is_projected_into_the_surface() -> None:
    normal = normalize(SPHERE.normals)
    up = np.array([0.0, 1.0, 0.0])
    away = np.abs(normal[:, 1]) < 0.999
    expected = normalize(up - normal[:, 1:2] * normal)  # Kautz et al. 2002, Sec. 6
    found = tangents(SPHERE.brush(parse_brushing("0,5,0")))
    assert np.allclose(found[away], expected[away], atol=1e-5)
    assert np.isfinite(found).all()
    rotated = tangents(SPHERE.brush(parse_brushing("y:90")))
    assert np.allclose(rotated[away], np.cross(normal, expected)[away], atol=1e-5)


def test_an_angle_rotates_anticlockwise_seen_from_outside() -> None:
    square = shape("plane")
    assert np.allclose(tangents(square), [1.0, 0.0, 0.0], atol=1e-6)
    assert np.allclose(tangents(square.brush(parse_brushing("u:30"))), [np.sqrt(0.75), 0.5, 0.0], atol=1e-6)


def test_a_quarter_turn_exchanges_the_axes_of_a_brdf() -> None:
    size = (48, 36)
    plain = lightarc.render("torus-knot", brdf=ALONG, size=size, samples=1)
    rotated = lightarc.render("torus-knot", brdf=ACROSS, brushing="u:90", size=size, samples=1)
    other = lightarc.render("torus-knot", brdf=ACROSS, size=size, samples=1)
    assert np.abs(plain - rotated).max() < 2e-3 * plain[..., :3].max()
    assert np.abs(plain - other).max() > 0.05


def test_a_bake_keeps_the_direction_of_its_model(tmp_path: Path) -> None:
    square = with_backs(shape("plane").brush(parse_brushing("x:20")))
    for brushing, name in ((None, "texture"), ("x:20", "brushed")):
        path = tmp_path / f"{name}.transport"
        lightarc.bake("plane", "ward:alpha_x=0.2,alpha_y=0.5", path, method="sh", order=3, brushing=brushing)
    found = open_transport(tmp_path / "brushed.transport", square).mesh
    assert found.brushing == Brushing((1.0, 0.0, 0.0), 20.0)
    assert np.array_equal(found.tangents, square.tangents)
    assert open_transport(tmp_path / "texture.transport").mesh.brushing == Brushing()
    assert b'"brushing"' not in (tmp_path / "texture.transport").read_bytes()[:4096]
    assert mesh_fingerprint(square) != mesh_fingerprint(shape("plane"))
