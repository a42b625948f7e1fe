"""Directories of a TIFF, walked with limits before any library walks them.

A few bytes can make directories follow each other in a circle, or let thousands of tags share the same megabytes;
readers then walk for a minute or for ever. Here every directory is met once, and what its tags hold is counted.
Places outside the file are passed over: cameras leave such behind, and the readers that need them refuse them.
Cost: 1 µs per tag.
"""

from __future__ import annotations

import struct

from engine.core.errors import InputError
from engine.storage.untrusted import AGAIN

#: Most tags of one directory, and directories below one; cameras write some 200 and 10.
TAGS_LIMIT = 4096
BELOW_LIMIT = 100

#: A directory's values lie beside each other: together they are not much more than the file.
_SHARE_LIMIT = 2
_FREE_BYTES = 1 << 16

_SUB_DIRECTORIES, _EXIF, _GPS, _INTEROPERABILITY = 330, 34665, 34853, 40965

#: Bytes of a value, by the type of its tag (TIFF 6.0, section 2; 13 is a directory, 16 to 18 are those of BigTIFF).
TYPE_BYTES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4, 16: 8, 17: 8, 18: 8}


def check_directories(content: bytes, name: str, most: int) -> None:
    """InputError for directories that meet again, are more than `most`, or hold more than can be in the file."""
    order = "<" if content.startswith(b"II") else ">"
    big = content[2:4] in (b"+\0", b"\0+")
    offset = struct.Struct(order + ("Q" if big else "I"))
    size = struct.Struct(order + ("Q" if big else "H"))
    entry = struct.Struct(order + ("HHQQ" if big else "HHII"))
    met: set[int] = set()
    ahead = [_at(offset, content, 8 if big else 4)]
    while ahead:
        place = ahead.pop()
        count = _at(size, content, place)
        start = place + size.size
        if place == 0 or start + count * entry.size > len(content):
            continue
        if place in met or len(met) == most or count > TAGS_LIMIT:
            what = "meet again" if place in met else "or their tags are too many"
            raise InputError(name, f"is a damaged TIFF (its directories {what})", AGAIN)
        met.add(place)
        held_bytes = 0
        for tag, kind, length, value in entry.iter_unpack(content[start : start + count * entry.size]):
            value_bytes = TYPE_BYTES.get(kind, 0) * length
            held_bytes += value_bytes if offset.size < value_bytes <= len(content) else 0
            if tag == _SUB_DIRECTORIES and length > 1 and kind in (4, 13, 16, 18):
                if length > BELOW_LIMIT:
                    raise InputError(name, f"is a damaged TIFF (a directory has {length} below it)", AGAIN)
                below = struct.Struct(order + ("I" if kind in (4, 13) else "Q"))
                ahead += [_at(below, content, value + below.size * index) for index in range(length)]
            elif tag in (_SUB_DIRECTORIES, _EXIF, _GPS, _INTEROPERABILITY) and value != place:
                ahead.append(value)
        if held_bytes > _SHARE_LIMIT * len(content) + _FREE_BYTES:
            raise InputError(name, "is a damaged TIFF (its tags hold more than the file)", AGAIN)
        ahead.append(_at(offset, content, start + count * entry.size))


def _at(number: struct.Struct, content: bytes, place: int) -> int:
    """The number at a place; 0 outside the file."""
    return int(number.unpack_from(content, place)[0]) if 0 < place <= len(content) - number.size else 0
