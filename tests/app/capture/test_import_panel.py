"""Rows of the import panel as they are clicked: what they ask for, and the settings of an import that follow."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest
from PySide6.QtCore import Qt

from app.capture.import_panel import ImportPanel
from app.document.document import ImportChoices
from app.document.import_choices import settings_of
from engine.capture.photograph.grey_patch import GreyPatch

PATCH = (4, 5, 20, 10)


@pytest.fixture
def panel(qtbot: Any) -> ImportPanel:
    """The panel on screen, which follows what it asks for."""
    made = ImportPanel()
    qtbot.addWidget(made)

    def follow(_words: str, parts: dict[str, Any]) -> None:
        made.show_choices(dataclasses.replace(made.choices, **parts), None)
        made.disable("", measured=made.choices.sphere)

    made.chosen.connect(follow)
    made.show_choices(ImportChoices(), None)
    made.disable("", measured=False)
    made.fold.head.setChecked(True)
    made.show()
    qtbot.waitExposed(made)
    return made


def pick(panel: ImportPanel, qtbot: Any, value: str) -> None:
    """Choose an intensity by keys, as a user does."""
    box = panel.boxes["equalise"]
    box.setFocus()
    while box.currentData() != value:
        before = box.currentIndex()
        qtbot.keyClick(box, Qt.Key.Key_Down if before < box.findData(value) else Qt.Key.Key_Up)
        assert box.currentIndex() != before


def test_lamps_are_equalised_by_the_object(panel: ImportPanel, qtbot: Any) -> None:
    assert settings_of(panel.choices).equalise is None
    pick(panel, qtbot, "object")
    assert panel.choices.equalise == "object"
    assert settings_of(panel.choices).equalise == "object"
    pick(panel, qtbot, "")
    assert settings_of(panel.choices).equalise is None


def test_lamps_are_equalised_by_the_grey_patch_which_is_asked_for(panel: ImportPanel, qtbot: Any) -> None:
    with qtbot.waitSignal(panel.patch_wanted):
        pick(panel, qtbot, "patch")
    assert settings_of(panel.choices).equalise is None
    panel.show_choices(dataclasses.replace(panel.choices, patch=PATCH), None)
    assert settings_of(panel.choices).equalise == GreyPatch(*PATCH)
    box = panel.boxes["white_balance"]
    box.setFocus()
    qtbot.keyClick(box, Qt.Key.Key_Home)
    assert panel.choices.patch is None
    assert panel.choices.equalise == ""


def test_a_second_sphere_needs_a_first(panel: ImportPanel, qtbot: Any) -> None:
    assert not panel.spheres.isEnabled()
    assert "not measured on a sphere" in panel.spheres.buttons["two"].toolTip()
    qtbot.mouseClick(panel.sphere.buttons["sphere"], Qt.MouseButton.LeftButton)
    qtbot.mouseClick(panel.spheres.buttons["two"], Qt.MouseButton.LeftButton)
    assert settings_of(panel.choices).second_sphere == "auto"
    qtbot.mouseClick(panel.sphere.buttons["stated"], Qt.MouseButton.LeftButton)
    assert settings_of(panel.choices).second_sphere is None
