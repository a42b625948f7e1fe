"""Who made a photograph, and under which terms, as its file says: XMP, IPTC, and EXIF where those say nothing.

A packet of XMP is found by its text wherever a format keeps it, as its specification has programs do that do not know
the format; IPTC lies in a resource of Photoshop. Names are those of `engine.scene.credits`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from xml.etree import ElementTree

from engine.images.exif import Exif

#: Most bytes of a packet of XMP, and of an entry of IPTC.
_PACKET_BYTES, _ENTRY_BYTES = 1 << 20, 2048

_BEGIN, _END = b"<x:xmpmeta", b"</x:xmpmeta>"
_RESOURCE = b"8BIM\x04\x04"

_RDF = "{http://www.w3.org/1999/02/22-rdf-syntax-ns#}"
_DC = "{http://purl.org/dc/elements/1.1/}"
_RIGHTS = "{http://ns.adobe.com/xap/1.0/rights/}"

#: Properties of XMP by entry, the first that says anything counts.
_PROPERTIES: Mapping[str, tuple[str, ...]] = {
    "title": (f"{_DC}title",),
    "author": (f"{_DC}creator",),
    "copyright": (f"{_DC}rights",),
    "source": (f"{_DC}source", "{http://ns.adobe.com/photoshop/1.0/}Source"),
    "licence": ("{http://creativecommons.org/ns#}license", f"{_RIGHTS}UsageTerms", f"{_RIGHTS}WebStatement"),
}

#: Numbers of IPTC in record 2 by entry.
_NUMBERS = {"title": 5, "author": 80, "copyright": 116, "source": 115}

_CREATIVE_COMMONS = re.compile(
    r"https?://(?:www\.)?creativecommons\.org/(licenses|publicdomain)/([a-z+-]{2,20}+)/(\d\.\d)(?:/[a-z./]{0,30}+)?"
)


def read_credits(content: bytes, noted: Exif) -> dict[str, str]:
    """The entries of `Credits` that a photograph states, by name; empty where it states none."""
    said = {"author": noted.artist, "copyright": noted.copyright}
    found = {name: value for name, value in said.items() if value}
    found |= _iptc(content)
    found |= _xmp(content)
    return {name: spdx(text) for name, value in found.items() if (text := " ".join(value.split()))}


def join_credits(photographs: Iterable[Mapping[str, str]]) -> dict[str, str]:
    """The entries of several photographs: the different ones of a name behind each other, but of titles."""
    found: dict[str, dict[str, None]] = {}
    for each in photographs:
        for name, value in each.items():
            found.setdefault(name, {})[value] = None
    return {name: ", ".join(values) for name, values in found.items() if name != "title" or len(values) == 1}


def spdx(text: str) -> str:
    """The SPDX identifier of an address of Creative Commons; any other text as it is.

    >>> spdx("https://creativecommons.org/licenses/by-sa/4.0/")
    'CC-BY-SA-4.0'
    """
    found = _CREATIVE_COMMONS.fullmatch(text)
    if found is None:
        return text
    group, terms, version = found.groups()
    if group == "publicdomain":
        return f"CC0-{version}" if terms == "zero" else text
    return f"CC-{terms.upper()}-{version}"


def _xmp(content: bytes) -> dict[str, str]:
    """Entries of the first packet of XMP; none where it is damaged, or defines entities."""
    begin = content.find(_BEGIN)
    end = content.find(_END, begin, begin + _PACKET_BYTES) if begin >= 0 else -1
    packet = content[begin : end + len(_END)] if end >= 0 else b""
    if not packet or b"<!" in packet:
        return {}
    try:
        root = ElementTree.fromstring(packet)
    except (ElementTree.ParseError, ValueError, LookupError, RecursionError):
        return {}
    descriptions = list(root.iter(f"{_RDF}Description"))
    found = {}
    for entry, names in _PROPERTIES.items():
        said = (_value(each, name) for name in names for each in descriptions)
        if value := next((value for value in said if value), ""):
            found[entry] = value
    return found


def _value(description: ElementTree.Element, name: str) -> str:
    """The text of a property: an attribute, an element, its items, or what it refers to."""
    if (stated := description.get(name)) is not None:
        return stated
    element = description.find(name)
    if element is None:
        return ""
    items = list(element.iter(f"{_RDF}li"))
    if any(each.get("{http://www.w3.org/XML/1998/namespace}lang") for each in items):
        items = items[:1]  # the default language comes first
    said = [each.text or "" for each in items] if items else [element.get(f"{_RDF}resource") or element.text or ""]
    return ", ".join(each for each in said if each.strip())


def _iptc(content: bytes) -> dict[str, str]:
    """Entries of the IPTC of a resource of Photoshop."""
    at = content.find(_RESOURCE)
    if at < 0:
        return {}
    at += len(_RESOURCE)
    name_bytes = content[at] if at < len(content) else 0
    at += name_bytes + 1 + (name_bytes + 1) % 2
    end = at + 4 + int.from_bytes(content[at : at + 4], "big")
    at += 4
    said: dict[int, list[str]] = {}
    while at + 5 <= min(end, len(content)) and content[at] == 0x1C:
        length = int.from_bytes(content[at + 3 : at + 5], "big")
        value = content[at + 5 : at + 5 + length]
        if length > _ENTRY_BYTES or len(value) < length:
            break
        if content[at + 1] == 2:
            said.setdefault(content[at + 2], []).append(_text(value))
        at += 5 + length
    return {entry: ", ".join(said[number]) for entry, number in _NUMBERS.items() if any(said.get(number, ()))}


def _text(value: bytes) -> str:
    try:
        return value.decode("utf-8")
    except UnicodeDecodeError:
        return value.decode("latin-1")
