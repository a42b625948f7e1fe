"""Who made a photograph, from EXIF, XMP and IPTC of files that are written here byte by byte."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile

from engine.capture.photograph.decode import read_photograph
from engine.images.credits import join_credits, spdx

PACKET = """<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
<rdf:Description xmlns:dc="http://purl.org/dc/elements/1.1/" xmlns:xmpRights="http://ns.adobe.com/xap/1.0/rights/"
 xmlns:photoshop="http://ns.adobe.com/photoshop/1.0/" photoshop:Source="Museum 4711"
 xmpRights:WebStatement="https://creativecommons.org/licenses/by/4.0/">
<dc:creator><rdf:Seq><rdf:li>Zoë Ng</rdf:li><rdf:li>A. Li</rdf:li></rdf:Seq></dc:creator>
<dc:rights><rdf:Alt><rdf:li xml:lang="x-default">© 2026 Zoë</rdf:li><rdf:li xml:lang="de">anders</rdf:li></rdf:Alt>
</dc:rights></rdf:Description></rdf:RDF></x:xmpmeta>"""


def segment(marker: int, body: bytes) -> bytes:
    return struct.pack(">BBH", 0xFF, marker, len(body) + 2) + body


def xmp(packet: str) -> bytes:
    return segment(0xE1, b"http://ns.adobe.com/xap/1.0/\0" + packet.encode())


def exif(artist: bytes, copyright: bytes) -> bytes:
    texts = [artist + b"\0", copyright + b"\0"]
    entries, data = b"", b""
    for tag, said in zip((0x013B, 0x8298), texts, strict=True):
        place = 8 + 2 + 24 + 4 + len(data)
        entries += struct.pack("<HHII", tag, 2, len(said), place)
        data += said
    tiff = b"II*\0\x08\0\0\0" + struct.pack("<H", 2) + entries + b"\0\0\0\0" + data
    return segment(0xE1, b"Exif\0\0" + tiff)


def iptc(**said: bytes) -> bytes:
    numbers = {"title": 5, "author": 80, "copyright": 116, "source": 115}
    body = b"".join(struct.pack(">BBBH", 0x1C, 2, numbers[name], len(text)) + text for name, text in said.items())
    return segment(0xED, b"Photoshop 3.0\0" + b"8BIM\x04\x04\0\0" + struct.pack(">I", len(body)) + body)


def photograph(folder: Path, *segments: bytes) -> Path:
    content = cv2.imencode(".jpg", np.full((8, 8, 3), 90, np.uint8))[1].tobytes()
    path = folder / "a.jpg"
    path.write_bytes(content[:2] + b"".join(segments) + content[2:])
    return path


FULL = {
    "author": "Zoë Ng, A. Li",
    "copyright": "© 2026 Zoë",
    "source": "Museum 4711",
    "licence": "CC-BY-4.0",
}


@pytest.mark.parametrize(
    ("segments", "wanted"),
    [
        ((exif(b"Ada Ng", b"(c) Ada "),), {"author": "Ada Ng", "copyright": "(c) Ada"}),
        ((xmp(PACKET),), FULL),
        (
            (exif(b"Ada Ng", b"(c) Ada "), iptc(title=b"Bowl", author="Zoë".encode("latin-1")), xmp(PACKET)),
            {**FULL, "title": "Bowl"},
        ),
        ((iptc(author=b"B", copyright=b"C", source=b"D"),), {"author": "B", "copyright": "C", "source": "D"}),
        ((), {}),
    ],
)
def test_what_a_photograph_states_is_read(tmp_path: Path, segments: tuple[bytes, ...], wanted: dict[str, str]) -> None:
    assert dict(read_photograph(photograph(tmp_path, *segments)).credits) == wanted


@pytest.mark.parametrize(
    "packet",
    [
        PACKET[:400],
        PACKET.replace("</rdf:RDF>", ""),
        '<x:xmpmeta><!DOCTYPE a [<!ENTITY b "c">]></x:xmpmeta>',
        "<x:xmpmeta " + "<a>" * 5000 + "</x:xmpmeta>",
    ],
)
def test_damaged_words_cost_no_photograph(tmp_path: Path, packet: str) -> None:
    cut = segment(0xED, b"Photoshop 3.0\0" + b"8BIM\x04\x04\0\0\0\0\xff\xff\x1c\x02\x50\xff")
    assert not read_photograph(photograph(tmp_path, cut, xmp(packet))).credits


def test_words_among_the_samples_of_a_tiff_are_none_of_its_author(tmp_path: Path) -> None:
    path, packet = tmp_path / "a.tif", PACKET.encode()
    false = PACKET.replace("Zoë", "Eve").encode().ljust(1200)
    samples = np.frombuffer(false[:1200], np.uint8).reshape(20, 20, 3)
    tifffile.imwrite(path, samples, photometric="rgb", extratags=[(700, 1, len(packet), packet)])
    assert path.read_bytes().find(false) >= 0
    assert dict(read_photograph(path).credits) == FULL


def test_several_photographs_state_together() -> None:
    said = [{"author": "A", "title": "one"}, {"author": "B", "title": "two"}, {"author": "A"}]
    assert join_credits(said) == {"author": "A, B"}
    assert spdx("http://creativecommons.org/publicdomain/zero/1.0/") == "CC0-1.0"
    assert spdx("https://example.org/licenses/by/4.0/") == "https://example.org/licenses/by/4.0/"
