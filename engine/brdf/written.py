"""A BRDF that a user writes in GLSL, in the format of Disney's BRDF Explorer: its text, parameters and values.

    analytic
    ::begin parameters
    float roughness 0.01 1 0.3        name, lowest, highest, default
    bool metal 0
    color tint 1 0.9 0.8
    ::end parameters
    ::begin shader
    vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) { … }
    ::end shader

L points to the light, V to the viewer, N, X and Y are normal, tangent and bitangent; the value is in 1/sr without the
cosine, as here. Lines that begin with # outside the shader are comments; sections of other names are left alone.
The values of the parameters stand in the text as their defaults, so that the text is all that has to be kept.

`f` evaluates the text itself for each pair of directions, in 32-bit floats, in a process of its own: the text may come
from a stranger. What needs a table makes one, and says its error (`engine.brdf.resample`).
Cost: 1 ms a call and 40 ns a pair on two cores; 0.5 s more for the first call.
"""

from __future__ import annotations

import itertools
import math
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from engine.brdf.resample import random_pairs
from engine.brdf.table import LARGEST
from engine.core.directions import Vectors
from engine.core.errors import InputError, MissingCapability
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.params import Colour
from engine.storage.untrusted import decode_content, read_bytes

#: Largest text in bytes, and most parameters.
LIMIT_BYTES, MAX_PARAMETERS = 1 << 16, 64

#: Seconds that an evaluation may take, after which its process ends it, and those after which its process is ended.
LIMIT_S, HANG_S = 8.0, 10.0

#: Seconds of CPU time that evaluations within `one_request` have taken so far; None outside of it.
_spent_s: ContextVar[float | None] = ContextVar("spent_s", default=None)

#: Memory of the process that evaluates, the driver's compiler among it.
MEMORY_BYTES = 4 << 30

_EVALUATE = "engine.gl.reflectance.evaluate:evaluate"
_OURS = 1_000_000  # as in that module

#: Pairs on which isotropy, reciprocity and doubtful values are found, and the RMS difference that counts as none.
_PAIRS, _SAME = 4096, 1e-3

_NAME = re.compile(r"[A-Za-z_]\w{0,63}")
#: Directives by which a text would be more than itself, or move its lines.
_REFUSED = ("version", "extension", "include", "line", "pragma")

#: The function that a text has to have, once every white space is one blank.
_SIGNATURE = re.compile(r"\bvec3 BRDF ?\(")

#: Positions in drivers' messages: Mesa `0:14(27): error`, NVIDIA `0(14) : error`, others `ERROR: 0:14:`.
_POSITIONS = (
    re.compile(r"\b\d{1,9}+:(\d{1,9}+)\(\d{1,9}+\) {0,9}+:"),
    re.compile(r"\b\d{1,9}+\((\d{1,9}+)\) {0,9}+:"),
    re.compile(r"\b\d{1,9}+:(\d{1,9}+):"),
)

#: A driver's word for an error, with its number, before the complaint.
_ERROR = re.compile(r"^error {0,9}+(?:\w{1,20}+ {0,9}+)?:")


class SourceError(InputError):
    """A text that is not a BRDF; `line` counts from 1, and is 0 where no single line is at fault."""

    def __init__(self, path: str | os.PathLike[str], line: int, problem: str, remedy: str) -> None:
        super().__init__(path, f"line {line}: {problem}" if line else problem, remedy)
        self.line = line


@dataclass(frozen=True)
class Declared:
    """One parameter: `kind` is float, bool or color, `line` that of its text, [low, high] the range of a float."""

    kind: str
    name: str
    line: int
    value: float | bool | Colour
    low: float = 0.0
    high: float = 1.0


@dataclass(frozen=True)
class Source:
    """A text taken apart: its parameters, and its GLSL with the line in which that begins."""

    parameters: tuple[Declared, ...]
    shader: str
    first_line: int


