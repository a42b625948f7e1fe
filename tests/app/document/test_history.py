"""The memory that steps of the undo history keep."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from app.document.document import Project
from app.document.history import count_freed_bytes, steps_to_keep
from engine.geometry.shapes import open_mesh


def test_a_step_gives_up_what_only_the_earlier_state_holds() -> None:
    whole = np.zeros((100, 100), np.float32)
    old = Project(built_from=(whole[:10], whole[50:], {"map": np.zeros(30)}), slices=4)
    assert count_freed_bytes(old, Project()) == whole.nbytes + 240, "a part keeps the whole array, and is counted once"
    assert count_freed_bytes(old, dataclasses.replace(old, slices=5)) == 0
    assert count_freed_bytes(old, dataclasses.replace(old, built_from=(whole,))) == 240
    assert count_freed_bytes(Project(), old) == 0


def test_a_step_gives_up_what_was_worked_out_of_a_model_as_well() -> None:
    mesh = open_mesh("sphere")
    arrays = (mesh.positions, mesh.normals, mesh.uv, mesh.faces, mesh.tangents)
    assert count_freed_bytes(Project(mesh=mesh), Project()) >= sum(array.nbytes for array in arrays)


@pytest.mark.parametrize(
    ("sizes", "kept"),
    [
        ([], 1),
        ([0, 0, 0], 3),
        ([7, 0, 3, 0, 7, 0], 5),
        ([7, 0, 3, 0, 8, 0], 3),
        ([1, 11], 1),
        ([11, 0], 1),
        ([5, 5], 2),
    ],
)
def test_the_latest_steps_are_kept_within_a_bound_and_the_last_always(sizes: list[int], kept: int) -> None:
    assert steps_to_keep(sizes, 10) == kept
