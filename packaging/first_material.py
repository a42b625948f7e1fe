"""Measures how soon a new user sees a relit material: from the start of the program to the first frame of an example.

    python packaging/first_material.py [STARTS]

One JSON object on standard output: for each of STARTS (3) starts in one home, which is empty before the first,
`window_s` until the start page is on screen, and `material_s` until the View workspace has drawn the material of the
first example, with `click_s`, the part of it that follows the click; `cpu_s`, the CPU time of the program until then,
which other programs hardly change; and the machine's load. The click is a real one (`xdotool`), as soon as the page is
there, so that the figures hold for a user who does not read. Needs a display.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

PATIENCE_S, LOOK_S = 300.0, 0.02

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

#: Milliseconds between two looks at the window from within.
EVERY_MS = 20


def main() -> int:
    if sys.argv[1:2] == ["--window"]:
        return watch(Path(sys.argv[2]))
    starts = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    with tempfile.TemporaryDirectory() as folder:
        found = [measure(Path(folder)) for _ in range(starts)]
    print(json.dumps({"load": round(os.getloadavg()[0], 2), "starts": found}))
    return 0


def measure(home: Path) -> dict[str, float]:
    """One start in `home`, a click on the first example, and the end of the program."""
    seen = home / "seen.json"
    seen.unlink(missing_ok=True)
    places = {f"XDG_{name}_HOME": str(home / name.lower()) for name in ("CONFIG", "DATA", "STATE", "CACHE")}
    environment = {**os.environ, **places, "HOME": str(home)}
    begun = time.monotonic()
    words = [sys.executable, __file__, "--window", str(seen)]
    with subprocess.Popen(words, env=environment) as window:
        said = wait_for(seen, "card", window)
        page_s = said["time"] - begun
        x, y = said["card"]
        clicked = time.monotonic()
        subprocess.run(["xdotool", "mousemove", str(x), str(y), "click", "1"], check=True)
        said = wait_for(seen, "drawn", window)
        window.terminate()
    seconds = {"window_s": page_s, "material_s": said["drawn"] - begun, "click_s": said["drawn"] - clicked}
    return {name: round(value, 2) for name, value in (seconds | {"cpu_s": said["cpu_s"]}).items()}


def wait_for(seen: Path, what: str, window: subprocess.Popen[bytes]) -> dict[str, Any]:
    """What the window says of itself, once it says `what`."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end and window.poll() is None:
        try:
            said = dict(json.loads(seen.read_bytes()))
        except (OSError, ValueError):
            said = {}
        if what in said:
            return said
        time.sleep(LOOK_S)
    window.kill()
    raise SystemExit(f"the window never said {what}")


def watch(seen: Path) -> int:
    """The window as `lightarc` opens it, which says in `seen` where the first example is, and when it is drawn."""
    from PySide6.QtCore import QTimer
    from PySide6.QtWidgets import QApplication

    from app.window.application import run, start
    from app.window.main_window import MainWindow

    application = start()
    said: dict[str, Any] = {}

    def tell(**more: Any) -> None:
        said.update(more)
        partial = seen.with_suffix(".new")
        partial.write_text(json.dumps(said))
        partial.replace(seen)

    def look() -> None:
        window = next((each for each in QApplication.topLevelWidgets() if isinstance(each, MainWindow)), None)
        if window is None or not window.isVisible() or not window.windowHandle().isExposed():
            return
        timer.stop()
        card = window.starting.page.cards[0]
        middle = card.mapToGlobal(card.rect().center())
        window.view.drawn.connect(lambda: draw(window))
        tell(card=(middle.x(), middle.y()), time=time.monotonic())

    def draw(window: MainWindow) -> None:
        scene = window.view.viewport.scene
        if "drawn" not in said and scene is not None and scene.material is not None:
            tell(drawn=time.monotonic(), cpu_s=time.process_time())

    timer = QTimer(application)
    timer.timeout.connect(look)
    timer.start(EVERY_MS)
    return run([])


if __name__ == "__main__":
    sys.exit(main())
