"""Photographs of a capture, and their light positions: never guessed, always stated."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.capture.lights import capture_file, light_positions
from engine.capture.lights.azimuth_spread import azimuth_spread
from engine.capture.lights.file_names import angles_with_words, bare_angles
from engine.capture.lights.light_positions import read_light_positions
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.lights.sources import find
from engine.capture.photograph.exposures import Exposure, Noted, exposure_scale
from engine.core.errors import InputError
from engine.core.health import Verdict
from tests.present import present


@pytest.fixture
def folder(tmp_path: Path) -> Callable[..., Any]:
    """Makes a folder of files that hold one byte each, or the text given."""

    def make(*names: str, **texts: Any) -> Path:
        for name in names:
            (tmp_path / name).write_bytes(b"x")
        for name, text in texts.items():
            (tmp_path / name.replace("__", ".")).write_text(text, encoding="utf-8")
        return tmp_path

    return make


def names(sources: Any) -> list[Any]:
    return [path.name for path in sources.photographs]


def test_capture_toml_before_light_positions_before_names(folder: Callable[..., Any]) -> None:
    place = folder(
        "a_70deg.png",
        "b_80deg.png",
        lights__lp="2\na_70deg.png 0.6 0 0.8\nb_80deg.png 0.8 0 0.6\n",
        capture__toml='transfer = "linear"\n[[photographs]]\nfile = "a_70deg.png"\nelevation_deg = 30.0\n'
        'exposure_s = 0.5\n[[photographs]]\nfile = "b_80deg.png"\nelevation_deg = 20\n',
    )
    sources = find([place])
    assert (names(sources), sources.angle_source) == (["b_80deg.png", "a_70deg.png"], "capture.toml")
    assert np.degrees(sources.elevation) == pytest.approx([20, 30])
    assert (sources.exposure_s, sources.transfer, sources.azimuth) == ((None, 0.5), "linear", None)
    (place / "capture.toml").unlink()
    sources = find([place])
    assert sources.angle_source == "lp"
    assert np.degrees(sources.elevation) == pytest.approx([36.8699, 53.1301], abs=1e-4)
    (place / "lights.lp").unlink()
    assert find([place]).angle_source == "file names"
    assert find([place], [5.0, 6.0]).angle_source == "user"


@pytest.mark.parametrize(
    ("stems", "expected"),
    [
        (["woven_10deg", "woven_5.5deg"], [10, 5.5]),
        (["img-elev-35.5", "img-elev-7,25"], [35.5, 7.25]),
        (["Elevation 30 x2", "007_angle=40"], [30, 40]),
        (["10°", "20 degrees"], [10, 20]),
        (["model30", "10degas"], [None, None]),
        (["el10_elev20", "x"], [None, None]),
    ],
)
def test_fault_11_angles_with_words(stems: Any, expected: Any) -> None:
    assert angles_with_words(stems) == expected


@pytest.mark.parametrize(
    ("stems", "expected"),
    [
        (["suede_10", "suede_30", "suede_90"], [10, 30, 90]),
        (["x_0001_10", "x_0001_40"], [10, 40]),
        (["im1", "im2", "im3"], None),
        ([f"{n:04}" for n in range(64)], None),
        (["img1", "img2", "img3", "img5", "img40"], [1, 2, 3, 5, 40]),
        (["IMG_4711", "IMG_4721"], None),
        (["a_10", "b_20"], None),
        (["10_20", "40_50"], None),
    ],
)
def test_fault_11_bare_numbers_are_angles_only_without_doubt(stems: Any, expected: Any) -> None:
    assert bare_angles(stems) == expected


def test_fault_11_no_angles_are_assumed_evenly_and_marked(folder: Callable[..., Any]) -> None:
    sources = find([folder(*(f"im{n}.png" for n in range(1, 13)))])
    assert sources.angle_source == "assumed"
    assert names(sources)[-3:] == ["im10.png", "im11.png", "im12.png"]
    assert np.degrees(sources.elevation) == pytest.approx(7.5 * np.arange(1, 13))
    assert [finding.verdict for finding in sources.findings] == [Verdict.WARNING]
    assert "assumed" in sources.findings[0].text


def test_fault_11_angles_from_names_are_shown_for_confirmation(folder: Callable[..., Any]) -> None:
    (finding,) = find([folder("a_10.png", "a_50.png")]).findings
    assert finding.verdict == Verdict.WARNING
    assert "10°, 50°" in finding.text


@pytest.mark.parametrize(
    ("files", "angles", "words"),
    [
        (["a_10deg.png"], None, "one photograph only (a_10deg.png)"),
        ([], None, "no photographs"),
        (["a_10deg.png", "b_20deg.png", "c.png"], None, "c.png has no angle"),
        (
            ["a_10deg.png", "b_10deg.tif"],
            None,
            "a_10deg.png and b_10deg.tif are said to be lit from the same direction: elevation 10°",
        ),
        (["a_10deg.png", "b_120deg.png"], None, "120° is outside"),
        (["a.png", "b.png"], [10.0], "2 photographs, but 1 angles"),
        (["a.png", "b.png"], [10.0, float("nan")], "nan° is outside"),
        (["a.png", "b.png"], [10.0, -1.0], "-1° is outside"),
    ],
)
def test_fault_10_and_11_what_does_not_fit_is_named(
    folder: Callable[..., Any], files: Any, angles: Any, words: str
) -> None:
    with pytest.raises(InputError) as refusal:
        find([folder(*files)], angles)
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("3\na.png 1 0 0\nb.png 0 0 1\n", "line 1 announces 3 lights, but 2 follow"),
        ("2\na.png,0,6,0,0,8\nb.png,0,0,1\n", "line 2 has commas between numbers and in them"),
        ("2\na.png 0 0 0\nb.png 0 0 1\n", "line 2 has a light at the distance 0"),
        ("2\na.png 0 0 1\n\nb.png 3 0 4e10\n", "line 4 has a light at the distance 4e+10"),
        ("2\na.png 0 0 1\nb.png nan 0 1\n", "line 3 should hold a name and three numbers"),
        ("2\na.png 0 0 1\nb.png 0.6 0 -0.8\n", "line 3 has a light behind"),
        ("2\na.png 0 0 1\nb.png 0 1\n", "line 3 should hold a name"),
        ("2\na.png 0 0 1\nb.png x y z\n", "line 3 should hold a name and three numbers"),
        ("2\na.png 0 0 1\na.png 0.6 0 0.8\n", "line 3 names a.png, as line 2 does"),
        ("2\na.png 0 0 1\nc.png 0.6 0 0.8\n", "not there: line 3 (c.png)"),
        ("1\na.png 0 0 1\n", "does not mention b.png"),
        ("a.png 0 0 1\n", "does not mention b.png"),
        ("\0\0\0", "line 1 should hold a name and three numbers"),
        ("\n \n", "line 1 should hold the number"),
    ],
)
def test_fault_11_light_positions_are_reported_by_line(folder: Callable[..., Any], text: str, words: str) -> None:
    with pytest.raises(InputError) as refusal:
        find([folder("a.png", "b.png", lights__lp=text)])
    assert words in str(refusal.value)
    assert "lights.lp" in str(refusal.value)


def test_light_positions_with_spaces_paths_and_bom(folder: Callable[..., Any]) -> None:
    place = folder(lights__lp="\ufeff2\nC:\\shots\\my sample 1.jpg 0 0.6 0.8\r\n/home/x/b.jpg -0.8 0 0.6\r\n")
    one, other = read_light_positions(place / "lights.lp").lights
    assert (one.name, other.line) == ("C:\\shots\\my sample 1.jpg", 3)
    assert np.degrees([one.elevation, one.azimuth]) == pytest.approx([53.1301, 90.0], abs=1e-4)
    assert np.degrees([other.elevation, other.azimuth]) == pytest.approx([36.8699, 180.0], abs=1e-4)


def test_descriptions_are_read_in_the_decoder_process(
    folder: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Spec 15, S16: what a stranger wrote is taken apart where nothing else can be reached, and comes back whole."""
    capture = (
        'lamp_distance = 1.1\n[[photographs]]\nfile = "é.png"\nhighlight_px = [0.1, 2]\n[simulation]\nx = 2020-01-02'
    )
    place = folder(lights__lp="1\na.jpg 0 0.6 0.8", capture__toml=capture)
    (place / "pointer.lp").write_text("version https://git-lfs.github.com/spec/v1\n")
    for module in (capture_file, light_positions):
        monkeypatch.setattr(module, "read_bytes", lambda path, _: pytest.fail(f"{path} was read in this process"))
    assert light_positions.read_light_positions(place / "lights.lp").lights[0].name == "a.jpg"
    found = capture_file.read_capture_file(place / "capture.toml")
    assert (found.lamp_distance, found.simulation) == (1.1, {"x": "2020-01-02"})
    assert found.photographs[0].highlight_px == (0.1, 2.0)
    with pytest.raises(InputError, match="is a git-lfs pointer") as caught:
        light_positions.read_light_positions(place / "pointer.lp")
    assert caught.value.path == str(place / "pointer.lp")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("photographs = 3", "photographs"),
        ('[[photographs]]\nfile = "a.png"\nelevation_degree = 3.0', "elevation_deg"),
        ('[[photographs]]\nfile = "a.png"\nelevation_deg = nan', "photographs.0.elevation_deg"),
        ('[[photographs]]\nfile = "a.png"\nelevation_deg = 91', "photographs.0.elevation_deg"),
        ("a = ", "not valid TOML"),
        ("x = " + "[" * 5000, "not valid TOML"),
    ],
)
def test_fault_9_wrong_capture_files_name_the_key(folder: Callable[..., Any], text: Any, words: str) -> None:
    with pytest.raises(InputError) as refusal:
        find([folder("a.png", "b.png", capture__toml=text)])
    assert words in str(refusal.value)


