"""Photographs of a capture, the light's position in each (`read_stated_lights`), and the files beside them.

Nothing is ever written beside photographs.

A capture that comes as an archive: its photographs are unpacked into a folder that lives as long as its sources.
"""

from __future__ import annotations

import os
import re
import stat
import string
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.azimuth_spread import about_azimuth
from engine.capture.lights.file_names import comparable, join_names, natural
from engine.capture.lights.folder import (
    CAPTURE_FILE,
    capture_files,
    capture_folder,
    inside,
    is_made_by_program,
    is_sidecar,
    one_of_each_shot,
)
from engine.capture.lights.light_angles import LIGHT_SUFFIXES, Stated, about_repeats, by_light, read_stated_lights
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.lights.polarised_pairs import PolarisedPairs, folders_of_pairs, pair_by_names, pair_of_folders
from engine.capture.photograph.exposures import Exposure
from engine.capture.photograph.kinds import photograph_suffixes, unread_suffixes
from engine.core.errors import InputError, OutputError
from engine.core.health import Finding, Verdict
from engine.core.steps import Step, Steps
from engine.core.summary import Summary
from engine.storage.archive_child import one_line
from engine.storage.atomic import discard, make_folder
from engine.storage.unpack import is_archive, unpack

if TYPE_CHECKING:
    from engine.capture.lights.capture_file import CaptureFile

#: Points marked in two photographs: x and y in the one, x and y in the other.
Pairs = Sequence[Sequence[float]]

_SET_ASIDE = re.compile(
    r"(?P<white>(white|flat)[ _-]?(field|frame|ref(erence)?)?)|(?P<dark>(dark|bias)[ _-]?(field|frame)?)"
    r"|(.{0,200}[ ._-])?mask",
    re.IGNORECASE,
)


@dataclass(frozen=True, eq=False)
class Unpacked:
    """The `archive` that photographs come from, the `members` by the name of the unpacked file, and their folder, which
    vanishes with the last reference to it; None where they lie in a folder that stays."""

    archive: Path
    members: Mapping[str, str]
    folder: TemporaryDirectory[str] | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Sources(Summary):
    """The photographs of one capture, by rising elevation.

    Attributes
    ----------
    photographs : (N,) paths, N ≥ 2, one per light: the shortest of its exposures.
    elevation : (N,) float64, radians above the sample plane, in [0, π/2]; 0 while a mirror sphere is to be asked.
    azimuth : (N,) float64 radians, 0 = right, π/2 = up in the image; None where unknown.
    angle_source : 'user', 'capture.toml', 'lp', 'dome', 'lights', 'file names', 'assumed', 'mirror sphere' or
        'photographs'.
    exposure_s : (N,) what `capture.toml` says of `photographs`, None where it is silent.
    exposures : (N,) all photographs of each light, by rising exposure.
    dark, flat : photographs without light and of an even white surface.
    lamp_distance : of a near lamp, in widths of the image; None for a distant one.
    lamp_gains : intensities over the median by file name, where a file of lights states them.
    lamp_sigma : standard deviations of those ('gains') and of the inverse distance ('distance') that it states; of
        estimated lights those of 'directions' in radians, and 'convexity' where hills and valleys may be exchanged.
    sphere : outline of a mirror sphere from which the lights are to be measured, 'auto' to find it, or None.
    highlights_px : (N,) column and row of the lamp's reflection where `capture.toml` corrects it.
    reference : the photograph that the others are to be aligned to, where `capture.toml` says so.
    control_points : by photograph, points (x and y in the reference, x and y in it) that `capture.toml` gives.
    transfer : 'srgb' or 'linear' where `capture.toml` says so.
    crossed : of pairs under polarisers, the photograph under crossed ones by the one under parallel ones.
    notes : the capture's notes.
    unpacked : what is known of the archive that the photographs come from, if they do.
    findings : what was set aside, assumed, or needs a look.
    """

    photographs: tuple[Path, ...]
    elevation: NDArray[np.float64]
    azimuth: NDArray[np.float64] | None
    angle_source: str
    exposure_s: tuple[float | None, ...]
    exposures: tuple[tuple[Exposure, ...], ...]
    dark: Path | None = None
    flat: Path | None = None
    lamp_distance: float | None = None
    lamp_gains: Mapping[str, float] = field(default_factory=dict)
    lamp_sigma: Mapping[str, float] = field(default_factory=dict)
    sphere: Circle | Literal["auto"] | None = None
    highlights_px: tuple[tuple[float, float] | None, ...] = ()
    reference: Path | None = None
    control_points: Mapping[Path, Pairs] = field(default_factory=dict)
    transfer: Literal["srgb", "linear"] | None = None
    notes: str = ""
    crossed: Mapping[Path, Path] = field(default_factory=dict)
    unpacked: Unpacked | None = None
    findings: tuple[Finding, ...] = ()

    @property
    def name(self) -> str:
        """Name of the folder or archive of the photographs."""
        place = capture_folder(self.photographs[0].parent)
        crossed = self.crossed.get(self.photographs[0])
        if crossed is not None and folders_of_pairs([place.name, crossed.parent.name]) is not None:
            place = place.parent
        return place.name if self.unpacked is None else place.name.split(".", 1)[0]

    def files(self, light: int) -> tuple[Path, ...]:
        """Return the files of light number `light`: its exposures, and the photograph under crossed polarisers."""
        crossed = self.crossed.get(self.photographs[light])
        return (*(one.path for one in self.exposures[light]), *([] if crossed is None else [crossed]))

    def reorder(self, order: NDArray[np.int64]) -> Sources:
        """These with the photographs in another order (N,); their angles stay, for whoever found others."""
        parts = ("photographs", "exposure_s", "exposures", "highlights_px")
        moved: dict[str, Any] = {name: tuple(getattr(self, name)[index] for index in order) for name in parts}
        return replace(self, **moved)

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        return {"name": self.name, "photographs": len(self.photographs), "angles": self.angle_source}


