"""Failures that a person can cause or mend. Everything else is a programming error and raises loudly.

Each carries the three things a person needs: what it is about (a file, a capability), what is wrong, and what would
be right. The command line turns them into exit codes (`app.cli`), the window into a dialog or a banner.
"""

from __future__ import annotations

import os


class LightarcError(Exception):
    """Base of the failures that are reported to a person in one sentence, never as a traceback."""


class FileError(LightarcError):
    """A file that cannot be used as asked: `path`, `problem` and `remedy` as plain words without a full stop."""

    def __init__(self, path: str | os.PathLike[str], problem: str, remedy: str) -> None:
        self.path = os.fspath(path)
        self.problem = problem.rstrip(".")
        self.remedy = remedy.rstrip(".")
        super().__init__(self.path, self.problem, self.remedy)

    def __str__(self) -> str:
        readable = self.path.encode("utf-8", "replace").decode("utf-8").replace("\n", "\\n")
        return f"{readable}: {self.problem}. {self.remedy}."


class InputError(FileError):
    """A file given by the user is damaged, of an unsupported kind, or contradicts the others."""


class OutputError(FileError):
    """A result cannot be written where the user asked for it; nothing half-written stays behind."""


class MissingCapability(LightarcError):
    """The machine lacks something (OpenGL 3.3, say); `remedy` names what to install or to use instead."""

    def __init__(self, capability: str, remedy: str) -> None:
        self.capability = capability.rstrip(".")
        self.remedy = remedy.rstrip(".")
        super().__init__(self.capability, self.remedy)

    def __str__(self) -> str:
        return f"{self.capability}. {self.remedy}."
