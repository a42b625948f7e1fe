"""A new user's day with the program, killed at twelve moments: nothing that was done may be missing afterwards.

    python packaging/trial.py FOLDER --photographs CAPTURE

needs a display with a window manager (Xvfb and openbox do), and the programs xdotool and import (ImageMagick). Mouse,
keys and eyes are those of `person`. Each moment of `DAY` is a piece of work in one workspace. Then the process is
killed, and the next start has to show the same. Images of the window before and after each kill lie in FOLDER, to be
looked at; `trial.json` says what was compared. The exit code is 1 where something was missing.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from pathlib import Path

from user import PATIENCE_S, PAUSE_S, User


def importing(user: User, photographs: Path) -> None:
    """Capture: killed while the photographs are read."""
    user.start(photographs)
    user.until(lambda seen: bool(seen["jobs"]) and seen["is_saved"] and seen["marks"]["photographs"] > 0, "the import")
    user.killed("import")
    user.go_on()
    user.until(lambda seen: seen["marks"]["map"] is not None or seen["marks"]["planes"] is not None, "the material")
    user.rest()


def a_material(user: User) -> None:
    """The material that the import has led to."""
    user.killed("material")


def exclude(user: User) -> None:
    """Capture: a photograph is left out by a key."""
    user.keys("ctrl+1")
    user.click("PhotographColumn", 0.5, 0.2)
    user.keys("x")
    user.saved()
    user.killed("excluded")


def rebuilt(user: User) -> None:
    """Material: built anew."""
    user.keys("ctrl+2")
    user.click("Rebuild material")
    user.rest()
    user.killed("rebuilt")


def compare_with(user: User) -> None:
    """BRDF: two of the library."""
    user.keys("ctrl+3", "ctrl+f")
    user.write("ward")
    user.keys("Return")
    user.until(lambda seen: bool(seen["marks"]["compared"]), "a BRDF among the compared ones", 60.0)
    user.saved()
    user.killed("compared")


def factor(user: User) -> None:
    """Factor: killed in the run, which goes on."""
    user.keys("ctrl+4", "ctrl+Return")
    user.until(lambda seen: bool(seen["marks"]["runs"]), "the run", 60.0)
    user.saved()
    is_running = bool(user.seen["jobs"])
    user.killed("factored")
    if is_running:
        user.go_on()
    user.rest()
    user.shoot("factored")


def light_up(user: User) -> None:
    """View: light and camera by the mouse."""
    user.keys("ctrl+5")
    user.until(lambda seen: seen["is_drawn"], "the image")
    time.sleep(8 * PAUSE_S)  # until the docks beside the image have their place
    light, camera = (user.seen["marks"][name] for name in ("look", "camera"))
    user.drag("viewport", (0.5, 0.5), (0.62, 0.45), "ctrl")
    user.drag("viewport", (0.5, 0.5), (0.4, 0.55))
    user.until(lambda seen: seen["marks"]["look"] != light and seen["marks"]["camera"] != camera, "both", 60.0)
    user.saved()
    user.killed("lit")


def bake(user: User) -> None:
    """View: killed in the middle of a bake, which goes on."""
    user.keys("ctrl+5", "h")
    user.until(lambda seen: "mode='sh'" in seen["marks"]["look"], "spherical harmonics", 60.0)
    user.click("Bake")
    user.until(lambda seen: any("aking" in job for job in seen["jobs"]), "the bake")
    user.saved()
    is_running = bool(user.seen["jobs"])
    user.killed("baking")
    if is_running:
        user.go_on()
    user.rest()
    user.shoot("baked")


def undo(user: User) -> None:
    """Steps that were undone can be done again after the kill."""
    steps = user.rest()["marks"]["position"]
    user.keys("ctrl+z", "ctrl+z", "ctrl+z")
    user.until(lambda seen: seen["marks"]["position"] == steps - 3, "three steps back")
    user.saved()
    user.killed("undone")
    user.keys("ctrl+shift+z", "ctrl+shift+z", "ctrl+shift+z")
    user.until(lambda seen: seen["marks"]["position"] == steps, "three steps forth")
    user.saved()


def export(user: User) -> None:
    """Export: killed while the bundle is written, which goes on where the user says."""
    target = user.folder / "Felt.lightarc"
    user.keys("ctrl+6")
    user.click("Export bundle")
    user.until(lambda seen: bool(seen["jobs"]), "the export", 60.0)
    user.killed("exported")
    user.go_on()
    user.answer("Export bundle", target)
    user.until(lambda seen: target.is_file(), "the bundle")
    user.rest()
    user.shoot("exported")


def save_as(user: User) -> None:
    """File: saved as through the dialog; the project goes on at its place, and is found there after the kill."""
    target = user.folder / "own place" / "Felt.lap"
    target.parent.mkdir(exist_ok=True)
    user.keys("ctrl+shift+s")
    user.answer("Save as", target)
    user.until(lambda seen: seen["path"] == str(target), "the copy")
    user.saved()
    user.killed("saved-as")


def collect(user: User) -> None:
    """File: collected through the menu and the dialogs; the copy opens where the photographs are not."""
    target = user.folder / "collected" / "Felt.lap"
    target.parent.mkdir(exist_ok=True)
    user.keys("alt+f", "Down", "Down", "Down", "Return")
    user.click("With results")
    user.answer("Collect", target)
    before = user.rest()
    user.until(lambda seen: target.is_file(), "the collected project")
    kept, hidden = user.folder / "photographs", user.folder / "photographs elsewhere"
    kept.rename(hidden)
    user.killed("collected")
    user.keys("ctrl+q")
    assert user.process is not None
    user.process.wait(PATIENCE_S)
    user.start(target)
    after = user.until(lambda seen: seen["path"] == str(target), "the collected project")
    time.sleep(8 * PAUSE_S)
    user.shoot("collected-opened")
    user.compare("opened elsewhere", before, after)
    hidden.rename(kept)


#: Work of the day after the import; each ends with a kill.
DAY = (a_material, exclude, rebuilt, compare_with, factor, light_up, bake, undo, export, save_as, collect)


def close(user: User) -> None:
    """Closed without a question; what was there is there when the file is opened again."""
    before = user.rest()
    code = user.close()
    user.start(Path(before["path"]))
    after = user.until(lambda seen: seen["path"] == before["path"], "the project")
    time.sleep(8 * PAUSE_S)
    user.shoot("closed-after")
    lost = {key: (old, after["marks"][key]) for key, old in before["marks"].items() if after["marks"][key] != old}
    user.compared.append({"moment": "closed", "code": code, "lost": lost, "dialogs": before["dialogs"]})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--photographs", type=Path, help="a capture; it is copied into FOLDER")
    names = [work.__name__ for work in DAY]
    parser.add_argument("--from", dest="first", choices=names, help="go on in FOLDER with this moment")
    options = parser.parse_args()
    folder = options.folder.absolute()
    user = User(folder, shots=len(list(folder.glob("*.png"))))
    if options.first is None:
        folder.mkdir(parents=True)
        photographs = folder / "photographs"
        shutil.copytree(options.photographs, photographs)
        importing(user, photographs)
    else:
        user.start()
    for work in DAY[names.index(options.first) if options.first else 0 :]:
        work(user)
    close(user)
    code = user.close()
    (folder / "trial.json").write_text(json.dumps(user.compared, indent=2))
    lost = [each for each in user.compared if each["lost"] or each["dialogs"]]
    print(f"{len(user.compared)} moments, {len(lost)} with something missing or asked; exit code {code}")
    return 1 if lost or code else 0


if __name__ == "__main__":
    sys.exit(main())
