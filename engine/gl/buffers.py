"""A mesh in GPU memory: interleaved float32 position (relative to the centre), normal and texture coordinates.

Colours of vertices as the lines of a texture: as many as one likes for each, which shaders fetch by number.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.geometry.mesh import BACKS, Mesh
from engine.gl.context import Limits
from engine.gl.program import find_uniform


class MeshBuffers:
    """Owns a vertex and an index buffer, tangents and colours once they are asked for, and a vertex array per program.

    Faces lie in the order of the parts of the model.

    Positions are relative to `centre` (3,), the mesh's own without one.
    """

    def __init__(self, context: moderngl.Context, mesh: Mesh, centre: NDArray[np.float64] | None = None) -> None:
        self.context = context
        position = (mesh.positions - (mesh.centre if centre is None else centre)).astype(np.float32)
        self.vertices = context.buffer(np.concatenate([position, mesh.normals, mesh.uv], axis=1).tobytes())
        self.mesh = mesh
        faces = mesh.faces
        if mesh.part is not None:
            some = [start + np.argsort(mesh.part[start:stop], kind="stable") for start, stop, _ in self._ranges()]
            faces = faces[np.concatenate(some)]
        self.indices = context.buffer(faces.tobytes())
        self.tangents: moderngl.Buffer | None = None
        self.colours: moderngl.Buffer | None = None
        self.arrays: dict[moderngl.Program, moderngl.VertexArray] = {}

    def draw(self, program: moderngl.Program, part: int | None = None) -> None:
        """Draw all faces, or those of one part of the model."""
        if program not in self.arrays:
            wanted = (("in_position", "3f"), ("in_normal", "3f"), ("in_uv", "2f"))
            layout = " ".join(
                size if name in program else size.replace("f", "f4").replace("f4", "x4") for name, size in wanted
            )
            names = [name for name, _ in wanted if name in program]
            content = [(self.vertices, layout, *names)]
            if "in_tangent" in program:
                self.tangents = self.tangents or self.context.buffer(self.mesh.tangents.tobytes())
                content.append((self.tangents, "3f", "in_tangent"))
            if "in_colour" in program:
                assert self.mesh.colours is not None
                self.colours = self.colours or self.context.buffer(self.mesh.colours.tobytes())
                content.append((self.colours, "3f", "in_colour"))
            self.arrays[program] = self.context.vertex_array(program, content, self.indices)
        for start, stop, is_doubled in self._ranges():
            if part is not None and self.mesh.part is not None:
                own = self.mesh.part[start:stop]
                start += int(np.count_nonzero(own < part))
                stop = start + int(np.count_nonzero(own == part))
            if start < stop:
                self._render(self.arrays[program], start, stop, is_doubled)

    def _ranges(self) -> list[tuple[int, int, bool]]:
        """The first and the last face of fronts, backs at the same place and all others, and whether they are doubled.

        ValueError where there are not so many.
        """
        count, fronts = len(self.mesh.faces), int(self.mesh.health.figures.get(BACKS, 0.0))
        if 2 * fronts > count:
            raise ValueError(f"{2 * fronts} fronts and backs of {count} faces are not possible")
        return [(0, fronts, True), (fronts, 2 * fronts, True), (2 * fronts, count, False)]

    def _render(self, array: moderngl.VertexArray, start: int, stop: int, is_doubled: bool) -> None:
        """Draw some faces; of those that are doubled the ones that face the camera."""
        if is_doubled:
            self.context.enable(self.context.CULL_FACE)
        try:
            array.render(vertices=3 * (stop - start), first=3 * start)
        finally:
            if is_doubled:
                self.context.disable(self.context.CULL_FACE)

    def release(self) -> None:
        for item in (*self.arrays.values(), self.vertices, self.indices, self.tangents, self.colours):
            if item is not None:
                item.release()
        self.arrays.clear()


#: Texture unit, above those of maps.
UNIT = 7

#: Colours beside each other in a line, a power of two: shaders find a place by shifts, as divisions of whole numbers
#: cost as much as the fetch.
WIDTH = 4096

#: Bytes that are brought to the device at a time: some milliseconds of work.
PIECE_BYTES = 2**22

#: Colours of vertices (R, 3), or with a mark (R, 4).
Colours = NDArray[np.floating[Any]]


class VertexRows:
    """Owns the texture; `write` replaces its content where the number of colours stays."""

    def __init__(self, context: moderngl.Context, texture_limits: Limits) -> None:
        self.context = context
        self._bits = min(WIDTH, texture_limits.texture_size).bit_length() - 1
        self._width = 1 << self._bits
        self._most = self._width * texture_limits.texture_size
        self._texture: moderngl.Texture | None = None

    def write(self, parts: Sequence[Colours]) -> Iterator[None]:
        """Take the colours of all `parts`, one after the other, piece by piece; nothing is to be drawn meanwhile.

        ValueError where the device cannot hold so many.
        """
        count = sum(map(len, parts))
        if count > self._most:
            raise ValueError(f"{count:,} colours of vertices are more than the {self._most:,} that fit")
        height = max(1, -(-count // self._width))
        if self._texture is not None and self._texture.height != height:
            self.release()
        if self._texture is None:
            self._texture = self.context.texture((self._width, height), 4, dtype="f4")
            self._texture.filter = (self.context.NEAREST, self.context.NEAREST)
        lines = max(1, PIECE_BYTES // (16 * self._width))
        for first in range(0, height, lines):
            here = min(lines, height - first)
            texels = _texels(parts, first * self._width, here * self._width)
            self._texture.write(texels, viewport=(0, first, self._width, here))
            yield

    def bind(self, program: moderngl.Program) -> None:
        assert self._texture is not None
        self._texture.use(UNIT)
        find_uniform(program, "rows").value = UNIT
        find_uniform(program, "row_bits").value = self._bits

    def release(self) -> None:
        if self._texture is not None:
            self._texture.release()
            self._texture = None


def _texels(parts: Sequence[Colours], first: int, count: int) -> NDArray[np.float32]:
    """(count, 4) from colour number `first` of all parts on; zeros after the last."""
    texels = np.zeros((count, 4), np.float32)
    begin = 0
    for part in parts:
        low, high = max(first, begin), min(first + count, begin + len(part))
        if low < high:
            texels[low - first : high - first, : part.shape[1]] = part[low - begin : high - begin]
        begin += len(part)
    return texels
