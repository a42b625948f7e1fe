"""Findings in plain words, worst first; one that concerns a photograph leads there."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QGridLayout, QLabel, QVBoxLayout, QWidget

from app import icons, theme
from app.panels import button, text
from app.status_bar import VERDICTS
from app.theme import STEP
from engine.health import Finding, Health, Verdict

SHOWN = 12


class Report(QWidget):
    """Shows the findings of a `Health`. `show_source(name)` asks for the photograph a finding concerns."""

    show_source = Signal(str)

    def __init__(self) -> None:
        super().__init__()
        self.column = QVBoxLayout(self)
        self.column.setContentsMargins(0, 0, 0, 0)
        self.column.setSpacing(2 * STEP)
        self.health: Health | None = None
        self.show_health(None)

    def show_health(self, health: Health | None) -> None:
        """Replace what is shown; None means that there is nothing to judge yet."""
        self.health = health
        while (item := self.column.takeAt(0)) is not None:
            if (old := item.widget()) is not None:
                old.hide()
                old.deleteLater()
        if health is None:
            self.column.addWidget(text("Follows the import.", "secondary"))
            return
        findings = sorted(health.findings, key=lambda finding: -finding.verdict)
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
        grid.setVerticalSpacing(0)
        mark = QLabel()
        mark.setPixmap(icons.pixmap(name, 16, getattr(theme.current(), look), self.devicePixelRatioF()))
        grid.addWidget(mark, 0, 0, Qt.AlignmentFlag.AlignTop)
        words = text(f"{finding.text[:1].upper()}{finding.text[1:]}", wrap=True)
        words.setMinimumWidth(10)
        grid.addWidget(words, 0, 1)
        grid.setColumnStretch(1, 1)
        if finding.source:
            source = finding.source
            link = button(source, "link", hint=f"Show {source}")
            link.clicked.connect(lambda: self.show_source.emit(source))
            grid.addWidget(link, 1, 1)
        return row
