"""`lightarc desktop-install`: the entry of the menu, icon, kinds of files, previews and man page of a Linux desktop.

What is written follows the specifications of freedesktop.org: desktop entries, shared MIME information, icon themes;
previews of files are those that GNOME, Xfce and others ask thumbnailers for. Installers write the same files.
"""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from app.arguments.results import SHARED, Output
from app.cli.completion import find_words
from engine.core.errors import MissingCapability
from engine.core.steps import Step
from engine.storage.atomic import discard, make_folder, write_bytes

EXAMPLE = "lightarc desktop-install"

#: Kinds of files: MIME type, comment, suffix, the bytes at its beginning, and the type that it is a form of.
FILE_KINDS = (
    ("application/x-lightarc-material", "Lightarc material", "lightarc", "PK\\003\\004", "application/zip"),
    ("application/x-lightarc-project", "Lightarc project", "lap", "SQLite format 3", "application/vnd.sqlite3"),
    ("image/x-polynomial-texture-map", "Polynomial texture map", "ptm", "PTM_1.", ""),
    ("image/x-reflectance-transformation", "Reflectance transformation image", "rti", "#HSH", ""),
)

ICON = Path(__file__).parents[2] / "resources" / "icons" / "lightarc.svg"

#: Programs that renew the tables of a desktop, each with the folder that it takes.
TABLES = {"update-desktop-database": "applications", "update-mime-database": "mime", "gtk-update-icon-cache": "icons"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--folder",
        type=Output(SHARED, Path),
        metavar="FOLDER",
        help="in place of the user's own (~/.local/share): /usr/share for all users",
    )
    parser.add_argument("--remove", action="store_true", help="take everything away that this command writes")


def run(arguments: argparse.Namespace, _show: Callable[[Step], None]) -> dict[str, Any]:
    """`files`, those that were written or removed; MissingCapability on systems without such desktops."""
    if not sys.platform.startswith("linux"):
        raise MissingCapability("Entries of this kind are of Linux desktops", "Make a shortcut to lightarc-window")
    folder = arguments.folder or user_folder()
    files = dict(entries(command_here(), arguments.build_parser(None)))
    for name, content in files.items():
        path = folder / name
        if arguments.remove:
            if path.is_file():
                discard(path)
        else:
            make_folder(path.parent)
            write_bytes(path, content)
    renew_tables(folder)
    return {"folder": str(folder), "files": sorted(files), "removed": arguments.remove, "warnings": []}


def report(result: dict[str, Any]) -> str:
    verb = "Removed" if result["removed"] else "Wrote"
    return "\n".join([f"{verb} in {result['folder']}:", *(f"  {name}" for name in result["files"])])


def user_folder() -> Path:
    """Folder in which a user keeps such files (XDG_DATA_HOME)."""
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")


def command_here() -> list[str]:
    """The words that start this program, whatever the search path of a desktop is."""
    script = Path(sys.argv[0]).absolute()
    if script.name.startswith("lightarc") and os.access(script, os.X_OK):
        return [str(script)]
    found = shutil.which("lightarc")
    return [found] if found else [sys.executable, "-m", __name__.partition(".cli")[0]]


def renew_tables(folder: Path) -> None:
    """Let the desktop see what has changed, where it has programs for that."""
    for program, below in TABLES.items():
        place = folder / below / ("hicolor" if below == "icons" else "")
        if shutil.which(program) and place.is_dir():
            options = ["--quiet", "--ignore-theme-index"] if below == "icons" else []
            subprocess.run([program, *options, str(place)], stdin=subprocess.DEVNULL, capture_output=True)


def entries(command: list[str], parser: argparse.ArgumentParser) -> Iterator[tuple[str, bytes]]:
    """Yield path, within a folder as /usr/share, and content of each file; `command` are the words of the program."""
    start = " ".join(map(_quote, command))
    yield "applications/lightarc.desktop", write_entry(start).encode()
    yield "icons/hicolor/scalable/apps/lightarc.svg", write_icon().encode()
    for kind, *_ in FILE_KINDS[:2]:
        yield f"icons/hicolor/scalable/mimetypes/{kind.replace('/', '-')}.svg", write_icon().encode()
    yield "mime/packages/lightarc.xml", write_kinds().encode()
    yield "thumbnailers/lightarc.thumbnailer", write_thumbnailer(start).encode()
    yield "man/man1/lightarc.1", write_man_page(parser).encode()


