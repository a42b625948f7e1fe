"""A mesh in GPU memory: interleaved float32 position (relative to the centre), normal and texture coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.mesh import Mesh


class MeshBuffers:
    """Owns a vertex and an index buffer, tangents once they are asked for, and a vertex array per program.

    Positions are relative to `centre` (3,), the mesh's own without one.
    """

    def __init__(self, context: Any, mesh: Mesh, centre: NDArray[np.float64] | None = None) -> None:
        self.context = context
        position = (mesh.positions - (mesh.centre if centre is None else centre)).astype(np.float32)
        self.vertices = context.buffer(np.concatenate([position, mesh.normals, mesh.uv], axis=1).tobytes())
        self.indices = context.buffer(mesh.faces.tobytes())
        self.mesh = mesh
        self.tangents: Any = None
        self.arrays: dict[Any, Any] = {}

    def draw(self, program: Any) -> None:
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
            self.arrays[program] = self.context.vertex_array(program, content, self.indices)
        self.arrays[program].render()

    def release(self) -> None:
        for item in (*self.arrays.values(), self.vertices, self.indices, self.tangents):
            if item is not None:
                item.release()
        self.arrays.clear()
