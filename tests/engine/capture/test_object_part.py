"""Shading fits of an object before a background: they are those of a capture of the object alone."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.mask import pack
from engine.capture.object_part import object_share, take_object
from engine.capture.stack import ImageStack
from engine.core.steps import drain
from engine.shading.compare import compare
from engine.shading.directional.planes import DirectionalMap
from engine.shading.representation import choose
from engine.shading.shading_map import ShadingMap
from engine.surface.relight import errors
from tests.engine.capture.calibration.generated import Capture, render, write

#: The object in the photographs, as a crop and as a mask.
LEFT, TOP, WIDTH, HEIGHT = 8, 6, 30, 26


@pytest.fixture(scope="module")
def stacks(tmp_path_factory: pytest.TempPathFactory) -> tuple[ImageStack, ImageStack]:
    """A stack with a mask, and one that was cut to the object."""
    folder = tmp_path_factory.mktemp("capture")
    rendered = render(Capture(seed=5, height=40, width=48, lamps=9, file_format="png16"))
    photographs = rendered.photographs.copy()
    photographs[:, : TOP - 2] = np.random.default_rng(2).random(photographs[:, : TOP - 2].shape) * 0.9
    sources = find([write(dataclasses.replace(rendered, photographs=photographs), folder / "photographs")])
    found = []
    for name, crop in (("whole", None), ("cut", (LEFT, TOP, WIDTH, HEIGHT))):
        settings = ImportSettings(calibrate="none", motion="none", crop=crop)
        found.append(drain(import_stack(sources, settings, folder / name)))
    mask = np.zeros((40, 48), np.bool_)
    mask[TOP : TOP + HEIGHT, LEFT : LEFT + WIDTH] = True
    whole, cut = found
    return dataclasses.replace(whole, provenance={**whole.provenance, "mask": pack(mask)}), cut


@pytest.mark.parametrize("representation", ["shading-map", "directional"])
def test_fits_and_errors_are_those_of_the_object_alone(
    stacks: tuple[ImageStack, ImageStack], representation: str
) -> None:
    whole, cut = stacks
    taken, mask, health = drain(take_object(whole))
    assert mask is not None
    assert object_share(taken) == pytest.approx(WIDTH * HEIGHT / (40 * 48))
    assert "the background is transparent" in health.findings[0].text
    rows, columns = slice(TOP, TOP + HEIGHT), slice(LEFT, LEFT + WIDTH)
    np.testing.assert_array_equal(taken.radiance[2:5, rows, columns], cut.radiance[2:5])
    assert not taken.radiance[3][~mask].any()
    assert not taken.radiance[3, 4:9, ::2][~mask[4:9, ::2]].any()
    ours, alone = (drain(choose(each, 6, wanted=representation)) for each in (taken, cut))  # type: ignore[arg-type]
    for name in ("leave_one_out", "in_sample", "mean_picture"):
        assert getattr(ours.shown, name) == pytest.approx(getattr(alone.shown, name), rel=0.02), name
    if isinstance(ours.map, ShadingMap):
        assert isinstance(alone.map, ShadingMap)
        np.testing.assert_allclose(ours.map.slices[:, rows, columns], alone.map.slices, rtol=1e-5, atol=1e-7)
        assert not ours.map.slices[:, ~mask].any()
    else:
        assert isinstance(ours.map, DirectionalMap)
        assert isinstance(alone.map, DirectionalMap)
        assert ours.map.leave_one_out == ours.shown.leave_one_out
        shown, wanted = (each.image(each.lights[0]) for each in (ours.map, alone.map))
        assert np.abs(shown[rows, columns] - wanted).mean() < 2e-3


def test_representations_are_compared_by_the_object_alone(stacks: tuple[ImageStack, ImageStack]) -> None:
    used = np.arange(9)
    (ours, maps), (alone, maps_alone) = (
        ({row.name: row for row in drain(compare(each, used, 6))}, drain(errors(each, used)))
        for each in (drain(take_object(stacks[0]))[0], stacks[1])
    )
    for name in ("mean", "ptm", "shading-map"):
        assert ours[name].leave_one_out == pytest.approx(alone[name].leave_one_out, rel=0.02), name
        assert ours[name].in_sample == pytest.approx(alone[name].in_sample, rel=0.05), name
    assert maps.left_out == pytest.approx(maps_alone.left_out, rel=0.02)


def test_a_stack_without_a_mask_stays_and_a_tile_shows_all(stacks: tuple[ImageStack, ImageStack]) -> None:
    whole, cut = stacks
    assert drain(take_object(cut))[0] is cut
    taken, mask, health = drain(take_object(whole, to_tile=True))
    assert (taken, mask) == (whole, None)
    assert "mask of the object is not used" in health.findings[0].text


def test_arrays_in_memory_are_masked_as_files_are(stacks: tuple[ImageStack, ImageStack], tmp_path: Path) -> None:
    whole, _ = stacks
    held = dataclasses.replace(whole, radiance=whole.radiance[:], saturated=whole.saturated[:])
    first, second = (drain(take_object(each))[0] for each in (whole, held))
    np.testing.assert_array_equal(first.radiance[:], second.radiance[:])
    np.testing.assert_array_equal(first.saturated[:], second.saturated[:])
    np.testing.assert_allclose(first.mean_radiance, second.mean_radiance)
