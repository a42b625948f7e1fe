"""A capture that is being taken, in the window: photographs appear with their verdicts, and lamps fill the dome."""

from __future__ import annotations

import math
import threading
from contextlib import closing
from pathlib import Path

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QAccessible, QCloseEvent, QColor, QImage, QMouseEvent, QPaintEvent
from PySide6.QtWidgets import QComboBox, QDialog, QFileDialog, QHBoxLayout, QProgressBar, QVBoxLayout, QWidget

from app.capture.light_dome import DomeImage, Lamp
from app.capture.photograph_list import PhotographList, Row, file_name
from app.commands.workbench import Workbench
from app.document.import_choices import settings_of
from app.jobs.jobs import Job
from app.watch.camera import Camera, find_lack
from app.watch.kernels import load_kernels_beside
from app.watch.project import choose_path_ahead
from app.widgets import theme
from app.widgets.image_view import paint_whole, rgb_image
from app.widgets.import_controls import name_controls
from app.widgets.number_field import NumberField
from app.widgets.panels import Rows, button, enable, line, text, with_buttons
from app.widgets.theme import PADDING, STEP
from engine.capture.ahead import WrittenAhead
from engine.capture.arriving import Arrived, Capture, Watching, arrive, decoding_options
from engine.capture.decoded import Decoded
from engine.core.directions import surface_direction
from engine.core.escape import escape_controls
from engine.core.figure_text import format_fixed, percent
from engine.core.health import Verdict
from engine.core.steps import Step, Steps, relay
from engine.shading.directional.relit_small import RelitSmall, relight_small
from engine.storage.notices import Notices

#: Size of the dialog in pixels, and the most photographs that can be expected.
SIZE, MAX_EXPECTED = (1080, 600), 9999.0

#: Fewest photographs that can be imported.
FEWEST = 2

#: Beginning of the port of a memory card, its place among the cameras, and its name until a user has chosen it.
CARD, LAST_CAMERA, CARD_WORDS = "disk:", 2, "a memory card…"

#: Light of the preview until a user chooses another: elevation and azimuth in degrees.
LIGHT_DEG = (45.0, 135.0)


class ArrivingDome(DomeImage):
    """The lamps of a capture: filled where the photograph is there, by its verdict, hollow where it is expected."""

    legend = "Filled: the photograph is there. Hollow: it is expected. The preview is lit from where the mouse is"

    #: The preview is to be lit from this elevation and azimuth, in degrees.
    lit = Signal(float, float)

    def __init__(self) -> None:
        super().__init__()
        self.verdicts: dict[str, Verdict] = {}

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        super().mouseMoveEvent(event)
        place = (event.position() - self._middle) / self._radius
        if math.hypot(place.x(), place.y()) <= 1.0:
            elevation_deg = math.degrees(math.acos(math.hypot(place.x(), place.y())))
            self.lit.emit(elevation_deg, math.degrees(math.atan2(-place.y(), place.x())))

    def colour(self, lamp: Lamp, worst: float) -> tuple[int, int, int]:
        if lamp.excluded or self.verdicts.get(lamp.name, Verdict.GOOD) < Verdict.WARNING:
            return super().colour(lamp, worst)
        colours = theme.current()
        found = QColor(colours.bad if self.verdicts[lamp.name] is Verdict.BAD else colours.warning)
        return found.red(), found.green(), found.blue()

    def words(self, lamp: Lamp) -> str:
        elevation, azimuth = format_fixed(lamp.elevation_deg, 1), format_fixed(lamp.azimuth_deg, 1)
        return f"{lamp.name}\nelevation {elevation}°, azimuth {azimuth}°".strip()


