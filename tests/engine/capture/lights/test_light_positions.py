"""Files of light positions whose names are not those of the photographs, and domes."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.capture.lights.sources import find
from engine.core.errors import InputError
from engine.core.health import Verdict

DIRECTIONS = ("0.8 0 0.6", "0 0.6 0.8", "0 0 1")
ELEVATIONS = [36.8699, 53.1301, 90.0]


def capture(folder: Path, photographs: Any, listed: Any) -> Any:
    """The sources of `photographs` beside an .lp file that lists these names, each with one of `DIRECTIONS`."""
    for name in photographs:
        (folder / name).write_bytes(b"x")
    lines = [f"{name} {direction}" for name, direction in zip(listed, DIRECTIONS, strict=False)]
    (folder / "lights.lp").write_text("\n".join([str(len(lines)), *lines]))
    return find([folder])


@pytest.mark.parametrize(
    ("photographs", "listed", "words", "verdict"),
    [
        (("a.tif", "b.tif", "c.tif"), ("a.jpg", "b.JPG", "C.jpg"), "without their extensions", Verdict.NOTE),
        (("x_1.tif", "x_2.tif", "x_3.tif"), ("dome-01.jpg", "dome-02.jpg", "dome-03.jpg"), "numbers", Verdict.WARNING),
        (
            ("a.tif", "b.tif", "c.tif"),
            ("/d/lamp7.jpg", "lamp3.jpg", "lamp9.jpg"),
            "order of its lines",
            Verdict.WARNING,
        ),
    ],
)
def test_names_that_do_not_fit_are_matched_and_said(
    tmp_path: Path, photographs: Any, listed: Any, words: str, verdict: Verdict
) -> None:
    sources = capture(tmp_path, photographs, listed)
    assert [path.name for path in sources.photographs] == list(photographs)
    assert np.degrees(sources.elevation) == pytest.approx(ELEVATIONS, abs=1e-4)
    (finding,) = [one for one in sources.findings if one.source == "lights.lp"]
    assert words in finding.text
    assert finding.verdict == verdict


def test_numbers_count_before_the_order_of_lines(tmp_path: Path) -> None:
    sources = capture(tmp_path, ("x_1.tif", "x_2.tif", "x_3.tif"), ("d3.jpg", "d1.jpg", "d2.jpg"))
    assert [path.name for path in sources.photographs] == ["x_3.tif", "x_1.tif", "x_2.tif"]


@pytest.mark.parametrize(
    ("photographs", "listed"),
    [
        (("a.tif", "b.tif", "c.tif"), ("a.jpg", "b.jpg", "z.jpg")),
        (("a.tif", "b.tif"), ("x.jpg", "y.jpg", "z.jpg")),
        (("a_1.tif", "a_2.tif", "a_4.tif"), ("a_1.jpg", "a_2.jpg", "a_3.jpg")),
    ],
)
def test_names_that_fit_in_part_are_refused(tmp_path: Path, photographs: Any, listed: Any) -> None:
    with pytest.raises(InputError, match="not there"):
        capture(tmp_path, photographs, listed)


def dome(folder: Path, **parts: Any) -> Any:
    for name in ("p2.jpg", "p10.jpg", "p1.jpg"):
        (folder / name).write_bytes(b"x")
    lamps = [dict(zip("xyz", map(float, line.split()), strict=True)) for line in DIRECTIONS]
    (folder / "ours.dome").write_text(json.dumps({"label": "ours", "directions": lamps, **parts}))
    return find([folder])


def test_a_dome_describes_photographs_in_the_order_of_their_names(tmp_path: Path) -> None:
    near = {"lightConfiguration": "spherical", "domeDiameter": 60, "imageWidth": 20}
    sources = dome(tmp_path, **near)
    assert [path.name for path in sources.photographs] == ["p1.jpg", "p2.jpg", "p10.jpg"]
    assert np.degrees(sources.elevation) == pytest.approx(ELEVATIONS, abs=1e-4)
    assert np.degrees(sources.azimuth[:2]) == pytest.approx([0, 90])
    assert (sources.angle_source, sources.lamp_distance) == ("dome", 1.5)
    assert dome(tmp_path, **{**near, "lightConfiguration": "directional"}).lamp_distance is None
    assert dome(tmp_path, **{**near, "imageWidth": 0}).lamp_distance is None


@pytest.mark.parametrize(
    ("lamps", "words"),
    [
        ([], "no list of directions"),
        ([[0, 0, 1]], "describes 1 lamps, but there are 3"),
        ([[0, 0, 1], [0, 1], [1, 0, 0]], "no x, y and z for lamp 2"),
        ([[0, 0, 1], {"x": "a", "y": 0, "z": 1}, [1, 0, 0]], "no x, y and z for lamp 2"),
        ([[0, 0, 1], [0, 0, 0], [1, 0, 0]], "length 0 for lamp 2"),
        ([[0, 0, 1], [0, 1, -1], [1, 0, 0]], "lamp 2 behind"),
        ([[0, 0, 1], [0, 1e400, 1], [1, 0, 0]], "no x, y and z for lamp 2"),
    ],
)
def test_domes_that_cannot_be_are_refused(tmp_path: Path, lamps: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        dome(tmp_path, directions=lamps)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a.tif 0.8 0 0.6\nb.tif 0 0.6 0.8\nc.tif 0 0 1\n", "does not begin with the number"),
        ("3\na.tif 800 0 600\nb.tif 0 300 400\nc.tif 0 0 1000\n", "holds positions"),
        ("3\na.tif 0.8 0 0.6 0.9\nb.tif 0 0.6 0.8 1.1\nc.tif 0 0 1 1\n", "has a fourth number"),
        ("3\na.tif 80 0 60 0.9\nb.tif 0 60 80 1.1\nc.tif 0 0 100 1\n", "holds positions"),
        ("3\na.tif,0.8,0,0.6\nb.tif,0,0.6,0.8\nc.tif,0,0,1\n", ""),
        ("3\na.tif, 0.8, 0, 0.6\nb.tif, 0, 0.6, 0.8\nc.tif, 0, 0, 1\n", ""),
        ("3\na.tif;0,8;0;0,6\nb.tif;0;0,6;0,8\nc.tif;0;0;1\n", ""),
        ("3\na.tif\t0,8\t0\t0,6\nb.tif\t0\t0,6\t0,8\nc.tif\t0\t0\t1\n", ""),
    ],
)
def test_lists_in_the_forms_of_other_programs_are_read(tmp_path: Path, text: str, said: str) -> None:
    for name in ("a.tif", "b.tif", "c.tif"):
        (tmp_path / name).write_bytes(b"x")
    (tmp_path / "lights.lp").write_text(text)
    sources = find([tmp_path])
    assert [path.name for path in sources.photographs] == ["a.tif", "b.tif", "c.tif"]
    assert np.degrees(sources.elevation) == pytest.approx(ELEVATIONS, abs=1e-4)
    texts = [one.text for one in sources.findings if one.source == "lights.lp"]
    assert any(said in each for each in texts) if said else texts == []


def test_numbers_at_the_end_of_names_are_no_intensities(tmp_path: Path) -> None:
    names = ("photo 1", "photo 2", "photo 3")
    sources = capture(tmp_path, [f"{name}.tif" for name in names], names)
    assert np.degrees(sources.elevation) == pytest.approx(ELEVATIONS, abs=1e-4)
    assert not any("fourth" in one.text for one in sources.findings)


def test_photographs_from_one_direction_are_two_measurements(tmp_path: Path) -> None:
    names = [f"{name}.tif" for name in "abcdef"]
    for name in names:
        (tmp_path / name).write_bytes(b"x")
    lines = [f"{name} {DIRECTIONS[index // 2]}" for index, name in enumerate(names)]
    (tmp_path / "lights.lp").write_text("\n".join(["6", *lines]))
    sources = find([tmp_path])
    assert len(sources.photographs) == 6
    assert any("crossed polarisers" in one.text for one in sources.findings)
    (tmp_path / "f.tif").unlink()
    (tmp_path / "lights.lp").write_text("\n".join(["5", *lines[:5]]))
    assert any("4 photographs share" in one.text for one in find([tmp_path]).findings)
