"""Settings kept between two starts: one small JSON file in the user's configuration folder.

A file that cannot be understood is put aside under another name and defaults are used; without a folder that can be
written, the program works and forgets.

The working folder of one run holds imported stacks until the program ends.

It is removed at the end; the folder of a crashed run is removed at the next start.
"""

from __future__ import annotations

import json
import logging
import os
import shutil
import tempfile
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import platformdirs

from engine.core.colour import OPERATORS
from engine.core.errors import FileError, InputError
from engine.storage.atomic import write_json
from engine.storage.untrusted import read_bytes
from engine.storage.writer import is_gone, writer

log = logging.getLogger(__name__)

FILE_LIMIT_BYTES = 2**20

#: No limit is larger: CPUs, and gigabytes of memory.
MAXIMUM = 2**20

#: Files, projects, and names of docks that are remembered.
RECENT, MAX_PROJECTS, MAX_DOCKS = 8, 500, 8

#: Letters of a path that is remembered; SQLite opens no project whose path is longer.
MAX_PATH = 512

#: The ending by which a remembered path is a project.
PROJECT_ENDING = ".lap"

#: Decimal marks: that of the system, a point or a comma.
NUMBERS = ("system", ".", ",")


#: Languages of the window: the one of the system, where there is a translation, or one by its code.
LANGUAGES = ("system", "en", "de")

#: Millimetres of each unit in which lengths can be given.
UNITS_MM = {"mm": 1.0, "cm": 10.0, "in": 25.4}

#: Drawing: by what the system chooses, its second graphics card, or the CPU alone.
GRAPHICS = ("system", "second", "processor")


@dataclass(frozen=True)
class Settings:
    """Remembered choices; `geometry` and `layout` are Qt's own description in hexadecimal.

    `closed_docks` are those of a workspace that the user has closed: Qt's description has them as they were last.
    `dock_sizes` are their widths and heights in turn.
    `workspace` is the one that was in front, for the start after a crash. `output_folder` is where an image, a
    bundle or exports were written last.
    `recent_projects` are all projects that were ever opened, the latest first, and `recent_files` what was opened last
    of everything else.
    `measure_error` says whether the image in the View workspace is compared with a reference in the background.
    `language` is one of `LANGUAGES`.
    `numbers` is the decimal mark, one of `NUMBERS`; `unit` is that of lengths, one of `UNITS_MM`; `graphics` draws, one
    of `GRAPHICS`; `tone_map` is that of new projects. `threads` and `memory_gb` are
    the CPUs that the program uses and the memory that a plan may choose; 0 is no limit. `cache_gb` is the size of
    the working copies in the cache (`app.session.cache`); 0 for what suits the disk. `has_seen_hints` is
    true once the first hints were shown.
    """

    theme: str = "dark"
    geometry: str = ""
    layout: str = ""
    last_folder: str = ""
    output_folder: str = ""
    recent_projects: tuple[str, ...] = ()
    recent_files: tuple[str, ...] = ()
    closed_docks: tuple[str, ...] = ()
    dock_sizes: tuple[int, ...] = ()
    measure_error: bool = True
    workspace: str = ""
    language: str = "system"
    numbers: str = "system"
    unit: str = "mm"
    graphics: str = "system"
    tone_map: str = "neutral"
    threads: int = 0
    memory_gb: float = 0.0
    cache_gb: float = 0.0
    has_seen_hints: bool = False


#: Choices of one of several words, by their names in `Settings`.
_CHOICES = {
    "language": LANGUAGES,
    "numbers": NUMBERS,
    "unit": tuple(UNITS_MM),
    "graphics": GRAPHICS,
    "tone_map": tuple(OPERATORS),
}


def config_folder() -> Path | None:
    """The folder of the settings; None if the system names no usable one (no home, say)."""
    folder = Path(os.path.expandvars(platformdirs.user_config_dir("lightarc", appauthor=False)))
    return folder if folder.is_absolute() else None


