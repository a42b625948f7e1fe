"""Kinds of photographs by the suffixes of their files, from the best to the worst for measuring light.

Apart from the readers, because the window asks for suffixes before it loads any of them.
"""

from __future__ import annotations

from pathlib import Path


def _suffixes(names: str) -> frozenset[str]:
    return frozenset(f".{name}" for name in names.split())


#: Suffixes under which LibRaw is tried for what no other reader knows, or for a TIFF.
RAW_SUFFIXES = _suffixes(
    "3fr arw cr2 cr3 crw dcr dng erf fff gpr iiq kdc mef mos mrw nef nrw orf pef raf raw rw2 rwl sr2 srf srw x3f"
)

#: Kinds that can be read, in their order.
_READ = (
    ("RAW", RAW_SUFFIXES),
    ("OpenEXR", _suffixes("exr")),
    ("Radiance", _suffixes("hdr rgbe pic")),
    ("TIFF", _suffixes("tif tiff")),
    ("PNG", _suffixes("png")),
    ("Targa", _suffixes("tga")),
    ("JPEG", _suffixes("jpg jpeg jpe")),
)

PHOTOGRAPH_SUFFIXES = frozenset().union(*(suffixes for _, suffixes in _READ))

#: Suffixes of images that no reader knows: they are named, not passed over.
UNREAD_SUFFIXES = _suffixes("avif bmp gif heic heif jp2 jxl psd ppm pgm webp")

#: Kinds are numbers from 0 up; the last is for what is not a photograph.
KINDS = range(len(_READ) + 1)


def kind_of(path: Path) -> int:
    """The kind of photograph by the file's suffix; the last of `KINDS` for what is none."""
    suffix = path.suffix.lower()
    return next((at for at, (_, suffixes) in enumerate(_READ) if suffix in suffixes), len(_READ))


def kind_name(kind: int) -> str:
    """The name of a kind."""
    return _READ[kind][0] if kind < len(_READ) else "others"
