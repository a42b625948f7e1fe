"""The comparison of BRDFs as a value: identities, names, files; and the drawn lengths of values."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.brdf.lobe_view import lengths
from app.commands.brdf_figures import ALBEDO_DEG, albedos, curves, thumbnail
from app.document.comparison import MARKERS, Comparison
from app.window.failures import explain
from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.diffuse import Lambert
from engine.core.colour import srgb_decode
from engine.core.errors import UsageError
from engine.core.steps import drain


def test_no_two_share_colour_and_marker_and_what_is_freed_is_used_again() -> None:
    comparison = Comparison()
    for _ in MARKERS:
        comparison = comparison.added("GGX", Lambert())
    assert len({(entry.colour, entry.marker) for entry in comparison.entries}) == len(MARKERS)
    assert len({entry.marker for entry in comparison.entries}) == len(MARKERS)
    assert len({entry.name for entry in comparison.entries}) == len(MARKERS)
    assert comparison.free_identity is None
    with pytest.raises(UsageError, match="at most") as refused:
        comparison.added("one more", Lambert())
    assert explain(refused.value) == (f"At most {len(MARKERS)} BRDFs are compared.", "")
    gone = comparison.entries[3]
    again = comparison.removed(gone.identity).added("Ward", Lambert())
    assert (again.entries[-1].colour, again.entries[-1].marker) == (gone.colour, gone.marker)


def test_a_file_is_in_the_library_once_and_found_again_in_its_place() -> None:
    one, two, three = (Path(name) for name in "abc")
    comparison = Comparison().with_file(one).with_file(two).with_file(one)
    assert comparison.files == (one, two)
    assert comparison.with_file(three, instead_of=two).files == (one, three)
    assert comparison.with_file(one, instead_of=two).files == (one,)


def test_lengths_grow_with_the_value_and_end_at_one() -> None:
    values = np.array([-1.0, 0.0, 1e-3, 0.5, 1.0, 2.0, 1e9])
    for logarithmic in (False, True):
        length = lengths(values, 2.0, logarithmic=logarithmic)
        assert length[:2].tolist() == [0.0, 0.0]
        assert length[-2:].tolist() == [1.0, 1.0]
        assert (np.diff(length[1:-1]) > 0.0).all()
    assert lengths(values, 2.0, logarithmic=False)[4] == 0.5
    assert lengths(np.array([0.1]), 10.0, logarithmic=True)[0] == pytest.approx(np.log(2.0) / np.log(101.0))


def test_a_lambertian_is_the_same_everywhere_and_reflects_its_albedo() -> None:
    found = drain(curves([(7, Lambert((0.6, 0.6, 0.6)), None)], 0.9))[7]
    for values in (found.lobe[:-1], found.polar, found.half_difference):
        assert values == pytest.approx(0.6 / np.pi)
    assert found.highest == pytest.approx(0.6 / np.pi)
    _, albedo = drain(albedos([(7, Lambert((0.6, 0.6, 0.6)))]))[7]
    assert albedo == pytest.approx(np.full(len(ALBEDO_DEG), 0.6), rel=2e-3)


def test_a_mirror_lobe_is_longest_away_from_the_light() -> None:
    found = drain(curves([(0, brdf_from_text("phong:exponent=200"), None)], np.radians(40.0)))[0]
    assert np.degrees(found.theta_o[np.argmax(found.polar)]) == pytest.approx(40.0, abs=1.0)
    farthest = found.wo.reshape(-1, 3)[np.argmax(found.lobe)]
    assert np.degrees(np.arctan2(farthest[0], farthest[2])) == pytest.approx(40.0, abs=2.0)


def test_what_does_not_depend_on_the_light_is_kept() -> None:
    brdf = brdf_from_text("ggx:alpha=0.3")
    first = drain(curves([(0, brdf, None)], 0.4))[0]
    assert drain(curves([(0, brdf, first)], 0.8))[0].half_difference is first.half_difference
    assert drain(curves([(0, Lambert(), first)], 0.8))[0].half_difference is not first.half_difference


def test_values_at_the_horizon_do_not_decide_the_scale() -> None:
    class Grazing:
        def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
            lowest = np.minimum(np.broadcast_to(wi, wo.shape)[..., 2], wo[..., 2])
            return np.where(lowest > 0.01, 1.0, 1e6)[..., None] * np.ones(3)

    assert drain(curves([(0, Grazing(), None)], 0.4))[0].highest == pytest.approx(1.0)


def test_a_thumbnail_is_a_lit_sphere_of_the_brdf() -> None:
    image = thumbnail(Lambert((0.5, 0.25, 0.0)), 36)
    assert image.shape == (36, 36, 4)
    assert image[0, 0].tolist() == [0, 0, 0, 0]
    assert image[18, 18, 3] == 255
    linear = srgb_decode(image[14, 14, :3] / 255.0)
    assert linear[0] > 0.1
    assert linear[1] == pytest.approx(linear[0] / 2.0, rel=0.05)
    assert linear[2] == 0.0
    assert image[10, 10, 0] > image[26, 26, 0]
