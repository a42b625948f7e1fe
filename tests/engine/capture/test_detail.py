"""Whether photographs show fine detail: generated ones in focus, out of focus, noisy, and smooth."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from engine.capture.detail import about_detail, find_finest
from engine.core.health import Verdict


def photographs(blur: float, noise: float, *, seed: int, contrast: float = 0.2) -> list[np.ndarray]:
    """Six (120, 130) of a matte surface with as much detail in each octave, out of focus by `blur` pixels."""
    rng = np.random.default_rng(seed)
    fields = []
    for _ in range(3):
        frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(130), np.fft.fftfreq(120)))
        spectrum = np.fft.fft2(rng.normal(size=(120, 130))) / np.maximum(frequency, 1.0 / 60.0)
        field = np.fft.ifft2(spectrum).real
        fields.append(contrast * field / field.std())
    normal = np.stack([fields[0], fields[1], np.ones((120, 130))])
    normal /= np.linalg.norm(normal, axis=0)
    azimuth = np.arange(6) * np.pi / 3.0 + 0.2
    lights = np.stack([0.6 * np.cos(azimuth), 0.6 * np.sin(azimuth), np.full(6, 0.8)], 1)
    shown = np.maximum(np.einsum("nc,chw->nhw", lights, normal), 0.0) * np.clip(0.5 + 0.5 * fields[2], 0.05, 1.0)
    images = [cv2.GaussianBlur(image, (0, 0), blur) if blur else image for image in shown]
    return [(image + rng.normal(0.0, noise, image.shape)).astype(np.float32) for image in images]


@pytest.mark.parametrize("noise", [0.0, 0.003, 0.02])
@pytest.mark.parametrize(("blur", "sizes"), [(0.0, {1}), (0.6, {1}), (1.5, {4, 8}), (4.0, {8})])
def test_photographs_out_of_focus_are_noted(blur: float, sizes: set[int], noise: float) -> None:
    for seed in range(6):
        windows = photographs(blur, noise, seed=seed)
        assert find_finest(windows) in sizes
        assert len(about_detail(windows)) == (1 not in sizes)


def test_the_note_tells_the_size_of_what_is_seen() -> None:
    (finding,) = about_detail(photographs(5.0, 0.003, seed=1))
    assert finding.verdict is Verdict.NOTE
    assert finding.text.startswith("No photograph shows detail of less than 8 pixels: ")


def test_nothing_is_said_of_what_shows_no_detail_at_all() -> None:
    rng = np.random.default_rng(3)
    even = [(0.4 + rng.normal(0.0, 0.01, (100, 100))).astype(np.float32) for _ in range(5)]
    ramp = np.linspace(0.2, 0.6, 100, dtype=np.float32)[None] * np.ones((100, 1), np.float32)
    for windows in (even, [ramp] * 4, even[:1], [], [np.zeros((60, 60), np.float32)] * 3, [even[0][:20]] * 3):
        assert about_detail(windows) == []
