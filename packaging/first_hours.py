"""Three first hours: from an empty home and the start page to the result that somebody came for.

    python packaging/first_hours.py -o FOLDER [--only ARTIST …]

A look-dev artist, a conservator and a researcher open an example, go back to the start page, open their own files by
it, and go on as `flows` does. A dead end is a dialog or a banner that says why something cannot be, or a wait in vain.
`MAX_S`, `MAX_RELIT_S` and `MAX_DEAD_ENDS` bound an hour. Compiled kernels are those of the checkout, as the installers
bring theirs; everything else of the home is empty. FOLDER gets `hours.md`, `hours.json` and a screenshot before each
step; the exit code is 1 where an hour misses a bound.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path
from typing import Any

import flows
from tasks import LONGEST_S, Task, choose, try_each, try_out
from user import User

#: Seconds from the start of the program to the result, and to a material of an example under a light that was moved.
MAX_S, MAX_RELIT_S = 600.0, 15.0

MAX_DEAD_ENDS = 1


def artist(user: User, given: Path) -> None:
    """The woven cloth, then ten photographs of their own → glTF and Blender."""
    see_example(user, "Woven cloth")
    open_photographs(user, given / "ten photographs")
    flows.artist(user, given)


def conservator(user: User, given: Path) -> None:
    """The bronze medal, then photographs of their own from a dome → surface maps, project, web page and RTI."""
    see_example(user, "Bronze medal")
    open_photographs(user, given / "dome")
    flows.conservator(user, given)


def researcher(user: User, given: Path) -> None:
    """The measured satin, then a BRDF, a mesh and an environment of their own → factors against the reference."""
    see_example(user, "Measured satin")
    start_page(user)
    user.click("BRDF or material")
    user.answer("BRDF or material", given / "blue.binary")
    user.until(lambda seen: bool(seen["marks"]["compared"]), "the BRDF", LONGEST_S)
    open_file(user, given / "vase.obj", "mesh")
    open_file(user, given / "studio.exr", "light")
    flows.researcher(user, given)


def open_file(user: User, path: Path, mark: str) -> None:
    """Open a file, and wait until the document has it."""
    user.keys("ctrl+o")
    user.answer("Open", path)
    user.until(lambda seen: path.stem in (seen["marks"][mark] or ""), path.name, LONGEST_S)


def see_example(user: User, name: str) -> None:
    """Open an example of the start page, and light it from elsewhere."""
    user.click(name)
    user.until(lambda seen: seen["workspace"] == "view" and seen["is_drawn"], "the example in View", LONGEST_S)
    flows.relight(user)
    user.moments["relit"] = time.monotonic() - user.begun


def start_page(user: User) -> None:
    user.keys("ctrl+shift+h")
    user.until(lambda seen: seen["workspace"] == "start", "the start page", 60.0)


def open_photographs(user: User, folder: Path) -> None:
    start_page(user)
    user.click("Photographs")
    user.answer("Folder of photographs", folder)


HOURS: tuple[Task, ...] = (artist, conservator, researcher)


def table(done: list[dict[str, Any]]) -> str:
    """The hours with their steps as Markdown."""
    rows = [
        f"Load {os.getloadavg()[0]:.1f} of {os.cpu_count()} cores at the end.\n",
        "| first hour | steps | to the result / s | relit example / s | dead ends | finished |",
        "|---|---|---|---|---|---|",
    ]
    for each in done:
        words = "yes" if each["done"] else each["why_not"]
        relit = each["moments"].get("relit", float("nan"))
        rows.append(
            f"| {each['task']} | {len(each['steps'])} | {each['whole_s']:.0f} | {relit:.1f} | "
            f"{len(each['dead_ends'])} | {words} |"
        )
    for each in done:
        rows += ["", f"## {each['task']}", "", *(f"- dead end: {words}" for words in each["dead_ends"])]
        rows += ["", "| | step | waiting / s |", "|---|---|---|"]
        rows += [f"| {at} | {step['step']} | {step['waited_s']} |" for at, step in enumerate(each["steps"], 1)]
    return "\n".join(rows) + "\n"


def is_well(hour: dict[str, Any]) -> bool:
    """True for a finished hour within all bounds."""
    within = hour["whole_s"] <= MAX_S and hour["moments"].get("relit", MAX_S) <= MAX_RELIT_S
    return bool(hour["done"] and within and len(hour["dead_ends"]) <= MAX_DEAD_ENDS)


def main() -> int:
    folder, hours = choose(__doc__, HOURS)
    given = flows.make_files(folder)
    done = try_each(hours, folder, lambda hour: try_out(hour, folder, given, shows_steps=True, is_new=True), "hours")
    (folder / "hours.md").write_text(table(done))
    print(table(done))
    return 0 if all(map(is_well, done)) else 1


if __name__ == "__main__":
    sys.exit(main())
