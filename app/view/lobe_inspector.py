"""The lobe inspector: the transport of one vertex towards one view, in Gaussians, wavelets and spherical harmonics.

A click on the model chooses the vertex. Images show the hemisphere above it in false colour, all on one scale, and
under each its error against the first (Green, Kautz, Matusik and Durand 2006, Figure 5, at a place of one's own).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QAccessible, QColor, QImage, QPainter, QPaintEvent
from PySide6.QtWidgets import QDockWidget, QHBoxLayout, QVBoxLayout, QWidget

from app.jobs.newest import Latest
from app.widgets import theme
from app.widgets.controls import ComboBox
from app.widgets.fitting import Fitting
from app.widgets.panels import text
from app.widgets.theme import PADDING, ROW, STEP, role
from engine.brdf.brdf import Brdf
from engine.core.directions import normalize
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps, part
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import caster_of
from engine.transport.gaussian.fitting.views import view_directions

if TYPE_CHECKING:
    from app.commands.workbench import Workbench
    from app.view.tab import ViewTab
    from engine.figures.inspected import Inspected
    from engine.transport.gaussian.samples import GlossySurface
    from engine.transport.gaussian.transfer import GaussianTransport

#: Views that can be chosen beside the camera's.
VIEWS = 92

#: Messages shown where there is nothing to inspect, and their shorter forms.
SHORT = {
    "Click the model to choose a vertex. Its lobes are those of a bake in Gaussians, or else fitted to one view.": (
        "Click the model to choose a vertex.",
        "Click the model",
    ),
    "This BRDF has no glossy part.": ("Not glossy",),
    "This vertex faces away from this view.": ("Faces away",),
}
ASK, DIFFUSE, AWAY = SHORT


@dataclass(frozen=True, eq=False)
class Question:
    """The vertex to inspect, seen at `pixel` of a screen of `size`, or `vertex`; towards `view`, or the camera."""

    mesh: Mesh
    ground: Ground | None
    brdf: Brdf
    camera: Camera
    transport: GaussianTransport | None
    lobes: int
    vertex: int | None
    pixel: tuple[float, float] | None
    size: tuple[int, int]
    view: int | None


@dataclass(frozen=True, eq=False)
class Answer:
    """`found` is None where nothing can be shown, and `reason` says why."""

    question: Question
    vertex: int | None
    found: Inspected | None
    reason: str = ""


class LobeInspector(QDockWidget):
    """Shows the images while it is open; they are computed in the background."""

    def __init__(self, bench: Workbench, view: ViewTab, parent: QWidget) -> None:
        super().__init__("Lobe inspector", parent)
        self.setObjectName("lobes")
        self.bench, self.view = bench, view
        self.vertex: int | None = None
        self.answer: Answer | None = None
        self._mesh: Mesh | None = None
        self._kept = _Kept()
        self._asking = Latest(bench.jobs, "Inspecting a vertex")
        self.words = Fitting()
        self.words.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self.words.say(ASK, *SHORT[ASK])
        self.towards = ComboBox()
        self.towards.addItem("The camera", None)
        for direction in range(VIEWS):
            self.towards.addItem(f"View {direction + 1}", direction)
        self.towards.setAccessibleName("View")
        self.towards.setToolTip("Direction of the view: the camera, or one of the 92 stored views")
        self.towards.activated.connect(lambda _index: self._ask())
        self.images = [HemisphereImage() for _ in range(4)]
        self.setWidget(self._lay_out())
        view.viewport.clicked.connect(self._on_clicked)
        view.viewport.rested.connect(self._look_again)
        view.bakings["gaussian"].relit_changed.connect(self._ask)
        bench.document.changed.connect(lambda _old, _new: self._look_again())
        self.visibilityChanged.connect(lambda visible: self._look_again() if visible else self._mark(None))

    def _lay_out(self) -> QWidget:
        inside = role(QWidget(), "panel")
        inside.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        head = QHBoxLayout()
        head.setSpacing(2 * STEP)
        head.addWidget(text("Towards", "secondary"))
        head.addWidget(self.towards)
        head.addWidget(self.words, 1)
        row = QHBoxLayout()
        row.setSpacing(PADDING)
        for image in self.images:
            row.addWidget(image, 1)
        column = QVBoxLayout(inside)
        column.setContentsMargins(PADDING, 2 * STEP, PADDING, 2 * STEP)
        column.addLayout(head)
        column.addLayout(row, 1)
        return inside

    def sizeHint(self) -> QSize:
        return QSize(640, 240)

    def _on_clicked(self, point: QPointF) -> None:
        if self.isVisible():
            self._ask((point.x(), point.y()))

    def _look_again(self) -> None:
        """Answer the same question anew after the model, its BRDF or the camera has changed."""
        scene = self.view.viewport.scene
        if scene is not None and scene.mesh is not self._mesh:
            self._mesh, self.vertex = scene.mesh, None
            self._show(None, ASK)
        if self.vertex is not None:
            self._ask()

    def _ask(self, pixel: tuple[float, float] | None = None) -> None:
        viewport = self.view.viewport
        scene, camera = viewport.scene, viewport.camera
        if not self.isVisible() or scene is None or camera is None or (pixel is None and self.vertex is None):
            return
        baking = self.view.bakings["gaussian"]
        transport = baking.made.transport if baking.made is not None and baking.is_drawable(scene) else None
        question = Question(
            scene.mesh,
            scene.ground,
            scene.brdf,
            camera,
            transport,
            baking.choices.value("lobes"),
            self.vertex,
            pixel,
            (viewport.width(), viewport.height()),
            self.towards.currentData(),
        )
        self._asking.ask(lambda: _answer(question, self._kept), self._take)

    def _take(self, answer: Answer) -> None:
        scene = self.view.viewport.scene
        if scene is None or answer.question.mesh is not scene.mesh or answer.vertex is None:
            return
        self._mesh, self.vertex = scene.mesh, answer.vertex
        self._show(answer, answer.reason)
        self._mark(answer.vertex)

    def _mark(self, vertex: int | None) -> None:
        """Ring the vertex in the viewport."""
        overlay, scene = self.view.viewport.overlay, self.view.viewport.scene
        shown = vertex is not None and scene is not None and self.isVisible()
        overlay.mark = tuple(scene.mesh.positions[vertex].tolist()) if shown and scene is not None else None
        overlay.update()

    def _show(self, answer: Answer | None, words: str) -> None:
        self.answer = answer
        found = answer.found if answer is not None else None
        if answer is None or found is None:
            self.words.say(words, *SHORT.get(words, ()))
            for image in self.images:
                image.show_nothing()
            return
        angle = f"seen {np.degrees(np.arccos(np.clip(found.cosine, -1.0, 1.0))):.0f}° from the normal"
        source = "lobes of the bake" if found.baked else "lobes fitted to this view alone"
        start = f"Vertex {answer.vertex:,}".replace(",", " ")
        self.words.say(f"{start}, {angle}; {source}", f"{start}, {angle}", start)
        self.images[0].show_values(
            found.image, found.highest, "Tabulated transport", f"to {number(found.highest, 3)} / sr"
        )
        for image, each in zip(self.images[1:], found.approximations, strict=True):
            error = f"error {percent(each.error_rel)}"
            image.show_values(each.image, found.highest, f"{each.name}, {each.numbers} numbers", error)

    def apply_theme(self) -> None:
        """Redraw what does not follow the palette by itself."""
        for image in self.images:
            image.update()


class HemisphereImage(QWidget):
    """A disc in false colour with two lines of words under it."""

    accessible_role = QAccessible.Role.Graphic

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Lobes of a vertex")
        self.image: QImage | None = None
        self.title = self.figure = ""
        self.setMinimumSize(96, 96 + 2 * ROW - 8)

    def show_nothing(self) -> None:
        """Leave the place empty."""
        self.image, self.title, self.figure = None, "", ""
        self.setAccessibleName("Lobes of a vertex")
        self.update()

    def show_values(self, values: NDArray[np.float32], highest: float, title: str, figure: str) -> None:
        """`values` (N, N), NaN outside the disc, from 0 to `highest`."""
        self.title, self.figure = title, figure
        self.setAccessibleName(f"{title}: {figure}")
        inside = np.isfinite(values)
        share = np.clip(np.where(inside, values, 0.0) / (highest if highest > 0.0 else 1.0), 0.0, 1.0)
        rgba = np.zeros((*values.shape, 4), np.uint8)
        from app.widgets.plots import colour_table

        rgba[..., :3] = colour_table("viridis")[np.rint(255.0 * share).astype(np.int64)]
        rgba[..., 3] = np.where(inside, 255, 0)
        height, width = values.shape
        self.image = QImage(rgba.tobytes(), width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        below = 2 * 18
        edge = min(self.width(), self.height() - below)
        place = QRectF((self.width() - edge) / 2, 0, edge, edge)
        colours = theme.current()
        if self.image is None:
            return
        painter.drawImage(place, self.image)
        painter.setFont(theme.font(12))
        for line, (words, colour) in enumerate(((self.title, colours.text), (self.figure, colours.secondary))):
            painter.setPen(QColor(colour))
            row = QRectF(0, edge + 2 + 17 * line, self.width(), 17)
            metrics = painter.fontMetrics()
            shorter = (words, words.removesuffix(" numbers"), words.split(",")[0], words.split()[0])
            fitted = next((form for form in shorter if metrics.horizontalAdvance(form) <= self.width()), shorter[-1])
            painter.drawText(row, Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignVCenter, fitted)


class _Kept:
    """The model that was asked about last, with what its transport takes."""

    def __init__(self) -> None:
        self.of: tuple[Mesh, Ground | None, Brdf] | None = None
        self.surface: GlossySurface | None = None


def _answer(question: Question, kept: _Kept) -> Steps[Answer]:
    yield Step(0.0, "looking at the model")
    from engine.figures.inspected import inspect
    from engine.transport.gaussian.samples import glossy_surface

    vertex = question.vertex if question.pixel is None else _pick(question)
    if vertex is None:
        return Answer(question, None, None)
    mesh, ground, brdf = question.mesh, question.ground, question.brdf
    before = kept.of
    if before is None or before[0] is not mesh or before[1:] != (ground, brdf) or kept.surface is None:
        kept.surface = glossy_surface(mesh, brdf, ground)
        kept.of = (mesh, ground, brdf)
    surface = kept.surface
    if surface.material.glossy is None:
        return Answer(question, vertex, None, DIFFUSE)
    eye = np.asarray(question.camera.eye) - mesh.positions[vertex]
    towards = normalize(eye) if question.view is None else view_directions()[question.view]
    if float(towards @ surface.frames[vertex][:, 2]) <= 0.0:
        return Answer(question, vertex, None, AWAY)
    steps = inspect(surface, vertex, towards, question.transport, question.lobes)
    return Answer(question, vertex, (yield from part(steps, 0.2, 1.0)))


def _pick(question: Question) -> int | None:
    """The vertex nearest to the surface point at the pixel; None beside the model."""
    assert question.pixel is not None
    x, y = question.pixel
    mesh = question.mesh
    ray = question.camera.rays(np.array([x]), np.array([y]), *question.size)
    hit = caster_of(mesh).intersect(np.array([question.camera.eye]), ray)
    if hit.face[0] < 0:
        return None
    return int(mesh.faces[hit.face[0]][int(np.argmax(hit.barycentric[0]))])