def test_what_is_no_photograph_is_set_aside_and_said(folder: Callable[..., Any]) -> None:
    place = folder(
        "a_10deg.png", "b_20deg.png", "._a_10deg.png", ".hidden.png", "Thumbs.db", "readme.txt", "flat.tif",
        "dark-frame_01.tif", "mask.png", "c.heic", "dark_leather_30deg.png",
    )  # fmt: skip
    sources = find([place])
    assert names(sources) == ["a_10deg.png", "b_20deg.png", "dark_leather_30deg.png"]
    said = {finding.source: finding.text for finding in sources.findings if finding.source}
    assert set(said) == {"flat.tif", "dark-frame_01.tif", "mask.png", "c.heic"}
    assert "white reference" in said["flat.tif"]


def test_fault_12_only_regular_files(folder: Callable[..., Any], tmp_path: Path) -> None:
    place = folder("a_10deg.png", "b_20deg.png")
    os.mkfifo(tmp_path / "c_30deg.png")
    with pytest.raises(InputError, match="is not a regular file"):
        find([place])
    (tmp_path / "c_30deg.png").unlink()
    (tmp_path / "c_30deg.png").symlink_to("c_30deg.png")
    with pytest.raises(InputError, match="cannot be read"):
        find([place])


def test_fault_12_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        find([tmp_path / "nowhere"])


