"""The faults that the eye finds: each is found where there is one, and no workspace has any."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from PySide6.QtCore import QSize
from PySide6.QtWidgets import (
    QDialog,
    QGridLayout,
    QLabel,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from app.commands.workbench import Arrival
from app.help.keys import show_about, show_keys
from app.help.mode_chooser import ModeChooser
from app.project.database import Damaged
from app.widgets.panels import Panel, text
from app.widgets.param_form import ParamForm
from app.window.arriving import ask_where
from app.window.dialogs import ask_to_recover, ask_what_to_collect, show_history, show_notes
from app.window.main_window import MainWindow
from app.window.top_bar import WORKSPACES
from benchmarks.app.faults import cut, faint, faults, nameless, out_of_order, overlapping
from engine.brdf.models.phong import Phong


@pytest.fixture
def sheet(qtbot: Any) -> Iterator[QWidget]:
    made = QWidget()
    QVBoxLayout(made)
    qtbot.addWidget(made)
    made.resize(240, 120)
    return made  # type: ignore[return-value]


def show(sheet: QWidget, qtbot: Any) -> QWidget:
    with qtbot.waitExposed(sheet):
        sheet.show()
    return sheet


def add(sheet: QWidget, widget: QWidget) -> None:
    layout = sheet.layout()
    assert layout is not None
    layout.addWidget(widget)


def test_text_without_room_is_found(sheet: QWidget, qtbot: Any) -> None:
    words = QLabel("Much more than there is room for in this place")
    words.setMaximumWidth(60)
    add(sheet, words)
    add(sheet, QLabel("Enough"))
    (found,) = cut(show(sheet, qtbot))
    assert "Much more" in found


def test_a_cell_without_room_is_found(sheet: QWidget, qtbot: Any) -> None:
    table = QTableWidget(2, 1)
    table.setAccessibleName("Uses")
    table.setColumnWidth(0, 120)
    table.setItem(0, 0, QTableWidgetItem("Sharp shadows under any light, and highlights"))
    table.setItem(1, 0, QTableWidgetItem("Enough"))
    add(sheet, table)
    show(sheet, qtbot)
    assert [found for found in cut(sheet) if "Sharp shadows" in found]
    table.setColumnWidth(0, 600)
    assert not [found for found in cut(sheet) if "Sharp shadows" in found]


def test_widgets_over_each_other_are_found(qtbot: Any) -> None:
    sheet = QWidget()
    qtbot.addWidget(sheet)
    grid = QGridLayout(sheet)
    grid.addWidget(QPushButton("One"), 0, 0)
    grid.addWidget(QPushButton("Two"), 0, 0)
    (found,) = overlapping(show(sheet, qtbot))
    assert "lies over" in found


@pytest.mark.parametrize(("colour", "is_found"), [("#777777", True), ("#000000", False)])
def test_faint_text_is_found(sheet: QWidget, qtbot: Any, colour: str, is_found: bool) -> None:
    words = QLabel("Words")
    words.setStyleSheet(f"background: #a0a0a0; color: {colour}; padding: 8px")
    add(sheet, words)
    assert bool(faint(show(sheet, qtbot))) is is_found


def test_a_control_without_a_name_is_found(sheet: QWidget, qtbot: Any) -> None:
    nobody = QPushButton("")
    add(sheet, nobody)
    add(sheet, QPushButton("Go"))
    assert len(nameless(show(sheet, qtbot))) == 1
    nobody.setAccessibleName("Stop")
    assert nameless(sheet) == []


def test_a_tab_key_that_leads_back_is_found(sheet: QWidget, qtbot: Any) -> None:
    first, second = QPushButton("First"), QPushButton("Second")
    layout = sheet.layout()
    assert isinstance(layout, QVBoxLayout)
    layout.addWidget(second)
    layout.insertWidget(0, first)
    (found,) = out_of_order(show(sheet, qtbot))
    assert "'Second'" in found
    assert "back to" in found


def test_a_form_that_comes_later_follows_what_is_above_it(qtbot: Any) -> None:
    panel = Panel()
    qtbot.addWidget(panel)
    above, below = QPushButton("Above"), QPushButton("Below")
    panel.column.addWidget(above)
    panel.column.addWidget(text("between"))
    panel.column.addWidget(below)
    form = ParamForm(Phong())
    panel.column.insertWidget(1, form)
    panel.finish()
    panel.resize(QSize(296, 400))
    form.follow(above)
    assert out_of_order(show(panel, qtbot)) == []


@pytest.mark.parametrize(
    ("theme", "size"),
    [
        ("dark", (1024, 700)),
        ("light", (1280, 800)),
        pytest.param("light", (1024, 700), marks=pytest.mark.long),
        pytest.param("dark", (1280, 800), marks=pytest.mark.long),
    ],
)
def test_no_workspace_has_a_fault(window: MainWindow, qtbot: Any, theme: str, size: tuple[int, int]) -> None:
    window.resize(*size)
    window.set_theme(theme)
    found: dict[str, list[str]] = {}
    for name in WORKSPACES:
        window.show_workspace(name)
        qtbot.wait(150)
        found[name] = faults(window)
        for _ in range(10):  # the layout may not have come to rest on a busy machine
            if not found[name]:
                break
            qtbot.wait(400)
            found[name] = faults(window)
    window.set_theme("dark")
    assert found == {name: [] for name in WORKSPACES}


def test_no_dialog_has_a_fault_or_is_higher_than_the_smallest_window(window: MainWindow, qtbot: Any) -> None:
    window.show_workspace("view")
    qtbot.waitUntil(lambda: window.view.default_mesh is not None, timeout=60_000)
    openers = (
        lambda: show_keys(window),
        lambda: show_about(window),
        lambda: show_history(window, window.bench),
        lambda: window.view.save_image("picture"),
        lambda: window.view.save_image("turntable"),
        lambda: ModeChooser(window, window.bench.document.project).open(),
        lambda: show_notes(window, window.bench),
        lambda: ask_what_to_collect(window, window.projects.path, [window.projects.path] * 40, print),
        lambda: ask_to_recover(window, Damaged(window.projects.path, "mesh is not a valid mesh"), print),
        lambda: ask_where(
            window,
            window.bench,
            print,
            Arrival(
                "Linen under the arc", print, print, "imports all photographs together, as one capture of one sample"
            ),
        ),
    )
    for show in openers:
        show()
        (dialog,) = [each for each in window.findChildren(QDialog) if each.isVisible()]
        qtbot.wait(100)
        assert faults(dialog) == []
        assert dialog.height() <= 660
        dialog.close()
