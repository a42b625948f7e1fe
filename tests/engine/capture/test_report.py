"""The report of an import: figures by hand, and verdicts that name the photograph."""

from typing import Any, cast

import numpy as np
import pytest

from engine.capture.report import Quality, grain, leave_one_out, noise_and_sharpness, noise_beside_grain, report
from engine.core.health import Verdict

NAMES = ("a.png", "b.png", "c.png", "d.png")
MEANS = np.array([0.1, 0.2, 0.3, 0.4])


def fine(**changes: Any) -> Quality:
    return Quality(**{"clipped_fraction": 0.0, "black_fraction": 0.0, "noise": 0.001, "sharpness": 1.0, **changes})


def findings(changes: Any, means: Any = MEANS) -> list[Any]:
    """Findings beyond GOOD where photograph c has `changes`."""
    qualities = [fine(**(changes if name == "c.png" else {})) for name in NAMES]
    return [found for found in report(NAMES, means, qualities).findings if found.verdict > Verdict.GOOD]


def test_a_good_stack_has_nothing_but_praise() -> None:
    assert findings({}) == []


@pytest.mark.parametrize(
    ("changes", "verdict", "words"),
    [
        ({"clipped_fraction": 0.01}, Verdict.NOTE, "1 % of the pixels are clipped"),
        ({"clipped_fraction": 0.2}, Verdict.WARNING, "20 % of the pixels are clipped"),
        ({"black_fraction": 0.3}, Verdict.NOTE, "30 % of the pixels are black"),
        ({"black_fraction": 0.95}, Verdict.WARNING, "95 % of the pixels are black"),
        ({"noise": 0.02}, Verdict.NOTE, "15.0 times the noise"),
        ({"noise": 0.1}, Verdict.WARNING, "3.0 times the noise"),
        ({"sharpness": 0.4}, Verdict.WARNING, "40 % of the usual sharpness"),
        ({"alignment_residual_px": 0.7}, Verdict.NOTE, "left 0.7 px"),
        ({"alignment_residual_px": 3.0}, Verdict.WARNING, "left 3.0 px"),
        ({"leave_one_out_error": 0.6}, Verdict.WARNING, "error of 60 %"),
    ],
)
def test_each_flaw_names_its_photograph(changes: Any, verdict: Any, words: str) -> None:
    (found,) = findings(changes)
    assert (found.verdict, found.source) == (verdict, "c.png")
    assert words in found.text


def test_extrapolation_says_little_against_the_darkest_and_hides_no_worse_one() -> None:
    def about(**errors: float) -> list[tuple[str | None, Verdict]]:
        qualities = [fine(leave_one_out_error=errors.get(name[0], 0.1)) for name in NAMES]
        found = report(NAMES, MEANS, qualities).findings
        return [(each.source, each.verdict) for each in found if "predicted" in each.text]

    assert about(a=0.9) == [("a.png", Verdict.NOTE), ("b.png", Verdict.GOOD)]
    assert about(a=0.9, c=0.6) == [("a.png", Verdict.NOTE), ("c.png", Verdict.WARNING)]
    assert about(a=0.6, c=0.9) == [("c.png", Verdict.WARNING)]


def test_means_that_fall_are_named() -> None:
    (found,) = findings({}, np.array([0.1, 0.3, 0.2, 0.4]))
    assert found.verdict == Verdict.WARNING
    assert "falls at c.png" in found.text


def test_lamps_on_several_sides_make_no_photograph_doubtful_by_its_brightness() -> None:
    qualities = [fine(leave_one_out_error=7.3 if name == "c.png" else 0.1) for name in NAMES]
    azimuth = np.radians([0.0, 90.0, 180.0, 270.0])
    health = report(NAMES, np.array([0.1, 0.3, 0.2, 0.4]), qualities, azimuth)
    assert health.warnings == []
    (found,) = [each for each in health.findings if each.verdict is Verdict.NOTE]
    assert found.source == "c.png"
    assert "does not know sides" in found.text
    one_arc = report(NAMES, np.array([0.1, 0.3, 0.2, 0.4]), qualities, np.radians([0.0, 1.0, 0.0, 1.0]))
    assert len(one_arc.warnings) == 2


def test_leave_one_out_of_proportional_photographs_is_exact() -> None:
    base = np.random.default_rng(0).random((8, 9, 3)).astype(np.float32)
    samples = base * MEANS.astype(np.float32)[:, None, None, None]
    assert leave_one_out(samples, MEANS) == pytest.approx([0.0] * 4, abs=1e-6)