class _Files(NamedTuple):
    """Files of a folder, sorted by purpose."""

    kept: list[Path]
    dark: Path | None
    flat: Path | None
    findings: list[Finding]


def find(
    paths: Sequence[Path],
    angles_deg: Sequence[float] | None = None,
    *,
    sphere: Circle | Literal["auto"] | None = None,
    aside: Sequence[Path] = (),
    pair: Path | Literal["auto", "none"] = "auto",
) -> Sources:
    """The capture that `paths` (one folder, or files) hold.

    `angles_deg` are the user's elevations in degrees, in the natural order of the file names; `sphere` is the mirror
    sphere from which they are to be measured instead; files `aside` are not photographs of the sample. `pair` is the
    folder of the photographs under crossed polarisers where `paths` hold those under parallel ones; 'auto' where names
    tell pairs (`engine.capture.lights.polarised_pairs`), 'none' where each photograph is one of its own. Raises
    InputError where there are fewer than two lights, where angles do not fit the photographs, or where two share one
    direction of light and are not known to be exposures of different length.
    """
    place = paths[0] if len(paths) == 1 else Path(os.path.commonpath([path.absolute() for path in paths]))
    paths, crossed = _set_crossed_apart(paths, pair)
    expanded, looked_into = _look_into(place, _expand(paths))
    capture = _capture_file(place, expanded)
    files = _sort_out(place, _without(expanded, aside), capture)
    photographs = [
        path for path in files.kept if path.name.lower() != CAPTURE_FILE and path.suffix.lower() not in LIGHT_SUFFIXES
    ]
    for path in photographs:
        _refuse_irregular(path)
    photographs, left_out = one_of_each_shot(photographs, _list_named(capture))
    if len(photographs) < 2:
        raise InputError(place, f"holds {_count(photographs)}", _list_needed(files.findings))
    every = photographs
    pairs = _pair(place, photographs, crossed, pair, aside)
    if pairs is not None:
        photographs = list(pairs.parallel)
    _refuse_equal_names(place, photographs)
    if angles_deg is None and sphere is None and capture is not None:
        sphere = _outline(capture)

    def read_lights(chosen: list[Path]) -> Stated:
        return read_stated_lights(place, files.kept, chosen, capture, angles_deg, sphere)

    stated = _read_lights_of_pairs(place, photographs, every, pairs, read_lights)
    lights = by_light(stated.lit, sphere is not None)
    if pairs is not None:
        _refuse_exposures(place, lights)
    azimuths = [light[0].azimuth_deg for light in lights if light[0].azimuth_deg is not None]
    azimuth = np.radians(azimuths) if len(azimuths) == len(lights) else None
    return Sources(
        photographs=tuple(light[0].path for light in lights),
        elevation=np.radians([light[0].elevation_deg for light in lights]),
        azimuth=azimuth,
        angle_source=stated.source,
        exposure_s=tuple(light[0].exposure_s for light in lights),
        exposures=tuple(tuple(Exposure(one.path, one.exposure_s) for one in light) for light in lights),
        dark=files.dark,
        flat=files.flat,
        lamp_distance=capture.lamp_distance if capture and capture.lamp_distance else stated.lamp_distance,
        lamp_gains=stated.lamp_gains,
        lamp_sigma=stated.lamp_sigma,
        sphere=sphere,
        highlights_px=tuple(light[0].highlight_px for light in lights),
        reference=_find_stated(place, files.kept, capture.reference) if capture and capture.reference else None,
        control_points=_control_points(photographs, capture),
        transfer=capture.transfer if capture else None,
        crossed=pairs.crossed if pairs is not None else {},
        notes=capture.notes if capture else "",
        findings=(
            *looked_into,
            *files.findings,
            *left_out,
            *stated.findings,
            *(pairs.findings if pairs is not None else ()),
            *about_repeats(lights),
            *about_azimuth(azimuth),
        ),
    )


