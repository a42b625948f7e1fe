"""Exports for other programs: every target as a card with its preview and its loss, and the choices for all.

Errors, sizes and previews are measured in a job as soon as somebody looks, card by card, and again where a choice
changes them. What cannot be written of this material says why in one sentence.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QDesktopServices, QShowEvent
from PySide6.QtWidgets import (
    QFileDialog,
    QLineEdit,
    QVBoxLayout,
    QWidget,
)

from app.commands.export_elsewhere import Choices, Sent, offered, sent, smallest_of
from app.commands.workbench import Workbench
from app.document.document import Project
from app.export.card import Board, Card
from app.jobs.jobs import Job
from app.jobs.newest import Latest
from app.project.interrupted import proposed_parts, proposed_place
from app.session.settings import UNITS_MM
from app.widgets.controls import ComboBox
from app.widgets.number_field import NumberField
from app.widgets.panels import Panel, button, enable, scroll_to, text, with_buttons
from app.widgets.theme import role
from app.widgets.workspace import side_by_side
from engine.core.errors import OutputError
from engine.core.figure_text import percent, size_text
from engine.core.steps import Step, Steps, relayed

if TYPE_CHECKING:
    from engine.exchange.export import Departure, Offer

WIDTH = 300

#: Width of the widest sample.
WIDEST_MM = 100_000.0

#: Room for the folder beside its button.
WITHIN_PX = 88

#: Targets of `engine.exchange.export`, in its order: name, title, hint.
TARGETS = (
    ("textures", "Textures", "Base colour, normal, roughness and the like, named and packed for a program"),
    ("materialx", "MaterialX", "OpenPBR and glTF PBR surfaces as .mtlx"),
    ("gltf", "glTF", "A ball with the material as .glb, for the web and engines"),
    ("usd", "USD", "A ball with UsdPreviewSurface as .usdz, for pipelines and Quick Look"),
    (
        "blender",
        "Blender",
        "A script that makes two materials, PBR and the power law, and the .blend by Blender's module",
    ),
    ("shaders", "Shaders", "GLSL, HLSL and OSL that evaluate the material itself"),
    ("web", "Web page", "A page with a light to drag, for any browser and for strict sites"),
    ("rti", "RTI", ".ptm, .rti and a tree for web viewers, for conservators"),
    ("brdf", "BRDF tables", "CSV, ALTA, MERL, RGL, and the nearest model as MaterialX"),
)
FIRST = ("textures", "materialx", "gltf")

PRESETS = (
    ("blender", "Blender"),
    ("unreal", "Unreal"),
    ("unity", "Unity"),
    ("godot", "Godot"),
    ("substance", "Substance"),
    ("gltf", "glTF"),
)
CODINGS = (("png8", "PNG, 8 bits"), ("png16", "PNG, 16 bits"), ("exr", "OpenEXR"))
NORMALS = (("", "As the program"), ("opengl", "y up (OpenGL)"), ("directx", "y down (DirectX)"))


class Elsewhere(QWidget):
    """The page of the Export workspace that writes a material for other programs."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.leaving: Departure | None = None
        self.found: dict[str, Offer] = {}
        self.exporting: Job | None = None
        self.written = bench.output_folder
        self.asked = 0
        self.latest = Latest(
            bench.jobs, "Measuring what leaving costs", self._progressed, self._stopped, lane="background"
        )
        self.own = Card(
            "", "The material itself", "What a bundle holds; all others are compared with it", is_choice=False
        )
        self.cards = {name: Card(name, title, hint) for name, title, hint in TARGETS}
        for name, card in self.cards.items():
            assert card.box is not None
            card.box.setChecked(name in FIRST)
            card.box.toggled.connect(lambda _on: self._update())
        self.board = Board([self.own, *self.cards.values()])
        row = QVBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(side_by_side(self.board, self._make_panel(), stretch=0))
        bench.output_moved.connect(lambda _folder: self._show_folder())
        self._show_folder()

    def _make_panel(self) -> QWidget:
        panel = Panel(WIDTH)
        costs = panel.section("What you lose by leaving")
        self.state = text("", "secondary", wrap=True)
        costs.wide(self.state)
        self.measure = button("Measure", hint="Measure errors and sizes of all targets")
        self.measure.clicked.connect(lambda: self.ask())
        self.stop = button("Stop", hint="Stop measuring; what was measured stays")
        self.stop.clicked.connect(self._stop)
        costs.wide(self.measure)
        costs.wide(self.stop)
        self.remarks = text("", "warning", wrap=True)
        costs.wide(self.remarks)
        budget = panel.section("Smallest within an error")
        self.budget = NumberField(5.0, 0.0, 1000.0, unit="%")
        budget.row("Error", self.budget, "Relative RMSE against the material itself that is still good enough")
        self.choose = button("Choose the smallest")
        self.choose.clicked.connect(self._choose_smallest)
        budget.wide(self.choose)
        self.chosen = text("", "secondary", wrap=True)
        budget.wide(self.chosen)
        textures = panel.section("Textures")
        self.preset, self.coding, self.normal = ComboBox(), ComboBox(), ComboBox()
        for box, entries, label, hint in (
            (self.preset, PRESETS, "Program", "Names and packing as its importer expects them"),
            (self.coding, CODINGS, "Files", "Bits of a value; OpenEXR holds half floats"),
            (self.normal, NORMALS, "Normals", "Direction of y in the map of normals"),
        ):
            for value, words in entries:
                box.addItem(words, value)
            box.activated.connect(lambda _index: self.ask(("textures",)))
            textures.row(label, box, hint)
        page = panel.section("Web page")
        self.width_field = NumberField(0.0, 0.0, WIDEST_MM, unit="mm", nothing="not known")
        page.row("Width", self.width_field, "Width of the sample, for a scale bar; empty where it is not known")
        place = panel.section("Folder")
        self.name = QLineEdit()
        self.name.setMaxLength(120)
        self.name.textChanged.connect(lambda _text: self._update())
        place.row("Name", self.name, "A folder with one folder for each target")
        self.place = text("")
        self.place.setMinimumWidth(10)
        change = button("Change…")
        change.clicked.connect(lambda: self._choose_folder(self.bench.output_folder))
        place.row("Within", with_buttons(self.place, change))
        result = self.result = panel.section("Result")
        self.verdict = text("Nothing written yet.", "secondary", wrap=True)
        self.files = text("", "secondary", wrap=True)
        self.show_folder = button("Show the folder", "link")
        self.show_folder.clicked.connect(self._open_folder)
        for widget in (self.verdict, self.files, self.show_folder):
            result.wide(widget)
        self.export = button("Export", "primary")
        self.export.clicked.connect(self.start)
        panel.finish(self.export)
        self._say("Nothing written yet.", "secondary")
        return panel

    @property
    def target(self) -> Path:
        """The folder to write."""
        return self.bench.output_folder / self.name.text().strip()

    @property
    def choices(self) -> Choices:
        textures = self.preset.currentData(), self.coding.currentData(), self.normal.currentData()
        return Choices(*textures, self.width_mm)

    @property
    def width_mm(self) -> float:
        """Width of the sample; 0 where it is not known."""
        return self.width_field.value * UNITS_MM[self.width_field.unit]

    def measure_in(self, unit: str) -> None:
        """Show lengths in one of `UNITS_MM`."""
        width_mm = self.width_mm
        self.width_field.unit, self.width_field.high = unit, WIDEST_MM / UNITS_MM[unit]
        self.width_field.show_value(width_mm / UNITS_MM[unit])

    @property
    def names(self) -> list[str]:
        """The targets that are chosen, in their order."""
        return [name for name, card in self.cards.items() if card.is_chosen]

    def offer(self, name: str) -> None:
        """Propose the name of what is open for the folder."""
        self.name.setText(f"{name} exports")

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        if not self.found and not self.latest.busy:
            self.ask()

    def changed(self, old: Project, new: Project) -> None:
        """Follow the document: what was measured holds for one material and its photographs."""
        if new.name != old.name or not self.name.text():
            self.offer(new.name)
        if old is new or old.material is not new.material or old.stack is not new.stack:
            self.latest.drop()
            self.leaving, self.found = None, {}
            for card in (self.own, *self.cards.values()):
                card.forget()
            self.chosen.setText("")
            self._say("Nothing written yet.", "secondary")
            if self.isVisible():
                self.ask()
        self._update()

    def ask(self, names: Collection[str] = ()) -> None:
        """Measure the targets `names` again, and all that were not measured yet."""
        project, choices, leaving = self.bench.document.project, self.choices, self.leaving
        wanted = tuple(name for name in self.cards if name in names or name not in self.found)
        if not project.has_map or not wanted:
            return
        self.latest.drop()
        for name in wanted:
            self.found.pop(name, None)
        self.asked += 1
        number = self.asked
        self.latest.ask(
            lambda: _numbered(number, offered(project, leaving, choices, wanted)),
            lambda _found: self._rest("Errors are relative, and measured on a ball under three environments."),
            lambda _error: self._rest("Not measured: see the message."),
        )
        self._rest("Measuring…")

    def _progressed(self, step: Step) -> None:
        """Show what the newest job has found so far."""
        number, found = step.partial
        if number != self.asked:
            return
        if found is None:
            self.state.setText(f"{percent(step.done)} · {step.note}")
            return
        if not hasattr(found, "target"):
            self.leaving = found
            unknown = {"flip": 0.0, "bytes": None, "bytes_per_texel": None}
            own = {"rmse_rel_reference": 0.0, "rmse_rel": found.own["rmse_rel"], **unknown}
            self.own.show_entry(own, found.ball())
            return
        self.found[found.target] = found
        card = self.cards[found.target]
        if found.why_not:
            card.refuse(found.why_not)
        else:
            card.show_entry(found.entry, found.ball)
        self._update()

    def _stopped(self) -> None:
        self._rest("Stopped. What was measured stays.")

    def _stop(self) -> None:
        self.asked += 1
        self.latest.drop()
        self._stopped()

    def _rest(self, words: str) -> None:
        self.state.setText(words)
        self._update()

    def _choose_smallest(self) -> None:
        """Choose the target alone that `--to auto` would write."""
        best = smallest_of(list(self.found.values()), 0.01 * self.budget.value)
        for name, card in self.cards.items():
            assert card.box is not None
            card.box.setChecked(name == best["chosen"])
        row = next(row for row in best["candidates"] if row["target"] == best["chosen"])
        kept = "keeps it at" if best["within"] else "is nearest, and no representation keeps it:"
        error = "–" if row["rmse_rel_reference"] is None else percent(row["rmse_rel_reference"], 3)
        by = f" by its {row['by']}" if "by" in row else ""
        self.chosen.setText(f"{self.cards[best['chosen']].title}{by} {kept} {error}, {size_text(row['bytes'])}.")

    def start(self) -> None:
        """Write the chosen targets; a folder that exists is replaced only if it is an export."""
        project, leaving, choices, names = self.bench.document.project, self.leaving, self.choices, self.names
        folder = self.target
        self._say("Writing…", "secondary")
        again = {"kind": "exports", "folder": str(folder.parent), "name": folder.name, "parts": names}
        self.exporting = self.bench.jobs.submit(
            "Exporting",
            lambda: sent(project, leaving, choices, names, folder),
            lane="compute",
            again=again,
            resource=str(folder),
        )
        self.exporting.succeeded.connect(self._exported)
        self.exporting.failed.connect(lambda error: self._say(f"Not written: {_problem(error)}", "bad"))
        self.exporting.cancelled.connect(lambda: self._say("Cancelled. Nothing was written.", "secondary"))
        self._update()

    def go_on(self, again: Mapping[str, Any]) -> None:
        """Ask for the folder of exports that were interrupted, and write them there anew.

        A material that has gone since leaves nothing to ask for.
        """
        place = proposed_place(again, self.bench.output_folder, self.name.text())
        self.name.setText(place.name)
        targets = proposed_parts(again)
        for name, card in self.cards.items():
            assert card.box is not None
            card.box.setChecked(name in targets)
        if self.names and self.bench.document.project.has_map and self._choose_folder(place.parent):
            self.export.click()

    def _exported(self, done: Sent) -> None:
        self.written = done.folder
        count, total = len(done.files), size_text(sum(done.files.values()))
        self._say(f"{done.folder.name} written: {count} files, {total}.", "good", done.files)
        self.bench.said.emit(f"{done.folder} written")

    def _say(self, words: str, look: str, files: Mapping[str, int] = MappingProxyType({})) -> None:
        """Show the result of an export, and its files."""
        self.verdict.setText(words)
        role(self.verdict, look)
        self.files.setText("\n".join(f"{_breakable(name)}, {size_text(size)}" for name, size in files.items()))
        for widget in (self.files, self.show_folder):
            widget.setVisible(bool(files))
        if look in ("good", "bad"):
            scroll_to(self.result)

    def _open_folder(self) -> None:
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.written)))

    def _choose_folder(self, proposed: Path) -> bool:
        """Ask for the folder; True if one was chosen."""
        chosen = QFileDialog.getExistingDirectory(self, "Folder for the exports", str(proposed))
        if chosen:
            self.bench.write_into(Path(chosen))
        return bool(chosen)

    def _show_folder(self) -> None:
        folder = str(self.bench.output_folder)
        self.place.setText(self.place.fontMetrics().elidedText(folder, Qt.TextElideMode.ElideMiddle, WITHIN_PX))
        self.place.setToolTip(folder)
        self._update()

    def _update(self) -> None:
        busy, names = self.latest.busy, self.names
        self.stop.setVisible(busy)
        self.measure.setVisible(not busy and len(self.found) < len(self.cards))
        measured = [offer for offer in self.found.values() if offer.entry and offer.ball is not None]
        enable(self.choose, "" if measured else "Nothing is measured yet", "Choose the one that --to auto would write")
        self.remarks.setText("\n".join(self._remarks()))
        self.remarks.setVisible(bool(self.remarks.text()))
        self.export.setText(f"Export {len(names)} target{'s' * (len(names) != 1)}" if names else "Export")
        enable(self.export, self._why_not(), "Write a folder with one folder for each target (Ctrl+Enter)")

    def _remarks(self) -> list[str]:
        """Warnings of the chosen targets, each sentence once with those that it holds for."""
        said: dict[str, list[str]] = {}
        for name in self.names:
            for words in self.found[name].entry.get("warnings", ()) if name in self.found else ():
                said.setdefault(words, []).append(self.cards[name].title)
        return [f"{', '.join(titles)}: {words}." for words, titles in said.items()]

    def _why_not(self) -> str:
        """The reason why nothing can be exported as things are."""
        name = self.name.text().strip()
        if self.exporting is not None and not self.exporting.over:
            return "An export is being written"
        if not self.names:
            return "Choose at least one target"
        if not name or name in (".", "..") or Path(name).name != name:
            return "Give the folder a name without slashes"
        if not os.access(self.bench.output_folder, os.W_OK | os.X_OK):
            return f"{self.bench.output_folder} cannot be written to; choose another folder"
        return ""


def _numbered(number: int, steps: Steps[Any]) -> Steps[Any]:
    """`steps` that say which request they belong to, beside their partial results."""
    return relayed(steps, lambda step: Step(step.done, step.note, (number, step.partial)))


def _breakable(path: str) -> str:
    """`path` with places where a line may break."""
    return path.replace("/", "/\u200b").replace("_", "_\u200b")


def _problem(error: Any) -> str:
    return f"{error.problem}." if isinstance(error, OutputError) else "see the message."
