"""Text of strangers: whole numbers, JSON, and text in UTF-16, which Windows programs call "Unicode", as UTF-8.

UTF-16 is known by its mark, or without one by its zeros: no letter of the file formats here needs its upper byte, and
no text in UTF-8 or Latin-1 holds a byte of 0. Cost: linear, about 10 ns for each letter.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NoReturn

from engine.core.errors import InputError

if TYPE_CHECKING:
    import os

#: Halves of letters, which Python puts in the place of bytes that it can't decode.
_NO_LETTER = re.compile("[\ud800-\udfff]")

_MARKS = (b"\xff\xfe", b"\xfe\xff")

#: Bytes that are looked at, and the share of letters among them whose upper byte must be 0.
_LOOKED_AT, _SHARE = 512, 0.75


def utf8(content: bytes) -> bytes:
    """`content` in UTF-8 without a mark where it is text in UTF-16, what is not a letter replaced; else as it is."""
    content = mark(content)
    return content.decode("utf-16", "replace").encode("utf-8") if content.startswith(_MARKS) else content


def mark(content: bytes) -> bytes:
    """`content` with the mark of its byte order where it is text in UTF-16 that lacks it; else as it is."""
    head = content[: min(_LOOKED_AT, len(content) // 2 * 2)]
    if not head or head.startswith(_MARKS):
        return content
    for mark, upper, lower in ((_MARKS[0], head[1::2], head[::2]), (_MARKS[1], head[::2], head[1::2])):
        if upper.count(0) >= _SHARE * len(upper) and 0 not in lower:
            return mark + content
    return content


def valid(value: Any) -> Any:
    """`value` of JSON with a replacement character for each code that is none: a byte of a name that is not UTF-8."""
    if isinstance(value, str):
        return _NO_LETTER.sub("\ufffd", value)
    if isinstance(value, Mapping):
        return {valid(name): valid(each) for name, each in value.items()}
    return [valid(each) for each in value] if isinstance(value, (list, tuple)) else value


def whole_number(text: object, most: int) -> int | None:
    """The number from 0 to `most` that `text` writes in decimal digits of ASCII; None where it does not.

    `str.isdigit` also takes superscripts, which `int` does not, and `int` takes signs, underscores and spaces, and
    thousands of digits at a cost that grows with their square.
    """
    if not isinstance(text, str) or not (text.isascii() and text.isdigit()) or len(text) > max(20, len(str(most))):
        return None
    number = int(text)
    return number if number <= most else None


def read_json(
    content: bytes, path: str | os.PathLike[str], member: str, remedy: str = "Export the bundle again"
) -> Any:
    """A JSON value of a stranger: UTF-8, finite numbers, no key twice, no nesting that exhausts the interpreter.

    Raises InputError for anything else, about `member` of `path`, with `remedy`.
    """
    try:
        return json.loads(
            content.decode("utf-8"), parse_constant=_refuse, parse_float=_finite, object_pairs_hook=_without_repeats
        )
    except RecursionError:
        raise InputError(path, f"{member} is nested too deeply", remedy) from None
    except ValueError as error:
        raise InputError(path, f"{member} is not valid JSON ({str(error)[:120]})", remedy) from None


def decode_json(content: bytes, name: str, member: str, remedy: str) -> dict[str, Any]:
    """`read_json` as a decoder: the `value`."""
    return {"value": read_json(content, name, member, remedy)}


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not a number")


def _finite(digits: str) -> float:
    number = float(digits)
    if not math.isfinite(number):
        raise ValueError(f"{digits[:40]} is too large")
    return number


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    value = dict(pairs)
    if len(value) != len(pairs):
        raise ValueError("a key appears twice in one object")
    return value