class RelitPreview(QWidget):
    """The photographs so far as one small image under a light that the user moves."""

    accessible_role = QAccessible.Role.Graphic

    def __init__(self) -> None:
        super().__init__()
        self.relit: RelitSmall | None = None
        self.light_deg = LIGHT_DEG
        self.image: QImage | None = None
        self.setMinimumSize(200, 200)
        self.setAccessibleName("Preview under a moved light")
        self.setToolTip("A preview from thumbnails: move the mouse over the dome to light it")

    def show_relit(self, relit: RelitSmall | None) -> None:
        """Show what has been made of the photographs; nothing where they are too few."""
        self.relit = relit
        self.light(*self.light_deg)

    def light(self, elevation_deg: float, azimuth_deg: float) -> None:
        """Light the preview from a direction."""
        self.light_deg = elevation_deg, azimuth_deg
        direction = surface_direction(math.radians(90.0 - elevation_deg), math.radians(azimuth_deg))
        self.image = None if self.relit is None else rgb_image(self.relit.image(direction))
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        paint_whole(self, self.image, "A preview appears as soon as lamps of photographs are known")


class WatchDialog(QDialog):
    """One capture. `capture_ended(folder)`: the capture in this folder has been taken, and is to be imported.

    The work runs beside all others, which do not wait for it; what it has decoded is kept until the next capture, or
    until the import is over.
    """

    capture_ended = Signal(object)

    def __init__(self, window: QWidget, bench: Workbench) -> None:
        super().__init__(window)
        self.bench = bench
        self.folder: Path | None = None
        self.capture = Capture()
        self.job: Job | None = None
        self.decoded: Decoded | None = None
        self.ahead: WrittenAhead | None = None
        self._finish = threading.Event()
        self.setWindowTitle("Watch")
        self.resize(*SIZE)
        column = QVBoxLayout(self)
        column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        column.addWidget(self._choices())
        column.addWidget(line())
        column.addLayout(self._views(), 1)
        self.words = text("", "secondary", wrap=True)
        self.bar = QProgressBar()
        self.bar.setTextVisible(False)
        self.bar.setAccessibleName("Photographs that are there")
        column.addWidget(self.bar)
        column.addWidget(self.words)
        column.addLayout(self._buttons())
        bench.jobs.changed.connect(self._on_job)
        self._refresh()

    def _choices(self) -> Rows:
        rows = Rows("Take photographs in while they are taken")
        self.folder_words, choose = text("none", wrap=True), button("Choose…")
        choose.clicked.connect(self._choose_folder)
        hint = "The folder in which the camera or the controller of the dome writes its photographs"
        rows.row("Folder", with_buttons(self.folder_words, choose), hint)
        self.expected = NumberField(0.0, 0.0, MAX_EXPECTED, nothing="as listed")
        hint = "The capture ends when so many are there; without a number, as many as a list of lights names"
        rows.row("Photographs", self.expected, hint)
        self.camera = QComboBox()
        for words, port in (("no camera", None), ("the one on a cable", ""), (CARD_WORDS, CARD)):
            self.camera.addItem(words, port)
        self.camera.activated.connect(self._choose_card)
        hint = "What the camera takes from now on is copied into the folder; nothing is changed on the camera"
        rows.row("Camera", self.camera, hint)
        return rows

    def _choose_card(self, index: int) -> None:
        """Ask for the folder of a memory card where one was chosen."""
        if index != LAST_CAMERA:
            return
        chosen = QFileDialog.getExistingDirectory(self, "Folder of the memory card")
        self.camera.setItemText(index, f"memory card {escape_controls(chosen)}" if chosen else CARD_WORDS)
        self.camera.setItemData(index, f"{CARD}{chosen}" if chosen else CARD)
        if not chosen:
            self.camera.setCurrentIndex(0)

    def _views(self) -> QHBoxLayout:
        self.list = PhotographList()
        self.list.setAccessibleName("Photographs that are there")
        self.list.chosen.connect(self._explain)
        self.dome = ArrivingDome()
        self.dome.setMinimumSize(240, 240)
        self.dome.chosen.connect(self._choose_lamp)
        self.preview = RelitPreview()
        self.dome.lit.connect(self.preview.light)
        self.coverage = text("", "secondary", wrap=True)
        self.findings = text("", wrap=True)
        right = QVBoxLayout()
        right.setSpacing(STEP)
        right.addWidget(self.dome, 1)
        right.addWidget(self.coverage)
        right.addWidget(self.findings)
        views = QHBoxLayout()
        views.setSpacing(2 * STEP)
        views.addWidget(self.list, 1)
        views.addWidget(self.preview, 1)
        views.addLayout(right, 1)
        return views

    def _buttons(self) -> QHBoxLayout:
        self.start, self.finish, self.cancel = button("Start", "primary"), button("Finish"), button("Cancel")
        self.start.clicked.connect(self.begin)
        self.finish.clicked.connect(self._finish.set)
        self.cancel.clicked.connect(self.stop)
        row = QHBoxLayout()
        row.setSpacing(STEP)
        row.addStretch(1)
        for each in (self.cancel, self.finish, self.start):
            row.addWidget(each)
        return row

    @property
    def is_running(self) -> bool:
        return self.job is not None and not self.job.over

    def take_folder(self, folder: Path) -> None:
        """Choose the folder."""
        self.folder = folder
        self.folder_words.setText(escape_controls(str(folder)))
        self._refresh()

    def _choose_folder(self) -> None:
        chosen = QFileDialog.getExistingDirectory(self, "Folder of photographs")
        if chosen:
            self.take_folder(Path(chosen))

    def begin(self) -> None:
        """Begin to follow the folder."""
        if self.folder is None or self.is_running:
            return
        self.forget()
        self._finish.clear()
        self.list.photographs.thumbnails.clear()
        self._show(Capture())
        self.preview.show_relit(None)
        folder, finish, beside = self.folder, self._finish, self.bench.own / "ahead"
        choices = self.bench.document.project.import_choices.for_another_capture
        wishes = Watching(folder, round(self.expected.value) or None)
        port: str | None = self.camera.currentData()

        def work() -> Steps[Capture]:
            yield Step(0.0, "")
            settings = settings_of(choices)
            self.decoded = decoded = Decoded(decoding_options(folder, settings))
            self.ahead = ahead = WrittenAhead(choose_path_ahead(beside), settings, decoded.options)
            with closing(Notices(folder) if port is None else Camera(folder, port)) as source:
                arriving = arrive(decoded, wishes, finish.is_set, source.wait, ahead)
                return (yield from relay(load_kernels_beside(arriving, settings), _with_preview))

        self.job = self.bench.jobs.submit("Watching a folder", work, lane="screen")
        self.job.progressed.connect(self._on_step)
        self.job.succeeded.connect(self._on_ended)
        self.job.failed.connect(lambda error: self.words.setText(escape_controls(str(error))))
        self.job.cancelled.connect(lambda: self.words.setText("Cancelled; the photographs stay in their folder"))
        for ended in (self.job.failed, self.job.cancelled):
            ended.connect(lambda *_: self.forget())
        for ended in (self.job.succeeded, self.job.failed, self.job.cancelled):
            ended.connect(lambda *_: self._refresh())
        self._refresh()

    def stop(self) -> None:
        """Cancel the capture; its photographs stay where they are."""
        if self.job is not None and self.is_running:
            self.bench.jobs.cancel(self.job)
        else:
            self.close()

    def forget(self) -> None:
        """Let go of what has been decoded and written."""
        for each in (self.ahead, self.decoded):
            if each is not None:
                each.close()
        self.ahead = self.decoded = None

    def closeEvent(self, event: QCloseEvent) -> None:
        """End with the dialog, whose photographs nobody sees any more."""
        if self.is_running:
            self.stop()
        super().closeEvent(event)

    def _on_step(self, step: Step) -> None:
        if step.partial is not None:
            capture, relit = step.partial
            self._show(capture)
            self.preview.show_relit(relit)
        self.words.setText(escape_controls(step.note) or "Waiting for photographs")

    def _on_ended(self, capture: Capture) -> None:
        self._show(capture)
        if capture.count < FEWEST:
            self.words.setText("A capture needs two photographs at least")
            return
        self.words.setText(f"{capture.count} photographs are there, and are imported")
        self.accept()
        self.capture_ended.emit(self.folder)

    def _on_job(self, job: Job) -> None:
        """Let go of what has been decoded when the import that it was for is over."""
        if job.over and job is self.bench.importing and not self.is_running:
            self.forget()

    def _show(self, capture: Capture) -> None:
        """Show what is there."""
        self.capture = capture
        for one in capture.photographs:
            name = file_name(one.path)
            known = name in self.list.photographs.thumbnails and one.path.name not in capture.new
            if one.thumbnail is not None and not known:
                self.list.photographs.show_thumbnail(name, rgb_image(one.thumbnail))
        self.list.show_rows([_row(one) for one in capture.photographs])
        if capture.new:
            self.list.scrollToBottom()
        self.dome.verdicts = {file_name(one.path): one.verdict for one in capture.photographs}
        self.dome.lamps = tuple(_lamps(capture))
        self.dome.update()
        self.bar.setRange(0, capture.expect or 1)
        self.bar.setValue(min(capture.count, self.bar.maximum()) if capture.expect else 0)  # full is not known before
        covered = capture.coverage
        self.coverage.setText("" if covered is None else f"Lights cover {percent(covered)} of the dome")
        self._explain(self.list.currentIndex().row())
        self._refresh()

    def _explain(self, place: int) -> None:
        """Say what is to be said of the photograph that is chosen, else of the last that is doubtful."""
        shown = self.capture.photographs
        chosen = shown[place] if 0 <= place < len(shown) else None
        doubtful = [one for one in shown if one.verdict >= Verdict.WARNING]
        chosen = chosen or (doubtful[-1] if doubtful else None)
        findings = self.capture.findings if chosen is None else chosen.findings
        said = [name_controls(escape_controls(each.text)) for each in findings]
        name = [] if chosen is None or not said else [escape_controls(file_name(chosen.path))]
        self.findings.setText("\n".join([*name, *said]))

    def _choose_lamp(self, place: int) -> None:
        names = [file_name(one.path) for one in self.capture.photographs]
        lamp = self.dome.lamps[place]
        self.preview.light(lamp.elevation_deg, lamp.azimuth_deg)
        if lamp.name in names:
            self.list.choose(names.index(lamp.name))

    def _refresh(self) -> None:
        """Offer what can be done now."""
        running = self.is_running
        enable(self.start, "It is running" if running else "Choose a folder" if self.folder is None else "")
        few = "" if self.capture.count >= FEWEST else "A capture needs two photographs at least"
        enable(self.finish, few if running else "Nothing is running", "Import the photographs that are there")
        self.cancel.setText("Cancel" if running else "Close")
        self.expected.setEnabled(not running)
        lack = find_lack()
        enable(self.camera, "It is running" if running else str(lack or ""))