def load(folder: Path | None) -> Settings:
    """Settings of `folder`; defaults where there are none, and a corrupt file is set aside."""
    path = folder and folder / "settings.json"
    if path is None or not path.exists():
        return Settings()
    try:
        return _from_json(json.loads(read_bytes(path, FILE_LIMIT_BYTES)))
    except (InputError, ValueError, TypeError, RecursionError) as error:
        aside = path.with_suffix(".corrupt.json")
        log.warning(
            "%s cannot be understood (%s); defaults are used and the old file is kept as %s", path, error, aside
        )
        try:
            path.replace(aside)
        except OSError as reason:
            log.warning("%s cannot be renamed: %s", path, reason)
        return Settings()


def save(settings: Settings, folder: Path | None) -> None:
    """Write `settings`; where that is impossible the log says so and nothing else happens."""
    if folder is None:
        return
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_json(folder / "settings.json", asdict(settings))
    except (FileError, OSError) as error:
        log.warning("settings are not kept: %s", error)


def with_latest(paths: tuple[str, ...], path: str, count: int) -> tuple[str, ...]:
    """`path` first, each once, at most `count` of them."""
    return (path, *(other for other in paths if other != path))[:count]


class Remembered:
    """The settings of one window, `now`; without a folder they are forgotten.

    They are written on a thread of their own, because a disk may take a second for it.
    """

    def __init__(self, folder: Path | None) -> None:
        self.folder = folder
        self.now = load(folder)
        self._disk = ThreadPoolExecutor(1, "settings")
        self._writing: Future[None] | None = None

    def change(self, **values: Any) -> None:
        """Take other values, by their names in `Settings`; they are on disk when the window closes."""
        self.now = replace(self.now, **values)

    def in_front(self, workspace: str) -> None:
        """Remember the workspace in front, on disk soon: a crash asks for it."""
        if workspace != self.now.workspace:
            self.keep(workspace=workspace)

    def opened(self, path: Path, folder: Path) -> None:
        """Remember `path` as what was opened last, from `folder`: a project on disk at once, another file soon.

        With it goes what other windows opened.
        """
        paths = self._paths()
        name, count = ("recent_projects", MAX_PROJECTS) if is_project(path) else ("recent_files", RECENT)
        if len(str(path)) <= MAX_PATH:
            paths[name] = with_latest(paths[name], str(path), count)
        self.keep(**paths, last_folder=str(folder))
        if is_project(path):
            self.wait()

    def forget(self, path: Path, instead: Path | None = None) -> None:
        """Remember `path` no longer, or `instead` of it; on disk soon."""
        paths = self._paths()
        if any(str(path) in each for each in paths.values()):
            new = [] if instead is None else [str(instead)]
            self.keep(
                **{
                    name: tuple(other for each in given for other in (new if each == str(path) else [each]))
                    for name, given in paths.items()
                }
            )

    def keep(self, **values: Any) -> None:
        """Take other values and write them soon, with the paths that other windows opened meanwhile."""
        self.change(**{**self._paths(), **values})
        self._writing = self._disk.submit(save, self.now, self.folder)

    def wait(self) -> None:
        """Wait until everything that is to be kept is on disk."""
        if self._writing is not None:
            self._writing.result()

    def _paths(self) -> dict[str, tuple[str, ...]]:
        """What is remembered on disk, where other windows write as well; `now` is newer until it is there."""
        is_written = self._writing is None or self._writing.done()
        there = load(self.folder) if self.folder is not None and is_written else self.now
        return {"recent_projects": there.recent_projects, "recent_files": there.recent_files}


def is_project(path: Path) -> bool:
    """True for the path of a project, by its ending."""
    return path.suffix.lower() == PROJECT_ENDING


