"""Millimetres per texel: stated, from a known length, and from a chart; carried through framings."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image as PillowImage
from PIL.TiffImagePlugin import IFDRational

from engine.capture.chart.find import find_chart
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.registration.framing import Framing
from engine.capture.scale import (
    CameraDistance,
    ChartPitch,
    KnownLength,
    is_estimate,
    mm_per_texel,
    scale_of,
    scale_of_camera,
    scale_of_chart,
)
from engine.core.errors import InputError, UsageError
from engine.core.steps import drain
from engine.images.encode import encode_png
from tests.engine.capture.chart.chart_images import flat_chart


@pytest.mark.parametrize(("turn", "size"), [(0.0, 0.8), (0.3, 1.1), (3.0, 0.6)])
def test_a_chart_tells_the_scale_to_half_a_percent(turn: float, size: float) -> None:
    random = np.random.default_rng(4)
    chart = flat_chart()
    height, width = chart.shape[:2]
    side = int(1.3 * size * np.hypot(height, width))
    cosine, sine = size * np.cos(turn), size * np.sin(turn)
    matrix = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0]])
    matrix[:, 2] = side / 2 - matrix[:, :2] @ [width / 2, height / 2]
    image = cv2.warpAffine(chart, matrix, (side, side), flags=cv2.INTER_AREA, borderValue=(0.2, 0.2, 0.2))
    image = np.clip(image + 0.004 * random.standard_normal(image.shape), 0.0, 1.0).astype(np.float32)
    found = find_chart(image, np.zeros(image.shape[:2], bool))
    assert found is not None
    scale = scale_of_chart(found[0].positions, 44.0)
    truth = 44.0 / (92 * size)  # patches of the drawing are 92 px apart
    assert scale.mm_per_pixel == pytest.approx(truth, rel=0.005)
    assert abs(scale.mm_per_pixel - truth) < 3.0 * scale.sigma
    oblique = cv2.perspectiveTransform(found[0].positions[None], np.array([[1, 0, 0], [0, 1, 0], [5e-4, 0, 1.0]]))[0]
    with pytest.raises(UsageError, match="obliquely"):
        scale_of_chart(oblique, 44.0)


def test_a_known_length_has_a_deviation_and_impossible_ones_are_refused() -> None:
    scale = scale_of(KnownLength((10.0, 20.0), (310.0, 420.0), 25.0))
    assert scale.mm_per_pixel == pytest.approx(0.05)
    assert scale.sigma == pytest.approx(0.05 * np.sqrt(0.5) / 500.0)
    for wrong in ((1.0, 1.0), (1.0, 1.5)):
        with pytest.raises(UsageError, match="two pixels apart"):
            KnownLength((1.0, 1.0), wrong, 3.0)
    with pytest.raises(UsageError, match="not within"):
        ImportSettings(scale=1e4)
    with pytest.raises(UsageError, match="needs a photograph that shows one"):
        ImportSettings(scale=ChartPitch(44.0))


def test_texels_of_a_framing_are_as_large_as_what_they_cover(tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    (tmp_path / "c").mkdir()
    for angle in (20, 40, 60):
        image = (angle / 90 * random.uniform(0.3, 1.0, (64, 80, 3)) * 255).astype(np.uint8)
        (tmp_path / "c" / f"x_{angle}deg.png").write_bytes(encode_png(image))
    corners = ((10.0, 10.0), (50.0, 10.0), (50.0, 40.0), (10.0, 40.0))
    for name, framing, texel in (("whole", None, 0.25), ("framed", Framing(corners, 80, 60), 0.125)):
        settings = ImportSettings(motion="none", scale=0.25, framing=framing)
        stack = drain(import_stack(find([tmp_path / "c"]), settings, tmp_path / name))
        assert mm_per_texel(stack.provenance) == pytest.approx(texel, rel=0.02)
        assert any(f"{texel * stack.radiance.shape[2]:.3g}" in each.text for each in stack.health.findings)
    assert mm_per_texel({}) is None
    assert mm_per_texel({"scale": {"mm_per_texel": -1.0}}) is None


@pytest.mark.parametrize("size", [0.1, 1.0])
def test_a_thin_lens_tells_the_scale_from_its_distance(size: float) -> None:
    """A sample whose image is m times as large lies f (2 + m + 1 / m) from the sensor, f (1 + 1 / m) from the lens."""
    focal_mm, pitch_mm = 100.0, 0.005
    from_sensor, from_lens = focal_mm * (2.0 + size + 1.0 / size), focal_mm * (1.0 + 1.0 / size)
    truth = pitch_mm / size
    if size < 1.0:
        measured = scale_of_camera(focal_mm, pitch_mm, from_sensor, is_measured=True)
        assert measured.mm_per_pixel == pytest.approx(truth)
        assert 0.05 < measured.sigma / truth < 0.07
        for distance_mm in (from_sensor, from_lens):
            noted = scale_of_camera(focal_mm, pitch_mm, distance_mm, is_measured=False)
            assert abs(noted.mm_per_pixel - truth) < 2.0 * noted.sigma
    else:
        with pytest.raises(UsageError, match="focuses nothing nearer than 400 mm"):
            scale_of_camera(focal_mm, pitch_mm, from_lens, is_measured=True)


def _camera_files(folder: Path, distance: float | None) -> None:
    random = np.random.default_rng(2)
    exif = PillowImage.Exif()
    noted = exif.get_ifd(0x8769)
    noted.update({0x920A: IFDRational(100), 0xA20E: 2000.0, 0xA20F: 2000.0, 0xA210: 3, 0xA002: 120})
    if distance is not None:
        noted[0x9206] = distance
    folder.mkdir()
    for angle in (30, 50, 70):
        image = random.integers(0, 3 * angle, (40, 60, 3), np.uint8)
        PillowImage.fromarray(image).save(folder / f"wood_{angle}.jpg", quality=95, exif=exif)


def test_the_notes_of_a_camera_are_an_estimate_that_is_asked_for(tmp_path: Path) -> None:
    """Pixels are 5 µm, and the image was halved: 10 µm; 1.21 m is ten times the focal length, and as much besides."""
    _camera_files(tmp_path / "c", 1.21)
    plain = drain(import_stack(find([tmp_path / "c"]), ImportSettings(motion="none"), tmp_path / "plain"))
    assert mm_per_texel(plain.provenance) is None
    assert [f for f in plain.health.findings if "suggest 0.11 mm per pixel (95 % interval 0.0" in f.text]
    settings = ImportSettings(motion="none", scale=CameraDistance())
    noted = drain(import_stack(find([tmp_path / "c"]), settings, tmp_path / "noted"))
    half = 0.5 * (12.1 - 2.0)
    by_sensor, by_lens = 0.01 * (half + np.sqrt(half**2 - 1.0)), 0.01 * 11.1
    assert mm_per_texel(noted.provenance) == pytest.approx(0.5 * (by_sensor + by_lens), rel=1e-6)
    assert is_estimate(noted.provenance)
    assert any("an estimate from the camera's notes" in finding.text for finding in noted.health.findings)
    measured = ImportSettings(motion="none", scale=CameraDistance(1210.0))
    found = drain(import_stack(find([tmp_path / "c"]), measured, tmp_path / "measured"))
    assert mm_per_texel(found.provenance) == pytest.approx(by_sensor, rel=1e-6)


def test_what_a_camera_does_not_note_is_named(tmp_path: Path) -> None:
    _camera_files(tmp_path / "c", None)
    with pytest.raises(InputError, match=r"does not note the distance, .* give it with --scale exif=MM"):
        drain(import_stack(find([tmp_path / "c"]), ImportSettings(scale=CameraDistance()), tmp_path / "stack"))
    with pytest.raises(InputError, match="focuses nothing nearer than 400 mm"):
        drain(import_stack(find([tmp_path / "c"]), ImportSettings(scale=CameraDistance(350.0)), tmp_path / "stack"))
