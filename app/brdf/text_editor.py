"""The text of a BRDF in GLSL in a window of its own: what is typed is compiled after a pause, and seen in all views.

A mistake is told below the text and marked at its line; until it is mended, the views keep the last BRDF that compiled.
"""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QRect, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QFontDatabase, QPainter, QPaintEvent, QResizeEvent, QTextCursor, QTextFormat
from PySide6.QtWidgets import QDialog, QFileDialog, QHBoxLayout, QPlainTextEdit, QTextEdit, QVBoxLayout, QWidget

from app.brdf.written_form import compile_text
from app.commands.brdf import save_text
from app.commands.workbench import Workbench
from app.document.comparison import Entry
from app.document.document import Project
from app.jobs.newest import Latest
from app.widgets import theme
from app.widgets.panels import button, text
from app.widgets.theme import PADDING, STEP, role
from engine.brdf.written import SourceError, WrittenBrdf
from engine.core.errors import FileError, MissingCapability

#: Pause after the last key before the text is compiled.
PAUSE_MS = 500

SIZE_PX, MIN_PX = QSize(680, 640), QSize(420, 300)
SPACES = 4


class NumberedText(QPlainTextEdit):
    """Text with the numbers of its lines, of which one can be marked as wrong."""

    def __init__(self) -> None:
        super().__init__()
        self.wrong_line = 0
        self.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.setTabStopDistance(SPACES * self.fontMetrics().horizontalAdvance(" "))
        self.setLineWrapMode(QPlainTextEdit.LineWrapMode.NoWrap)
        self.setAccessibleName("Text of the BRDF")
        self.numbers = _Numbers(self)
        self.blockCountChanged.connect(lambda _count: self._make_room())
        self.updateRequest.connect(lambda _rect, _by: self.numbers.update())
        self._make_room()

    def mark(self, line: int) -> None:
        """Mark line number `line`, which counts from 1; 0 marks none."""
        self.wrong_line = line
        block = self.document().findBlockByNumber(line - 1)
        marks = []
        if line and block.isValid():
            selection = QTextEdit.ExtraSelection()
            background = QColor(theme.current().bad)
            background.setAlpha(60)
            selection.format.setBackground(background)
            selection.format.setProperty(QTextFormat.Property.FullWidthSelection, True)
            selection.cursor = QTextCursor(block)
            marks.append(selection)
        self.setExtraSelections(marks)
        self.numbers.update()

    def number_width(self) -> int:
        """Pixels that the numbers take."""
        digits = len(str(max(1, self.blockCount())))
        return self.fontMetrics().horizontalAdvance("9" * max(2, digits)) + 3 * STEP

    def _make_room(self) -> None:
        self.setViewportMargins(self.number_width(), 0, 0, 0)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        inside = self.contentsRect()
        self.numbers.setGeometry(QRect(inside.left(), inside.top(), self.number_width(), inside.height()))

    def paint_numbers(self, painter: QPainter) -> None:
        """Draw the numbers of the lines in sight; that of the wrong one in the colour of mistakes."""
        colours, block = theme.current(), self.firstVisibleBlock()
        painter.fillRect(self.numbers.rect(), QColor(colours.panel))
        painter.setFont(self.font())
        width = self.numbers.width() - STEP
        while block.isValid():
            place = self.blockBoundingGeometry(block).translated(self.contentOffset())
            if place.top() > self.numbers.height():
                return
            number = block.blockNumber() + 1
            painter.setPen(QColor(colours.bad if number == self.wrong_line else colours.secondary))
            box = QRect(0, round(place.top()), width, self.fontMetrics().height())
            painter.drawText(box, Qt.AlignmentFlag.AlignRight, str(number))
            block = block.next()


class _Numbers(QWidget):
    def __init__(self, edit: NumberedText) -> None:
        super().__init__(edit)
        self.edit = edit

    def paintEvent(self, _event: QPaintEvent) -> None:
        self.edit.paint_numbers(QPainter(self))


