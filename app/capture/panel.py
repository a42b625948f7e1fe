"""The right side of the Capture workspace: the capture, the choices of the import, and its report."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QPushButton

from app.capture.import_panel import ImportPanel
from app.document.document import Project
from app.document.import_choices import points_of, reference_of
from app.jobs.jobs import Job
from app.widgets.panels import Panel, button, enable, text
from app.widgets.report import Report
from engine.capture.lights.azimuth_spread import ONE_ARC, azimuth_spread
from engine.capture.scale import EXTENT_HINT, extent_text

if TYPE_CHECKING:
    from app.commands.workbench import Workbench
    from engine.capture.stack import ImageStack

ANGLES = {
    "capture.toml": "capture.toml",
    "lp": "light positions",
    "dome": "dome",
    "lights": "calibrated lights",
    "file names": "file names",
    "assumed": "assumed",
    "user": "entered",
    "mirror sphere": "mirror sphere",
    "photographs": "estimated from the photographs",
}


class CapturePanel(Panel):
    """Shows figures, choices and findings of a project."""

    def __init__(self, bench: Workbench) -> None:
        super().__init__()
        self.bench = bench
        capture = self.section("Capture")
        self.resolution = capture.figure("Size")
        self.extent, self.figures = capture.figure("Extent", EXTENT_HINT), capture
        self.camera = capture.figure("Camera")
        self.angles = capture.figure("Angles", "Source of the light's elevations")
        self.angle_words = text("", "warning", wrap=True)
        capture.wide(self.angle_words)
        settings = self.section("Import")
        self.options = ImportPanel()
        settings.wide(self.options)
        self.again = button("Import again")
        settings.wide(self.again)
        report = self.section("Report")
        self.report = Report()
        report.wide(self.report)
        self.build = button("Build material", "primary")
        self.build.clicked.connect(bench.build_material)
        self.finish(self.build)

    def show_figures(self, project: Project) -> None:
        """Show the figures of the stack, or without one those of the photographs."""
        stack = project.stack
        self.resolution.setText("–" if stack is None else size_of(stack))
        extent = (
            "" if stack is None else extent_text(stack.provenance, stack.radiance.shape[2], stack.radiance.shape[1])
        )
        self.extent.setText(extent)
        self.figures.show_row(self.extent, bool(extent))
        cameras = stack.provenance.get("cameras") or stack.provenance.get("camera") if stack is not None else None
        unknown = "not recorded" if stack is not None else "–"
        camera = ", ".join(map(str, cameras)) if isinstance(cameras, (list, tuple)) else str(cameras or unknown)
        self.camera.setText(self.camera.fontMetrics().elidedText(camera, Qt.TextElideMode.ElideRight, 150))
        self.camera.setToolTip(camera)
        source = stack.angle_source if stack is not None else project.sources.angle_source if project.sources else ""
        self.angles.setText(ANGLES.get(source, "–"))
        self.angle_words.setVisible(source == "assumed")
        self.angle_words.setText(
            "No angles were found, so even steps are assumed. Double-click an angle to correct it: elevation / azimuth."
        )
        self.report.show_health(stack.health if stack is not None else None)

    def show_choices(self, project: Project) -> str:
        """Show the import choices; returns the reason why they cannot be changed, or ""."""
        stack = project.stack
        size = (stack.radiance.shape[2], stack.radiance.shape[1]) if stack is not None else None
        provenance = stack.provenance if stack is not None else {}
        has_pairs = project.sources is not None and bool(project.sources.crossed)
        self.options.show_choices(project.import_choices, size, provenance, has_pairs)
        points = points_of(project)
        self.options.show_points({name: len(pairs) for name, pairs in points.items()}, find_unaligned(stack))
        why_not = "" if project.sources is not None and stack is not None else "Needs the photographs"
        measured = project.import_choices.sphere or (project.sources is not None and project.sources.sphere is not None)
        azimuth = stack.azimuth if stack is not None else None
        self.options.disable(why_not, measured=measured, one_sided=azimuth_spread(azimuth) <= ONE_ARC)
        return why_not

    @property
    def main_button(self) -> QPushButton:
        """The button of what comes next: to read the photographs again where settings changed, else to build."""
        return self.again if self.again.isEnabled() else self.build

    def update_buttons(self, project: Project) -> None:
        """Disable what cannot be done now, and say why."""
        enable(self.again, self._why_not_again(project), "Read the photographs with these settings (Ctrl+Enter)")
        words = "Linearise the photographs into slices and compress them (Ctrl+Enter)"
        enable(self.build, self._why_not_build(project), words)
        self.build.setText("Rebuild material" if project.has_map else "Build material")

    def _why_not_again(self, project: Project) -> str:
        if project.sources is None:
            return "There are no photographs to read again"
        if _running(self.bench.importing):
            return "The photographs are being imported"
        is_as_chosen = project.stack is not None and project.import_choices == project.imported_with
        return "Nothing was changed" if is_as_chosen else ""

    def _why_not_build(self, project: Project) -> str:
        if project.stack is None:
            return "Waiting for the photographs"
        if _running(self.bench.building):
            return "The material is being built"
        return "The material is up to date" if project.has_map and project.built_from == project.recipe else ""

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        self.options.fold.apply_theme()
        self.report.show_health(self.report.health)


def size_of(stack: ImageStack) -> str:
    """The size of the images of a stack."""
    height, width = stack.radiance.shape[1:3]
    return f"{width} × {height} px"


def find_unaligned(stack: ImageStack | None) -> tuple[str, ...]:
    """The photographs that the last import was asked to align and could not."""
    if stack is None or not stack.quality or stack.provenance.get("motion", "none") == "none":
        return ()
    pairs = zip(stack.sources, stack.quality, strict=True)
    named = stack.provenance.get("aligned_to")
    return tuple(name for name, quality in pairs if quality.alignment_residual_px is None and name != named)


def first_to_mark(project: Project, current: str | None) -> str | None:
    """The photograph in which points are marked first: the current one, unless another needs it more."""
    names, lost, reference = (
        project.stack.sources if project.stack is not None else (),
        find_unaligned(project.stack),
        None,
    )
    reference = reference_of(project)
    if lost and current not in lost:
        return next((name for name in lost if name != reference), current)
    if current == reference:
        return next((name for name in names if name != reference), current)
    return current


def _running(job: Job | None) -> bool:
    return job is not None and not job.over
