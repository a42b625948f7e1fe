"""Variations over a model: which methods show it, as what they bake it, and what is said where they do not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from app.document.bake_request import choices_for, make_request
from app.document.document import Project
from app.document.variation import (
    Blend,
    Colours,
    VariedParameter,
    as_baked,
    images_of,
    light_with,
    select_baked,
    select_shown,
    settings_with,
    words_on_left_out,
)
from app.project.bakes import place_of
from app.project.photographs import files_of, photographs
from engine.brdf.brdf import brdf_from_text
from engine.core.errors import UsageError
from engine.geometry.shapes import shape
from engine.images.encode import rgb_channels, write_exr
from engine.transport import method as transport
from engine.transport.baking.spatially_varying import variation_from_text

GGX = brdf_from_text("ggx:alpha=0.3")
WIDTH, HEAD_ON, DIFFUSE = (
    VariedParameter(name, 0.1, 0.5, source) for name, source in (("alpha", "x"), ("f0", "y"), ("kd", "z"))
)
BLEND, COLOURS = Blend("phong:exponent=30"), Colours(Path("cloth.png"))
ALL = (WIDTH, BLEND, HEAD_ON, COLOURS, DIFFUSE)


def test_each_method_shows_what_it_has_a_place_for() -> None:
    shown = {name: select_shown(transport.method_of(name), GGX, ALL) for name in transport.names()}
    assert shown == {"sh": (WIDTH, HEAD_ON), "wavelet": (BLEND, COLOURS), "gaussian": (WIDTH, HEAD_ON, DIFFUSE)}
    assert select_baked(transport.method_of("wavelet"), GGX, ALL) == (BLEND,), "colours are put on a finished bake"
    assert select_shown(transport.method_of("sh"), brdf_from_text("phong"), ALL) == (DIFFUSE,)


def test_settings_and_light_have_them_as_the_command_line_says_them() -> None:
    wavelet, sh = choices_for("wavelet"), choices_for("sh")
    settings = settings_with(wavelet.settings, ALL)
    assert (settings.blend, settings.albedo) == (("phong:exponent=30:y",), "cloth.png")
    assert light_with(wavelet.light, ALL).albedo == "cloth.png"
    assert light_with(sh.light, (WIDTH,)).vary == ("alpha=0.1:0.5:x",)
    assert as_baked((WIDTH, BLEND)) == (variation_from_text("alpha=0.1:0.5:x"),)
    given = choices_for("wavelet", albedo="other.png").settings
    assert settings_with(given, ALL).albedo == "other.png", "what is said on the command line holds"


def test_a_mode_says_what_it_leaves_out_and_who_shows_it() -> None:
    said = words_on_left_out("Material", "shading-map", GGX, (WIDTH, COLOURS))
    assert said.startswith("Material leaves out what varies over the model, ‘Roughness α’, ‘Colours’: ")
    assert "spherical harmonics or Gaussians or wavelets" in said
    assert words_on_left_out("SH", "sh", GGX, (WIDTH, HEAD_ON)) == ""
    assert "no such parameter" in words_on_left_out("SH", "sh", brdf_from_text("lambert"), (WIDTH,))


def test_what_varies_otherwise_is_another_bake(tmp_path: Path) -> None:
    for name, radiance in (("a.exr", 0.2), ("b.exr", 0.7)):
        write_exr(tmp_path / name, rgb_channels(flat(radiance)), half=False)
    first, second = (VariedParameter("alpha", 0.1, 0.5, tmp_path / name) for name in ("a.exr", "b.exr"))
    sphere, choices = shape("sphere"), choices_for("sh", order=3)

    def place(*variations: VariedParameter) -> Path:
        return place_of(make_request(sphere, None, GGX, choices, None, variations), tmp_path)

    head_on = [VariedParameter("f0", 0.1, 0.5, tmp_path / name) for name in ("a.exr", "b.exr")]
    places = [place(), place(WIDTH), place(HEAD_ON), place(first), place(second)]
    places += [place(first, head_on[0]), place(first, head_on[1]), place(second, head_on[0])]
    assert len(set(places)) == len(places)
    moved = tmp_path / "moved"
    moved.mkdir()
    (tmp_path / "a.exr").rename(moved / "c.exr")
    assert place(VariedParameter("alpha", 0.1, 0.5, moved / "c.exr")) == places[3], "an image counts by its content"


def flat(value: float) -> NDArray[np.float32]:
    return np.full((4, 4, 3), value, np.float32)


def test_images_are_files_of_the_project_and_no_photographs() -> None:
    project = Project(variations=(VariedParameter("alpha", 0.1, 0.5, Path("mask.png")), BLEND, COLOURS))
    assert files_of(project) == images_of(project.variations) == (Path("mask.png"), Path("cloth.png"))
    assert photographs(project) == ()


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="cannot go"):
        VariedParameter("alpha", float("nan"), 1.0)
    with pytest.raises(ValueError, match="not a source"):
        VariedParameter("alpha", 0.0, 1.0, "w")
    with pytest.raises(UsageError, match="unknown BRDF"):
        Blend("nonsense")
