"""Exports for other programs: every target as a card with its preview and its loss, and the choices for all.

Errors, sizes and previews that were measured before are shown at once; the others are measured when the user asks for
it, card by card, or with the export that states them. What cannot be written of this material says why in one sentence.
"""

from __future__ import annotations

import dataclasses
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

from app.commands.export_elsewhere import (
    Known,
    Sent,
    find_measured_before,
    seconds_to_measure,
    send,
    smallest_of,
)
from app.commands.export_elsewhere import (
    offer as offered,
)
from app.commands.surface import take_maps
from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.exporting import MAX_ERROR_PERCENT, MAX_WIDTH_MM, REPEATS, Exporting
from app.export.card import Board, Card
from app.export.credits_fields import CreditsFields
from app.jobs.jobs import Job
from app.jobs.newest import Latest
from app.project.interrupted import propose_parts, propose_place
from app.project.losses import OWN
from app.session.settings import UNITS_MM
from app.widgets.controls import ComboBox
from app.widgets.fitting import breakable
from app.widgets.number_field import NumberField
from app.widgets.panels import Panel, button, enable, scroll_to, text, with_buttons
from app.widgets.theme import role
from app.widgets.workspace import side_by_side
from engine.core.errors import OutputError
from engine.core.figure_text import percent, size_text, time_text
from engine.core.steps import Step, Steps, relay
from engine.exchange.targets import EXPORTERS

if TYPE_CHECKING:
    from engine.exchange.export import Departure, Offer

WIDTH = 300

#: Room for the folder beside its button.
WITHIN_PX = 88

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


#: What the figures are, once all of them are there.
MEASURED = "Errors are relative, and measured on a preview sphere under three environments."


