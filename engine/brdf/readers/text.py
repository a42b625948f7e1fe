"""Text files of measurements: their letters, lines and numbers, checked before anything is believed.

UTF-8 and UTF-16 with or without a mark and Latin-1 are read, with any line ends. What is wrong is reported with
its line, counted from 1. Numbers are written with a decimal point, and with Fortran's exponents too (`1.5D-02`);
`nan`, `inf` and numbers beyond float64 are numbers here, and the value that they make invalid is dropped where samples
are made (`engine.brdf.samples`).
Lines and words are taken apart without patterns that search backwards, so that the time is proportional to the length
of the file whatever is in it.
Cost: about 1 s per 3 million numbers.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.storage.text import mark as mark_encoding
from engine.storage.untrusted import AGAIN, read_bytes

#: Largest text that is read, longest line, and most samples: far beyond any published measurement.
LIMIT_BYTES = 256 << 20
LINE_LIMIT = 1 << 20
SAMPLES_LIMIT = 2_000_000

CORRECT = "Correct the file, or export it again from the program that wrote it"

_NO_TEXT = re.compile(rb"[\x00-\x08\x0e-\x19\x1b-\x1f\x7f]")
#: So many bytes of text make a text; what is not a letter behind them is damage, which reading the whole tells.
_SURE_BYTES = 4096

_MARKS = ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig"))
_FORTRAN = str.maketrans("dD", "ee")


class Line(NamedTuple):
    """A line that is not empty, without the white space around it, and its number from 1."""

    number: int
    text: str


def read_lines(path: str | os.PathLike[str]) -> list[Line]:
    """The lines of a text file that hold anything; InputError for what is not text."""
    content = mark_encoding(read_bytes(path, LIMIT_BYTES))
    text = _decode(path, content)
    split = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    lines = [Line(number, bare) for number, line in enumerate(split, 1) if (bare := line.strip())]
    for line in lines:
        if len(line.text) > LINE_LIMIT:
            refuse(path, line.number, f"has {len(line.text)} characters; at most {LINE_LIMIT} are read")
    return lines


def head_lines(head: bytes) -> list[str]:
    """The lines of the first bytes of a file as far as they can be told, for a look at the format; [] for no text."""
    head = mark_encoding(head)
    for mark, coding in ((b"\xff\xfe", "utf-16-le"), (b"\xfe\xff", "utf-16-be")):
        if head.startswith(mark):
            return [line.strip() for line in head[2:].decode(coding, "ignore").splitlines()]
    if _NO_TEXT.search(head, 0, _SURE_BYTES):
        return []
    return [line.strip() for line in head.removeprefix(b"\xef\xbb\xbf").decode("latin-1").splitlines()]


def numbers(path: str | os.PathLike[str], line: int, words: Sequence[str]) -> list[float]:
    """`words` as numbers; InputError names the line and the word that is none."""
    try:
        values = [float(word) for word in words]
    except ValueError:
        values = [float(word.translate(_FORTRAN)) for word in words if is_number(word)]
    if len(values) != len(words) or any("_" in word for word in words):
        wrong = next(word for word in words if not is_number(word))
        if wrong.count(",") == 1 and is_number(wrong.replace(",", ".")):
            refuse(path, line, f"has a decimal comma in {wrong[:40]!r}", "Write decimal points")
        refuse(path, line, f"has {wrong[:40]!r} where a number is needed")
    return values


def is_number(word: str) -> bool:
    """True for what `numbers` takes."""
    try:
        float(word.translate(_FORTRAN))
    except ValueError:
        return False
    return "_" not in word


def without_unit(name: str, units: Sequence[str]) -> tuple[str, str]:
    """The name of a column and which of `units` (in small letters, long ones first) ends it, '' for none.

    `theta_i_deg`, `theta_i (deg)` and `theta_i[deg]` all are `theta_i` in `deg`.
    """
    bare = name[:-1] if name.endswith((")", "]")) else name
    unit = next((unit for unit in units if bare.lower().endswith(unit)), "")
    return (bare[: -len(unit)].rstrip("_ ([") if unit else name), unit


def table(path: str | os.PathLike[str], rows: Sequence[list[float]]) -> NDArray[np.float64]:
    """Rows of one length as an array (N, width); InputError where there is none or there are too many."""
    if not rows:
        raise InputError(path, "holds no measurement", AGAIN)
    if len(rows) > SAMPLES_LIMIT:
        raise InputError(path, f"holds {len(rows)} samples; at most {SAMPLES_LIMIT} are read", "Make it smaller")
    return np.array(rows, np.float64)


def refuse(path: str | os.PathLike[str], line: int, problem: str, remedy: str = CORRECT) -> NoReturn:
    """Raise InputError for what is wrong in a line."""
    raise InputError(path, f"line {line} {problem}", remedy)


def _decode(path: str | os.PathLike[str], content: bytes) -> str:
    coding = next((each for mark, each in _MARKS if content.startswith(mark)), None)
    found = _NO_TEXT.search(content) if coding != "utf-16" else None
    if found:
        raise InputError(path, f"is not text (byte {found[0][0]:#04x} at {found.start()})", AGAIN)
    try:
        return content.decode(coding or "utf-8")
    except UnicodeDecodeError:
        if coding:
            raise InputError(path, f"is damaged: it begins as {coding} text and does not go on so", AGAIN) from None
        return content.decode("latin-1")
