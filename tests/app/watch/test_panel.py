"""A capture that is being taken, in the window: photographs, lamps, what can be done, and what is let go of."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QFileDialog, QWidget

import engine.capture.arriving as arriving
from app.commands.workbench import Workbench
from app.watch.camera import find_lack
from app.watch.panel import WatchDialog
from engine.capture.decoded import find_kept
from engine.core.health import Verdict
from tests.engine.capture.calibration.generated import Capture, render, write


@pytest.fixture
def dialog(qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[WatchDialog]:
    monkeypatch.setattr(arriving, "STEADY_S", 0.02)
    window = QWidget()
    qtbot.addWidget(window)
    (tmp_path / "own").mkdir()
    bench = Workbench(tmp_path / "own", window)
    dialog = WatchDialog(window, bench)
    yield dialog
    dialog.forget()
    bench.jobs.close()


def test_photographs_and_lamps_appear_as_they_come(dialog: WatchDialog, qtbot: Any, tmp_path: Path) -> None:
    card = write(render(Capture(seed=2, lamps=4, height=40, width=48, file_format="jpg")), tmp_path / "card")
    folder = tmp_path / "taken"
    folder.mkdir()
    names = sorted(path.name for path in card.glob("*.jpg"))
    for name in ("lights.lp", *names[:2]):
        shutil.copy(card / name, folder)
    ended: list[Path] = []
    dialog.capture_ended.connect(ended.append)
    assert not dialog.start.isEnabled()
    assert not dialog.finish.isEnabled()
    dialog.take_folder(folder)
    dialog.show()
    qtbot.mouseClick(dialog.start, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: dialog.capture.count == 2, timeout=60_000)
    assert dialog.finish.isEnabled()
    assert [row.name for row in dialog.list.photographs.rows] == names[:2]
    assert set(dialog.list.photographs.thumbnails) == set(names[:2])
    assert [lamp.excluded for lamp in dialog.dome.lamps] == [True, True, False, False]
    assert dialog.coverage.text().startswith("Lights cover ")
    assert (dialog.bar.value(), dialog.bar.maximum()) == (2, 4)
    shutil.copy(folder / names[0], folder / names[3])
    qtbot.waitUntil(lambda: len(dialog.capture.photographs) == 3, timeout=60_000)
    assert dialog.dome.verdicts[names[3]] is Verdict.BAD
    assert f"is the same image as {names[0]}" in dialog.findings.text()
    for name in names[2:]:
        shutil.copy(card / name, folder)
    qtbot.waitUntil(lambda: bool(ended), timeout=60_000)  # by itself, when all of the list are there
    assert ended == [folder]
    assert not dialog.isVisible()
    assert dialog.preview.relit is not None
    before = dialog.preview.image
    dialog.dome.chosen.emit(0)
    assert dialog.preview.light_deg == (dialog.dome.lamps[0].elevation_deg, dialog.dome.lamps[0].azimuth_deg)
    assert dialog.preview.image is not None
    assert dialog.preview.image != before, "another light shows another image"
    assert dialog.decoded is not None
    assert find_kept(folder / names[3], dialog.decoded.options) is not None
    dialog.forget()


def test_the_mouse_over_the_dome_lights_the_preview(dialog: WatchDialog, qtbot: Any) -> None:
    """Elevation falls from the middle of the disk, and azimuth turns from its right side."""
    dialog.show()
    dome = dialog.dome
    with qtbot.waitSignal(dome.lit) as lit:
        qtbot.mouseMove(dome, QPoint(dome.width() // 2, dome.height() // 2 - round(0.5 * dome._radius)))
    assert lit.args == [pytest.approx(60.0, abs=1.0), pytest.approx(90.0, abs=2.0)]


def test_a_camera_is_chosen_where_its_library_is_there(dialog: WatchDialog, monkeypatch: pytest.MonkeyPatch) -> None:
    assert dialog.camera.isEnabled() == (find_lack() is None)
    assert dialog.camera.isEnabled() or "pip install 'lightarc[camera]'" in dialog.camera.toolTip()
    card = dialog.camera.count() - 1
    for chosen, port in (("/media/card", "disk:/media/card"), ("", None)):
        monkeypatch.setattr(QFileDialog, "getExistingDirectory", lambda *_, chosen=chosen: chosen)
        dialog.camera.setCurrentIndex(card)
        dialog.camera.activated.emit(card)
        assert dialog.camera.currentData() == port


def test_the_bar_is_empty_as_long_as_nobody_knows_how_many_come(dialog: WatchDialog) -> None:
    there = tuple(arriving.Arrived(Path(name), np.zeros((8, 8, 3), np.uint8), None, ()) for name in ("a.jpg", "b.jpg"))
    for expect, value in ((None, 0), (4, 2), (2, 2)):
        dialog._show(arriving.Capture(there, expect=expect))
        assert dialog.bar.value() == value
        assert dialog.bar.maximum() > value or expect == value


def test_a_capture_is_finished_early_or_cancelled(dialog: WatchDialog, qtbot: Any, tmp_path: Path) -> None:
    folder = write(render(Capture(seed=2, lamps=2, height=40, width=48, file_format="jpg")), tmp_path / "taken")
    dialog.take_folder(folder)
    dialog.expected.value = 9.0
    ended: list[Path] = []
    dialog.capture_ended.connect(ended.append)
    dialog.begin()
    qtbot.waitUntil(lambda: dialog.capture.count == 2, timeout=60_000)
    dialog.cancel.click()
    qtbot.waitUntil(lambda: not dialog.is_running, timeout=60_000)
    assert ended == []
    assert dialog.words.text() == "Cancelled; the photographs stay in their folder"
    assert (dialog.decoded, dialog.ahead) == (None, None)
    dialog.begin()
    qtbot.waitUntil(lambda: dialog.finish.isEnabled(), timeout=60_000)
    dialog.finish.click()
    qtbot.waitUntil(lambda: bool(ended), timeout=60_000)