class Elsewhere(QWidget):
    """The page of the Export workspace that writes a material for other programs."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        self.leaving: Departure | None = None
        self.found: dict[str, Offer] = {}
        self.keys: Mapping[str, str] = {}
        self.exporting: Job | None = None
        self.written = bench.output_folder
        self.asked = 0
        self.is_looked_up = self.is_measuring = self.goes_on = False
        self.looking = Latest(bench.jobs, "Looking for measured export errors")
        self.latest = Latest(
            bench.jobs, "Measuring the export error", self._on_progressed, self._on_stopped, lane="compute"
        )
        self.own = Card(
            "", "The material itself", "What a bundle holds; all others are compared with it", is_choice=False
        )
        self.cards = {name: Card(name, each.title, each.hint) for name, each in EXPORTERS.items()}
        for card in self.cards.values():
            assert card.box is not None
            card.box.clicked.connect(lambda _on: self._targets_chosen())
        self.board = Board([self.own, *self.cards.values()])
        row = QVBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(side_by_side(self.board, self._make_panel(), stretch=0))
        bench.output_moved.connect(lambda _folder: self._show_folder())
        self._show_settings(bench.document.project.exporting)
        self._show_folder()

    def _make_panel(self) -> QWidget:
        panel = Panel(WIDTH)
        costs = panel.section("Export error")
        self.state = text("", "secondary", wrap=True)
        costs.wide(self.state)
        self.measure = button("Measure export error")
        self.measure.clicked.connect(self.ask)
        self.stop = button("Stop", hint="Stop measuring. What was measured is kept")
        self.stop.clicked.connect(self._stop)
        costs.wide(self.measure)
        costs.wide(self.stop)
        self.remarks = text("", "warning", wrap=True)
        costs.wide(self.remarks)
        budget = panel.section("Smallest format under this error")
        self.budget = NumberField(5.0, 0.0, MAX_ERROR_PERCENT, unit="%")
        self.budget.edited.connect(lambda value, final: self._set("Error of an export", final, error_percent=value))
        budget.row("Error", self.budget, "Relative RMSE against the material itself that is still good enough")
        self.choose = button("Choose")
        self.choose.clicked.connect(self._choose_smallest)
        budget.wide(self.choose)
        self.chosen = text("", "secondary", wrap=True)
        budget.wide(self.chosen)
        textures = panel.section("Textures")
        self.preset, self.coding, self.normal = ComboBox(), ComboBox(), ComboBox()
        for part, box, entries, label, hint in (
            ("preset", self.preset, PRESETS, "Program", "Names and packing as its importer expects them"),
            ("coding", self.coding, CODINGS, "Files", "Bits of a value; OpenEXR holds half floats"),
            ("normal", self.normal, NORMALS, "Normals", "Direction of y in the map of normals"),
        ):
            for value, words in entries:
                box.addItem(words, value)
            box.activated.connect(
                lambda _index, part=part, box=box: self._set("Settings of textures", **{part: box.currentData()})
            )
            textures.row(label, box, hint)
        self.repeats = ComboBox()
        for count in REPEATS:
            self.repeats.addItem("1 × 1, the sample" if count == 1 else f"{count} × {count}", count)
        self.repeats.activated.connect(lambda _index: self._set("Tile of exports", repeats=self.repeats.currentData()))
        hint = "A larger tile whose repeats all differ, for programs that repeat maps in a grid"
        panel.section("Tile").row("Repeats", self.repeats, f"{hint}; errors are measured with the export")
        page = panel.section("Web page")
        self.width_field = NumberField(0.0, 0.0, MAX_WIDTH_MM, unit="mm", nothing="not known")
        self.width_field.edited.connect(self._width_edited)
        page.row("Width", self.width_field, "Width of the sample, for a scale bar; empty where it is not known")
        self.credits = CreditsFields(self.bench, panel)
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
    def choices(self) -> Exporting:
        """The settings of exports in the project."""
        return self.bench.document.project.exporting

    def _set(self, words: str, final: bool = True, **parts: Any) -> None:
        """Change settings of the project; what is dragged is one step of its history."""
        document = self.bench.document
        settings = dataclasses.replace(self.choices, **parts)
        if settings != self.choices:
            document.change(words, gesture=words, exporting=settings)
        if final:
            document.end_gesture()

    def _width_edited(self, value: float, final: bool) -> None:
        width_mm = min(value * UNITS_MM[self.width_field.unit], MAX_WIDTH_MM)
        self._set("Width of the sample", final, width_mm=width_mm)

    def _targets_chosen(self) -> None:
        """A click chose other targets; those that this material cannot leave by stay as they were."""
        boxes = {name: card.box for name, card in self.cards.items() if card.box is not None}
        before = self.targets
        chosen = [name for name, box in boxes.items() if (box.isChecked() if box.isEnabled() else name in before)]
        self._set("Targets of an export", targets=tuple(chosen))

    def _choose(self, words: str, names: Collection[str]) -> None:
        self._set(words, targets=tuple(name for name in self.cards if name in names))

    @property
    def targets(self) -> tuple[str, ...]:
        """The targets that the project chooses, or that are proposed for its material."""
        project = self.bench.document.project
        return project.exporting.targets_for(is_directional=project.material.directional is not None)

    def _show_targets(self) -> None:
        for name, card in self.cards.items():
            if card.box is not None:
                card.box.setChecked(name in self.targets)

    def _show_settings(self, settings: Exporting) -> None:
        """Show the settings of the project."""
        self._show_targets()
        for box, value in zip((self.preset, self.coding, self.normal), settings.of_textures, strict=True):
            box.setCurrentIndex(box.findData(value))
        self.repeats.setCurrentIndex(self.repeats.findData(settings.repeats))
        self.budget.show_value(settings.error_percent)
        self.width_field.show_value(settings.width_mm / UNITS_MM[self.width_field.unit])

    def measure_in(self, unit: str) -> None:
        """Show lengths in one of `UNITS_MM`."""
        self.width_field.unit, self.width_field.high = unit, MAX_WIDTH_MM / UNITS_MM[unit]
        self.width_field.show_value(self.choices.width_mm / UNITS_MM[unit])

    @property
    def names(self) -> list[str]:
        """The targets that are chosen, in their order."""
        return [name for name, card in self.cards.items() if card.is_chosen]

    def offer(self, name: str) -> None:
        """Propose the name of what is open for the folder."""
        self.name.setText(f"{name} exports")

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self._look_up()

    def changed(self, old: Project, new: Project) -> None:
        """Follow the document: what was measured holds for one material and its photographs."""
        if new.name != old.name or not self.name.text():
            self.offer(new.name)
        if old is new or old.exporting != new.exporting or old.material is not new.material:
            self._show_settings(new.exporting)
        self.credits.show_project(new)
        if old is new or _list_dependencies(old) != _list_dependencies(new):
            self.looking.drop()
            self.goes_on = False
            self._drop()
            self.leaving, self.found, self.keys = None, {}, {}
            for card in (self.own, *self.cards.values()):
                card.forget()
            self.chosen.setText("")
            self._say("Nothing written yet.", "secondary")
            self.is_looked_up = False
        elif old.exporting.of_textures != new.exporting.of_textures:
            self._drop()
            self.found.pop("textures", None)
            self.cards["textures"].forget()
            self.is_looked_up = False
        if self.isVisible():
            self._look_up()
        self._update()

    def _look_up(self) -> None:
        """Show what was measured before; nothing is measured."""
        project = self.bench.document.project
        if self.is_looked_up or not project.has_map:
            return
        self.is_looked_up = True
        folders = tuple(dict.fromkeys((self.bench.own, self.bench.folder)))
        self.looking.ask(lambda: find_measured_before(project, tuple(self.cards), folders), self._on_found_before)

    def _on_found_before(self, known: Known) -> None:
        self.keys = known.keys
        for name, offer in known.offers.items():
            if name not in self.found:
                self._show_offer(offer)
        self._update()

    def _find_unmeasured(self) -> tuple[str, ...]:
        return tuple(name for name in self.cards if name not in self.found)

    def ask(self) -> None:
        """Measure all targets that were not measured yet, and keep what is found with the project."""
        project, leaving, wanted = self.bench.document.project, self.leaving, self._find_unmeasured()
        if not project.has_map or not wanted:
            return
        self.asked += 1
        number, known, folder = self.asked, Known(dict(self.found), self.keys), self.bench.own
        self.latest.ask(
            lambda: _number(number, project, offered(project, leaving, known, wanted, folder)),
            lambda _found: self._end(),
            lambda _error: self._end("Not measured: see the message."),
        )
        self.is_measuring = True
        self._update("Measuring…")

    def _on_progressed(self, step: Step) -> None:
        """Show what the newest job has found so far."""
        number, project, found = step.partial
        if number != self.asked:
            return
        if found is None:
            self.state.setText(f"{percent(step.done)} · {step.note}")
        else:
            self._take(project, found)

    def _take(self, project: Project, found: Any) -> None:
        """Keep what a job has found on its way: a surface, the material that is ready, or an offer."""
        if hasattr(found, "maps"):
            take_maps(self.bench, project, found)
        elif hasattr(found, "subject"):
            self.leaving = found
        else:
            self._show_offer(found)
            self._update(self.state.text())

    def _show_offer(self, offer: Offer) -> None:
        self.found[offer.target] = offer
        card = self.own if offer.target == OWN else self.cards[offer.target]
        if offer.why_not:
            card.refuse(offer.why_not)
        else:
            card.show_entry(offer.entry, offer.sphere)

    def _stop(self) -> None:
        self.goes_on = False
        self._drop()
        self._on_stopped()

    def _on_stopped(self) -> None:
        self._end("Stopped. What was measured is kept.")

    def _drop(self) -> None:
        """Measure no further, and take nothing more of what was asked for."""
        self.asked += 1
        self.is_measuring = False
        self.latest.drop()

    def _end(self, words: str = "") -> None:
        self.is_measuring = False
        self._update(words)

    def _choose_smallest(self) -> None:
        """Choose the target alone that `--to auto` would write."""
        best = smallest_of(list(self.found.values()), 0.01 * self.budget.value)
        self._choose("Choose the smallest format", (best["chosen"],))
        row = next(row for row in best["candidates"] if row["target"] == best["chosen"])
        kept = "keeps it at" if best["within"] else "is nearest, and no representation keeps it:"
        error = "–" if row["rmse_rel_reference"] is None else percent(row["rmse_rel_reference"], 3)
        by = f" by its {row['by']}" if "by" in row else ""
        self.chosen.setText(f"{self.cards[best['chosen']].title}{by} {kept} {error}, {size_text(row['bytes'])}.")

    def start(self) -> None:
        """Write the chosen targets; a folder that exists is replaced only if it is an export."""
        project, leaving, names = self.bench.document.project, self.leaving, self.names
        folder, own, known = self.target, self.bench.own, Known(dict(self.found), self.keys)
        self.goes_on = self.is_measuring
        self._drop()  # what was asked for last comes first, and measures some of the same
        self._say("Writing…", "secondary")
        again = {"kind": "exports", "folder": str(folder.parent), "name": folder.name, "parts": names}
        self.exporting = self.bench.jobs.submit(
            f"Exporting to {folder.name}",
            lambda: send(project, leaving, known, names, folder, own),
            lane="compute",
            again=again,
            resource=str(folder),
            on_stop="Nothing is written if you stop it.",
        )
        self.exporting.progressed.connect(lambda step: self._export_progressed(project, step))
        self.exporting.succeeded.connect(self._on_exported)
        self.exporting.failed.connect(lambda error: self._say(f"Not written: {_problem(error)}", "bad"))
        self.exporting.cancelled.connect(lambda: self._say("Cancelled. Nothing was written.", "secondary"))
        for ended in (self.exporting.succeeded, self.exporting.failed, self.exporting.cancelled):
            ended.connect(lambda *_: self._go_on_measuring())
        self._update("Goes on after the export." if self.goes_on else "")

    def _export_progressed(self, project: Project, step: Step) -> None:
        """Take what an export has found on its way, unless it is of another material than that of the project now."""
        now, found = self.bench.document.project, step.partial
        is_current = _list_dependencies(project) == _list_dependencies(now)
        if getattr(found, "target", "") == "textures":
            is_current &= project.exporting.of_textures == now.exporting.of_textures
        if found is not None and is_current:
            self._take(project, found)

    def _go_on_measuring(self) -> None:
        """Measure what is left, where an export came between and nobody has stopped it."""
        if self.goes_on:
            self.goes_on = False
            self.ask()
        self._update()

    def go_on(self, again: Mapping[str, Any]) -> None:
        """Ask for the folder of exports that were interrupted, and write them there anew.

        A material that has gone since leaves nothing to ask for.
        """
        place = propose_place(again, self.bench.output_folder, self.name.text())
        self.name.setText(place.name)
        self._choose("Targets of an export", propose_parts(again))
        if self.names and self.bench.document.project.has_map and self._choose_folder(place.parent):
            self.export.click()

    def _on_exported(self, done: Sent) -> None:
        self.written = done.folder
        count, total = len(done.files), size_text(sum(done.files.values()))
        self._say(f"{done.folder.name} written: {count} files, {total}.", "good", done.files)
        self.bench.said.emit(f"{done.folder} written")

    def _say(self, words: str, look: str, files: Mapping[str, int] = MappingProxyType({})) -> None:
        """Show the result of an export, and its files."""
        self.verdict.setText(words)
        role(self.verdict, look)
        self.files.setText("\n".join(f"{breakable(name)}, {size_text(size)}" for name, size in files.items()))
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
        folder = self.bench.output_folder
        home = Path(os.path.expanduser("~"))  # noqa: PTH111 - Path.home raises without one
        shown = str(Path("~", folder.relative_to(home)) if folder.is_relative_to(home) else folder)
        self.place.setText(self.place.fontMetrics().elidedText(shown, Qt.TextElideMode.ElideMiddle, WITHIN_PX))
        self.place.setToolTip(str(folder))
        self._update()

    def _update(self, words: str = "") -> None:
        """Show what can be done now; `words` are the state of measuring, where it is not that of the figures."""
        busy, names, left = self.is_measuring, self.names, self._find_unmeasured()
        self.stop.setVisible(busy or self.goes_on)
        self.measure.setVisible(not busy and not self.goes_on and bool(left))
        cost = f"about {time_text(self._seconds(len(left)))}" if left else ""
        self.measure.setToolTip(f"Measure errors and sizes of {len(left)} targets, {cost}; kept with the project")
        plural = "target is" if len(left) == 1 else "targets are"
        resting = f"{len(left)} {plural} not measured. Measuring takes {cost}." if left else MEASURED
        if words or not (busy or self.goes_on):
            self.state.setText(words or resting)
        measured = [offer for name, offer in self.found.items() if name in self.cards and offer.sphere is not None]
        enable(self.choose, "" if measured else "Nothing is measured yet", "Choose the one that --to auto would write")
        self.remarks.setText("\n".join(self._remarks()))
        self.remarks.setVisible(bool(self.remarks.text()))
        self.export.setText(f"Export {len(names)} target{'s' * (len(names) != 1)}" if names else "Export")
        enable(self.export, self._why_not(), "Write a folder with one folder for each target (Ctrl+Enter)")

    def _seconds(self, count: int) -> float:
        """Estimated seconds to measure so many targets, rounded to what an estimate is worth."""
        seconds = seconds_to_measure(self.bench.document.project, count, is_ready=self.leaving is not None)
        return max(1.0, float(f"{seconds:.1g}"))

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


def _list_dependencies(project: Project) -> tuple[int, ...]:
    """What the errors of all targets depend on, by identity; settings of textures concern these alone."""
    parts = (project.material, project.stack, project.excluded, project.white)
    return tuple(map(id, parts))


def _number(number: int, project: Project, steps: Steps[Any]) -> Steps[Any]:
    """`steps` that say which request they belong to, and to which project, beside their partial results."""
    return relay(steps, lambda step: Step(step.done, step.note, (number, project, step.partial)))


def _problem(error: BaseException) -> str:
    return f"{error.problem}." if isinstance(error, OutputError) else "see the message."
