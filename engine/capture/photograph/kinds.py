"""Kinds of photographs by the suffixes of their files, from the best to the worst for measuring light.

Apart from the readers, because the window asks for suffixes before it loads any of them.
"""

from __future__ import annotations

from pathlib import Path

from engine.storage.readers import readers, suffixes


def _suffixes(names: str) -> frozenset[str]:
    return frozenset(f".{name}" for name in names.split())


#: Suffixes under which LibRaw is tried for what no other reader knows, or for a TIFF.
RAW_SUFFIXES = _suffixes(
    "3fr arw cr2 cr3 crw dcr dng erf fff gpr iiq kdc mef mos mrw nef nrw orf pef raf raw rw2 rwl sr2 srf srw x3f"
)

#: Suffixes of images that no reader of the package knows: they are named, not passed over.
_UNREAD_SUFFIXES = _suffixes("avif bmp gif heic heif jp2 jxl psd ppm pgm webp")


def photograph_suffixes() -> frozenset[str]:
    """The suffixes of photographs that can be read."""
    return RAW_SUFFIXES.union(suffixes("image"))


def unread_suffixes() -> frozenset[str]:
    """The suffixes of images that cannot."""
    return _UNREAD_SUFFIXES - photograph_suffixes()


def kinds() -> range:
    """Numbers of the kinds of photographs from 0 up; the last is for what is not a photograph."""
    return range(len(readers("image")) + 2)


def kind_of(path: Path) -> int:
    """The kind of photograph by the file's suffix; the last of `kinds` for what is none."""
    suffix = path.suffix.lower()
    if suffix in RAW_SUFFIXES:
        return 0
    known = readers("image")
    return next((at for at, each in enumerate(known, 1) if suffix in each.endings), len(known) + 1)


def kind_name(kind: int) -> str:
    """The name of a kind."""
    return ("RAW", *(each.title for each in readers("image")), "others")[kind]
