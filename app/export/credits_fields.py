"""Title, author, licence and source of a material, which all its files state."""

from __future__ import annotations

import dataclasses

from PySide6.QtWidgets import QLineEdit

from app.commands.surface import credits_of_sources
from app.commands.workbench import Workbench
from app.document.document import Project
from app.widgets.panels import Panel
from engine.scene.credits import LONGEST, clean

#: Entries with the label and the hint of each.
ENTRIES = (
    ("title", "Title", "Title of the work"),
    ("author", "Author", "Who made it"),
    ("licence", "License", "An SPDX identifier as CC-BY-4.0, or words"),
    ("source", "Source", "An address or a reference"),
)


class CreditsFields:
    """A section of a panel; what photographs or the material state stands in a field until a user writes there."""

    def __init__(self, bench: Workbench, panel: Panel) -> None:
        self.bench = bench
        self.fields: dict[str, QLineEdit] = {}
        rows = panel.section("Credits")
        for name, label, hint in ENTRIES:
            field = self.fields[name] = QLineEdit()
            field.setMaxLength(LONGEST)
            field.editingFinished.connect(lambda name=name: self._take_entry(name))
            rows.row(label, field, f"{hint}; written into all files of an export")

    def show_project(self, project: Project) -> None:
        """Show the credits of `project`, and in grey those that its material and its photographs state."""
        stated = credits_of_sources(project)
        for name, field in self.fields.items():
            if not field.hasFocus():  # else somebody is writing
                field.setText(getattr(project.exporting.credits, name))
            field.setPlaceholderText(getattr(stated, name) or (stated.copyright if name == "author" else ""))

    def _take_entry(self, name: str) -> None:
        document = self.bench.document
        exporting = document.project.exporting
        credits = dataclasses.replace(exporting.credits, **{name: clean(self.fields[name].text())})
        if credits != exporting.credits:
            document.change("Credits", exporting=dataclasses.replace(exporting, credits=credits))