@pytest.mark.parametrize("name", ["nosuch", "nosuch.zip", "nosuch.jpg"])
def test_fault_12_a_path_to_nothing_is_said_to_be_one(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match="No such file"):
        find([tmp_path / name])


def test_fault_13_odd_names(tmp_path: Path) -> None:
    stems = ("e\u0301 10deg", "日本 20deg", "a'\"%\n 30deg", "😀 40deg", "x. 50deg.", "n" * 240 + "60deg")
    for stem in stems:
        (tmp_path / f"{stem}.png").write_bytes(b"x")
    (tmp_path / os.fsdecode(b"\xff\xfe 70deg.png")).write_bytes(b"x")
    assert np.degrees(find([tmp_path]).elevation) == pytest.approx([10, 20, 30, 40, 50, 60, 70])


def test_composed_and_decomposed_names_are_one(folder: Callable[..., Any]) -> None:
    place = folder("cafe\u0301.png", "b.png", lights__lp="2\ncaf\u00e9.png 0 0 1\nb.png 0.6 0 0.8\n")
    assert len(find([place]).photographs) == 2


def test_a_file_given_twice_counts_once(folder: Callable[..., Any]) -> None:
    place = folder("a_10deg.png", "b_20deg.png")
    assert len(find([place / "a_10deg.png", place / "b_20deg.png", place]).photographs) == 2


