"""Clean up a project: what can be made again of its photographs goes, bit for bit; what cannot stays, compressed.

The results of a state of the history can be made again if its photographs lie where they lay with the content that they
had (all are hashed), if this version imported them, and if the settings of its material or maps are known. Each removal
and each compression stands alone, so that a clean-up that is interrupted leaves a sound project of a size in between.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import engine
from app.document.document import Project
from app.project.arrays import PACKED, compress, file_of, folder_of, is_cached
from app.project.budget import take_in
from app.project.database import connect, explain
from app.project.made import forget, size_of
from app.project.photographs import check, marks_of, name_files, photographs
from app.project.pixels import FILES, are_packed, are_there, keep_pixels, open_kept, place_of
from app.project.places import hold
from app.project.project_file import Opened, data_folder, read
from app.project.recipes import as_built, list_remakable
from app.project.tidying import forget_unused, is_own, names_in, remove_whole
from app.project.values import DAMAGE, Absent, in_full, parse
from app.session import cache
from engine.capture.stack import read_record
from engine.core.errors import FileError, InputError
from engine.core.steps import Step, Steps, part
from engine.storage.atomic import discard

log = logging.getLogger(__name__)

#: Forms of a material that are made of a stack.
MAPS = ("shading_map", "power_law", "directional")


@dataclass(frozen=True)
class CleanedUp:
    """The bytes of a project before and after, those freed in the cache beside it, and why something stays, in
    sentences without a full stop."""

    before_bytes: int
    after_bytes: int
    cache_bytes: int = 0
    kept: tuple[str, ...] = ()

    @property
    def freed_bytes(self) -> int:
        """All that the disk has more now."""
        return max(0, self.before_bytes - self.after_bytes) + self.cache_bytes


@dataclass(frozen=True, eq=False)
class _State:
    """A state of the history: its document, and the names of the values of its parts."""

    project: Project
    parts: Mapping[str, str]


def clean_up(path: Path) -> Steps[CleanedUp]:
    """Remove from the project at `path` what its photographs can give again, and compress the rest.

    Raises InputError where it is not a project, is damaged, keeps its data behind a link, or is open in another window;
    OutputError where it cannot be written. It is then as it was.
    """
    yield Step(0.0, "reading the project")
    folder, before = data_folder(path), _bytes_of(path)
    if not is_own(folder) or any(each.is_symlink() for each in folder.glob("*")):
        raise InputError(folder, "is or holds a link to elsewhere", "Copy the project, and clean up the copy")
    with hold(path) as is_open_here:
        states = list(_states(path, read(path)))
        files = {file for state in states for file in photographs(state.project)}
        gone, kept = yield from part(_doubtful(path, files), 0.0, 0.5)
        again = _list_remakable(states, folder, gone)
        kept += _other_versions(states, again, gone)
        named, needed = _collect_names(path, states, again)
        freed = yield from part(_without_pixels(folder, states, again), 0.5, 0.7)
        freed += yield from part(_without_arrays(folder, named, needed), 0.7, 0.9)
        if not is_open_here:
            _without_bakes(folder)
            with connect(path) as connection, explain(path):
                forget_unused(connection, folder, stacks=True)
        elif any(folder.glob("bake-*")):
            kept += ["Bakes stay while the project is open"]
    yield Step(1.0, "cleaned up")
    return CleanedUp(before, _bytes_of(path), freed, tuple(kept))


def _bytes_of(path: Path) -> int:
    return size_of(path) + size_of(data_folder(path))


def _states(path: Path, opened: Opened) -> Iterator[_State]:
    """All states in the file."""
    with connect(path) as connection, explain(path):
        rows = connection.execute("SELECT name, parts FROM state").fetchall()
    for name, parts in rows:
        with _check_undamaged(path):
            yield _State(opened.state(str(name)), parse(parts))


@contextmanager
def _check_undamaged(path: Path) -> Iterator[None]:
    """What cannot be read within the block is an InputError: nothing is removed where it is not known what is held."""
    try:
        yield
    except DAMAGE as error:
        raise InputError(path, f"is damaged ({error})", "Recover it first: lightarc project recover") from error


def _doubtful(path: Path, files: Iterable[Path]) -> Steps[tuple[set[Path], list[str]]]:
    """Photographs that are gone, changed or without a mark, and sentences on them."""
    known = marks_of(path)
    about = yield from check(path, sorted(files), thorough=True)
    unmarked = {file for file in files if in_full(file) not in known} - {*about.missing, *about.changed}
    words = ("missing", "not as they were when they were imported", "not marked as they were imported")
    kept = [
        f"{name_files(sorted(some))} {why}. The results made of them stay"
        for some, why in zip((about.missing, about.changed, unmarked), words, strict=True)
        if some
    ]
    return {*about.missing, *about.changed, *unmarked}, kept


def _list_remakable(states: Iterable[_State], folder: Path, gone: set[Path]) -> list[frozenset[str]]:
    """The parts of each state that can be made again; a material also where other states know its stack."""
    found = [(state.project, list_remakable(state.project, (folder,), gone)) for state in states]
    stacks = {id(project.stack) for project, parts in found if "stack" in parts}
    of_others = {id(project) for project, _ in found if (made := as_built(project)) and id(made.stack) in stacks}
    return [parts | {"material"} if id(project) in of_others else parts for project, parts in found]


def _other_versions(states: Iterable[_State], again: Iterable[frozenset[str]], gone: set[Path]) -> list[str]:
    """A sentence where photographs are there but were imported by another version."""
    for state, parts in zip(states, again, strict=True):
        stack = state.project.stack
        if stack is not None and "stack" not in parts and not gone and state.project.sources is not None:
            by = str(stack.provenance.get("software", "another version"))
            if by != f"lightarc {engine.__version__}":
                return [f"The photographs were imported by {by}. Import them again to make their results smaller"]
    return []


def _without_pixels(folder: Path, states: Iterable[_State], again: Iterable[frozenset[str]]) -> Steps[int]:
    """Remove the pixels of stacks that can be made again and compress those of others; the bytes freed in the cache."""
    places = {place: False for place in folder.glob("stack-*") if place.is_dir()}
    for state, parts in zip(states, again, strict=True):
        stack = state.project.stack
        if stack is not None and stack.folder in places:
            places[stack.folder] = places[stack.folder] or "stack" in parts
    freed = 0
    for at, (place, is_made_again) in enumerate(places.items()):
        yield Step(at / len(places), "photographs")
        try:
            record = read_record(place)
        except InputError as error:
            log.info("%s", error)
            continue
        cached = place_of(record, place)
        if is_made_again and cached != place:
            freed += size_of(cached) if cached.is_dir() and cache.remove(cached, even_own=True) else 0
            for name in FILES:
                discard(place / name)
                discard(place / f"{name}{PACKED}")
        elif cached != place:
            stack = open_kept(place)
            if are_packed(place) or (are_there(stack) and (yield from part(keep_pixels(stack), 0.0, 1.0))):
                for name in FILES:
                    discard(place / name)
    return freed


def _without_arrays(folder: Path, named: set[str], kept: set[str]) -> Steps[int]:
    """Remove the arrays that are not `kept` and compress the others; the bytes freed in the cache of those `named`."""
    there = [each for each in folder_of(folder).glob("*") if each.suffix in (".npy", PACKED) and len(each.stem) == 40]
    for at, file in enumerate(there):
        yield Step(at / len(there), "results")
        if file.stem not in kept:
            discard(file)
        elif file.suffix == ".npy":
            try:
                compress(folder, file.stem)
            except (Absent, FileError) as error:
                log.info("%s stays as it is: %s", file.name, error)
    for name in sorted(kept):
        if is_cached(name) and not file_of(folder, name).exists():
            take_in(folder, name)
    copies = [cache.entry(f"array-{name}") for name in sorted(named - kept)]
    sizes = [(place, size_of(place)) for place in copies if place is not None and place.is_dir()]
    return sum(size for place, size in sizes if cache.remove(place))


def _collect_names(path: Path, states: Iterable[_State], again: Iterable[frozenset[str]]) -> tuple[set[str], set[str]]:
    """Names of all arrays of the states, and of those that cannot be made again for a state."""
    arrays: dict[str, set[str]] = {}
    with connect(path) as connection, explain(path), _check_undamaged(path):

        def text_of(name: str) -> Any:
            row = connection.execute("SELECT text FROM value WHERE name = ?", (name,)).fetchone()
            if row is None:
                raise ValueError("a value is gone")
            return parse(row[0])

        def arrays_of(said: object) -> set[str]:
            found = set[str]()
            for kind, name in names_in(said):
                if kind == "value" and name not in arrays:
                    arrays[name] = set()  # a value that names itself ends here
                    arrays[name] = arrays_of(text_of(name))
                found |= {name} if kind == "array" else arrays.get(name, set())
            return found

        named, kept = set[str](), set[str]()
        for state, made in zip(states, again, strict=True):
            for part_name, value in state.parts.items():
                said = text_of(value)
                named |= arrays_of(said)
                if part_name == "material" and "material" in made:
                    kept |= arrays_of(_without_maps(said, text_of))
                elif part_name != "surface" or "surface" not in made:
                    kept |= arrays_of(said)
    return named, kept


def _without_maps(said: object, text_of: Callable[[str], object]) -> Any:
    """The text of a material without that of the maps made of its stack."""
    if isinstance(said, Mapping) and isinstance(said.get("value"), str):
        said = text_of(said["value"])
    if not isinstance(said, Mapping) or not isinstance(said.get("of"), Mapping):
        return said
    return {"is": said.get("is"), "of": {name: each for name, each in said["of"].items() if name not in MAPS}}


def _without_bakes(folder: Path) -> None:
    """Remove bakes, which are baked again where they are wanted."""
    gone = [place for pattern in ("bake-*.transport", ".bake-*.unfinished") for place in folder.glob(pattern)]
    for place in gone:
        remove_whole(place)
    forget(folder, gone)
