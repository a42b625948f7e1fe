from __future__ import annotations

import dataclasses
import weakref
from typing import Any

import numpy as np

from app.document.document import Project, Step
from app.document.history import KEPT_BYTES
from app.document.open_document import Document
from engine.core.errors import InputError


def move_light(document: Document, phi_deg: float) -> None:
    look = dataclasses.replace(document.project.look, light_phi_deg=phi_deg)
    document.change("Move the light", gesture="light", look=look)


def test_a_drag_is_one_undo_step_and_the_next_drag_another(qtbot: Any) -> None:
    document = Document()
    start = document.project
    for phi in range(1, 40):
        move_light(document, phi)
    document.end_gesture()
    middle = document.project
    for phi in range(50, 60):
        move_light(document, phi)
    assert document.undo_stack.count() == 2
    document.undo_stack.undo()
    assert document.project is middle
    document.undo_stack.undo()
    assert document.project is start
    document.undo_stack.redo()
    assert document.project is middle


def test_another_kind_of_change_is_a_step_of_its_own(qtbot: Any) -> None:
    document = Document()
    move_light(document, 1.0)
    document.change("8 slices", slices=6)
    move_light(document, 2.0)
    assert document.undo_stack.count() == 3


def test_changed_carries_old_and_new_and_shares_what_did_not_change(qtbot: Any) -> None:
    document = Document()
    seen: list[tuple[Project, Project]] = []
    document.changed.connect(lambda old, new: seen.append((old, new)))
    start = document.project
    document.change("6 slices", slices=6)
    document.undo_stack.undo()
    assert [(old.slices, new.slices) for old, new in seen] == [(8, 6), (6, 8)]
    assert seen[0][0] is start
    assert seen[0][1].material is start.material
    assert seen[1][1] is start


def test_an_undo_storm_comes_back_to_the_same_objects(qtbot: Any) -> None:
    document = Document()
    chance = np.random.default_rng(21)
    for index in range(50):
        document.change(f"step {index}", slices=int(chance.integers(2, 32)))
    history = document.project
    for _ in range(2_000):
        (document.undo_stack.undo if chance.random() < 0.5 else document.undo_stack.redo)()
    document.undo_stack.setIndex(document.undo_stack.count())
    assert document.project is history


def test_clear_forgets_the_history(qtbot: Any) -> None:
    document = Document()
    document.change("6 slices", slices=6)
    document.clear()
    assert document.project.slices == 8
    assert not document.undo_stack.canUndo()


def test_the_oldest_steps_go_where_what_only_they_keep_is_too_large(qtbot: Any) -> None:
    document, size_bytes = Document(), KEPT_BYTES // 5
    stack = document.undo_stack
    arrays = []
    for number in range(9):
        array = np.empty(size_bytes, np.uint8)  # its pages are never touched, so it costs nothing
        arrays.append(weakref.ref(array))
        document.change(f"Build {number}", built_from=(array,))
        del array
        for slices in (3, 4):
            document.change(f"{slices} slices", slices=slices)
    assert [at for at, array in enumerate(arrays) if array() is not None] == [3, 4, 5, 6, 7, 8]
    assert stack.count() == 5 * 3 + 2, "small steps stay as long as what is between them is not too large"
    shown, count = document.project, stack.count()
    for _ in range(count):
        stack.undo()
    assert not stack.canUndo()
    assert document.project.built_from[0] is arrays[3]()
    stack.setIndex(count)
    assert document.project is shown
    assert (stack.undoText(), stack.redoText()) == ("4 slices", "")


def test_what_one_step_gave_up_can_be_had_again_however_large_it_is(qtbot: Any) -> None:
    document = Document()
    large = (np.empty(2 * KEPT_BYTES, np.uint8),)
    document.change("Build", built_from=large)
    document.change("Forget", built_from=())
    document.undo_stack.undo()
    assert document.project.built_from is large
    assert not document.undo_stack.canUndo()


def test_a_drag_keeps_no_project_between_its_ends(qtbot: Any) -> None:
    document = Document()
    seen = []
    for phi in range(1, 40):
        move_light(document, phi)
        seen.append(weakref.ref(document.project))
    assert [each() for each in seen if each() is not None] == [document.project]


def test_a_drag_after_an_undo_is_a_step_of_its_own(qtbot: Any) -> None:
    document = Document()
    move_light(document, 1.0)
    first = document.project
    document.change("6 slices", slices=6)
    document.undo_stack.undo()
    move_light(document, 2.0)
    document.undo_stack.undo()
    assert document.project is first


def test_a_step_that_cannot_be_read_leaves_all_as_it_was(qtbot: Any) -> None:
    """The disk of a project is gone, and with it the states that the history knows by name."""
    document, gone = Document(), [True]
    first, now = Project(name="first"), Project(name="now")

    def find(name: str) -> Project:
        if gone:
            raise InputError("Felt.lap", "is gone", "Bring it back")
        return first

    document.restore(now, (Step("Rename", "", "a state", "another"),), 1, find)
    with qtbot.waitSignal(document.unread) as said:
        document.undo_stack.undo()
    assert "Felt.lap" in str(said.args[0])
    assert document.project is now
    assert document.undo_stack.index() == 1
    gone.clear()
    document.undo_stack.undo()
    assert document.project is first
    assert document.undo_stack.index() == 0
