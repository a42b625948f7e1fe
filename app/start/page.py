"""The start page: examples that open at once, three starting points, and all projects of the user.

The page only asks and shows. Lists, sizes and thumbnails come from a job of the background, piece by piece; the
commands on projects are jobs as well.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PySide6.QtCore import QPoint, QRect, QSize, Qt, QUrl, Signal
from PySide6.QtGui import (
    QAccessible,
    QColor,
    QDesktopServices,
    QEnterEvent,
    QFocusEvent,
    QImage,
    QImageReader,
    QKeyEvent,
    QKeySequence,
    QMouseEvent,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QResizeEvent,
    QShortcut,
)
from PySide6.QtWidgets import (
    QAbstractButton,
    QBoxLayout,
    QFrame,
    QHBoxLayout,
    QInputDialog,
    QLineEdit,
    QMenu,
    QScrollArea,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

from app.commands.workbench import Workbench
from app.jobs.jobs import Job
from app.project.cleaning import CleanedUp, clean_up
from app.project.listing import Listed, list_projects, size_of_project
from app.project.places import file_name
from app.project.upkeep import move_to_trash, rename
from app.start.examples import EXAMPLES, Example
from app.start.project_list import ProjectList
from app.widgets import theme
from app.widgets.panels import button, enable, text
from app.widgets.theme import PADDING, STEP, role
from engine.core.figure_text import size_text
from engine.core.steps import Step, Steps

#: Width of the examples next to projects, and the largest width of the page, in pixels.
EXAMPLES_WIDTH, MAX_WIDTH = 300, 1480

#: Height of the image of an example over its width, where no projects are there.
IMAGE_SHAPE = 0.72

#: Projects whose sizes and thumbnails are handed over at once.
BATCH = 8


@dataclass(frozen=True)
class StartingPoint:
    """A way to begin: its icon, its title and what can be opened there."""

    name: str
    icon: str
    title: str
    about: str


STARTING_POINTS = (
    StartingPoint("photographs", "capture", "Photographs", "A material or an object under a moving light"),
    StartingPoint("brdf", "brdf", "BRDF or material", "Measured BRDFs, PBR textures, MaterialX, a bundle"),
    StartingPoint("model", "view", "Model and environment", "A mesh and an HDR environment that lights it"),
)


@dataclass(frozen=True, eq=False)
class Details:
    """Sizes and thumbnails of some projects, as they arrive."""

    of: tuple[tuple[Path, int, QImage], ...]


def read_projects(
    folder: Path, others: Iterable[Path], left_out: Path | None, thumbnail: Callable[[Path], QImage]
) -> Steps[None]:
    """The projects, then their sizes and thumbnails: the partial results are a tuple of `Listed`, then `Details`."""
    yield Step(0.0, "reading the list of projects")
    found = tuple(each for each in list_projects(folder, others) if each.path != left_out)
    yield Step(0.1, "reading the list of projects", partial=found)
    for first in range(0, len(found), BATCH):
        paths = [each.path for each in found[first : first + BATCH]]
        details = Details(tuple((path, size_of_project(path), thumbnail(path)) for path in paths))
        yield Step(0.1 + 0.9 * first / len(found), "reading thumbnails", partial=details)


class StartPage(QScrollArea):
    """Shown at a start without files, and by File > Projects.

    Signals
    -------
    open_wanted : the path of a project.
    example_wanted : an `Example`.
    start_wanted : the name of one of `STARTING_POINTS`.
    renamed : the paths of a project before and after. gone : the path of one that is in the trash.
    clean_wanted : the project that is open in this window is to be closed and cleaned up.
    approached : the pointer moves over a card or a project, or a card gets the focus. A pointer that only lies where
        the page appears announces nothing.
    """

    accessible_role = QAccessible.Role.Pane

    open_wanted = Signal(object)
    example_wanted = Signal(object)
    start_wanted = Signal(str)
    renamed = Signal(object, object)
    gone = Signal(object)
    clean_wanted = Signal()
    approached = Signal()

    def __init__(
        self,
        bench: Workbench,
        folder: Path,
        remembered: Callable[[], Iterable[Path]],
        opened: Callable[[], Path],
        is_worth_keeping: Callable[[], bool],
        thumbnail: Callable[[Path], QImage],
    ) -> None:
        """`folder` holds the untitled projects. `remembered` gives those that were ever opened, `opened` the path of
        the one of this window,
        `is_worth_keeping` is true where that holds work, and `thumbnail` gives the image of one, on any thread."""
        super().__init__()
        self.bench, self.folder, self.remembered, self.thumbnail = bench, folder, remembered, thumbnail
        self.opened, self.is_worth_keeping = opened, is_worth_keeping
        role(self, "canvas")
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setWidgetResizable(True)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setAccessibleName("Start page")
        self.cards = [ExampleCard(example) for example in EXAMPLES if example.image.is_file()]
        self.points = [PointCard(point) for point in STARTING_POINTS]
        for card in self.cards:
            card.clicked.connect(partial(self._open_example, card))
        for point in self.points:
            point.clicked.connect(partial(self.start_wanted.emit, point.point.name))
        self.list = ProjectList()
        for each in (*self.cards, *self.points):
            each.approached.connect(self.approached)
        self.list.entered.connect(lambda _index: self.approached.emit())
        self._lay_out()
        self._connect_projects()
        self.apply_theme()
        self._show_projects(())

    def _lay_out(self) -> None:
        self.examples = QWidget()
        self.examples_box = QBoxLayout(QBoxLayout.Direction.LeftToRight, self.examples)
        self.examples_box.setContentsMargins(0, 0, 0, 0)
        self.examples_box.setSpacing(4 * STEP)
        for card in self.cards:
            self.examples_box.addWidget(card, 1)
        points = QHBoxLayout()
        points.setSpacing(4 * STEP)
        for point in self.points:
            points.addWidget(point, 1)
        self.projects = self._projects()
        self.body = QBoxLayout(QBoxLayout.Direction.LeftToRight)
        self.body.setSpacing(6 * STEP)
        self.body.addWidget(self.projects, 1)
        left = QVBoxLayout()
        left.setSpacing(2 * STEP)
        self.examples_title = text("Examples", "heading")
        left.addWidget(self.examples_title)
        left.addWidget(self.examples, 1)
        left.addStretch(0)
        self.body.addLayout(left, 0)
        inside = role(QWidget(), "canvas")
        inside.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        page = QWidget()
        page.setMaximumWidth(MAX_WIDTH)
        column = QVBoxLayout(page)
        column.setContentsMargins(6 * STEP, 5 * STEP, 6 * STEP, 5 * STEP)
        column.setSpacing(2 * STEP)
        column.addWidget(text("Start with", "heading"))
        column.addLayout(points)
        column.addSpacing(3 * STEP)
        column.addLayout(self.body, 1)
        row = QHBoxLayout(inside)
        row.setContentsMargins(0, 0, 0, 0)
        row.addStretch(1)
        row.addWidget(page, 1000)
        row.addStretch(1)
        self.setWidget(inside)
        ways = [*self.points, self.search, self.list, self.open_button, *self.commands.values(), *self.cards]
        for before, after in itertools.pairwise(ways):
            self.setTabOrder(before, after)

    def _projects(self) -> QWidget:
        holder = QWidget()
        column = QVBoxLayout(holder)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2 * STEP)
        self.count = text("", "secondary")
        self.search = QLineEdit()
        self.search.setPlaceholderText("Search projects")
        self.search.setAccessibleName("Search projects")
        self.search.setClearButtonEnabled(True)
        self.search.setMaximumWidth(240)
        head = QHBoxLayout()
        head.setSpacing(3 * STEP)
        head.addWidget(text("Projects", "heading"))
        head.addWidget(self.count, 1)
        head.addWidget(self.search, 1)
        foot = QHBoxLayout()
        foot.setSpacing(2 * STEP)
        self.open_button = button("Open", "primary")
        self.commands = {
            "rename": button("Rename…", hint="Give the project another name in its folder (F2)"),
            "show": button("Show in folder", hint="Open the folder of the project file"),
            "clean": button("Clean up", hint="Remove what can be made again; a project that is open here is closed"),
            "trash": button("Move to trash", hint="Move the project and its data to the trash of the system (Delete)"),
        }
        foot.addWidget(self.open_button)
        for made in self.commands.values():
            made.setProperty("hint", made.toolTip())
            foot.addWidget(made)
        foot.addStretch(1)
        column.addLayout(head)
        self.nothing = text("No project fits this search.", "secondary")
        self.nothing.setAlignment(Qt.AlignmentFlag.AlignCenter)
        column.addWidget(self.nothing)
        column.addWidget(self.list, 1)
        column.addLayout(foot)
        return holder

    def _connect_projects(self) -> None:
        self.search.textChanged.connect(self._search)
        self.search.returnPressed.connect(self._open)
        self.list.activated.connect(lambda _index: self._open())
        self.list.customContextMenuRequested.connect(self._show_menu)
        self.list.selectionModel().currentChanged.connect(lambda _new, _old: self._enable())
        self.open_button.clicked.connect(self._open)
        runs = {"rename": self._rename, "show": self._show_in_folder, "clean": self._clean_up, "trash": self._trash}
        for name, run in runs.items():
            self.commands[name].clicked.connect(run)
        for keys, name in (("F2", "rename"), ("Delete", "trash")):
            shortcut = QShortcut(QKeySequence(keys), self.list)
            shortcut.setContext(Qt.ShortcutContext.WidgetShortcut)
            shortcut.activated.connect(self.commands[name].click)

    def read(self) -> None:
        """Read the list of projects anew, in the background."""
        others, left_out = tuple(self.remembered()), None if self.is_worth_keeping() else self.opened()
        work = partial(read_projects, self.folder, others, left_out, self.thumbnail)
        job = self.bench.jobs.submit("Reading the list of projects", work, lane="screen", prepares=False)
        job.progressed.connect(self._take)

    def _take(self, step: Step) -> None:
        if isinstance(step.partial, tuple):
            self._show_projects(step.partial)
        elif isinstance(step.partial, Details):
            for path, size_bytes, thumbnail in step.partial.of:
                self.list.projects.add_details(path, size_bytes, thumbnail)
            self._count()

    def _show_projects(self, projects: tuple[Listed, ...]) -> None:
        """Show the list, with the examples at its side; the examples alone, and large, where there is no project."""
        chosen = self.list.project
        self.list.projects.show_projects(projects)
        self.list.select(chosen.path if chosen is not None else None)
        has_projects = bool(projects)
        self.projects.setVisible(has_projects)
        self.examples.setFixedWidth(EXAMPLES_WIDTH) if has_projects else self.examples.setMaximumWidth(MAX_WIDTH)
        if not has_projects:
            self.examples.setMinimumWidth(0)
        self._on_bound_examples()
        directions = QBoxLayout.Direction
        self.examples_box.setDirection(directions.TopToBottom if has_projects else directions.LeftToRight)
        self.body.setStretch(0, 1 if has_projects else 0)
        self.body.setStretch(1, 0 if has_projects else 1)
        self._count()
        self._search_shown()

    def _on_bound_examples(self) -> None:
        """Let images fill their cards, so that the words below are seen in small windows too."""
        inner = min(self.viewport().width(), MAX_WIDTH) - 12 * STEP
        card = (inner - 4 * STEP * (len(self.cards) - 1)) // max(1, len(self.cards))
        alone = round(IMAGE_SHAPE * card) + ExampleCard.WORDS
        self.examples.setMaximumHeight(MAX_WIDTH if self.projects.isVisibleTo(self) else max(alone, 132))

    def _count(self) -> None:
        projects, model = self.list.projects.all, self.list.projects
        total = sum(model.sizes.get(each.path, 0) for each in projects)
        words = f"{len(projects)} project{'s' if len(projects) != 1 else ''}"
        self.count.setText(f"{words}, {size_text(total)}" if total else words)

    def _search(self, wanted: str) -> None:
        self.list.projects.search(wanted)
        shown = self.list.projects.shown
        self.list.select(shown[0].path if shown and wanted.strip() else None)
        self._search_shown()

    def _search_shown(self) -> None:
        self.nothing.setVisible(not self.list.projects.shown)
        self.list.setVisible(bool(self.list.projects.shown))
        self._enable()

    def _enable(self) -> None:
        """Offer what can be done with the chosen project, and say why something cannot."""
        project = self.list.project
        why_not = "Choose a project first" if project is None else ""
        enable(self.open_button, why_not)
        if project is not None and project.path == self.opened():
            why_not = "This project is open in this window"
        elif project is not None and project.is_open:
            why_not = "This project is open in another window"
        is_free = project is not None and not project.is_open
        for name, made in self.commands.items():
            can_be_open = name == "show" or (name == "clean" and is_free)
            enable(made, "" if project is not None and can_be_open else why_not)

    def _open(self) -> None:
        if self.list.project is not None:
            self.open_wanted.emit(self.list.project.path)

    def _open_example(self, card: ExampleCard) -> None:
        if not any(each.is_opening for each in self.cards):
            self.example_wanted.emit(card.example)

    def show_opening(self, example: Example | None) -> None:
        """Mark the card of the example that is being opened; None where none is."""
        for card in self.cards:
            card.show_opening(card.example is example)

    def _show_menu(self, at: QPoint) -> None:
        if not self.list.indexAt(at).isValid():
            return
        menu = QMenu(self)
        for made in (self.open_button, *self.commands.values()):
            action = menu.addAction(made.text())
            action.setEnabled(made.isEnabled())
            action.triggered.connect(made.click)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(self.list.viewport().mapToGlobal(at))

    def _rename(self) -> None:
        project = self.list.project
        if project is None:
            return
        dialog = QInputDialog(self)
        dialog.setWindowTitle("Rename project")
        dialog.setLabelText("Name of the project")
        dialog.setTextValue(project.name)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.textValueSelected.connect(partial(self.rename, project.path))
        dialog.open()

    def rename(self, path: Path, words: str) -> None:
        """Give the project at `path` another name."""
        if not words.strip():
            return
        name = file_name(words, path.stem)
        job = self.bench.jobs.submit(f"Renaming {path.stem}", lambda: rename(path, name), lane="save")
        job.succeeded.connect(lambda new: self._on_renamed(path, new))

    def _on_renamed(self, path: Path, new: Path) -> None:
        if new != path:
            self.renamed.emit(path, new)
            self.read()

    def _show_in_folder(self) -> None:
        project = self.list.project
        if project is not None and not QDesktopServices.openUrl(QUrl.fromLocalFile(str(project.path.parent))):
            self.bench.said.emit(f"The project is {project.path}")

    def _clean_up(self) -> None:
        project = self.list.project
        if project is None:
            return
        if project.path == self.opened():
            self.clean_wanted.emit()
            return
        job = begin_clean_up(self.bench, project.path, project.name)
        job.succeeded.connect(lambda _found: self.read())

    def _trash(self) -> None:
        project = self.list.project
        if project is None:
            return
        path, name = project.path, project.name
        job = self.bench.jobs.submit(f"Moving {name} to the trash", lambda: move_to_trash(path), lane="save")
        job.succeeded.connect(lambda _: self.gone.emit(path))
        job.succeeded.connect(lambda _: self.bench.said.emit(f"{name} is in the trash of the system"))
        job.succeeded.connect(lambda _: self.read())

    def apply_theme(self) -> None:
        """Draw what is painted in the colours of the current theme."""
        for widget in (*self.cards, *self.points, self.list.viewport()):
            widget.update()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        inside = self.widget()
        if inside is not None:
            inside.setMaximumWidth(self.viewport().width())
            self._on_bound_examples()


def begin_clean_up(bench: Workbench, path: Path, name: str) -> Job:
    """Clean up the project at `path` in the background, and say what that freed."""
    job = bench.jobs.submit(f"Cleaning up {name}", lambda: clean_up(path), lane="save", resource=str(path))
    job.succeeded.connect(lambda found: bench.said.emit(describe_cleaning(name, found)))
    return job


def describe_cleaning(name: str, found: CleanedUp) -> str:
    """Describe the space that a clean-up freed, and the first reason why something stays."""
    freed = f"{name}: {size_text(found.freed_bytes)} freed"
    return f"{freed}. {found.kept[0]}" if found.kept else freed


class _Card(QAbstractButton):
    """A button that draws itself: a rounded field that lights up under the mouse and shows the focus.

    `approached`: the pointer moves over it, or it gets the focus.
    """

    approached = Signal()

    def __init__(self, name: str, about: str) -> None:
        super().__init__()
        self.setMouseTracking(True)
        self.setAccessibleName(name)
        self.setAccessibleDescription(about)
        self.setText(name)
        self.setToolTip(about)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def enterEvent(self, event: QEnterEvent) -> None:
        super().enterEvent(event)
        self.update()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        super().mouseMoveEvent(event)
        self.approached.emit()

    def focusInEvent(self, event: QFocusEvent) -> None:
        super().focusInEvent(event)
        self.approached.emit()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.click()
        else:
            super().keyPressEvent(event)

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        colours, shape = theme.current(), QPainterPath()
        shape.addRoundedRect(self.rect().toRectF().adjusted(0.5, 0.5, -0.5, -0.5), 6, 6)
        painter.fillPath(shape, QColor(colours.hover if self.underMouse() or self.isDown() else colours.panel))
        painter.save()
        painter.setClipPath(shape)
        self.draw(painter)
        painter.restore()
        painter.setPen(QColor(colours.accent if self.hasFocus() else colours.line))
        painter.drawPath(shape)

    def draw(self, painter: QPainter) -> None:
        """Draw the content of the card."""
        raise NotImplementedError

    def draw_words(self, painter: QPainter, place: QRect, about: str) -> None:
        """Draw the name of the card over `about`, in two lines."""
        colours, flags = theme.current(), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        for line, (words, colour) in enumerate(((self.text(), colours.text), (about, colours.secondary))):
            painter.setFont(theme.font(strong=line == 0))
            painter.setPen(QColor(colour))
            row = QRect(place.left(), place.top() + 20 * line, place.width(), 20)
            shown = painter.fontMetrics().elidedText(words, Qt.TextElideMode.ElideRight, row.width())
            painter.drawText(row, flags, shown)


class PointCard(_Card):
    """One of the starting points: icon, title, and what can be opened there."""

    def __init__(self, point: StartingPoint) -> None:
        super().__init__(point.title, point.about)
        self.point = point
        self.setMinimumWidth(160)
        self.setFixedHeight(64)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        return QSize(240, 64)

    def draw(self, painter: QPainter) -> None:
        icon = theme.pixmap(self.point.icon, theme.LARGE, theme.current().accent, self.devicePixelRatioF())
        painter.drawPixmap(QPoint(4 * STEP, (self.height() - theme.LARGE) // 2), icon)
        left = 8 * STEP + theme.LARGE
        self.draw_words(
            painter, QRect(left, self.height() // 2 - 21, self.width() - left - PADDING, 40), self.point.about
        )


class ExampleCard(_Card):
    """A large image of an example over its title."""

    #: Height of the words below the image, in pixels.
    WORDS = 52

    def __init__(self, example: Example) -> None:
        super().__init__(example.title, example.about)
        self.example, self.is_opening = example, False
        self.image = QImageReader(str(example.image)).read()
        self._scaled = QImage()
        self.setMinimumSize(160, 132)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def sizeHint(self) -> QSize:
        return QSize(360, 280)

    def show_opening(self, is_opening: bool) -> None:
        """Say that the example is being opened."""
        self.is_opening = is_opening
        self.update()

    def draw(self, painter: QPainter) -> None:
        scale = self.devicePixelRatioF()
        place = QRect(0, 0, self.width(), self.height() - self.WORDS)
        wanted = place.size() * scale
        if self._scaled.size() != wanted and not self.image.isNull():
            self._scaled = fit(self.image, wanted)
        painter.drawImage(place, self._scaled)
        about = "Opening…" if self.is_opening else self.example.about
        words = QRect(PADDING, place.bottom() + 2 + STEP, self.width() - 2 * PADDING, 40)
        self.draw_words(painter, words, about)


def fit(image: QImage, size: QSize) -> QImage:
    """`image` over the whole of `size`; where nearly half of it would be cut off, whole and on its own ground."""
    ratio = (image.width() * size.height()) / max(1, image.height() * size.width())
    modes = Qt.AspectRatioMode
    mode = modes.KeepAspectRatioByExpanding if 0.6 < ratio < 1.8 else modes.KeepAspectRatio
    scaled = image.scaled(size, mode, Qt.TransformationMode.SmoothTransformation)
    whole = QImage(size, QImage.Format.Format_RGB32)
    whole.fill(image.pixelColor(0, 0))
    painter = QPainter(whole)
    painter.drawImage((size.width() - scaled.width()) // 2, (size.height() - scaled.height()) // 2, scaled)
    painter.end()
    return whole
