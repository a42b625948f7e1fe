"""Twelve tasks of a buyer, each from a first start, with its clicks, its seconds of waiting and its images.

    python packaging/tasks.py -o FOLDER [--only TASK …]

needs the programs Xvfb, openbox, xdotool and import (ImageMagick). It brings its own display and window manager, and
files for the tasks: photographs of which one is broken, a dome, a measured BRDF, one in GLSL, and a vase of few
vertices. `person` moves the mouse and presses the keys. Images lie in FOLDER, to be looked at; `tasks.json` has the
counts. A task is done when what it is about is there, in the document or on disk; the exit code is 1 where one is not.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from user import PAUSE_S, ROOT, User

if TYPE_CHECKING:
    from collections.abc import Iterator

#: A task, done by a user with the files of a folder.
Task = Callable[[User, Path], None]

#: Size of the display.
SCREEN = "1280x800x24"

#: The longest that a task is waited for, in seconds.
LONGEST_S = 240.0

#: A reflectance as somebody writes it for BRDF Explorer.
GLSL = """analytic

::begin parameters
float shine 1 200 30
color tint .7 .3 .1
::end parameters

::begin shader
vec3 BRDF( vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y )
{
    vec3 H = normalize(L + V);
    return tint / 3.14159265 + vec3((shine + 2.0) / 25.0 * pow(max(dot(N, H), 0.0), shine));
}
::end shader
"""


def make(folder: Path) -> Path:
    """The folder of the files that the tasks begin with, made by the program itself."""
    place = folder / "given"
    if place.exists():
        return place
    place.mkdir()
    small = ("--size", "128")
    run("simulate", "-o", place / "photographs", *small)
    run("simulate", "-o", place / "dome", *small, "--elevations", "3", "--azimuths", "5")
    run("brdf", "convert", "lafortune:preset=blue-paint", "-o", place / "blue.binary")
    (place / "tinted.brdf").write_text(GLSL)
    (place / "vase.obj").write_text(vase(48, 24))
    broken = sorted((place / "photographs").glob("*.tif*"))[4]
    broken.write_bytes(broken.read_bytes()[:2000])
    return place


def vase(columns: int, rows: int) -> str:
    """A vase of few vertices as an .obj, as users bake: a turned profile with texture coordinates."""
    lines = []
    for row in range(rows + 1):
        up = row / rows
        radius = 0.3 + 0.25 * math.sin(2.0 * math.pi * (up + 0.15)) + 0.1 * up
        for column in range(columns + 1):
            around = 2.0 * math.pi * column / columns
            lines.append(f"v {radius * math.sin(around):.5f} {2.0 * up - 1.0:.5f} {radius * math.cos(around):.5f}")
            lines.append(f"vt {column / columns:.5f} {up:.5f}")
    for row in range(rows):
        for column in range(1, columns + 1):
            at = row * (columns + 1) + column
            lines.append("f " + " ".join(f"{n}/{n}" for n in (at, at + 1, at + columns + 2, at + columns + 1)))
    return "\n".join(lines)


def run(*words: object) -> None:
    """A verb of the program."""
    subprocess.run([sys.executable, "-m", "app", *map(str, words)], cwd=ROOT, check=True, capture_output=True)


def workspace(user: User, name: str) -> None:
    """Go to a workspace by its button."""
    user.click(name)
    user.until(lambda seen: seen["workspace"] == name.lower(), f"the workspace {name}", 60.0)


def with_sample(user: User) -> None:
    """Open the sample from the empty window."""
    user.click("Try the sample capture")
    user.until(lambda seen: seen["marks"]["map"] is not None and not seen["jobs"], "the material", LONGEST_S)


def on_model(user: User) -> None:
    """Open the sample, and see it on a model."""
    with_sample(user)
    workspace(user, "View")
    user.until(lambda seen: seen["is_drawn"], "the image", LONGEST_S)


def on_vase(user: User, given: Path) -> None:
    """Open a model of one's own, which comes to the front in View."""
    user.keys("ctrl+o")
    user.answer("Open", given / "vase.obj")
    user.until(lambda seen: seen["marks"]["mesh"] == "vase" and seen["workspace"] == "view", "the model", LONGEST_S)
    user.until(lambda seen: seen["is_drawn"] and not seen["jobs"], "the image", LONGEST_S)


