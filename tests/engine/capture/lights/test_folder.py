"""Folders as users keep them: one photograph of each shot, and a reason for each file that is left out."""

import math
import zipfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.capture.lights.folder import one_of_each_shot
from engine.capture.lights.sources import find, find_packed
from engine.core.errors import InputError
from engine.core.health import Verdict
from engine.core.steps import drain

SHOTS = [f"IMG_{number:04}" for number in range(12, 20)]
LP = "8\n" + "".join(
    f"C:\\ring\\jpeg-exports\\{shot}.jpg {math.cos(0.15 * at)} 0 {math.sin(0.15 * at)}\n"
    for at, shot in enumerate(SHOTS, 1)
)


def make(place: Path, *names: str) -> Path:
    for name in names:
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_bytes(name.encode())
    return place


def take_marks(sources: Any) -> list[str]:
    return sorted(path.name for path in sources.photographs)


def describe(sources: Any) -> str:
    return " | ".join(finding.text for finding in sources.findings)


def test_raw_is_taken_where_jpegs_lie_beside_it(tmp_path: Path) -> None:
    place = make(tmp_path, *(f"{shot}.{kind}" for shot in SHOTS for kind in ("CR2", "JPG", "CR2.xmp", "THM")))
    sources = find([place])
    assert take_marks(sources) == [f"{shot}.CR2" for shot in SHOTS]
    assert "RAW was taken, not: IMG_0012.JPG" in describe(sources)
    assert take_marks(find(sorted(place.iterdir()))) == take_marks(
        sources
    )  # as where all files are dragged into the window


def test_the_kind_that_holds_every_shot_goes_before_a_better_one(tmp_path: Path) -> None:
    place = make(tmp_path, *(f"{shot}.jpg" for shot in SHOTS), *(f"{shot}.nef" for shot in SHOTS[1:]))
    assert take_marks(find([place])) == [f"{shot}.jpg" for shot in SHOTS]
    mixed = find([make(tmp_path, "IMG_0020.nef", "IMG_0021.nef")])
    assert take_marks(mixed) == [f"{SHOTS[0]}.jpg", *(f"{shot}.nef" for shot in (*SHOTS[1:], "IMG_0020", "IMG_0021"))]
    assert any(one.verdict == Verdict.WARNING and "are mixed" in one.text for one in mixed.findings)


def test_what_capture_toml_names_is_taken(tmp_path: Path) -> None:
    place = make(tmp_path, *(f"{shot}.{kind}" for shot in SHOTS[:2] for kind in ("tif", "jpg")))
    entries = [
        f'[[photographs]]\nfile = "{shot}.jpg"\nelevation_deg = {at + 1}0\n' for at, shot in enumerate(SHOTS[:2])
    ]
    (place / "capture.toml").write_text("".join(entries))
    assert take_marks(find([place])) == ["IMG_0012.jpg", "IMG_0013.jpg"]


def test_copies_go_only_where_every_byte_is_equal(tmp_path: Path) -> None:
    place = make(tmp_path, "a_10deg.png", "b_20deg.png", "b_20deg (1).png", "c_30deg.png")
    with pytest.raises(InputError, match=r"are said to be lit from the same direction: elevation 20°"):
        find([place])
    (place / "b_20deg (1).png").write_bytes((place / "b_20deg.png").read_bytes())
    sources = find([place])
    assert take_marks(sources) == ["a_10deg.png", "b_20deg.png", "c_30deg.png"]
    assert "equal in every byte, were excluded: b_20deg (1).png" in describe(sources)


def test_a_rule_that_leaves_nothing_is_no_rule(tmp_path: Path) -> None:
    assert take_marks(find([make(tmp_path, "preview_10.png", "preview_50.png")])) == [
        "preview_10.png",
        "preview_50.png",
    ]


def project(place: Path) -> Path:
    """The folder of a capture as RTIBuilder makes it."""
    make(place, *(f"jpeg-exports/{shot}.jpg" for shot in SHOTS), *(f"original-captures/{shot}.CR2" for shot in SHOTS))
    make(place, "assembly-files/ring.xml", "cropped-files/IMG_0012.jpg", "finished-files/ring.ptm", "notes.txt")
    (place / "assembly-files" / "ring.lp").write_text(LP)
    return place


def test_folders_of_rtibuilder_are_looked_into(tmp_path: Path) -> None:
    sources = find([project(tmp_path / "ring")])
    assert take_marks(sources) == [f"{shot}.jpg" for shot in SHOTS]
    assert (sources.angle_source, sources.name) == ("lp", "ring")
    assert "taken from jpeg-exports, light positions from ring.lp" in describe(sources)
    archive = tmp_path / "ring.zip"
    with zipfile.ZipFile(archive, "w") as packed:
        for path in sorted((tmp_path / "ring").rglob("*.*")):
            packed.write(path, path.relative_to(tmp_path))
    unpacked = drain(find_packed([archive], scratch=tmp_path))
    assert (take_marks(unpacked), unpacked.angle_source) == (take_marks(sources), "lp")


def test_one_folder_inside_is_looked_into_and_several_are_named(tmp_path: Path) -> None:
    place = make(tmp_path, "DCIM/a_10deg.jpg", "DCIM/b_20deg.jpg", "Thumbnails/a.jpg", "darktable_exported/a.jpg")
    assert take_marks(find([place])) == ["a_10deg.jpg", "b_20deg.jpg"]
    make(place, "second/a.jpg")
    with pytest.raises(InputError, match=r"its folders DCIM, second do. Give the folder of one capture"):
        find([place])


FORMS = st.sampled_from(["{}.CR2", "{}.JPG", "{}.tif", "{}-Edit.tif", "{}_thumb.jpg", "{} (1).JPG"])


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 9), FORMS), min_size=1, max_size=40, unique=True), st.data())
def test_every_shot_is_taken_once_and_every_other_file_is_said(files: Any, data: Any) -> None:
    """Folders that nobody made by hand: nothing vanishes without a word, and the order of files decides nothing."""
    paths = [Path(form.format(f"DSC_{number:04}")) for number, form in files]
    chosen, findings = one_of_each_shot(paths, set())
    shots = [path.name.split(".")[0] for path in chosen]
    assert len(set(shots)) == len(shots)
    assert len(chosen) + sum(_count_named(finding.text) for finding in findings) == len(paths)
    plain = {path.name.split(".")[0] for path in paths if path.stem.isascii() and len(path.name.split(".")[0]) == 8}
    assert plain <= set(shots)  # a shot that lies there under its own name is in the capture
    shuffled, _ = one_of_each_shot(data.draw(st.permutations(paths)), set())
    assert set(shuffled) == set(chosen)


def _count_named(text: str) -> int:
    """Files that a finding names, of which it counts those after the fifth."""
    if "are mixed" in text:
        return 0
    listing = text.rsplit(": ", 1)[1]
    names, _, more = listing.partition(" and ")
    return len(names.split(", ")) + (int(more.split()[0]) if more else 0)
