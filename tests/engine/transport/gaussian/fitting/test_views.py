"""The 92 views: where they lie, and which three are around a direction."""

from __future__ import annotations

import numpy as np

from engine.transport.gaussian.fitting.views import (
    TRIANGLES,
    VIEWS,
    nearest_views,
    view_directions,
    view_neighbours,
    view_tables,
    view_triangles,
)

#: The unit roundoff of float64.
U = 2.0**-53


def blend(index: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """The directions that the views make with these weights."""
    towards = (weight[..., None] * view_directions()[index]).sum(axis=-2)
    return towards / np.linalg.norm(towards, axis=-1)[..., None]


def test_G12_the_views_are_92_distinct_ones_as_symmetric_as_an_icosahedron() -> None:
    views = view_directions()
    assert views.shape == (VIEWS, 3) == (92, 3)
    assert np.abs(np.linalg.norm(views, axis=1) - 1.0).max() <= 2 * U
    cosine = views @ views.T
    np.fill_diagonal(cosine, -1.0)
    assert np.degrees(np.arccos(cosine.max())) > 20.0
    assert np.linalg.norm(views.sum(axis=0)) <= 1e-14
    second = views.T @ views / VIEWS  # the only symmetric matrix that an icosahedron leaves alone
    np.testing.assert_allclose(second, np.eye(3) / 3.0, atol=1e-15)
    # a fifth of a turn about a corner brings the views onto themselves
    neighbours, count = view_neighbours()
    axis = views[np.flatnonzero(count == 5)[0]]
    angle, cross = 2.0 * np.pi / 5.0, np.cross(np.eye(3), -axis)
    turn = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    nearest = (views @ turn.T @ views.T).max(axis=1)
    assert np.abs(nearest - 1.0).max() <= 1e-14
    assert sorted(set(count.tolist())) == [5, 6]
    assert (count == 5).sum() == 12
    assert ((neighbours >= 0).sum(axis=1) == count).all()


def test_G12_the_triangles_tile_the_sphere() -> None:
    corners = view_directions()[view_triangles()]
    assert corners.shape == (TRIANGLES, 3, 3) == (180, 3, 3)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    volume = np.einsum("fi,fi->f", a, np.cross(b, c))
    assert volume.min() > 0.0  # counter-clockwise from outside
    # van Oosterom and Strackee 1983: the solid angles of triangles that neither overlap nor leave gaps add up
    sides = 1.0 + (a * b).sum(axis=1) + (b * c).sum(axis=1) + (c * a).sum(axis=1)
    assert abs(2.0 * np.arctan2(volume, sides).sum() - 4.0 * np.pi) <= 1e-12


def test_G12_a_view_is_reproduced_exactly() -> None:
    index, weight = nearest_views(view_directions())
    at = weight.argmax(axis=1)
    assert (index[np.arange(VIEWS), at] == np.arange(VIEWS)).all()
    assert np.abs(np.sort(weight, axis=1) - (0.0, 0.0, 1.0)).max() <= 4 * U


def test_G12_every_direction_lies_in_a_triangle() -> None:
    random = np.random.default_rng(3).normal(size=(1_000_000, 3))
    random /= np.linalg.norm(random, axis=1)[:, None]
    corners = view_directions()[view_triangles()]
    middles = (corners + np.roll(corners, 1, axis=1)).reshape(-1, 3)
    centres = corners.sum(axis=1)
    for directions in (random, view_directions(), middles, centres, np.eye(3), -np.eye(3)):
        index, weight = nearest_views(directions)
        assert weight.min() >= 0.0
        assert np.abs(weight.sum(axis=1) - 1.0).max() <= 4 * U
        unit = directions / np.linalg.norm(directions, axis=1)[:, None]
        assert np.abs(blend(index, weight) - unit).max() <= 1e-14
    index, weight = nearest_views(middles)
    assert np.abs(weight.min(axis=1)).max() <= 1e-14


def test_weights_are_continuous_across_edges_and_do_not_depend_on_length() -> None:
    corners = view_directions()[view_triangles()]
    middles = (corners + np.roll(corners, 1, axis=1)).reshape(-1, 3)
    across = 1e-7 * np.random.default_rng(4).normal(size=middles.shape)
    dense = np.zeros((2, len(middles), VIEWS))
    for k, sign in enumerate((1.0, -1.0)):
        index, weight = nearest_views(3.0 * (middles + sign * across))
        np.put_along_axis(dense[k], index, weight, axis=1)
    assert np.abs(dense[0] - dense[1]).max() <= 1e-5


def test_the_tables_for_shaders_give_the_same_views() -> None:
    """The four steps of `ViewTables`, as a shader takes them, in float32."""
    tables = view_tables()
    random = np.random.default_rng(5).normal(size=(2000, 3)).astype(np.float32)
    index, weight = nearest_views(random)
    for direction, views, shares in zip(random, index, weight, strict=True):
        face = int(np.argmax(tables.centres.astype(np.float32) @ direction))
        a, b, c = tables.face_inverse[face].astype(np.float32) @ direction
        a, b = 3.0 * a / (a + b + c), 3.0 * b / (a + b + c)
        i = min(int(max(a, 0.0)), 2)
        j = min(int(max(b, 0.0)), 2 - i)
        found = tables.triangle[face, i, j, int((a - i) + (b - j) > 1.0 and i + j < 2)]
        own = np.maximum(tables.inverse[found].astype(np.float32) @ direction, 0.0)
        dense = np.zeros((2, VIEWS))
        dense[0, tables.corners[found]], dense[1, views] = own / own.sum(), shares
        assert np.abs(dense[0] - dense[1]).max() <= 1e-5
