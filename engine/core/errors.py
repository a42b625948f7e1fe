"""Failures that a user can cause or mend. Everything else is a programming error and raises loudly.

Each carries the three things a user needs: what it is about (a file, a capability), what is wrong, and what would
be right. The command line turns them into exit codes (`app.command_line`), the window into a dialog or a banner.
"""

from __future__ import annotations

import errno
import os

from engine.core.escape import escape_controls

#: First words of what is said of a file that is its subject.
VERBS = (
    *("is", "was", "has", "holds", "lacks", "cannot", "does", "needs", "would", "names", "lists", "states", "says"),
    *("keeps", "stores", "covers", "shows", "uses", "takes", "gives", "looks", "defines", "announces", "changed"),
)


class LightarcError(Exception):
    """Base of the failures that are reported to a user in one sentence, never as a traceback."""


class UsageError(LightarcError, ValueError):
    """A value or choice that is not possible, in words for whoever gave it: an option, a parameter, a text to parse.

    It is a ValueError too, as the callers of a Python function expect; a plain ValueError is a programming error.
    """


class FileError(LightarcError):
    """A file that cannot be used as asked: `path`, `problem` and `remedy` as plain words without a full stop."""

    def __init__(self, path: str | os.PathLike[str], problem: str, remedy: str) -> None:
        self.path = os.fspath(path)
        self.problem = problem.rstrip(".")
        self.remedy = remedy.rstrip(".")
        super().__init__(self.path, self.problem, self.remedy)

    def __str__(self) -> str:
        return escape_controls(f"{self.path}: {self.problem}. {self.remedy}.")


class InputError(FileError):
    """A file given by the user is damaged, of an unsupported kind, or contradicts the others."""


class UnreadableError(InputError):
    """A file that the system does not let be read: it is not there, not permitted, or its disk fails."""


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


class OutOfMemory(LightarcError):
    """Memory, threads or processes have run out: `problem` says of what there was too little, `remedy` what helps."""

    def __init__(self, problem: str) -> None:
        self.problem = problem.rstrip(".")
        self.remedy = (
            "Close other programs, ask for fewer pixels, texels or vertices, or raise the limits of this account "
            "(ulimit -v, ulimit -u, ulimit -n)"
        )
        super().__init__(self.problem)

    def __str__(self) -> str:
        return f"{self.problem}. {self.remedy}."


#: Words of the dynamic linker that finds no memory for a library.
_NO_ROOM_FOR_LIBRARY = ("failed to map segment", "cannot allocate memory", "cannot map zero-fill")

#: cv2.error.code of a failed allocation (StsNoMem).
_NO_MEMORY_OF_OPENCV = -4


def file_failure(error: BaseException) -> InputError | None:
    """`error` as InputError where the system refused something about a file that it names; else None."""
    if not isinstance(error, OSError) or error.errno is None or not isinstance(error.filename, (str, bytes)):
        return None
    problem = f"cannot be used ({os.strerror(error.errno)})"
    return InputError(os.fsdecode(error.filename), problem, "Check that it is there and its permissions")


def shortage(error: BaseException) -> OutOfMemory | None:
    """`error` as OutOfMemory where that is what it means, in whatever words a library puts it; else None."""
    if isinstance(error, OutOfMemory):
        return error
    if isinstance(error, BaseExceptionGroup):  # of work that was tried again and failed in another way
        return next((lack for each in error.exceptions if (lack := shortage(each)) is not None), None)
    if isinstance(error, MemoryError):
        needed_bytes = getattr(error, "_total_size", 0)  # of numpy's
        more = f": {needed_bytes / 2**20:,.1f} MiB more were needed" if needed_bytes else ""
        return OutOfMemory(f"There is not enough memory{more}")
    if isinstance(error, RuntimeError) and "can't start new thread" in str(error):
        return OutOfMemory("No further thread can be started")
    if isinstance(error, OSError) and error.errno == errno.ENOMEM:
        return OutOfMemory("There is not enough memory")
    if isinstance(error, OSError) and error.errno in (errno.EMFILE, errno.ENFILE):
        return OutOfMemory("Too many files are open")
    if isinstance(error, BlockingIOError) and not hasattr(error, "characters_written"):  # of a fork, not of a pipe
        return OutOfMemory("No further process can be started")
    if getattr(error, "code", None) == _NO_MEMORY_OF_OPENCV and type(error).__module__ == "cv2":
        return OutOfMemory("There is not enough memory")
    # SystemError: a function in C went on although it had found no memory
    if isinstance(error, ImportError | OSError | SystemError):
        if any(words in str(error).lower() for words in _NO_ROOM_FOR_LIBRARY):
            return OutOfMemory("There is not enough memory to load all libraries")
        cause = error.__cause__ or error.__context__
        return shortage(cause) if cause is not None else None
    return None
