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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.capture.capture_file import NAME as CAPTURE_FILE
from engine.capture.capture_file import CaptureFile, read_capture_file
from engine.capture.exposures import Exposure, noted_exposure
from engine.capture.light_positions import comparable, read_light_positions
from engine.capture.mirror_sphere import Circle
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
#: How the findings begin that tell where unmeasured angles come from.
FROM_NAMES, ASSUMED = "Elevations were read from the file names", "No angles were found"
#: What `angle_source` says of lights that a mirror sphere shows.
SPHERE = "mirror sphere"
#: Points marked in two photographs: x and y in the one, x and y in the other.
Pairs = Sequence[Sequence[float]]

_ARCHIVES = _suffixes("zip 7z rar tar gz tgz")
_SET_ASIDE = re.compile(
    r"(?P<white>(white|flat)[ _-]?(field|frame|ref(erence)?)?)|(?P<dark>(dark|bias)[ _-]?(field|frame)?)|mask", re.I
)


@dataclass(frozen=True, eq=False)
class Sources:
    """The photographs of one capture, by rising elevation.

    Attributes
    ----------
    photographs : (N,) paths, N ≥ 2, one per light: the shortest of its exposures.
    elevation : (N,) float64, radians above the sample plane, in [0, π/2]; 0 while a mirror sphere is to be asked.
    azimuth : (N,) float64 radians, 0 = right, π/2 = up in the picture; None where unknown.
    angle_source : 'user', 'capture.toml', 'lp', 'file names', 'assumed' or 'mirror sphere'.
    exposure_s : (N,) what `capture.toml` says of `photographs`, None where it is silent.
    exposures : (N,) all photographs of each light, by rising exposure.
    dark, flat : photographs without light and of an even white surface.
    lamp_distance : of a near lamp, in widths of the picture; None for a distant one.
    sphere : outline of a mirror sphere from which the lights are to be measured, 'auto' to find it, or None.
    highlights_px : (N,) column and row of the lamp's reflection where `capture.toml` corrects it.
    reference : the photograph that the others are to be aligned to, where `capture.toml` says so.
    control_points : by photograph, points (x and y in the reference, x and y in it) that `capture.toml` gives.
    transfer : 'srgb' or 'linear' where `capture.toml` says so.
    notes : the capture's notes.
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
    sphere: Circle | Literal["auto"] | None = None
    highlights_px: tuple[tuple[float, float] | None, ...] = ()
    reference: Path | None = None
    control_points: Mapping[Path, Pairs] = field(default_factory=dict)
    transfer: str | None = None
    notes: str = ""
    findings: tuple[Finding, ...] = ()


class _Lit(NamedTuple):
    path: Path
    elevation_deg: float
    azimuth_deg: float | None = None
    exposure_s: float | None = None
    highlight_px: tuple[float, float] | None = None

    @property
    def direction(self) -> tuple[float, float | None]:
        """Equal for photographs of one light."""
        azimuth = None if self.azimuth_deg is None else round(self.azimuth_deg % 360.0, 6)
        return round(self.elevation_deg, 6), azimuth


class _Files(NamedTuple):
    """What lies in a folder, sorted by what it is for."""

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
) -> Sources:
    """The capture that `paths` (one folder, or files) hold.

    `angles_deg` are the user's elevations in degrees, in the natural order of the file names; `sphere` is the mirror
    sphere from which they are to be measured instead; files `aside` are no photographs of the sample. Raises
    InputError where there are fewer than two lights, where angles do not fit the photographs, or where two share one
    direction of light and are not known to be exposures of different length.
    """
    place = paths[0] if len(paths) == 1 else Path(os.path.commonpath([path.absolute() for path in paths]))
    expanded = _expanded(paths)
    capture = _capture_file(place, expanded)
    files = _sorted_out(place, _without(expanded, aside), capture)
    photographs = [path for path in files.kept if path.name.lower() != CAPTURE_FILE and path.suffix.lower() != ".lp"]
    if len(photographs) < 2:
        raise InputError(place, f"holds {_count(photographs)}", _needed(files.findings))
    for path in photographs:
        _refuse_irregular(path)
    _refuse_equal_names(place, photographs)
    if angles_deg is None and sphere is None and capture is not None:
        sphere = _outline(capture)
    lit, angle_source, told = _lit(place, files.kept, photographs, capture, angles_deg, sphere)
    lights = _lights(lit, sphere is not None)
    azimuths = [light[0].azimuth_deg for light in lights if light[0].azimuth_deg is not None]
    azimuth = np.radians(azimuths) if len(azimuths) == len(lights) else None
    return Sources(
        photographs=tuple(light[0].path for light in lights),
        elevation=np.radians([light[0].elevation_deg for light in lights]),
        azimuth=azimuth,
        angle_source=angle_source,
        exposure_s=tuple(light[0].exposure_s for light in lights),
        exposures=tuple(tuple(Exposure(one.path, one.exposure_s) for one in light) for light in lights),
        dark=files.dark,
        flat=files.flat,
        lamp_distance=capture.lamp_distance if capture else None,
        sphere=sphere,
        highlights_px=tuple(light[0].highlight_px for light in lights),
        reference=_stated(place, files.kept, capture.reference) if capture and capture.reference else None,
        control_points=_control_points(photographs, capture),
        transfer=capture.transfer if capture else None,
        notes=capture.notes if capture else "",
        findings=(*files.findings, *told, *about_azimuth(azimuth)),
    )


def _without(files: list[Path], aside: Sequence[Path]) -> list[Path]:
    taken = {os.path.realpath(path) for path in aside}
    return [file for file in files if os.path.realpath(file) not in taken]


def _control_points(photographs: Sequence[Path], capture: CaptureFile | None) -> dict[Path, Pairs]:
    entries = capture.photographs if capture is not None else ()
    told = {comparable(entry.file): entry.control_points for entry in entries if entry.control_points}
    return {path: told[comparable(path.name)] for path in photographs if comparable(path.name) in told}


def _outline(capture: CaptureFile) -> Circle | None:
    entry = capture.sphere
    return Circle(entry.column_px, entry.row_px, entry.radius_px) if entry is not None else None


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


def _sorted_out(place: Path, files: list[Path], capture: CaptureFile | None) -> _Files:
    """The files that count, the calibration frames, and a finding for each that is no photograph of the sample."""
    kept: list[Path] = []
    findings: list[Finding] = []
    frames = {kind: _stated(place, files, name) for kind, name in _frame_names(capture).items()}
    for file in files:
        aside = _SET_ASIDE.fullmatch(re.sub(r"[ _.-]?\d*$", "", file.stem))
        if file in frames.values():
            continue
        if file.suffix.lower() in _ARCHIVES:
            raise InputError(file, "is an archive", "Unpack it and give the folder")
        if file.suffix.lower() in _UNREAD_PICTURES:
            text = f"a {file.suffix.lower()} file is not read; convert it to TIFF or PNG"
            findings.append(Finding(Verdict.WARNING, text, file.name))
        elif aside and file.suffix.lower() in PHOTOGRAPH_SUFFIXES:
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


def _stated(place: Path, files: list[Path], name: str) -> Path:
    """The file that `capture.toml` names, which lies beside it."""
    for file in files:
        if comparable(file.name) == comparable(name):
            return file
    where = _named(files, CAPTURE_FILE)
    raise InputError(where[0] if where else place, f"names {name}, which is not there", "Add the file, or correct it")


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
    sphere: Circle | Literal["auto"] | None,
) -> tuple[list[_Lit], str, list[Finding]]:
    """Photographs with their lights from the first source that knows, its name, and what to say about it."""
    if angles_deg is not None:
        return _from_user(place, photographs, angles_deg), "user", []
    if capture is not None and capture.photographs:
        lit = _from_capture_file(_named(files, CAPTURE_FILE)[0], photographs, capture, sphere is not None)
        return lit, "capture.toml" if sphere is None else SPHERE, []
    if sphere is not None:
        return [_Lit(path, 0.0) for path in photographs], SPHERE, []
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


def _from_capture_file(path: Path, photographs: list[Path], capture: CaptureFile, measured: bool) -> list[_Lit]:
    """What the file says; elevations may be missing where they are to be `measured`."""
    entries = {comparable(entry.file): entry for entry in capture.photographs}
    if len(entries) != len(capture.photographs):
        twice = [name for name, count in Counter(comparable(e.file) for e in capture.photographs).items() if count > 1]
        raise InputError(path, f"lists {_listed(twice)} more than once", "Keep one entry for each")
    silent = [entry.file for entry in capture.photographs if entry.elevation_deg is None]
    if silent and not measured:
        remedy = "Add it, or the table [sphere] of a mirror sphere that shows it"
        raise InputError(path, f"gives no elevation_deg for {_listed(silent)}", remedy)
    _match(path, photographs, {name: name for name in entries})
    chosen = [(photograph, entries[comparable(photograph.name)]) for photograph in photographs]
    return [
        _Lit(photograph, e.elevation_deg or 0.0, e.azimuth_deg, e.exposure_s, e.highlight_px)
        for photograph, e in chosen
    ]


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
    finding = Finding(verdict, f"{FROM_NAMES}: {shown}. Check that they are right")
    return [_Lit(path, angle) for path, angle in zip(photographs, angles, strict=True)], "file names", [finding]


def _assumed(photographs: list[Path]) -> tuple[list[_Lit], str, list[Finding]]:
    """Steps of 10°, or smaller ones where there are more than nine photographs, up to 90° at most."""
    step = min(10.0, 90.0 / len(photographs))
    text = (
        f"{ASSUMED}: elevations from {step:g}° to {step * len(photographs):g}° in steps of {step:g}° are "
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


def about_azimuth(azimuth: NDArray[np.float64] | None) -> list[Finding]:
    spread = azimuth_spread(azimuth)
    if spread <= ONE_ARC:
        return []
    text = (
        f"The lights spread over {math.degrees(spread):.0f}° of azimuth, while the method assumes one arc. Only their "
        "elevations are used: relief that is lit from several sides is averaged"
    )
    return [Finding(Verdict.WARNING, text)]


def _lights(lit: list[_Lit], measured: bool) -> list[list[_Lit]]:
    """Photographs of one light together, by rising exposure; lights by rising elevation.

    Where elevations are `measured` only later, photographs of which nothing is said are lights of their own.
    """
    groups: dict[object, list[_Lit]] = {}
    for one in lit:
        told = not measured or one.elevation_deg > 0.0
        groups.setdefault(one.direction if told else one.path, []).append(one)
    lights = [_by_exposure(group) if len(group) > 1 else group for group in groups.values()]
    lights.sort(key=lambda light: (light[0].elevation_deg, light[0].azimuth_deg or 0.0, natural(light[0].path.name)))
    if len(lights) < 2:
        problem = f"holds {len(lit)} exposures of one light only"
        raise InputError(lit[0].path.parent, problem, "At least two pictures under different lights are needed")
    return lights


def _by_exposure(group: list[_Lit]) -> list[_Lit]:
    """Photographs of one light, whose exposures must be known and different."""
    known = [one._replace(exposure_s=one.exposure_s or noted_exposure(one.path).exposure_s) for one in group]
    if len({one.exposure_s for one in known} - {None}) < len(group):
        problem = f"{' and '.join(one.path.name for one in group)} are said to be lit from the same "
        remedy = "Keep one of them, correct the angles, or state different exposure_s in capture.toml"
        raise InputError(group[0].path.parent, f"{problem}{group[0].elevation_deg:g}°", remedy)
    return sorted(known, key=lambda one: one.exposure_s or 0.0)


def printable(path: Path) -> str:
    """The file name as text that can be stored: bytes that are no UTF-8 become replacement characters."""
    return os.fsencode(path.name).decode("utf-8", "replace")


def _listed(names: Sequence[str], limit: int = 5) -> str:
    more = f" and {len(names) - limit} more" if len(names) > limit else ""
    return ", ".join(names[:limit]) + more
