"""Text made to be slow, through every reader of text from outside: CPU time per byte, and how it grows.

A place is where a sound file is interrupted; a fill is what is put there, over and over. A reader whose time is
proportional to the length grows with the exponent 1; one that searches backwards at every place grows with 2.
The time is that of this process and of its decoders together, which other programs on the machine hardly change.
Cost: 5 minutes; each place meets every fill briefly, and those that took longest there at full length.
"""

from __future__ import annotations

import contextlib
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import psutil

from benchmarks.measure import Measure
from engine.brdf.brdf import brdf_from_text
from engine.brdf.readers.read import read_measurement
from engine.brdf.readers.samples_child import read_directions
from engine.capture.lights.capture_file import read_capture_file
from engine.capture.lights.file_names import angles_with_words, bare_angles, natural
from engine.capture.lights.light_positions import read_light_positions
from engine.core.errors import InputError
from engine.geometry.camera import Camera
from engine.geometry.camera import parse as read_camera
from engine.geometry.mesh import read_mesh
from engine.geometry.read_scene import check_memory
from engine.images.decode import read_image
from engine.light.lamps import lamp_from_text
from engine.storage.atomic import write_bytes
from engine.storage.records import read_manifest
from engine.tradeoff.front import budget_from_text
from engine.transport.baking.blend import blend_from_text

#: Longest CPU time for reading untrusted text, in seconds per 2^20 bytes.
LIMIT_S = 2.0

#: Length in bytes at which every fill is tried, how many of each place are tried further, and at which two lengths.
BRIEF, WORST, LENGTHS = 1 << 15, 2, (1 << 18, 1 << 20)

#: CPU time below this is reported too roughly by systems, and is too little, to say how it grows.
_CERTAIN_S = 0.05

FILLS = {
    "blanks": " ",
    "tabs": "\t",
    "newlines": "\n",
    "returns": "\r",
    "blank lines": " \n",
    "comments": "# \n",
    "hashes": "#",
    "underscores": "_",
    "parentheses": "(",
    "brackets": "[",
    "braces": '{"a":[',
    "tables": "[a]\n",
    "dotted": "a.",
    "commas": ",",
    "semicolons": ";",
    "digits": "1",
    "numbers": "1 ",
    "fractions": "1.",
    "exponents": "1e",
    "Fortran": "1D",
    "signs": "+-",
    "huge": "1e400 ",
    "nan": "nan ",
    "inf": "inf,",
    "hexadecimal": "0x",
    "letters": "a",
    "degrees": "deg(",
    "names": "theta_i,",
    "wavelengths": "1nm",
    "elements": "element face 1\n",
    "faces": "f 1 2 3\n",
    "slashes": "1/",
    "backslashes": "\\",
    "continued": "\\\n",
    "quotes": '"',
    "equals": "=",
    "colons": ":",
    "NUL": "\0",
    "separators": "\x1f",
    "accents": "é",
    "ideographs": "漢",
    "no-break": "\u00a0",
    "line separators": "\u2028",
}


class Place(NamedTuple):
    """A sound text of `before` and `after` around the place, the name of its file, and what reads that."""

    file: str
    before: str
    after: str
    read: Callable[[Path], object]


def _place(file: str, text: str, read: Callable[[Path], object]) -> Place:
    before, after = text.split("@")
    return Place(file, before, after, read)


def _as_text(read: Callable[[str], object]) -> Callable[[Path], object]:
    return lambda path: read(path.read_bytes().decode("utf-8", "replace"))


def _manifest(path: Path) -> object:
    return read_manifest(path.read_bytes(), path)


_CSV = "theta_i,phi_i,theta_o,phi_o,r,g,b\n10,0,10,0,1,1,1\n"
_ALTA = "#DIM 4 3\n#PARAM_IN RUSIN_TH_PH_TD_PD\n0 0 0 0 1 1 1\n"
_ASTM = "NUM_POINTS 1\nVARS theta_i,phi_i,theta_s,phi_s,400nm,500nm\n0,0,0,0,1,1\n"
_CORNELL = "2 400 500\n0 0 0 0 1 1\n"
_CURET = "1 " + "0.1 " * 205 + "\n"
_OFF = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
_XYZ = "".join(f"property float {axis}\n" for axis in "xyz")
_PLY_HEAD = f"element vertex 3\n{_XYZ}element face 1\nproperty list uchar int vertex_indices\n"
_PLY = f"ply\nformat ascii 1.0\n{_PLY_HEAD}end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
_OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
_STL = (
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"
)
_HDR = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1\n\n-Y 1 +X 1\n\1\1\1\1"


