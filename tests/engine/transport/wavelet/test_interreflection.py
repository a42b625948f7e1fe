"""Bounces in wavelets: a furnace, glossy light against the reference, lamps, and bakes that go on."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.mesh import Mesh
from engine.light.lamps import Lamp
from engine.transport.baking.blend import Mixture
from engine.transport.baking.file import open_transport
from engine.transport.wavelet.bake import BakeSettings, Work, bake, prepare, transport_of
from engine.transport.wavelet.lighting import Lighting, dark, lamp_tuples, tuples
from engine.transport.wavelet.quantise import encode_light
from engine.transport.wavelet.relight import Relighter
from engine.transport.wavelet.transfer import relight_transport

SETTINGS = BakeSettings(16, 96, 4, bounces=12, gather=512)


def corner(cells: int = 6) -> Mesh:
    """The corner of a room: three unit squares that face each other, with vertices of their own."""
    along = np.linspace(0.0, 1.0, cells + 1)
    u, v = (each.ravel() for each in np.meshgrid(along, along, indexing="ij"))
    number = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    square = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    positions, normals, faces = [], [], []
    for axis in range(3):
        place = np.zeros((len(u), 3))
        place[:, (axis + 1) % 3], place[:, (axis + 2) % 3] = u, v
        positions.append(place)
        normals.append(np.broadcast_to(np.eye(3, dtype=np.float32)[axis], place.shape))
        faces.append(square + axis * len(u))
    uv = np.tile(np.stack([u, v], -1), (3, 1)).astype(np.float32)
    return Mesh(
        np.concatenate(positions), np.concatenate(normals), uv, np.concatenate(faces).astype(np.int32), "corner"
    )


def diffuse(albedo: float) -> SeparableFactors:
    hemisphere_map = HemisphereMap("orthographic", 4)
    even = np.full((1, 4, 4, 3), math.sqrt(albedo / math.pi), np.float32)
    return SeparableFactors(hemisphere_map, "in-out", even, even, isotropic=True, reciprocal=True, name="even")


@pytest.fixture(scope="module")
def white(tmp_path_factory: pytest.TempPathFactory) -> tuple[Work, Path]:
    """A corner that reflects everything, and its bake."""
    work, path = prepare(corner(), diffuse(1.0), SETTINGS), tmp_path_factory.mktemp("white") / "white.transport"
    drain(bake(path, work))
    return work, path


def test_a_white_corner_under_even_light_cannot_be_seen(white: tuple[Work, Path]) -> None:
    work, path = white
    transport = transport_of(open_transport(path))
    light, reflects = encode_light(np.ones((6, 16, 16, 3))), math.sqrt(1.0 / math.pi)
    direct = relight_transport(transport, light) * reflects
    whole = tuples(transport, Lighting(light)) * reflects
    edges = (work.surface.positions == 0.0).sum(axis=1) > 1  # half of what lies at the seam sees a wall from inside it
    assert direct[~edges].min() < 0.8
    np.testing.assert_allclose(whole[~edges], 1.0, atol=0.04)
    assert abs(whole[~edges].mean() - 1.0) < 0.01


def test_the_light_of_a_lamp_is_reflected_too(tmp_path: Path) -> None:
    """A lamp on the diagonal of a corner lights its sides alike, and each gets what the others send by their share."""
    drain(
        bake(tmp_path / "a.transport", prepare(corner(), diffuse(1.0), replace(SETTINGS, bounces=1, coefficients=384)))
    )
    transport = transport_of(open_transport(tmp_path / "a.transport"))
    lamp = dark(16, (Lamp((math.sqrt(1.0 / 3.0),) * 3, (1.0, 2.0, 4.0)),))
    rows = lamp_tuples(transport, lamp.directional)
    np.testing.assert_array_equal(rows, Relighter(transport).tuples(lamp))
    rows -= lamp_tuples(replace(transport, bounces=None), lamp.directional)
    place = transport.mesh.positions
    wall = np.flatnonzero((transport.mesh.normals[:, 0] == 1.0) & (place[:, 1] > 0.0) & (place[:, 2] > 0.0))
    sent = np.array([1.0, 2.0, 4.0]) / math.sqrt(3.0 * math.pi)
    shares = [_share_of_floor(y, z) + _share_of_floor(z, y) for _, y, z in place[wall]]
    expected = np.array(shares)[:, None] * sent
    np.testing.assert_allclose(rows[wall].sum(axis=0), expected.sum(axis=0), rtol=0.03)
    np.testing.assert_allclose(rows[wall], expected, atol=0.05 * sent.max())


def _share_of_floor(height: float, across: float, cells: int = 400) -> float:
    """The share that a unit square has of the view, times cosine, of a place on a wall at its side."""
    centres = (np.arange(cells) + 0.5) / cells
    x, z = np.meshgrid(centres, centres - across)
    squared = x * x + height * height + z * z
    return float((x * height / (math.pi * squared * squared)).sum() / cells**2)


def test_an_interrupted_bake_goes_on_with_its_bounces(white: tuple[Work, Path], tmp_path: Path) -> None:
    work, path = white
    steps = bake(tmp_path / "again.transport", work)
    for step in steps:
        if step.note.startswith("following"):
            break
    steps.close()
    baked = drain(bake(tmp_path / "again.transport", work))
    assert baked.resumed_chunks == baked.chunks / 2
    assert (tmp_path / "again.transport").read_bytes() == path.read_bytes()


def test_bounces_belong_to_one_brdf(white: tuple[Work, Path]) -> None:
    mixture = Mixture((1,), np.ones((len(white[0].surface.positions), 1), np.float32))
    with pytest.raises(UsageError, match="one BRDF"):
        prepare(corner(), diffuse(0.5), SETTINGS, None, mixture)
