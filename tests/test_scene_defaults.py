"""One default of each setting of a scene: engine, window, command line and Python API."""

from __future__ import annotations

import dataclasses
import inspect

import numpy as np
import pytest

import lightarc
from app.cli.transport import render, scene_options
from app.document.document import Look
from engine.core.directions import world_direction
from engine.core.params import parameters
from engine.scene.scene import Scene
from engine.scene.settings import DEFAULTS, SceneSettings


def test_engine_command_line_and_library_have_one_default_of_each_setting() -> None:
    fields = {field.name: field.default for field in dataclasses.fields(Scene)}
    assert fields["light"] == pytest.approx(tuple(world_direction(*np.radians(DEFAULTS.light_deg))))
    assert (fields["irradiance"], fields["repeats"]) == (DEFAULTS.irradiance, DEFAULTS.repeats)
    for function in (lightarc.make_scene, lightarc.render):
        signature = inspect.signature(function).parameters
        for name in ("irradiance", "repeats", "environment_rotation_deg"):
            assert signature[name].default == getattr(DEFAULTS, name)
    for options in (render.DEFAULTS, scene_options.defaults_of_options()):
        found = (options["intensity"], options["tile"], options["env_rotation_deg"])
        assert found == (DEFAULTS.irradiance, DEFAULTS.repeats, DEFAULTS.environment_rotation_deg)
    assert lightarc.make_scene("plane").light == pytest.approx(fields["light"])


#: Settings of the window by those of a scene: the factor on an environment has a field of its own there.
IN_THE_WINDOW = {
    "light_theta_deg": ("light_theta_deg",),
    "light_phi_deg": ("light_phi_deg",),
    "irradiance": ("irradiance", "gain"),
    "environment_rotation_deg": ("rotation_deg",),
    "repeats": ("repeats",),
}

#: Defaults that the window has of its own: it begins with an image to look at.
OWN = {"light_theta_deg": 55.0, "light_phi_deg": -30.0, "irradiance": 2.2, "repeats": 3.0}


def test_the_window_declares_what_the_others_do() -> None:
    look = Look()
    declared = {each.name: each for each in parameters(Look)}
    assert IN_THE_WINDOW.keys() == {each.name for each in parameters(SceneSettings)}
    for each in parameters(SceneSettings):
        for name in IN_THE_WINDOW[each.name]:
            assert getattr(look, name) == OWN.get(name, getattr(DEFAULTS, each.name)), name
            assert declared[name].unit == each.unit
            assert each.low <= declared[name].low < declared[name].high <= each.high, name
    fields = {field.name: field.default for field in dataclasses.fields(Scene)}
    for name in ("source", "lookup", "above", "directions"):
        assert getattr(look, name) == fields[name]
