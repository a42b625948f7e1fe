"""Position of the light in each photograph: from the first source that knows.

These are, in this order, what the user says, `capture.toml`, an `.lp` file, and numbers in the file names; where none
of them exists, evenly spaced elevations are assumed and marked as such.

`.lp` files: the light positions of BRDF transformation imaging.

The first line holds the number of lights, every other one `name x y z`: x to the right, y up in the image, z towards
the camera. Names may contain spaces and may be paths of the machine that took the photographs, of which the last part
counts. What does not fit is reported with its line number and never guessed. The text is read in the decoder child of
the photographs (`engine.storage.untrusted`), which an import starts in any case.
Cost: 2 ms for 64 lights, once that child runs.

Elevations of the light from file names: woven_10deg.tif, img-elev-35.5.png, suede_10 … suede_90.

A number with a word (elev, elevation, angle, el before it; deg, degrees, ° after it) is an angle. A bare number is
one only where all names agree but for that number, and the numbers are no plain count: 1, 2, 3 … are a sequence.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections import Counter
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple, NoReturn

from engine.capture.lights.capture_file import CaptureFile, capture_files
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.photograph.exposures import noted_exposure
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.storage.text import utf8
from engine.storage.untrusted import decode_in_child, handed, read_bytes

_LIMIT_BYTES = 16 << 20

#: Largest deviation of a direction's length from 1: files with two decimals are welcome.
_UNIT_TOLERANCE = 0.01


@dataclass(frozen=True)
class Light:
    """The light of one photograph, in radians; `line` of the file counts from 1."""

    name: str
    elevation: float
    azimuth: float
    line: int


def read_light_positions(path: Path) -> tuple[Light, ...]:
    """The lights of an `.lp` file in its order; InputError names the line that is wrong."""
    decoder, process = (
        "engine.capture.lights.light_angles:decode_light_positions",
        "engine.capture.photograph.decode",
    )
    reply = decode_in_child(decoder, path, limit_bytes=_LIMIT_BYTES, process=process)
    return tuple(Light(*fields) for fields in reply["lights"])


def decode_light_positions(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: the fields of every `Light`."""
    with handed({name: content}):
        return {"lights": [astuple(light) for light in _lights(Path(name))]}


