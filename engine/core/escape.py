"""Names and messages as a terminal, a log and a window can show them.

File names come from anybody: they may hold bytes that are not UTF-8, line breaks, sequences that drive a terminal, and
marks that turn the direction of writing, so that `exe.gpj` reads as `jpg.exe`.
"""

from __future__ import annotations

import unicodedata

#: Joiners, which Persian and Indian names and emoji need.
_JOINERS = "\u200c\u200d"


def escape_controls(text: str) -> str:
    r"""Return `text` on one line, with control characters, direction marks and bytes that are not UTF-8 escaped.

    Parameters
    ----------
    text : any text; bytes that are not UTF-8 are lone surrogates in it, as `os.fsdecode` makes them.

    Returns
    -------
    The same text where all of it can be shown, else with escapes such as ``\x1b``, ``\n``, ``\u202e`` and ``\xe9``.
    """
    return text if text.isprintable() else "".join(map(_escape, text))


def _escape(letter: str) -> str:
    if letter.isprintable() or letter in _JOINERS or unicodedata.category(letter) == "Zs":
        return letter
    if "\udc80" <= letter <= "\udcff":  # a byte of a file name
        return f"\\x{ord(letter) - 0xDC00:02x}"
    return letter.encode("unicode_escape").decode("ascii")
