"""What all files of a capture tell together: narrow samples, and tags of orientation that are chance."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
import tifffile

from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.stack import ImageStack
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images.encode import rgb_channels, write_exr

LIGHTS = [(0.6, 0.0), (-0.55, 0.0), (0.0, 0.65), (0.0, -0.5), (0.4, 0.4)]
STILL = ImportSettings(motion="none", calibrate="none")


def _images() -> list[np.ndarray]:
    random = np.random.default_rng(3)
    albedo = cv2.GaussianBlur(random.uniform(0.1, 1.0, (40, 60, 3)), (0, 0), 2.0)
    return [albedo * (0.9 - 0.1 * index) + 0.01 * random.random((40, 60, 3)) for index in range(len(LIGHTS))]


def _write(folder: Path, images: list[np.ndarray], suffix: str, is_written: bool = False) -> None:
    lines = [str(len(images))]
    for index, (image, (x, y)) in enumerate(zip(images, LIGHTS, strict=True)):
        if not is_written:
            cv2.imwrite(str(folder / f"p{index}.{suffix}"), image)
        lines.append(f"p{index}.{suffix} {x} {y} {np.sqrt(1.0 - x * x - y * y):.6f}")
    (folder / "lights.lp").write_text("\n".join(lines))


def _import(folder: Path, tmp_path: Path) -> ImageStack:
    return drain(import_stack(find([folder]), STILL, tmp_path / "stack"))


@pytest.mark.parametrize(("bits", "said"), [(10, "10 bits"), (12, "12 bits"), (14, "14 bits"), (16, "")])
def test_narrow_samples_in_files_of_16_bits_have_their_own_white(tmp_path: Path, bits: int, said: str) -> None:
    (tmp_path / "in").mkdir()
    top = (1 << bits) - 1
    _write(tmp_path / "in", [np.rint(top * image / 1.0).clip(0, top).astype(np.uint16) for image in _images()], "tif")
    stack = _import(tmp_path / "in", tmp_path)
    assert 0.1 < stack.radiance[:].mean() < 0.5
    assert said in " ".join(stack.health.warnings)
    assert ("bits" in " ".join(stack.health.warnings)) == bool(said)


@pytest.mark.parametrize(
    ("white", "suffix", "said"),
    [
        ((0.4, 0.4, 0.4), "tif", "(0.4)"),
        ((0.3, 0.4, np.inf), "exr", "(red 0.3, green 0.4)"),
        ((np.inf,) * 3, "tif", ""),
    ],
)
def test_floating_point_samples_at_a_shared_maximum_are_clipped(
    tmp_path: Path, white: tuple[float, ...], suffix: str, said: str
) -> None:
    (tmp_path / "in").mkdir()
    falling = np.linspace(1.0, 0.3, 60)[:, None]
    images = [np.minimum(falling * image, white).astype(np.float32) for image in _images()]
    for index, image in enumerate(images):
        path = tmp_path / "in" / f"p{index}.{suffix}"
        if suffix == "exr":
            write_exr(path, rgb_channels(image), half=False)
        else:
            tifffile.imwrite(path, image, photometric="rgb", metadata=None)
    _write(tmp_path / "in", images, suffix, is_written=True)
    stack = _import(tmp_path / "in", tmp_path)
    clipped = np.stack([(image >= np.asarray(white, np.float32)).any(axis=-1) for image in images])
    order = [int(name[1]) for name in stack.sources]
    np.testing.assert_array_equal(stack.saturated[:], clipped[order])
    told = [warning for warning in stack.health.warnings if "taken as clipped" in warning]
    assert len(told) == bool(said)
    assert said in " ".join(told)


def test_an_even_patch_under_lamps_of_one_elevation_is_not_clipped(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    images = [0.5 * image.astype(np.float32) for image in _images()]
    lines = [str(len(images))]
    for index, image in enumerate(images):
        image[:10, :10] = 0.9 if index < 4 else 0.8
        write_exr(tmp_path / "in" / f"p{index}.exr", rgb_channels(image), half=False)
        turn = 0.5 * np.pi * index
        lines.append(f"p{index}.exr {0.6 * np.cos(turn)} {0.6 * np.sin(turn)} 0.8" if index < 4 else "p4.exr 0 0 1")
    (tmp_path / "in" / "lights.lp").write_text("\n".join(lines))
    stack = _import(tmp_path / "in", tmp_path)
    assert not stack.saturated[:].any()
    assert not any("clipped" in warning for warning in stack.health.warnings)


@pytest.mark.parametrize(("scale", "is_said"), [(1.0, False), (255.0, True)])
def test_floating_point_samples_that_are_levels_are_doubted(tmp_path: Path, scale: float, is_said: bool) -> None:
    (tmp_path / "in").mkdir()
    for index, image in enumerate(_images()):
        write_exr(tmp_path / "in" / f"p{index}.exr", rgb_channels((scale * image).astype(np.float32)), half=False)
    _write(tmp_path / "in", _images(), "exr", is_written=True)
    warnings = " ".join(_import(tmp_path / "in", tmp_path).health.warnings)
    assert ("divide them by 255" in warnings) == is_said


def _tag(path: Path, orientation: int) -> None:
    """Put an EXIF segment with this orientation behind the first marker of a JPEG."""
    content = path.read_bytes()
    entry = (0x0112).to_bytes(2, "big") + b"\0\3\0\0\0\1" + orientation.to_bytes(2, "big") + b"\0\0"
    tiff = b"MM\0*\0\0\0\x08\0\1" + entry + b"\0\0\0\0"
    segment = b"Exif\0\0" + tiff
    path.write_bytes(content[:2] + b"\xff\xe1" + (len(segment) + 2).to_bytes(2, "big") + segment + content[2:])


@pytest.mark.parametrize("tag", [3, 6])
def test_orientations_that_differ_by_chance_are_one(tmp_path: Path, tag: int) -> None:
    (tmp_path / "in").mkdir()
    _write(tmp_path / "in", [np.rint(255.0 * image).clip(0, 255).astype(np.uint8) for image in _images()], "jpg")
    for index in (1, 3):
        _tag(tmp_path / "in" / f"p{index}.jpg", tag)
    stack = _import(tmp_path / "in", tmp_path)
    assert stack.radiance.shape[1:3] == (40, 60)
    assert any("EXIF orientations differ" in warning for warning in stack.health.warnings)


def test_a_photograph_that_was_turned_is_refused_by_its_tag(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    images = [np.rint(255.0 * image).clip(0, 255).astype(np.uint8) for image in _images()]
    images[1] = images[1][::-1, ::-1]
    _write(tmp_path / "in", images, "jpg")
    _tag(tmp_path / "in" / "p1.jpg", 3)
    with pytest.raises(InputError, match=r"p1.jpg: was turned during the capture: EXIF orientation 3"):
        _import(tmp_path / "in", tmp_path)


@pytest.mark.parametrize("of_lamps", [False, True])
def test_frames_of_narrow_samples_have_the_white_of_the_photographs(tmp_path: Path, of_lamps: bool) -> None:
    falling = np.linspace(1.0, 0.4, 60)[:, None]
    stacks = []
    for top in (4095, 65535):
        folder = tmp_path / str(top)
        frames = [tmp_path / f"{name}{top}" for name in ("dark", "flat")]
        for each in (folder, *frames):
            each.mkdir()
        codes = [np.rint(4095 * (0.1 + 0.8 * falling * image)) for image in _images()]
        even = np.ones((40, 60, 3))
        shown = [np.rint(4095 * level * even) for level in (0.1, 0.1 + 0.7 * falling)]
        _write(folder, [np.rint(each * (top / 4095)).astype(np.uint16) for each in codes], "tif")
        for frame, pixels in zip(frames, shown, strict=True):
            for index in range(len(LIGHTS)):
                cv2.imwrite(str(frame / f"p{index}.tif"), np.rint(pixels * (top / 4095)).astype(np.uint16))
        dark, flat = frames if of_lamps else [each / "p0.tif" for each in frames]
        settings = ImportSettings(motion="none", calibrate="none", dark=dark, flat=flat)
        stacks.append(drain(import_stack(find([folder]), settings, tmp_path / f"stack{top}")))
    np.testing.assert_allclose(stacks[0].radiance[:], stacks[1].radiance[:], rtol=2e-3, atol=2e-4)
    assert [warning for warning in stacks[0].health.warnings if "12 bits" in warning] == stacks[0].health.warnings[:1]