def _set_crossed_apart(
    paths: Sequence[Path], pair: Path | Literal["auto", "none"]
) -> tuple[Sequence[Path], Path | None]:
    """The paths without the folder of photographs under crossed polarisers, and that folder."""
    if isinstance(pair, Path):
        return paths, pair
    if pair == "none" or not all(path.is_dir() for path in paths):
        return paths, None
    if len(paths) == 2:
        both = folders_of_pairs([path.name for path in paths])
        if both is not None:
            parallel, crossed = (next(path for path in paths if path.name == name) for name in both)
            return [parallel], crossed
    if len(paths) == 1 and not any(_is_photograph(entry) for entry in list_entries(paths[0])):
        folders = [entry for entry in list_entries(paths[0]) if entry.is_dir() and not is_made_by_program(entry.name)]
        filled = [folder.name for folder in folders if any(_is_photograph(entry) for entry in list_entries(folder))]
        both = folders_of_pairs(filled)
        if both is not None:
            return [paths[0], paths[0] / both[0]], paths[0] / both[1]
    return paths, None


def _pair(
    place: Path,
    photographs: list[Path],
    crossed: Path | None,
    pair: Path | Literal["auto", "none"],
    aside: Sequence[Path],
) -> PolarisedPairs | None:
    """Pairs of `photographs` with those in the folder `crossed`, or of which names tell; None where there are none."""
    if crossed is None:
        return pair_by_names(photographs) if pair == "auto" else None
    if not crossed.is_dir():
        raise InputError(crossed, "is not a folder", "Give the folder of the photographs under crossed polarisers")
    inside = _sort_out(crossed, _without(_expand([crossed]), aside), None).kept
    others, _ = one_of_each_shot([path for path in inside if path.suffix.lower() in photograph_suffixes()], set())
    for path in others:
        _refuse_irregular(path)
    return pair_of_folders(photographs, others, place)


def _read_lights_of_pairs(
    place: Path,
    photographs: list[Path],
    every: list[Path],
    pairs: PolarisedPairs | None,
    read: Callable[[list[Path]], Stated],
) -> Stated:
    """The lights of photographs, of pairs those of the parallel ones, also where a list names all of them."""
    try:
        return read(photographs)
    except InputError as error:
        if pairs is None or len(every) != 2 * len(photographs):
            raise
        try:
            stated = read(every)
        except InputError:
            raise error from None
    lit = {one.path: one for one in stated.lit}
    for path, crossed in pairs.crossed.items():
        if lit[path].direction != lit[crossed].direction:
            problem = f"lists other lights for {path.name} and {crossed.name}, which are a pair under polarisers"
            raise InputError(place, problem, "Correct the list, or import each photograph by itself with --pair none")
    return stated._replace(lit=[lit[path] for path in photographs])


def photographs_in(folder: Path) -> list[Path]:
    """The photographs of a folder in the order of their names, one of each shot."""
    found = [path for path in _expand([folder]) if path.suffix.lower() in photograph_suffixes()]
    for path in found:
        _refuse_irregular(path)
    return one_of_each_shot(found, set())[0]


def _refuse_exposures(place: Path, lights: Sequence[Sequence[Any]]) -> None:
    several = next((light for light in lights if len(light) > 1), None)
    if several is not None:
        names = join_names([one.path.name for one in several])
        problem = f"holds several exposures of one light ({names}) in pairs under polarisers, which are not merged"
        raise InputError(place, problem, "Keep one exposure of each light and polariser")


def _without(files: list[Path], aside: Sequence[Path]) -> list[Path]:
    taken = {os.path.realpath(path) for path in aside}
    return [file for file in files if os.path.realpath(file) not in taken]


