"""Shadow maps: what sharp lights see of a model, as depths that the shader of direct light compares with.

Every light has views, all in one texture of depths (Williams1978): a distant one a parallel view of the model along its
direction, a point of a light near the model a view of the model's sphere, or six views all around where it is inside
that. The fewer the views, the finer each. What lies outside all views of a light is lit: nothing but the model casts
shadows there. `resources/shaders/shadow_maps.glsl` looks places up, moved along their normals by about the width of a
texel, within which depths are not told apart. Edges of shadows lie where those of `engine.render.direct` do, to a texel
of the map; of lights near the model that are not points, the share that is seen is that of `POINTS` points.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.core.directions import normalize, world_from_tangent
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.gl.buffers import MeshBuffers
from engine.gl.context import NO_SCISSOR, Limits
from engine.gl.program import find_uniform, load_program, set_uniforms
from engine.light.near_lamps import NearLamp, sample_pattern
from engine.scene.scene import Scene

Array = NDArray[np.float64]

#: Longest side of the texture, of one view, and the views that it holds at most.
ATLAS, VIEW, MOST = 4096, 2048, 1024

#: Points of a light near the model, and the distance in radii of the model from which it sees it in one view.
POINTS, OUTSIDE = 16, 1.25

#: Texture units of the depths and of the views, beside those of factors.
DEPTH_UNIT, VIEW_UNIT = 8, 10


@dataclass(frozen=True)
class Key:
    """All that shadow maps depend on, which a camera is not part of.

    `directions` are the bytes of those of the distant lights that cast shadows, from the light number `first` on.
    """

    mesh: Mesh
    ground: Ground | None
    first: int
    directions: bytes
    near_lamps: tuple[NearLamp, ...]


def key_of(scene: Scene) -> Key | None:
    """The key of a scene's shadow maps; None where nothing casts shadows."""
    if not scene.shadows or not (scene.casting or scene.near_lamps):
        return None
    directions = scene.sharp_lights.direction.tobytes()
    return Key(scene.mesh, scene.ground, scene.casting.start, directions, scene.near_lamps)


class ShadowMaps:
    """Owns the depths of all views of one scene's lights, drawn when it is made, and the texture of the views."""

    def __init__(
        self, context: moderngl.Context, key: Key, casters: list[MeshBuffers], reach: float, texture_limits: Limits
    ) -> None:
        """`casters` have their vertices about the centre of the mesh, and all are within `reach` of it."""
        views = list(_distant_views(key, reach))
        self._near: list[tuple[int, int, int]] = []  # the first view, points, and views of each point
        for lamp in key.near_lamps:
            of_points = [_near_views(place, key.mesh.radius, reach) for place in _points_of(lamp, key.mesh.centre)]
            self._near.append((len(views), len(of_points), len(of_points[0])))
            views += [view for point in of_points for view in point]
        self._first, self._count = key.first, len(views) - sum(points * of_each for _, points, of_each in self._near)
        self._grid = max(1, math.ceil(math.sqrt(len(views))))
        self._side = max(1, min(VIEW, min(ATLAS, texture_limits.texture_size) // self._grid))
        self._depths = context.depth_texture((self._grid * self._side,) * 2)
        self._depths.compare_func = ""
        self._depths.filter = (context.NEAREST, context.NEAREST)
        self._draw(context, views, casters)
        texels = np.zeros((len(views), 5, 4), np.float32)
        for row, (matrix, width) in zip(texels, views, strict=True):
            row[:4], row[4, 0] = matrix.T, width / self._side
        self._views = context.texture((5, max(1, len(views))), 4, texels, dtype="f4")
        self._views.filter = (context.NEAREST, context.NEAREST)

    def _draw(self, context: moderngl.Context, views: list[View], casters: list[MeshBuffers]) -> None:
        bound, target = context.fbo, context.framebuffer(depth_attachment=self._depths)
        program = load_program(context, "shadow_maps.vert", "shadow_maps.frag")
        try:
            target.use()
            target.scissor = NO_SCISSOR
            target.clear()
            context.enable_only(context.DEPTH_TEST)
            for number, (matrix, _) in enumerate(views):
                row, column = divmod(number, self._grid)
                target.viewport = (column * self._side, row * self._side, self._side, self._side)
                find_uniform(program, "clip_from_model").write(np.ascontiguousarray(matrix.T, np.float32))
                for each in casters:
                    each.draw(program)
        finally:
            bound.use()
            target.release()
            for each in casters:
                array = each.arrays.pop(program, None)
                if array is not None:
                    array.release()
            program.release()

    def bind(self, program: moderngl.Program) -> None:
        self._depths.use(DEPTH_UNIT)
        self._views.use(VIEW_UNIT)
        values = {"shadow_depths": DEPTH_UNIT, "shadow_views": VIEW_UNIT, "shadow_grid": self._grid}
        set_uniforms(program, {**values, "first_casting": self._first, "casting_count": self._count})
        if self._near:
            find_uniform(program, "near_shadows").write(np.array(self._near, np.int32))

    def release(self) -> None:
        self._depths.release()
        self._views.release()


#: The clip space of a view from places about the centre of the mesh (4, 4), and the width of what it shows at w = 1.
View = tuple[Array, float]


def _distant_views(key: Key, reach: float) -> Iterator[View]:
    """Parallel views that hold the model, and the depth of all there is."""
    radius = key.mesh.radius
    for direction in np.frombuffer(key.directions).reshape(-1, 3):
        axes = world_from_tangent(direction).T
        matrix = np.eye(4)
        matrix[:2, :3], matrix[2, :3] = axes[:2] / radius, -axes[2] / reach
        yield matrix, 2.0 * radius


def _points_of(lamp: NearLamp, centre: Array) -> Array:
    """Points (P, 3) of a lamp about the centre of the model; a sphere is the disc that the centre sees."""
    place = np.asarray(lamp.position) - centre
    if lamp.is_point:
        return place[None]
    pattern = sample_pattern(lamp, POINTS)
    if lamp.shape != "sphere":
        return np.asarray(place + pattern @ lamp.half_sides)
    across = world_from_tangent(normalize(place, (0.0, 1.0, 0.0)))[:, :2].T
    return np.asarray(place + lamp.radius * (pattern @ across))


def _near_views(place: Array, radius: float, reach: float) -> list[View]:
    """One view from `place` of the sphere of the model, or six all around."""
    distance = float(np.linalg.norm(place))
    far = distance + reach
    if distance > OUTSIDE * radius:
        near = 0.5 * (distance - radius)
        tangent = radius / math.sqrt(distance**2 - radius**2)
        return [_perspective(place, -place / distance, tangent, near, far)]
    six = np.concatenate([np.eye(3), -np.eye(3)])
    return [_perspective(place, towards, 1.0, 1e-3 * radius, far) for towards in six]


def _perspective(place: Array, towards: Array, tangent: float, near: float, far: float) -> View:
    axes = world_from_tangent(-towards).T
    matrix = np.zeros((4, 4))
    matrix[:2, :3], matrix[3, :3] = axes[:2] / tangent, -axes[2]
    matrix[2, :3] = -axes[2] * (far + near) / (far - near)
    matrix[:, 3] = -matrix[:, :3] @ place
    matrix[2, 3] -= 2.0 * far * near / (far - near)
    return matrix, 2.0 * tangent
