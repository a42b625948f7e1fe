"""Make the images of the README and the manual anew, from the real window and from the commands of the manual.

    python packaging/manual_images.py [window] [watch] [tutorials] [mistakes] [fronts]

Without a choice it makes all. The window needs a display with OpenGL (`Xvfb -screen 0 1920x1080x24` does). Images lie
in `docs/manual/images` as WebP of at most `MAX_BYTES`: the width of the page is what they are shown at.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
import tifffile
from manual_commands import run_commands, run_step, tutorials
from numpy.typing import NDArray
from PIL import Image
from PySide6.QtWidgets import QApplication, QWidget
from screens import PATIENCE_S, rest, settle, wait_until, with_work

from app.viewport.gl_surface import request_format
from app.widgets import theme
from app.window.main_window import MainWindow
from benchmarks.app.filled import states
from engine.capture.lights.sources import find
from engine.core.colour import srgb_decode, srgb_encode

IMAGES = Path(__file__).resolve().parents[1] / "docs" / "manual" / "images"
MAX_BYTES = 150_000

#: Width and height of the window, and the most pixels along a side of an image that a command has made.
WINDOW_PX, IMAGE_PX = (1280, 800), 1000

#: States of a window with work in it (`benchmarks.app.filled.states`), by the names of their images.
STATES = {
    "capture": "window-capture",
    "material-slices": "window-material",
    "material-surface": "window-surface",
    "brdf-log": "window-brdf",
    "factor-terms": "window-factor",
    "view-baked": "window-view",
    "view-wipe": "window-wipe",
    "export-elsewhere": "window-export",
}

#: Stands for light of a room, which is added to photographs: lamps on eight sides at half the brightness of the lamp.
ROOM = "room"

#: Photographs of a capture as they should be and with a mistake: the name of the image, the sample, the options of the
#: mistake, and the photographs that are shown, by their elevation; several are shown as their mean.
MISTAKES = {
    "mistake-bright": ("hammered", "--exposures 3", (55,)),
    "mistake-moved": ("medal", "--misalignment-px 12 --turn-deg 4", (40, 55, 70, 90)),
    "mistake-near": ("leather", "--lamp-distance 0.8", (40,)),
    "mistake-room": ("medal", ROOM, (10,)),
}

#: Pixels of a photograph of a mistake, and between two.
MISTAKE_PX, GAP_PX = 320, 16

#: Scenes whose Pareto fronts are measured, beside that of the tutorial on accuracy, by the names of their images.
FRONTS = {
    "front-soft": "sphere --brdf lambert --env overcast --ground",
    "front-shadows": "sphere --brdf lambert --env noon --ground",
}

#: Files that the commands of a tutorial leave, and the images that are made of them.
MADE = {
    "first-material": {"woven.png": "woven"},
    "desk-lamp": {"felt.png": "felt"},
    "dome": {"from-right.png": "dome-right", "from-left.png": "dome-left"},
    "colour-chart": {"chart.png": "chart"},
    "inscription": {"grazing.png": "medal-grazing"},
    "accuracy": {"difference.png": "difference", "tradeoff/tradeoff.png": "front"},
}


def main() -> int:
    chosen = sys.argv[1:] or ["window", "watch", "tutorials", "mistakes", "fronts"]
    IMAGES.mkdir(exist_ok=True)
    if "window" in chosen:
        photograph_window()
    if "watch" in chosen:
        photograph_watch()
    if "tutorials" in chosen:
        keep_results()
    if "mistakes" in chosen:
        for name, mistake in MISTAKES.items():
            show_mistake(name, *mistake)
    if "fronts" in chosen:
        for name, scene in FRONTS.items():
            measure_front(name, scene)
    return 0


def photograph_window() -> None:
    """The window on its start page, in every workspace with the sample, and with the photographs of a dome."""
    request_format()
    application = QApplication([])
    theme.apply(application, "dark")
    window = MainWindow(None)
    window.show()
    window.set_theme("dark")
    window.resize(*WINDOW_PX)
    window.show_start()
    keep(window, "window-start")
    with_work(window)
    for name in states(window):
        if name == "export-elsewhere":
            window.export.elsewhere.ask()
            wait_until(lambda: not window.bench.jobs.active)
        if name in STATES:
            keep(window, STATES[name])
    with tempfile.TemporaryDirectory() as folder:
        show_dome(window, Path(folder) / "dome")
        window.close()


def photograph_watch() -> None:
    """The first half of the photographs of a dome, of which one is black, in the dialog that follows their folder."""
    request_format()
    application = QApplication.instance() or QApplication([])
    assert isinstance(application, QApplication)
    theme.apply(application, "dark")
    window = MainWindow(None)
    window.resize(*WINDOW_PX)
    window.show()
    with tempfile.TemporaryDirectory() as folder:
        dome, taken = Path(folder) / "dome", Path(folder) / "taken"
        run_step(f"lightarc simulate -o {dome} --sample leather --azimuths 6 --elevations 3 --size 160", Path())
        taken.mkdir()
        for path in (dome / "capture.toml", *sorted(dome.glob("*.tif"))[:9]):
            shutil.copy(path, taken)
        black = sorted(taken.glob("*.tif"))[4]
        tifffile.imwrite(black, tifffile.imread(black) // 300)
        dialog = window.show_watch()
        dialog.take_folder(taken)
        dialog.folder_words.setText("/captures/leather")
        dialog.begin()
        wait_until(lambda: dialog.capture.count == 9)
        settle(1.0)
        save(dialog, "window-watch")
        dialog.stop()
        wait_until(lambda: not dialog.is_running)
        window.close()


def show_dome(window: MainWindow, photographs: Path) -> None:
    """A medal under a dome of lamps, imported into a new project, with the normals of its surface."""
    run_step(f"lightarc simulate -o {photographs} --sample medal --azimuths 8 --elevations 4 --size 256", Path())
    window.new()
    window.bench.import_photographs(find([photographs]), name="Medal")
    wait_until(lambda: window.bench.document.project.has_map and not window.bench.jobs.active)
    window.show_workspace("material")
    window.material.show_page("surface")
    window.material.surface.make.click()
    wait_until(lambda: window.bench.document.project.surface is not None and not window.bench.jobs.active)
    keep(window, "window-dome")


def keep(window: MainWindow, name: str) -> None:
    rest(window, PATIENCE_S)
    save(window, name)


def save(widget: QWidget, name: str) -> None:
    path = IMAGES / f"{name}.png"
    widget.grab().save(str(path))
    compress(path, IMAGES / f"{name}.webp", max(WINDOW_PX))
    path.unlink()


def keep_results() -> None:
    """Run the commands of all tutorials that leave images, and keep these."""
    for page in tutorials():
        if page.stem in MADE:
            with tempfile.TemporaryDirectory() as folder:
                run_commands(page, Path(folder))
                for source, name in MADE[page.stem].items():
                    compress(Path(folder) / source, IMAGES / f"{name}.webp", IMAGE_PX)


def measure_front(name: str, scene: str) -> None:
    """Measure settings of all methods on a scene, and keep the plot of error against the time of a frame."""
    with tempfile.TemporaryDirectory() as folder:
        run_step(f"lightarc tradeoff {scene} --budget-s 300 -o tradeoff", Path(folder))
        compress(Path(folder, "tradeoff", "tradeoff.png"), IMAGES / f"{name}.webp", IMAGE_PX)


def show_mistake(name: str, sample: str, options: str, elevations_deg: tuple[int, ...]) -> None:
    """Photograph a sample as it should be and with a mistake, and lay both side by side."""
    sheet = Image.new("RGB", (2 * MISTAKE_PX + GAP_PX, MISTAKE_PX), "white")
    angles = ",".join(map(str, elevations_deg))
    with tempfile.TemporaryDirectory() as folder:
        for place, wrong in enumerate(("", options)):
            capture = Path(folder, str(place))
            command = f"lightarc simulate -o {capture} --sample {sample} --elevations-deg {angles} --size {MISTAKE_PX}"
            run_step(f"{command} {'--misalignment-px 0' if wrong in ('', ROOM) else wrong}", Path())
            light = linear_mean(capture)
            if wrong == ROOM:
                sides = f"--elevations-deg 45 --azimuths 8 --misalignment-px 0 --size {MISTAKE_PX}"
                run_step(f"lightarc simulate -o {folder}/room --sample {sample} {sides}", Path())
                light += 0.5 * linear_mean(Path(folder, "room"))
            photograph = Image.fromarray(np.rint(255.0 * srgb_encode(light.clip(0.0, 1.0))).astype(np.uint8))
            sheet.paste(photograph, (place * (MISTAKE_PX + GAP_PX), 0))
        sheet.save(Path(folder, "sheet.png"))
        compress(Path(folder, "sheet.png"), IMAGES / f"{name}.webp", IMAGE_PX)


def linear_mean(capture: Path) -> NDArray[np.float64]:
    """The mean of all photographs of a folder in linear light, white being 1."""
    codes = [tifffile.imread(path)[..., :3] for path in sorted(capture.glob("*.tif"))]
    return np.mean([srgb_decode(image / np.iinfo(image.dtype).max) for image in codes], axis=0)


def compress(source: Path, target: Path, most_px: int) -> None:
    """Write `source` as WebP, no larger than `most_px`, as well as `MAX_BYTES` allow."""
    with Image.open(source) as image:
        small = image.convert("RGBA" if "A" in image.getbands() else "RGB")
        small.thumbnail((most_px, most_px), Image.Resampling.LANCZOS)
        for quality in range(85, 20, -10):
            small.save(target, quality=quality, method=6)
            if target.stat().st_size <= MAX_BYTES:
                return


if __name__ == "__main__":
    sys.exit(main())
