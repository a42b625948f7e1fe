"""Three flows of users from their files to their result, with a count of steps, seconds of waiting, and screenshots.

    python packaging/flows.py -o FOLDER [--only FLOW …]

A conservator with photographs from a dome, a look-dev artist with ten photographs, and a researcher with a BRDF, a mesh
and an HDR environment. Each starts the program with files, as a double click or the command line does. A step is a
click, a drag, a chord of keys or a typed text; `MAX_STEPS` bounds them. The machine is the one of `tasks`: a display of
its own, mouse and keys by xdotool. Each flow also checks that the window leads into none of the dead ends that users
have met, and ends with Quit and a look at the files. FOLDER gets `flows.md`, `flows.json` and a screenshot before and
after each step; the exit code is 1 where a flow is not finished or takes more steps than it may.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from tasks import LONGEST_S, Task, choose, run, try_each, try_out, vase
from user import Seen, User

from engine.images.encode import write_exr

#: Steps that a flow may take.
MAX_STEPS = {"conservator": 12, "artist": 8, "researcher": 12}

#: The longest that a search for factors is waited for, in seconds, and the button that saves the plot of their errors.
SEARCH_S = 900.0
SAVE_PLOT = "Save plot as PNG, SVG or CSV…"

#: Files that each flow starts with.
FILES = {
    "conservator": ("dome",),
    "artist": ("ten photographs",),
    "researcher": ("blue.binary", "vase.obj", "studio.exr"),
}


def make_files(folder: Path) -> Path:
    """The folder of the files that the flows begin with; what is there already stays."""
    given = folder / "given"
    if (given / "data").exists():
        return given
    given.mkdir(parents=True)
    run("simulate", "-o", given / "dome", "--size", "128", "--elevations", "3", "--azimuths", "5")
    angles = ("--elevations-deg", "9,18,27,36,45,54,63,72,81,90")
    run("simulate", "-o", given / "ten photographs", "--size", "128", *angles)
    run("brdf", "convert", "lafortune:preset=blue-paint", "-o", given / "blue.binary")
    (given / "vase.obj").write_text(vase(48, 24))
    rows, columns = np.mgrid[0:32, 0:64]
    window = 20.0 * np.exp(-((rows - 10) ** 2 + (columns - 20) ** 2) / 12.0)
    write_exr(given / "studio.exr", {name: (0.3 + window).astype(np.float32) for name in "RGB"})
    (given / "data").mkdir()
    return given


def conservator(user: User, _given: Path) -> None:
    """Photographs from a dome → material → View → surface maps → saved project → web page and RTI."""
    has_material(user)
    user.keys("ctrl+5")
    seen = user.until(lambda seen: seen["workspace"] == "view" and seen["is_drawn"], "the view", LONGEST_S)
    expect("Tiling" not in seen["places"], "a capture from a dome is tiled in View")
    relight(user)
    user.keys("ctrl+2")
    user.until(lambda seen: seen["workspace"] == "material", "the workspace Material", 60.0)
    user.click("Surface maps")
    user.keys("ctrl+Return")
    user.until(lambda seen: seen["marks"]["surface"], "the surface maps", LONGEST_S)
    target = save(user, "Dome")
    export(user, "Web page", "RTI")
    files = export_material(user)
    expect(any(path.suffix == ".html" for path in files), "there is no web page")
    expect(any(path.suffix in (".ptm", ".rti") for path in files), "there is no RTI")
    quit_with(user, target)


def artist(user: User, _given: Path) -> None:
    """Ten photographs → material → View → glTF and Blender."""
    has_material(user)
    user.keys("ctrl+5")
    user.until(lambda seen: seen["workspace"] == "view" and seen["is_drawn"], "the view", LONGEST_S)
    relight(user)
    export(user, "Blender")
    files = export_material(user)
    expect(any(path.suffix == ".glb" for path in files), "there is no glTF")
    expect(any("blender" in str(path).lower() for path in files), "there is nothing for Blender")
    quit_with(user, None)


def researcher(user: User, _given: Path) -> None:
    """BRDF, mesh and HDR → factored → compared with the reference → the plot of errors as a file."""

    def is_open(seen: Seen) -> bool:
        marks = seen["marks"]
        return bool(marks["compared"]) and marks["mesh"] == "vase" and (marks["light"] or "").startswith("studio")

    user.until(is_open, "the BRDF, the mesh and the environment, opened together", LONGEST_S)
    user.keys("ctrl+4")
    user.until(lambda seen: seen["workspace"] == "factor", "the workspace Factor", 60.0)
    user.keys("ctrl+Return")
    user.until(lambda seen: bool(seen["marks"]["runs"]), "the run", LONGEST_S)
    user.until(lambda seen: not seen["jobs"], "the end of the search", SEARCH_S)
    name = user.seen["marks"]["runs"][0][1].lower()
    expect("blue" in name, f"what was opened last is not factored, but {name}")
    plot = user.folder / "errors.csv"
    user.click(SAVE_PLOT)
    user.until(lambda seen: "Save the error plot" in seen["dialogs"], "the dialog to save the plot", 60.0)
    user.write(str(plot))
    user.keys("Return")
    user.until(lambda _seen: plot.exists(), "the plot", 60.0)
    user.click("Use in View")
    user.until(lambda seen: seen["workspace"] == "view" and seen["is_drawn"], "the view", LONGEST_S)
    user.until(lambda seen: "blue" in (seen["marks"]["measured"] or ""), "the factors in View", LONGEST_S)
    user.keys("b")
    user.until(lambda seen: "comparing='wipe'" in seen["marks"]["look"], "the comparison", 60.0)
    expect("against='reference'" in user.seen["marks"]["look"], "it is not compared with the reference")
    quit_with(user, None)


def has_material(user: User) -> None:
    """Wait until the photographs that the program was started with have become a material."""
    user.until(
        lambda seen: (seen["marks"]["map"] or seen["marks"]["planes"]) is not None and not seen["jobs"],
        "the material",
        LONGEST_S,
    )


def relight(user: User) -> None:
    """Move the light by the mouse."""
    before = user.seen["marks"]["look"]
    user.drag("viewport", (0.5, 0.5), (0.62, 0.45), "ctrl")
    user.until(lambda seen: seen["marks"]["look"] != before, "the light", 60.0)


def save(user: User, name: str) -> Path:
    """Save the project under a name; the file appears whatever runs."""
    target = user.folder / f"{name}.lap"
    user.keys("ctrl+s")
    user.until(lambda seen: "Save as" in seen["dialogs"], "the dialog to save", 60.0)
    user.write(str(target))
    user.keys("Return")
    user.until(lambda seen: target.is_file() and seen["path"] == str(target), "the saved project", 60.0)
    return target


def export(user: User, *names: str) -> None:
    """Choose targets for other programs, and write them. Nothing is measured unasked."""
    user.keys("ctrl+6")
    user.until(lambda seen: seen["workspace"] == "export", "the workspace Export", 60.0)
    seen = user.seen
    expect(
        "PBR maps – none opened" not in seen["places"] or not seen["marks"]["surface"], "surface maps are not offered"
    )
    if "Web page" not in seen["places"]:
        user.click("Other programs")
    seen = user.until(lambda seen: target(seen, names[0]) != "", "the targets", 60.0)
    unasked = [title for title in seen["computing"] if "measuring" in title.lower()]
    expect(not unasked, f"something is measured unasked: {unasked}")
    for name in names:
        if target(seen, name) not in seen["checked"]:
            user.click(target(seen, name))
    user.keys("ctrl+Return")


def target(seen: Seen, name: str) -> str:
    """The words of the box of a target, which may say in brackets what is written; '' where there is none."""
    return next((words for words in seen["places"] if words.partition(" (")[0] == name), "")


def export_material(user: User) -> list[Path]:
    """Wait for the end of an export; its files."""
    user.until(lambda seen: bool(seen["jobs"]) or bool(write(user)), "the export", 60.0)
    user.until(lambda seen: not seen["jobs"] and bool(write(user)), "the files", LONGEST_S)
    return write(user)


def write(user: User) -> list[Path]:
    """Files in folders of exports of this user."""
    return [path for folder in user.folder.glob("* exports") for path in folder.rglob("*") if path.is_file()]


def quit_with(user: User, target: Path | None) -> None:
    """Quit by the keyboard, which is none of the steps: the program ends well, and keeps what was saved."""
    steps, pressed = list(user.steps), user.pressed
    user.shoot("after")
    code = user.close()
    user.steps, user.pressed = steps, pressed
    expect(code == 0, f"the program ended with {code}")
    expect(target is None or target.is_file(), "the saved project is lost")


def expect(is_so: bool, otherwise: str) -> None:
    """A dead end where it is not so."""
    if not is_so:
        raise SystemExit(f"dead end: {otherwise}")


FLOWS: tuple[Task, ...] = (conservator, artist, researcher)


def table(done: list[dict[str, Any]]) -> str:
    """The flows with their steps as Markdown."""
    rows = ["| flow | steps | at most | waiting / s | finished |", "|---|---|---|---|---|"]
    for each in done:
        words = "yes" if each["done"] else each["why_not"]
        count, bound = len(each["steps"]), MAX_STEPS[each["task"]]
        rows.append(f"| {each['task']} | {count} | {bound} | {each['waiting_s'] + each['start_s']:.0f} | {words} |")
    for each in done:
        rows += ["", f"## {each['task']}", "", "| | step | waiting / s |", "|---|---|---|"]
        rows += [f"| {at} | {step['step']} | {step['waited_s']} |" for at, step in enumerate(each["steps"], 1)]
    return "\n".join(rows) + "\n"


def main() -> int:
    folder, flows = choose(__doc__, FLOWS)
    given = make_files(folder)

    def try_one(flow: Task) -> dict[str, Any]:
        return try_out(flow, folder, given, *FILES[flow.__name__], shows_steps=True)

    done = try_each(flows, folder, try_one, "flows")
    (folder / "flows.md").write_text(table(done))
    print(table(done))
    return 0 if all(each["done"] and len(each["steps"]) <= MAX_STEPS[each["task"]] for each in done) else 1


if __name__ == "__main__":
    sys.exit(main())
