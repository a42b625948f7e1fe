"""Exposure of each photograph of a capture, and the scale on which all are comparable.

The relative exposure is the time, times the sensitivity (ISO) and over the square of the aperture number where the
camera noted these for every photograph. Radiance of all photographs is brought to the reference exposure, whose white
level is 1: the most frequent one, and of equally frequent ones the shortest.
"""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.storage.untrusted import build, decode_content, decode_in_child, read_head

_HEAD_BYTES = 1 << 20

#: Relative exposures in seconds that are believed; radiance on the scale of any of them is finite.
SHORTEST_S, LONGEST_S = 1e-9, 1e9


@dataclass(frozen=True)
class Exposure:
    """A photograph and, in seconds, what `capture.toml` says about its exposure."""

    path: Path
    exposure_s: float | None


@dataclass(frozen=True)
class Noted:
    """Exposure as the camera noted it, None for what it did not note."""

    exposure_s: float | None = None
    iso: float | None = None
    aperture: float | None = None


@dataclass(frozen=True)
class Scale:
    """Factors that bring photographs to the reference exposure.

    `factor` by path, empty where radiance is left as it is; `relative` exposures by path where they are known;
    `reference` is the relative exposure whose white level is 1.
    """

    factor: Mapping[Path, float]
    relative: Mapping[Path, float]
    reference: float | None
    findings: tuple[Finding, ...]


def read_noted_exposure(path: Path) -> Noted:
    """Exposure that the camera noted in `path`, usually within its first megabyte.

    Nothing for a file that cannot be read, which decoding will tell.
    """
    decoder = "engine.capture.photograph.decode:decode_exposure"
    try:
        head, size_bytes = read_head(path, _HEAD_BYTES)
    except InputError:
        return Noted()
    with contextlib.suppress(InputError):
        noted = build(Noted, path, decode_content(decoder, path, head))
        if noted.exposure_s is not None:
            return noted
    if size_bytes > len(head):
        with contextlib.suppress(InputError):
            noted = build(Noted, path, decode_in_child(decoder, path))
            return noted if noted.exposure_s is not None else Noted()
    return Noted()


def exposure_scale(lights: Sequence[Sequence[Exposure]], noted: Mapping[Path, Noted]) -> Scale:
    """The scale of a capture's `lights` (photographs of each), given what the camera `noted` in each."""
    photographs = [photograph for light in lights for photograph in light]
    relative = _relative(photographs, noted)
    unknown = [one.path.name for one in photographs if one.path not in relative]
    different = Counter(_round(value) for value in relative.values())
    if len(different) <= 1 and not (unknown and different):
        return Scale({}, relative, next(iter(relative.values()), None), ())
    if unknown:
        return Scale({}, relative, None, (_find_unscaled(photographs, relative, unknown),))
    reference = min(different, key=lambda value: (-different[value], value))
    text = f"Exposures differ: {_table(photographs, relative)}. Radiance is brought to that of {reference:g} s"
    factor = {path: reference / value for path, value in relative.items()}
    return Scale(factor, relative, reference, (Finding(Verdict.NOTE, text),))


def _relative(photographs: Sequence[Exposure], noted: Mapping[Path, Noted]) -> dict[Path, float]:
    """Exposure times, weighted by what differs between photographs and is known of all; InputError for absurd ones."""
    notes = [noted.get(one.path, Noted()) for one in photographs]
    iso_known = all(note.iso for note in notes) and len({note.iso for note in notes}) > 1
    aperture_known = all(note.aperture for note in notes) and len({note.aperture for note in notes}) > 1
    first = notes[0]
    relative = {}
    for one, note in zip(photographs, notes, strict=True):
        time_s = one.exposure_s or note.exposure_s
        if time_s is None:
            continue
        if iso_known and note.iso and first.iso:
            time_s *= note.iso / first.iso
        if aperture_known and note.aperture and first.aperture:
            time_s *= (first.aperture / note.aperture) ** 2
        if not SHORTEST_S <= time_s <= LONGEST_S:
            problem = (
                f"was exposed for {time_s:g} s, as stated or noted, which is outside {SHORTEST_S:g} … {LONGEST_S:g}"
            )
            raise InputError(one.path, problem, "State its exposure_s in capture.toml")
        relative[one.path] = time_s
    return relative


def _round(value: float) -> float:
    """Exposures within a thousandth of each other are one."""
    return float(f"{value:.3g}")


def _find_unscaled(photographs: Sequence[Exposure], relative: Mapping[Path, float], unknown: Sequence[str]) -> Finding:
    text = (
        f"Exposures differ: {_table(photographs, relative)}. Radiance is not scaled, because the exposure of "
        f"{', '.join(unknown[:4])}{' …' if len(unknown) > 4 else ''} is unknown; state exposure_s in capture.toml"
    )
    return Finding(Verdict.WARNING, text)


def _table(photographs: Sequence[Exposure], relative: Mapping[Path, float]) -> str:
    values = [f"{_round(relative[one.path]):g} s" if one.path in relative else "unknown" for one in photographs]
    return group([(value, one.path.name) for value, one in zip(values, photographs, strict=True)])


def group(values: Sequence[tuple[str, str]]) -> str:
    """'8 × 16 bit; 8 bit: a.png, b.png' for (value, name): the usual value by its count, the others by name."""
    groups: dict[str, list[str]] = {}
    for value, name in values:
        groups.setdefault(value, []).append(name)
    (usual, names), *others = sorted(groups.items(), key=lambda item: -len(item[1]))
    named = [f"{value}: {', '.join(some[:4])}{' …' if len(some) > 4 else ''}" for value, some in others]
    return "; ".join([f"{len(names)} × {usual}", *named])