@dataclass(frozen=True)
class WrittenBrdf:
    """The BRDF of a `text`, of which `name` is for a user; `written` makes one, and measures what it is.

    Attributes
    ----------
    isotropic, reciprocal : as found on 4096 pairs of directions, to a thousandth RMS.
    health : values that are negative or no numbers, which count as 0.
    """

    text: str
    name: str
    isotropic: bool = False
    reciprocal: bool = False
    health: Health = field(default_factory=Health, compare=False)

    kind: ClassVar[str] = "written in GLSL"
    energy_conserving: ClassVar[bool] = False
    samples: ClassVar[int] = 0
    invalid_samples: ClassVar[int] = 0

    @property
    def source(self) -> Source:
        return parse(self.text, self.name)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame.

        Raises SourceError where the text does not compile or takes too long, and MissingCapability without OpenGL.
        """
        values = _raw(self.text, self.name, wi, wo)
        return np.clip(np.nan_to_num(values, nan=0.0, posinf=LARGEST, neginf=0.0), 0.0, LARGEST)


def looks_like_written(head: bytes, _size_bytes: int, _name: str) -> bool:
    """The word `analytic` in the first line, as BRDF Explorer wants it."""
    first = head.removeprefix(b"\xef\xbb\xbf").split(b"\n", 1)[0].split()
    return first[:1] == [b"analytic"]


def read_written(path: str | os.PathLike[str]) -> WrittenBrdf:
    """The BRDF in a `.brdf` file; SourceError names the line that is wrong."""
    content = read_bytes(path)
    if len(content) > LIMIT_BYTES:
        raise SourceError(path, 0, f"has {len(content):,} bytes of text, more than {LIMIT_BYTES:,}", "Shorten it")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    return write(text, Path(path).stem, path)


def write(text: str, name: str, path: str | os.PathLike[str] = "") -> WrittenBrdf:
    """The BRDF of a text, compiled and looked at; `path` names it in messages.

    Raises SourceError where the text is not a BRDF, and MissingCapability without OpenGL.
    """
    path = path or name
    parse(text, path)
    wi, wo = random_pairs(_PAIRS)
    turned = _turn(wi), _turn(wo)
    batch = np.stack([wi, turned[0], wo]), np.stack([wo, turned[1], wi])
    raw = _raw(text, name, *batch, path=path)
    brdf = WrittenBrdf(text, name)
    plain, around, exchanged = np.clip(np.nan_to_num(raw, nan=0.0, posinf=LARGEST, neginf=0.0), 0.0, LARGEST)
    scale = float(np.sqrt(np.mean(plain**2))) or 1.0
    isotropic, reciprocal = (
        bool(np.sqrt(np.mean((other - plain) ** 2)) <= _SAME * scale) for other in (around, exchanged)
    )
    return replace(brdf, isotropic=isotropic, reciprocal=reciprocal, health=_health(raw[0]))


def _turn(directions: Vectors) -> Vectors:
    """Each pair turned about the normal by an angle of its own."""
    angle = np.random.default_rng(1).uniform(0.3, 2.0 * np.pi - 0.3, len(directions))
    x, y, z = directions.T
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=-1)


def _health(raw: Vectors) -> Health:
    figures = {
        "no_numbers": float(np.mean(~np.isfinite(raw).all(axis=-1))),
        "negative": float(np.mean((raw < 0.0).any(axis=-1))),
    }
    words = {"no_numbers": "are infinite or no numbers", "negative": "are negative"}
    found = [
        Finding(Verdict.WARNING, f"{percent(share)} of the values {words[name]} and count as 0.")
        for name, share in figures.items()
        if share > 0.0
    ]
    return Health(MappingProxyType(figures), tuple(found))


def _raw(text: str, name: str, wi: ArrayLike, wo: ArrayLike, path: str | os.PathLike[str] = "") -> Vectors:
    """Values of the text itself, (..., 3), 0 where a direction is at or below the horizon."""
    wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
    values = np.zeros(wi.shape)
    above = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
    if above.any():
        values[above] = _evaluate(parse(text, path or name), path or name, wi[above], wo[above])
    return values


@contextmanager
def one_request() -> Iterator[None]:
    """Let all evaluations within the block together take no more than `LIMIT_S` of CPU time.

    Whoever asks for figures of a BRDF evaluates it many times. A further block within the block counts by itself.
    Raises SourceError at the evaluation that begins after the limit.
    """
    token = _spent_s.set(0.0)
    try:
        yield
    finally:
        _spent_s.reset(token)


def _evaluate(source: Source, path: str | os.PathLike[str], wi: Vectors, wo: Vectors) -> Vectors:
    parameters = [[each.kind, each.name, each.line, each.value] for each in source.parameters]
    content = np.stack([wi, wo]).astype(np.float32).tobytes()
    spent_s = _spent_s.get()
    if spent_s is not None and spent_s > LIMIT_S:
        raise SourceError(path, 0, f"takes more than {LIMIT_S:g} s to evaluate", "Shorten its loops")
    words: dict[str, Any] = {"shader": source.shader, "first_line": source.first_line, "parameters": parameters}
    try:
        reply = decode_content(
            _EVALUATE, path, content, memory_bytes=MEMORY_BYTES, timeout_s=HANG_S, limit_s=LIMIT_S, **words
        )
    except InputError as error:
        raise _fail(path, error) from None
    if "missing" in reply:
        raise MissingCapability(*reply["missing"])
    if "log" in reply:
        raise _describe_refusal(path, source, str(reply["log"]))
    if spent_s is not None:
        _spent_s.set(spent_s + float(reply["cpu_s"]))
    values: Vectors = np.asarray(reply["values"], np.float64)
    return values


def _fail(path: str | os.PathLike[str], error: InputError) -> SourceError:
    """The failure of the process in words about the text, of which it knows nothing."""
    if "could not be decoded within" in error.problem:
        return SourceError(path, 0, f"hangs: not evaluated within {HANG_S:g} s", "Shorten its loops")
    if "crashed" in error.problem:
        return SourceError(path, 0, "makes the driver of OpenGL crash", "Write it more simply")
    return SourceError(path, 0, error.problem, error.remedy)


def _describe_refusal(path: str | os.PathLike[str], source: Source, log: str) -> SourceError:
    """The first complaint of the driver, at its line."""
    for line in log.splitlines():
        for position in _POSITIONS:
            found = position.search(line)
            if found and "warning" not in line:
                number = int(found[1])
                words = _ERROR.sub("", line[found.end() :].strip()).strip() or line.strip()
                if 0 < number < _OURS:
                    return SourceError(path, number, words[:300], "Correct it there")
                problem = f"the function BRDF does not fit the rest ({words[:200]})"
                return SourceError(path, source.first_line, problem, "Close all brackets, comments and #if")
    said = " ".join(log.split())[:200]
    return SourceError(path, source.first_line, f"does not compile ({said})", "Correct the shader")


def parse(text: str, path: str | os.PathLike[str] = "") -> Source:
    """A text taken apart without being compiled; SourceError names the line that is wrong."""
    if len(text.encode("utf-8", "replace")) > LIMIT_BYTES:
        raise SourceError(path, 0, f"has more than {LIMIT_BYTES:,} bytes of text", "Shorten it")
    if "\0" in text:
        raise SourceError(path, text[: text.index("\0")].count("\n") + 1, "holds a zero byte", "Remove it")
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    if lines[0].lstrip("\ufeff").split()[:1] != ["analytic"]:
        raise SourceError(path, 1, "does not begin with the word analytic", "Write it into the first line")
    parameters: list[Declared] = []
    shader: list[str] = []
    first = section_line = 0
    section = ""
    for number, line in enumerate(lines[1:], start=2):
        words = line.split()
        if words[:1] == ["::begin"]:
            if section:
                raise SourceError(path, number, f"{section} has not ended", f"Write ::end {section} before it")
            section, section_line = " ".join(words[1:2]) or "section", number
            first = number + 1 if section == "shader" and not first else first
        elif words[:1] == ["::end"]:
            if words[1:2] != [section]:
                raise SourceError(path, number, f"ends {' '.join(words[1:2])[:60]!r}, not {section!r}", "Pair them")
            section = ""
        elif section == "shader":
            _check_directive(path, number, line)
            shader += [""] * (number - first - len(shader)) + [line]
        elif section == "parameters" and words and not words[0].startswith("#"):
            parameters.append(_declare(path, number, words))
            _check_new(path, number, parameters)
    if section:
        raise SourceError(path, section_line, f"{section} never ends", f"Write ::end {section} after it")
    if not shader or not _SIGNATURE.search(" ".join("\n".join(shader).split())):
        remedy = "Write vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) between ::begin shader and ::end shader"
        raise SourceError(path, first, "has no function BRDF", remedy)
    return Source(tuple(parameters), "\n".join(shader), first)


def _check_directive(path: str | os.PathLike[str], number: int, line: str) -> None:
    text = line.strip()
    found = _NAME.match(text[1:].lstrip()) if text.startswith("#") else None
    if found and found[0] in _REFUSED:
        raise SourceError(path, number, f"#{found[0]} is not allowed", "Remove the line: a text stands for itself")


def _check_new(path: str | os.PathLike[str], number: int, parameters: list[Declared]) -> None:
    if len(parameters) > MAX_PARAMETERS:
        raise SourceError(path, number, f"declares more than {MAX_PARAMETERS} parameters", "Leave some out")
    if parameters[-1].name in {each.name for each in parameters[:-1]}:
        raise SourceError(path, number, f"declares {parameters[-1].name} again", "Give it another name")


#: By kind, the numbers that follow the name.
_NUMBERS = {"float": 3, "bool": 1, "color": 3}
_SHAPES = {
    "float": "float name lowest highest default",
    "bool": "bool name 0 or 1",
    "color": "color name red green blue",
}


def _declare(path: str | os.PathLike[str], number: int, words: list[str]) -> Declared:
    kind = words[0]
    if kind not in _NUMBERS:
        raise SourceError(path, number, f"{kind[:60]!r} is not a kind of parameter", "Write float, bool or color")
    values = words[2 : 2 + _NUMBERS[kind]]
    try:
        numbers = [float({"true": "1", "false": "0"}.get(value, value)) for value in values]
    except ValueError:
        numbers = []
    if len(numbers) != _NUMBERS[kind] or not all(math.isfinite(value) and abs(value) < LARGEST for value in numbers):
        raise SourceError(path, number, "is not a parameter", f"Write {_SHAPES[kind]}")
    name = words[1]
    if not _NAME.fullmatch(name) or name.startswith(("gl_", "lightarc_")) or "__" in name:
        raise SourceError(path, number, f"{name[:60]!r} is not a name for a parameter", "Use letters, digits and _")
    if kind == "bool":
        return Declared(kind, name, number, numbers[0] != 0.0)
    if kind == "color":
        return Declared(kind, name, number, (numbers[0], numbers[1], numbers[2]))
    low, high, value = numbers
    if not low < high:
        raise SourceError(path, number, f"the range of {name} is empty", "Write a highest above the lowest")
    return Declared(kind, name, number, min(max(value, low), high), low, high)


def with_value(text: str, name: str, value: float | bool | Colour) -> str:
    """The text with another default of one parameter; what stands around it stays as it is, comments too."""
    (each,) = (each for each in parse(text).parameters if each.name == name)
    lines = text.split("\n")
    words = ["".join(run) for _, run in itertools.groupby(lines[each.line - 1], str.isspace)]
    start = next(place for place, word in enumerate(words) if word == each.name)
    said = [f"{int(value)}"] if isinstance(value, bool) else [f"{part:.7g}" for part in np.atleast_1d(value)]
    last = start + 2 * _NUMBERS[each.kind]
    for place, word in zip(range(last, start, -2), reversed(said), strict=False):
        words[place] = word
    lines[each.line - 1] = "".join(words)
    return "\n".join(lines)
