"""Drives the real window over the built-in sample and saves an image of every workspace, dock, dialog and state.

    python packaging/screenshots.py FOLDER --sizes 1280x800 --themes dark --parts empty dialogs

needs a display with OpenGL that is as large as the largest size (`Xvfb -screen 0 2600x1700x24` does). Without
`--sizes`, `--themes` and `--parts` it takes all of them: 1024 × 700, 1280 × 720, 1280 × 800, 1920 × 1080,
2560 × 1440, and 1280 × 800 at 200 % from a second process, each dark and light. The program starts once; what takes
long is done once, and then seen in all sizes and themes. Images are named STATE-SIZE-THEME.png. `contact-sheet.png`
has all images of the folder, small, with their names; `faults.txt` lists what `benchmarks.app.faults` finds in those
of this run: text that is cut, overlapping widgets, faint text, controls without a name. The parts are in
`packaging/screens.py`; images of the README and the manual are made by `packaging/manual_images.py`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from PySide6.QtWidgets import QApplication
from screens import PARTS, Gallery, Size

from app.viewport.gl_surface import request_format
from app.widgets import language, theme
from app.window.main_window import MainWindow

THEMES = ("dark", "light")

#: Sizes by their names; the last is the second size, in pixels that are twice as large.
DOUBLED = "200%"
SIZES = {
    **{
        f"{width}x{height}": (width, height)
        for width, height in ((1024, 700), (1280, 720), (1280, 800), (1920, 1080), (2560, 1440))
    },
    DOUBLED: (1280, 800),
}

#: Width of an image on the contact sheet, the images of a row, and the height of a name.
SMALL_PX, IN_A_ROW, NAME_PX = 400, 6, 16

#: Set in the process whose pixels are twice as large.
IS_DOUBLED = "LIGHTARC_SCREENSHOTS_DOUBLED"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--sizes",
        nargs="+",
        choices=SIZES,
        default=list(SIZES),
        metavar="SIZE",
        help=", ".join(SIZES).replace("%", "%%"),
    )
    parser.add_argument(
        "--themes", nargs="+", choices=THEMES, default=list(THEMES), metavar="THEME", help="dark, light"
    )
    parser.add_argument("--language", choices=language.LANGUAGES, default="en", help="language of the window")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=list(PARTS), metavar="PART", help=", ".join(PARTS))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    doubled = os.environ.get(IS_DOUBLED) is not None
    sizes = [name for name in options.sizes if (name == DOUBLED) == doubled]
    faults: list[str] = []
    if sizes:
        faults = drive(options, [Size(name.removesuffix("%"), *SIZES[name]) for name in sizes])
    if doubled:
        print(*faults, sep="\n")
        return 0
    if DOUBLED in options.sizes:
        faults += at_200_percent(options)
    (options.folder / "faults.txt").write_text("".join(f"{line}\n" for line in faults), encoding="utf-8")
    contact_sheet(options.folder)
    print(f"{len(faults)} faults", *faults, sep="\n")
    return 0


def at_200_percent(options: argparse.Namespace) -> list[str]:
    """Take the images that have pixels twice as large, in a process of their own; their faults."""
    again = [sys.executable, __file__, str(options.folder), "--sizes", DOUBLED]
    again += ["--themes", *options.themes, "--parts", *options.parts, "--language", options.language]
    doubled = {**os.environ, "QT_SCALE_FACTOR": "2", IS_DOUBLED: "1"}
    done = subprocess.run(again, env=doubled, check=True, stdout=subprocess.PIPE, text=True)
    return [line for line in done.stdout.splitlines() if ".png: " in line]


def drive(options: argparse.Namespace, sizes: list[Size]) -> list[str]:
    """Open the window, lead it through the chosen parts, and close it; the faults of the images."""
    request_format()
    application = QApplication([])
    theme.apply(application, options.themes[0])
    language.use(options.language, application)
    window = MainWindow(None)
    window.show()
    gallery = Gallery(options.folder, sizes, options.themes)
    for name, part in PARTS.items():
        if name in options.parts:
            begun, before = time.monotonic(), gallery.taken
            part(gallery, window)
            print(f"{name}: {gallery.taken - before} images in {time.monotonic() - begun:.0f} s", file=sys.stderr)
    window.close()
    return gallery.faults


def contact_sheet(folder: Path) -> None:
    """All images of `folder`, small and with their names, in one."""
    from PIL import Image, ImageDraw

    paths = [path for path in sorted(folder.glob("*.png")) if not path.name.startswith("contact-sheet")]
    small = []
    for path in paths:
        with Image.open(path) as image:
            height = max(1, round(SMALL_PX * image.height / image.width))
            small.append(image.convert("RGB").resize((SMALL_PX, height), Image.Resampling.LANCZOS))
    rows = [range(first, min(first + IN_A_ROW, len(small))) for first in range(0, len(small), IN_A_ROW)]
    heights = [max(small[at].height for at in row) + NAME_PX for row in rows]
    sheet = Image.new("RGB", (SMALL_PX * IN_A_ROW, max(1, sum(heights))), "#808080")
    draw, top = ImageDraw.Draw(sheet), 0
    for row, height in zip(rows, heights, strict=True):
        for at in row:
            left = SMALL_PX * (at - row.start)
            draw.text((left + 4, top + 2), paths[at].stem, fill="#ffffff")
            sheet.paste(small[at], (left, top + NAME_PX))
        top += height
    sheet.save(folder / "contact-sheet.png")


if __name__ == "__main__":
    sys.exit(main())