def _control_points(photographs: Sequence[Path], capture: CaptureFile | None) -> dict[Path, Pairs]:
    entries = capture.photographs if capture is not None else ()
    stated = {comparable(entry.file): entry.control_points for entry in entries if entry.control_points}
    return {path: stated[comparable(path.name)] for path in photographs if comparable(path.name) in stated}


def _outline(capture: CaptureFile) -> Circle | None:
    entry = capture.sphere
    return Circle(entry.column_px, entry.row_px, entry.radius_px) if entry is not None else None


def _expand(paths: Sequence[Path]) -> list[Path]:
    """The files meant by `paths` in natural order; of folders the photographs and what describes them."""
    found: dict[str, Path] = {}
    for path in paths:
        given = (
            [path] * (not is_sidecar(path))
            if not path.is_dir()
            else [entry for entry in list_entries(path) if belongs(entry)]
        )
        found.update((os.path.realpath(file), file) for file in given)
    return sorted(found.values(), key=lambda path: (natural(path.name), str(path)))


def _look_into(place: Path, expanded: list[Path]) -> tuple[list[Path], list[Finding]]:
    """The files `expanded`, or those of the one folder in `place` that holds the capture where `place` has none."""
    if not place.is_dir() or any(path.suffix.lower() in photograph_suffixes() for path in expanded):
        return expanded, []
    folders = [entry for entry in list_entries(place) if entry.is_dir() and not is_made_by_program(entry.name)]
    counts = [(folder.name, sum(_is_photograph(entry) for entry in list_entries(folder))) for folder in folders]
    name, lights = inside(counts)
    if name is None:
        filled = sorted(folder for folder, count in counts if count)
        deeper = [folder for folder in folders if not filled and any(entry.is_dir() for entry in list_entries(folder))]
        if len(deeper) == 1:  # as DCIM/100CANON
            return _look_into(deeper[0], [*expanded, *_expand(deeper)])
        if filled:
            problem = f"holds no photographs itself, but its folders {join_names(filled)} do"
            raise InputError(place, problem, "Give the folder of one capture")
        if (place / "stack.json").is_file():
            raise InputError(place, "is a stack already", "Make a material of it with lightarc shade or normals")
        return expanded, []
    beside = (
        [entry for entry in list_entries(place / lights) if entry.suffix.lower() in LIGHT_SUFFIXES] if lights else []
    )
    if any(path.suffix.lower() in LIGHT_SUFFIXES for path in expanded):
        beside = []
    text = f"Photographs were taken from {name}" + (f", light positions from {beside[0].name}" if beside else "")
    return _expand([*expanded, place / name, *beside]), [Finding(Verdict.NOTE, text)]


def _is_photograph(entry: Path) -> bool:
    return not is_sidecar(entry) and entry.suffix.lower() in photograph_suffixes()


def _list_named(capture: CaptureFile | None) -> set[str]:
    """Files that a user wrote down, as names are compared."""
    return {comparable(entry.file) for entry in capture.photographs} if capture is not None else set()


def list_entries(folder: Path) -> list[Path]:
    """All that lies in a folder, in no order; InputError where it cannot be read."""
    try:
        return list(folder.iterdir())
    except OSError as error:
        problem = f"cannot be read ({os.strerror(error.errno or 0)})"
        raise InputError(folder, problem, "Check the permissions of the folder") from None


def belongs(entry: Path) -> bool:
    """True if a file of this name is taken for a photograph or describes some."""
    suffix = entry.suffix.lower()
    known = photograph_suffixes() | unread_suffixes() | LIGHT_SUFFIXES
    return not entry.name.startswith(".") and (suffix in known or entry.name.lower() == CAPTURE_FILE)


def is_set_aside(file: Path) -> bool:
    """True for a photograph that by its name is a white reference, a dark frame or a mask."""
    return _aside(file) is not None


def _aside(file: Path) -> re.Match[str] | None:
    stem = file.stem.rstrip(string.digits)
    return _SET_ASIDE.fullmatch(stem[:-1] if stem.endswith(tuple(" _.-")) else stem)


