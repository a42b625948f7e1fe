"""Which photographs a capture consists of, and where the light stood in each.

Angles come from what the user says, else from `capture.toml`, an `.lp` file, or numbers in the file names; where none
of these exists, evenly spaced elevations are assumed and marked as such. Nothing is ever written beside photographs.
"""

from __future__ import annotations

import math
import os
import re
import stat
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.capture.capture_file import NAME as CAPTURE_FILE
from engine.capture.capture_file import CaptureFile, read_capture_file
from engine.capture.light_positions import comparable, read_light_positions
from engine.capture.name_angles import angles_with_words, bare_angles, natural
from engine.errors import InputError
from engine.health import Finding, Verdict


def _suffixes(names: str) -> frozenset[str]:
    return frozenset(f".{name}" for name in names.split())


PHOTOGRAPH_SUFFIXES = _suffixes(
    "jpg jpeg jpe png tif tiff exr hdr rgbe pic 3fr arw cr2 cr3 crw dcr dng erf fff gpr iiq kdc mef mos mrw nef nrw "
    "orf pef raf raw rw2 rwl sr2 srf srw x3f"
)
_UNREAD_PICTURES = _suffixes("avif bmp gif heic heif jp2 jxl psd ppm pgm tga webp")
#: Lights whose azimuths lie within this angle count as one arc.
ONE_ARC = math.radians(5.0)
_ARCHIVES = _suffixes("zip 7z rar tar gz tgz")
_SET_ASIDE = re.compile(
    r"(?P<white>(white|flat)[ _-]?(field|frame|ref(erence)?)?)|(?P<dark>(dark|bias)[ _-]?(field|frame)?)|mask", re.I
)


@dataclass(frozen=True, eq=False)
class Sources:
    """The photographs of one capture, by rising elevation.

    Attributes
    ----------
    photographs : (N,) paths, N ≥ 2.
    elevation : (N,) float64, radians above the sample plane, in [0, π/2].
    azimuth : (N,) float64 radians, 0 = right, π/2 = up in the picture; None where unknown.
    angle_source : 'user', 'capture.toml', 'lp', 'file names' or 'assumed'.
    exposure_s : (N,) what `capture.toml` says, None where it is silent.
    transfer : 'srgb' or 'linear' where `capture.toml` says so.
    notes : the capture's notes.
    findings : what was set aside, assumed, or needs a look.
    """

    photographs: tuple[Path, ...]
    elevation: NDArray[np.float64]
    azimuth: NDArray[np.float64] | None
    angle_source: str
    exposure_s: tuple[float | None, ...]
    transfer: str | None = None
    notes: str = ""
    findings: tuple[Finding, ...] = ()


class _Lit(NamedTuple):
    path: Path
    elevation_deg: float
    azimuth_deg: float | None = None
    exposure_s: float | None = None


def find(paths: Sequence[Path], angles_deg: Sequence[float] | None = None) -> Sources:
    """The capture that `paths` (one folder, or files) hold.

    `angles_deg` are the user's elevations in degrees, in the natural order of the file names. Raises InputError where
    there are fewer than two photographs, where angles do not fit them, or where two share one direction of light.
    """
    place = paths[0] if len(paths) == 1 else Path(os.path.commonpath([path.absolute() for path in paths]))
    files, findings = _sorted_out(_expanded(paths))
    photographs = [path for path in files if path.name.lower() != CAPTURE_FILE and path.suffix.lower() != ".lp"]
    if len(photographs) < 2:
        raise InputError(place, f"holds {_count(photographs)}", _needed(findings))
    for path in photographs:
        _refuse_irregular(path)
    _refuse_equal_names(place, photographs)
    capture = _capture_file(place, files)
    lit, angle_source, told = _lit(place, files, photographs, capture, angles_deg)
    _refuse_equal_directions(lit)
    lit.sort(key=lambda one: (one.elevation_deg, one.azimuth_deg or 0.0, natural(one.path.name)))
    azimuths = [one.azimuth_deg for one in lit if one.azimuth_deg is not None]
    azimuth = np.radians(azimuths) if len(azimuths) == len(lit) else None
    return Sources(
        photographs=tuple(one.path for one in lit),
        elevation=np.radians([one.elevation_deg for one in lit]),
        azimuth=azimuth,
        angle_source=angle_source,
        exposure_s=tuple(one.exposure_s for one in lit),
        transfer=capture.transfer if capture else None,
        notes=capture.notes if capture else "",
        findings=(*findings, *told, *_about_azimuth(azimuth)),
    )


def _expanded(paths: Sequence[Path]) -> list[Path]:
    """The files meant by `paths` in natural order; of folders the photographs and what describes them."""
    found: dict[str, Path] = {}
    for path in paths:
        given = [path] if not path.is_dir() else [entry for entry in _entries(path) if _belongs(entry)]
        found.update((os.path.realpath(file), file) for file in given)
    return sorted(found.values(), key=lambda path: (natural(path.name), str(path)))


