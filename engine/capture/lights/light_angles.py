"""Position of the light in each photograph: from the first source that knows.

These are, in this order, what the user says, `capture.toml`, a file of lights (`LIGHT_SUFFIXES`), and file names;
where none of them exists, evenly spaced elevations are assumed and marked as such.

Names in an `.lp` file need not be those of the photographs: they are matched without regard to the extension, else by
the number at their end, else in the order of the lines, and what was done is said. Names that fit in part are refused.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, NamedTuple

from engine.capture.lights.file_names import (
    angles_with_words,
    bare_angles,
    comparable,
    join_names,
    natural,
    number_of,
    printable,
    stem_name,
)
from engine.capture.lights.folder import capture_files
from engine.capture.lights.light_file import read_lights
from engine.capture.lights.light_positions import Light, read_dome, read_light_positions
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.photograph.exposures import read_noted_exposure
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict

if TYPE_CHECKING:
    from engine.capture.lights.capture_file import CaptureFile

#: Beginnings of the findings that name the origin of unmeasured angles.
FROM_NAMES, ASSUMED = "Elevations were read from the file names", "No angles were found"
#: Value of `angle_source` for lights that a mirror sphere shows.
SPHERE = "mirror sphere"


#: Files of light positions.
LIGHT_SUFFIXES = frozenset({".lp", ".dome", ".lights"})


class Lit(NamedTuple):
    """A photograph and what is known of its light; azimuth None where unknown."""

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


class Stated(NamedTuple):
    """Photographs with their lights, the name of the source that knew, what to say about it, and where the source gives
    them the lamps' distance in widths of the image, intensities by name, and deviations as a `CalibratedLights` has."""

    lit: list[Lit]
    source: str
    findings: list[Finding]
    lamp_distance: float | None = None
    lamp_gains: Mapping[str, float] = MappingProxyType({})
    lamp_sigma: Mapping[str, float] = MappingProxyType({})


def read_stated_lights(
    place: Path,
    files: list[Path],
    photographs: list[Path],
    capture: CaptureFile | None,
    angles_deg: Sequence[float] | None,
    sphere: Circle | Literal["auto"] | None,
) -> Stated:
    """Photographs with their lights from the first source that knows."""
    if angles_deg is not None:
        return Stated(_from_user(place, photographs, angles_deg), "user", [])
    if capture is not None and capture.photographs:
        lit = _from_capture_file(capture_files(files)[0], photographs, capture, sphere is not None)
        return Stated(lit, "capture.toml" if sphere is None else SPHERE, [])
    if sphere is not None:
        return Stated([Lit(path, 0.0) for path in photographs], SPHERE, [])
    light_files = [path for path in files if path.suffix.lower() in LIGHT_SUFFIXES]
    if len(light_files) > 1:
        names = ", ".join(path.name for path in light_files)
        raise InputError(place, f"holds several light-position files: {names}", "Keep the one that belongs")
    if light_files:
        readers = {".dome": _from_dome, ".lights": _from_calibrated_lights, ".lp": _from_light_positions}
        return readers[light_files[0].suffix.lower()](light_files[0], photographs)
    return _from_names(place, photographs) or _assume(photographs)


def _from_user(place: Path, photographs: list[Path], angles_deg: Sequence[float]) -> list[Lit]:
    if len(angles_deg) != len(photographs):
        problem = f"{len(photographs)} photographs, but {len(angles_deg)} angles were given"
        raise InputError(place, problem, "Give one elevation in degrees per photograph, in the order of their names")
    for angle in angles_deg:
        _refuse_impossible(place, angle)
    return [Lit(path, float(angle)) for path, angle in zip(photographs, angles_deg, strict=True)]


def _refuse_impossible(path: Path, angle_deg: float) -> None:
    if not 0.0 <= angle_deg <= 90.0:
        problem = f"an elevation of {angle_deg:g}° is outside 0° to 90°"
        raise InputError(
            path, problem, "The elevation of the light counts from the sample (0°) to straight above (90°)"
        )


def _from_capture_file(path: Path, photographs: list[Path], capture: CaptureFile, measured: bool) -> list[Lit]:
    """Lights by the file; elevations may be missing if they are to be `measured`."""
    entries = {comparable(entry.file): entry for entry in capture.photographs}
    if len(entries) != len(capture.photographs):
        twice = [name for name, count in Counter(comparable(e.file) for e in capture.photographs).items() if count > 1]
        raise InputError(path, f"lists {join_names(twice)} more than once", "Keep one entry for each")
    silent = [entry.file for entry in capture.photographs if entry.elevation_deg is None]
    if silent and not measured:
        remedy = "Add it, or the table [sphere] of a mirror sphere that shows it"
        raise InputError(path, f"gives no elevation_deg for {join_names(silent)}", remedy)
    _match(path, photographs, {name: name for name in entries})
    chosen = [(photograph, entries[comparable(photograph.name)]) for photograph in photographs]
    return [
        Lit(photograph, e.elevation_deg or 0.0, e.azimuth_deg, e.exposure_s, e.highlight_px) for photograph, e in chosen
    ]


