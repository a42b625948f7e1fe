"""Simplified occluders: what they change and what they must not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.geometry.ray_caster import RayCaster
from engine.geometry.shapes import open_mesh, sphere
from engine.transport.baking.occluder import Occluder, occluder_error, simplify


def test_the_model_itself_is_no_change(shared_data: Callable[[str], Path]) -> None:
    mesh = open_mesh(str(shared_data("mesh/classic/suzanne.obj")))
    found = occluder_error(mesh, Occluder(RayCaster(mesh.positions, mesh.faces)), 16, np.arange(0, 900, 50))
    assert (found.open_rms, found.faces) == (0.0, len(mesh.faces))


def test_finer_grids_leave_more_triangles_and_a_smaller_error(shared_data: Callable[[str], Path]) -> None:
    mesh = open_mesh(str(shared_data("mesh/classic/spot.obj")))
    vertices = np.arange(0, len(mesh.positions), 40)
    found = [occluder_error(mesh, simplify(mesh, cells), 16, vertices) for cells in (12, 48, 400)]
    assert found[0].faces < 0.2 * len(mesh.faces)
    assert found[0].faces < found[1].faces <= found[2].faces <= len(mesh.faces)
    assert found[0].open_rms > found[1].open_rms > found[2].open_rms
    assert found[2].open_rms < 0.02


def test_a_convex_model_does_not_shade_itself() -> None:
    mesh = sphere()
    found = occluder_error(mesh, simplify(mesh, 30), 16, np.arange(0, len(mesh.positions), 500))
    assert found.open_rms < 0.005


@pytest.mark.parametrize("cells", [0, 7, 5000])
def test_grids_out_of_range_are_refused(cells: int) -> None:
    with pytest.raises(ValueError, match="cells"):
        simplify(sphere(), cells)