def _quote(word: str) -> str:
    """A word of an Exec line: its quotes are those of the desktop entry specification."""
    plain = word.replace("%", "%%")
    if shlex.quote(word) == word:
        return plain
    for letter in '\\"`$':
        plain = plain.replace(letter, f"\\{letter}")
    return '"' + plain.replace("\\", "\\\\") + '"'


def write_entry(start: str) -> str:
    """The desktop entry."""
    kinds = ";".join(kind for kind, *_ in FILE_KINDS)
    return "\n".join(
        [
            "[Desktop Entry]",
            "Type=Application",
            "Version=1.5",
            "Name=Lightarc",
            "GenericName=Material from Photographs",
            "GenericName[de]=Material aus Fotografien",
            "Comment=Turn photographs under a moving light into a relightable material",
            "Comment[de]=Aus Fotografien unter bewegtem Licht ein Material machen, das sich neu beleuchten lässt",
            f"Exec={start} gui %F",
            "Icon=lightarc",
            "Terminal=false",
            "Categories=Graphics;3DGraphics;Science;",
            "Keywords=BRDF;RTI;PTM;material;photograph;reflectance;",
            f"MimeType={kinds};",
            "StartupNotify=true",
            "StartupWMClass=lightarc",
            "",
        ]
    )


def write_icon() -> str:
    """The icon in colours of its own: that of the window takes the colour of the text beside it."""
    drawn = ICON.read_text(encoding="utf-8").replace("currentColor", "#ffb454")
    head, mark, rest = drawn.partition("><path")
    return f'{head}><rect width="24" height="24" rx="5" fill="#20242b" stroke="none"/><path{rest}' if mark else drawn


def write_kinds() -> str:
    """The MIME types, each by its suffix and its first bytes."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<mime-info xmlns="http://www.freedesktop.org/standards/shared-mime-info">',
    ]
    for kind, comment, suffix, magic, parent in FILE_KINDS:
        lines += [f'  <mime-type type="{kind}">', f"    <comment>{comment}</comment>"]
        lines += [f'    <sub-class-of type="{parent}"/>'] if parent else []
        if not parent:  # what is a zip or a database at its beginning is told by its suffix alone
            lines.append(f'    <magic><match value="{magic}" type="string" offset="0"/></magic>')
        lines += [f'    <glob pattern="*.{suffix}"/>', "  </mime-type>"]
    return "\n".join([*lines, "</mime-info>", ""])


def write_thumbnailer(start: str) -> str:
    """Previews in file managers: the material or the scene, drawn on the CPU, which needs no display."""
    draw = f"{start} render %i -o %o --width %s --height %s --renderer cpu --samples 1 --threads 1 --quiet --overwrite"
    kinds = ";".join(kind for kind, *_ in FILE_KINDS)
    return "\n".join(["[Thumbnailer Entry]", f"TryExec={start.split()[0]}", f"Exec={draw}", f"MimeType={kinds};", ""])


def write_man_page(parser: argparse.ArgumentParser) -> str:
    """The man page: verbs, and options of every command; those of a verb are a matter of its help."""
    lines = [
        ".TH LIGHTARC 1",
        ".SH NAME",
        "lightarc \\- photographs of a material under a moving light become a relightable material",
        ".SH SYNOPSIS",
        ".B lightarc",
        "[\\fIFILE\\fR ...]",
        ".br",
        ".B lightarc",
        "\\fIVERB\\fR [\\fIOPTION\\fR ...]",
        ".SH DESCRIPTION",
        "Without a verb the window opens. \\fBlightarc \\fIVERB\\fB \\-h\\fR explains a verb with all its options.",
    ]
    verbs = [each for each in find_words(parser) if not each.path]
    for title, is_option in (("VERBS", False), ("OPTIONS OF EVERY COMMAND", True)):
        lines.append(f".SH {title}")
        for word in verbs:
            if word.names[0].startswith("-") == is_option:
                lines += [".TP", f".B {', '.join(word.names)}".replace("-", "\\-"), word.help.replace("-", "\\-")]
    lines += [".SH EXIT STATUS", str(parser.epilog).removeprefix("exit codes: ")]
    lines += [".SH SEE ALSO", "The manual: F1 in the window."]
    return "\n".join([*lines, ""])
