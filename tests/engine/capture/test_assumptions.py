"""The check of what the method assumes, on stacks whose answer is known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from engine.capture.assumptions import LEVELS, check_azimuths, compare_azimuths
from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE
from engine.core.health import Verdict
from engine.core.steps import drain
from engine.simulate.arc import LightArc
from engine.simulate.simulate import renderings
from tests.present import present

DEGREES = (10.0, 30.0, 50.0, 70.0, 90.0)


def stack(images: Any, azimuth_deg: Any, saturated: Any = None) -> ImageStack:
    radiance = np.asarray(images, np.float32)
    return ImageStack(
        radiance=radiance,
        saturated=np.zeros(radiance.shape[:3], bool) if saturated is None else saturated,
        elevation=np.radians(np.linspace(10, 90, len(radiance))),
        azimuth=None if azimuth_deg is None else np.radians(azimuth_deg),
        mean_radiance=radiance.mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE,
        sources=tuple(map(str, range(len(radiance)))),
        angle_source="user",
    )


def stripes(contrast: Any, levels: Any = (0.2, 0.6)) -> list[Any]:
    """Two photographs of stripes, mean `levels`, whose bright half has 1 + contrast of the mean."""
    pattern = np.where(np.arange(20) % 2 == 0, 1 + contrast, 1 - contrast)
    return [level * np.broadcast_to(pattern[None, :, None], (10, 20, 3)) for level in levels]


def simulate(sample: Any, azimuths_deg: Any, **settings: Any) -> Any:
    """Noise-free photographs at every azimuth."""
    images, azimuths = [], []
    for azimuth_deg in azimuths_deg:
        arc = LightArc(sample, size=96, azimuth=(math.radians(azimuth_deg),), **settings)
        images += drain(renderings(arc, [math.radians(angle) for angle in DEGREES]))
        azimuths += [azimuth_deg] * len(DEGREES)
    return stack(images, azimuths)


def test_images_that_depend_on_mean_radiance_alone_do_not_differ() -> None:
    images = [level * np.random.default_rng(0).random((10, 20, 3)) for level in (0.2, 0.5, 0.3, 0.9)]
    check = drain(check_azimuths(stack(images, (0, 0, 90, 90))))
    assert check is not None
    assert check.overall < 1e-6
    assert check.finding().verdict is Verdict.GOOD
    assert check.azimuths_deg == pytest.approx((0, 90))


def test_opposite_stripes_differ_by_twice_their_contrast() -> None:
    check = drain(check_azimuths(stack(stripes(0.3) + stripes(-0.3), (0, 0, 180, 180))))
    assert check is not None
    np.testing.assert_allclose(check.difference, 2 * 0.3, rtol=1e-6)
    assert check.mean_radiance == pytest.approx(tuple(0.2 + 0.4 * (np.arange(LEVELS) + 0.5) / LEVELS))
    finding = check.finding()
    assert finding.verdict is Verdict.NOTE
    assert "differ by 60 %" in finding.text


def test_three_sectors_are_compared_in_pairs() -> None:
    """Contrasts 0, c and -c: squared differences c², c² and 4c², on average 2c²."""
    images = stripes(0.0) + stripes(0.1) + stripes(-0.1)
    check = drain(check_azimuths(stack(images, (0, 0, 120, 120, 240, 240))))
    assert check is not None
    assert check.overall == pytest.approx(math.sqrt(2) * 0.1, rel=1e-6)
    assert check.finding().verdict is Verdict.NOTE


def test_levels_lie_where_all_sectors_have_photographs() -> None:
    check = drain(check_azimuths(stack(stripes(0.1) + stripes(0.1, (0.4, 0.9)), (0, 0, 90, 90))))
    assert check is not None
    assert check.mean_radiance == pytest.approx(tuple(0.4 + 0.2 * (np.arange(LEVELS) + 0.5) / LEVELS))


def test_clipped_texels_are_left_out() -> None:
    images = stripes(0.0) + stripes(0.0)
    broken = [image.copy() for image in images]
    broken[1][3, 4] = 5.0
    saturated = np.zeros((4, 10, 20), bool)
    saturated[1, 3, 4] = True
    means = stack(images, (0, 0, 90, 90)).mean_radiance
    damaged = stack(broken, (0, 0, 90, 90), saturated)
    object.__setattr__(damaged, "mean_radiance", means)
    assert present(drain(check_azimuths(damaged))).overall < 1e-6
    everything = stack(images, (0, 0, 90, 90), np.ones((4, 10, 20), bool))
    assert "cannot be compared" in present(drain(check_azimuths(everything))).finding().text


@pytest.mark.parametrize(
    "azimuth_deg",
    [None, (0, 0, 3, 3), (0, 0, 0, 90)],
    ids=["unknown", "one arc", "a single photograph in the other sector"],
)
def test_one_azimuth_has_nothing_to_compare(azimuth_deg: Any) -> None:
    assert drain(check_azimuths(stack(stripes(0.1) + stripes(-0.1), azimuth_deg))) is None


def test_ranges_that_do_not_meet_have_nothing_to_compare() -> None:
    images = stripes(0.1, (0.1, 0.2)) + stripes(0.1, (0.4, 0.9))
    assert drain(check_azimuths(stack(images, (0, 0, 90, 90)))) is None


def test_samples_of_a_stack_tell_the_same_as_the_whole() -> None:
    whole = stack(stripes(0.3) + stripes(-0.3), (0, 0, 180, 180))
    some = compare_azimuths(whole.radiance[:, ::2, :10], whole.mean_radiance, whole.azimuth)
    assert some is not None
    assert some.overall == pytest.approx(present(drain(check_azimuths(whole))).overall)


def test_plain_card_of_the_virtual_arc_keeps_the_assumptions_and_cloth_does_not() -> None:
    card = drain(check_azimuths(simulate("plain", (0, 90))))
    cloth = drain(check_azimuths(simulate("woven", (0, 90))))
    assert card is not None
    assert card.overall < 1e-5
    assert cloth is not None
    assert cloth.overall > 0.1
    assert cloth.finding().verdict is not Verdict.GOOD
