"""Draws any scene: under its lights, of its bake, or with the texels of its material in the light of the bake.

The twin of `engine.render.shadowed`. A frame of texels in baked light costs two frames under the lights and one of the
bake: three pictures, and what becomes of each of their pixels.
"""

from __future__ import annotations

from collections.abc import Generator
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.gl.direct import DirectRenderer
from engine.gl.program import load_program, set_uniforms
from engine.gl.screen import Picture
from engine.gl.tiles import ToneMapper
from engine.gl.transported import TransportRenderer
from engine.render.display import Display
from engine.render.shadowed import LEAST, MOST, shadowed, with_and_without
from engine.scene.scene import Scene

#: Pieces of a picture of a bake, at most: each evaluates all vertices anew, which is most of its cost.
MOST_PIECES = 4


class SceneRenderer:
    """Owns the renderers of all scenes, each made when it is first needed; belongs to one context and its thread."""

    def __init__(self, context: Any) -> None:
        self.context = context
        self._pictures: tuple[Picture, ...] = ()
        self._used: tuple[DirectRenderer | TransportRenderer, ...] = ()

    @cached_property
    def direct(self) -> DirectRenderer:
        return DirectRenderer(self.context)

    @cached_property
    def baked(self) -> TransportRenderer:
        return TransportRenderer(self.context)

    @cached_property
    def _plain(self) -> DirectRenderer:
        """Draws the BRDF alone, so that the texels of the other stay where they are."""
        return DirectRenderer(self.context)

    @cached_property
    def _product(self) -> tuple[Any, Any]:
        """The program that makes one picture of three, and its array."""
        program = load_program(self.context, "screen.vert", "shadowed.frag")
        return program, self.context.vertex_array(program, [])

    @cached_property
    def _tone_mapper(self) -> ToneMapper:
        return ToneMapper(self.context)

    @property
    def messages(self) -> list[str]:
        """Sentences for a person about what had to be reduced or replaced for the last picture."""
        return [text for renderer in self._used for text in renderer.messages]

    def draw(
        self, scene: Scene, framebuffer: Any, size: tuple[int, int], *, samples: int = 2, display: Display | None = None
    ) -> None:
        """Draw `scene`, tone-mapped and sRGB-coded, over `framebuffer`, whose `size` is (width, height) in pixels."""
        shown = display or Display()
        self._use_for(scene)
        if scene.relit is None:
            self.direct.draw(scene, framebuffer, size, samples=samples, display=shown)
        elif not scene.has_texels:
            self.baked.draw(scene.relit, scene.camera, framebuffer, size, samples=samples, display=shown)
        else:
            picture = Picture(self.context, size)
            try:
                bands = self.bands(scene, picture.framebuffer, size, samples=samples)
                next(bands)
                while not sent(bands, size[1] * samples):
                    pass
                self._tone_mapper.draw(picture.texture, framebuffer, (0, 0, *size), 1, shown)
            finally:
                picture.release()

    def bands(
        self, scene: Scene, framebuffer: Any, size: tuple[int, int], *, samples: int = 2
    ) -> Generator[None, int, None]:
        """The linear picture in pieces, as `Tiles.bands`; other drawing with this renderer meanwhile spoils it."""
        self._use_for(scene)
        if scene.relit is None:
            return self.direct.bands(scene, framebuffer, size, samples=samples)
        if not scene.has_texels:
            return self._baked_bands(scene, framebuffer, size, samples)
        return self._shadowed_bands(scene, framebuffer, size, samples)

    def radiance(self, scene: Scene, size: tuple[int, int], *, samples: int = 2) -> NDArray[np.float32]:
        """The picture (height, width, 4) float32, row 0 on top: linear radiance times coverage, and coverage."""
        self._use_for(scene)
        if scene.relit is None:
            return self.direct.radiance(scene, size, samples=samples)
        baked = self.baked.radiance(scene.relit, scene.camera, size, samples=samples)
        if not scene.has_texels:
            return baked
        with_texels, without = with_and_without(scene)
        texels = self.direct.radiance(with_texels, size, samples=samples)
        return shadowed(texels, self._plain.radiance(without, size, samples=samples), baked)

    def _use_for(self, scene: Scene) -> None:
        is_direct = scene.relit is None
        self._used = (self.direct,) if is_direct else (self.direct, self.baked) if scene.has_texels else (self.baked,)

    def _baked_bands(
        self, scene: Scene, framebuffer: Any, size: tuple[int, int], samples: int
    ) -> Generator[None, int, None]:
        bands = self.baked.bands(scene.relit, scene.camera, framebuffer, size, samples=samples)
        next(bands)
        while True:
            rows = yield
            if sent(bands, max(rows, size[1] * samples // MOST_PIECES)):
                return

    def _shadowed_bands(
        self, scene: Scene, framebuffer: Any, size: tuple[int, int], samples: int
    ) -> Generator[None, int, None]:
        """T, T_0 and B one after the other, and L of them."""
        with_texels, without = with_and_without(scene)
        if not self._pictures or self._pictures[0].size != size:
            self._forget_pictures()
            self._pictures = tuple(Picture(self.context, size) for _ in range(3))
        pictures = self._pictures
        texels, plain, baked = (picture.framebuffer for picture in pictures)
        yield from self.direct.bands(with_texels, texels, size, samples=samples)
        yield from self._plain.bands(without, plain, size, samples=samples)
        yield from self._baked_bands(scene, baked, size, samples)
        for unit, picture in enumerate(pictures):
            if unit < 2:
                picture.texture.build_mipmaps()  # whose last is the mean of all
            picture.texture.use(unit)
        framebuffer.use()
        framebuffer.viewport = (0, 0, *size)
        self.context.disable(self.context.DEPTH_TEST | self.context.BLEND | self.context.CULL_FACE)
        program, array = self._product
        set_uniforms(program, {"texels": 0, "plain": 1, "baked": 2, "least": LEAST, "most": MOST})
        array.render(vertices=3)

    def _forget_pictures(self) -> None:
        for picture in self._pictures:
            picture.release()
        self._pictures = ()

    def release(self) -> None:
        """Free everything; the renderer can be used again afterwards and uploads anew."""
        self._forget_pictures()
        self._used, made = (), vars(self)
        for name in ("direct", "baked", "_plain", "_tone_mapper"):
            if name in made:
                made.pop(name).release()
        for item in reversed(made.pop("_product", ())):
            item.release()


def sent(bands: Generator[None, int, None], rows: int) -> bool:
    """True if these rows of `bands` were the last."""
    try:
        bands.send(rows)
    except StopIteration:
        return True
    return False