def sample(user: User, _given: Path) -> None:
    """The sample on a model."""
    on_model(user)
    time.sleep(8 * PAUSE_S)


def photographs(user: User, given: Path) -> None:
    """Own photographs, of which one is broken and left out."""
    user.click("Choose photographs…")
    user.answer("Folder of photographs", given / "photographs")
    user.until(lambda seen: "Leave it out" in seen["places"], "the question", LONGEST_S)
    user.shoot("broken")
    user.keys("Return")
    user.until(lambda seen: seen["marks"]["map"] is not None and not seen["jobs"], "the material", LONGEST_S)
    workspace(user, "Material")


def dome(user: User, given: Path) -> None:
    """Photographs under a dome of lamps."""
    user.click("Choose photographs…")
    user.answer("Folder of photographs", given / "dome")
    user.until(lambda seen: seen["marks"]["planes"] is not None and not seen["jobs"], "the material", LONGEST_S)
    workspace(user, "View")
    user.until(lambda seen: seen["is_drawn"], "the image", LONGEST_S)


def compare(user: User, given: Path) -> None:
    """Five BRDFs compared, a measured one among them, and a model fitted to it."""
    workspace(user, "BRDF")
    user.click("Search the library")
    for name in ("ward", "oren", "cook", "ashikhmin"):
        user.write(name)
        user.keys("Return")
    user.keys("ctrl+o")
    user.answer("Open", given / "blue.binary")
    seen = user.until(lambda seen: len(seen["marks"]["compared"]) >= 5, "five BRDFs", LONGEST_S)
    count = len(seen["marks"]["compared"])
    user.click("Fit")
    user.until(lambda seen: len(seen["marks"]["compared"]) > count and not seen["jobs"], "the fit", LONGEST_S)


def write(user: User, given: Path) -> None:
    """A BRDF written in GLSL, with a parameter moved."""
    user.keys("ctrl+o")
    user.answer("Open", given / "tinted.brdf")
    seen = user.until(lambda seen: bool(seen["marks"]["compared"]), "the BRDF", LONGEST_S)
    if seen["workspace"] != "brdf":
        workspace(user, "BRDF")
    user.until(lambda seen: any(name.startswith("Shine") for name in seen["places"]), "its sliders", LONGEST_S)
    user.drag("Shine #2", (0.3, 0.5), (0.8, 0.5))
    user.until(lambda seen: not seen["jobs"], "its images", LONGEST_S)


def factor(user: User, _given: Path) -> None:
    """The material's BRDF factored by three methods, and the last used."""
    workspace(user, "Factor")
    for number, downs in enumerate((1, 1, 3)):
        user.click("Method")
        user.keys(*["Down"] * downs, "Return")
        user.keys("ctrl+Return")
        user.until(lambda seen, at=number: len(seen["marks"]["runs"]) > at, "the run", LONGEST_S)
        user.until(lambda seen: not seen["jobs"], "the end of the run", LONGEST_S)
    user.click("Use in View")
    user.until(lambda seen: seen["workspace"] == "view" and not seen["jobs"], "the material", LONGEST_S)


def bake(user: User, given: Path) -> None:
    """Each mode baked on a model of one's own, and wiped against the reference.

    It has 1,225 vertices: the draped cloth has 58,081, for which the panel says minutes, for Gaussians many of them.
    """
    with_sample(user)
    on_vase(user, given)
    for key in ("h", "w", "g"):
        user.keys(key, "ctrl+Return")
        user.until(lambda seen: "Stop baking" in seen["places"], "the beginning of the bake", LONGEST_S)
        user.until(
            lambda seen: not {"Stop baking", "Bake"} & seen["places"].keys() and not seen["jobs"], "the bake", LONGEST_S
        )
        if key == "h":
            user.keys("b")
        time.sleep(16 * PAUSE_S)
        user.shoot(f"wipe-{key}")


