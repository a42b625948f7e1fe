"""Text of strangers: whole numbers, and text in UTF-16, which Windows programs call "Unicode", as UTF-8.

UTF-16 is known by its mark, or without one by its zeros: no letter of the file formats here needs its upper byte, and
no text in UTF-8 or Latin-1 holds a byte of 0. Cost: linear, about 10 ns for each letter.
"""

from __future__ import annotations

from typing import Any

_MARKS = (b"\xff\xfe", b"\xfe\xff")

#: Bytes that are looked at, and the share of letters among them whose upper byte must be 0.
_LOOKED_AT, _SHARE = 512, 0.75


def utf8(content: bytes) -> bytes:
    """`content` in UTF-8 without a mark where it is text in UTF-16, what is no letter replaced; else as it is."""
    content = marked(content)
    return content.decode("utf-16", "replace").encode("utf-8") if content.startswith(_MARKS) else content


def marked(content: bytes) -> bytes:
    """`content` with the mark of its byte order where it is text in UTF-16 that lacks it; else as it is."""
    head = content[: min(_LOOKED_AT, len(content) // 2 * 2)]
    if not head or head.startswith(_MARKS):
        return content
    for mark, upper, lower in ((_MARKS[0], head[1::2], head[::2]), (_MARKS[1], head[::2], head[1::2])):
        if upper.count(0) >= _SHARE * len(upper) and 0 not in lower:
            return mark + content
    return content


def whole_number(text: Any, most: int) -> int | None:
    """The number from 0 to `most` that `text` writes in decimal digits of ASCII; None where it does not.

    `str.isdigit` also takes superscripts, which `int` does not, and `int` takes signs, underscores and spaces, and
    thousands of digits at a cost that grows with their square.
    """
    if not isinstance(text, str) or not (text.isascii() and text.isdigit()) or len(text) > max(20, len(str(most))):
        return None
    number = int(text)
    return number if number <= most else None
