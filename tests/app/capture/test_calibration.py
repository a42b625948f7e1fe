"""Calibration chosen in the window and followed by a real import, against captures with known ground truth."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import QPointF, Qt

from app.window.main_window import MainWindow
from engine.images.decode import read_image
from tests.app.captures import capture, choices, drag, import_again, open_path, pick


def frame_chosen(window: MainWindow, name: str, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Choose a file in the box of a calibration frame."""
    monkeypatch.setattr("app.capture.import_panel.QFileDialog.getOpenFileName", lambda *_: (str(path), ""))
    pick(window, name, "choose")


def unevenness(stack: Any) -> float:
    """Largest relative deviation of an image from its mean, away from its edges."""
    inner = stack.radiance[:, 8:-8, 8:-8].astype(float)
    return float((inner.std(axis=(1, 2)) / inner.mean(axis=(1, 2))).max())


def off_truth(stack: Any, folder: Path, truth: dict[str, Any]) -> np.ndarray:
    """Quotients of what was imported and what was simulated, where there is light."""
    parts = []
    for name, radiance, saturated in zip(stack.sources, stack.radiance, stack.saturated, strict=True):
        clean = read_image(folder / "truth" / truth[name]["radiance"]).pixels
        strong = (clean > 0.1) & (clean < 1) & ~saturated[..., None]
        parts.append(radiance[strong] / clean[strong])
    return np.concatenate(parts)


def test_frames_chosen_in_the_window_take_out_dark_signal_and_fall_off(
    window: MainWindow, qtbot: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Corners lose 40 % and the sensor adds 2 %: with frames, all is one factor of the ground truth within noise."""
    folder, frames = tmp_path / "c", tmp_path / "frames"
    _, truth = capture(folder, sample="plain", corner_loss=0.4, dark=0.02, calibration=True)
    frames.mkdir()
    for name in ("dark", "flat"):
        shutil.move(folder / f"{name}.tif", frames / f"{name} of today.tif")
    notes = folder / "capture.toml"
    notes.write_text(
        "\n".join(line for line in notes.read_text().splitlines() if "dark" not in line[:5] and "flat" not in line[:5])
    )
    open_path(window, qtbot, folder, motion="none")
    plain = off_truth(window.bench.document.project.stack, folder, truth)
    assert plain.std() / plain.mean() > 0.08
    frame_chosen(window, "dark", frames / "dark of today.tif", monkeypatch)
    frame_chosen(window, "flat", frames / "flat of today.tif", monkeypatch)
    assert window.capture.options.boxes["flat"].currentText() == "flat of today.tif"
    stack = import_again(window, qtbot)
    assert (stack.provenance["dark"], stack.provenance["flat"]) == ("dark of today.tif", "flat of today.tif")
    found = off_truth(stack, folder, truth)
    assert found.std() / found.mean() < 0.03
    assert unevenness(stack) < 0.02
    window.undo.trigger()
    window.undo.trigger()
    pick(window, "flat", "none")
    assert choices(window).flat == "none"


def test_the_distance_of_a_near_lamp_evens_a_plain_sheet_out(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    """The fall-off over the sheet is undone for the true distance alone, and an unknown side is warned of."""
    folder = tmp_path / "c"
    capture(folder, sample="plain", noise=0.0, lamp_distance=1.5)
    notes = folder / "capture.toml"
    notes.write_text("\n".join(line for line in notes.read_text().splitlines() if "lamp_distance" not in line))
    open_path(window, qtbot, folder, motion="none")
    uneven = unevenness(window.bench.document.project.stack)
    assert uneven > 0.05
    panel = window.capture.options
    panel.fold.head.setChecked(True)
    qtbot.mouseClick(panel.lamp.buttons["near"], Qt.MouseButton.LeftButton)
    panel.distance.edited.emit(1.5, True)
    assert panel.distance.text() == "1.5 widths"
    stack = import_again(window, qtbot)
    assert stack.provenance["lamp_distance_widths"] == 1.5
    assert unevenness(stack) < 0.01
    assert not [one for one in stack.health.findings if "which side" in one.text]
    panel.distance.edited.emit(6.0, True)
    assert unevenness(import_again(window, qtbot)) > 0.5 * uneven


def test_a_near_lamp_on_an_unknown_side_is_warned_of_in_the_report(
    window: MainWindow, qtbot: Any, photographs: Path
) -> None:
    open_path(window, qtbot, photographs, motion="none")
    panel = window.capture.options
    panel.fold.head.setChecked(True)
    qtbot.mouseClick(panel.lamp.buttons["near"], Qt.MouseButton.LeftButton)
    stack = import_again(window, qtbot)
    assert [one for one in stack.health.warnings if "nothing says on which side it stood" in one]
    assert window.capture.report.health is stack.health


def test_a_patch_drawn_on_the_image_makes_it_grey(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    """A plain sheet is photographed in tinted light; the drawn patch, wherever it lies, becomes neutral."""
    from engine.images.encode import write_tiff16

    folder = tmp_path / "Tinted"
    folder.mkdir()
    tint = np.array([0.4, 0.5, 0.2])
    sheet = 0.7 + 0.3 * np.sin(np.arange(96) / 9.0)[:, None, None]
    for angle in (20, 40, 60):
        codes = np.broadcast_to(sheet * tint * angle / 60, (96, 120, 3))
        write_tiff16(folder / f"card_{angle}deg.tif", np.rint(codes * 65535).astype(np.uint16), transfer="linear")
    (folder / "capture.toml").write_text(
        'transfer = "linear"\n'
        + "".join(f'[[photographs]]\nfile = "card_{a}deg.tif"\nelevation_deg = {a}\n' for a in (20, 40, 60))
    )
    open_path(window, qtbot, folder, motion="none")
    tab, document = window.capture, window.bench.document
    steps = document.undo_stack.count()
    pick(window, "white_balance", "patch")
    qtbot.waitUntil(lambda: tab.image.image is not None and not window.bench.jobs.active, timeout=60_000)
    start = tab.image.to_screen(QPointF(20, 30))
    drag(tab.image, start, start + QPointF(40, 24) * tab.image.zoom)
    assert document.undo_stack.count() == steps + 1
    assert choices(window).patch == pytest.approx((20, 30, 40, 24), abs=1)
    stack = import_again(window, qtbot)
    assert stack.provenance["picture_balance"] == pytest.approx([1.25, 1.0, 2.5], rel=2e-3)
    colour = stack.radiance[:, 30:54, 20:60].mean(axis=(1, 2))
    assert np.ptp(colour / colour.mean(axis=1, keepdims=True), axis=1).max() < 2e-3


def test_before_and_after_are_shown_again_without_reading_anything(
    window: MainWindow, qtbot: Any, photographs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    open_path(window, qtbot, photographs, motion="none")
    tab = window.capture
    shown = {}
    for value in ("before", "after"):
        tab.when.buttons[value].click()
        qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)
        shown[value] = tab.image.image
    started: list[str] = []
    monkeypatch.setattr(window.bench.jobs, "submit", lambda name, *_, **__: started.append(name))
    for value in ("before", "after", "before"):
        tab.when.buttons[value].click()
        assert tab.image.image is shown[value]
    # The small image for the list of recent projects follows a gesture in its own time, and reads no photograph.
    assert [name for name in started if name != "Making a small image"] == []
    assert shown["before"] is not shown["after"]