def _at(text: str, mark: str, *, before: bool = False) -> str:
    """`text` with the place after (or before) the first `mark`."""
    return text.replace(mark, "@" + mark if before else mark + "@", 1)


PLACES = {
    "CSV name": _place("a.csv", _at(_CSV, "phi_o"), read_measurement),
    "CSV unit": _place("a.csv", _at(_CSV, "phi_o").replace("@", " (@deg)"), read_measurement),
    "CSV first name": _place("a.csv", _at(_CSV, "theta_i", before=True), read_directions),
    "CSV number": _place("a.csv", _at(_CSV, "1,1"), read_measurement),
    "CSV comment": _place("a.csv", "# @\n" + _CSV, read_measurement),
    "CSV rows": _place("a.csv", _CSV + "@", read_measurement),
    "ALTA key": _place("a.dat", _at(_ALTA, "#PARAM", before=True).replace("@", "#@ 3\n"), read_measurement),
    "ALTA sizes": _place("a.dat", "#PARAM_IN CARTESIAN\n#DIM 4@3\n", read_measurement),
    "ALTA name": _place("a.dat", _at(_ALTA, "RUSIN"), read_measurement),
    "ALTA rows": _place("a.dat", _ALTA + "@", read_measurement),
    "ASTM names": _place("a.astm", _at(_ASTM, "theta_s"), read_measurement),
    "ASTM wavelength": _place("a.astm", _at(_ASTM, ",4"), read_measurement),
    "ASTM count": _place("a.astm", _at(_ASTM, "NUM_POINTS 1"), read_measurement),
    "ASTM head": _place("a.astm", _at(_ASTM, "1\n"), read_measurement),
    "ASTM rows": _place("a.astm", _ASTM + "@", read_measurement),
    "Cornell count": _place("a.brdf", "@" + _CORNELL, read_measurement),
    "Cornell wavelengths": _place("a.brdf", _at(_CORNELL, "500"), read_measurement),
    "Cornell rows": _place("a.brdf", _CORNELL + "@", read_measurement),
    "CUReT rows": _place("abrdf.dat", _CURET + "@", read_measurement),
    ".lp count": _place("a.lp", "@1\na.jpg 0 0 1\n", read_light_positions),
    ".lp name": _place("a.lp", "1\na@.jpg 0 0 1\n", read_light_positions),
    ".lp numbers": _place("a.lp", "1\na.jpg 0 0 1@\n", read_light_positions),
    ".lp lines": _place("a.lp", "1\n@\n", read_light_positions),
    "TOML": _place("capture.toml", "@", read_capture_file),
    "TOML value": _place("capture.toml", "notes = @\n", read_capture_file),
    "TOML text": _place("capture.toml", 'notes = "@"\n', read_capture_file),
    "TOML key": _place("capture.toml", "a@ = 1\n", read_capture_file),
    "TOML number": _place("capture.toml", "lamp_distance = 1@\n", read_capture_file),
    "TOML list": _place("capture.toml", "x = [@]\n", read_capture_file),
    "JSON": _place("manifest.json", "@", _manifest),
    "JSON value": _place("manifest.json", '{"format":"lightarc-bundle","name":@}', _manifest),
    "JSON number": _place("manifest.json", '{"format":"lightarc-bundle","sigma":1@}', _manifest),
    "JSON text": _place("manifest.json", '{"format":"lightarc-bundle","name":"@"}', _manifest),
    "OBJ": _place("a.obj", "@" + _OBJ, read_mesh),
    "OBJ vertex": _place("a.obj", _at(_OBJ, "v 0 0 0"), read_mesh),
    "OBJ face": _place("a.obj", _OBJ.rstrip() + "@\n", read_mesh),
    "OFF head": _place("a.off", "@" + _OFF, read_mesh),
    "OFF counts": _place("a.off", _at(_OFF, "OFF"), read_mesh),
    "OFF counts in memory": _place("a.off", _at(_OFF, "OFF"), check_memory),
    "OFF vertex": _place("a.off", _at(_OFF, "0 1 0\n", before=True), read_mesh),
    "PLY head": _place("a.ply", _at(_PLY, "1.0\n"), read_mesh),
    "PLY element": _place("a.ply", _at(_PLY, "element vertex 3"), read_mesh),
    "PLY element in memory": _place("a.ply", _at(_PLY, "element face"), check_memory),
    "PLY vertex": _place("a.ply", _at(_PLY, "0 1 0\n", before=True), read_mesh),
    "STL name": _place("a.stl", _at(_STL, "solid a"), read_mesh),
    "STL vertex": _place("a.stl", _at(_STL, "vertex 0 0 0"), read_mesh),
    "glTF": _place("a.gltf", "@", read_mesh),
    "glTF value": _place("a.gltf", '{"asset":{"version":"2.0"},"meshes":@}', read_mesh),
    "HDR head": _place("a.hdr", _at(_HDR, "RADIANCE\n"), read_image),
    "HDR exposure": _place("a.hdr", _at(_HDR, "EXPOSURE=1"), read_image),
    "HDR size": _place("a.hdr", _at(_HDR, "-Y 1"), read_image),
    "angle in a name": _place("a", "cloth_10@deg", _as_text(lambda name: angles_with_words([name]))),
    "number in a name": _place("a", "cloth_10@", _as_text(lambda name: bare_angles([name, "cloth_20"]))),
    "order of names": _place("a", "cloth_10@", _as_text(natural)),
    "lamp": _place("a", "theta_deg=1@", _as_text(lamp_from_text)),
    "camera": _place("a", "eye=1,2,3@", _as_text(lambda text: read_camera(text, Camera((0, 0, 4), (0, 0, 0))))),
    "BRDF": _place("a", "ggx:alpha=0.3@", _as_text(brdf_from_text)),
    "budget": _place("a", "1@ ms", _as_text(budget_from_text)),
    "blend": _place("a", "ggx:alpha=0.1@:y", _as_text(blend_from_text)),
}