def _from_light_positions(path: Path, photographs: list[Path]) -> Stated:
    found = read_light_positions(path)
    chosen, findings = _find_pairs(path, photographs, found.lights)
    findings = [*(Finding(Verdict.NOTE, note, path.name) for note in found.notes), *findings]
    lit = [
        Lit(p, math.degrees(one.elevation), math.degrees(one.azimuth))
        for p, one in zip(photographs, chosen, strict=True)
    ]
    return Stated(lit, "lp", findings)


def _from_calibrated_lights(path: Path, photographs: list[Path]) -> Stated:
    found = read_lights(path)
    chosen, findings = _find_pairs(path, photographs, found.lights)
    gains = {
        printable(photograph): found.gains[light.line - 1]
        for photograph, light in zip(photographs, chosen, strict=True)
    }
    near = f"{found.lamp_distance:.3g} image widths away" if found.lamp_distance else "distant"
    spread = f", with intensities of {min(gains.values()):.2f} to {max(gains.values()):.2f} of the median"
    text = f"states the {len(chosen)} lamps: {near}{spread if len(set(gains.values())) > 1 else ''}"
    lit = [
        Lit(p, math.degrees(one.elevation), math.degrees(one.azimuth))
        for p, one in zip(photographs, chosen, strict=True)
    ]
    findings = [Finding(Verdict.NOTE, text, path.name), *findings]
    return Stated(lit, "lights", findings, found.lamp_distance, gains, found.sigma)


def _find_pairs(path: Path, photographs: list[Path], lights: Sequence[Light]) -> tuple[list[Light], list[Finding]]:
    """The light of each photograph, and what to say where its name is not that of the photograph."""
    without, numbers = "without their extensions", "by their numbers alone"
    for key, words in ((comparable, ""), (stem_name, without), (number_of, numbers)):
        by_key = {key(light.name): light for light in lights}
        keys = [key(photograph.name) for photograph in photographs]
        if len(by_key) == len(lights) == len(set(keys)) and by_key.keys() == set(keys) and None not in by_key:
            chosen = [by_key[one] for one in keys]
            return chosen, [_about_names(path, photographs, chosen, words)] if words else []
    known = {stem_name(light.name) for light in lights}
    if len(lights) != len(photographs) or any(stem_name(photograph.name) in known for photograph in photographs):
        _match(path, photographs, {comparable(one.name): f"line {one.line} ({one.name})" for one in lights})
    return list(lights), [_about_names(path, photographs, lights, "in the order of its lines")]


def _about_names(path: Path, photographs: list[Path], chosen: Sequence[Light], words: str) -> Finding:
    first, last = (f"{chosen[at].name[:60]} is {photographs[at].name}" for at in (0, -1))
    text = (
        f"names other files than the photographs; they were matched {words}: {first}, {last}. Check that this is right"
    )
    return Finding(Verdict.NOTE if words.startswith("without") else Verdict.WARNING, text, path.name)


def _from_dome(path: Path, photographs: list[Path]) -> Stated:
    dome = read_dome(path)
    if len(dome.directions) != len(photographs):
        problem = f"describes {len(dome.directions)} lamps, but there are {len(photographs)} photographs"
        raise InputError(path, problem, "Add the photographs that are missing, or correct it")
    lit = [
        Lit(photograph, math.degrees(elevation), math.degrees(azimuth))
        for photograph, (elevation, azimuth) in zip(photographs, dome.directions, strict=True)
    ]
    near = f", {dome.lamp_distance:.3g} image widths away" if dome.lamp_distance else ""
    text = f"its lamps{near} were taken in the order of the file names. Check that they were lit in it"
    return Stated(lit, "dome", [Finding(Verdict.NOTE, text, path.name)], dome.lamp_distance)


def _match(path: Path, photographs: list[Path], described: dict[str, str]) -> None:
    """Refuse descriptions without photographs, and photographs without description."""
    names = {comparable(photograph.name) for photograph in photographs}
    missing = [where for name, where in described.items() if name not in names]
    if missing:
        raise InputError(
            path, f"names photographs that are not there: {join_names(missing)}", "Add them, or correct it"
        )
    strange = sorted(names - described.keys(), key=natural)
    if strange:
        raise InputError(
            path, f"does not mention {join_names(strange)}", "Add them to it, or take them out of the folder"
        )