def _sort_out(place: Path, files: list[Path], capture: CaptureFile | None) -> _Files:
    """The files that count, the calibration frames, and a finding for each that is not a photograph of the sample."""
    kept: list[Path] = []
    findings: list[Finding] = []
    frames = {kind: _find_stated(place, files, name) for kind, name in _frame_names(capture).items()}
    for file in files:
        aside = _aside(file)
        if file in frames.values():
            continue
        if file.suffix.lower() in unread_suffixes():
            text = f"a {file.suffix.lower()} file is not read; convert it to TIFF or PNG"
            findings.append(Finding(Verdict.WARNING, text, file.name))
        elif aside and file.suffix.lower() in photograph_suffixes():
            kind = "white reference" if aside["white"] else "dark frame" if aside["dark"] else "mask"
            used = kind != "mask" and frames.setdefault(kind, file) is file
            text = f"taken for a {kind} by its name and {'used as such' if used else 'set aside'}"
            findings.append(Finding(Verdict.NOTE, text, file.name))
        else:
            kept.append(file)
    return _Files(kept, frames.get("dark frame"), frames.get("white reference"), findings)


def _frame_names(capture: CaptureFile | None) -> dict[str, str]:
    stated = {"dark frame": capture.dark, "white reference": capture.flat} if capture is not None else {}
    return {kind: name for kind, name in stated.items() if name is not None}


def _find_stated(place: Path, files: list[Path], name: str) -> Path:
    """The file that `capture.toml` names, which lies beside it."""
    for file in files:
        if comparable(file.name) == comparable(name):
            return file
    where = capture_files(files)
    raise InputError(where[0] if where else place, f"names {name}, which is not there", "Add the file, or correct it")


def _count(photographs: list[Path]) -> str:
    return f"one photograph only ({photographs[0].name})" if photographs else "no photographs"


def _list_needed(findings: list[Finding]) -> str:
    aside = "; ".join(f"{finding.source}: {finding.text}" for finding in findings[:3])
    return "At least two images under different lights are needed" + (f". Set aside: {aside}" if aside else "")


def _refuse_irregular(path: Path) -> None:
    try:
        regular = stat.S_ISREG(path.stat().st_mode)
    except (OSError, ValueError) as error:
        reason = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
        raise InputError(path, f"cannot be read ({reason})", "Check that it exists, or leave it out") from None
    if not regular:
        raise InputError(path, "is not a regular file", "Leave it out")


def _refuse_equal_names(place: Path, photographs: list[Path]) -> None:
    twice = [name for name, count in Counter(path.name for path in photographs).items() if count > 1]
    if twice:
        raise InputError(place, f"several photographs are called {join_names(twice)}", "Give each a name of its own")


def _capture_file(place: Path, files: list[Path]) -> CaptureFile | None:
    found = capture_files(files)
    if len(found) > 1:
        raise InputError(place, f"holds {len(found)} files called {CAPTURE_FILE}", "Keep the one that belongs")
    if not found:
        return None
    from engine.capture.lights.capture_file import read_capture_file

    return read_capture_file(found[0])


_NESTED = (".zip", ".7z", ".rar", ".tar", ".tgz", ".tbz2", ".txz", ".tar.gz", ".tar.bz2", ".tar.xz", ".gz", ".xz")
_BUNDLE = PurePosixPath("manifest.json")

#: The decoder process that reads an archive: that of the photographs in it.
_PROCESS = "engine.capture.photograph.decode"


def find_packed(
    paths: Sequence[Path],
    angles_deg: Sequence[float] | None = None,
    *,
    sphere: Circle | Literal["auto"] | None = None,
    aside: Sequence[Path] = (),
    pair: Path | Literal["auto", "none"] = "auto",
    scratch: Path | None = None,
    keep: Path | None = None,
) -> Steps[Sources]:
    """As `sources.find`, where `paths` may also be one archive (zip, or tar with or without compression).

    It is unpacked into a folder in `scratch` (else in the system's folder for temporary files), which vanishes when
    nothing refers to the sources any more, or into the new folder `keep`, which stays. Of its folders the uppermost
    with photographs counts.
    """
    yield Step(0.0, "Looking for photographs")
    archives = [path for path in paths if is_archive(path)]
    if not archives:
        return find(paths, angles_deg, sphere=sphere, aside=aside, pair=pair)
    (archive, *others) = archives
    if others or len(paths) > 1:
        raise InputError(archive, "is an archive among other files", "Give one archive alone, or files and folders")
    folder = None if keep is not None else _scratch_folder(scratch)
    top = keep or Path(folder.name if folder is not None else "")
    is_whole = False
    try:
        place, left_out = make_folder(top / archive.name), list[str]()
        members = yield from unpack(archive, place, lambda names: _choose(archive, names, left_out), _PROCESS)
        with name_members(Unpacked(archive, members)):
            sources = find([place], angles_deg, sphere=sphere, aside=aside, pair=pair)
        is_whole = True
    finally:
        if keep is not None and not is_whole:
            discard(keep)
    text = f"Photographs in other folders of {archive.name} were excluded: {join_names(left_out)}"
    findings = (Finding(Verdict.NOTE, text),) if left_out else ()
    unpacked = Unpacked(archive, members, folder)
    return replace(sources, unpacked=unpacked, findings=(*sources.findings, *findings))


