"""Parts of all that the window can show: functions that lead a window there and let a `Gallery` take images.

`PARTS` has them in their order. Each can run alone; those that need work in the window make it where there is none.
"""

from __future__ import annotations

import errno
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QPoint, QTimer
from PySide6.QtWidgets import QApplication, QColorDialog, QDialog, QFileDialog, QMenu, QWidget

from app.capture.photograph_menu import menu_of
from app.commands import brdf as commands_brdf
from app.commands.workbench import Arrival
from app.help.keys import show_about, show_keys
from app.help.manual import PAGES, Manual
from app.help.mode_chooser import ModeChooser
from app.help.tour import Tour
from app.viewport.viewport import Viewport
from app.window.arriving import ask_for_consent, ask_where
from app.window.dialogs import ask_what_to_collect, show_history, show_notes
from app.window.main_window import MainWindow
from app.window.preferences import Preferences
from app.window.top_bar import WORKSPACES
from benchmarks.app.faults import faults
from benchmarks.app.filled import COMPARED, fill, states
from engine.capture.doubts import Doubtful
from engine.capture.lights.sources import find
from engine.core.errors import InputError, MissingCapability, OutOfMemory
from engine.core.steps import drain
from engine.light.lamps import LampSettings
from engine.simulate.built_in import make_built_in_sample
from engine.storage import atomic

ROOT = Path(__file__).resolve().parents[1]

#: States of the View workspace: a name, the mode, and how it is compared with the reference.
STATES = (
    ("lamps", "shading-map", ""),
    ("reference", "reference", ""),
    ("wipe", "shading-map", "wipe"),
    ("difference", "shading-map", "difference"),
)

#: The longest that work is waited for, and an image that refines.
PATIENCE_S, REFINING_S = 900.0, 6.0

#: A window is at rest when nothing has moved for so long; the pauses of the program are shorter than that.
QUIET_S = 0.35

#: Pause before a dialog or a menu is looked at.
OPENING_S = 0.35

#: Dialogs of Qt, whose faults are not ours. Qt also frees their parts where PySide does not see it.
OF_QT = (QColorDialog, QFileDialog)


@dataclass(frozen=True)
class Size:
    """A size of the window, in pixels, and its name."""

    name: str
    width: int
    height: int


@dataclass
class Gallery:
    """Images of `folder`, in all `sizes` and `themes`, and their `faults`; `taken` counts them."""

    folder: Path
    sizes: Sequence[Size]
    themes: Sequence[str]
    faults: list[str] = field(default_factory=list)
    taken: int = 0
    look: str = ""

    def looks(self, window: MainWindow, *, largest: int = 1 << 20) -> Iterator[None]:
        """Bring the window to each size, no more than the first `largest` of them, and to each theme."""
        for size in self.sizes[:largest]:
            window.resize(size.width, size.height)
            for theme in self.themes:
                if window.settings.now.theme != theme or not self.look:
                    window.set_theme(theme)
                self.look = f"{size.name}-{theme}"
                yield

    def take(self, window: MainWindow, name: str, in_front: QWidget | None = None) -> None:
        """Let the window come to rest, and keep what it shows; `in_front` covers and dims all else."""
        rest(window)
        self.keep(window, name, in_front)

    def keep(self, shown: QWidget, name: str, in_front: QWidget | None = None) -> None:
        """Save the image of a window, a dialog or a menu as it is now; note its faults, or those of `in_front`."""
        path = self.folder / f"{name}-{self.look}.png"
        if not shown.grab().save(str(path)):
            raise SystemExit(f"{path} cannot be written")
        self.taken += 1
        if not isinstance(shown, OF_QT):
            self.faults += [f"{path.name}: {fault}" for fault in faults(in_front or shown)]

    def open(self, window: MainWindow, name: str, show: Callable[[], object]) -> None:
        """Keep the dialogs and menus that `show` opens, and close them; `show` may wait until they are closed."""

        def look() -> None:
            opened = [each for each in QApplication.topLevelWidgets() if each.isVisible() and each is not window]
            for at, each in enumerate(opened):
                try:
                    if isinstance(each, (QDialog, QMenu)):
                        self.keep(each, name if at == 0 else f"{name}-{at}")
                finally:
                    each.close()  # `show` may wait for that
            if not opened:
                print(f"{name} opens nothing", file=sys.stderr)

        QTimer.singleShot(round(1000 * OPENING_S), look)
        show()
        settle(OPENING_S + 0.1)