def _from_names(place: Path, photographs: list[Path]) -> Stated | None:
    stems = [path.stem for path in photographs]
    worded = angles_with_words(stems)
    silent = [path.name for path, angle in zip(photographs, worded, strict=True) if angle is None]
    if 0 < len(silent) < len(photographs):
        problem = (
            f"of {len(photographs)} photographs, {join_names(silent)} has no angle in its name and the others have"
        )
        raise InputError(place, problem, "Rename it, take it out, or give all angles yourself")
    angles = bare_angles(stems) if silent else [angle for angle in worded if angle is not None]
    if angles is None:
        return None
    for path, angle in zip(photographs, angles, strict=True):
        _refuse_impossible(path, angle)
    shown = ", ".join(f"{angle:g}°" for angle in sorted(angles))
    verdict = Verdict.WARNING if silent else Verdict.NOTE
    finding = Finding(verdict, f"{FROM_NAMES}: {shown}. Check that they are right")
    lit = [Lit(path, angle) for path, angle in zip(photographs, angles, strict=True)]
    return Stated(lit, "file names", [finding])


def _assume(photographs: list[Path]) -> Stated:
    """Steps of 10°, or smaller ones where there are more than nine photographs, up to 90° at most."""
    step = min(10.0, 90.0 / len(photographs))
    text = (
        f"{ASSUMED}: elevations from {step:g}° to {step * len(photographs):g}° in steps of {step:g}° are "
        "assumed, in the order of the file names. Give the real ones"
    )
    lit = [Lit(path, min(90.0, step * (index + 1))) for index, path in enumerate(photographs)]
    return Stated(lit, "assumed", [Finding(Verdict.WARNING, text)])


def by_light(lit: list[Lit], measured: bool) -> list[list[Lit]]:
    """Photographs of one light together, by rising exposure; lights by rising elevation.

    Where elevations are `measured` only later, photographs of which nothing is said are lights of their own.
    """
    groups: dict[object, list[Lit]] = {}
    for one in lit:
        known = not measured or one.elevation_deg > 0.0
        groups.setdefault(one.direction if known else one.path, []).append(one)
    lights = [light for group in groups.values() for light in _by_exposure(group)]
    lights.sort(key=lambda light: (light[0].elevation_deg, light[0].azimuth_deg or 0.0, natural(light[0].path.name)))
    if len(lights) < 2:
        problem = f"holds {len(lit)} exposures of one light only"
        raise InputError(lit[0].path.parent, problem, "At least two images under different lights are needed")
    return lights


def direction_text(elevation_deg: float, azimuth_deg: float | None) -> str:
    """A direction of light as users say it: 'elevation 30°, azimuth 120°', of an arc its elevation alone."""
    azimuth = "" if azimuth_deg is None else f", azimuth {azimuth_deg % 360.0:.4g}°"
    return f"elevation {elevation_deg:.4g}°{azimuth}"


def about_repeats(lights: list[list[Lit]]) -> list[Finding]:
    """Findings about lights from one direction, which are as many measurements."""
    number = Counter(light[0].direction for light in lights if light[0].azimuth_deg is not None)
    repeated = sum(count for count in number.values() if count > 1)
    if not repeated:
        return []
    text = f"{repeated} photographs share their direction of light with another one; each counts as a measurement"
    if len(number) > 2 and set(number.values()) == {2}:
        text = (
            "Every direction of light occurs twice, and each photograph counts as a measurement. If these are pairs "
            "under parallel and crossed polarisers, put each half into a folder called parallel or crossed, or give "
            "the folder of the crossed half with --pair"
        )
    return [Finding(Verdict.WARNING, text)]


def _by_exposure(group: list[Lit]) -> list[list[Lit]]:
    """Photographs of one direction as lights: exposures of one, or measurements that repeat each other.

    Elevations without azimuths often are of several lamps, so that equal ones are refused.
    """
    if len(group) == 1:
        return [group]
    known = [one._replace(exposure_s=one.exposure_s or read_noted_exposure(one.path).exposure_s) for one in group]
    if len({one.exposure_s for one in known} - {None}) == len(group):
        return [sorted(known, key=lambda one: one.exposure_s or 0.0)]
    if group[0].azimuth_deg is not None:
        return [[one] for one in known]
    names, light = " and ".join(one.path.name for one in group), direction_text(*group[0].direction)
    remedy = (
        "Take one of them out of the folder, correct the light that is stated for it, or state different "
        "exposure_s in capture.toml, by which they are merged"
    )
    raise InputError(group[0].path.parent, f"{names} are said to be lit from the same direction: {light}", remedy)