def cheapest(user: User, given: Path) -> None:
    """The cheapest mode within 2 % for a model of one's own."""
    on_vase(user, given)
    user.until(lambda seen: "Budget" in seen["places"], "the Accuracy dock", LONGEST_S)
    before = user.seen["marks"]["look"]
    user.click("Budget", 0.3)
    user.write("2 %")
    user.keys("Return")
    user.until(lambda seen: "Stop measuring" in seen["places"], "the beginning", LONGEST_S)
    user.shoot("measuring")
    user.until(lambda seen: "Stop measuring" not in seen["places"], "the end", LONGEST_S)
    user.until(lambda seen: seen["marks"]["look"] != before, "the choice", 60.0)


def save(user: User, _given: Path) -> None:
    """An image and a turntable."""
    on_model(user)
    for keys, title, name in (("ctrl+p", "Save an image", "a.png"), ("ctrl+shift+p", "Save a turntable", "a.webp")):
        user.keys(keys)
        user.until(lambda seen, title=title: title in seen["dialogs"], "the dialog", 60.0)
        if name == "a.webp":
            user.click("Length", 0.5)
            user.keys("ctrl+a")
            user.write("0.5")
            user.keys("Tab")
        user.shoot(name[:-4])
        user.keys("Return")
        time.sleep(4 * PAUSE_S)
        target = user.folder / name
        user.answer(title, target)
        user.until(lambda _seen, target=target: target.exists(), name, LONGEST_S)


def export(user: User, _given: Path) -> None:
    """The material for Blender."""
    with_sample(user)
    workspace(user, "Export")
    user.click("Other programs")
    user.click(next(words for words in user.seen["places"] if words.startswith("Blender")))
    user.keys("ctrl+Return")
    target = user.folder / "Woven sample exports"
    user.until(lambda _seen: any(target.rglob("*lender*")), "the files", LONGEST_S)
    user.until(lambda seen: not seen["jobs"], "the end", LONGEST_S)


def recover(user: User, _given: Path) -> None:
    """Everything is there again after a kill."""
    on_model(user)
    time.sleep(8 * PAUSE_S)
    before = user.seen["marks"]["look"]
    user.drag("viewport", (0.5, 0.5), (0.62, 0.45), "ctrl")
    user.until(lambda seen: seen["marks"]["look"] != before, "the light", 60.0)
    user.saved()
    user.killed("recover")
    if user.compared[-1]["lost"]:
        raise SystemExit(f"lost: {user.compared[-1]['lost']}")


def keyboard(user: User, _given: Path) -> None:
    """From the first start to a saved image and a bundle without the mouse."""
    for _ in range(20):
        if user.seen["focus"] == "Try the sample capture":
            break
        user.keys("Tab")
        time.sleep(PAUSE_S)
    user.keys("space")
    user.until(lambda seen: seen["marks"]["map"] is not None and not seen["jobs"], "the material", LONGEST_S)
    user.keys("ctrl+5")
    user.until(lambda seen: seen["workspace"] == "view" and seen["is_drawn"], "the image", LONGEST_S)
    time.sleep(8 * PAUSE_S)
    user.keys("ctrl+p")
    user.until(lambda seen: "Save an image" in seen["dialogs"], "the dialog", 60.0)
    user.keys("Return")
    time.sleep(4 * PAUSE_S)
    user.keys("Return")
    image = user.folder / "Woven sample.png"
    user.until(lambda _seen: image.exists(), "the image", LONGEST_S)
    user.keys("ctrl+e")
    user.until(lambda seen: seen["workspace"] == "export", "the workspace", 60.0)
    user.keys("ctrl+Return")
    user.until(lambda _seen: (user.folder / "Woven sample.lightarc").exists(), "the bundle", LONGEST_S)
    user.until(lambda seen: not seen["jobs"], "the end", LONGEST_S)
    if user.clicks:
        raise SystemExit("the mouse was used")


