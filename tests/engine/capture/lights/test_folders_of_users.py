"""Folders as hundreds of users would have them, drawn by seed: names, kinds, sidecars, leftovers, sub-folders.

The capture is drawn first and the folder around it, so that what is to be taken is known. Hypothesis makes what fails
as small as it can be.
"""

from __future__ import annotations

import math
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import given, seed, settings
from hypothesis import strategies as st

from engine.capture.lights.sources import find

NAMES = ("IMG_{:04}", "DSC{:05}", "_MG_{:04}", "P{:07}", "Bild {}", "scan-{:03}", "Übung_{:02}", "a.b_{:03}")
KINDS = (".CR2", ".NEF", ".dng", ".tif", ".TIFF", ".png", ".JPG", ".jpeg", ".jpg", ".TGA")
BESIDE = ("{stem}.xmp", "{name}.xmp", "{stem}.THM", "{name}.pp3", "{name}.dop", "._{name}", "{stem}.AAE", "{name}.md5")
LEFTOVERS = (
    *(".DS_Store", "Thumbs.db", "desktop.ini", "ZbThumbnail.info", "notes.txt", "report.pdf", "capture.log"),
    *("IMG_9999.jpg.part", "IMG_9998.CR2.crdownload", "IMG_9997.jpg.tmp", "~IMG_9996.tmp", ".IMG_9995.jpg.swp"),
    *("IMG_9994.jpg.download/IMG_9994.jpg", "Unconfirmed 12345.crdownload", "IMG_9993.jpg.icloud"),
)
MADE = (
    *("thumbs/IMG_0001.jpg", "Thumbnails/a.png", "@eaDir/IMG_0001.JPG/SYNOPHOTO_THUMB_M.jpg", ".thumbnails/x.jpg"),
    *("previews/a.jpg", "Catalog.lrdata/p.jpg", "CaptureOne/Cache/a.jpg", "__MACOSX/._IMG_0001.JPG"),
)
PLACES = ("", "", "", "DCIM/", "DCIM/100CANON/", "jpeg-exports/", "Photos of the day/")
LISTS = ("", "", "lights.lp", "dome.LP")


@dataclass(frozen=True)
class Folder:
    """Files of a folder by name, those of the capture, and where the angles come from."""

    files: dict[str, str]
    taken: frozenset[str]
    angle_source: str


@st.composite
def folders(draw: st.DrawFn) -> Folder:
    pattern, first = draw(st.sampled_from(NAMES)), draw(st.integers(1, 900))
    stems = [pattern.format(first + at) for at in range(draw(st.integers(2, 9)))]
    kinds = draw(st.lists(st.sampled_from(KINDS), min_size=1, max_size=3, unique_by=str.lower))
    best = min(kinds, key=rank)
    place = draw(st.sampled_from(PLACES))
    names = {f"{place}{stem}{kind}" for stem in stems for kind in kinds}
    beside = draw(st.lists(st.sampled_from(BESIDE), max_size=3, unique=True))
    names |= {
        f"{place}{each.format(stem=stem, name=stem + kind)}" for each in beside for stem in stems for kind in kinds
    }
    names |= {f"{place}{each}" for each in draw(st.lists(st.sampled_from(LEFTOVERS), max_size=4, unique=True))}
    names |= set(draw(st.lists(st.sampled_from(MADE), max_size=3, unique=True)))
    files = {name: name for name in names}
    if lights := draw(st.sampled_from(LISTS)):
        listed = draw(st.sampled_from((best, ".jpg", "")))
        before = draw(st.sampled_from(("", "C:\\rti\\jpeg-exports\\", "/captures/felt/")))
        lines = [
            f"{before}{stem}{listed} {math.cos(0.1 * at)} 0 {math.sin(0.1 * at)}" for at, stem in enumerate(stems, 1)
        ]
        files[place + lights] = "\n".join([str(len(stems)), *lines])
    return Folder(files, frozenset(f"{stem}{best}" for stem in stems), "lp" if lights else "assumed")


def rank(kind: str) -> int:
    """RAW before TIFF before PNG before Targa before JPEG, and what a camera writes before DNG."""
    return (".cr2", ".nef", ".dng", ".tif", ".tiff", ".png", ".tga", ".jpeg", ".jpg").index(kind.lower())


def holds(folder: Folder, place: Path) -> None:
    for name, content in folder.files.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(content)
    sources = find([place])
    assert {path.name for path in sources.photographs} == folder.taken
    assert sources.angle_source == folder.angle_source


@settings(max_examples=100, deadline=None, derandomize=True)
@given(folders())
def test_what_belongs_to_the_capture_is_taken(tmp_path_factory: pytest.TempPathFactory, folder: Folder) -> None:
    place = tmp_path_factory.mktemp("folder")
    holds(folder, place)
    shutil.rmtree(place)


@pytest.mark.long
@pytest.mark.parametrize("number", range(4))
def test_what_belongs_to_the_capture_is_taken_from_many(tmp_path_factory: pytest.TempPathFactory, number: int) -> None:
    @seed(number)
    @settings(max_examples=500, deadline=None, database=None)
    @given(folders())
    def law(folder: Folder) -> None:
        place = tmp_path_factory.mktemp("folder")
        holds(folder, place)
        shutil.rmtree(place)

    law()
