"""The choices of a project that hold for all captures of a batch, kept as a project of their own beside the results.

So the batch goes on with the same choices whatever becomes of the project that they were taken from, which may be open
in a window meanwhile.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from app.batch.captures import OF_PHOTOGRAPHS, OF_PROJECT
from app.document.document import ImportChoices, Project
from app.document.factoring import Factoring
from app.project.project_file import History, Writer, data_folder, read, state_name

#: The file in the folder of results.
FILE = "template.lap"

#: Parts of a project that are choices although they belong to its capture.
_OF_CAPTURE = ("excluded", *OF_PROJECT)


def choices_of(project: Project) -> Project:
    """The choices of `project`, without a capture and its results, and without what holds for its photographs alone."""
    choices = replace(
        project.import_choices,
        reference=None,
        **{name: getattr(ImportChoices(), name) for name in OF_PHOTOGRAPHS},
    )
    parts = {**project.without_capture, **{name: getattr(project, name) for name in _OF_CAPTURE}}
    return replace(project, **parts, import_choices=choices, factoring=Factoring(), notes="", name="Untitled")


def template_of(output: Path) -> Path | None:
    """The template in the folder of results, None where there is none."""
    return output / FILE if (output / FILE).is_file() else None


def read_template(path: Path | None) -> Project:
    """The choices at `path`, those of a new project where it is None; InputError where it is no project."""
    return Project() if path is None else choices_of(read(path).current)


def keep_template(project: Project, output: Path) -> None:
    """Keep the choices of `project` in the folder of results; OutputError where they cannot be written."""
    choices, own = choices_of(project), output / FILE
    if own.exists() and state_of(own) == state_name(choices, data_folder(own)):
        return
    writer = Writer(own)
    writer.write(History(choices))
    writer.close()


def state_of(path: Path | None) -> str:
    """The hash of the choices at `path`, whenever these were written; '' where there are none."""
    return "" if path is None else state_name(read_template(path), data_folder(path))
