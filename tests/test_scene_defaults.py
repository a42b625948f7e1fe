"""One default of each setting of a scene: engine, command line and Python API."""

from __future__ import annotations

import dataclasses
import inspect

import numpy as np
import pytest

import lightarc
from app.cli.transport import render, scene_options
from engine.core.directions import world_direction
from engine.scene.scene import Scene
from engine.scene.settings import DEFAULTS


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
