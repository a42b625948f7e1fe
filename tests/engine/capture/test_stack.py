"""Import into a stack folder, and opening of stack folders that may be damaged."""

import itertools
import json
import os
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from engine.capture import import_stack as module
from engine.capture.doubts import Doubtful
from engine.capture.import_stack import ImportSettings, ThumbnailReady, import_stack
from engine.capture.lights.sources import find
from engine.capture.photograph.decode import ReadAhead
from engine.capture.stack import npy_header, open_stack
from engine.core.errors import InputError, OutputError
from engine.core.steps import Steps, drain
from engine.storage.scratch import array_in

HEIGHT, WIDTH = 120, 160
LUMINANCE = np.array([0.2126390059, 0.7151686788, 0.0721923154])


def texture(seed: int = 0, height: int = HEIGHT + 40, width: int = WIDTH + 40) -> Any:
    noise = cv2.GaussianBlur(np.random.default_rng(seed).normal(size=(height, width)).astype(np.float32), (0, 0), 2.0)
    return 1.0 + 0.2 * noise / noise.std()


def write(path: Path, radiance: Any, bits: int = 16) -> None:
    """A PNG of linear radiance in [0, 1], coded as sRGB."""
    coded = np.where(radiance <= 0.0031308, 12.92 * radiance, 1.055 * np.maximum(radiance, 1e-9) ** (1 / 2.4) - 0.055)
    codes = np.rint(np.clip(coded, 0, 1) * (2**bits - 1)).astype(np.uint16 if bits == 16 else np.uint8)
    done, content = cv2.imencode(".png", codes[..., ::-1] if codes.ndim == 3 else codes)
    assert done
    Path(path).write_bytes(content.tobytes())


def colour(luminance: Any) -> NDArray[np.float32]:
    return (luminance[..., None] * np.array([0.9, 1.0, 0.7])).astype(np.float32)