def _lights(path: Path) -> tuple[Light, ...]:
    text = utf8(read_bytes(path, _LIMIT_BYTES)).decode("utf-8-sig", "surrogateescape")
    lines = [(number, line.strip()) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines or not re.fullmatch(r"\d{1,7}", lines[0][1]):
        _refuse(path, 1, "should hold the number of lights")
    lights = tuple(_light(path, number, line) for number, line in lines[1:])
    if len(lights) != int(lines[0][1]):
        _refuse(path, 1, f"announces {int(lines[0][1])} lights, but {len(lights)} follow")
    _refuse_repeated_names(path, lights)
    return lights


def comparable(name: str) -> str:
    """A file name in the spelling in which names are compared: systems store accents composed or decomposed."""
    return unicodedata.normalize("NFC", re.split(r"[/\\]", name)[-1])


def _light(path: Path, number: int, line: str) -> Light:
    words = line.rsplit(maxsplit=3)
    if len(words) != 4:
        _refuse(path, number, f"should hold a name and three numbers, not {line[:60]!r}")
    if any("," in word for word in words[1:]):
        _refuse(path, number, f"has a decimal comma in {' '.join(words[1:])[:60]!r}; write decimal points")
    try:
        x, y, z = (float(word) for word in words[1:])
    except ValueError:
        _refuse(path, number, f"has no three numbers at its end: {' '.join(words[1:])[:60]!r}")
    length = math.sqrt(x * x + y * y + z * z)
    if not abs(length - 1.0) <= _UNIT_TOLERANCE:
        _refuse(path, number, f"has a direction of length {length:g}; a unit vector is needed")
    if z < 0.0:
        _refuse(path, number, f"has a light behind the sample (z = {z:g})")
    return Light(words[0].strip("\"'"), math.atan2(z, math.hypot(x, y)), math.atan2(y, x), number)


def _refuse_repeated_names(path: Path, lights: tuple[Light, ...]) -> None:
    first: dict[str, int] = {}
    for light in lights:
        earlier = first.setdefault(comparable(light.name), light.line)
        if earlier != light.line:
            _refuse(path, light.line, f"names {light.name[:60]}, as line {earlier} does")


def _refuse(path: Path, line: int, problem: str) -> NoReturn:
    raise InputError(path, f"line {line} {problem}", "Correct the file, or remove it and give the angles yourself")


_NUMBER = r"\d{1,20}+(?:[.,]\d{1,20}+)?"
_WORDED = re.compile(
    rf"(?:(?<![a-z])(?:elevation|elev|angle|el)[ _=-]?({_NUMBER}))|(?:({_NUMBER})[ _-]?(?:degrees|deg|°)(?![a-z]))",
    re.IGNORECASE,
)

#: Angles lie farther apart than this many degrees on average; a count with gaps does not.
_MEAN_STEP = 2.5
_BARE = re.compile(rf"(?<![\d.,])({_NUMBER})")


def angles_with_words(stems: Sequence[str]) -> list[float | None]:
    """The angle in degrees that a word marks in each name, None where there is none or there are several."""
    found = [{_number(a or b) for a, b in _WORDED.findall(stem)} for stem in stems]
    return [numbers.pop() if len(numbers) == 1 else None for numbers in found]


def bare_angles(stems: Sequence[str]) -> list[float] | None:
    """The only number in which all names differ, where it can be an angle in degrees and is no plain count."""
    texts = {_BARE.sub("\0", stem) for stem in stems}
    if len(texts) != 1 or len(stems) < 2:
        return None
    columns = zip(*(map(_number, _BARE.findall(stem)) for stem in stems), strict=True)
    angles = [column for column in map(list, columns) if _may_be_angles(column)]
    return angles[0] if len(angles) == 1 else None


def natural(name: str) -> list[tuple[int, int | str]]:
    """Sorting key in which img2 comes before img10."""
    return [
        (0, int(part)) if part.isdecimal() else (1, part) for part in re.split(r"(\d{1,255}+)", name.casefold()) if part
    ]


def _may_be_angles(numbers: list[float]) -> bool:
    low, high = min(numbers), max(numbers)
    return len(set(numbers)) == len(numbers) and 30.0 < high <= 90.0 and high - low >= _MEAN_STEP * (len(numbers) - 1)


def _number(text: str) -> float:
    return float(text.replace(",", "."))


#: Beginnings of the findings that name the origin of unmeasured angles.
FROM_NAMES, ASSUMED = "Elevations were read from the file names", "No angles were found"
#: Value of `angle_source` for lights that a mirror sphere shows.
SPHERE = "mirror sphere"


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


def stated_lights(
    place: Path,
    files: list[Path],
    photographs: list[Path],
    capture: CaptureFile | None,
    angles_deg: Sequence[float] | None,
    sphere: Circle | Literal["auto"] | None,
) -> tuple[list[Lit], str, list[Finding]]:
    """Photographs with their lights from the first source that knows, its name, and what to say about it."""
    if angles_deg is not None:
        return _from_user(place, photographs, angles_deg), "user", []
    if capture is not None and capture.photographs:
        lit = _from_capture_file(capture_files(files)[0], photographs, capture, sphere is not None)
        return lit, "capture.toml" if sphere is None else SPHERE, []
    if sphere is not None:
        return [Lit(path, 0.0) for path in photographs], SPHERE, []
    light_files = [path for path in files if path.suffix.lower() == ".lp"]
    if len(light_files) > 1:
        names = ", ".join(path.name for path in light_files)
        raise InputError(place, f"holds several light-position files: {names}", "Keep the one that belongs")
    if light_files:
        return _from_light_positions(light_files[0], photographs), "lp", []
    return _from_names(place, photographs) or _assumed(photographs)


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
        raise InputError(path, f"lists {listed(twice)} more than once", "Keep one entry for each")
    silent = [entry.file for entry in capture.photographs if entry.elevation_deg is None]
    if silent and not measured:
        remedy = "Add it, or the table [sphere] of a mirror sphere that shows it"
        raise InputError(path, f"gives no elevation_deg for {listed(silent)}", remedy)
    _match(path, photographs, {name: name for name in entries})
    chosen = [(photograph, entries[comparable(photograph.name)]) for photograph in photographs]
    return [
        Lit(photograph, e.elevation_deg or 0.0, e.azimuth_deg, e.exposure_s, e.highlight_px) for photograph, e in chosen
    ]


def _from_light_positions(path: Path, photographs: list[Path]) -> list[Lit]:
    lights = {comparable(light.name): light for light in read_light_positions(path)}
    _match(path, photographs, {name: f"line {light.line} ({name})" for name, light in lights.items()})
    chosen = [(photograph, lights[comparable(photograph.name)]) for photograph in photographs]
    return [Lit(p, math.degrees(light.elevation), math.degrees(light.azimuth)) for p, light in chosen]


def _match(path: Path, photographs: list[Path], described: dict[str, str]) -> None:
    """Refuse descriptions without photographs, and photographs without description."""
    names = {comparable(photograph.name) for photograph in photographs}
    missing = [where for name, where in described.items() if name not in names]
    if missing:
        raise InputError(path, f"names photographs that are not there: {listed(missing)}", "Add them, or correct it")
    strange = sorted(names - described.keys(), key=natural)
    if strange:
        raise InputError(path, f"does not mention {listed(strange)}", "Add them to it, or take them out of the folder")


def _from_names(place: Path, photographs: list[Path]) -> tuple[list[Lit], str, list[Finding]] | None:
    stems = [path.stem for path in photographs]
    worded = angles_with_words(stems)
    silent = [path.name for path, angle in zip(photographs, worded, strict=True) if angle is None]
    if 0 < len(silent) < len(photographs):
        problem = f"of {len(photographs)} photographs, {listed(silent)} has no angle in its name and the others have"
        raise InputError(place, problem, "Rename it, take it out, or give all angles yourself")
    angles = bare_angles(stems) if silent else [angle for angle in worded if angle is not None]
    if angles is None:
        return None
    for path, angle in zip(photographs, angles, strict=True):
        _refuse_impossible(path, angle)
    shown = ", ".join(f"{angle:g}°" for angle in sorted(angles))
    verdict = Verdict.WARNING if silent else Verdict.NOTE
    finding = Finding(verdict, f"{FROM_NAMES}: {shown}. Check that they are right")
    return [Lit(path, angle) for path, angle in zip(photographs, angles, strict=True)], "file names", [finding]


def _assumed(photographs: list[Path]) -> tuple[list[Lit], str, list[Finding]]:
    """Steps of 10°, or smaller ones where there are more than nine photographs, up to 90° at most."""
    step = min(10.0, 90.0 / len(photographs))
    text = (
        f"{ASSUMED}: elevations from {step:g}° to {step * len(photographs):g}° in steps of {step:g}° are "
        "assumed, in the order of the file names. Give the real ones"
    )
    lit = [Lit(path, min(90.0, step * (index + 1))) for index, path in enumerate(photographs)]
    return lit, "assumed", [Finding(Verdict.WARNING, text)]


def by_light(lit: list[Lit], measured: bool) -> list[list[Lit]]:
    """Photographs of one light together, by rising exposure; lights by rising elevation.

    Where elevations are `measured` only later, photographs of which nothing is said are lights of their own.
    """
    groups: dict[object, list[Lit]] = {}
    for one in lit:
        known = not measured or one.elevation_deg > 0.0
        groups.setdefault(one.direction if known else one.path, []).append(one)
    lights = [_by_exposure(group) if len(group) > 1 else group for group in groups.values()]
    lights.sort(key=lambda light: (light[0].elevation_deg, light[0].azimuth_deg or 0.0, natural(light[0].path.name)))
    if len(lights) < 2:
        problem = f"holds {len(lit)} exposures of one light only"
        raise InputError(lit[0].path.parent, problem, "At least two pictures under different lights are needed")
    return lights


def _by_exposure(group: list[Lit]) -> list[Lit]:
    """Photographs of one light, whose exposures must be known and different."""
    known = [one._replace(exposure_s=one.exposure_s or noted_exposure(one.path).exposure_s) for one in group]
    if len({one.exposure_s for one in known} - {None}) < len(group):
        problem = f"{' and '.join(one.path.name for one in group)} are said to be lit from the same "
        remedy = "Keep one of them, correct the angles, or state different exposure_s in capture.toml"
        raise InputError(group[0].path.parent, f"{problem}{group[0].elevation_deg:g}°", remedy)
    return sorted(known, key=lambda one: one.exposure_s or 0.0)


def listed(names: Sequence[str], limit: int = 5) -> str:
    """The names with commas, the first few of many."""
    more = f" and {len(names) - limit} more" if len(names) > limit else ""
    return ", ".join(names[:limit]) + more
