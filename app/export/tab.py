"""The Export workspace: the bundle with its contents, path and verification, and exports for other programs."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import Qt, QUrl, Signal
from PySide6.QtGui import QDesktopServices, QKeySequence, QShortcut, QShowEvent
from PySide6.QtWidgets import QCheckBox, QFileDialog, QHBoxLayout, QLabel, QLineEdit, QWidget

from app.commands.export_bundle import Exported, draw
from app.commands.surface import is_current, material_with_surface
from app.commands.workbench import Workbench
from app.document.document import Look, Project
from app.document.following import Following
from app.export.credits_fields import CreditsFields
from app.export.elsewhere import Elsewhere
from app.jobs.jobs import Job
from app.jobs.newest import Latest
from app.project.interrupted import propose_parts, propose_place
from app.view.tab import ViewTab
from app.viewport.refining import same
from app.widgets.empty_state import EmptyState, with_empty_state
from app.widgets.image_view import Image, ImageView, rgb_image
from app.widgets.panels import Pages, Panel, Rows, Segments, button, enable, text, with_buttons
from app.widgets.theme import ROW, STEP, role
from app.widgets.workspace import bar_of_choices, side_by_side, under
from engine.core.errors import OutputError
from engine.core.figure_text import size_text
from engine.core.steps import Steps
from engine.shading.power_law import PowerLawMap

if TYPE_CHECKING:
    from engine.scene.scene import Scene

WIDTH = 372

#: Forms of the material in a bundle: their values, labels and files, and why a material may not have them.
PARTS = (
    ("slices", "Shading map, all slices", "shading_map.exr", "needs lamps on an arc"),
    (
        "power-law",
        "Power law",
        "Scale, exponent, map of errors, and the slices of kept tiles",
        "needs a shading map",
    ),
    (
        "planes",
        "Directional map, all planes",
        "directional_plane00.png and so on, their numbers and weights",
        "needs lamps all round",
    ),
    ("pbr", "PBR maps", "pbr_maps.exr, 32-bit floats with their uncertainty", "not made yet"),
)
ALWAYS = (
    ("BRDF", "brdf.json"),
    ("Shader", "shader/lightarc.glsl; PBR maps have none"),
    (
        "Viewer for a browser",
        "viewer/index.html, which shows the power law or planes under a light that can be dragged; PBR maps have none",
    ),
    ("Preview", "preview.png, as in the View workspace"),
    ("Manifest with provenance", "manifest.json"),
)
BUNDLES = "Bundles (*.lightarc);;Folders (*)"
STALE = "Settings were changed after this material was built. Rebuild it in Material before you export it."
VARIED = "Spatial variation (View) is kept in the project, not in bundles."


class ExportTab(QWidget):
    """Writes the project's material as a bundle, or for other programs, once `fill` has been through."""

    capture_wanted = Signal()
    sample_wanted = Signal()

    def __init__(self, bench: Workbench, view: ViewTab) -> None:
        super().__init__()
        self.bench = bench
        self.view = view
        self.exporting: Job | None = None
        self.written = bench.output_folder
        self.latest = Latest(bench.jobs, "Drawing the preview", stopped=self._preview_failed, lane="background")
        self.previewed: tuple[Scene, Look] | None = None

    def fill(self) -> Iterator[None]:
        """Make what is in it, a part with each step, and each at once where it stays: moving widgets costs time."""
        bench, view = self.bench, self.view
        self.image = ImageView()
        self.empty = self._make_empty()
        self.pages = with_empty_state(self, self.empty, self._make_work())
        yield
        self.elsewhere = Elsewhere(bench)
        self.form_pages.addWidget(self.elsewhere)
        yield
        begin = QShortcut(QKeySequence("Ctrl+Return"), self, context=Qt.ShortcutContext.WindowShortcut)
        begin.activated.connect(lambda: (self.elsewhere.export if self.is_elsewhere else self.export).click())
        view.model_ready.connect(self._draw_preview)
        self.following = Following(bench.document, self, self._on_changed)
        bench.output_moved.connect(lambda _folder: self._show_folder())
        bench.jobs.changed.connect(lambda _job: self._update_buttons())
        self._on_changed(Project(), bench.document.project)

    def _make_empty(self) -> EmptyState:
        return EmptyState(
            "bundle",
            "Nothing to export yet",
            "A bundle holds the material with everything that another program needs to show it. Import photographs "
            "first; the material is built from them.",
            (("Go to Capture", "", self.capture_wanted), ("Try the sample capture", "sample", self.sample_wanted)),
        )

    def _make_work(self) -> QWidget:
        self.forms = Segments(
            (
                ("bundle", "Bundle", "The material itself, as one file that this program opens again"),
                (
                    "elsewhere",
                    "Other programs",
                    "Textures, MaterialX, glTF, USD, shaders, RTI and more, and their losses",
                ),
            )
        )
        self.forms.choose("bundle")
        self.forms.chosen.connect(self.show_form)
        bar, row = bar_of_choices()
        row.addWidget(self.forms)
        row.addStretch(1)
        self.form_pages = Pages()
        self.form_pages.addWidget(side_by_side(self.image, self._make_right()))
        return under(bar, self.form_pages)

    @property
    def is_elsewhere(self) -> bool:
        """True while the page for other programs is shown."""
        return self.form_pages.currentIndex() == 1

    def show_form(self, form: str) -> None:
        """Show the page of the bundle, or that of other programs ('elsewhere')."""
        self.forms.choose(form)
        self.form_pages.setCurrentIndex(int(form == "elsewhere"))
        self._draw_preview()

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
        place.row("Folder", with_buttons(self.place, choose))
        contents = panel.section("Contents")
        self.parts: dict[str, tuple[QCheckBox, QLabel]] = {}
        for value, words, file, _ in PARTS:
            box = QCheckBox(words)
            box.setChecked(True)
            box.setToolTip(file)
            box.clicked.connect(lambda _on: self._parts_chosen())
            self.parts[value] = (box, _figure())
            _add(contents, box, self.parts[value][1])
        for words, file in ALWAYS:
            line = text(words)
            line.setToolTip(file)
            line.setContentsMargins(24, 0, 0, 0)
            _add(contents, line, _figure())
        self.total = _figure()
        _add(contents, text("Maps, before packing", "title"), self.total)
        self.stale = text(STALE, "warning", wrap=True)
        self.varied = text(VARIED, "secondary", wrap=True)
        contents.wide(self.stale)
        contents.wide(self.varied)
        self.credits = CreditsFields(self.bench, panel)
        panel.column.addSpacing(3 * STEP)
        self.export = button("Export bundle", "primary")
        self.export.clicked.connect(self.start)
        panel.column.addWidget(self.export)
        self.result = panel.section("Result")
        self.verdict = text("", wrap=True)
        self.result.wide(self.verdict)
        self.files, self.sizes = text("", "secondary"), _figure()
        self.members = QWidget()
        beside = QHBoxLayout(self.members)
        beside.setContentsMargins(0, STEP, 0, STEP)
        beside.addWidget(self.files, 1)
        beside.addWidget(self.sizes)
        self.result.wide(self.members)
        self.show_folder = button("Show the folder", "link")
        self.show_folder.clicked.connect(self._open_folder)
        self.result.wide(self.show_folder)
        panel.finish()
        return panel

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.view.want_model()
        self._draw_preview()
        self._update_buttons()

    def _draw_preview(self) -> None:
        """Draw what will be preview.png, while somebody looks."""
        project = self.bench.document.project
        scene = self.view.scene(project)
        if not self.isVisible() or self.is_elsewhere or not project.has_map or scene is None:
            return
        look, before = project.look, self.previewed
        if before is None or before[1] != look or not same(before[0], scene):
            self.previewed = scene, look
            self.latest.ask(lambda: _preview(draw(scene, look)), self.image.show_image, self._preview_failed)

    def _preview_failed(self, _error: BaseException | None = None) -> None:
        self.previewed = None

    @property
    def target(self) -> Path:
        """The path of the bundle to write."""
        return self.bench.output_folder / self.name.text().strip()

    def start(self) -> None:
        """Write the bundle; what exists is replaced only if it is a bundle."""
        self._say("Writing…", "secondary")
        scene = self.view.scene(self.bench.document.project)
        self.exporting = self.bench.export(self.target, frozenset(self._list_chosen()), scene)
        self.exporting.succeeded.connect(self._on_exported)
        self.exporting.failed.connect(lambda error: self._say(f"Not written: {_problem(error)}", "bad"))
        self.exporting.cancelled.connect(lambda: self._say("Cancelled. Nothing was written.", "secondary"))
        self._update_buttons()

    def go_on(self, again: Mapping[str, Any]) -> None:
        """Ask for the place of a bundle whose writing was interrupted, and write it there anew.

        A material that has gone since leaves nothing to ask for.
        """
        self.show_form("bundle")
        place = propose_place(again, self.bench.output_folder, self.name.text())
        self.name.setText(place.name)
        self._leave_out(frozenset(self.parts) - propose_parts(again))
        if not self._list_chosen():
            return
        chosen, _ = QFileDialog.getSaveFileName(self, "Export bundle", str(place), BUNDLES)
        if chosen:
            self.name.setText(Path(chosen).name)
            self.bench.write_into(Path(chosen).parent)
            self.export.click()

    def fit(self) -> None:
        """Show the whole preview."""
        self.image.fit()

    def _on_exported(self, done: Exported) -> None:
        if done.problems:
            self._say("Written, but not sound: " + " ".join(done.problems), "bad")
            return
        total = size_text(sum(done.members.values()))
        words = f"{done.path.name} written and verified: {len(done.members)} members, {total}."
        self._say(words, "good", done.members)
        self.written = done.path.parent
        self.bench.said.emit(f"{done.path} written and verified")

    def _parts_chosen(self) -> None:
        """A click chose other parts; those that this material lacks stay as they were."""
        before = self.bench.document.project.exporting.left_out
        is_out = {value: not box.isChecked() for value, (box, _) in self.parts.items() if box.isEnabled()}
        self._leave_out(frozenset(value for value in self.parts if is_out.get(value, value in before)))

    def _leave_out(self, parts: frozenset[str]) -> None:
        document = self.bench.document
        exporting = dataclasses.replace(document.project.exporting, left_out=parts)
        if exporting != document.project.exporting:
            document.change("Parts of the bundle", exporting=exporting)

    def _say(self, words: str, look: str, members: dict[str, int] | None = None) -> None:
        """Show the result of the export, and the largest members first."""
        self.verdict.setText(words)
        role(self.verdict, look)
        listed = sorted((members or {}).items(), key=lambda item: -item[1])
        self.files.setText("\n".join(name for name, _ in listed))
        self.sizes.setText("\n".join(size_text(size) for _, size in listed))
        for widget in (self.members, self.show_folder):
            widget.setVisible(bool(listed))

    def _open_folder(self) -> None:
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(self.written)))

    def _choose_folder(self) -> None:
        chosen = QFileDialog.getExistingDirectory(self, "Folder for the bundle", str(self.bench.output_folder))
        if chosen:
            self.bench.write_into(Path(chosen))

    def offer(self, name: str) -> None:
        """Propose the name of what is open for the bundle."""
        self.name.setText(f"{name}.lightarc")
        self.elsewhere.offer(name)

    def _show_folder(self) -> None:
        folder = str(self.bench.output_folder)
        self.place.setText(self.place.fontMetrics().elidedText(folder, Qt.TextElideMode.ElideMiddle, 150))
        self.place.setToolTip(folder)
        self._update_buttons()

    def _on_changed(self, old: Project, new: Project) -> None:
        self.pages.setCurrentIndex(1 if new.has_map else 0)
        if new.name != old.name or not self.name.text():
            self.offer(new.name)
        self.elsewhere.changed(old, new)
        self.credits.show_project(new)
        before, after = old.material, new.material
        is_other = before is not after or old.surface is not new.surface or old.surface_from is not new.surface_from
        if not self.place.text() or is_other or old.exporting != new.exporting or old.excluded != new.excluded:
            self._show_sizes(new)
            self._show_folder()
        if before.maps != after.maps:
            self._say("Nothing written yet.", "secondary")
        if old is not new:
            self._draw_preview()
        self.stale.setVisible(new.stack is not None and new.built_from != new.recipe)
        self.varied.setVisible(bool(new.variations))
        self._update_buttons()

    def _show_sizes(self, project: Project) -> None:
        sizes = part_sizes(project)
        for value, words, hint, why_not in PARTS:
            box, figure = self.parts[value]
            why_not = _why_no_maps(project) if value == "pbr" else why_not
            box.setChecked(bool(sizes[value]) and value not in project.exporting.left_out)
            enable(box, "" if sizes[value] else f"This material has none: {why_not}", hint)
            box.setText(_describe(project.material.power_law) if value == "power-law" else words)
            figure.setText(size_text(sizes[value]) if sizes[value] else why_not)

    def _list_chosen(self) -> list[str]:
        return [value for value, (box, _) in self.parts.items() if box.isChecked() and box.isEnabled()]

    def _update_buttons(self) -> None:
        sizes = part_sizes(self.bench.document.project)
        self.total.setText(size_text(sum(sizes[value] for value in self._list_chosen())))
        there = os.path.exists(self.target)  # noqa: PTH110 - Path.exists raises for names that are too long
        self.export.setText("Replace bundle" if there else "Export bundle")
        enable(self.export, self._why_not(), "Write the bundle and check it (Ctrl+Enter)")

    def _why_not(self) -> str:
        """The reason why nothing can be exported as things are."""
        name = self.name.text().strip()
        if self.exporting is not None and not self.exporting.over:
            return "The bundle is being written"
        if not self._list_chosen():
            return "Choose at least one form of the material"
        if not name or name in (".", "..") or Path(name).name != name:
            return "Give the bundle a name without slashes"
        if not os.access(self.bench.output_folder, os.W_OK | os.X_OK):
            return f"{self.bench.output_folder} cannot be written to; choose another folder"
        return ""

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.empty.apply_theme()
        self.image.update()


