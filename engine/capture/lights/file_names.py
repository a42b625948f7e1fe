"""File names of photographs: comparison, order, and the angles that they state.

Elevations of the light from file names: woven_10deg.tif, img-elev-35.5.png, suede_10 … suede_90.

A number with a word (elev, elevation, angle, el before it; deg, degrees, ° after it) is an angle. A bare number is
one only where all names agree but for that number, and the numbers are not a plain count: 1, 2, 3 … are a sequence.
"""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Sequence
from pathlib import Path


def comparable(name: str) -> str:
    """A file name in the spelling in which names are compared: systems store accents composed or decomposed."""
    return unicodedata.normalize("NFC", re.split(r"[/\\]", name)[-1])


def stem_of(path: Path) -> str:
    """A file name without its extension, as `comparable` has it and in small letters."""
    return Path(comparable(path.name)).stem.casefold()


def stem_name(name: str) -> str:
    """The name without its extension, in small letters: RAW files are often listed as the JPEG that was made."""
    return re.sub(r"\.[a-z0-9]{1,5}$", "", comparable(name).casefold())


def number_of(name: str) -> int | None:
    """The last number in a name; None without one."""
    numbers: list[str] = re.findall(r"\d{1,18}", stem_name(name))
    return int(numbers[-1]) if numbers else None


def join_names(names: Sequence[str], limit: int = 5) -> str:
    """The names with commas, the first few of many."""
    more = f" and {len(names) - limit} more" if len(names) > limit else ""
    return ", ".join(names[:limit]) + more


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
    """The only number in which all names differ, where it can be an angle in degrees and is not a plain count."""
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


def printable(path: Path) -> str:
    """The file name as text that can be stored: bytes that are not UTF-8 become replacement characters."""
    return as_text(path.name)


def as_text(name: str) -> str:
    """A name with replacement characters for bytes that are not UTF-8."""
    return os.fsencode(name).decode("utf-8", "replace")