@contextmanager
def name_members(unpacked: Unpacked | None) -> Iterator[None]:
    """Errors about unpacked photographs name the archive and the member in place of a temporary file."""
    try:
        yield
    except InputError as error:
        path = Path(error.path)
        if unpacked is not None and path.parent.name == unpacked.archive.name and path.name in unpacked.members:
            error.path = os.path.join(unpacked.archive, *unpacked.members[path.name].split("/"))  # noqa: PTH118 - a name
        elif unpacked is not None and path.name == unpacked.archive.name:
            error.path = os.fspath(unpacked.archive)
        raise


def unpack_again(unpacked: Unpacked, place: Path) -> Steps[None]:
    """Unpack the photographs of an archive into the folder `place`, where they were before."""
    yield from unpack(
        unpacked.archive, make_folder(place), lambda names: _choose(unpacked.archive, names, []), _PROCESS
    )


def _scratch_folder(scratch: Path | None) -> tempfile.TemporaryDirectory[str]:
    try:
        return tempfile.TemporaryDirectory(prefix="lightarc-", dir=scratch, ignore_cleanup_errors=True)
    except OSError as error:
        place = scratch or Path(tempfile.gettempdir())
        raise OutputError(place, f"cannot be written ({one_line(error)})", "Check its permissions") from None


def _choose(archive: Path, names: Sequence[str], left_out: list[str]) -> list[str]:
    """The photographs in the uppermost folder that has any, and what describes them; other folders are `left_out`."""
    visible = [PurePosixPath(name) for name in names if not _is_hidden(PurePosixPath(name))]
    if _BUNDLE in visible:
        raise InputError(archive, "is a bundle, or holds one: no photographs", "Open it in the window")
    nested = [path.name for path in visible if path.name.lower().endswith(_NESTED)]
    if nested:
        raise InputError(archive, f"holds another archive ({nested[0]})", "Unpack it and give the folder")
    folders = {path.parent for path in visible if path.suffix.lower() in photograph_suffixes()}
    if not folders:
        raise InputError(archive, "holds no photographs", "Pack the photographs of one capture")
    top = min(len(folder.parts) for folder in folders)
    uppermost = [folder for folder in folders if len(folder.parts) == top]
    if len(uppermost) > 1 and len({folder.parent for folder in uppermost}) == 1:
        name, _ = inside([(folder.name, 1) for folder in uppermost])
        uppermost = [uppermost[0].parent / name] if name is not None else uppermost
    if len(uppermost) > 1 and folders_of_pairs([folder.name for folder in uppermost]) is not None:
        several = join_names(sorted(map(str, uppermost)))
        problem = f"holds pairs under polarisers in two folders: {several}"
        remedy = "Unpack it and give the folder, or pack them in one folder under names that end in _par and _cross"
        raise InputError(archive, problem, remedy)
    if len(uppermost) > 1:
        several = join_names(sorted(map(str, uppermost)))
        raise InputError(archive, f"holds photographs in several folders: {several}", "Pack one capture by itself")
    left_out += sorted(str(folder) for folder in folders - set(uppermost))
    taken = [path for path in visible if path.parent == uppermost[0] and belongs(Path(path.name))]
    return [str(path) for path in (*taken, *_lights_beside(visible, uppermost[0], taken))]


def _lights_beside(
    visible: Sequence[PurePosixPath], folder: PurePosixPath, taken: Sequence[PurePosixPath]
) -> list[PurePosixPath]:
    """Light positions in the folder where RTIBuilder puts them, if there are none beside the photographs."""
    place = folder.parent
    _, lights = inside(
        [(one, 1) for one in (folder.name, *{path.parent.name for path in visible if path.parent.parent == place})]
    )
    known = any(path.suffix.lower() in LIGHT_SUFFIXES for path in taken)
    if lights is None or known:
        return []
    return [path for path in visible if path.parent == place / lights and path.suffix.lower() in LIGHT_SUFFIXES]


def _is_hidden(path: PurePosixPath) -> bool:
    """True for files that file managers and packers add."""
    return path.name.startswith(".") or "__MACOSX" in path.parts