TASKS: tuple[Task, ...] = (
    *(sample, photographs, dome, compare, write, factor),
    *(bake, cheapest, save, export, recover, keyboard),
)


def try_out(
    task: Task, folder: Path, given: Path, *files: str, shows_steps: bool = False, is_new: bool = False
) -> dict[str, Any]:
    """One task from a first start, with `files` of `given`: its counts, and why it was not done; '' where it was."""
    name, place = task.__name__, folder / task.__name__
    place.mkdir(parents=True)
    user, why_not = User(place, shows_steps=shows_steps, is_new=is_new), ""
    begun = time.monotonic()
    user.start(*(given / file for file in files))
    start_s = time.monotonic() - begun
    user.clicks = user.pressed = 0
    user.waited_s = 0.0
    if files:
        user.steps = [{"step": f"start with {', '.join(files)}", "waited_s": 0.0}]
    try:
        task(user, given)
        time.sleep(4 * PAUSE_S)
        user.shoot(name)
    except SystemExit as reason:
        why_not = str(reason)
    if user.process is not None:
        user.process.kill()
        user.process.wait()
    return {
        "task": name,
        "done": not why_not,
        "clicks": user.clicks,
        "keys": user.pressed,
        "waiting_s": round(user.waited_s, 1),
        "start_s": round(start_s, 1),
        "whole_s": round(time.monotonic() - begun, 1),
        "moments": {name: round(seconds, 1) for name, seconds in user.moments.items()},
        "dead_ends": user.notices + ([why_not] if why_not else []),
        "steps": [{**step, "waited_s": round(step["waited_s"], 1)} for step in user.steps],
        "pictures": sorted(path.name for path in place.glob("*.png")),
        "why_not": why_not,
    }


@contextmanager
def display() -> Iterator[None]:
    """A display of one's own with a window manager, until the block ends."""
    read, write = os.pipe()
    screen = ["Xvfb", "-displayfd", str(write), "-screen", "0", SCREEN, "-nolisten", "tcp"]
    server = subprocess.Popen(screen, pass_fds=(write,), stderr=subprocess.DEVNULL)
    os.environ["DISPLAY"] = f":{os.read(read, 16).decode().strip()}"
    manager = subprocess.Popen(["openbox"], stderr=subprocess.DEVNULL)
    try:
        time.sleep(1.0)
        yield
    finally:
        for process in (manager, server):
            process.terminate()
            process.wait()


def choose(about: str | None, tasks: Sequence[Task]) -> tuple[Path, list[Task]]:
    """The folder for the results and the tasks that the command line chooses of `tasks`."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--only", nargs="+", choices=[task.__name__ for task in tasks])
    options = parser.parse_args()
    folder = options.output.absolute()
    folder.mkdir(parents=True, exist_ok=True)
    return folder, [task for task in tasks if options.only is None or task.__name__ in options.only]


def try_each(
    tasks: Sequence[Task], folder: Path, try_one: Callable[[Task], dict[str, Any]], name: str
) -> list[dict[str, Any]]:
    """The results of `tasks`, one after the other at a display; NAME.json in `folder` has those so far."""
    done = []
    with display():
        for task in tasks:
            done.append(try_one(task))
            print(json.dumps(done[-1]), flush=True)
            (folder / f"{name}.json").write_text(json.dumps(done, indent=2))
    return done


def main() -> int:
    folder, tasks = choose(__doc__, TASKS)
    given = make(folder)
    done = try_each(tasks, folder, lambda task: try_out(task, folder, given), "tasks")
    return 0 if all(each["done"] for each in done) else 1


if __name__ == "__main__":
    sys.exit(main())
