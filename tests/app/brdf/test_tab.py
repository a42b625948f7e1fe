"""The BRDF workspace by what it does to the project: compare, change, hide, fit, use, save, and files that are bad."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QColor, QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QFileDialog, QLabel, QPushButton, QToolButton, QWidget

from app.brdf.library import KEY
from app.brdf.tab import BrdfTab
from app.commands import brdf as commands_brdf
from app.document.comparison import MARKERS
from app.project.values import Finder, Keeper, decode, encode, name_of
from app.widgets.param_form import NumberEditor
from app.window.main_window import MainWindow
from engine.brdf.brdf import MODELS, brdf_from_text
from engine.brdf.models.microfacet import Ggx
from engine.brdf.models.presets import PRESETS
from engine.brdf.readers.read import read_brdf
from engine.brdf.readers.table_file import write_table
from engine.brdf.resample import table_from
from engine.brdf.table import DirectionTable, HalfDifferenceTable
from engine.geometry.shapes import shape
from tests.app.window.test_main_window import assert_readable
from tests.present import present

Drop = Callable[[QWidget, list[Path]], None]


@pytest.fixture
def tab(window: MainWindow, qtbot: Any) -> BrdfTab:
    window.show_workspace("brdf")
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)
    return window.brdf


@pytest.fixture
def table(tmp_path: Path) -> Path:
    """A measured table of few samples, as a file."""
    path = tmp_path / "felt.exr"
    write_table(path, table_from(brdf_from_text("ggx:kd=0.3,alpha=0.4"), (12, 10, 12), "felt", np.float32))
    return path


def names(tab: BrdfTab) -> list[str]:
    return [entry.name for entry in tab.comparison.entries]


def rest(tab: BrdfTab, qtbot: Any) -> None:
    qtbot.wait(20)
    qtbot.waitUntil(lambda: not tab.bench.jobs.active and not tab.at_rest.isActive(), timeout=120_000)


def steps(tab: BrdfTab) -> int:
    return tab.bench.document.undo_stack.count()


def dialogs(window: MainWindow) -> list[str]:
    return [f"{box.text()}\n{box.informativeText()}" for box in window.failures.open_dialogs.values()]


def close_dialogs(window: MainWindow) -> None:
    for box in tuple(window.failures.open_dialogs.values()):
        box.close()


def at_the_first_error(tab: BrdfTab, act: Callable[[], None]) -> list[bool]:
    """A list that holds one value once `act` has run, as soon as the fit tells an error.

    A fit may end between two looks of `waitUntil`; its signal is never missed.
    """
    done: list[bool] = []

    def once() -> None:
        if tab.inspector.fit.so_far is not None and not done:
            done.append(True)
            act()

    tab.inspector.fit.changed.connect(once)
    return done


def library_row(tab: BrdfTab, key: str) -> Any:
    return next(item for item in tab.library.items() if item.data(KEY) == key)


def test_the_library_holds_every_model_and_preset_and_adds_what_is_chosen(tab: BrdfTab, qtbot: Any) -> None:
    assert tab.pages.currentWidget() is tab.empty
    keys = [item.data(KEY) for item in tab.library.items() if item.data(KEY)]
    assert keys == [*MODELS, *(preset.text for preset in PRESETS)]
    assert not tab.library.add.isEnabled()
    tab.library.list.setCurrentItem(library_row(tab, "ward"))
    QTest.keyClick(tab.library.list, Qt.Key.Key_Return)
    tab.library.list.setCurrentItem(library_row(tab, "lafortune:preset=blue-paint"))
    QTest.mouseClick(tab.library.add, Qt.MouseButton.LeftButton)
    assert names(tab) == ["Ward", "Blue paint"]
    assert tab.entry is not None
    assert tab.entry.brdf == brdf_from_text("lafortune:preset=blue-paint")
    assert tab.pages.currentWidget() is tab.tiles
    assert steps(tab) == 2
    tab.bench.document.undo_stack.undo()
    assert (names(tab), tab.entry.name) == (["Ward"], "Ward")


def test_the_search_leaves_what_has_all_its_words(tab: BrdfTab) -> None:
    tab.library.search.setText("blue pain")
    left = [item.data(KEY) for item in tab.library.items() if not item.isHidden() and item.data(KEY)]
    assert "lafortune:preset=blue-paint" in left
    assert all("blue" in key for key in left)
    shown = [item.text() for item in tab.library.items() if not item.isHidden() and not item.data(KEY)]
    assert shown == ["Published"]
    tab.library.search.setText("oren")
    QTest.keyClick(tab.library.search, Qt.Key.Key_Return)
    assert tab.library.search.selectedText() == "oren"  # the next word replaces it
    assert names(tab) == ["Oren–Nayar"]


def test_thumbnails_are_drawn_for_the_rows_in_sight(tab: BrdfTab, qtbot: Any) -> None:
    library = tab.library
    qtbot.waitUntil(lambda: "lambert" in library.images and not library.in_sight_without(), timeout=60_000)
    last = PRESETS[-1].text
    assert last not in library.images
    library.list.scrollToBottom()
    qtbot.waitUntil(lambda: last in library.images, timeout=60_000)
    assert len(library.images) < len(MODELS) + len(PRESETS)


def test_a_parameter_is_dragged_in_one_step_with_live_views(tab: BrdfTab, qtbot: Any) -> None:
    commands_brdf.add_model(tab.bench, "ggx:alpha=0.2")
    rest(tab, qtbot)
    before = steps(tab)
    assert tab.inspector.form is not None
    slider = cast(Any, tab.inspector.form.editors["alpha"]).slider
    start = QPoint(20, slider.height() // 2)
    QTest.mousePress(slider, Qt.MouseButton.LeftButton, pos=start)
    for step in range(1, 8):
        QTest.mouseMove(slider, start + QPoint(4 * step, 0))
    QTest.mouseRelease(slider, Qt.MouseButton.LeftButton, pos=start + QPoint(28, 0))
    assert steps(tab) == before + 1
    assert tab.entry is not None
    changed = tab.entry.brdf
    assert cast(Any, changed).alpha != 0.2
    rest(tab, qtbot)
    assert tab.current is not None
    assert tab.known[tab.current].brdf == changed
    assert tab.albedos[tab.current][0] == changed
    assert tab.facts is not None
    assert tab.facts.brdf == changed
    tab.bench.document.undo_stack.undo()
    assert cast(Any, tab.entry.brdf).alpha == 0.2
    assert cast(Any, tab.inspector.form.editors["alpha"]).field.value == 0.2


def test_entries_are_hidden_removed_and_brought_back(tab: BrdfTab, qtbot: Any) -> None:
    for text in ("ggx", "ward", "phong"):
        commands_brdf.add_model(tab.bench, text)
    rest(tab, qtbot)
    assert tab.lobes is not None
    assert len(tab.lobes.lobes) == 3
    identity = tab.comparison.entries[1].identity
    tab.inspector.list.item(1).setCheckState(Qt.CheckState.Unchecked)
    assert [entry.visible for entry in tab.comparison.entries] == [True, False, True]
    assert len(tab.lobes.lobes) == 2
    tab.inspector.list.setCurrentRow(1)
    assert tab.current == identity
    tab.inspector.list.setFocus()
    QTest.keyClick(tab.inspector.list, Qt.Key.Key_Delete)
    assert names(tab) == ["GGX", "Phong"]
    assert tab.entry is not None
    assert tab.entry.name == "Phong"
    tab.bench.document.undo_stack.undo()
    assert names(tab) == ["GGX", "Ward", "Phong"]
    tab.bench.document.undo_stack.undo()
    rest(tab, qtbot)
    assert len(tab.lobes.lobes) == 3
    assert tab.inspector.list.item(1).checkState() == Qt.CheckState.Checked


def test_each_has_one_colour_and_marker_in_space_and_in_every_plot(tab: BrdfTab, qtbot: Any) -> None:
    for text in ("ggx", "ward"):
        commands_brdf.add_model(tab.bench, text)
    rest(tab, qtbot)
    identities = [(entry.colour, entry.marker) for entry in tab.comparison.entries]
    assert tab.lobes is not None
    drawn = [QColor.fromRgbF(*surface.colour).name() for surface in tab.lobes.lobes]
    assert drawn == [colour for colour, _ in identities]
    assert tab.lobes.markers == [marker for _, marker in identities]
    for plot in (tab.polar, tab.albedo):
        shown = [(c.opts["pen"].color().name(), m.opts["symbol"]) for c, m in plot.lines.items if c.isVisible()]
        assert shown == identities


def test_control_drag_moves_the_light_of_all_views(tab: BrdfTab, qtbot: Any) -> None:
    commands_brdf.add_model(tab.bench, "phong:exponent=80")
    rest(tab, qtbot)
    before, keys = tab.light_deg, Qt.KeyboardModifier.ControlModifier
    start = QPoint(100, 100)
    assert tab.lobes is not None
    QTest.mousePress(tab.lobes, Qt.MouseButton.LeftButton, keys, start)
    QTest.mouseMove(tab.lobes, start + QPoint(0, 30))
    QTest.mouseRelease(tab.lobes, Qt.MouseButton.LeftButton, keys, start + QPoint(0, 30))
    assert tab.light_deg > before
    assert tab.light.field.value == tab.light_deg
    rest(tab, qtbot)
    assert tab.current is not None
    assert np.degrees(tab.known[tab.current].theta_i) == pytest.approx(tab.light_deg)
    assert np.degrees(tab.lobes.light[0]) == pytest.approx(tab.light_deg)
    tab.set_light(200.0)
    assert tab.light_deg == 89.0


def test_one_view_can_fill_the_place(tab: BrdfTab) -> None:
    commands_brdf.add_model(tab.bench, "ggx")
    tile = tab.tile_of["albedo"]
    small = tile.width()
    QTest.mouseDClick(tile.head, Qt.MouseButton.LeftButton)
    assert [name for name, each in tab.tile_of.items() if each.isVisible()] == ["albedo"]
    QTest.qWait(20)
    assert tile.width() > 2 * small
    tile.enlarge.setFocus()
    QTest.keyClick(tile.enlarge, Qt.Key.Key_Escape)
    assert all(each.isVisible() for each in tab.tile_of.values())


def test_without_opengl_the_lobes_say_so_and_the_rest_works(tab: BrdfTab, qtbot: Any) -> None:
    tab._make_lobes("OpenGL is not available")
    commands_brdf.add_model(tab.bench, "ggx")
    rest(tab, qtbot)
    assert "OpenGL is not available" in present(tab.space.findChild(QLabel)).text()
    assert tab.current is not None
    assert tab.entry is not None
    assert tab.known[tab.current].brdf == tab.entry.brdf
    tab.fit()


def test_dropped_tables_are_compared_and_stay_in_the_library(
    window: MainWindow, qtbot: Any, drop: Drop, table: Path
) -> None:
    window.show_workspace("capture")
    drop(window, [table])
    tab = window.brdf
    qtbot.waitUntil(lambda: bool(tab.comparison.entries), timeout=60_000)
    assert window.stack.currentWidget() is tab
    rest(tab, qtbot)
    assert tab.comparison.files == (table,)
    assert tab.entry is not None
    assert tab.entry.path == table
    assert isinstance(tab.entry.brdf, HalfDifferenceTable)
    unusable = tab.entry.brdf.invalid_samples
    assert tab.inspector.samples.text() == "1 440" + (f", {unusable} unusable" if unusable else "")
    assert tab.inspector.reciprocity.text() == "exact"
    assert tab.inspector.largest.text().endswith("°")
    assert not tab.inspector.copy.isEnabled()
    assert "formula" in tab.inspector.copy.toolTip()
    assert library_row(tab, str(table)).text() == "felt.exr"


BAD = {
    "garbage.binary": b"\x00\x01garbage" * 99,
    "pointer.binary": b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 34992012\n",
    "empty.bsdf": b"",
    "cut.binary": np.array([90, 90, 180], "<i4").tobytes() + bytes(1000),
    "huge.binary": np.array([2**31 - 1] * 3, "<i4").tobytes(),
    "words.csv": b"theta_i,phi_i,theta_o\n1,2,three\n",
    "lines.astm": b"NUM_POINTS 10\nVARS theta_i,phi_i,theta_s,phi_s\n1,2\n",
}


def test_a_bad_file_is_one_sentence_and_changes_nothing(
    window: MainWindow, qtbot: Any, drop: Drop, tmp_path: Path
) -> None:
    window.show_workspace("brdf")
    before = window.bench.document.project
    for name, content in BAD.items():
        path = tmp_path / name
        path.write_bytes(content)
        drop(window, [path])
        qtbot.waitUntil(lambda: bool(dialogs(window)), timeout=60_000)
        (words,) = dialogs(window)
        assert str(path) in words
        assert "fault" not in words
        assert "Traceback" not in words
        assert window.bench.document.project is before
        close_dialogs(window)


def test_a_file_that_is_gone_can_be_found_again(
    tab: BrdfTab, qtbot: Any, table: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands_brdf.open_file(tab.bench, table)
    qtbot.waitUntil(lambda: bool(tab.comparison.entries), timeout=60_000)
    tab.remove()
    moved = table.with_name("moved.exr")
    table.rename(moved)
    tab.hide()
    tab.show()
    qtbot.waitUntil(lambda: tab.library.missing == frozenset({table}), timeout=60_000)
    row = library_row(tab, str(table))
    assert "not found" in row.text()
    tab.library.list.setCurrentItem(row)
    assert tab.library.add.text() == "Find it…"
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(moved), ""))
    tab.library.add_current()
    qtbot.waitUntil(lambda: bool(tab.comparison.entries), timeout=60_000)
    assert tab.comparison.files == (moved,)
    assert tab.entry is not None
    assert tab.entry.path == moved


def test_a_fit_finds_the_model_that_is_there_and_is_one_step(tab: BrdfTab, qtbot: Any) -> None:
    commands_brdf.add_model(tab.bench, "ggx:kd=0.3,alpha=0.3,f0=0.2")
    rest(tab, qtbot)
    before, live = steps(tab), []
    fit = tab.inspector.fit
    fit.changed.connect(lambda: live.append([one.live for one in tab.shown()].count(True)))
    QTest.mouseClick(fit.start, Qt.MouseButton.LeftButton)
    assert not fit.start.isEnabled()
    assert "running" in fit.start.toolTip()
    qtbot.waitUntil(lambda: not fit.running, timeout=240_000)
    assert 1 in live
    assert steps(tab) == before + 1
    found = tab.entry
    assert found is not None
    assert found.name == "GGX to GGX"
    assert cast(Any, found.brdf).alpha == pytest.approx(0.3, rel=1e-3)
    assert found.fitted is not None
    assert found.fitted.after < 1e-3 < found.fitted.before
    assert "→" in tab.inspector.fitted.text()
    assert not any(one.live for one in tab.shown())
    tab.bench.document.undo_stack.undo()
    assert names(tab) == ["GGX"]


def test_a_fit_that_is_stopped_keeps_the_best_so_far(tab: BrdfTab, qtbot: Any) -> None:
    commands_brdf.add_model(tab.bench, "lafortune:preset=blue-paint")
    rest(tab, qtbot)
    fit = tab.inspector.fit
    fit.model.setCurrentIndex(fit.model.findData("cook-torrance"))
    stopped = at_the_first_error(tab, lambda: QTest.mouseClick(fit.stop, Qt.MouseButton.LeftButton))
    fit.begin()
    qtbot.waitUntil(lambda: bool(stopped) and not fit.running, timeout=240_000)
    assert names(tab) == ["Blue paint", "Cook–Torrance to Blue paint"]
    assert tab.entry is not None
    assert tab.entry.fitted is not None
    assert tab.entry.fitted.after <= tab.entry.fitted.before


def test_a_fit_to_what_is_gone_adds_nothing(window: MainWindow, tab: BrdfTab, qtbot: Any) -> None:
    commands_brdf.add_model(tab.bench, "ward")
    rest(tab, qtbot)
    gone = at_the_first_error(tab, window.new)
    tab.inspector.fit.begin()
    qtbot.waitUntil(lambda: bool(gone) and not tab.inspector.fit.running, timeout=240_000)
    assert names(tab) == []


def test_the_material_reflects_with_a_model_and_the_view_names_it(window: MainWindow, tab: BrdfTab) -> None:
    commands_brdf.add_model(tab.bench, "lafortune:preset=blue-paint")
    before = steps(tab)
    QTest.mouseClick(tab.inspector.use, Qt.MouseButton.LeftButton)
    assert steps(tab) == before + 1
    material = window.bench.document.project.material
    assert (material.brdf, material.measured) == ("lafortune:preset=blue-paint", None)
    assert window.view.brdf == brdf_from_text(material.brdf)
    window.undo.trigger()
    assert isinstance(window.view.brdf, Ggx)


def test_the_material_reflects_with_a_measurement_and_the_view_offers_it(
    window: MainWindow, tab: BrdfTab, qtbot: Any, table: Path
) -> None:
    commands_brdf.open_file(tab.bench, table)
    qtbot.waitUntil(lambda: bool(tab.comparison.entries), timeout=60_000)
    tab.inspector.use.click()
    qtbot.waitUntil(lambda: window.bench.document.project.material.measured is not None, timeout=120_000)
    material = window.bench.document.project.material
    assert isinstance(brdf_from_text(material.brdf), Ggx)
    assert cast(Any, brdf_from_text(material.brdf)).alpha == pytest.approx(0.4, rel=0.2)
    view = window.view
    assert view.brdf is material.measured
    assert "felt" in view.brdf_panel.choice.currentText()
    assert view.brdf_panel.form is not None
    assert not view.brdf_panel.form.isVisibleTo(view)
    view.brdf_panel.choice.setCurrentIndex(view.brdf_panel.choice.findData("ward"))
    view.brdf_panel.choice.activated.emit(view.brdf_panel.choice.currentIndex())
    assert window.bench.document.project.material.measured is None
    assert view.brdf_panel.form.isVisibleTo(view)
    assert tab.entry is not None
    place = [view.brdf_panel.choice.itemText(at) for at in range(view.brdf_panel.choice.count())].index(tab.entry.name)
    view.brdf_panel.choice.setCurrentIndex(place)
    view.brdf_panel.choice.activated.emit(place)
    qtbot.waitUntil(lambda: window.bench.document.project.material.measured is not None, timeout=120_000)


def test_a_measurement_without_a_shader_is_shown_by_its_nearest_model_until_its_table_is_there(
    window: MainWindow, qtbot: Any
) -> None:
    theta, phi = np.linspace(0.0, 1.5, 4), np.linspace(0.0, 2 * np.pi, 4, endpoint=False)
    size = (4, 4, 4, 4)
    grid = DirectionTable(theta, phi, theta, phi, np.full((*size, 3), 0.2), np.zeros(size, bool), "cloth")
    material = dataclasses.replace(window.bench.document.project.material, brdf="lambert", measured=grid)
    window.show_workspace("view")
    window.bench.document.change("Measured", material=material, mesh=shape("sphere"))
    assert window.view.brdf == brdf_from_text("lambert")
    assert "preparing" in window.view.hint.text()
    qtbot.waitUntil(lambda: isinstance(window.view.brdf, HalfDifferenceTable), timeout=120_000)
    assert "RMS off" in window.view.hint.text()
    assert "cloth" in window.view.brdf_panel.choice.currentText()
    assert window.bench.document.project.material.measured is grid


def test_the_text_that_is_copied_names_the_model(tab: BrdfTab) -> None:
    commands_brdf.add_model(tab.bench, "ggx:alpha=0.25,f0=0.9/0.6/0.3")
    tab.inspector.copy.click()
    assert tab.entry is not None
    assert brdf_from_text(QGuiApplication.clipboard().text()) == tab.entry.brdf


def test_a_table_is_saved_and_reads_back_the_same(
    tab: BrdfTab, qtbot: Any, table: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commands_brdf.open_file(tab.bench, table)
    qtbot.waitUntil(lambda: bool(tab.comparison.entries), timeout=60_000)
    rest(tab, qtbot)
    said: list[str] = []
    tab.bench.said.connect(said.append)
    proposals: list[Path] = []

    def answer(_parent: Any, _title: str, proposal: str, _endings: str) -> tuple[str, str]:
        proposals.append(Path(proposal))
        return str(tmp_path / "again"), "Table of Lightarc (*.exr)"

    monkeypatch.setattr(QFileDialog, "getSaveFileName", answer)
    before = tab.bench.output_folder
    tab.inspector.save.click()
    qtbot.waitUntil(lambda: (tmp_path / "again.exr").exists() and bool(said), timeout=60_000)
    assert said == ["again.exr written"]
    assert [place.parent for place in proposals] == [before]
    assert tab.bench.output_folder == tmp_path
    assert tab.entry is not None
    assert np.array_equal(cast(Any, read_brdf(tmp_path / "again.exr")).values, cast(Any, tab.entry.brdf).values)


def test_more_than_can_be_distinguished_are_refused_in_words(tab: BrdfTab) -> None:
    said: list[str] = []
    tab.bench.said.connect(said.append)
    for _ in range(len(MARKERS) + 1):
        commands_brdf.add_model(tab.bench, "lambert")
    assert len(names(tab)) == len(MARKERS)
    assert "remove one" in said[-1]
    assert "remove one" in tab.inspector.fit.start.toolTip()


def test_a_storm_of_undo_and_redo_ends_where_the_project_is(tab: BrdfTab, qtbot: Any) -> None:
    stack = tab.bench.document.undo_stack
    for text in ("ggx", "ward", "lafortune:preset=blue-paint", "poulin-fournier"):
        commands_brdf.add_model(tab.bench, text)
        tab.set_light(10.0 + 17.0 * len(names(tab)))
        assert tab.current is not None
        tab._set_visible(tab.current, visible=False)
    tab.remove()
    for _ in range(4):
        while stack.canUndo():
            stack.undo()
        while stack.canRedo():
            stack.redo()
        tab._next_scale()
    for _ in range(3):
        stack.undo()
    rest(tab, qtbot)
    shown = tab.shown()
    assert tab.lobes is not None
    assert len(tab.lobes.lobes) == len(shown) == sum(entry.visible for entry in tab.comparison.entries)
    for one in shown:
        assert tab.known[one.number].brdf == one.brdf
        assert np.degrees(tab.known[one.number].theta_i) == pytest.approx(tab.light_deg)


def test_facts_that_come_late_leave_those_of_the_current_entry(tab: BrdfTab, qtbot: Any) -> None:
    for text in ("lambert", "phong"):
        commands_brdf.add_model(tab.bench, text)
    tab.inspector.list.setCurrentRow(0)
    rest(tab, qtbot)
    of_the_first = tab.facts
    tab.inspector.list.setCurrentRow(1)
    rest(tab, qtbot)
    assert of_the_first is not None
    tab._judged(of_the_first)
    assert tab.entry is not None
    assert tab.facts is not None
    assert tab.facts.brdf == tab.entry.brdf != of_the_first.brdf


def test_switching_quickly_between_many_ends_with_the_last(tab: BrdfTab, qtbot: Any) -> None:
    for text in ("ggx", "ward", "phong", "cook-torrance", "lambert"):
        commands_brdf.add_model(tab.bench, text)
    for turn in range(15):
        tab.inspector.list.setCurrentRow(turn % 5)
        qtbot.wait(3)
    tab.inspector.list.setCurrentRow(2)
    rest(tab, qtbot)
    assert tab.entry is not None
    assert tab.entry.name == "Phong"
    assert tab.inspector.kind.text() == "Phong"
    assert tab.facts is not None
    assert tab.facts.brdf == tab.entry.brdf
    assert tab.current is not None
    assert tab.slice.values is tab.known[tab.current].half_difference
    assert tab.sphere.brdf == tab.entry.brdf


@pytest.mark.dressed
@pytest.mark.parametrize("size", [pytest.param((1280, 800), marks=pytest.mark.long), (1120, 700)])
def test_no_words_are_cut_off_where_there_is_something_to_compare(
    window: MainWindow, tab: BrdfTab, qtbot: Any, table: Path, size: tuple[int, int]
) -> None:
    window.resize(*size)
    for text in ("ggx", "lafortune:preset=blue-paint"):
        commands_brdf.add_model(tab.bench, text)
    commands_brdf.open_file(tab.bench, table)
    qtbot.waitUntil(lambda: len(names(tab)) == 3, timeout=60_000)
    for row in range(3):
        tab.inspector.list.setCurrentRow(row)
        rest(tab, qtbot)
        qtbot.wait(60)
        for kind in (QLabel, QPushButton, QToolButton):
            for widget in tab.findChildren(kind):
                if widget.isVisible() and cast(Any, widget).text():
                    assert_readable(widget, "brdf")
    for widget in tab.findChildren(QAbstractButton):
        if widget.isVisible():
            assert widget.text() or widget.accessibleName(), widget.objectName()


def test_reflectance_written_in_glsl_is_compared_and_kept(tab: BrdfTab, qtbot: Any, tmp_path: Path) -> None:
    path = tmp_path / "mine.brdf"
    head = "analytic\n::begin parameters\nfloat grey 0 1 0.25\nbool on 1\ncolor tint 1 0.5 0.5\n::end parameters"
    begin, end = f"{head}\n::begin shader\nvec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)", "\n::end shader\n"
    path.write_text(f"{begin} {{ return on ? grey * tint : vec3(0); }}{end}", encoding="utf-8")
    commands_brdf.open_file(tab.bench, path)
    qtbot.waitUntil(lambda: names(tab) == ["mine"], timeout=60_000)
    rest(tab, qtbot)
    assert tab.inspector.kind.text() == "written in GLSL"
    editor = tab.inspector.written.editors["grey"]
    assert isinstance(editor, NumberEditor)
    editor.edited.emit(0.5, True)
    qtbot.waitUntil(lambda: tab.entry is not None and "grey 0 1 0.5" in cast(Any, tab.entry.brdf).text, timeout=60_000)
    rest(tab, qtbot)
    entry = tab.entry
    assert entry is not None
    np.testing.assert_allclose(entry.brdf.f([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), [0.5, 0.25, 0.25], rtol=1e-6)
    texts: dict[str, str] = {}

    def keep(words: str) -> str:
        name = name_of(words.encode())
        texts[name] = words
        return name

    def no_array(*_: object) -> Any:
        raise AssertionError("GLSL has no arrays")

    kept = encode(entry.brdf, Keeper(text=keep, array=no_array, folder=tmp_path))
    assert decode(kept, Finder(text=texts.__getitem__, array=no_array, folder=tmp_path)) == entry.brdf
