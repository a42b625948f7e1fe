"""Colours beyond Rec.709: told at import, and the working space that follows from them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.capture.gamut import SpaceChoice
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.object_outline import ObjectOutline
from engine.capture.stack import ImageStack, open_stack
from engine.capture.stack_record import parse_record, write_record
from engine.core.colour import REC_709, REC_2020
from engine.core.errors import InputError, UsageError
from engine.core.steps import drain
from engine.images.encode import rgb_channels, write_exr
from engine.shading.representation import choose

NARROW, WIDE = (0.4, 0.5, 0.3), (0.03, 0.6, 0.05)


def _import(
    tmp_path: Path, share: float, choice: SpaceChoice, mask: ObjectOutline | None = None
) -> tuple[ImageStack, np.ndarray]:
    """Photographs in linear Rec.2020, of which a share of the columns is a green beyond Rec.709."""
    colour = np.empty((30, 40, 3), np.float32)
    colour[:], colour[:, : round(40 * share)] = NARROW, WIDE
    random = np.random.default_rng(1)
    colour *= random.uniform(0.7, 1.0, (30, 40, 1)).astype(np.float32)
    (tmp_path / "in").mkdir()
    for elevation in (30, 60, 90):
        image = colour * np.float32(np.sin(np.radians(elevation)))
        write_exr(tmp_path / "in" / f"wood_{elevation}.exr", rgb_channels(image), half=False, space=REC_2020)
    settings = ImportSettings(motion="none", working_space=choice, mask=mask)
    return drain(import_stack(find([tmp_path / "in"]), settings, tmp_path / "stack")), colour


@pytest.mark.parametrize(
    ("share", "choice", "space", "said"),
    [
        (0.25, "rec709", REC_709, "Colours of 25 % of the texels lie beyond Rec.709, by up to"),
        (0.25, "auto", REC_2020, "maps of the surface are made in linear Rec.2020, beyond which lie none"),
        (0.0, "auto", REC_709, ""),
        (0.0, "rec2020", REC_2020, "no colours lie beyond Rec.709"),
    ],
)
def test_colours_beyond_are_told(tmp_path: Path, share: float, choice: SpaceChoice, space: object, said: str) -> None:
    stack, colour = _import(tmp_path, share, choice)
    assert stack.working_space == space
    found = [finding.text for finding in stack.health.findings if "Rec.709" in finding.text]
    assert said in " ".join(found)
    assert len(found) == bool(said)
    np.testing.assert_allclose(stack.radiance[2] @ REC_2020.from_rec709.T, colour, atol=1e-5)
    made = drain(choose(stack, 3))
    assert [finding.text for finding in made.remarks] == [
        "colours of 25 % of the texels lie beyond Rec.709: slices keep them, and a power law clips them"
    ] * bool(share)
    if share:
        assert stack.provenance["gamut"]["beyond_rec709"] == pytest.approx(share)
        lowest = np.array(WIDE) @ REC_2020.to_rec709.T
        assert stack.provenance["gamut"]["distance"] == pytest.approx(-lowest.min() / lowest.max(), rel=1e-4)


def test_colours_around_an_object_do_not_count(tmp_path: Path) -> None:
    """As those of a chart beside it."""
    stack, _ = _import(tmp_path, 0.25, "auto", ObjectOutline(((12.5, 3.0), (36.0, 3.0), (36.0, 26.0), (12.5, 26.0))))
    assert stack.working_space == REC_709
    assert stack.provenance["gamut"]["beyond_rec709"] == 0.0
    assert not any("Rec.709" in finding.text for finding in stack.health.findings)


def test_other_spaces_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="unknown working space 'p3'; choose from rec709, rec2020, acescg, auto"):
        ImportSettings(working_space="p3")  # type: ignore[arg-type]
    _import(tmp_path, 0.0, "auto")
    path = tmp_path / "stack" / "stack.json"
    record, _ = parse_record(path.read_bytes(), path, "")
    record.provenance["working_space"] = "linear Rec.2100"
    path.write_bytes(write_record(record))
    with pytest.raises(InputError, match="states a working space that is not known"):
        open_stack(tmp_path / "stack")
