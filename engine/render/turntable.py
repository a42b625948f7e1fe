"""A turntable: the scene of each frame of a full turn of the model, of the light, or of both together.

The model itself stays where it is. That it turns before a camera and a light that rest is the same image as camera
and light that turn the other way, so a bake can be drawn as it is, and only light is computed anew:

    model   the camera and the light turn by −a
    light   the light turns by +a, lights near the model with it
    both    the camera turns by −a: the light is fixed to the model

Angles are about +Y, anticlockwise from above, as those of environments (`DistantLights.rotated`); the axis goes through
the middle of the model.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import cos, pi, sin
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from engine.geometry.camera import Camera, Vector, frame
from engine.light.near_lamps import NearLamp
from engine.scene.scene import Scene

Turns = Literal["model", "light", "both"]
#: Vertices, and positions of the turn, that a camera is placed by.
FRAMED_BY, FRAMES_FRAMED = 4000, 24

TURNS: tuple[Turns, ...] = get_args(Turns)


def turn(scene: Scene, angle: float, turns: Turns) -> Scene:
    """`scene` after a part of the turn by `angle` in radians."""
    if turns != "light":
        scene = replace(scene, camera=camera_about(scene.camera, -angle, middle(scene.mesh.positions)))
    if turns == "both":
        return scene
    light = angle if turns == "light" else -angle
    lamps = tuple(replace(lamp, direction=about_y(lamp.direction, light)) for lamp in scene.lamps)
    return replace(
        scene,
        light=about_y(scene.light, light),
        environment_rotation=scene.environment_rotation + light,
        lamps=lamps,
        near_lamps=tuple(near_about(lamp, light, middle(scene.mesh.positions)) for lamp in scene.near_lamps),
    )


def near_about(lamp: NearLamp, angle: float, axis: Vector) -> NearLamp:
    """A light near the model, turned by `angle` about the vertical through the point `axis`."""
    assert lamp.across is not None
    facing, across = about_y(lamp.facing, angle), about_y(lamp.across, angle)
    return replace(lamp, position=_move(lamp.position, angle, axis), facing=facing, across=across)


def frames(scene: Scene, count: int, turns: Turns) -> Iterator[Scene]:
    """The scenes of `count` frames, the first as it is; the one after the last would be the first again."""
    return (turn(scene, 2.0 * pi * number / count, turns) for number in range(count))


def camera_about(camera: Camera, angle: float, axis: Vector) -> Camera:
    """The camera, turned by `angle` about the vertical through the point `axis`."""
    eye, target = _move(camera.eye, angle, axis), _move(camera.target, angle, axis)
    return replace(camera, eye=eye, target=target, up=about_y(camera.up, angle))


def _move(point: Vector, angle: float, axis: Vector) -> Vector:
    x, y, z = about_y((point[0] - axis[0], point[1], point[2] - axis[2]), angle)
    return axis[0] + x, y, axis[2] + z


def middle(positions: NDArray[Any]) -> Vector:
    """The middle of the box around `positions` (V, 3)."""
    x, y, z = (np.asarray(positions, np.float64).min(axis=0) + np.asarray(positions, np.float64).max(axis=0)) / 2.0
    return float(x), float(y), float(z)


def frame_all_round(positions: NDArray[Any], aspect: float) -> Camera:
    """The camera that sees the whole model in each frame of its turn, as `frame` sees it in one."""
    few = np.asarray(positions, np.float64)[:: max(1, len(positions) // FRAMED_BY)]
    x0, _, z0 = middle(positions)
    around = [few]
    for angle in np.arange(1, FRAMES_FRAMED) * (2.0 * pi / FRAMES_FRAMED):
        x, y, z = (few - (x0, 0.0, z0)).T
        turned_x, turned_z = x * cos(angle) + z * sin(angle), z * cos(angle) - x * sin(angle)
        around.append(np.stack([turned_x + x0, y, turned_z + z0], axis=1))
    return frame(np.concatenate(around), aspect)


def about_y(vector: Vector, angle: float) -> Vector:
    """`vector` turned about +Y: from +Z to +X after pi / 2."""
    x, y, z = (float(value) for value in vector)
    return x * cos(angle) + z * sin(angle), y, z * cos(angle) - x * sin(angle)