def rest(window: MainWindow, refining_s: float = REFINING_S) -> None:
    """Run the event loop until the small jobs are over and the image has come to rest, or long enough."""
    begun = quiet = time.monotonic()
    while time.monotonic() - quiet < QUIET_S:
        settle(0.02)
        is_busy = any(job.lane == "screen" and job.state != "paused" for job in window.bench.jobs.active)
        drawn = [each.surface for each in window.findChildren(Viewport) if each.isVisible()]
        is_drawing = not all(getattr(surface, "is_finished", True) for surface in drawn)
        if is_busy or window.is_dressing or (is_drawing and time.monotonic() - begun < refining_s):
            quiet = time.monotonic()
        if time.monotonic() - begun > PATIENCE_S:
            raise SystemExit("the window does not come to rest")


def settle(seconds: float) -> None:
    """Run the event loop for a while."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        QApplication.processEvents()
        time.sleep(0.005)


def wait_until(done: Callable[[], bool]) -> None:
    """Run the event loop until `done`."""
    end = time.monotonic() + PATIENCE_S
    while not done():
        if time.monotonic() > end:
            raise SystemExit("the window did not get there in time")
        settle(0.02)


def with_sample(window: MainWindow) -> None:
    """Open the sample where the window has no material."""
    if not window.bench.document.project.has_map:
        window.bench.rebuild_sample()
    wait_until(lambda: window.bench.document.project.has_map and not window.bench.jobs.active)
    window.show_workspace("view")
    wait_until(lambda: window.view.default_mesh is not None)


def with_work(window: MainWindow) -> None:
    """Compare, factor and bake beside the sample, where that is not done."""
    with_sample(window)
    if not window.bench.document.project.factoring.runs:
        fill(window, wait_until, method="sh")
    if window.bench.document.project.surface is None:
        window.material.surface.make.click()
        wait_until(lambda: window.bench.document.project.surface is not None)


def empty(gallery: Gallery, window: MainWindow) -> None:
    """The start page, and every workspace with nothing in it."""
    for _ in gallery.looks(window):
        window.show_start()
        wait_until(lambda: not window.bench.jobs.active)
        gallery.take(window, "0-start")
        for name in WORKSPACES:
            window.show_workspace(name)
            gallery.take(window, f"1-empty-{name}")


def hints(gallery: Gallery, window: MainWindow) -> None:
    """The welcome tour."""
    for _ in gallery.looks(window, largest=2):
        window.show_hints()
        tour = next(each for each in window.findChildren(Tour) if each.isVisible())
        for at in range(len(tour.hints)):
            tour.show_hint(at)
            gallery.take(window, f"2-hint-{at + 1}", tour)
        tour.end()
        settle(0.1)


def importing(gallery: Gallery, window: MainWindow) -> None:
    """The sample while it is made and imported."""
    if window.bench.document.project.has_map:
        return
    window.show_workspace("capture")
    window.bench.rebuild_sample()
    wait_until(lambda: window.bench.importing is not None and window.bench.importing.step.done > 0.3)
    for _ in gallery.looks(window):
        settle(QUIET_S)
        gallery.keep(window, "3-importing")
    wait_until(lambda: window.bench.document.project.has_map and not window.bench.jobs.active)


def work(gallery: Gallery, window: MainWindow) -> None:
    """Every state of a window with work in it."""
    with_work(window)
    for _ in gallery.looks(window):
        for name in states(window):
            gallery.take(window, f"4-{name}")


def menus(gallery: Gallery, window: MainWindow) -> None:
    """The menus, of the window, of photographs, and below buttons."""
    with_work(window)
    for _ in gallery.looks(window, largest=1):
        for name, (workspace, show) in menu_openers(window).items():
            window.show_workspace(workspace)
            gallery.open(window, f"5-menu-{name}", show)


def menu_openers(window: MainWindow) -> dict[str, tuple[str, Callable[[], object]]]:
    """By the name of each menu: the workspace that it belongs to, and what opens it."""
    at, view, capture, brdf = window.mapToGlobal(QPoint(80, 160)), window.view, window.capture, window.brdf
    openers: dict[str, tuple[str, Callable[[], object]]] = {}
    for action in window.menus.actions():
        menu: Any = action.menu()
        openers[action.text().replace("&", "").lower()] = "capture", partial(menu.popup, at)

    def show_varying() -> None:
        view.varying.fill_menu()
        view.varying.menu.popup(at)

    def show_views() -> None:
        view.views.fill()
        view.views.popup(at)

    return {
        **openers,
        "photograph": ("capture", lambda: menu_of(capture, window.bench, capture.list, (capture.magnify,)).popup(at)),
        "varying": ("view", show_varying),
        "views": ("view", show_views),
        "glsl": ("brdf", lambda: brdf.library.write.menu().popup(at)),
    }


def dialogs(gallery: Gallery, window: MainWindow) -> None:
    """The dialogs that menus and buttons open, and the questions that the window asks."""
    with_sample(window)
    bench, path = window.bench, window.projects.path
    if not bench.document.project.comparison.entries:
        commands_brdf.add_model(bench, COMPARED[1])
    doubts = (
        Doubtful(
            "/media/ada/Linen under the arc",
            "nothing says where the lamp stood, and the photographs do not grow brighter with the elevations that "
            "were assumed in the order of the file names, as they would on an arc",
            "Enter the angles",
            "trust_angles",
        ),
        Doubtful("/media/ada/linen_50deg.CR3", "is cut off in the middle", "Bring it again", "leave_out"),
        Doubtful(
            "/media/ada/linen_60deg.CR3",
            "is black, as if its lamp had not fired",
            "Take it again, or import the other nine photographs without it, or use all of them",
            "leave_out",
            "use_all",
        ),
    )
    openers: dict[str, Callable[[], object]] = {
        "picture": lambda: window.view.save_image("picture"),
        "turntable": lambda: window.view.save_image("turntable"),
        "keys": lambda: show_keys(window),
        "modes": lambda: ModeChooser(window, bench.document.project).open(),
        "preferences": lambda: Preferences(window, window.settings.now, bench.jobs).open(),
        "about": lambda: show_about(window),
        "history": lambda: show_history(window, bench),
        "notes": lambda: show_notes(window, bench),
        "collect": lambda: ask_what_to_collect(window, path, (), print),
        "photographs": lambda: ask_where(
            window, bench, print, Arrival("Linen under the arc", print, print, "imports all photographs together")
        ),
        **{
            f"consent-{doubt.otherwise or doubt.consent}": partial(ask_for_consent, window, bench, doubt)
            for doubt in doubts
        },
        "files": lambda: window.files.choose_files(),
        "save-as": lambda: window.files.save_as(),
        "colour": lambda: QColorDialog(window).open(),
        **{
            f"manual-{page.stem}": lambda page=page: Manual(window).show_page(page.stem)
            for page in sorted(PAGES.glob("*.md"))
        },
    }
    for _ in gallery.looks(window, largest=1):
        window.show_workspace("view")
        for name, show in openers.items():
            gallery.open(window, f"6-dialog-{name}", show)
    _show_brdfs(gallery, window)


def _show_brdfs(gallery: Gallery, window: MainWindow) -> None:
    """The text of a BRDF, with a mistake as well, and the ranking of all models."""
    tab, fit = window.brdf, window.brdf.inspector.fit
    window.show_workspace("brdf")
    wait_until(lambda: tab.entry is not None)
    tab.library.template_wanted.emit("ggx")
    wait_until(lambda: any(type(each).__name__ == "TextEditor" for each in QApplication.topLevelWidgets()))
    editor: Any = next(each for each in QApplication.topLevelWidgets() if type(each).__name__ == "TextEditor")
    whole = editor.edit.toPlainText()
    for _ in gallery.looks(window, largest=1):
        for name, words in (("text", whole), ("text-wrong", whole.replace("dot(", "dott(", 1))):
            editor.edit.setPlainText(words)
            settle(0.7)
            rest(window)
            gallery.keep(editor, f"6-dialog-{name}")
    editor.edit.setPlainText(whole)
    settle(0.7)
    editor.close()
    fit.rank_all()
    wait_until(lambda: fit.ranking is not None and fit.ranking.isVisible())
    assert fit.ranking is not None
    for _ in gallery.looks(window, largest=1):
        settle(OPENING_S)
        gallery.keep(fit.ranking, "6-dialog-ranking")
    fit.ranking.close()


def failures(gallery: Gallery, window: MainWindow) -> None:
    """Sentences where something fails: faults of the program and of files, newer versions, an earlier crash."""
    place = Path(tempfile.mkdtemp(prefix="lightarc-failures-"))
    newer = newer_project(window, place / "Woven sample.lap")
    bundle = InputError(
        place / "Woven.lightarc", "was written by a newer Lightarc (schema 9, this one reads 4)", "Update Lightarc"
    )
    errors: dict[str, BaseException] = {
        "newer-bundle": bundle,
        "memory": OutOfMemory("The image needs 3.2 GB, and 1.1 GB are free"),
        "capability": MissingCapability("OpenGL 3.3 is not there", "Install the driver of the graphics card"),
    }
    for at, _ in enumerate(gallery.looks(window, largest=1)):
        gallery.open(window, "7-failure-newer-project", lambda: window.open_project(newer))
        for name, error in errors.items():
            gallery.open(
                window,
                f"7-failure-{name}",
                partial(window.failures.report, "The file cannot be opened", error),
            )
        # each place in the code is told once: this is a place of its own for each look
        wrong = compile("\n" * at + "raise ZeroDivisionError('division by zero')", __file__, "exec")
        window.failures.install()
        gallery.open(window, "7-failure-crash", partial(QTimer.singleShot, 0, partial(exec, wrong)))
        sys.excepthook = sys.__excepthook__
    window.show_workspace("capture")
    crashed = Path.home() / ".local/state/lightarc/log/crash-2026-11-25-221507-4711-1764108907.txt"
    for _ in gallery.looks(window):
        window.tell_of_crash(str(crashed))
        gallery.take(window, "7-failure-crashed-before")
    window.banners.say("crashed", "")
    shutil.rmtree(place)


def newer_project(window: MainWindow, path: Path) -> Path:
    """A copy of the project of `window` as a later version would write it."""
    wait_until(lambda: window.projects.is_saved)
    shutil.copyfile(window.projects.path, path)
    connection = sqlite3.connect(path)
    with connection:
        connection.execute("UPDATE meta SET value = '999' WHERE name = 'schema'")
    connection.close()
    return path


def jobs(gallery: Gallery, window: MainWindow) -> None:
    """The Jobs dock below the View workspace, with the power law in use."""
    with_sample(window)
    for _ in gallery.looks(window):
        window.show_workspace("view")
        window.docks.jobs.show()
        window.docks.jobs.raise_()
        window.view.lookup.source.buttons["power-law"].click()
        gallery.take(window, "8-view-jobs")
        window.docks.jobs.hide()


def compare_with(gallery: Gallery, window: MainWindow) -> None:
    """The View workspace with lamps and a ground, the reference alone, beside another mode, and less it."""
    with_sample(window)
    window.show_workspace("view")
    document = window.bench.document
    lamps = (LampSettings(phi_deg=-60.0, radius_deg=4.0, colour=(1.0, 0.7, 0.4)), LampSettings(phi_deg=80.0))
    for name, mode, comparing in STATES:
        parts: dict[str, Any] = {"mode": mode, "against": "reference", "comparing": comparing}
        look = replace(document.project.look, lamps=lamps, has_ground=True, **parts)
        document.change("Compare", look=look)
        for _ in gallery.looks(window):
            settle(1.0)
            wait_until(lambda: enough(window))
            gallery.keep(window, f"8-view-{name}")
    document.change("Compare", look=replace(document.project.look, lamps=(), has_ground=False, comparing=""))


def enough(window: MainWindow) -> bool:
    """True if a shown reference has a few samples, and the error of compared images is known."""
    images = window.view.images
    found = images.reference.found
    refined = images.progressive is None or (found is not None and found.samples >= 4)
    return refined and (len(images.modes) < 2 or images.error is not None)


def docks(gallery: Gallery, window: MainWindow) -> None:
    """The docks: cost of accuracy, effects planned, forced and planned anew, a bake, health and the self-test."""
    with_sample(window)
    window.show_workspace("view")
    document, effects, accuracy = window.bench.document, window.docks.effects, window.docks.accuracy
    document.change("Plan", look=replace(document.project.look, forced=(), skipped=(), mode="direct"))
    window.bench.load_environment("studio")
    wait_until(lambda: effects.plan is not None)
    accuracy.modes.setCurrentIndex(accuracy.modes.findData("direct"))
    accuracy.time.setCurrentIndex(0)
    accuracy.go.click()
    wait_until(lambda: accuracy.job is None or accuracy.live is not None)
    for _ in gallery.looks(window):
        settle(QUIET_S)
        gallery.keep(window, "9-measuring")
    wait_until(lambda: accuracy.job is None)
    document.change("Force", look=replace(document.project.look, forced=("self-shadowing",), skipped=("glossy",)))
    wait_until(lambda: effects.plan is not None)
    for _ in gallery.looks(window):
        for name, budget in (("points", ""), ("within", "1 s"), ("nothing-within", "0.001 %"), ("wrong", "soon")):
            accuracy.budget.setText(budget)
            gallery.take(window, f"9-accuracy-{name}")
    accuracy.budget.clear()
    window.view.choose_mode("sh")
    wait_until(lambda: window.view.bakings["sh"].ready is not None or window.view.bakings["sh"].is_made)
    for _ in gallery.looks(window):
        gallery.take(window, "9-bake")
    window.self_test()
    for _ in gallery.looks(window, largest=1):
        settle(2.0)
        gallery.keep(window, "9-self-test-runs")
    wait_until(lambda: window.docks.health.job is None)
    for _ in gallery.looks(window):
        gallery.take(window, "9-self-test")
    window.docks.health.hide()


def banners(gallery: Gallery, window: MainWindow) -> None:
    """The sentences about a project above the workspaces, each by its cause.

    Photographs that moved and that changed, a full disk, a file that cannot be written, a second window, and a project
    that a killed process left in the middle of a job.
    """
    bench, projects = window.bench, window.projects
    window.new()
    window.show_workspace("capture")
    place = Path(tempfile.mkdtemp(prefix="lightarc-banners-"))
    photographs = shutil.copytree(drain(make_built_in_sample(place / "sample")), place / "photographs")
    path = place / "Woven sample.lap"
    projects.copy_to(path)
    wait_until(lambda: projects.path == path)
    bench.import_photographs(find([photographs]), name="Woven sample")
    wait_until(lambda: bench.document.project.has_map and not bench.jobs.active and projects.is_saved)

    def show(cause: str) -> None:
        wait_until(lambda: cause in window.banners.words)
        for _ in gallery.looks(window, largest=2):
            settle(QUIET_S)
            gallery.keep(window, f"9-banner-{cause}")

    moved = photographs.rename(place / "moved")
    window.whereabouts.look()
    show("missing")
    moved.rename(photographs)
    first = min(photographs.glob("woven_*"))
    content = first.read_bytes()
    first.write_bytes(content + b"\0")
    window.whereabouts.look()
    show("changed")
    first.write_bytes(content)
    window.whereabouts.look()
    atomic.fault = full_disk
    bench.load_model("torus-knot")
    show("saving")
    atomic.fault = None
    wait_until(lambda: "saving" not in window.banners.words and projects.is_saved)
    window.new()
    for name, words in (("second", SECOND), ("killed", KILLED)):
        pipe = subprocess.PIPE
        with subprocess.Popen([sys.executable, "-c", words, str(path)], stdin=pipe, stdout=pipe, cwd=ROOT) as other:
            assert other.stdout is not None
            other.stdout.readline()
            window.open_project(path)
            show("read-only" if name == "second" else "interrupted")
            other.kill()
        window.new()
    shutil.rmtree(place)


def full_disk(operation: str, _path: Path) -> None:
    if operation == "create":
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


#: Another process that has a project open, and one that is killed while it bakes for it.
SECOND = """
import sys
from pathlib import Path
from app.project.places import claim
claim(Path(sys.argv[1]))
print(flush=True)
input()
"""
KILLED = """
import os, sys
from pathlib import Path
from app.project.interrupted import running
from app.project.places import claim
from app.project.project_file import data_folder
path = Path(sys.argv[1])
claim(path)
with running(data_folder(path), "Baking spherical harmonics", {"kind": "bake"}):
    print(flush=True)
    os._exit(1)
"""

#: The parts by their names, in their order: some leave work in the window for the next.
PARTS: dict[str, Callable[[Gallery, MainWindow], None]] = {
    "empty": empty,
    "hints": hints,
    "importing": importing,
    "failures": failures,
    "dialogs": dialogs,
    "work": work,
    "menus": menus,
    "jobs": jobs,
    "compared": compare_with,
    "docks": docks,
    "banners": banners,
}