def test_azimuth_spread_wraps() -> None:
    assert azimuth_spread(np.radians([350.0, 5.0, 10.0])) == pytest.approx(np.radians(20.0))
    assert azimuth_spread(None) == 0.0


def test_rti_stack_uses_elevations_and_says_how_far_its_lights_spread(shared_data: Callable[[str], Path]) -> None:
    sources = find([shared_data("stacks/ring_rti64")])
    assert len(sources.photographs) == 64
    assert sources.angle_source == "lp"
    assert np.degrees(sources.elevation[[0, -1]]) == pytest.approx([10.2, 77.5], abs=0.1)
    assert (np.diff(sources.elevation) >= 0).all()
    assert any("339° of azimuth" in finding.text for finding in sources.findings)


def toml(*photographs: str, head: str = "") -> str:
    return head + "".join(f"\n[[photographs]]\n{text}\n" for text in photographs)


def entry(name: str, elevation_deg: float, more: str = "") -> str:
    return f'file = "{name}"\nelevation_deg = {elevation_deg}\n{more}'


def test_exposures_of_one_light_belong_together(folder: Callable[..., Any]) -> None:
    taken = (("a", 20, 0.5), ("b", 20, 0.125), ("c", 60, 0.125), ("d", 60, 0.5))
    entries = [entry(f"{name}.png", angle, f"exposure_s = {time_s}") for name, angle, time_s in taken]
    sources = find([folder("a.png", "b.png", "c.png", "d.png", capture__toml=toml(*entries))])
    assert names(sources) == ["b.png", "c.png"]
    assert sources.exposure_s == (0.125, 0.125)
    assert [[(one.path.name, one.exposure_s) for one in light] for light in sources.exposures] == [
        [("b.png", 0.125), ("a.png", 0.5)],
        [("c.png", 0.125), ("d.png", 0.5)],
    ]


def test_exposures_of_one_light_are_distinguished_by_what_the_camera_noted(tmp_path: Path, dng: Any) -> None:
    mosaic = np.full((16, 16), 500, np.uint16)
    for name, exposure in (("a_20deg", (1, 10)), ("b_20deg", (1, 40)), ("c_60deg", (1, 10))):
        (tmp_path / f"{name}.dng").write_bytes(dng(mosaic, exposure=exposure))
    sources = find([tmp_path])
    assert [[one.exposure_s for one in light] for light in sources.exposures] == [[0.025, 0.1], [None]]
    (tmp_path / "d_60deg.dng").write_bytes(dng(mosaic, exposure=(1, 10)))
    with pytest.raises(
        InputError, match=r"c_60deg.dng and d_60deg.dng are said to be lit from the same direction: elevation 60°"
    ):
        find([tmp_path])


def test_one_light_alone_is_no_capture(folder: Callable[..., Any]) -> None:
    entries = [entry("a.png", 20, "exposure_s = 1.0"), entry("b.png", 20, "exposure_s = 2.0")]
    with pytest.raises(InputError, match="2 exposures of one light only"):
        find([folder("a.png", "b.png", capture__toml=toml(*entries))])


