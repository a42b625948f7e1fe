"""Alignment against known shifts, and refusal of what cannot be aligned."""

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import fft

from engine.capture.registration.align import align
from engine.capture.registration.control_points import with_control_points
from engine.capture.registration.pair_motion import Refused, refuse_degenerate
from engine.capture.registration.texture import choose_supported_motion, reduce
from engine.core.steps import drain

SIZE = 320


def scene(seed: int = 0, size: int = SIZE, deviation: float = 2.0) -> NDArray[np.float32]:
    """A periodic texture in [0.1, 0.9], so that it can be shifted exactly."""
    rng = np.random.default_rng(seed)
    frequency = np.hypot(fft.fftfreq(size)[:, None], fft.rfftfreq(size))
    spectrum = fft.rfft2(rng.normal(size=(size, size))) * np.exp(-2 * (np.pi * deviation * frequency) ** 2)
    image = fft.irfft2(spectrum, s=(size, size))
    return (0.5 + 0.4 * image / np.abs(image).max()).astype(np.float32)


def shift_image(image: Any, right: Any, down: Any) -> NDArray[np.float32]:
    """`image` moved by any part of a pixel, exactly."""
    rows, columns = fft.fftfreq(image.shape[0])[:, None], fft.rfftfreq(image.shape[1])
    phase = np.exp(-2j * np.pi * (columns * right + rows * down))
    return fft.irfft2(fft.rfft2(image.astype(np.float64)) * phase, s=image.shape).astype(np.float32)


def noisy(image: Any, snr_db: float = 30.0, seed: int = 0) -> NDArray[np.float32]:
    power = float(np.mean(image.astype(np.float64) ** 2))
    noise = np.random.default_rng(seed).normal(0, np.sqrt(power * 10 ** (-snr_db / 10)), image.shape)
    return (image + noise).astype(np.float32)


def align_images(*images: Any, motion: str = "translation", factor: int = 1) -> Any:
    return drain(align(images, [f"p{n}" for n in range(len(images))], motion, factor))


def find_moved_centre(result: Any, index: Any, size: int = SIZE) -> Any:
    """The position of the reference's centre in photograph `index`, minus the same for photograph 0."""
    centre = np.array([size / 2, size / 2, 1.0])
    there, base = (result.matrix[n] @ centre for n in (index, 0))
    return there[:2] / there[2] - base[:2] / base[2]


@pytest.mark.parametrize("motion", ["translation", "euclidean", "affine", "homography"])
def test_AL1_identical_images_give_the_identity(motion: str) -> None:
    image = scene()
    result = align_images(image, image.copy(), motion=motion)
    corners = np.array([[0, 0, 1], [SIZE, 0, 1], [0, SIZE, 1], [SIZE, SIZE, 1.0]])
    moved = corners @ result.matrix[1].T
    assert np.abs(moved[:, :2] / moved[:, 2:] - corners[:, :2]).max() <= 1e-6
    assert result.aligned.all()
    assert result.residual_px == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("kind", ["constant", "black", "noise"])
def test_AL2_no_texture_is_said_and_left_alone(kind: str) -> None:
    rng = np.random.default_rng(5)
    level = {"constant": 0.4, "black": 0.0, "noise": 0.5}[kind]
    images = [np.full((SIZE, SIZE), level, np.float32) for _ in range(2)]
    if kind == "noise":
        images = [image + rng.normal(0, 0.1, image.shape).astype(np.float32) for image in images]
    result = align_images(*images, motion="euclidean")
    assert np.array_equal(result.matrix, np.tile(np.eye(3), (2, 1, 1)))
    assert not result.confidence.any()
    assert not result.aligned.any()
    assert any("no texture" in finding.text for finding in result.findings)


@pytest.mark.parametrize("motion", ["translation", "euclidean", "affine", "homography"])
@pytest.mark.parametrize("shift", [(0.37, -0.81), (12.63, 7.19), (-90.5, 40.25)])
def test_AL3_sub_pixel_shift_at_30_dB(motion: str, shift: Any) -> None:
    image = scene(1, 2 * SIZE)
    images = [noisy(p[:SIZE, :SIZE], seed=n) for n, p in enumerate((image, shift_image(image, *shift)))]
    result = align_images(*images, motion=motion)
    assert np.abs(find_moved_centre(result, 1) - shift).max() <= 0.05
    assert np.nanmax(result.residual_px) < 0.2


def test_AL3_holds_in_pixels_of_the_photograph_for_reduced_images() -> None:
    image = scene(2, 2 * SIZE, deviation=4.0)
    images = [reduce(noisy(p, seed=n), 2) for n, p in enumerate((image, shift_image(image, 5.37, -3.81)))]
    result = align_images(*images, factor=2)
    assert np.abs(find_moved_centre(result, 1) - (5.37, -3.81)).max() <= 0.1