def _with_preview(step: Step) -> Step:
    """A step with the capture and its preview, made where nobody waits; nobody knows how long a capture takes."""
    if not isinstance(step.partial, Capture):
        return Step(0.0, step.note)
    there = [(one.thumbnail, one.direction) for one in step.partial.photographs if one.verdict < Verdict.BAD]
    lit = [(image, each) for image, each in there if image is not None and each is not None]
    angles = np.radians([(90.0 - elevation, azimuth or 0.0) for _, (elevation, azimuth) in lit]).reshape(-1, 2)
    relit = relight_small([image for image, _ in lit], surface_direction(angles[:, 0], angles[:, 1])) if lit else None
    return Step(0.0, step.note, (step.partial, relit))


def _row(one: Arrived) -> Row:
    elevation, azimuth = one.direction or (math.nan, None)
    worst = max(one.findings, key=lambda each: each.verdict, default=None)
    return Row(file_name(one.path), elevation, azimuth, one.verdict, "" if worst is None else worst.text)


def _lamps(capture: Capture) -> list[Lamp]:
    """Lamps of photographs that are there, then those that are expected; on an arc as if it lay on the right."""
    there = [one for one in capture.photographs if one.direction is not None]
    found = [
        Lamp(file_name(one.path), one.direction[0], one.direction[1] or 0.0, None, False)
        for one in there
        if one.direction is not None
    ]
    taken = [one.direction for one in there]
    missing = [each for each in capture.listed if each not in taken]
    return [*(Lamp("", elevation, azimuth or 0.0, None, True) for elevation, azimuth in missing), *found]
