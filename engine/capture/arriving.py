"""Photographs of a capture that is being taken: each is awaited, decoded once, and judged beside those before it.

A photograph is awaited until its file is written completely: its size and time of change stay, or the system has said
that it was closed, and it can be decoded. Files that are renamed, written again or removed while that goes on are
followed. A file that stays as it is for `GIVE_UP_S` and cannot be decoded is said to be unreadable, and looked at again
when it changes.

What is said of photographs is what the report of an import says (`engine.capture.report`, `engine.capture.empty`), of
those that are there; it changes while others arrive. Motion is that against the first photograph, as two photographs
are aligned, and is not known where their light is too unlike. What was decoded is kept for the import
(`engine.capture.decoded`), and lights of which all is known are written for it (`engine.capture.ahead`).

Cost: a photograph of 24 megapixels 0.4 s besides its decoder, half of it for the motion.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.capture.ahead import WrittenAhead
from engine.capture.arriving_positions import MOVES_PX, Positions
from engine.capture.decoded import Decoded, Kept, Mark, mark_of
from engine.capture.doubts import FEWEST
from engine.capture.empty import empty
from engine.capture.import_plan import ImportSettings
from engine.capture.lights.capture_file import read_capture_file
from engine.capture.lights.file_names import printable
from engine.capture.lights.folder import CAPTURE_FILE, one_of_each_shot
from engine.capture.lights.light_angles import LIGHT_SUFFIXES
from engine.capture.lights.listed import Direction, Listed, coverage, from_names, read_listed
from engine.capture.lights.mirror_sphere import Circle, find_highlights, find_sphere, light_direction
from engine.capture.lights.sources import belongs, is_set_aside, list_entries
from engine.capture.photograph.decode import Reading, count_at_once
from engine.capture.photograph.grey_patch import GreyPatch
from engine.capture.photograph.kinds import photograph_suffixes
from engine.capture.registration.texture import reduction
from engine.capture.report import Quality, judge_each
from engine.core.budget import free_bytes
from engine.core.colour import to_display8
from engine.core.directions import surface_direction
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Verdict
from engine.core.steps import Step, Steps

#: Seconds between two looks at the folder, that a file stays as it is before it counts as complete, the same where the
#: system has said that it was closed, and until one that cannot be decoded is given up.
LOOK_S, STEADY_S, CLOSED_S, GIVE_UP_S = 0.2, 1.0, 0.1, 10.0

#: Pixels of the images that are compared beyond those that other light on relief imitates
#: (`engine.capture.registration.align`).
MOVED_PX = 8.0

#: Numbers of photographs at which a mirror sphere is looked for.
_SPHERE_AT = (4, 8, 16, 32)

#: The elevation of a lamp of which nothing is known, in degrees.
_ANY_ELEVATION_DEG = 45.0

#: A function that waits for so many seconds at most, and gives the files that the system says were closed.
Wait = Callable[[float], Collection[Path]]


@dataclass(frozen=True, eq=False)
class Watching:
    """The wishes of a user for a capture that is being taken.

    Attributes
    ----------
    folder : where photographs appear. aside : files in it that are not photographs of the sample.
    expect : number of photographs at which it ends; None for that of a list of lights, or without end.
    idle_s : seconds without a new photograph after which it ends, counted from the first one; None without end.
    angles_deg : elevations in degrees, in the order of the names. sphere : a mirror sphere in the photographs.
    """

    folder: Path
    expect: int | None = None
    idle_s: float | None = None
    angles_deg: tuple[float, ...] | None = None
    sphere: Circle | Literal["auto"] | None = None
    aside: tuple[Path, ...] = ()


@dataclass(frozen=True, eq=False)
class Arrived:
    """A photograph that is there: uint8 sRGB `thumbnail` (h, w, 3), None where it cannot be read, its light, and the
    findings on it. It `counts` unless it is the same image as another."""

    path: Path
    thumbnail: NDArray[np.uint8] | None
    direction: Direction | None
    findings: tuple[Finding, ...]
    counts: bool = True

    @property
    def verdict(self) -> Verdict:
        """The most severe of what is to be said."""
        return max((each.verdict for each in self.findings), default=Verdict.GOOD)


@dataclass(frozen=True, eq=False)
class Capture:
    """A capture as far as it has been taken.

    Attributes
    ----------
    photographs : those that are there, in the order in which they came; `new` are the names of those that just did.
    awaited : names of files that are being written or decoded. expect : the number at which it ends, None without.
    listed : lights that a list states, those of photographs that are missing as well.
    findings : what is to be said of the whole, as a list that cannot be read.
    """

    photographs: tuple[Arrived, ...] = ()
    awaited: tuple[str, ...] = ()
    expect: int | None = None
    listed: tuple[Direction, ...] = ()
    findings: tuple[Finding, ...] = ()
    new: frozenset[str] = frozenset()

    @property
    def directions(self) -> list[Direction]:
        """The lights of the photographs that can be used, as far as they are known."""
        usable = [one for one in self.photographs if one.verdict < Verdict.BAD]
        return [one.direction for one in usable if one.direction is not None]

    @property
    def coverage(self) -> float | None:
        """The share of the hemisphere that is covered by lights, None where their azimuths are not known."""
        return coverage(self.directions)

    @property
    def count(self) -> int:
        """The number of photographs that could be read, each once."""
        return sum(one.thumbnail is not None and one.counts for one in self.photographs)


@dataclass(eq=False)
class _File:
    """A file that is being followed: its mark, since when it stays, and what is known of it."""

    mark: Mark
    since_s: float
    is_closed: bool = False
    reading: Reading | None = None
    kept: Kept | None = None
    shown: NDArray[np.uint8] | None = None
    error: InputError | None = None
    spot: Direction | UsageError | None = None
    said: bool = False

    @property
    def is_over(self) -> bool:
        """True where nothing is to be expected of the file unless it changes."""
        return self.kept is not None or self.said


def decoding_options(folder: Path, settings: ImportSettings) -> dict[str, Any]:
    """The options with which an import by `settings` decodes the photographs of a folder, as far as that is known."""
    transfer: str | None = settings.transfer
    stated = [entry for entry in list_entries(folder) if entry.name.lower() == CAPTURE_FILE]
    if transfer == "auto" and stated:
        with suppress(InputError):  # which the import reports
            transfer = read_capture_file(stated[0]).transfer
    balance = "none" if isinstance(settings.white_balance, GreyPatch) else settings.white_balance
    return {"white_balance": balance, "transfer": transfer or "auto", "bands": settings.bands}


def arrive(
    decoded: Decoded,
    watching: Watching,
    is_ended: Callable[[], bool] = lambda: False,
    wait: Wait | None = None,
    ahead: WrittenAhead | None = None,
) -> Steps[Capture]:
    """Follow a folder until as many photographs are there as are expected, none came for a time, or it `is_ended`.

    Lights are written `ahead` between two looks, as far as they can be. Steps carry a `Capture` when something has
    changed. At the end files that are being written are waited for, for `GIVE_UP_S` at most. Raises InputError for a
    folder that cannot be read.
    """
    follow = _Follow(decoded, watching)
    try:
        last_s, ended_s = time.monotonic(), math.inf
        closed: Collection[Path] = ()
        while True:
            changed = follow.look(closed)
            changed |= follow.decode()
            if changed:
                follow.judge()
            capture = follow.capture
            now = time.monotonic()
            if changed or follow.is_busy:
                last_s = now
            share = capture.count / capture.expect if capture.expect else 0.0
            yield Step(min(share, 1.0), _note(capture), capture if changed else None)
            is_idle = watching.idle_s is not None and capture.photographs and now - last_s >= watching.idle_s
            if is_ended() or is_idle or (capture.expect is not None and capture.count >= capture.expect):
                ended_s = min(ended_s, now)
            if now - ended_s >= (GIVE_UP_S if follow.is_busy else 0.0):
                return capture
            if ahead is not None and math.isinf(ended_s):
                follow.write_next(ahead)
            closed = follow.pause(wait or _sleep)
    finally:
        follow.close()


def _sleep(seconds: float) -> Collection[Path]:
    time.sleep(seconds)
    return ()


def _note(capture: Capture) -> str:
    many = f"{capture.count} of {capture.expect}" if capture.expect else f"{capture.count}"
    return f"{many} photographs" + (f", waiting for {capture.awaited[0]}" if capture.awaited else "")


@dataclass(eq=False)
class _Follow:
    """The files of a folder, followed."""

    decoded: Decoded
    watching: Watching
    files: dict[Path, _File] = field(default_factory=dict)
    order: list[Path] = field(default_factory=list)
    capture: Capture = field(default_factory=Capture)
    _lists: dict[Path, Mark | None] = field(default_factory=dict)
    _listed: Listed | None = None
    _about_list: tuple[Finding, ...] = ()
    _sphere: Circle | None = None
    _shots: set[Path] = field(default_factory=set)
    _new: set[Path] = field(default_factory=set)
    _positions: Positions = field(default_factory=Positions)
    _judged: tuple[list[Path], dict[Path, Direction], Circle | None] | None = None
    _said: dict[Path, tuple[tuple[Finding, ...], bool]] = field(default_factory=dict)

    @property
    def is_busy(self) -> bool:
        """True while a file is being written or decoded."""
        return any(not each.is_over for each in self.files.values())

    def look(self, closed: Collection[Path] = ()) -> bool:
        """Take note of the files that are there now; True where that changes what is to be shown."""
        entries = [entry for entry in list_entries(self.watching.folder) if belongs(entry)]
        changed = self._read_lists(entries)
        marks = self._mark_photographs(entries)
        gone = {path: file for path, file in self.files.items() if path not in marks}
        renamed = {(file.mark.device, file.mark.number): path for path, file in gone.items()}
        for path, mark in marks.items():
            before = None if path in self.files else renamed.pop((mark.device, mark.number), None)
            if before is not None:
                self.files[path] = self.files.pop(before)
                self.order = [path if each == before else each for each in self.order]
                del gone[before]
                changed = True
            if path not in self.files:
                self.files[path] = _File(mark, _first_seen_s(mark))
                changed = True
            elif self.files[path].mark != mark:
                self._begin_again(path, mark)
                changed = True
        for path in gone:
            self._forget(path)
            changed = True
        names = {path.resolve() for path in closed}
        for path, file in self.files.items():
            if names and path.resolve() in names and not file.is_closed:
                file.is_closed, file.since_s = True, time.monotonic()
        return changed

    def decode(self) -> bool:
        """Begin to decode what is complete, and take what has been decoded; True where that changes what is shown."""
        changed, running = False, sum(file.reading is not None for file in self.files.values())
        sizes = [file.kept.width * file.kept.height for file in self.files.values() if file.kept is not None]
        at_once = count_at_once(max(sizes), free_bytes()) if sizes else 1
        for path, file in list(self.files.items()):
            stays_s = time.monotonic() - file.since_s
            if file.reading is not None:
                if file.reading.wait(0.0):
                    changed |= self._take(path, file)
            elif file.is_over:
                continue
            elif file.error is None and file.mark.size and stays_s >= (CLOSED_S if file.is_closed else STEADY_S):
                if running < at_once:
                    file.reading = Reading(path, **self.decoded.options, keep_codes=True)
                    running += 1
            elif stays_s >= GIVE_UP_S:
                self._give_up(path, file)
                changed = True
        return changed

    def pause(self, wait: Wait) -> Collection[Path]:
        """Wait until something may have changed, for `LOOK_S` at most; the files that were closed meanwhile."""
        reading = next((file.reading for file in self.files.values() if file.reading is not None), None)
        if reading is not None:
            reading.wait(LOOK_S)
            return wait(0.0)
        now = time.monotonic()
        steady = [CLOSED_S + file.since_s - now for file in self.files.values() if file.is_closed and not file.is_over]
        return wait(min([LOOK_S, *(each for each in steady if each > 0.0)]))

    def close(self) -> None:
        """Stop the decoders."""
        for file in self.files.values():
            if file.reading is not None:
                file.reading.close()

    def _read_lists(self, entries: Sequence[Path]) -> bool:
        """Read the lists of lights anew where they have changed."""
        lists = [path for path in entries if path.suffix.lower() in LIGHT_SUFFIXES or path.name.lower() == CAPTURE_FILE]
        marks = {path: mark_of(path) for path in sorted(lists)}
        if marks == self._lists and (marks or self._listed is not None or self.watching.angles_deg is None):
            return False
        self._lists, self._listed, self._about_list = marks, None, ()
        try:
            self._listed = read_listed(list(marks), self.watching.angles_deg)
        except InputError as error:  # perhaps it is being written
            self._about_list = (Finding(Verdict.WARNING, f"{error.problem}. {error.remedy}", Path(error.path).name),)
        return True

    def _mark_photographs(self, entries: Sequence[Path]) -> dict[Path, Mark]:
        """The marks of the photographs among the files of the folder, one file of each shot."""
        aside = {path.resolve() for path in self.watching.aside}
        found = [
            path
            for path in sorted(entries)
            if path.suffix.lower() in photograph_suffixes()
            and path.name.lower() != CAPTURE_FILE
            and path.suffix.lower() not in LIGHT_SUFFIXES
            and not is_set_aside(path)
            and path.resolve() not in aside
        ]
        if set(found) != self.files.keys():
            self._shots = set(one_of_each_shot(found, set())[0])
        marks = {path: mark_of(path) for path in found if path in self._shots and path.is_file()}
        return {path: mark for path, mark in marks.items() if mark is not None}

    def _begin_again(self, path: Path, mark: Mark) -> None:
        """Follow a file that has changed."""
        self._forget(path)
        self.files[path] = _File(mark, time.monotonic())

    def _forget(self, path: Path) -> None:
        file = self.files.pop(path)
        if file.reading is not None:
            file.reading.close()
        self.decoded.forget(file.mark)
        if path in self.order:
            self.order.remove(path)

    def _take(self, path: Path, file: _File) -> bool:
        """Keep a photograph that has been decoded; True where there is one."""
        assert file.reading is not None
        reading, file.reading = file.reading, None
        try:
            photograph = reading.photograph()
        except InputError as error:
            file.error = error
            return False
        if mark_of(path) != file.mark:
            return False  # it has changed meanwhile, which the next look finds
        file.kept = self.decoded.keep(file.mark, photograph)
        file.shown = to_display8(file.kept.noted.thumbnail)
        self.order.append(path)
        self._new.add(path)
        return True

    def _give_up(self, path: Path, file: _File) -> None:
        if file.error is None:  # it is empty
            file.error = InputError(path, "is empty", "Copy it again")
        file.said = True
        self.order.append(path)
        self._new.add(path)

    def write_next(self, ahead: WrittenAhead) -> None:
        """Write one light to its place in the stack, where a list tells it."""
        if self._listed is not None:
            ahead.write_next([path for path in self.order if self.files[path].kept is not None], self._listed)

    def judge(self) -> None:
        """Say of all photographs what is to be said of them by now."""
        there = [(path, self.files[path]) for path in self.order]
        taken = [(path, file, file.kept) for path, file in there if file.kept is not None]
        paths = [path for path, _, _ in taken]
        directions = self._directions(paths, taken)
        judged = paths, directions, self._sphere
        if self._new or judged != self._judged:  # it takes a tenth of a second, also where a file has just appeared
            lamps = {self.files[path].mark: _towards(direction) for path, direction in directions.items()}
            self._positions.follow({file.mark: kept for _, file, kept in taken}, lamps)
            all_said = _judge_all(taken, directions, self._positions, self._sphere is not None)
            self._judged, self._said = judged, dict(zip(paths, all_said, strict=True))
        shown = [
            Arrived(path, file.shown, directions.get(path), *self._said[path])
            if file.kept is not None
            else Arrived(path, None, None, (_about_error(path, file.error),))
            for path, file in there
        ]
        expect = self.watching.expect
        if expect is None and self._listed is not None:
            expect = self._listed.count
        awaited = tuple(printable(path) for path, file in self.files.items() if not file.is_over)
        listed = self._listed.directions if self._listed is not None else ()
        new, self._new = frozenset(path.name for path in self._new), set()
        self.capture = Capture(tuple(shown), awaited, expect, listed, self._about_list, new)

    def _directions(self, paths: list[Path], taken: Sequence[_Taken]) -> dict[Path, Direction]:
        """The lights of photographs, as far as they are known: those that the sphere shows, else what is stated."""
        outline = self.watching.sphere
        if outline is None and self._listed is not None:
            outline = self._listed.sphere
        if outline is not None:
            self._look_at_sphere(outline, taken)
            spots = {path: file.spot for path, file, _ in taken if isinstance(file.spot, tuple)}
            return {path: spot for path, spot in spots.items() if not isinstance(spot, UsageError)}
        return self._find_stated(paths)

    def _find_stated(self, paths: list[Path]) -> dict[Path, Direction]:
        """The lights of photographs that a list or their names state."""
        stated = self._listed.match(paths) if self._listed is not None else from_names(paths)
        return {path: one for path, one in zip(paths, stated, strict=True) if one is not None}

    def _look_at_sphere(self, sphere: Circle | Literal["auto"], taken: Sequence[_Taken]) -> None:
        """Find the sphere, and the reflection of the lamp on it in each photograph of the usual size."""
        usual = [one for one in taken if (one[2].width, one[2].height) == (taken[0][2].width, taken[0][2].height)]
        greys = [kept.noted.grey for _, _, kept in usual if kept.noted.grey is not None]
        if not greys:
            return
        images, factor = np.stack(greys), reduction(usual[0][2].height, usual[0][2].width)
        if isinstance(sphere, Circle):
            self._sphere = Circle(sphere.column / factor, sphere.row / factor, sphere.radius / factor)
        elif self._sphere is None and len(images) in _SPHERE_AT:
            with suppress(UsageError):
                self._sphere = find_sphere(images)
        if self._sphere is None:
            return
        for (_, file, _), spot in zip(usual, find_highlights(images, self._sphere), strict=True):
            file.spot = spot if isinstance(spot, UsageError) else _direction_of(self._sphere, spot)


#: A photograph that has been decoded.
_Taken = tuple[Path, _File, Kept]


def _first_seen_s(mark: Mark) -> float:
    """The time since which a file counts as steady: of one that has been there for long, long ago."""
    age_s = time.time() - mark.changed_ns / 1e9
    return time.monotonic() - (STEADY_S if age_s > GIVE_UP_S else 0.0)


def _direction_of(sphere: Circle, spot: tuple[float, float]) -> Direction | UsageError:
    try:
        x, y, z = light_direction(sphere, *spot)
    except UsageError as error:
        return error
    return math.degrees(math.asin(min(1.0, float(z)))), math.degrees(math.atan2(y, x)) % 360.0


def _towards(direction: Direction) -> NDArray[np.float64]:
    """The unit vector towards a lamp, those of an arc of which no azimuth is known at the same one."""
    elevation, azimuth = direction
    return surface_direction(math.radians(90.0 - elevation), math.radians(azimuth or 0.0))


def _judge_all(
    taken: Sequence[_Taken], directions: Mapping[Path, Direction], positions: Positions, sees_sphere: bool
) -> Iterator[tuple[tuple[Finding, ...], bool]]:
    """The findings on each photograph beside the others, and whether it is another image than those before it."""
    names = [printable(path) for path, _, _ in taken]
    kept = [one for _, _, one in taken]
    qualities = [Quality(one.clipped, one.black, *one.noted.noise_and_sharpness) for one in kept]
    findings = judge_each(names, np.array([one.mean_radiance for one in kept]), qualities) if kept else []
    usual = Counter((one.width, one.height) for one in kept).most_common(1)
    of_usual = [at for at, one in enumerate(kept) if (one.width, one.height) == usual[0][0]]
    elevations = [directions[path][0] if path in directions else _ANY_ELEVATION_DEG for path, _, _ in taken]
    nothing = {}
    if len(of_usual) >= FEWEST:
        noted = [kept[at].noted for at in of_usual]
        noise = [one.noise_and_sharpness[0] for one in noted]
        images, clipped = [one.thumbnail for one in noted], [one.clipped for one in noted]
        found = empty(images, clipped, noise, np.radians([elevations[at] for at in of_usual]))
        nothing = {of_usual[at]: problem for at, problem in found.items()}
    first: dict[bytes, str] = {}
    for at, ((_, file, one), name) in enumerate(zip(taken, names, strict=True)):
        said = [each for each in findings if each.source == name and each.verdict > Verdict.GOOD]
        if at in nothing:
            said.append(Finding(Verdict.BAD, "{}. {}".format(*nothing[at]), name))
        if at not in of_usual:
            text = "has {} × {} px, and most have {} × {}".format(one.width, one.height, *usual[0][0])
            said.append(Finding(Verdict.BAD, text, name))
        image = one.noted.thumbnail
        twin = first.setdefault(image.tobytes(), name) if image.min() < image.max() else name
        if twin != name:
            said.append(Finding(Verdict.BAD, f"is the same image as {twin}: leave one of them out", name))
        compared_px = positions.measure_px(file.mark) / reduction(one.height, one.width)
        if compared_px >= MOVED_PX:
            said.append(Finding(Verdict.WARNING, "is shifted against the first photograph", name))
        elif compared_px >= MOVES_PX:
            text = "seems shifted against the first photograph, as other light can imitate"
            said.append(Finding(Verdict.NOTE, text, name))
        if sees_sphere and isinstance(file.spot, UsageError):
            said.append(Finding(Verdict.WARNING, f"shows no lamp on the mirror sphere: {file.spot}", name))
        yield tuple(said), twin == name


def _about_error(path: Path, error: InputError | None) -> Finding:
    assert error is not None
    return Finding(Verdict.BAD, f"{error.problem}. {error.remedy}", printable(path))
