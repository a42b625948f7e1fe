"""Findings in plain words, worst first; one that concerns a photograph leads there."""

from __future__ import annotations

from html import escape

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QVBoxLayout, QWidget

from app.widgets import theme
from app.widgets import theme as icons
from app.widgets.import_controls import name_controls
from app.widgets.panels import text
from app.widgets.status_bar import VERDICTS
from app.widgets.theme import STEP
from engine.core.health import Finding, Health, Verdict

SHOWN = 12


class Report(QWidget):
    """Shows the findings of a `Health`. `show_source(name)` asks for the photograph a finding concerns."""

    show_source = Signal(str)

    def __init__(self, before: str = "Appears after import.") -> None:
        """`before` is said where there is no result yet."""
        super().__init__()
        self.before = before
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)
        self.column.setSpacing(2 * STEP)
        self.health: Health | None = None
        self.show_health(None)

    def show_health(self, health: Health | None) -> None:
        """Show another health; None if there is no result yet."""
        self.health = health
        while (item := self.column.takeAt(0)) is not None:
            if (old := item.widget()) is not None:
                old.hide()
                old.deleteLater()
        if health is None:
            self.column.addWidget(text(self.before, "secondary", wrap=True))
            return
        findings = sorted(health.summary, key=lambda finding: -finding.verdict)
        for finding in findings[:SHOWN]:
            self.column.addWidget(self._row(finding))
        if not findings:
            self.column.addWidget(self._row(Finding(Verdict.GOOD, "Nothing needs attention.")))
        if len(findings) > SHOWN:
            self.column.addWidget(text(f"and {len(findings) - SHOWN} more in the log", "secondary"))

    def _row(self, finding: Finding) -> QWidget:
        name, look, _ = VERDICTS[finding.verdict]
        row = QWidget()
        grid = QGridLayout(row)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(2 * STEP)
        mark = QLabel()
        mark.setPixmap(icons.pixmap(name, 16, getattr(theme.current(), look), self.devicePixelRatioF()))
        grid.addWidget(mark, 0, 0, Qt.AlignmentFlag.AlignTop)
        grid.addWidget(self._words(finding), 0, 1)
        grid.setColumnStretch(1, 1)
        return row

    def _words(self, finding: Finding) -> QLabel:
        """The sentence; the photograph it begins with is a link."""
        words = QLabel()
        words.setWordWrap(True)
        words.setMinimumWidth(10)
        if finding.source is None:
            words.setTextFormat(Qt.TextFormat.PlainText)
            words.setText(name_controls(f"{finding.text[:1].upper()}{finding.text[1:]}"))
            return words
        source = finding.source
        words.setTextFormat(Qt.TextFormat.RichText)
        words.setText(
            f'<a style="color:{theme.current().accent};text-decoration:none" href="source">{escape(source)}</a>'
            f"{finding.between}{escape(name_controls(finding.text))}"
        )
        words.setTextInteractionFlags(
            Qt.TextInteractionFlag.LinksAccessibleByMouse | Qt.TextInteractionFlag.LinksAccessibleByKeyboard
        )
        words.linkActivated.connect(lambda _link: self.show_source.emit(source))
        return words
