"""A new user's day with the program, killed at twelve moments: nothing that was done may be missing afterwards.

    python packaging/trial.py FOLDER --photographs CAPTURE

needs a display with a window manager (Xvfb and openbox do), and the programs xdotool and import (ImageMagick). Mouse,
keys and eyes are those of `person`. Each moment of `DAY` is a piece of work in one workspace. Then the process is
killed, and the next start has to show the same. Pictures of the window before and after each kill lie in FOLDER, to be
looked at; `trial.json` says what was compared. The exit code is 1 where something was missing.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from pathlib import Path

from person import PATIENCE_S, PAUSE_S, Person


def importing(person: Person, photographs: Path) -> None:
    """Capture: killed while the photographs are read."""
    person.start(photographs)
    person.until(
        lambda seen: bool(seen["jobs"]) and seen["is_saved"] and seen["marks"]["photographs"] > 0, "the import"
    )
    person.killed("import")
    person.go_on()
    person.until(lambda seen: seen["marks"]["map"] is not None or seen["marks"]["planes"] is not None, "the material")
    person.rest()


def a_material(person: Person) -> None:
    """The material that the import has led to."""
    person.killed("material")


def excluded(person: Person) -> None:
    """Capture: a photograph is left out by a key."""
    person.keys("ctrl+1")
    person.click("PhotographColumn", 0.5, 0.2)
    person.keys("x")
    person.saved()
    person.killed("excluded")


def rebuilt(person: Person) -> None:
    """Material: built anew."""
    person.keys("ctrl+2")
    person.click("Rebuild material")
    person.rest()
    person.killed("rebuilt")


def compared(person: Person) -> None:
    """BRDF: two of the library."""
    person.keys("ctrl+3", "ctrl+f")
    person.write("ward")
    person.keys("Return")
    person.until(lambda seen: bool(seen["marks"]["compared"]), "a BRDF among the compared ones", 60.0)
    person.saved()
    person.killed("compared")


def factored(person: Person) -> None:
    """Factor: killed in the run, which goes on."""
    person.keys("ctrl+4", "ctrl+Return")
    person.until(lambda seen: bool(seen["marks"]["runs"]), "the run", 60.0)
    person.saved()
    is_running = bool(person.seen["jobs"])
    person.killed("factored")
    if is_running:
        person.go_on()
    person.rest()
    person.shot("factored")


def lit(person: Person) -> None:
    """View: light and camera by the mouse."""
    person.keys("ctrl+5")
    person.until(lambda seen: seen["is_drawn"], "the picture")
    time.sleep(8 * PAUSE_S)  # until the docks beside the picture have their place
    light, camera = (person.seen["marks"][name] for name in ("look", "camera"))
    person.drag("viewport", (0.5, 0.5), (0.62, 0.45), "ctrl")
    person.drag("viewport", (0.5, 0.5), (0.4, 0.55))
    person.until(lambda seen: seen["marks"]["look"] != light and seen["marks"]["camera"] != camera, "both", 60.0)
    person.saved()
    person.killed("lit")


def baked(person: Person) -> None:
    """View: killed in the middle of a bake, which goes on."""
    person.keys("ctrl+5", "h")
    person.until(lambda seen: "mode='sh'" in seen["marks"]["look"], "spherical harmonics", 60.0)
    person.click("Bake")
    person.until(lambda seen: any("aking" in job for job in seen["jobs"]), "the bake")
    person.saved()
    is_running = bool(person.seen["jobs"])
    person.killed("baking")
    if is_running:
        person.go_on()
    person.rest()
    person.shot("baked")


def undone(person: Person) -> None:
    """Steps that were undone can be done again after the kill."""
    steps = person.rest()["marks"]["position"]
    person.keys("ctrl+z", "ctrl+z", "ctrl+z")
    person.until(lambda seen: seen["marks"]["position"] == steps - 3, "three steps back")
    person.saved()
    person.killed("undone")
    person.keys("ctrl+shift+z", "ctrl+shift+z", "ctrl+shift+z")
    person.until(lambda seen: seen["marks"]["position"] == steps, "three steps forth")
    person.saved()


def exported(person: Person) -> None:
    """Export: killed while the bundle is written, which goes on where the person says."""
    target = person.folder / "Felt.lightarc"
    person.keys("ctrl+6")
    person.click("Export bundle")
    person.until(lambda seen: bool(seen["jobs"]), "the export", 60.0)
    person.killed("exported")
    person.go_on()
    person.answer("Export bundle", target)
    person.until(lambda seen: target.is_file(), "the bundle")
    person.rest()
    person.shot("exported")


def saved_as(person: Person) -> None:
    """File: saved as through the dialog; the project goes on at its place, and is found there after the kill."""
    target = person.folder / "own place" / "Felt.lap"
    target.parent.mkdir(exist_ok=True)
    person.keys("ctrl+shift+s")
    person.answer("Save as", target)
    person.until(lambda seen: seen["path"] == str(target), "the copy")
    person.saved()
    person.killed("saved-as")


def collected(person: Person) -> None:
    """File: collected through the menu and the dialogs; the copy opens where the photographs are not."""
    target = person.folder / "collected" / "Felt.lap"
    target.parent.mkdir(exist_ok=True)
    person.keys("alt+f", "Down", "Down", "Down", "Return")
    person.click("With results")
    person.answer("Collect", target)
    before = person.rest()
    person.until(lambda seen: target.is_file(), "the collected project")
    kept, hidden = person.folder / "photographs", person.folder / "photographs elsewhere"
    kept.rename(hidden)
    person.killed("collected")
    person.keys("ctrl+q")
    assert person.process is not None
    person.process.wait(PATIENCE_S)
    person.start(target)
    after = person.until(lambda seen: seen["path"] == str(target), "the collected project")
    time.sleep(8 * PAUSE_S)
    person.shot("collected-opened")
    person.compare("opened elsewhere", before, after)
    hidden.rename(kept)


#: Work of the day after the import; each ends with a kill.
DAY = (a_material, excluded, rebuilt, compared, factored, lit, baked, undone, exported, saved_as, collected)


def closed(person: Person) -> None:
    """Closed without a question; what was there is there when the file is opened again."""
    before = person.rest()
    code = person.close()
    person.start(Path(before["path"]))
    after = person.until(lambda seen: seen["path"] == before["path"], "the project")
    time.sleep(8 * PAUSE_S)
    person.shot("closed-after")
    lost = {key: (old, after["marks"][key]) for key, old in before["marks"].items() if after["marks"][key] != old}
    person.compared.append({"moment": "closed", "code": code, "lost": lost, "dialogs": before["dialogs"]})


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--photographs", type=Path, help="a capture; it is copied into FOLDER")
    names = [work.__name__ for work in DAY]
    parser.add_argument("--from", dest="first", choices=names, help="go on in FOLDER with this moment")
    options = parser.parse_args()
    folder = options.folder.absolute()
    person = Person(folder, shots=len(list(folder.glob("*.png"))))
    if options.first is None:
        folder.mkdir(parents=True)
        photographs = folder / "photographs"
        shutil.copytree(options.photographs, photographs)
        importing(person, photographs)
    else:
        person.start()
    for work in DAY[names.index(options.first) if options.first else 0 :]:
        work(person)
    closed(person)
    code = person.close()
    (folder / "trial.json").write_text(json.dumps(person.compared, indent=2))
    lost = [each for each in person.compared if each["lost"] or each["dialogs"]]
    print(f"{len(person.compared)} moments, {len(lost)} with something missing or asked; exit code {code}")
    return 1 if lost or code else 0


if __name__ == "__main__":
    sys.exit(main())
