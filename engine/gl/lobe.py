"""Draws lobes of BRDFs: surfaces r(wo) over the hemisphere, on a disc with rings, with the light's direction.

Points are in the surface frame; the camera is in a world whose +Y is the surface's normal. Colours are sRGB-coded and
go to the framebuffer as they are.
64 × 64 points a lobe are 7,938 triangles; what bounds a frame in software is the number of pixels that they cover.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.geometry.camera import Camera
from engine.gl.program import find_uniform, load_program, set_uniforms

Rgb = tuple[float, float, float]

#: Colours are mixed by opacity; the image itself stays opaque, or the window would shine through it. The types of
#: moderngl leave the factors of opacity out.
MIXED: Any = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA, moderngl.ZERO, moderngl.ONE)

RINGS_DEG = (30.0, 60.0, 90.0)

#: The surface's tangent, normal and bitangent as the world's +X, +Y and −Z.
WORLD_FROM_SURFACE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class LobeSurface:
    """Points (R, C, 3) of one lobe, the angles (R, C, 2) of their directions in degrees, and its colour.

    With an `opacity` below 1 it hides nothing, and is drawn over what is opaque where it is in front of it.
    """

    points: NDArray[np.float32]
    angles_deg: NDArray[np.float32]
    colour: Rgb
    opacity: float = 1.0


@dataclass(frozen=True)
class LobeColours:
    """Background, rings and axes, the light's direction."""

    background: Rgb
    rings: Rgb
    light: Rgb


class LobeRenderer:
    """Owns the program and the buffers of what was drawn last; belongs to one context and its thread."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self.program = load_program(context, "lobe.vert", "lobe.frag")
        self._surfaces: tuple[
            Sequence[LobeSurface], list[tuple[moderngl.VertexArray, moderngl.Buffer, moderngl.Buffer]]
        ] = ((), [])
        self._lines: tuple[float, float] | None = None
        self._line_parts: tuple[moderngl.VertexArray, moderngl.Buffer] | None = None
        self._light_start = 0

    def draw(
        self,
        framebuffer: moderngl.Framebuffer,
        surfaces: Sequence[LobeSurface],
        light: tuple[float, float],
        camera: Camera,
        colours: LobeColours,
    ) -> None:
        """Draw over all of `framebuffer`; `light` is (theta, phi) in radians in the surface frame."""
        framebuffer.use()
        framebuffer.viewport = (0, 0, *framebuffer.size)
        framebuffer.clear(*colours.background, 1.0, depth=1.0)
        self.context.enable_only(self.context.DEPTH_TEST)
        matrix = camera.clip_from_model(np.zeros(3), 1.5, framebuffer.size[0] / max(1, framebuffer.size[1]))
        matrix[:, :3] = matrix[:, :3] @ WORLD_FROM_SURFACE
        find_uniform(self.program, "clip_from_surface").write(np.ascontiguousarray(matrix.T, np.float32))
        lines = self._prepare_lines(light)
        set_uniforms(self.program, {"lit": False, "colour": colours.rings})
        lines.render(self.context.LINES, vertices=self._light_start)
        set_uniforms(self.program, {"colour": colours.light})
        lines.render(self.context.LINES, first=self._light_start)
        if self._surfaces[0] is not surfaces:
            self._upload(surfaces)
        set_uniforms(self.program, {"lit": True, "eye": tuple(WORLD_FROM_SURFACE.T @ camera.eye)})
        pairs = list(zip(surfaces, self._surfaces[1], strict=True))
        for surface, (array, *_) in sorted(pairs, key=lambda pair: -pair[0].opacity):
            if surface.opacity < 1.0:
                self.context.enable(self.context.BLEND)
                self.context.blend_func = MIXED
                framebuffer.depth_mask = False
            set_uniforms(self.program, {"colour": surface.colour, "opacity": surface.opacity})
            array.render()
        framebuffer.depth_mask = True
        self.context.disable(self.context.BLEND)

    def _upload(self, surfaces: Sequence[LobeSurface]) -> None:
        self._release_surfaces()
        uploaded = []
        for surface in surfaces:
            rows, columns = surface.points.shape[:2]
            vertices = np.concatenate([surface.points, surface.angles_deg], axis=-1, dtype=np.float32)
            buffers = (self.context.buffer(vertices.tobytes()), self.context.buffer(_quads(rows, columns).tobytes()))
            layout = [(buffers[0], "3f 2f", "in_point", "in_angles")]
            uploaded.append((self.context.vertex_array(self.program, layout, buffers[1]), *buffers))
        self._surfaces = (surfaces, uploaded)

    def _prepare_lines(self, light: tuple[float, float]) -> moderngl.VertexArray:
        if self._lines == light and self._line_parts is not None:
            return self._line_parts[0]
        self._release_lines()
        still, moving = _still_lines(), _light_lines(*light)
        self._light_start = len(still)
        vertices = np.concatenate([still, moving]).astype(np.float32)
        buffer = self.context.buffer(vertices.tobytes())
        array = self.context.vertex_array(self.program, [(buffer, "3f", "in_point")])
        self._lines, self._line_parts = light, (array, buffer)
        return array

    def _release_lines(self) -> None:
        for item in self._line_parts or ():
            item.release()
        self._lines = self._line_parts = None

    def _release_surfaces(self) -> None:
        for items in self._surfaces[1]:
            for item in items:
                item.release()
        self._surfaces = ((), [])

    def release(self) -> None:
        """Free everything."""
        self._release_surfaces()
        self._release_lines()
        self.program.release()


def _quads(rows: int, columns: int) -> NDArray[np.uint32]:
    """(2 (rows − 1)(columns − 1), 3) triangles of a grid."""
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    below, right = corner + columns, corner + 1
    halves = [np.stack([corner, below, right], -1), np.stack([right, below, below + 1], -1)]
    return np.concatenate(halves).astype(np.uint32)


def _still_lines() -> NDArray[np.float64]:
    """Ends (N, 3) of line pieces: rings at the sine of some angles, a cross through them, the normal."""
    turn = np.linspace(0.0, 2.0 * np.pi, 97)
    pieces = []
    for angle in np.radians(RINGS_DEG):
        ring = np.sin(angle) * np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], -1)
        pieces.append(np.stack([ring[:-1], ring[1:]], axis=1).reshape(-1, 3))
    axes = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, 0], [0, 0, 1.0]])
    return np.concatenate([*pieces, axes])


def _light_lines(theta: float, phi: float) -> NDArray[np.float64]:
    """Ends (N, 3) of an arrow from the light to the middle, and of its dashed mirror direction."""
    towards = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
    aside = np.array([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), -np.sin(theta)])
    tips = [0.12 * towards + side * 0.03 * aside for side in (-1.0, 1.0)]
    arrow = [1.15 * towards, 0.02 * towards, 0.02 * towards, tips[0], 0.02 * towards, tips[1]]
    mirror = towards * (-1.0, -1.0, 1.0)
    dashes = [share * mirror for share in np.linspace(0.05, 1.15, 24)]
    return np.array(arrow + dashes)
