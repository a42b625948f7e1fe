"""The Export workspace: what the bundle will hold, where it goes, and whether it arrived sound."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from PySide6.QtCore import QBuffer, QByteArray, QIODevice, Qt, Signal
from PySide6.QtGui import QImage, QShowEvent
from PySide6.QtWidgets import (
    QCheckBox,
    QFileDialog,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QWidget,
)

from app.document import Project
from app.image_view import ImageView
from app.jobs import Job
from app.panels import EmptyState, Panel, Rows, button, enable, text, with_empty_state
from app.pictures import Picture
from app.status_bar import size_text
from app.theme import ROW, STEP, role
from app.workbench import Exported, Workbench
from engine.errors import OutputError

WIDTH = 372

PARTS = (
    ("slices", "Shading map, all slices", "shading_map.exr"),
    ("power-law", "Power law, scale and exponent", "power_law_scale.exr, power_law_exponent.exr"),
)
ALWAYS = (
    ("Reflectance", "brdf.json"),
    ("Shader", "shader/lightarc.glsl"),
    ("Preview", "preview.png"),
    ("Manifest with provenance", "manifest.json"),
)


class ExportTab(QWidget):
    """Writes the project's material as a bundle."""

    capture_wanted = Signal()
    sample_wanted = Signal()

    def __init__(self, bench: Workbench, take_picture: Callable[[], QImage]) -> None:
        super().__init__()
        self.bench = bench
        self.take_picture = take_picture
        self.folder = Path.home() if Path.home().is_dir() else Path.cwd()
        self.exporting: Job | None = None
        self.image = ImageView()
        self.empty = self._make_empty()
        self.pages = with_empty_state(self, self.empty, self._make_work())
        bench.document.changed.connect(self._changed)
        bench.jobs.changed.connect(lambda _job: self._update_buttons())
        self._changed(Project(), bench.document.project)

    def _make_empty(self) -> EmptyState:
        return EmptyState(
            "bundle",
            "Nothing to export yet",
            "A bundle holds the material with everything that another program needs to show it. Import photographs "
            "first; the material is built from them.",
            (("Go to Capture", "", self.capture_wanted), ("Try the sample capture", "sample", self.sample_wanted)),
        )

    def _make_work(self) -> QWidget:
        work = QWidget()
        row = QHBoxLayout(work)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(1)
        row.addWidget(self.image, 1)
        row.addWidget(self._make_right())
        return work

    def _make_right(self) -> QWidget:
        panel = Panel(WIDTH)
        place = panel.section("Bundle")
        self.name = QLineEdit()
        self.name.setMaxLength(120)
        self.name.textChanged.connect(lambda _text: self._update_buttons())
        place.row("Name", self.name, "Ends in .lightarc: one file. Otherwise a folder.")
        self.place = text("", "")
        self.place.setMinimumWidth(10)
        choose = button("Change…")
        choose.clicked.connect(self._choose_folder)
        beside = QHBoxLayout()
        beside.setContentsMargins(0, 0, 0, 0)
        beside.setSpacing(2 * STEP)
        beside.addWidget(self.place, 1)
        beside.addWidget(choose)
        holder = QWidget()
        holder.setLayout(beside)
        place.row("Folder", holder)
        contents = panel.section("Contents")
        self.parts: dict[str, tuple[QCheckBox, QLabel]] = {}
        for value, words, file in PARTS:
            box = QCheckBox(words)
            box.setChecked(True)
            box.setToolTip(file)
            box.toggled.connect(lambda _on: self._update_buttons())
            self.parts[value] = (box, _figure())
            _add(contents, box, self.parts[value][1])
        for words, file in ALWAYS:
            line = text(words)
            line.setToolTip(file)
            line.setContentsMargins(24, 0, 0, 0)
            _add(contents, line, _figure())
        self.total = _figure()
        _add(contents, text("Together, at most", "title"), self.total)
        panel.column.addSpacing(3 * STEP)
        self.export = button("Export bundle", "primary")
        self.export.clicked.connect(self.start)
        panel.column.addWidget(self.export)
        self.result = panel.section("Result")
        self.verdict = text("", wrap=True)
        self.result.wide(self.verdict)
        self.files = text("", "secondary", wrap=True)
        self.result.wide(self.files)
        panel.finish()
        return panel

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.image.show_picture(Picture((self.take_picture(),)))

    @property
    def target(self) -> Path:
        """Where the bundle goes."""
        return self.folder / self.name.text().strip()

    def start(self) -> None:
        """Write the bundle; what exists is replaced only if it is a bundle."""
        include = frozenset(value for value, (box, _) in self.parts.items() if box.isChecked() and box.isEnabled())
        preview = _png(self.take_picture())
        self._say("Writing…", "secondary", "")
        self.exporting = self.bench.export(self.target, include, preview)
        self.exporting.succeeded.connect(self._exported)
        self.exporting.failed.connect(lambda error: self._say(f"Not written: {_problem(error)}", "bad", ""))
        self.exporting.cancelled.connect(lambda: self._say("Cancelled. Nothing was written.", "secondary", ""))
        self._update_buttons()

    def fit(self) -> None:
        """Show the whole preview."""
        self.image.fit()

    def _exported(self, done: Exported) -> None:
        if done.problems:
            self._say("Written, but not sound: " + " ".join(done.problems), "bad", "")
            return
        lines = [f"{name}  {size_text(size)}" for name, size in sorted(done.members.items(), key=lambda item: -item[1])]
        total = size_text(sum(done.members.values()))
        self._say(f"{done.path.name} written and verified: {len(lines)} members, {total}.", "good", "\n".join(lines))
        self.bench.said.emit(f"{done.path} written and verified")

    def _say(self, words: str, look: str, files: str) -> None:
        self.verdict.setText(words)
        role(self.verdict, look)
        self.files.setText(files)
        self.files.setVisible(bool(files))

    def _choose_folder(self) -> None:
        chosen = QFileDialog.getExistingDirectory(self, "Folder for the bundle", str(self.folder))
        if chosen:
            self.set_folder(Path(chosen))

    def set_folder(self, folder: Path) -> None:
        """Export into `folder` from now on."""
        self.folder = folder
        self._show_folder()

    def _show_folder(self) -> None:
        words = self.place.fontMetrics().elidedText(str(self.folder), Qt.TextElideMode.ElideMiddle, 150)
        self.place.setText(words)
        self.place.setToolTip(str(self.folder))

    def _changed(self, old: Project, new: Project) -> None:
        self.pages.setCurrentIndex(1 if new.has_map else 0)
        if new.name != old.name or not self.name.text():
            self.name.setText(f"{new.name}.lightarc")
        if new.material is not old.material or not self.place.text():
            self._show_sizes(new)
            self._show_folder()
        if new.material.shading_map is not old.material.shading_map:
            self._say("Nothing written yet.", "secondary", "")
        if self.isVisible():
            self.image.show_picture(Picture((self.take_picture(),)))
        self._update_buttons()

    def _show_sizes(self, project: Project) -> None:
        for value, size_bytes in part_sizes(project).items():
            box, figure = self.parts[value]
            enable(box, "" if size_bytes else "This material has none", {v: f for v, _, f in PARTS}[value])
            figure.setText(size_text(size_bytes) if size_bytes else "–")

    def _update_buttons(self) -> None:
        sizes = part_sizes(self.bench.document.project)
        chosen = [value for value, (box, _) in self.parts.items() if box.isChecked() and box.isEnabled()]
        self.total.setText(size_text(sum(sizes[value] for value in chosen)))
        name = self.name.text().strip()
        why_not = ""
        if self.exporting is not None and not self.exporting.over:
            why_not = "The bundle is being written"
        elif not chosen:
            why_not = "Choose the slices, the power law, or both"
        elif not name or name in (".", "..") or Path(name).name != name:
            why_not = "Give the bundle a name without slashes"
        enable(self.export, why_not, "Write the bundle and check it")

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.empty.apply_theme()
        self.image.update()


def part_sizes(project: Project) -> dict[str, int]:
    """Bytes of each part before compression, 0 where the material lacks it."""
    shading_map, power_law = project.material.shading_map, project.material.power_law
    return {
        "slices": shading_map.slices.nbytes if shading_map is not None else 0,
        "power-law": power_law.size_bytes if power_law is not None else 0,
    }


def _figure() -> QLabel:
    figure = text("", "secondary")
    figure.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return figure


def _add(rows: Rows, left: QWidget, right: QWidget) -> None:
    holder = QWidget()
    holder.setFixedHeight(ROW)
    line = QHBoxLayout(holder)
    line.setContentsMargins(0, 0, 0, 0)
    line.addWidget(left, 1)
    line.addWidget(right)
    rows.wide(holder)


def _png(image: QImage) -> bytes:
    content = QByteArray()
    buffer = QBuffer(content)
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    image.save(buffer, "PNG")  # type: ignore[call-overload]
    return bytes(content.data())


def _problem(error: Any) -> str:
    return f"{error.problem}." if isinstance(error, OutputError) else "see the message."
