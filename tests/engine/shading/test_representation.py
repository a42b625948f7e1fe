"""The choice between the shading map and planes, and what is refused."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.core.health import Verdict
from engine.core.steps import Steps, drain
from engine.shading import representation
from engine.shading.directional.planes import DirectionalMap
from engine.shading.fidelity import Fidelity
from engine.shading.representation import check_worth, choose, has_sides
from engine.shading.shading_map import ShadingMap, build, sample_slices
from tests.engine.domes import dome


def give(found: Fidelity) -> Steps[Fidelity]:
    yield from ()
    return found


def test_photographs_that_are_left_out_choose_planes_for_a_dome() -> None:
    found = drain(choose(dome(), 4))
    assert isinstance(found.map, DirectionalMap)
    assert found.shown.leave_one_out < found.others["shading-map"].leave_one_out
    assert found.health.verdict is Verdict.GOOD
    assert found.health.figures["directional_leave_one_out_rmse_srgb8"] == found.shown.leave_one_out
    check_worth(dome(), found)


def test_a_shading_map_is_made_of_all_texels_only_where_it_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is judged on a grid, where it has the bits of the whole."""
    stack, good = dome(), Fidelity(0.0, 0.0, 8.0, 12)
    grid, whole = sample_slices(stack.radiance[:, 1:5], stack.mean_radiance, 4), drain(build(stack, 4))
    np.testing.assert_array_equal(grid.slices, whole.slices[:, 1:5])
    assert grid.r_max == whole.r_max
    monkeypatch.setattr(representation, "build", None)
    found = drain(choose(stack, 4))
    assert found.bytes_per_texel == {"directional": len(found.map.planes), "shading-map": 48}  # type: ignore[union-attr]
    monkeypatch.undo()
    monkeypatch.setattr(representation, "fidelity", lambda *_: give(good))
    taken = drain(choose(stack, 4))
    assert isinstance(taken.map, ShadingMap)
    np.testing.assert_array_equal(taken.map.slices, whole.slices)
    assert (taken.shown, taken.others) == (good, {"directional": found.shown})
    assert taken.bytes_per_texel == found.bytes_per_texel


def test_means_that_do_not_belong_to_the_pixels_are_refused_before_a_choice() -> None:
    stack = dome()
    for means, text in ((1.001 * stack.mean_radiance, "do not belong"), (0.0 * stack.mean_radiance, "no light")):
        with pytest.raises(InputError, match=text):
            drain(choose(dataclasses.replace(stack, mean_radiance=means), 4))


def test_one_arc_keeps_the_shading_map_and_weighs_nothing_else() -> None:
    arc = dataclasses.replace(dome(), azimuth=np.full(12, 1.0))
    unknown = dataclasses.replace(dome(), azimuth=None)
    for stack in (arc, unknown):
        assert not has_sides(stack, np.arange(12))
        found = drain(choose(stack, 4))
        assert isinstance(found.map, ShadingMap)
        assert found.others == {}


def test_a_wish_is_followed_and_what_cannot_be_is_refused() -> None:
    assert isinstance(drain(choose(dome(), 4, wanted="shading-map")).map, ShadingMap)
    assert isinstance(drain(choose(dome(), 4, wanted="directional")).map, DirectionalMap)
    with pytest.raises(InputError, match="too few"):
        drain(choose(dome(), 4, excluded=dome().sources[3:], wanted="directional"))


@pytest.mark.parametrize("wanted", ["shading-map", "directional"])
def test_a_map_that_is_worse_than_the_mean_image_is_refused(wanted: str) -> None:
    found = drain(choose(dome(), 4, wanted=wanted))  # type: ignore[arg-type]
    worse = dataclasses.replace(found, shown=Fidelity(9.0, 3.0, 8.0, 12))
    assert worse.health.verdict is Verdict.WARNING
    with pytest.raises(InputError, match=r"9 8-bit levels, their mean image 8.*--force"):
        check_worth(dome(), worse)
    check_worth(dataclasses.replace(dome(), azimuth=None), worse)


@pytest.mark.parametrize(("left_out", "verdict"), [(20.0, Verdict.GOOD), (33.4, Verdict.WARNING)])
def test_a_map_that_is_hardly_nearer_than_the_mean_image_is_not_called_good(left_out: float, verdict: Verdict) -> None:
    shown = Fidelity(left_out, 15.0, 34.4, 115)
    assert not shown.is_worse
    assert shown.finding().verdict is verdict


def test_a_photograph_that_the_others_contradict_is_named() -> None:
    """Another exposure than its neighbours have, which neither blackness nor clipping gives away."""
    sound = dome(24)
    radiance = np.array(sound.radiance)
    radiance[9] *= 0.4
    assert not drain(choose(sound, 4)).outliers
    (finding,) = drain(choose(dataclasses.replace(sound, radiance=radiance), 4)).outliers
    assert (finding.source, finding.verdict) == ("9", Verdict.WARNING)
    assert finding.sentence.startswith("9 is predicted from the others ")
