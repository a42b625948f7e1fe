"""Examples that the program ships: projects that open ready made, each as a new untitled project.

Each is an archive of a project with its data, NAME.zip, and an image of it, NAME.jpg, in `resources/gallery`;
`packaging/make_gallery.py` makes them. The archives are part of the program, not input of a user.
"""

from __future__ import annotations

import zipfile
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from app.project.places import new_path
from app.project.project_file import data_folder
from app.widgets.resources import RESOURCES
from engine.core.steps import Step, Steps
from engine.storage.atomic import atomic_file, discard, make_folder

FOLDER = RESOURCES / "gallery"

#: Bytes that are unpacked at once.
PIECE_BYTES = 1 << 20

#: The project file in an archive; all else in it belongs into the data folder.
PROJECT = "project.lap"


@dataclass(frozen=True)
class Example:
    """A shipped project: its file name, what the page says of it, and the workspace that shows it first."""

    name: str
    title: str
    about: str
    workspace: str = "view"

    @property
    def image(self) -> Path:
        return FOLDER / f"{self.name}.jpg"

    @property
    def archive(self) -> Path:
        return FOLDER / f"{self.name}.zip"


EXAMPLES = (
    Example("woven", "Woven cloth", "Ten photographs under a light arc"),
    Example("medal", "Bronze medal", "Forty photographs in a light dome"),
    Example("satin", "Measured satin", "A measured BRDF, factored into textures"),
)


def unpack(example: Example, folder: Path) -> Steps[Path]:
    """A new untitled project in `folder` that holds `example`; its path.

    The project file comes last, so that an interruption leaves no project. Raises OutputError where `folder` cannot be
    written.
    """
    yield Step(0.0, f"opening {example.title}")
    path, is_whole = new_path(folder), False
    data = data_folder(path)
    try:
        with zipfile.ZipFile(example.archive) as archive:
            members = sorted((member for member in archive.infolist() if not member.is_dir()), key=_project_last)
            for at, member in enumerate(members):
                yield Step(at / len(members), f"opening {example.title}")
                target = path if member.filename == PROJECT else data / PurePosixPath(member.filename)
                make_folder(target.parent)
                with archive.open(member) as packed, atomic_file(target, member.file_size) as file:
                    while piece := packed.read(PIECE_BYTES):
                        file.write(piece)
        is_whole = True
    finally:
        if not is_whole:
            discard(data)
    return path


def _project_last(member: zipfile.ZipInfo) -> tuple[bool, str]:
    return member.filename == PROJECT, member.filename
