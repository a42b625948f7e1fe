"""Rows of transport in spherical harmonics for some vertices, from what all vertices of a bake share.

That is a recipe of arrays and plain values, so that the workers of a cluster can make chunks as well as this process
(`engine.transport.baking.chunks`).
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.one_thread import one_thread
from engine.geometry.ray_caster import RayCaster
from engine.transport.baking.chunks import Chunk, Make, Recipe
from engine.transport.baking.visibility import Receivers, visibility_shares
from engine.transport.sh.interreflection import Surroundings, gather
from engine.transport.sh.transfer import diffuse_vectors, free_vectors, matrices, visibility_harmonics


def maker(recipe: Recipe) -> Make:
    """Chunks of a bake by their numbers, from its recipe (`sh.bake.recipe_of`)."""
    caster = RayCaster(recipe["shading_positions"], recipe["shading_faces"])
    return Baker(recipe, Receivers(caster, recipe["origin"], recipe["normal"], recipe["free"]))


class Baker:
    """Turns vertices into rows of transport, with everything that they share; `of` are all vertices as receivers."""

    def __init__(self, recipe: Recipe, of: Receivers) -> None:
        self._recipe, self._of = recipe, of
        self._sent: NDArray[np.float32] | None = recipe.get("sent")
        self._around = Surroundings(recipe["positions"], recipe["faces"], of, recipe["order"], recipe["gather"])

    def __call__(self, number: int) -> Chunk:
        """The chunk of that number."""
        bounds = self._recipe["bounds"]
        rows, visibility_s = self.made(np.arange(bounds[number], bounds[number + 1]))
        return Chunk(number, rows, visibility_s)

    def made(self, vertices: NDArray[np.int64]) -> tuple[dict[str, NDArray[Any]], float]:
        """The rows of `vertices`, all of the model or all of the ground, and the seconds for their visibility."""
        started = time.perf_counter()
        counts = None if self._of.free[vertices].all() else self.visible(vertices)
        visibility_s = time.perf_counter() - started
        return {"rows": self.rows(vertices, counts)}, visibility_s

    def visible(self, vertices: NDArray[np.int64]) -> NDArray[np.uint8]:
        """(B, 6 N²) how many parts of each texel are seen."""
        shares = visibility_shares(self._of, self._recipe["edge"], self._recipe["fine"], vertices)
        return np.concatenate([counts for _, counts in shares])

    def rows(self, vertices: NDArray[np.int64], counts: NDArray[np.uint8] | None) -> NDArray[np.float32]:
        """(rows, C, order²) of `vertices`, all of the model or all of the ground; `counts` None where all are free."""
        recipe, channels = self._recipe, self._recipe["channels"]
        if recipe["diffuse"] or vertices[0] >= recipe["ground_vertex"]:
            rows = np.repeat(self._vectors(vertices, counts)[:, None], channels, axis=1)
            if self._sent is not None:
                rows += gather(self._around, vertices, self._sent)
            return rows
        frames = recipe["frames"][vertices]
        own = matrices(self._seen(vertices, counts), frames, self._of.free[vertices])
        whole = np.repeat(own[:, :, None], channels, axis=2)
        if self._sent is not None:
            whole += gather(self._around, vertices, self._sent, frames)
        return whole.reshape(-1, channels, recipe["order"] ** 2)

    def _vectors(self, vertices: NDArray[np.int64], counts: NDArray[np.uint8] | None) -> NDArray[np.float32]:
        recipe, normal = self._recipe, self._of.normal[vertices]
        if counts is None:
            return free_vectors(recipe["order"], normal)
        free, full = self._of.free[vertices], recipe["fine"] ** 2
        with one_thread():
            return diffuse_vectors(counts, full, recipe["edge"], recipe["order"], normal, free)

    def _seen(self, vertices: NDArray[np.int64], counts: NDArray[np.uint8] | None) -> NDArray[np.float32]:
        """Spherical harmonics of visibility; any where all vertices are free, because theirs are known."""
        recipe, order = self._recipe, 2 * self._recipe["order"] - 1
        if counts is None:
            return np.zeros((len(vertices), order**2), np.float32)
        with one_thread():
            return visibility_harmonics(counts, recipe["fine"] ** 2, recipe["edge"], order)
