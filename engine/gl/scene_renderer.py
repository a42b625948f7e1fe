"""Draws any scene: under its lights, of its bake, or with the texels of its material in the light of the bake.

The counterpart of `engine.render.shadowed`. A frame of texels in baked light costs two frames under the lights and one
of the bake: three images, and what becomes of each of their pixels.
"""

from __future__ import annotations

from collections.abc import Generator

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.core.cached import cached_property
from engine.geometry.camera import Camera
from engine.gl.direct import DirectRenderer
from engine.gl.program import load_program, set_uniforms
from engine.gl.screen import Image
from engine.gl.tiles import ToneMapper
from engine.gl.transported import TransportRenderer
from engine.render.display import Display
from engine.render.shadowed import MAXIMUM, MINIMUM, combine_shadowed, with_and_without
from engine.scene.scene import RelightTransport, Scene

#: Pieces of an image of a bake, at most: each evaluates all vertices anew, which is most of its cost.
MAX_PIECES = 4


class SceneRenderer:
    """Owns the renderers of all scenes, each made when it is first needed; belongs to one context and its thread."""

    def __init__(self, context: moderngl.Context) -> None:
        self.context = context
        self._images: tuple[Image, ...] = ()
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
    def _product(self) -> tuple[moderngl.Program, moderngl.VertexArray]:
        """The program that makes one image of three, and its array."""
        program = load_program(self.context, "screen.vert", "shadowed.frag")
        return program, self.context.vertex_array(program, [])

    @cached_property
    def _tone_mapper(self) -> ToneMapper:
        return ToneMapper(self.context)

    @property
    def messages(self) -> list[str]:
        """Sentences for a user about what had to be reduced or replaced for the last image."""
        return [text for renderer in self._used for text in renderer.messages]

    def draw(
        self,
        scene: Scene,
        framebuffer: moderngl.Framebuffer,
        size: tuple[int, int],
        *,
        samples: int = 2,
        display: Display | None = None,
    ) -> None:
        """Draw `scene`, tone-mapped and sRGB-coded, over `framebuffer`, whose `size` is (width, height) in pixels."""
        shown = display or Display()
        self._use_for(scene)
        if scene.relit is None:
            self.direct.draw(scene, framebuffer, size, samples=samples, display=shown)
        elif not scene.has_texels:
            self.baked.draw(scene.relit, scene.camera, framebuffer, size, samples=samples, display=shown)
        else:
            image = Image(self.context, size)
            try:
                bands = self.bands(scene, image.framebuffer, size, samples=samples)
                next(bands)
                while not send(bands, size[1] * samples):
                    pass
                self._tone_mapper.draw(image.texture, framebuffer, (0, 0, *size), 1, shown)
            finally:
                image.release()

    def bands(
        self, scene: Scene, framebuffer: moderngl.Framebuffer, size: tuple[int, int], *, samples: int = 2
    ) -> Generator[None, int, None]:
        """The linear image in pieces, as `Tiles.bands`; other drawing with this renderer meanwhile spoils it."""
        self._use_for(scene)
        if scene.relit is None:
            return self.direct.bands(scene, framebuffer, size, samples=samples)
        if not scene.has_texels:
            return self._bake_bands(scene.relit, scene.camera, framebuffer, size, samples)
        return self._draw_shadowed_bands(scene, scene.relit, framebuffer, size, samples)

    def radiance(self, scene: Scene, size: tuple[int, int], *, samples: int = 2) -> NDArray[np.float32]:
        """The image (height, width, 4) float32, row 0 on top: linear radiance times coverage, and coverage."""
        self._use_for(scene)
        if scene.relit is None:
            return self.direct.radiance(scene, size, samples=samples)
        baked = self.baked.radiance(scene.relit, scene.camera, size, samples=samples)
        if not scene.has_texels:
            return baked
        with_texels, without = with_and_without(scene)
        texels = self.direct.radiance(with_texels, size, samples=samples)
        return combine_shadowed(texels, self._plain.radiance(without, size, samples=samples), baked)

    def _use_for(self, scene: Scene) -> None:
        is_direct = scene.relit is None
        self._used = (self.direct,) if is_direct else (self.direct, self.baked) if scene.has_texels else (self.baked,)

    def _bake_bands(
        self,
        relit: RelightTransport,
        camera: Camera,
        framebuffer: moderngl.Framebuffer,
        size: tuple[int, int],
        samples: int,
    ) -> Generator[None, int, None]:
        bands = self.baked.bands(relit, camera, framebuffer, size, samples=samples)
        next(bands)
        while True:
            rows = yield
            if send(bands, max(rows, size[1] * samples // MAX_PIECES)):
                return

    def _draw_shadowed_bands(
        self,
        scene: Scene,
        relit: RelightTransport,
        framebuffer: moderngl.Framebuffer,
        size: tuple[int, int],
        samples: int,
    ) -> Generator[None, int, None]:
        """T, T_0 and B one after the other, and L of them."""
        with_texels, without = with_and_without(scene)
        if not self._images or self._images[0].size != size:
            self._forget_images()
            self._images = tuple(Image(self.context, size) for _ in range(3))
        images = self._images
        texels, plain, baked = (image.framebuffer for image in images)
        yield from self.direct.bands(with_texels, texels, size, samples=samples)
        yield from self._plain.bands(without, plain, size, samples=samples)
        yield from self._bake_bands(relit, scene.camera, baked, size, samples)
        for unit, image in enumerate(images):
            if unit < 2:
                image.texture.build_mipmaps()  # whose last is the mean of all
            image.texture.use(unit)
        framebuffer.use()
        framebuffer.viewport = (0, 0, *size)
        self.context.disable(self.context.DEPTH_TEST | self.context.BLEND | self.context.CULL_FACE)
        program, array = self._product
        set_uniforms(program, {"texels": 0, "plain": 1, "baked": 2, "least": MINIMUM, "most": MAXIMUM})
        array.render(vertices=3)

    def _forget_images(self) -> None:
        for image in self._images:
            image.release()
        self._images = ()

    def release(self) -> None:
        """Free everything; the renderer can be used again afterwards and uploads anew."""
        self._forget_images()
        self._used, made = (), vars(self)
        for name in ("direct", "baked", "_plain", "_tone_mapper"):
            if name in made:
                made.pop(name).release()
        for item in reversed(made.pop("_product", ())):
            item.release()


def send(bands: Generator[None, int, None], rows: int) -> bool:
    """True if these rows of `bands` were the last."""
    try:
        bands.send(rows)
    except StopIteration:
        return True
    return False