def test_euclidean_motion_is_recovered() -> None:
    image = scene(3, 2 * SIZE)
    turn = cv2.getRotationMatrix2D((SIZE, SIZE), 1.5, 1.0)
    turn[:, 2] += 3.3, -2.1
    other = cv2.warpAffine(image, turn, image.shape[::-1], flags=cv2.INTER_CUBIC)
    part = np.s_[SIZE // 2 : SIZE // 2 + SIZE, SIZE // 2 : SIZE // 2 + SIZE]
    result = align_images(image[part], other[part], motion="euclidean")
    point = np.array([SIZE / 4, SIZE / 3, 1.0])
    expected = turn @ np.array([SIZE * 3 / 4, SIZE * 5 / 6, 1.0]) - SIZE / 2
    there = result.matrix[1] @ np.linalg.inv(result.matrix[0]) @ point
    assert np.abs(there[:2] / there[2] - expected).max() < 0.1


def relief_under(elevation_deg: float, height: Any) -> NDArray[np.float32]:
    """Lambertian relief lit from the right, without shadows: valleys turn into hills as the lamp passes over."""
    slope = np.gradient(height.astype(np.float64), axis=1)
    elevation = np.radians(elevation_deg)
    return (0.5 + 0.4 * (np.sin(elevation) - slope * np.cos(elevation))).astype(np.float32)


def test_AL4_contrast_inversion_between_grazing_lights() -> None:
    height = 30 * scene(4, 2 * SIZE, deviation=3.0)
    from_right, from_left = relief_under(30, height), shift_image(relief_under(150, height), 2.37, -1.81)
    correlation = np.corrcoef(from_right.ravel(), relief_under(150, height).ravel())[0, 1]
    assert correlation < -0.99
    result = align_images(noisy(from_right[:SIZE, :SIZE]), noisy(from_left[:SIZE, :SIZE], seed=1))
    assert np.abs(find_moved_centre(result, 1) - (2.37, -1.81)).max() <= 0.25


def test_AL5_a_periodic_weave_is_reported_as_ambiguous() -> None:
    row, column = np.mgrid[:SIZE, :SIZE] * (2 * np.pi / 20)
    weave = (0.5 + 0.3 * np.sin(row) * np.sin(column)).astype(np.float32)
    moved = np.roll(weave, 20, axis=1)
    result = align_images(noisy(weave), noisy(moved, seed=1))
    assert any("repeats" in finding.text for finding in result.findings)
    assert np.abs(find_moved_centre(result, 1)).max() < 0.1
    unique = align_images(noisy(scene()), noisy(shift_image(scene(), 1, 0), seed=1))
    assert not unique.findings


def test_AL6_texture_on_one_line_falls_back_to_shifts() -> None:
    image = np.full((SIZE, SIZE), 0.4, np.float32)
    image[95:145] = scene()[95:145]
    assert choose_supported_motion(scene(), "homography") == "homography"
    for motion in ("affine", "homography"):
        assert choose_supported_motion(image, motion) == "translation"
    result = align_images(image, shift_image(image, 2.0, 1.0), motion="homography")
    assert np.abs(find_moved_centre(result, 1) - (2.0, 1.0)).max() < 0.05
    assert result.matrix[1][2] == pytest.approx([0, 0, 1])
    assert any("too little texture" in finding.text for finding in result.findings)


def test_AL6_degenerate_motions_are_refused() -> None:
    for matrix in (
        np.diag([1.0, 1e-8, 1.0]),
        np.diag([-1.0, 1.0, 1.0]),
        np.array([[1, 0, 0], [0, 1, 0], [-0.1, 0, 1.0]]),
    ):
        with pytest.raises(Refused):
            refuse_degenerate(matrix, (SIZE, SIZE))
    refuse_degenerate(np.eye(3), (SIZE, SIZE))


def test_AL7_more_than_half_a_frame_and_upside_down_are_refused() -> None:
    image = scene(6, 2 * SIZE)
    far = align_images(image[:SIZE, :SIZE], image[:SIZE, 180 : 180 + SIZE])
    turned = align_images(scene(), np.ascontiguousarray(scene()[::-1, ::-1]))
    for result, words in ((far, "half the frame"), (turned, "180°")):
        assert np.array_equal(result.matrix[1], np.eye(3))
        assert not result.aligned.any()
        assert any(words in finding.text and finding.source for finding in result.findings)


def test_one_bad_photograph_does_not_spoil_the_others() -> None:
    images = [noisy(scene()), np.zeros((SIZE, SIZE), np.float32), noisy(shift_image(scene(), 1.5, 0.5), seed=2)]
    result = align_images(*images)
    assert result.aligned.tolist() == [True, False, True]
    assert np.isnan(result.residual_px[1])
    assert np.abs(find_moved_centre(result, 2) - (1.5, 0.5)).max() <= 0.05


def test_small_shifts_of_images_in_too_different_light_are_not_believed() -> None:
    shared, own = scene(), scene(9)
    unlike = 0.45 * shared + 0.55 * own
    small, large = (align_images(shared, shift_image(unlike, right, 0)) for right in (3.0, 30.0))
    assert small.aligned.tolist() == [False, False]
    assert "too unlike" in small.findings[0].text
    assert np.abs(find_moved_centre(large, 1) - (30.0, 0.0)).max() < 0.5


def test_residual_sees_a_motion_that_the_model_cannot_follow() -> None:
    row, column = np.mgrid[:SIZE, :SIZE].astype(np.float32)
    bent = cv2.remap(scene(), column + 0.6 * np.sin(row / 40), row, cv2.INTER_CUBIC, borderMode=cv2.BORDER_WRAP)
    result = align_images(scene(), bent)
    assert 0.2 < np.nanmax(result.residual_px) < 0.8


def relief_arc(shifts: Any) -> list[Any]:
    """Coloured relief under a sinking lamp, noise 30 dB, moved by `shifts`."""
    height, tone = 12 * scene(7, 2 * SIZE, deviation=3.0), 0.5 + scene(8, 2 * SIZE, deviation=1.5)
    lights = np.linspace(25, 85, len(shifts))
    moved = [
        shift_image(relief_under(light, height) * tone, *shift) for light, shift in zip(lights, shifts, strict=True)
    ]
    return [noisy(one[:SIZE, :SIZE], seed=n) for n, one in enumerate(moved)]


def test_a_camera_that_stood_still_is_left_alone_under_a_sinking_lamp() -> None:
    result = align_images(*relief_arc([(0, 0)] * 7))
    assert result.aligned.all()
    moved = [np.abs(find_moved_centre(result, n)).max() for n in range(7)]
    assert max(moved) <= 0.02


def test_most_of_one_knock_is_undone_under_a_sinking_lamp() -> None:
    shifts = [(0, 0)] * 4 + [(2.3, -1.6)] + [(0, 0)] * 2
    result = align_images(*relief_arc(shifts))
    error = [
        np.abs(find_moved_centre(result, n) - find_moved_centre(result, 3) - shift).max()
        for n, shift in enumerate(shifts)
    ]
    assert max(error) <= 0.25 * np.hypot(2.3, 1.6)
    assert result.aligned.all()


def test_a_camera_that_moves_with_the_lamp_learns_the_certainty_of_its_shifts() -> None:
    shifts = np.random.default_rng(3).uniform(-6, 6, (7, 2))
    result = align_images(*relief_arc(shifts))
    reported = [finding.text for finding in result.findings if "not determined to better than" in finding.text]
    assert len(reported) == 1
    assert f"p{result.reference}" not in reported[0].split(" are ")[0]


@pytest.mark.parametrize("motion", ["translation", "euclidean", "affine", "homography"])
def test_AL3_holds_for_a_stack_in_one_light(motion: str) -> None:
    shifts = [(0, 0), (0.37, -0.81), (1.2, 0.4), (1.9, 0.9), (-2.2, 3.1), (12.6, -7.2)]
    image = scene(7, 2 * SIZE)
    stack = [noisy(shift_image(image, *shift)[:SIZE, :SIZE], seed=n) for n, shift in enumerate(shifts)]
    result = align_images(*stack, motion=motion)
    error = [np.abs(find_moved_centre(result, n) - shift).max() for n, shift in enumerate(shifts)]
    assert max(error) <= 0.05
    assert result.residual_px.max() < 0.1


def test_control_points_take_the_place_of_what_failed() -> None:
    failed = align_images(scene(), np.zeros((SIZE, SIZE), np.float32))
    pairs = [[10, 10, 13.5, 8], [200, 40, 203.5, 38]]
    marked = with_control_points(failed, {1: pairs}, ["p0", "p1"], "euclidean")
    assert np.abs(find_moved_centre(marked, 1) - (3.5, -2.0)).max() < 1e-9
    assert marked.aligned[1]
    assert not marked.findings
    stiffer = with_control_points(failed, {1: pairs}, ["p0", "p1"], "homography")
    assert "euclidean was used" in stiffer.findings[0].text


def test_wrong_calls() -> None:
    with pytest.raises(ValueError, match="unknown motion"):
        align_images(scene(), scene(), motion="spline")
    with pytest.raises(ValueError, match="one size"):
        align_images(scene(), scene()[:100])
