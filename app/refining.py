"""One picture of a scene on the graphics device: coarse at once, then finer and finer, in pieces.

The pieces leave the window's thread free between them. What is finest so far is `picture`; whoever shows it asks for
the next piece. Baked light goes to the device in pieces, too, and the picture before stays meanwhile. Everything here
belongs to one OpenGL context, which is current while it is called.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

from app.quality import MANY_LIGHTS, MOVING_S, ONE_LIGHT, Cost, Quality, next_rows
from engine.scene import Scene

#: Seconds that baked light is brought to the device at a time.
LOAD_S = 0.01


@dataclass
class _Coming:
    """A finer picture under way: its bands, the rows of the next and of the first, seconds and pieces so far."""

    level: Quality
    picture: Any
    bands: Generator[None, int, None]
    rows: int
    first_rows: int
    seconds: float = 0.0
    pieces: int = 0


class Refining:
    """Draws one scene at a time. `renderer` and pictures are made in `context`.

    Attributes
    ----------
    baked : the renderer of baked light, once it is needed.
    picture : `engine.gl.screen.Picture`, the last that was completed; None before the first.
    quality : its level, None where it is of another scene or size than is wanted now.
    screen : size (width, height) in pixels that it is for.
    """

    def __init__(self, context: Any) -> None:
        from engine.gl.direct import DirectRenderer

        self.context = context
        self.renderer = DirectRenderer(context)
        self.baked: Any = None
        self.scene: Scene | None = None
        self.picture: Any = None
        self.screen = (0, 0)
        self.quality: Quality | None = None
        self.cost = Cost()
        self._coming: _Coming | None = None
        self._loading: tuple[Any, Iterator[None]] | None = None

    def wants(self, scene: Scene, screen: tuple[int, int]) -> None:
        """Draw `scene` for `screen` from now on; what is of something else is out of date."""
        if self.scene is None or screen != self.screen or not same(scene, self.scene):
            self._start_anew()
        if self._loading is not None and (scene.lit is None or not _is_alike(scene.lit, self._loading[0])):
            self._loading = None
        self.scene, self.screen = scene, screen

    def _start_anew(self) -> None:
        if self._coming is not None:
            self._coming.bands.close()
            self._coming.picture.release()
        self.quality = self._coming = None

    @property
    def under_way(self) -> bool:
        return self._coming is not None

    @property
    def is_loading(self) -> bool:
        """Whether baked light is on its way to the device, and nothing of it is drawn yet."""
        return self._loading is not None

    def is_finished(self, budget_s: float) -> bool:
        """Whether the picture is the finest that is going to be drawn in `budget_s`."""
        return self.quality is not None and self._coming is None and self._finer(budget_s) is None

    def draw_first(self) -> float | None:
        """A first picture of what is new, as good as time allows while something moves; the seconds that it took."""
        if self.scene is None or self.quality is not None:
            return None
        lit = self.scene.lit
        loaded = self._load(lit) if lit is not None else None
        if lit is not None and loaded is None:
            return None
        if loaded is lit:
            return self._draw_first()
        wanted, self.scene = self.scene, replace(self.scene, lit=loaded)
        try:
            return self._draw_first()
        finally:
            self.scene, self.quality = wanted, None  # of the light before: its own is brought to the device now

    def _load(self, lit: Any) -> Any:
        """Bring `lit` to the device for a moment: the light that is there completely now, or None.

        What has begun is ended first, so that a light that is turned without a pause is seen to turn.
        """
        from engine.gl.transported import TransportRenderer

        self.baked = self.baked or TransportRenderer(self.context)
        if self._loading is None:
            self._loading = (lit, self.baked.load(lit))
        begun, pieces = self._loading
        self._loading = None
        started = time.perf_counter()
        for _ in pieces:
            if time.perf_counter() - started > LOAD_S:
                self._loading = (begun, pieces)
                return None
        return begun

    def _draw_first(self) -> float:
        assert self.scene is not None
        scene, levels = self.scene, self._levels()
        self.cost.about(scene.mesh, scene.shading, type(scene.brdf), scene.lookup, type(scene.lit))
        pixels, lights = self.screen[0] * self.screen[1], self._lights()
        coming = self._begin(levels[self.cost.best(levels, pixels, lights, MOVING_S)])
        if self.cost.is_new:
            self._advance(coming, 1)
            coming.seconds, coming.pieces = 0.0, 0
        while not self._advance(coming, coming.picture.size[1] * coming.level.samples):
            pass
        return self._complete(coming)

    def go_on(self, budget_s: float) -> float | None:
        """One more piece of a finer picture; the seconds that it took altogether where it is complete now."""
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
        """How many lights are summed; baked light was summed before."""
        assert self.scene is not None
        return len(self.scene.lights.direction) if self.scene.lit is None else 1

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
        from engine.gl.screen import Picture

        assert self.scene is not None
        width, height = (max(1, side // level.reduction) for side in self.screen)
        picture = Picture(self.context, (width, height))
        bands = self._bands(level, picture.framebuffer, (width, height))
        next(bands)
        rows = self.cost.rows(self._evaluations(level), height * level.samples)
        if self.scene.lit is not None:  # every piece evaluates all vertices anew, which is most of its cost
            rows = max(rows, height * level.samples // 4)
        return _Coming(level, picture, bands, rows, rows)

    def _bands(self, level: Quality, framebuffer: Any, size: tuple[int, int]) -> Generator[None, int, None]:
        assert self.scene is not None
        if self.scene.lit is None:
            return self.renderer.bands(level.of(self.scene), framebuffer, size, samples=level.samples)
        lit, camera = self.scene.lit, self.scene.camera
        bands: Generator[None, int, None] = self.baked.bands(lit, camera, framebuffer, size, samples=level.samples)
        return bands

    def _advance(self, coming: _Coming, rows: int) -> bool:
        """Draw so many rows; whether the picture is complete."""
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
        if self.picture is not None:
            self.picture.release()
        self.picture, self.quality = coming.picture, coming.level
        self.cost.learn(self._evaluations(coming.level), coming.seconds, max(1, coming.pieces))
        return coming.seconds

    def release(self) -> None:
        """Free everything."""
        self._start_anew()
        self._loading = None
        if self.picture is not None:
            self.picture.release()
        self.renderer.release()
        if self.baked is not None:
            self.baked.release()
        self.picture = self.baked = None


def _is_alike(lit: Any, other: Any) -> bool:
    """Whether two lights are of one kind of transport on one model, so that either may be seen for the other."""
    return type(lit) is type(other) and lit.mesh is other.mesh


def same(scene: Scene, other: Scene) -> bool:
    """Whether two scenes are one picture."""
    return all(getattr(scene, part.name) == getattr(other, part.name) for part in fields(scene))
