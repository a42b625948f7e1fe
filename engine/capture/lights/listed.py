"""Lights that are stated of a capture while its photographs are still being taken, and how much of the dome they cover.

A list of lights names all photographs before they are there; angles in file names come with each. What belongs to a
photograph can only be told for sure when all are there (`engine.capture.lights.light_angles`), which the import does.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.file_names import angles_with_words, bare_angles, comparable, natural, number_of, stem_name
from engine.capture.lights.folder import capture_files
from engine.capture.lights.light_angles import LIGHT_SUFFIXES
from engine.capture.lights.light_file import read_lights
from engine.capture.lights.light_positions import read_dome, read_light_positions
from engine.capture.lights.mirror_sphere import Circle
from engine.core.directions import surface_direction

#: Elevation and azimuth in degrees, the azimuth None on an arc of which none is known.
Direction = tuple[float, float | None]

#: A direction is covered that lies within so many degrees of a lamp, and number of directions that are looked at.
COVERS_DEG, POINTS = 25.0, 2000


@dataclass(frozen=True)
class Listed:
    """Lights of photographs, in the order of the list; the `names` of these are none where they count in that order.

    There are no directions where a mirror `sphere` of this outline tells them. `gains` are the intensities of the lamps
    and `lamp_distance` is in widths of the image, where the list states them.
    """

    directions: tuple[Direction, ...]
    names: tuple[str, ...] = ()
    sphere: Circle | None = None
    gains: tuple[float, ...] = ()
    lamp_distance: float | None = None

    @property
    def count(self) -> int | None:
        """The number of photographs that are listed; None where none is."""
        return max(len(self.directions), len(self.names)) or None

    @property
    def order(self) -> list[int]:
        """Places in the list by rising elevation, as a stack has the lights."""
        names = self.names or ("",) * len(self.directions)
        keys = [
            (elevation, azimuth or 0.0, natural(name))
            for (elevation, azimuth), name in zip(self.directions, names, strict=True)
        ]
        return sorted(range(len(keys)), key=keys.__getitem__)

    def match(self, photographs: Sequence[Path]) -> list[Direction | None]:
        """The light of each photograph, None where the list does not tell it."""
        return [None if place is None else self.directions[place] for place in self.places(photographs)]

    def places(self, photographs: Sequence[Path]) -> list[int | None]:
        """The place of each photograph in the list, None where that does not tell it."""
        nothing: list[int | None] = [None] * len(photographs)
        if not self.directions:
            return nothing
        if not self.names:
            order = sorted(range(len(photographs)), key=lambda at: natural(photographs[at].name))
            ranks = {at: rank for rank, at in enumerate(order)}
            return [ranks[at] if ranks[at] < len(self.directions) else None for at in range(len(ranks))]
        for key in (comparable, stem_name, number_of):
            by_key: dict[Hashable, int] = {key(name): place for place, name in enumerate(self.names)}
            matched = [by_key.get(key(photograph.name)) for photograph in photographs]
            if len(by_key) == len(self.names) and matched != nothing:
                return matched
        return nothing


def read_listed(files: Sequence[Path], angles_deg: Sequence[float] | None = None) -> Listed | None:
    """The lights that a user gives as elevations, or that a list among `files` of a folder states; None without one.

    Raises InputError for a list that cannot be read.
    """
    if angles_deg is not None:
        return Listed(tuple((float(angle), None) for angle in angles_deg))
    near = None
    if found := capture_files(list(files)):
        from engine.capture.lights.capture_file import read_capture_file

        capture = read_capture_file(found[0])
        entries, outline, near = capture.photographs, capture.sphere, capture.lamp_distance
        sphere = None if outline is None else Circle(outline.column_px, outline.row_px, outline.radius_px)
        names = tuple(entry.file for entry in entries)
        if sphere is not None:
            return Listed((), names, sphere)
        if entries and all(entry.elevation_deg is not None for entry in entries):
            directions = tuple((float(entry.elevation_deg or 0.0), entry.azimuth_deg) for entry in entries)
            return Listed(directions, names, lamp_distance=near)
    lists = [path for path in files if path.suffix.lower() in LIGHT_SUFFIXES]
    if not lists:
        return None
    suffix = lists[0].suffix.lower()
    if suffix == ".dome":
        dome = read_dome(lists[0])
        directions = tuple(_in_degrees(*one) for one in dome.directions)
        return Listed(directions, lamp_distance=near or dome.lamp_distance)
    gains: tuple[float, ...] = ()
    if suffix == ".lights":
        stated = read_lights(lists[0])
        lights, gains, near = stated.lights, stated.gains, near or stated.lamp_distance
    else:
        lights = read_light_positions(lists[0]).lights
    directions = tuple(_in_degrees(one.elevation, one.azimuth) for one in lights)
    return Listed(directions, tuple(one.name for one in lights), None, gains, near)


def from_names(photographs: Sequence[Path]) -> list[Direction | None]:
    """The elevation in the name of each photograph, None where it has none."""
    stems = [path.stem for path in photographs]
    angles = angles_with_words(stems)
    if None in angles:
        angles = [*(bare_angles(stems) or angles)]
    return [None if angle is None or not 0.0 <= angle <= 90.0 else (angle, None) for angle in angles]


def coverage(directions: Sequence[Direction]) -> float | None:
    """The share of the hemisphere that lies within 25° of a lamp; None where azimuths are not known."""
    known = [(math.radians(high), math.radians(azimuth)) for high, azimuth in directions if azimuth is not None]
    if not known or len(known) < len(directions):
        return None
    elevation, azimuth = np.array(known).T
    lamps = surface_direction(0.5 * np.pi - elevation, azimuth)
    return float(((_hemisphere() @ lamps.T).max(axis=1) >= math.cos(math.radians(COVERS_DEG))).mean())


def _hemisphere() -> NDArray[np.float64]:
    """(POINTS, 3) directions above the sample, each for the same solid angle: a spiral of equal heights."""
    height = (np.arange(POINTS) + 0.5) / POINTS
    azimuth = np.arange(POINTS) * (np.pi * (3.0 - math.sqrt(5.0)))
    radius = np.sqrt(1.0 - height * height)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height], axis=1)


def _in_degrees(elevation: float, azimuth: float) -> Direction:
    return math.degrees(elevation), math.degrees(azimuth)
