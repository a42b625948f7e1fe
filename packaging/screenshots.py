"""Drives the real window over the built-in sample and saves a picture of every workspace, dock and dialog.

    python packaging/screenshots.py FOLDER --readme packaging/screenshots/view.png

needs a display with OpenGL (Xvfb does). Pictures come at 1024 × 700, 1280 × 800, 1920 × 1080 and 2560 × 1440, dark and
light, and at 200 % from a second process. `contact-sheet.png` has all of them, small, with their names; `faults.txt`
lists what `app.bench.faults` finds in them: text that is cut, overlapping widgets, faint text, controls without a name.
`--readme`, which may be left out, also writes the picture at the top of the README: the View workspace with the
material on a model. `--empty` stops before the sample: a minute or two in place of an hour
(without a graphics card).
"""

from __future__ import annotations

import argparse
import errno
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from PySide6.QtWidgets import QApplication, QDialog, QWidget

from app.bench.faults import faults
from app.bench.filled import fill, states
from app.help.keys import show_about, show_keys
from app.help.manual import Manual
from app.help.mode_chooser import ModeChooser
from app.viewport.gl_surface import request_format
from app.widgets import theme
from app.window.dialogs import show_history
from app.window.main_window import MainWindow
from app.window.preferences import Preferences
from app.window.top_bar import WORKSPACES
from engine.capture.lights.sources import find
from engine.core.steps import drain
from engine.figures.demo import built_in_sample
from engine.light.lamps import LampSettings
from engine.storage import atomic

SIZES = ((1024, 700), (1280, 800), (1920, 1080), (2560, 1440))

#: Width of a picture on the contact sheet, the pictures of a row, and the height of a name.
SMALL_PX, IN_A_ROW, NAME_PX = 400, 6, 16

#: Faults by the picture in which they were found.
FOUND: dict[str, list[str]] = {}

#: States of the View workspace: a name, the mode, and how it is compared with the reference.
STATES = (
    ("lamps", "shading-map", ""),
    ("reference", "reference", ""),
    ("wipe", "shading-map", "wipe"),
    ("difference", "shading-map", "difference"),
)

