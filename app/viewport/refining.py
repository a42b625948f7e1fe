"""One image of a scene on the graphics device: coarse at once, then finer and finer, in pieces.

The pieces leave the window's thread free between them. What is finest so far is `image`; whoever shows it asks for
the next piece. Baked light goes to the device in pieces, too, and the image before stays meanwhile. Everything here
belongs to one OpenGL context, which is current while it is called.

The quality of the next frame, learnt from the cost of the frames so far.

A frame has evaluations: sub-pixels times lights. Coarser frames have fewer pixels and, under an environment, fewer
lights, each of which then stands for a larger region (`engine.light.light_tree`). No graphics card is asked what it is:
a fast one reaches the finest level within the first frames.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import numpy as np

from engine.scene.scene import RelightTransport, Scene
from engine.shading.directional.planes import DirectionalMap
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap

if TYPE_CHECKING:
    from engine.gl.context import Context
    from engine.gl.screen import Image

MAPS = (ShadingMap, PowerLawMap, DirectionalMap)

#: Baked light, or the maps of a material.
Needed = RelightTransport | ShadingMap | PowerLawMap | DirectionalMap

#: Longest time that a frame may hold up the window's thread, and that one piece of a finer image may.
MOVING_S, PIECE_S = 0.03, 0.03

#: Longest time of a whole finer image, in pieces: while a job that the user asked for runs, and when none does.
STILL_S, IDLE_S = 0.3, 60.0

#: A frame has at most so many times the evaluations of one whose cost is known.
STEP = 5

#: Greatest cost of a piece of the image over that of the average one, which shows background as well.
DENSE = 2.5


@dataclass(frozen=True)
class Quality:
    """Sub-pixels along a side of a pixel; pixels along a side that share one; lights of which one is drawn."""

    samples: int
    reduction: int = 1
    fewer: int = 1

    @property
    def is_coarse(self) -> bool:
        """True if it has fewer pixels than the screen, or fewer lights than the scene."""
        return self.reduction > 1 or self.fewer > 1

    def evaluations(self, pixels: int, lights: int) -> int:
        """Evaluations for an image with so many pixels on screen."""
        return round(max(1, pixels * self.samples**2 // self.reduction**2) * max(1.0, lights / self.fewer))

    def of(self, scene: Scene) -> Scene:
        """`scene` with the lights of this quality; round lamps are single directions where there are to be fewer."""
        if self.fewer == 1:
            return scene
        fewer = max(1, scene.directions // self.fewer) if scene.environment is not None else scene.directions
        return replace(scene, directions=fewer, lamps=tuple(replace(lamp, radius=0.0) for lamp in scene.lamps))


#: From best to quickest: under one light, and under many.
ONE_LIGHT = tuple(Quality(*at) for at in ((2, 1), (1, 1), (1, 2), (1, 3), (1, 4), (1, 6), (1, 9)))
MANY_LIGHTS = (*ONE_LIGHT[:5], *(Quality(1, *at) for at in ((4, 4), (6, 4), (6, 16), (9, 16), (9, 64))))


class Cost:
    """The measured seconds of frames of one kind of scene, by their evaluations."""

    def __init__(self) -> None:
        self._seconds: dict[int, float] = {}
        self._kind: tuple[object, ...] = ()

    def about(self, *kind: object) -> None:
        """Set the kind of frames drawn from now on; another kind forgets all that was learnt."""
        if len(kind) != len(self._kind) or any(new is not old for new, old in zip(kind, self._kind, strict=True)):
            self._kind = kind
            self._seconds.clear()

    @property
    def is_new(self) -> bool:
        """True if nothing is known: the next frame compiles its shader first, so its time predicts nothing."""
        return not self._seconds

    def learn(self, evaluations: int, seconds: float, pieces: int = 1) -> None:
        """A frame of so many `evaluations` took `seconds`, in `pieces` of which each draws all triangles anew."""
        again = (pieces - 1) * min(self._seconds.values(), default=0.0)
        self._seconds[evaluations] = max(seconds - again, seconds / pieces)

    def predicted(self, evaluations: int) -> float:
        """Seconds that a frame will take: between those that are known, or in proportion to the largest of them."""
        if not self._seconds:
            return float("inf")
        known = sorted(self._seconds)
        beyond = max(1.0, evaluations / known[-1])
        return float(np.interp(evaluations, known, [self._seconds[at] for at in known])) * beyond

    def best(self, levels: tuple[Quality, ...], pixels: int, lights: int, budget_s: float) -> int:
        """The finest of `levels` that fits `budget_s` and is not a leap; the last where none does."""
        most = STEP * max(self._seconds, default=0)
        for at, level in enumerate(levels):
            evaluations = level.evaluations(pixels, lights)
            if evaluations <= most and self.predicted(evaluations) <= budget_s:
                return at
        return len(levels) - 1

    def rows(self, evaluations: int, height: int) -> int:
        """The number of rows, of `height`, of a first piece of an image of so many `evaluations`."""
        fixed_s = min(self._seconds.values(), default=0.0)
        whole_s = max(self.predicted(evaluations) - fixed_s, 1e-6)
        if not np.isfinite(whole_s):
            return 1
        return int(np.clip(height * max(PIECE_S - fixed_s, PIECE_S / 3) / (DENSE * whole_s), 1, height))


def next_rows(rows: int, seconds: float, first: int) -> int:
    """Rows of the piece after one of `rows` that took `seconds`: fewer where it was late, more where it was early."""
    if seconds > PIECE_S:
        return max(1, int(rows * PIECE_S / seconds))
    return min(round(1.5 * rows + 0.5), 3 * first) if seconds < PIECE_S / 2 else rows


#: Seconds that baked light is brought to the device at a time.
LOAD_S = 0.01


@dataclass
class _Coming:
    """A finer image under way: its bands, the rows of the next and of the first, seconds and pieces so far."""

    level: Quality
    image: Image
    bands: Generator[None, int, None]
    rows: int
    first_rows: int
    seconds: float = 0.0
    pieces: int = 0


class Refining:
    """Draws one scene at a time. `renderer` and images are made in `context`.

    Attributes
    ----------
    image : `engine.gl.screen.Image`, the last that was completed; None before the first.
    quality : its level, None where it is of another scene or size than is wanted now.
    screen : size (width, height) in pixels that it is for.
    """

    def __init__(self, context: Context) -> None:
        from engine.gl.scene_renderer import SceneRenderer

        self.context = context
        self.renderer = SceneRenderer(context)
        self.scene: Scene | None = None
        self.image: Image | None = None
        self.screen = (0, 0)
        self.quality: Quality | None = None
        self.cost = Cost()
        self._coming: _Coming | None = None
        self._loading: tuple[Needed, Iterator[None]] | None = None

    def wants(self, scene: Scene, screen: tuple[int, int]) -> None:
        """Draw `scene` for `screen` from now on; images of anything else are out of date."""
        if self.scene is None or screen != self.screen or not same(scene, self.scene):
            self._start_anew()
        if self._loading is not None and not _is_alike(_to_load(scene), self._loading[0]):
            self._loading = None
        self.scene, self.screen = scene, screen

    def _start_anew(self) -> None:
        if self._coming is not None:
            self._coming.bands.close()
            self._coming.image.release()
        self.quality = self._coming = None

    @property
    def under_way(self) -> bool:
        return self._coming is not None

    @property
    def is_loading(self) -> bool:
        """True if baked light or a material is on its way to the device, and nothing of it is drawn yet."""
        return self._loading is not None

    def is_finished(self, budget_s: float) -> bool:
        """True if the image is the finest that will be drawn in `budget_s`."""
        return self.quality is not None and self._coming is None and self._finer(budget_s) is None

    def draw_first(self) -> float | None:
        """Draw a first image of a new scene, as good as time allows while something moves; returns its seconds."""
        if self.scene is None or self.quality is not None:
            return None
        needed = _to_load(self.scene)
        loaded = self._load(needed) if needed is not None else None
        if needed is not None and loaded is None:
            return None
        if loaded is needed:
            return self._draw_first()
        assert not isinstance(loaded, MAPS), "maps in place of others are never loaded"
        wanted, self.scene = self.scene, replace(self.scene, relit=loaded)
        try:
            return self._draw_first()
        finally:
            self.scene, self.quality = wanted, None  # of the light before: its own is brought to the device now

    def _load(self, needed: Needed) -> Needed | None:
        """Bring baked light or a material to the device for a moment: what is there completely now, or None.

        What has begun is ended first, so that a light in continuous rotation is drawn in rotation.
        """
        assert self.scene is not None
        if self._loading is None:
            self._loading = (needed, self._bring(needed))
        begun, pieces = self._loading
        self._loading = None
        started = time.perf_counter()
        for _ in pieces:
            if time.perf_counter() - started > LOAD_S:
                self._loading = (begun, pieces)
                return None
        return begun

    def _bring(self, needed: Needed) -> Iterator[None]:
        if isinstance(needed, MAPS):
            assert self.scene is not None
            return self.renderer.direct.load(needed, self.scene.tiling_mode)
        return self.renderer.baked.load(needed)

    def _draw_first(self) -> float:
        assert self.scene is not None
        scene, levels = self.scene, self._levels()
        self.cost.about(
            scene.mesh, scene.shading, scene.pbr, type(scene.brdf), scene.lookup, type(scene.relit), scene.tiling_mode
        )
        pixels, lights = self.screen[0] * self.screen[1], self._lights()
        coming = self._begin(levels[self.cost.best(levels, pixels, lights, MOVING_S)])
        if self.cost.is_new:
            self._advance(coming, 1)
            coming.seconds, coming.pieces = 0.0, 0
        while not self._advance(coming, coming.image.size[1] * coming.level.samples):
            pass
        return self._complete(coming)

    def go_on(self, budget_s: float) -> float | None:
        """One more piece of a finer image; the seconds that it took altogether where it is complete now."""
        if self.scene is None:
            return None
        if self.quality is None:
            return self.draw_first()
        if self._coming is None:
            level = self._finer(budget_s)
            if level is None:
                return None
            self._coming = self._begin(level)
        coming, before = self._coming, self._coming.seconds
        done = self._advance(coming, coming.rows)
        coming.rows = next_rows(coming.rows, coming.seconds - before, coming.first_rows)
        if not done:
            return None
        self._coming = None
        return self._complete(coming)

    def _levels(self) -> tuple[Quality, ...]:
        assert self.scene is not None
        return ONE_LIGHT if self._lights() == 1 else MANY_LIGHTS

    def _lights(self) -> int:
        """The number of lights that are summed; baked light was summed before, and texels are drawn under each."""
        assert self.scene is not None
        return len(self.scene.lights.direction) if self.scene.relit is None or self.scene.has_texels else 1

    def _evaluations(self, level: Quality) -> int:
        assert self.scene is not None
        return level.evaluations(self.screen[0] * self.screen[1], self._lights())

    def _finer(self, budget_s: float) -> Quality | None:
        """The next level to draw of a scene that is at rest."""
        if self.scene is None or self.quality is None or budget_s <= MOVING_S:
            return None
        levels, pixels = self._levels(), self.screen[0] * self.screen[1]
        best = self.cost.best(levels, pixels, self._lights(), budget_s)
        return levels[best] if best < levels.index(self.quality) else None

    def _begin(self, level: Quality) -> _Coming:
        from engine.gl.screen import Image

        assert self.scene is not None
        width, height = (max(1, side // level.reduction) for side in self.screen)
        image = Image(self.context, (width, height))
        bands = self.renderer.bands(level.of(self.scene), image.framebuffer, (width, height), samples=level.samples)
        next(bands)
        rows = self.cost.rows(self._evaluations(level), height * level.samples)
        return _Coming(level, image, bands, rows, rows)

    def _advance(self, coming: _Coming, rows: int) -> bool:
        """Draw so many rows; whether the image is complete."""
        started = time.perf_counter()
        done = False
        try:
            coming.bands.send(rows)
        except StopIteration:
            done = True
        self.context.finish()
        coming.seconds += time.perf_counter() - started
        coming.pieces += 1
        return done

    def _complete(self, coming: _Coming) -> float:
        if self.image is not None:
            self.image.release()
        self.image, self.quality = coming.image, coming.level
        self.cost.learn(self._evaluations(coming.level), coming.seconds, max(1, coming.pieces))
        return coming.seconds

    def release(self) -> None:
        """Free everything."""
        self._start_anew()
        self._loading = None
        if self.image is not None:
            self.image.release()
        self.renderer.release()
        self.image = None


def _to_load(scene: Scene) -> Needed | None:
    """What is brought to the device in pieces before a scene is drawn: its baked light, or the maps of its material."""
    return scene.relit if scene.relit is not None else scene.shading


def _is_alike(needed: Needed | None, other: Needed) -> bool:
    """True for the same, and for baked light of one method on one model, which may stand in for each other."""
    mesh = getattr(needed, "mesh", None)
    return needed is other or (
        type(needed) is type(other) and mesh is not None and mesh is getattr(other, "mesh", None)
    )


def same(scene: Scene, other: Scene) -> bool:
    """True if two scenes give the same image."""
    return all(getattr(scene, part.name) == getattr(other, part.name) for part in fields(scene))
