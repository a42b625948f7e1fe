"""Draws baked transport under its light (`engine.transport.relight`), whichever of the methods it was baked with.

The light is uploaded when it is another one, in pieces where a window must go on meanwhile; moving the camera costs a
frame and nothing else. Tiles and bands are
those of `engine.gl.tiles`. The counterpart is `engine.render.transported`, which mixes the radiance of corners also
where here each fragment looks its terms up: between vertices, not at them, the two differ as far as triangles are
coarse.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Protocol, TypeVar, cast

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.gl.buffers import Colours, MeshBuffers, VertexRows
from engine.gl.context import Limits, limits
from engine.gl.program import find_uniform, load_program, set_uniforms
from engine.gl.tiles import Paint, Tiles
from engine.render.display import Display
from engine.transport.method import method_of
from engine.transport.relight import RelightTransport

#: The transport that a method draws.
Relit = TypeVar("Relit", contravariant=True)


class Textures(Protocol[Relit]):
    """Data of a method in GPU memory for one transport: `Textures` of its `drawing` module.

    Attributes
    ----------
    SHADER, SOURCE : the stem of the shaders that draw it, and the file that they include.
    definitions : what they are compiled with. messages : what had to be reduced, as sentences for a user.
    """

    SHADER: str
    SOURCE: str
    messages: list[str]

    def __init__(self, context: moderngl.Context, relit: Relit, limits: Limits) -> None: ...
    @property
    def definitions(self) -> dict[str, str]: ...
    @staticmethod
    def key(relit: Relit) -> object:
        """The source of the textures: equal for what can share them."""

    @staticmethod
    def rows(relit: Relit) -> list[Colours]:
        """The rows (R, 3 or 4) of the vertices under the light, in parts."""

    def fill(self) -> Iterator[None]:
        """Bring to the device, piece by piece, what does not belong to the light."""

    def relight(self, relit: Relit) -> Iterator[None]:
        """Take the light of `relit`, piece by piece, as far as it is not in the rows."""

    def bind(self, program: moderngl.Program) -> None:
        """Set what the shaders read."""

    def release(self) -> None:
        """Free everything."""


class TransportRenderer:
    """Owns everything that drawing baked transport needs in GPU memory; belongs to one context and its thread.

    Attributes
    ----------
    messages : what had to be reduced for the last image, as sentences for a user.
    """

    def __init__(self, context: moderngl.Context, *, texture_limits: Limits | None = None, debug: bool = False) -> None:
        self.context = context
        self.limits = texture_limits or limits(context)
        self.debug = debug
        self.messages: list[str] = []
        self._tiles = Tiles(context, self.limits)
        self._rows = VertexRows(context, self.limits)
        self._programs: dict[tuple[tuple[str, str], ...], moderngl.Program] = {}
        self._mesh: tuple[Mesh, MeshBuffers] | None = None
        self._textures: tuple[object, Textures[RelightTransport]] | None = None
        self._relit: RelightTransport | None = None

    def draw(
        self,
        relit: RelightTransport,
        camera: Camera,
        framebuffer: moderngl.Framebuffer,
        size: tuple[int, int],
        *,
        samples: int = 2,
        display: Display | None = None,
    ) -> None:
        """Draw `relit`, tone-mapped and sRGB-coded, over `framebuffer`, whose `size` is (width, height) in pixels."""
        self._tiles.draw(self._painting(relit, camera, size), framebuffer, size, samples, display or Display())

    def bands(
        self,
        relit: RelightTransport,
        camera: Camera,
        framebuffer: moderngl.Framebuffer,
        size: tuple[int, int],
        *,
        samples: int = 2,
    ) -> Generator[None, int, None]:
        """The linear image in pieces, as `Tiles.bands`; other drawing with this renderer meanwhile spoils it."""
        return self._tiles.bands(self._painting(relit, camera, size), framebuffer, size, samples)

    def radiance(
        self, relit: RelightTransport, camera: Camera, size: tuple[int, int], *, samples: int = 2
    ) -> NDArray[np.float32]:
        """The image (height, width, 4) float32, row 0 on top: linear radiance times coverage, and coverage."""
        return self._tiles.radiance(self._painting(relit, camera, size), size, samples)

    @property
    def invalid_samples(self) -> int:
        """With `debug`, how many samples of the last `radiance` were not finite (drawn magenta)."""
        return self._tiles.invalid_samples

    def _painting(self, relit: RelightTransport, camera: Camera, size: tuple[int, int]) -> Paint:
        return lambda tile_from_clip: self._paint(relit, camera, size[0] / size[1], tile_from_clip)

    def _paint(
        self, relit: RelightTransport, camera: Camera, aspect: float, tile_from_clip: NDArray[np.float64]
    ) -> None:
        """Draw everything for one tile."""
        textures, buffers = self._upload(relit), self._buffers(relit.mesh)
        program = self._program(textures)
        centre = relit.mesh.centre
        eye = tuple(np.subtract(camera.eye, centre).tolist())
        set_uniforms(program, {"eye": eye, "flat_vertex": relit.flat_vertex})
        self.messages = textures.messages
        textures.bind(program)
        self._rows.bind(program)
        matrix = tile_from_clip @ camera.clip_from_model(centre, relit.mesh.radius, aspect)
        find_uniform(program, "clip_from_model").write(np.ascontiguousarray(matrix.T, np.float32))
        buffers.draw(program)

    def _buffers(self, mesh: Mesh) -> MeshBuffers:
        if self._mesh is None or self._mesh[0] is not mesh:
            if self._mesh is not None:
                self._mesh[1].release()
            self._mesh = (mesh, MeshBuffers(self.context, mesh))
        return self._mesh[1]

    def holds(self, relit: RelightTransport) -> bool:
        """True if all of `relit` is in the device's memory."""
        return self._relit is relit

    def load(self, relit: RelightTransport) -> Iterator[None]:
        """Bring `relit` into the device's memory piece by piece, some milliseconds each; nothing is drawn meanwhile.

        Closing the iterator early leaves nothing that could be drawn. ValueError where the device cannot hold it.
        """
        if self.holds(relit):
            return
        self._relit, key = None, _owner(relit).key(relit)
        if self._textures is None or self._textures[0] != key:
            if self._textures is not None:
                self._textures[1].release()
                self._textures = None
            textures = _owner(relit)(self.context, relit, self.limits)
            try:
                yield from textures.fill()
            except BaseException:
                textures.release()
                raise
            self._textures = (key, textures)
        textures = self._textures[1]
        yield from self._rows.write(_owner(relit).rows(relit))
        yield from textures.relight(relit)
        self._buffers(relit.mesh)
        self._relit = relit

    def _upload(self, relit: RelightTransport) -> Textures[RelightTransport]:
        """The textures of what was baked, with the light in the rows of its vertices."""
        for _ in self.load(relit):
            pass
        assert self._textures is not None
        return self._textures[1]

    def _program(self, textures: Textures[RelightTransport]) -> moderngl.Program:
        stem = textures.SHADER
        definitions = {"SOURCE": textures.SOURCE, **textures.definitions, **({"DEBUG": "1"} if self.debug else {})}
        key = (("SHADER", stem), *definitions.items())
        if key not in self._programs:
            self._programs[key] = load_program(self.context, f"{stem}.vert", f"{stem}.frag", definitions)
        return self._programs[key]

    def release(self) -> None:
        """Free everything; the renderer can be used again afterwards and uploads anew."""
        for owner in (self._mesh, self._textures):
            if owner is not None:
                owner[-1].release()
        for program in self._programs.values():
            program.release()
        self._rows.release()
        self._tiles.release()
        self._mesh = self._textures = self._relit = None
        self._programs.clear()


def _owner(relit: RelightTransport) -> type[Textures[RelightTransport]]:
    """The class of the textures of `relit`."""
    return cast("type[Textures[RelightTransport]]", method_of(relit.method).drawing.Textures)