PATIENCE_S = 900.0


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--readme", type=Path, help="where the picture of the README goes")
    parser.add_argument("--empty", action="store_true", help="only the window as it is before anything is opened")
    parser.add_argument("--banners", action="store_true", help="only the sentences above the workspaces")
    parser.add_argument("--doubled", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    if not options.doubled and not options.banners:
        doubled = {**os.environ, "QT_SCALE_FACTOR": "2"}
        again = [sys.executable, __file__, str(options.folder), "--doubled", *["--empty"] * options.empty]
        subprocess.run(again, env=doubled, check=True, timeout=3600)
    drive(options)
    if not options.doubled:
        contact_sheet(options.folder)
    lines = [f"{picture}: {fault}" for picture, faults in FOUND.items() for fault in faults]
    with (options.folder / "faults.txt").open("w" if options.doubled else "a", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in lines)
    print(f"{len(lines)} faults{' at 200 %' * options.doubled}", *lines, sep="\n")
    return 0


def drive(options: argparse.Namespace) -> None:
    """Open the window, lead it through all states, and close it."""
    request_format()
    application = QApplication([])
    theme.apply(application, "dark")
    window = MainWindow(None)
    window.failures.install()
    window.show()
    if options.doubled:
        window.resize(1280, 800)
    sizes = ((1280, 800),) if options.doubled else SIZES
    before = "0-200-percent" if options.doubled else "1-empty"
    if options.banners:
        banners(window, options.folder)
        window.close()
        return
    for look in ("dark", "light"):
        window.set_theme(look)
        everywhere(window, options.folder, f"{before}-{look}", sizes)
        dialogs(window, options.folder, f"{before}-{look}")
    window.set_theme("dark")
    if options.empty:
        window.close()
        return
    window.bench.make_sample_anew()
    wait_until(lambda: window.bench.importing is not None and window.bench.importing.step.done > 0.3)
    save(window, options.folder / "2-importing-capture.png")
    wait_until(lambda: window.bench.document.project.has_map and not window.bench.jobs.active)
    wait_for_model(window)
    fill(window, wait_until, method="sh")
    walk(window, options.folder, "3-filled-dark", sizes)
    if options.doubled:
        window.set_theme("light")
        walk(window, options.folder, "3-filled-light", sizes)
        window.close()
        return
    if options.readme is not None:
        window.resize(1280, 800)
        window.show_workspace("view")
        save(window, options.readme)
    window.show_workspace("material")
    window.material.show_what.buttons["error"].click()
    save(window, options.folder / "4-error-map.png")
    window.docks.jobs.show()
    window.show_workspace("view")
    window.view.lookup.source.buttons["power-law"].click()
    save(window, options.folder / "5-view-jobs.png")
    window.docks.jobs.hide()
    compared(window, options.folder, "6-dark")
    docks(window, options.folder, "8-dark")
    window.set_theme("light")
    walk(window, options.folder, "7-filled-light", sizes)
    compared(window, options.folder, "7-light")
    docks(window, options.folder, "8-light")
    banners(window, options.folder)
    window.close()


def everywhere(window: MainWindow, folder: Path, state: str, sizes: Sequence[tuple[int, int]] = SIZES) -> None:
    """Every workspace at every size."""
    for width, height in sizes:
        window.resize(width, height)
        for name in WORKSPACES:
            window.show_workspace(name)
            save(window, folder / f"{state}-{name}-{width}.png")


def walk(window: MainWindow, folder: Path, state: str, sizes: Sequence[tuple[int, int]]) -> None:
    """Every state of a window with work in it, at every size."""
    for width, height in sizes:
        window.resize(width, height)
        for name in states(window):
            save(window, folder / f"{state}-{name}-{width}.png")


def dialogs(window: MainWindow, folder: Path, state: str) -> None:
    """The dialogs that the menus open."""
    window.show_workspace("view")
    wait_until(lambda: window.view.default_mesh is not None)
    openers: dict[str, Callable[[], object]] = {
        "picture": lambda: window.view.save_picture("picture"),
        "turntable": lambda: window.view.save_picture("turntable"),
        "keys": lambda: show_keys(window),
        "manual": lambda: Manual(window).show_page("view", "Light"),
        "modes": lambda: ModeChooser(window, window.bench.document.project).open(),
        "preferences": lambda: Preferences(window, window.settings.now, window.bench.jobs).open(),
        "about": lambda: show_about(window),
        "history": lambda: show_history(window, window.bench),
    }
    for name, show in openers.items():
        show()
        settle(0.4)
        for dialog in [each for each in window.findChildren(QDialog) if each.isVisible()]:
            keep(dialog, folder / f"{state}-dialog-{name}.png")
            dialog.close()
    settle(0.2)


def contact_sheet(folder: Path) -> None:
    """All pictures of `folder`, small and with their names, in one."""
    from PIL import Image, ImageDraw

    paths = [path for path in sorted(folder.glob("*.png")) if path.name != "contact-sheet.png"]
    small = []
    for path in paths:
        with Image.open(path) as picture:
            height = max(1, round(SMALL_PX * picture.height / picture.width))
            small.append(picture.convert("RGB").resize((SMALL_PX, height), Image.Resampling.LANCZOS))
    rows = [range(first, min(first + IN_A_ROW, len(small))) for first in range(0, len(small), IN_A_ROW)]
    heights = [max(small[at].height for at in row) + NAME_PX for row in rows]
    sheet = Image.new("RGB", (SMALL_PX * IN_A_ROW, sum(heights)), "#808080")
    draw, top = ImageDraw.Draw(sheet), 0
    for row, height in zip(rows, heights, strict=True):
        for at in row:
            left = SMALL_PX * (at - row.start)
            draw.text((left + 4, top + 2), paths[at].stem, fill="#ffffff")
            sheet.paste(small[at], (left, top + NAME_PX))
        top += height
    sheet.save(folder / "contact-sheet.png")


def compared(window: MainWindow, folder: Path, state: str) -> None:
    """The View workspace with lamps and a ground, the reference alone, beside another mode, and less it."""
    window.show_workspace("view")
    document = window.bench.document
    lamps = (LampSettings(phi_deg=-60.0, radius_deg=4.0, colour=(1.0, 0.7, 0.4)), LampSettings(phi_deg=80.0))
    for width, height in SIZES:
        window.resize(width, height)
        for name, mode, comparing in STATES:
            parts = {"mode": mode, "against": "reference", "comparing": comparing}
            look = replace(document.project.look, lamps=lamps, has_ground=True, **parts)
            document.change("Compare", look=look)
            settle(1.0)
            wait_until(lambda: enough(window))
            grab(window, folder / f"{state}-{name}-{width}.png")
    document.change("Compare", look=replace(document.project.look, lamps=(), has_ground=False, comparing=""))


def docks(window: MainWindow, folder: Path, state: str) -> None:
    """The docks: cost of accuracy, effects planned, forced and planned anew, a bake, health and the self-test."""
    window.show_workspace("view")
    document, effects, accuracy = window.bench.document, window.docks.effects, window.docks.accuracy
    document.change("Plan", look=replace(document.project.look, forced=(), skipped=(), mode="direct"))
    window.bench.load_environment("studio")
    wait_until(lambda: effects.plan is not None)
    accuracy.modes.setCurrentIndex(accuracy.modes.findData("direct"))
    accuracy.time.setCurrentIndex(0)
    accuracy.go.click()
    wait_until(lambda: accuracy.job is None or accuracy.live is not None)
    grab(window, folder / f"{state}-measuring.png")
    wait_until(lambda: accuracy.job is None)
    document.change("Force", look=replace(document.project.look, forced=("self-shadowing",), skipped=("glossy",)))
    grab(window, folder / f"{state}-planned-before.png")
    wait_until(lambda: effects.plan is not None)
    for width, height in SIZES:
        window.resize(width, height)
        for name, budget in (("points", ""), ("within", "1 s"), ("nothing-within", "0.001 %")):
            accuracy.budget.setText(budget)
            grab(window, folder / f"{state}-{name}-{width}.png")
    accuracy.budget.clear()
    window.view.choose_mode("sh")
    wait_until(lambda: window.view.bakings["sh"].ready is not None or window.view.bakings["sh"].is_made)
    grab(window, folder / f"{state}-bake.png")
    window.self_test()
    wait_until(lambda: window.docks.health.job is None)
    for width, height in SIZES:
        window.resize(width, height)
        grab(window, folder / f"{state}-self-test-{width}.png")
    window.docks.health.hide()


def banners(window: MainWindow, folder: Path) -> None:
    """The sentences about a project above the workspaces, each by its cause, in both themes.

    Photographs that moved and that changed, a full disk, a file that cannot be written, a second window, and a project
    that a killed process left in the middle of a job.
    """
    bench, projects = window.bench, window.projects
    window.resize(1280, 800)
    window.show_workspace("capture")
    place = Path(tempfile.mkdtemp(prefix="lightarc-banners-"))
    photographs = shutil.copytree(drain(built_in_sample(place / "sample")), place / "photographs")
    path = place / "Woven sample.lap"
    projects.copy_to(path)
    wait_until(lambda: projects.path == path)
    bench.import_photographs(find([photographs]), name="Woven sample")
    wait_until(lambda: bench.document.project.has_map and not bench.jobs.active and projects.is_saved)

    def shown(cause: str) -> None:
        wait_until(lambda: cause in window.banners.words)
        for look in ("dark", "light"):
            window.set_theme(look)
            grab(window, folder / f"9-{look}-{cause}.png")

    moved = photographs.rename(place / "moved")
    window.whereabouts.look()
    shown("missing")
    moved.rename(photographs)
    first = min(photographs.glob("woven_*"))
    content = first.read_bytes()
    first.write_bytes(content + b"\0")
    window.whereabouts.look()
    shown("changed")
    first.write_bytes(content)
    window.whereabouts.look()
    atomic.fault = full_disk
    bench.load_model("torus-knot")
    shown("saving")
    atomic.fault = None
    wait_until(lambda: "saving" not in window.banners.words and projects.is_saved)
    window.new()
    for name, words in (("second", SECOND), ("killed", KILLED)):
        pipe, root = subprocess.PIPE, Path(__file__).resolve().parents[1]
        with subprocess.Popen([sys.executable, "-c", words, str(path)], stdin=pipe, stdout=pipe, cwd=root) as other:
            assert other.stdout is not None
            other.stdout.readline()
            window.open_project(path)
            shown("read-only" if name == "second" else "interrupted")
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


def grab(window: MainWindow, path: Path) -> None:
    """Keep what the window shows a moment later, whether or not it is at rest."""
    settle(0.6)
    keep(window, path)


def keep(shown: QWidget, path: Path) -> None:
    """Save the picture of a window or a dialog, and note its faults."""
    if not shown.grab().save(str(path)):
        raise SystemExit(f"{path} cannot be written")
    found = faults(shown)
    if found:
        FOUND[path.name] = found


def enough(window: MainWindow) -> bool:
    """True if a shown reference has a few samples, and the error of compared pictures is known."""
    pictures = window.view.pictures
    found = pictures.reference.found
    refined = pictures.progressive is None or (found is not None and found.samples >= 8)
    return refined and (len(pictures.modes) < 2 or pictures.error is not None)


def save(window: MainWindow, path: Path) -> None:
    """Let the window come to rest, and keep what it shows."""
    settle(0.6)
    wait_until(lambda: not any(not job.heavy and job.state != "paused" for job in window.bench.jobs.active))
    settle(0.4)
    wait_until(lambda: not window.view.isVisible() or getattr(window.view.viewport.surface, "is_finished", True))
    grab(window, path)


def wait_for_model(window: MainWindow) -> None:
    """The View workspace loads its model when it is first seen."""
    window.show_workspace("view")
    wait_until(lambda: window.view.default_mesh is not None)


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


if __name__ == "__main__":
    sys.exit(main())