@pytest.fixture(scope="session")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four photographs of one texture, brighter with the elevation, moved by whole pixels."""
    folder = tmp_path_factory.mktemp("capture")
    surface = texture()
    for angle, (right, down) in zip((20, 40, 60, 80), ((0, 0), (3, -2), (-4, 1), (2, 5)), strict=True):
        view = surface[20 - down : 20 - down + HEIGHT, 20 - right : 20 - right + WIDTH]
        write(folder / f"cloth_{angle}deg.png", colour(0.005 * angle * view))
    return folder


@pytest.fixture(scope="session")
def stack(capture: Path, tmp_path_factory: pytest.TempPathFactory) -> Any:
    return run(capture, tmp_path_factory.mktemp("stacks") / "stack")


def run(photographs: Path, target: Any, angles: Any = None, **settings: Any) -> Any:
    return drain(import_stack(find([Path(photographs)], angles), ImportSettings(**settings), target))


def contents(folder: Path) -> dict[str, Any]:
    return {path.name: path.read_bytes() for path in sorted(Path(folder).iterdir()) if path.is_file()}


def test_photographs_become_an_aligned_linear_stack(stack: Any) -> None:
    assert stack.sources == tuple(f"cloth_{angle}deg.png" for angle in (20, 40, 60, 80))
    assert stack.elevation_deg == pytest.approx([20, 40, 60, 80])
    assert stack.radiance.dtype == np.float32
    assert stack.saturated.shape == stack.radiance.shape[:3]
    height, width = stack.radiance.shape[1:3]
    assert (HEIGHT - 8, WIDTH - 8) <= (height, width) <= (HEIGHT - 7, WIDTH - 7)
    scaled = stack.radiance[:] / np.array([20, 40, 60, 80], np.float32)[:, None, None, None]
    assert np.abs(scaled[1:] / scaled[0] - 1).max() < 0.01
    assert max(quality.alignment_residual_px for quality in stack.quality) < 0.15


def test_mean_radiance_is_the_luminance_over_the_crop(stack: Any) -> None:
    means = stack.radiance[:].astype(np.float64).mean(axis=(1, 2)) @ LUMINANCE
    assert stack.mean_radiance == pytest.approx(means, rel=1e-7)


def test_opening_restores_everything(stack: Any) -> None:
    again = open_stack(stack.folder)
    for name in ("radiance", "saturated", "elevation", "mean_radiance"):
        assert np.array_equal(getattr(again, name)[:], getattr(stack, name)[:])
    assert (again.azimuth, again.quality, again.angle_source) == (None, stack.quality, "file names")
    assert dict(again.provenance) == dict(stack.provenance)
    assert again.health.findings == stack.health.findings
    assert again.provenance["photographs"][0]["transfer"] == "srgb"


def test_without_alignment_pixels_stay(capture: Path, tmp_path: Path) -> None:
    stack = run(capture, tmp_path / "s", motion="none")
    assert stack.radiance.shape == (4, HEIGHT, WIDTH, 3)
    assert [quality.alignment_residual_px for quality in stack.quality] == [None] * 4


def test_crop_is_in_pixels_of_the_photographs(capture: Path, tmp_path: Path) -> None:
    whole = run(capture, tmp_path / "whole", motion="none")
    part = run(capture, tmp_path / "part", motion="none", crop=(10, 20, 50, 30))
    assert np.array_equal(part.radiance, whole.radiance[:, 20:50, 10:60])
    with pytest.raises(InputError, match="lies outside"):
        run(capture, tmp_path / "none", crop=(500, 0, 10, 10))
    assert not (tmp_path / "none").exists()


@pytest.mark.parametrize("band_pixels", [1, 1000, 1 << 30])
def test_S11_streamed_import_is_bit_equal_for_any_band(
    capture: Path, stack: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, band_pixels: int
) -> None:
    for place in ("import_stack", "output"):
        monkeypatch.setattr(f"engine.capture.{place}.BAND_PIXELS", band_pixels)
    again = run(capture, tmp_path / "stack")
    assert contents(again.folder) == contents(stack.folder)


def test_S11_import_through_a_scratch_file_is_bit_equal(
    capture: Path, stack: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.storage.scratch.IN_MEMORY_BYTES", 0)
    again = run(capture, tmp_path / "stack")
    assert contents(again.folder) == contents(stack.folder)


def test_S11_alignment_needs_the_disk_space_of_one_light_more_than_the_result(
    capture: Path, stack: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import weakref

    made: list[weakref.ref[Any]] = []
    light_bytes, codes_bytes = 13 * HEIGHT * WIDTH, 6 * HEIGHT * WIDTH  # codes of 16 bits wait
    disk_bytes = int(1.1 * (4 * light_bytes + codes_bytes + (1 << 20))) + 1

    def waiting_bytes() -> int:
        return sum(array.nbytes for array in (one() for one in made) if array is not None)

    def record(*how: Any) -> Any:
        array = make(*how)
        made.append(weakref.ref(array))
        return array

    def free_bytes(folder: Path) -> int:
        written = sum(path.stat().st_size for path in tmp_path.rglob("*.npy*"))
        return disk_bytes - waiting_bytes() - written

    make = array_in
    monkeypatch.setattr("engine.storage.scratch.IN_MEMORY_BYTES", 0)
    monkeypatch.setattr(module, "array_in", record)
    monkeypatch.setattr("engine.storage.atomic.free_bytes", free_bytes)
    waiting = {}
    for step in import_stack(find([capture]), ImportSettings(), tmp_path / "stack"):
        if step.note.startswith("Writing"):
            waiting[step.note] = waiting_bytes() / codes_bytes
    assert waiting == {f"Writing {1 + light} of 4": 4 - light for light in range(4)}
    assert contents(tmp_path / "stack") == contents(stack.folder)
    disk_bytes -= 2
    with pytest.raises(OutputError, match="space"):
        run(capture, tmp_path / "again")
    assert waiting_bytes() == 0


def test_S11_one_photograph_is_held_while_the_next_two_are_read(
    capture: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import weakref

    take = ReadAhead.next_photograph
    alive: list[weakref.ref[Any]] = []

    def watch(ahead: Any, done: Any, note: Any) -> Steps[Any]:
        assert not [one for one in alive if one() is not None]
        photograph = yield from take(ahead, done, note)
        assert len(ahead._readings) <= 2
        alive.append(weakref.ref(photograph))
        return photograph

    monkeypatch.setattr(ReadAhead, "next_photograph", watch)
    for motion in ("none", "euclidean"):
        run(capture, tmp_path / motion, motion=motion)
    assert len(alive) == 8


def test_steps_show_thumbnails_and_rise(capture: Path, tmp_path: Path) -> None:
    steps: list[Any] = []
    drain(import_stack(find([capture]), ImportSettings(), tmp_path / "stack"), steps.append)
    thumbnails = [step.partial for step in steps if isinstance(step.partial, ThumbnailReady)]
    assert [one.path.name for one in thumbnails] == [f"cloth_{angle}deg.png" for angle in (20, 40, 60, 80)]
    assert all(one.thumbnail.dtype == np.uint8 and max(one.thumbnail.shape) <= 256 for one in thumbnails)
    assert all(0.0 <= before.done <= after.done <= 1.0 for before, after in itertools.pairwise(steps))
    assert any(step.note == "Aligning 3 of 4" for step in steps)


@pytest.mark.campaign(rounds=5)
def test_fault_17_closed_at_every_step_leaves_nothing(
    capture: Path, tmp_path: Path, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("engine.capture.photograph.decode.PATIENCE_S", 60.0)
    for stop in range(seed % 5, 10_000, 5):
        steps = import_stack(find([capture]), ImportSettings(), tmp_path / "stack")
        try:
            for _ in range(stop + 1):
                next(steps)
        except StopIteration:
            break
        steps.close()
        assert list(tmp_path.iterdir()) == []
    assert stop > 12
    assert open_stack(tmp_path / "stack").sources


def test_photographs_are_never_written_to(capture: Path, tmp_path: Path) -> None:
    before = {path.name: (path.stat().st_mtime_ns, path.read_bytes()) for path in capture.iterdir()}
    run(capture, tmp_path / "stack")
    assert {path.name: (path.stat().st_mtime_ns, path.read_bytes()) for path in capture.iterdir()} == before


def test_an_older_stack_is_replaced_and_a_strange_folder_is_not(capture: Path, tmp_path: Path) -> None:
    run(capture, tmp_path / "stack", crop=(30, 30, 20, 20))
    assert run(capture, tmp_path / "stack").radiance.shape[1] > 20
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years")
    with pytest.raises(OutputError):
        run(capture, tmp_path / "mine")
    assert (tmp_path / "mine" / "thesis.txt").read_text() == "years"


def test_fault_10_sizes_that_differ_are_listed(capture: Path, tmp_path: Path) -> None:
    folder = tmp_path / "mixed"
    folder.mkdir()
    for angle in (20, 40, 60):
        (folder / f"cloth_{angle}deg.png").write_bytes((capture / f"cloth_{angle}deg.png").read_bytes())
    write(folder / "odd_70deg.png", colour(0.4 * texture()[:50, :70]))
    with pytest.raises(InputError) as refusal:
        run(folder, tmp_path / "stack")
    assert "3 of 4 photographs have 160 × 120 px, but odd_70deg.png has 70 × 50" in str(refusal.value)
    assert not (tmp_path / "stack").exists()


def test_fault_10_bit_depths_that_differ_are_warned_of(capture: Path, tmp_path: Path) -> None:
    folder = tmp_path / "mixed"
    folder.mkdir()
    (folder / "cloth_20deg.png").write_bytes((capture / "cloth_20deg.png").read_bytes())
    (folder / "cloth_40deg.png").write_bytes((capture / "cloth_40deg.png").read_bytes())
    write(folder / "cloth_70deg.png", colour(0.4 * texture()[20 : 20 + HEIGHT, 20 : 20 + WIDTH]), bits=8)
    warnings = run(folder, tmp_path / "stack").health.warnings
    assert any("Bit depths differ: 2 × 16 bit; 8 bit: cloth_70deg.png" in warning for warning in warnings)


def test_fault_10_the_same_image_twice(capture: Path, tmp_path: Path) -> None:
    content = (capture / "cloth_20deg.png").read_bytes()
    for name in ("a_10deg.png", "b_20deg.png"):
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=r"a_10deg.png and b_20deg.png are the same image"):
        run(tmp_path, tmp_path / "stack")


def test_fault_5_a_truncated_photograph_is_named_and_nothing_is_written(capture: Path, tmp_path: Path) -> None:
    folder = tmp_path / "cut"
    folder.mkdir()
    for angle in (20, 40):
        content = (capture / f"cloth_{angle}deg.png").read_bytes()
        (folder / f"cloth_{angle}deg.png").write_bytes(content[: len(content) // 2] if angle == 40 else content)
    with pytest.raises(InputError, match=r"cloth_40deg.png"):
        run(folder, tmp_path / "stack")
    assert [path.name for path in tmp_path.iterdir()] == ["cut"]


@pytest.fixture
def damaged(stack: Any, tmp_path: Path) -> tuple[Any, Any]:
    """A copy of the stack folder to damage, and a function that expects it to be refused in words."""
    folder = tmp_path / "damaged"
    folder.mkdir()
    for name, content in contents(stack.folder).items():
        (folder / name).write_bytes(content)

    def refuse(words: str) -> None:
        with pytest.raises(InputError) as refusal:
            open_stack(folder)
        assert words in str(refusal.value)

    return folder, refuse


@pytest.mark.parametrize("name", ["stack.json", "radiance.npy", "saturated.npy"])
@pytest.mark.parametrize("damage", ["missing", "empty", "half", "longer", "folder", "pipe"])
def test_fault_5_half_written_stacks(damaged: tuple[Any, Any], name: str, damage: str) -> None:
    folder, refused = damaged
    path, content = folder / name, (folder / name).read_bytes()
    path.unlink()
    if damage == "folder":
        path.mkdir()
    elif damage == "pipe":
        os.mkfifo(path)
    elif damage != "missing":
        path.write_bytes({"empty": b"", "half": content[: len(content) // 2], "longer": content + b"x"}[damage])
    refused(name)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("height_px", 10**9), ("height_px", -1), ("width_px", 3.5), ("sources", ["a"]), ("sources", []),
        ("elevations_deg", [80, 60, 40, 20]), ("elevations_deg", [10.0, 20.0]), ("mean_radiance", "x"),
        ("lightarc_stack", 2), ("angle_source", "guess"), ("elevations_deg", [10.0, 20.0, 30.0, 91.0]),
        ("azimuths_deg", []), ("quality", [{}]), ("extra", 1), ("elevations_deg", [float("nan")] * 4),
        ("mean_radiance", [float("inf")] * 4), ("mean_radiance", [1e30] * 4),
        ("provenance", {"picture_balance": [1.0, -1e30, 1.0]}), ("provenance", {"a": [{"deep": -1e30}]}),
        ("provenance", {"lamp_distance_widths": -1.0}), ("provenance", {"a": float("inf")}),
    ],
)  # fmt: skip
def test_fault_9_wrong_records(damaged: tuple[Any, Any], key: str, value: Any) -> None:
    folder, refused = damaged
    record = json.loads((folder / "stack.json").read_text())
    (folder / "stack.json").write_text(json.dumps({**record, key: value}))
    refused("stack.json")
    del record["record_sha256"]  # as of before records were sealed
    (folder / "stack.json").write_text(json.dumps({**record, key: value}))
    refused("stack.json")


def test_numbers_that_no_float_holds_and_repeated_keys_are_refused(damaged: tuple[Any, Any]) -> None:
    folder, refused = damaged
    text = (folder / "stack.json").read_text()
    for other in (text.replace('"width_px"', '"a": 1e400, "width_px"', 1), text.replace("{", '{"width_px": 5,', 1)):
        (folder / "stack.json").write_text(other)
        refused("stack.json")


def test_a_record_is_sealed_and_older_ones_are_said_to_be_not(damaged: tuple[Any, Any]) -> None:
    folder, refused = damaged
    record = json.loads((folder / "stack.json").read_text())
    assert not any("sealed" in finding.text for finding in open_stack(folder).health.findings)
    mean = [1.001 * value for value in record["mean_radiance"]]
    (folder / "stack.json").write_text(json.dumps({**record, "mean_radiance": mean}))
    refused("stack.json: is not as it was written")
    del record["record_sha256"]
    (folder / "stack.json").write_text(json.dumps(record))
    assert any("before records of stacks were sealed" in finding.text for finding in open_stack(folder).health.findings)


@pytest.mark.parametrize("text", ["", "[]", "{", "null", "[" * 100_000, '{"a":' * 100_000, "\xff\x00"])
def test_fault_9_records_that_are_no_json(damaged: tuple[Any, Any], text: Any) -> None:
    folder, refused = damaged
    (folder / "stack.json").write_text(text, encoding="latin-1")
    refused("stack.json")


@pytest.mark.parametrize("shape", [(4, 1, 1, 3), (3, 3)])
def test_fault_5_arrays_of_another_kind(damaged: tuple[Any, Any], stack: Any, shape: Any) -> None:
    folder, refused = damaged
    size = (folder / "radiance.npy").stat().st_size
    for header in (
        npy_header(shape, np.float32),
        npy_header(stack.radiance.shape, np.int32),
        b"\x93NUMPY\x01\x00" * 16,
    ):
        (folder / "radiance.npy").write_bytes(header + bytes(size - len(header)))
        refused("radiance.npy")


@pytest.mark.parametrize(
    ("name", "damage"),
    [("radiance.npy", "rows swapped"), ("radiance.npy", "a brighter pixel"), ("saturated.npy", "a mask of ones")],
)
def test_damaged_pixels_are_found(damaged: tuple[Any, Any], name: str, damage: str) -> None:
    folder, refused = damaged
    pixels = np.load(folder / name)
    if damage == "rows swapped":
        pixels[0, [0, 1]] = pixels[0, [1, 0]]
    elif damage == "a brighter pixel":
        pixels[1, 2, 3] *= 1.5
    else:
        pixels[...] = True
    np.save(folder / name, pixels)
    refused(f"{name}: is damaged: the checksum of its pixels does not fit")


def test_stacks_of_before_there_were_checksums_open_with_a_note(damaged: tuple[Any, Any]) -> None:
    folder, _ = damaged
    record = json.loads((folder / "stack.json").read_text())
    older = {key: value for key, value in record.items() if not key.endswith(("crc32", "sha256"))}
    (folder / "stack.json").write_text(json.dumps(older))
    assert any("before stacks had checksums" in finding.text for finding in open_stack(folder).health.findings)


def test_a_folder_that_is_no_stack(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not a stack"):
        open_stack(tmp_path)


def test_npy_header_is_read_by_numpy(stack: Any) -> None:
    for name, array in (("radiance", stack.radiance), ("saturated", stack.saturated)):
        assert np.array_equal(np.load(stack.folder / f"{name}.npy", allow_pickle=False), array[:])


def test_fault_13_odd_names_come_back_readable(capture: Path, tmp_path: Path) -> None:
    folder = tmp_path / "ünï \n'%😀"
    folder.mkdir()
    for name, angle in ((os.fsdecode(b"\xff_10deg.png"), 20), ("‏עברית 20deg.png", 40)):
        (folder / name).write_bytes((capture / f"cloth_{angle}deg.png").read_bytes())
    stack = run(folder, tmp_path / "stack \n😀")
    assert stack.sources == ("\ufffd_10deg.png", "‏עברית 20deg.png")


def test_capture_toml_says_that_samples_are_linear(capture: Path, tmp_path: Path) -> None:
    folder = tmp_path / "linear"
    folder.mkdir()
    lines = ['transfer = "linear"']
    for angle in (20, 40):
        (folder / f"cloth_{angle}deg.png").write_bytes((capture / f"cloth_{angle}deg.png").read_bytes())
        lines += ["[[photographs]]", f'file = "cloth_{angle}deg.png"', f"elevation_deg = {angle}", "exposure_s = 0.5"]
    (folder / "capture.toml").write_text("\n".join(lines))
    assert tomllib.loads((folder / "capture.toml").read_text())
    linear = run(folder, tmp_path / "a", motion="none")
    coded = run(folder, tmp_path / "b", motion="none", transfer="srgb")
    assert linear.mean_radiance[1] > 2 * coded.mean_radiance[1]
    assert linear.provenance["photographs"][0]["exposure_s"] == 0.5


def test_wrong_settings() -> None:
    for wrong in ({"motion": "spline"}, {"transfer": "gamma"}, {"crop": (0, 0, 0, 5)}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            ImportSettings(**wrong)


def test_rti_photographs_stay_where_they_are(shared_data: Callable[[str], Path], tmp_path: Path) -> None:
    folder = tmp_path / "ring"
    folder.mkdir()
    lines = shared_data("stacks/ring_rti64/lights.lp").read_text().splitlines()[1:]
    chosen = lines[::8]
    (folder / "lights.lp").write_text("\n".join([str(len(chosen)), *chosen]))
    for line in chosen:
        name = line.split()[0]
        (folder / name).write_bytes(shared_data(f"stacks/ring_rti64/{name}").read_bytes())
    stack = run(folder, tmp_path / "stack")
    assert stack.radiance.shape == (8, 800, 800, 3)
    assert stack.azimuth is not None
    assert stack.provenance["motion"] == "none"
    assert any("of azimuth" in finding.sentence for finding in stack.health.findings)


def test_plain_paper_without_angles_is_refused_until_a_user_says_so(
    shared_data: Callable[[str], Path], tmp_path: Path
) -> None:
    """Three photographs whose names count, in no order of brightness."""
    folder = shared_data("stacks/pinkney_flat3")
    with pytest.raises(Doubtful, match="nothing says where the lamp stood") as refused:
        run(folder, tmp_path / "stack")
    assert refused.value.consent == "trust_angles"
    assert not (tmp_path / "stack").exists()
    stack = run(folder, tmp_path / "stack", trust_angles=True)
    assert stack.angle_source == "assumed"
    assert any("are assumed" in warning for warning in stack.health.warnings)
    assert any("does not grow" in warning for warning in stack.health.warnings)
    assert any("a user said so" in warning for warning in stack.health.warnings)


@pytest.mark.parametrize("photographs", [5, pytest.param(20, marks=pytest.mark.long)])
def test_matte_statue_stays_put_under_known_lights(
    shared_data: Callable[[str], Path], photographs: int, tmp_path: Path
) -> None:
    lights = shared_data("stacks/uw_psm/lights.txt").read_text().splitlines()[1 : 1 + photographs]
    folder = tmp_path / "cat"
    folder.mkdir()
    rows = []
    for number, light in enumerate(lights):
        direction = np.array(light.split(), float)
        rows.append(f"cat.{number}.tga " + " ".join(f"{v:.6f}" for v in direction / np.linalg.norm(direction)))
        shutil.copy(shared_data(f"stacks/uw_psm/cat/cat.{number}.tga"), folder)
    shutil.copy(shared_data("stacks/uw_psm/cat/cat.mask.tga"), folder)
    (folder / "lights.lp").write_text("\n".join([str(len(rows)), *rows]))
    stack = run(folder, tmp_path / "stack", motion="translation")
    assert stack.elevation_deg[0] == pytest.approx(51.1, abs=0.2)
    assert sorted(stack.sources) == [f"cat.{number}.tga" for number in range(photographs)]
    matrices = np.array([one["alignment_matrix"] for one in stack.provenance["photographs"]]).reshape(-1, 3, 3)
    assert np.abs(matrices[:, :2, 2]).max() < 2.0