def test_calibration_frames_are_found_by_name_or_stated(folder: Callable[..., Any]) -> None:
    place = folder("a_10deg.png", "b_20deg.png", "white-reference.tif", "dark_1.tif", "dark_2.tif")
    sources = find([place])
    assert sources.dark is not None
    assert (sources.dark.name, present(sources.flat).name) == ("dark_1.tif", "white-reference.tif")
    said = {finding.source: finding.text for finding in sources.findings if finding.source}
    assert "used" in said["dark_1.tif"]
    assert "set aside" in said["dark_2.tif"]
    head = 'flat = "card.png"\nlamp_distance = 1.5\n'
    place = folder("card.png", capture__toml=toml(entry("a_10deg.png", 10), entry("b_20deg.png", 20), head=head))
    sources = find([place])
    assert (present(sources.dark).name, present(sources.flat).name, sources.lamp_distance) == (
        "dark_1.tif",
        "card.png",
        1.5,
    )
    (place / "card.png").unlink()
    with pytest.raises(InputError, match=r"capture.toml: names card.png, which is not there"):
        find([place])


def test_files_set_aside_by_the_user_are_no_photographs(folder: Callable[..., Any]) -> None:
    place = folder("a_10deg.png", "b_20deg.png", "c.png")
    assert names(find([place], aside=[place / "c.png"])) == ["a_10deg.png", "b_20deg.png"]


def test_lights_of_a_mirror_sphere_are_measured_later(folder: Callable[..., Any]) -> None:
    place = folder("a.png", "b.png", "c.png")
    sources = find([place], sphere="auto")
    assert (sources.sphere, sources.angle_source, sources.azimuth) == ("auto", "mirror sphere", None)
    assert sources.elevation.tolist() == [0, 0, 0]
    text = "[sphere]\ncolumn_px = 20.0\nrow_px = 30\nradius_px = 10.5\n"
    silent = ['file = "a.png"\nhighlight_px = [21.5, 30]', 'file = "b.png"', 'file = "c.png"']
    sources = find([folder(capture__toml=toml(*silent, head=text))])
    assert sources.sphere == Circle(20.0, 30.0, 10.5)
    assert sources.highlights_px == ((21.5, 30.0), None, None)
    with pytest.raises(InputError, match=r"capture.toml: gives no elevation_deg for a.png, b.png, c.png"):
        find([folder(capture__toml=toml(*silent))])


def test_relative_exposures_use_what_is_known_of_all() -> None:
    paths = [Path(name) for name in "abc"]
    lights = [[Exposure(path, None)] for path in paths]
    noted = {path: Noted(t, iso, 8.0) for path, t, iso in zip(paths, (0.5, 0.5, 0.25), (100, 100, 400), strict=True)}
    scale = exposure_scale(lights, noted)
    assert [scale.factor[path] for path in paths] == pytest.approx([1, 1, 0.5])
    assert "1 s: c" in scale.findings[0].text
    noted[paths[2]] = Noted(0.25, None, 8.0)
    assert exposure_scale(lights, noted).factor[paths[2]] == pytest.approx(2)
    noted[paths[2]] = Noted()
    unknown = exposure_scale(lights, noted)
    assert not unknown.factor
    assert "exposure of c is unknown" in unknown.findings[0].text
    assert unknown.findings[0].verdict == Verdict.WARNING
    assert exposure_scale(lights, {}).findings == ()


@pytest.mark.parametrize("time_s", [1e-300, 1e300])
def test_an_exposure_that_no_photograph_has_is_refused(time_s: float) -> None:
    lights = [[Exposure(Path("a"), 1.0)], [Exposure(Path("b"), time_s)]]
    with pytest.raises(InputError, match=r"^b: was exposed for 1e[+-]300 s"):
        exposure_scale(lights, {})