def content(place: Place, fill: str, length: int) -> bytes:
    """The text with about `length` bytes of `fill` at the place, in UTF-8."""
    return (place.before + fill * (length // len(fill.encode())) + place.after).encode()


def refusal(place: Place, fill: str, length: int, folder: Path) -> str | None:
    """The error message of the reader for the text, which is written into `folder`; None if the reader accepts it.

    InputError refuses a file, ValueError an argument of the command line; other exceptions propagate.
    """
    path = folder / place.file
    write_bytes(path, content(place, fill, length))
    if place.file == "abrdf.dat":
        write_bytes(folder / "table.txt", b"0.1 0.2 0.3 0.4\n" * 205)
    try:
        place.read(path)
    except InputError as error:
        return str(error)
    except ValueError as error:
        if place.file != "a":
            raise
        return str(error)
    return None


class Cost(NamedTuple):
    """The time of a place and fill per 2^20 bytes, and the exponent with which it grows, 0 where it is too short."""

    time_s: float
    growth: float
    place: str
    fill: str


def hostile_text() -> Measure:
    """The slowest place and fill of all and of each format, in CPU time per 2^20 bytes, beside `LIMIT_S`."""
    with tempfile.TemporaryDirectory() as folder:
        costs = [_cost(name, fill, Path(folder)) for name in PLACES for fill in _slowest_fills(name, Path(folder))]
    slowest = max(costs)
    formats: dict[str, Cost] = {}
    for cost in sorted(costs):
        formats[cost.place.split()[0]] = cost
    more = {
        "place": slowest.place,
        "fill": slowest.fill,
        "growth": slowest.growth,
        "steepest_growth": max(cost.growth for cost in costs),
        "formats": {name: cost._asdict() for name, cost in formats.items()},
    }
    return Measure("hostile-text", slowest.time_s, LIMIT_S, "2 s a megabyte", more)


def _slowest_fills(name: str, folder: Path) -> list[str]:
    """Those of `WORST` fills that take longest at the place, briefly; ties of the rough clock by the wall clock."""
    refusal(PLACES[name], "1", 0, folder)  # the sound file loads and compiles what its reader needs
    times: dict[str, tuple[float, float]] = {}
    for what in FILLS:
        start = time.perf_counter()
        times[what] = (_cpu_time_s(name, what, BRIEF, folder), time.perf_counter() - start)
    return sorted(times, key=times.__getitem__)[-WORST:]


def _cost(name: str, what: str, folder: Path) -> Cost:
    short_s, long_s = (_cpu_time_s(name, what, length, folder) for length in LENGTHS)
    ratio = math.log(LENGTHS[1] / LENGTHS[0])
    growth = math.log(long_s / short_s) / ratio if min(short_s, long_s) > _CERTAIN_S else 0.0
    return Cost(long_s * 2**20 / LENGTHS[1], growth, name, what)


def _cpu_time_s(name: str, what: str, length: int, folder: Path) -> float:
    """CPU time of a reading, in seconds: this process, its decoders, and those that ended."""
    before = _measure_used_s()
    refusal(PLACES[name], FILLS[what], length, folder)
    return _measure_used_s() - before


def _measure_used_s() -> float:
    own = psutil.Process()
    times = own.cpu_times()
    used_s = time.process_time() + times.children_user + times.children_system
    for child in own.children():
        with contextlib.suppress(psutil.NoSuchProcess):
            child_times = child.cpu_times()
            used_s += child_times.user + child_times.system
    return used_s