def _entries(folder: Path) -> list[Path]:
    try:
        return list(folder.iterdir())
    except OSError as error:
        problem = f"cannot be read ({os.strerror(error.errno or 0)})"
        raise InputError(folder, problem, "Check the permissions of the folder") from None


def _belongs(entry: Path) -> bool:
    suffix = entry.suffix.lower()
    known = PHOTOGRAPH_SUFFIXES | _UNREAD_PICTURES | {".lp"}
    return not entry.name.startswith(".") and (suffix in known or entry.name.lower() == CAPTURE_FILE)


def _sorted_out(files: list[Path]) -> tuple[list[Path], list[Finding]]:
    """The files that count, and a finding for each that is set aside."""
    kept: list[Path] = []
    findings: list[Finding] = []
    for file in files:
        aside = _SET_ASIDE.fullmatch(re.sub(r"[ _.-]?\d*$", "", file.stem))
        if file.suffix.lower() in _ARCHIVES:
            raise InputError(file, "is an archive", "Unpack it and give the folder")
        if file.suffix.lower() in _UNREAD_PICTURES:
            text = f"a {file.suffix.lower()} file is not read; convert it to TIFF or PNG"
            findings.append(Finding(Verdict.WARNING, text, file.name))
        elif aside and file.suffix.lower() in PHOTOGRAPH_SUFFIXES:
            kind = "white reference" if aside["white"] else "dark frame" if aside["dark"] else "mask"
            findings.append(Finding(Verdict.NOTE, f"taken for a {kind} by its name and set aside", file.name))
        else:
            kept.append(file)
    return kept, findings


def _count(photographs: list[Path]) -> str:
    return f"one photograph only ({photographs[0].name})" if photographs else "no photographs"


def _needed(findings: list[Finding]) -> str:
    aside = "; ".join(f"{finding.source}: {finding.text}" for finding in findings[:3])
    return "At least two pictures under different lights are needed" + (f". Set aside: {aside}" if aside else "")


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
        raise InputError(place, f"several photographs are called {_listed(twice)}", "Give each a name of its own")


def _lit(
    place: Path,
    files: list[Path],
    photographs: list[Path],
    capture: CaptureFile | None,
    angles_deg: Sequence[float] | None,
) -> tuple[list[_Lit], str, list[Finding]]:
    """Photographs with their lights from the first source that knows, its name, and what to say about it."""
    if angles_deg is not None:
        return _from_user(place, photographs, angles_deg), "user", []
    if capture is not None and capture.photographs:
        return _from_capture_file(_named(files, CAPTURE_FILE)[0], photographs, capture), "capture.toml", []
    light_files = [path for path in files if path.suffix.lower() == ".lp"]
    if len(light_files) > 1:
        names = ", ".join(path.name for path in light_files)
        raise InputError(place, f"holds several light-position files: {names}", "Keep the one that belongs")
    if light_files:
        return _from_light_positions(light_files[0], photographs), "lp", []
    return _from_names(place, photographs) or _assumed(photographs)


def _named(files: list[Path], name: str) -> list[Path]:
    return [path for path in files if path.name.lower() == name]


def _capture_file(place: Path, files: list[Path]) -> CaptureFile | None:
    found = _named(files, CAPTURE_FILE)
    if len(found) > 1:
        raise InputError(place, f"holds {len(found)} files called {CAPTURE_FILE}", "Keep the one that belongs")
    return read_capture_file(found[0]) if found else None


def _from_user(place: Path, photographs: list[Path], angles_deg: Sequence[float]) -> list[_Lit]:
    if len(angles_deg) != len(photographs):
        problem = f"{len(photographs)} photographs, but {len(angles_deg)} angles were given"
        raise InputError(place, problem, "Give one elevation in degrees per photograph, in the order of their names")
    for angle in angles_deg:
        _refuse_impossible(place, angle)
    return [_Lit(path, float(angle)) for path, angle in zip(photographs, angles_deg, strict=True)]


def _refuse_impossible(path: Path, angle_deg: float) -> None:
    if not 0.0 <= angle_deg <= 90.0:
        problem = f"an elevation of {angle_deg:g}° is outside 0° to 90°"
        raise InputError(
            path, problem, "The elevation of the light counts from the sample (0°) to straight above (90°)"
        )