def part_sizes(project: Project) -> dict[str, int]:
    """Bytes of each part before compression, 0 where the material lacks it.

    PBR maps are those that the material is, or those of its surface.
    """
    material = material_with_surface(project)
    shading_map, power_law, directional = material.shading_map, material.power_law, material.directional
    maps = material.surface.maps if material.surface is not None else material.pbr
    return {
        "slices": shading_map.slices.nbytes if shading_map is not None else 0,
        "power-law": power_law.size_bytes if power_law is not None else 0,
        "planes": directional.planes.nbytes if directional is not None else 0,
        "pbr": 0 if maps is None else maps.size_bytes,
    }


def _why_no_maps(project: Project) -> str:
    """Why no PBR maps can go into the bundle, in a few words."""
    if project.surface is None:
        return "make them in Material"
    return "of other texels" if is_current(project) else "out of date"


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


def _describe(power_law: PowerLawMap | None) -> str:
    """The row of the power law: how it is stored, and whether tiles keep their slices."""
    if power_law is None:
        return "Power law"
    kept = " and kept tiles" if power_law.kept is not None else ""
    return f"Power law, {power_law.storage.exponent_bits} bits{kept}"


def _preview(drawing: Steps[Any]) -> Steps[Image]:
    return Image((rgb_image((yield from drawing)),))


def _problem(error: BaseException) -> str:
    return f"{error.problem}." if isinstance(error, OutputError) else "see the message."