class TextEditor(QDialog):
    """Edits the text of the entry `identity`. `edited(identity, brdf)` is a text that compiled."""

    edited = Signal(int, object)

    def __init__(self, parent: QWidget, bench: Workbench, entry: Entry) -> None:
        super().__init__(parent)
        assert isinstance(entry.brdf, WrittenBrdf)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setMinimumSize(MIN_PX)
        self.resize(SIZE_PX)
        self.bench, self.identity, self.name = bench, entry.identity, entry.name
        self.setWindowTitle(f"{entry.name}, written in GLSL")
        self.latest = Latest(bench.jobs, "Compiling GLSL")
        self.pause = QTimer(self)
        self.pause.setSingleShot(True)
        self.pause.setInterval(PAUSE_MS)
        self.pause.timeout.connect(self.compile)
        self.edit = NumberedText()
        self.applied = entry.brdf.text
        self.edit.setPlainText(self.applied)
        self.edit.textChanged.connect(self._on_typed)
        self.verdict = text("", "secondary", wrap=True)
        self.verdict.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.save = button("Save as…", hint="As a .brdf file, which opens here and in BRDF Explorer")
        self.save.clicked.connect(self._save)
        done = button("Close", "primary")
        done.clicked.connect(self.close)
        foot = QHBoxLayout()
        foot.addWidget(self.verdict, 1)
        foot.addWidget(self.save)
        foot.addWidget(done)
        for each in (self.save, done):
            each.setAutoDefault(False)
        column = QVBoxLayout(self)
        column.setContentsMargins(PADDING, PADDING, PADDING, PADDING)
        column.setSpacing(2 * STEP)
        column.addWidget(self.edit, 1)
        column.addLayout(foot)
        self._say("Compiles half a second after the last key", "secondary")
        bench.document.changed.connect(self._on_changed)

    @property
    def written(self) -> str:
        """The text as it stands in the editor."""
        return self.edit.toPlainText()

    def _on_typed(self) -> None:
        self.pause.start()

    def compile(self) -> None:
        """Compile what is written, beside the window, and let the views follow."""
        wanted = self.written
        if wanted != self.applied:
            self.latest.ask(lambda: compile_text(wanted, self.name), lambda found: self._on_compiled(wanted, found))
        else:
            self._say("Compiled", "secondary")

    def _on_compiled(self, wanted: str, found: WrittenBrdf | FileError | MissingCapability) -> None:
        if isinstance(found, WrittenBrdf):
            self.applied = wanted
            doubts = " ".join(found.health.warnings)
            self._say(doubts or "Compiled", "warning" if doubts else "good")
            self.edited.emit(self.identity, found)
        elif isinstance(found, FileError):
            line = found.line if isinstance(found, SourceError) else 0
            self._say(f"{found.problem[:1].upper()}{found.problem[1:]}. {found.remedy}.", "bad", line)
        else:
            self._say(f"{found}", "bad")

    def _say(self, words: str, look: str, line: int = 0) -> None:
        self.verdict.setText(words)
        role(self.verdict, look)
        self.edit.mark(line)

    def _on_changed(self, _old: Project, new: Project) -> None:
        """Follow an undo or a slider; what is typed and not compiled yet stays."""
        entry = new.comparison.find(self.identity)
        if entry is None or not isinstance(entry.brdf, WrittenBrdf):
            self.close()
        elif entry.brdf.text != self.applied and self.written == self.applied:
            self.applied = entry.brdf.text
            place = self.edit.textCursor().position()
            self.edit.blockSignals(True)
            self.edit.setPlainText(self.applied)
            self.edit.blockSignals(False)
            cursor = self.edit.textCursor()
            cursor.setPosition(min(place, len(self.applied)))
            self.edit.setTextCursor(cursor)

    def _save(self) -> None:
        proposed = f"{self.bench.propose(self.name, 'brdf')}.brdf"
        chosen, _ = QFileDialog.getSaveFileName(self, "Save the text", proposed, "BRDF Explorer (*.brdf)")
        if chosen:
            path = Path(chosen)
            self.bench.write_into(path.parent)
            save_text(self.bench, self.written, path if path.suffix else path.with_suffix(".brdf"))

    def done(self, result: int) -> None:
        """Compile what was typed last before the editor goes."""
        self.bench.document.changed.disconnect(self._on_changed)
        self.pause.stop()
        self.latest.drop()
        super().done(result)