def test_leave_one_out_finds_the_odd_one() -> None:
    base = np.random.default_rng(0).random((8, 9, 3)).astype(np.float32)
    samples = base * MEANS.astype(np.float32)[:, None, None, None]
    samples[1] = samples[1, ::-1]
    errors = leave_one_out(samples, MEANS)
    assert int(np.argmax(cast(Any, errors))) == 1
    expected = np.sqrt(np.mean((0.2 * (base - base[::-1]).astype(float)) ** 2)) / 0.2
    assert errors[1] == pytest.approx(expected, rel=1e-5)


def test_leave_one_out_of_black_and_equal_photographs() -> None:
    samples = np.ones((4, 2, 2, 3), np.float32) * np.array([0, 0.5, 0.5, 1], np.float32)[:, None, None, None]
    errors = leave_one_out(samples, np.array([0, 0.5, 0.5, 1.0]))
    assert errors[0] is None
    assert errors[1:] == pytest.approx([0.0] * 3, abs=1e-6)
    assert leave_one_out(samples[:2], np.array([0.0, 0.5])) == [None, None]


def test_noise_is_measured_and_blur_lowers_sharpness() -> None:
    import cv2

    rng = np.random.default_rng(1)
    sharp = cv2.GaussianBlur(rng.random((300, 400)).astype(np.float32), (0, 0), 1.0)
    noise, _ = noise_and_sharpness(cv2.GaussianBlur(sharp, (0, 0), 8) + rng.normal(0, 0.02, sharp.shape).astype("f4"))
    assert noise == pytest.approx(0.02, rel=0.05)
    assert noise_and_sharpness(cv2.GaussianBlur(sharp, (0, 0), 3))[1] < 0.6 * noise_and_sharpness(sharp)[1]
    assert noise_and_sharpness(np.zeros((5, 5), np.float32)) == (0.0, 0.0)


def grainy(count: int, noise: float, seed: int) -> np.ndarray:
    """Photographs (count, 200, 220) of a matte surface of grains that differ in reflectance and slope."""
    rng = np.random.default_rng(seed)
    albedo = rng.uniform(0.2, 0.8, (200, 220))
    normal = np.stack([*rng.normal(0, 0.15, (2, 200, 220)), np.ones((200, 220))])
    normal /= np.linalg.norm(normal, axis=0)
    elevation, azimuth = rng.uniform(0.5, 1.4, count), rng.uniform(0, 6.28, count)
    across = np.cos(elevation)
    lights = np.stack([across * np.cos(azimuth), across * np.sin(azimuth), np.sin(elevation)], 1)
    shown = albedo * np.maximum(0, np.einsum("nc,chw->nhw", lights, normal))
    return (shown + rng.normal(0, noise, shown.shape)).astype(np.float32)


@pytest.mark.parametrize(("count", "at_most"), [(5, 3.0), (12, 1.5), (40, 1.5)])
def test_grain_is_not_noise(count: int, at_most: float) -> None:
    """The noise of the others adds to what is left, and grain in its own shadow is not spanned."""
    images = grainy(count, 0.003, count)
    alone = [noise_and_sharpness(image)[0] for image in images]
    assert min(alone) > 30 * 0.003
    found = np.array(noise_beside_grain([grain(image) for image in images])) / 0.003
    assert (found > 0.95).all()
    assert (found < at_most).all()


def test_grain_of_one_arc_is_told_by_three_photographs() -> None:
    """Grain without slopes differs from light to light by its brightness alone."""
    rng = np.random.default_rng(2)
    surface = rng.uniform(0.7, 1.3, (64, 80))
    images = [light * surface + rng.normal(0, 0.004, surface.shape) for light in (0.1, 0.3, 0.8)]
    found = np.array(noise_beside_grain([grain(image.astype(np.float32)) for image in images])) / 0.004
    assert found == pytest.approx([1.0, 1.1, 2.5], rel=0.15)


def test_noise_without_grain_stays() -> None:
    rng = np.random.default_rng(3)
    sigma = np.array([0.001, 0.004, 0.02, 0.003])
    images = [(0.5 + rng.normal(0, each, (180, 180))).astype(np.float32) for each in sigma]
    assert noise_beside_grain([grain(image) for image in images]) == pytest.approx(sigma, rel=0.05)
    nothing = [np.zeros(9, np.float32)] * 3
    assert noise_beside_grain(nothing) == [0.0, 0.0, 0.0]