def _from_capture_file(path: Path, photographs: list[Path], capture: CaptureFile) -> list[_Lit]:
    entries = {comparable(entry.file): entry for entry in capture.photographs}
    if len(entries) != len(capture.photographs):
        twice = [name for name, count in Counter(comparable(e.file) for e in capture.photographs).items() if count > 1]
        raise InputError(path, f"lists {_listed(twice)} more than once", "Keep one entry for each")
    _match(path, photographs, {name: name for name in entries})
    chosen = [(photograph, entries[comparable(photograph.name)]) for photograph in photographs]
    return [_Lit(photograph, e.elevation_deg, e.azimuth_deg, e.exposure_s) for photograph, e in chosen]


def _from_light_positions(path: Path, photographs: list[Path]) -> list[_Lit]:
    lights = {comparable(light.name): light for light in read_light_positions(path)}
    _match(path, photographs, {name: f"line {light.line} ({name})" for name, light in lights.items()})
    chosen = [(photograph, lights[comparable(photograph.name)]) for photograph in photographs]
    return [_Lit(p, math.degrees(light.elevation), math.degrees(light.azimuth)) for p, light in chosen]


def _match(path: Path, photographs: list[Path], described: dict[str, str]) -> None:
    """Refuse descriptions without photographs, and photographs without description."""
    names = {comparable(photograph.name) for photograph in photographs}
    missing = [where for name, where in described.items() if name not in names]
    if missing:
        raise InputError(path, f"names photographs that are not there: {_listed(missing)}", "Add them, or correct it")
    strange = sorted(names - described.keys(), key=natural)
    if strange:
        raise InputError(path, f"does not mention {_listed(strange)}", "Add them to it, or take them out of the folder")


def _from_names(place: Path, photographs: list[Path]) -> tuple[list[_Lit], str, list[Finding]] | None:
    stems = [path.stem for path in photographs]
    worded = angles_with_words(stems)
    silent = [path.name for path, angle in zip(photographs, worded, strict=True) if angle is None]
    if 0 < len(silent) < len(photographs):
        problem = f"of {len(photographs)} photographs, {_listed(silent)} has no angle in its name and the others have"
        raise InputError(place, problem, "Rename it, take it out, or give all angles yourself")
    angles = bare_angles(stems) if silent else [angle for angle in worded if angle is not None]
    if angles is None:
        return None
    for path, angle in zip(photographs, angles, strict=True):
        _refuse_impossible(path, angle)
    shown = ", ".join(f"{angle:g}°" for angle in sorted(angles))
    verdict = Verdict.WARNING if silent else Verdict.NOTE
    finding = Finding(verdict, f"Elevations were read from the file names: {shown}. Check that they are right")
    return [_Lit(path, angle) for path, angle in zip(photographs, angles, strict=True)], "file names", [finding]


def _assumed(photographs: list[Path]) -> tuple[list[_Lit], str, list[Finding]]:
    """Steps of 10°, or smaller ones where there are more than nine photographs, up to 90° at most."""
    step = min(10.0, 90.0 / len(photographs))
    text = (
        f"No angles were found: elevations from {step:g}° to {step * len(photographs):g}° in steps of {step:g}° are "
        "assumed, in the order of the file names. Give the real ones"
    )
    lit = [_Lit(path, min(90.0, step * (index + 1))) for index, path in enumerate(photographs)]
    return lit, "assumed", [Finding(Verdict.WARNING, text)]


def azimuth_spread(azimuth: NDArray[np.float64] | None) -> float:
    """The smallest angle in radians that holds all azimuths; 0 where they are unknown."""
    if azimuth is None:
        return 0.0
    rising = np.sort(np.mod(azimuth, 2 * math.pi))
    return 2 * math.pi - float(np.diff(rising, append=rising[0] + 2 * math.pi).max())


def _about_azimuth(azimuth: NDArray[np.float64] | None) -> list[Finding]:
    spread = azimuth_spread(azimuth)
    if spread <= ONE_ARC:
        return []
    text = (
        f"The lights spread over {math.degrees(spread):.0f}° of azimuth, while the method assumes one arc. Only their "
        "elevations are used: relief that is lit from several sides is averaged"
    )
    return [Finding(Verdict.WARNING, text)]


def _refuse_equal_directions(lit: list[_Lit]) -> None:
    groups: dict[tuple[float, float | None], list[str]] = {}
    for one in lit:
        azimuth = None if one.azimuth_deg is None else round(one.azimuth_deg % 360.0, 6)
        groups.setdefault((round(one.elevation_deg, 6), azimuth), []).append(one.path.name)
    for (elevation, _), names in groups.items():
        if len(names) > 1:
            problem = f"{' and '.join(names)} are said to be lit from the same {elevation:g}°"
            raise InputError(lit[0].path.parent, problem, "Keep one of them, or correct the angles")


def _listed(names: Sequence[str], limit: int = 5) -> str:
    more = f" and {len(names) - limit} more" if len(names) > limit else ""
    return ", ".join(names[:limit]) + more