def _from_json(values: object) -> Settings:
    """Known keys of the right type; ValueError for anything that is not an object."""
    if not isinstance(values, dict):
        raise ValueError("not an object")
    names = ("theme", "geometry", "layout", "last_folder", "output_folder", "workspace", *_CHOICES)
    texts = {key: values[key] for key in names if key in values}
    for key, value in texts.items():
        if not isinstance(value, str):
            raise ValueError(f"{key} is not a text")
    for key in ("geometry", "layout"):
        bytes.fromhex(texts.get(key, ""))
    lists = {name: values.get(name, []) for name in ("recent", "recent_projects", "recent_files", "closed_docks")}
    for name, words in lists.items():
        if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
            raise ValueError(f"{name} is not a list of texts")
    known = [path for path in lists["recent"] if len(path) <= MAX_PATH]  # one list of both, until version 0.1
    projects = [*lists["recent_projects"], *(path for path in known if is_project(Path(path)))]
    files = [*lists["recent_files"], *(path for path in known if not is_project(Path(path)))]
    for key, values_of_it in _CHOICES.items():
        if key in texts and texts[key] not in values_of_it:
            raise ValueError(f"{key} is not one that there is")
    flags = {name: values[name] for name in ("measure_error", "has_seen_hints") if name in values}
    if not all(isinstance(flag, bool) for flag in flags.values()):
        raise ValueError("measure_error or has_seen_hints is neither true nor false")
    limits = {name: values[name] for name in ("threads", "memory_gb", "cache_gb") if name in values}
    if not all(type(limit) in (int, float) and 0 <= limit < MAXIMUM for limit in limits.values()):
        raise ValueError("threads, memory_gb or cache_gb is not a number from 0")
    limits = {name: int(limit) if name == "threads" else float(limit) for name, limit in limits.items()}
    sizes = values.get("dock_sizes", [])
    if (
        not isinstance(sizes, list)
        or len(sizes) % 2
        or not all(type(side) is int and 0 < side < MAXIMUM for side in sizes)
    ):
        raise ValueError("dock_sizes is not a list of widths and heights")
    return Settings(
        **texts,
        dock_sizes=tuple(sizes[:MAX_DOCKS]),
        recent_projects=tuple(projects[:MAX_PROJECTS]),
        recent_files=tuple(files[:RECENT]),
        closed_docks=tuple(lists["closed_docks"][:MAX_DOCKS]),
        **flags,
        **limits,
    )


PREFIX = "session-"


def open_session() -> Path:
    """A new folder below the cache folder, or below the one for temporary files where that cannot be written."""
    for base in _bases():
        try:
            base.mkdir(parents=True, exist_ok=True)
            remove_abandoned(base)
            return Path(tempfile.mkdtemp(prefix=f"{PREFIX}{writer()}-", dir=base))
        except OSError as error:
            log.warning("%s cannot hold working data: %s", base, error)
    return Path(tempfile.mkdtemp(prefix=f"{PREFIX}{writer()}-"))


def close_own_sessions() -> None:
    """Remove the working folders of this process, also those that it still uses: it ends."""
    for base in _bases():
        for folder in base.glob(f"{PREFIX}{writer()}-*"):
            close_session(folder)


def close_session(folder: Path) -> None:
    """Remove the working folder with everything in it."""
    shutil.rmtree(folder, ignore_errors=True)


def remove_abandoned(base: Path) -> None:
    """Remove the working folders in `base` whose process is gone."""
    for folder in base.glob(f"{PREFIX}*"):
        if is_gone(folder):
            shutil.rmtree(folder, ignore_errors=True)


def cache_folder() -> Path | None:
    """The folder of what can be made again; None if the system names no usable one."""
    folder = Path(os.path.expandvars(platformdirs.user_cache_dir("lightarc", appauthor=False)))
    return folder if folder.is_absolute() else None


def _bases() -> tuple[Path, Path]:
    return Path(platformdirs.user_cache_dir("lightarc", appauthor=False)), Path(tempfile.gettempdir())
