"""Interreflection in wavelet transport: light that comes by way of other parts of the model, glossy as the model is.

The radiance that a vertex sends towards another is a sum over terms (Wang2004 Eq. 6), so what arrives there by a bounce
is linear in the transport vectors of the first:

    T'_k(v) = Σ_ω light_k(ω) π / D Σ_j view_j(y, −ω) T_j(y)        D rays ω from v, as dense as the cosine, that meet y

and by one more bounce the same of T'. The vectors T' + T'' + … have the same coefficients as T, but for the finest:
light that is spread by a surface varies little with where it came from. They are kept apart from T, because light of
lamps falls on T by rays, and on them as a narrow lobe in the map. There the coefficients that T lacks make bounces of
a lamp 16 % too bright in a white corner, with four times as many 2 %.

Each ray reads the vectors of one corner of the triangle that it meets, chosen by its barycentric coordinates. Surfaces
are black from behind. Bound by reading those vectors: some 300 coefficients a ray for four terms.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import Vectors
from engine.core.kernels import parallel, prange
from engine.core.steps import Step, Steps
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.ray_caster import RayCaster, meets_front
from engine.storage.scratch import scratch_array
from engine.transport.baking import visibility_kernel
from engine.transport.baking.chunks import Recipe, Remote, each_of, open_workers
from engine.transport.baking.visibility import Receivers
from engine.transport.sh.interreflection import make_pattern
from engine.transport.wavelet.haar import FACES, candidates, select
from engine.transport.wavelet.kernel import store_vector
from engine.transport.wavelet.quantise import STEP
from engine.transport.wavelet.transfer import split_by_kind

#: Edge of the faces up to whose details bounces are kept, and the share of a vector's coefficients that they keep. On a
#: torus knot over a bright floor all of them lower the error by 1.5 % of it, a fourth raises it by 3 %, and details of
#: an edge of 8 alone change nothing.
EDGE, SHARE = 16, 2

#: Rays that are followed at once.
CHUNK_RAYS = 1 << 18

#: Rows that are put together at once.
CHUNK_ROWS = 1 << 14

Rows = dict[str, NDArray[Any]]

#: A task of a bounce: its vertices, and the vectors of the bounces before at these, where there were some.
Task = tuple[NDArray[np.int64], Rows | None]

#: Its result: the vertices, the vectors of this bounce, and those of all bounces so far.
Bounced = tuple[NDArray[np.int64], Rows, Rows]


@dataclass(frozen=True, eq=False)
class Coarse:
    """Coefficients of vectors up to details of an edge of `EDGE`, which a bounce takes, one vector after another.

    Vector r has the `indices` and `words` (n,) from `start` (R + 1,) [r] to start[r + 1], in rising order, and `peaks`
    (R, 3) as `Vectors16`.
    """

    start: NDArray[np.int64]
    indices: NDArray[np.uint16]
    words: NDArray[np.uint32]
    peaks: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Receivers `of` light on a surface, which are its vertices, their frames (V, 3, 3), factors, and rays of a bounce.

    The ground, with its albedo, begins with vertex `first`. `coefficients` is how many a vector of direct light has.
    `kind` (first,) is that of the `kinds` BRDFs which each vertex of the model has, where there are several
    (`WaveletTransport`).
    """

    of: Receivers
    frames: Vectors
    factors: SeparableFactors
    first: int
    ground_albedo: float
    rays: int
    coefficients: int
    kind: NDArray[np.int64] | None = None
    kinds: int = 1

    @property
    def terms(self) -> int:
        return self.factors.terms // self.kinds

    @property
    def rows(self) -> int:
        """Rows of all vertices."""
        return self.first * self.terms + len(self.frames) - self.first

    @property
    def width(self) -> int:
        """Coefficients of a vector of bounces."""
        return max(1, self.coefficients // SHARE)

    def rows_of(self, vertices: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The first row of each of `vertices`, and how many there are."""
        on_model = vertices < self.first
        row = np.where(on_model, vertices * self.terms, self.first * (self.terms - 1) + vertices)
        return row, np.where(on_model, self.terms, 1)

    def slice_of(self, vertices: NDArray[np.int64]) -> slice:
        """The rows of `vertices` that follow each other, all of the model or all of the ground."""
        row, count = self.rows_of(vertices[[0, -1]])
        return slice(int(row[0]), int(row[1] + count[1]))


def gather_reflections(
    around: Surroundings,
    direct: Iterable[Mapping[str, NDArray[Any]]],
    bounces: int,
    bounds: NDArray[np.int64],
    cluster: str | None = None,
) -> Steps[Rows]:
    """Vectors of the light that comes by up to `bounces` reflections, as many rows as the `direct` ones in all parts.

    They have half as many coefficients (`SHARE`). `bounds` cut the vertices into parts, none of which has some of the
    model and some of the ground; the workers of a `cluster` follow them where its address is given
    (`engine.transport.baking.chunks`).
    """
    latest, total = cut_details(direct, around.rows, around.coefficients), _make_rows(around.rows, around.width)
    for bounce in range(bounces):
        found, done = _make_rows(around.rows, around.width), 0
        by = Remote(cluster, maker, _recipe_of(around, latest)) if cluster else partial(follow, around, latest)
        parts = (np.arange(start, stop) for start, stop in pairwise(bounds))
        tasks = ((some, _read(total, around.slice_of(some)) if bounce else None) for some in parts)
        with open_workers(by) as run, closing(each_of(run, tasks)) as results:
            for vertices, own, whole in results:
                _put(found, around.slice_of(vertices), own)
                _put(total, around.slice_of(vertices), whole)
                done += len(vertices)
                note = f"following bounce {bounce + 1} of {bounces}"
                yield Step((bounce + done / bounds[-1]) / bounces, note)
        latest = cut_details(split_rows(found), around.rows, around.width)
    return total


def cut_details(parts: Iterable[Mapping[str, NDArray[Any]]], rows: int, width: int) -> Coarse:
    """Cut so many `rows` of at most `width` coefficients, whose `parts` follow each other, to what a bounce takes."""
    start, peaks = np.zeros(rows + 1, np.int64), np.empty((rows, 3), np.float32)
    indices, words = scratch_array((rows * width,), np.uint16), scratch_array((rows * width,), np.uint32)
    row = 0
    for part in parts:
        count = len(part["counts"])
        taken = np.arange(part["indices"].shape[1]) < part["counts"][:, None]
        taken &= part["indices"] < FACES * EDGE * EDGE
        start[row + 1 : row + count + 1] = start[row] + np.cumsum(np.count_nonzero(taken, axis=1))
        into = slice(int(start[row]), int(start[row + count]))
        indices[into], words[into], peaks[row : row + count] = (
            part["indices"][taken],
            part["words"][taken],
            part["peaks"],
        )
        row += count
    return Coarse(start, indices[: start[-1]], words[: start[-1]], peaks)


def split_rows(rows: Rows) -> Iterator[Rows]:
    """Parts of `rows` that follow each other."""
    for start in range(0, len(rows["counts"]), CHUNK_ROWS):
        yield _read(rows, slice(start, start + CHUNK_ROWS))


def _make_rows(rows: int, width: int) -> Rows:
    """Empty vectors of at most `width` coefficients."""
    return {
        "indices": scratch_array((rows, width), np.uint16),
        "words": scratch_array((rows, width), np.uint32),
        "peaks": scratch_array((rows, 3), np.float32),
        "counts": np.zeros(rows, np.uint16),
    }


def _read(rows: Rows, some: slice) -> Rows:
    return {name: array[some] for name, array in rows.items()}


def _put(rows: Rows, some: slice, values: Rows) -> None:
    for name, array in rows.items():
        array[some] = values[name]


def maker(recipe: Recipe) -> Callable[[Task], Bounced]:
    """`follow` a bounce at vertices, from `_recipe_of` it."""
    caster = RayCaster(recipe["positions"], recipe["faces"])
    of = Receivers(caster, recipe["origin"], recipe["normal"], recipe["free"])
    latest = Coarse(recipe["start"], recipe["indices"], recipe["words"], recipe["peaks"])
    return partial(follow, Surroundings(of=of, **{name: recipe[name] for name in _SHARED}), latest)


#: Attributes of `Surroundings` that a recipe holds as they are.
_SHARED = ("frames", "factors", "first", "ground_albedo", "rays", "coefficients", "kind", "kinds")


def _recipe_of(around: Surroundings, latest: Coarse) -> Recipe:
    of = around.of
    return {
        **of.describe(),
        **{name: getattr(around, name) for name in _SHARED},
        "start": latest.start,
        "indices": latest.indices,
        "words": latest.words,
        "peaks": latest.peaks,
    }


def make_full_bounce(around: Surroundings) -> Callable[[NDArray[np.int64]], object]:
    """A bounce of full vectors at vertices, to see how long it takes."""
    rows, width = around.rows, around.coefficients
    start, peaks = np.arange(rows + 1) * width, np.zeros((rows, 3), np.float32)
    full = Coarse(start, np.zeros(rows * width, np.uint16), np.zeros(rows * width, np.uint32), peaks)
    return lambda vertices: follow(around, full, (vertices, None))


def follow(around: Surroundings, latest: Coarse, task: Task) -> Bounced:
    """Follow a bounce of the `latest` vectors of all vertices to those of a `task`, all of the model or the ground."""
    vertices, before = task
    terms = int(around.rows_of(vertices[:1])[1][0])
    found = _make_rows(terms * len(vertices), around.width)
    total = _make_rows(terms * len(vertices), around.width)
    if before is not None:
        _put(total, slice(None), before)
    step = max(1, CHUNK_RAYS // around.rays)
    for start in range(0, len(vertices), step):
        some = slice(start * terms, (start + step) * terms)
        _gather(around, vertices[start : start + step], latest, _read(found, some), _read(total, some))
    return vertices, found, total


def _gather(around: Surroundings, vertices: NDArray[np.int64], latest: Coarse, found: Rows, total: Rows) -> None:
    """Put what reaches `vertices` of the `latest` vectors into `found`, and add it to `total`, which are theirs."""
    origin, direction = visibility_kernel.hemisphere_rays(
        vertices, around.of.origin, around.of.normal, make_pattern(around.rays)
    )
    caster = around.of.caster
    hits = caster.intersect(origin, direction)
    corners = caster.faces[hits.face]
    met = np.flatnonzero((hits.face >= 0) & meets_front(caster.positions, corners, direction))
    source = _choose_corners(met, corners[met], hits.barycentric[met])
    own = vertices[met // around.rays]
    sent = _view_weights(around, source, -direction[met])
    taken = _light_weights(around, own, direction[met]) * (np.pi / around.rays)
    row, count = around.rows_of(source)
    follow_bounce(
        np.searchsorted(met, np.arange(len(vertices) + 1) * around.rays),
        taken,
        sent,
        row,
        count,
        latest.start,
        latest.indices,
        latest.words,
        latest.peaks,
        len(found["counts"]) // len(vertices),
        FACES * EDGE * EDGE,
        candidates(around.coefficients),
        STEP,
        *_arrays(found),
        *_arrays(total),
    )


def _arrays(rows: Rows) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    return rows["indices"], rows["words"], rows["peaks"], rows["counts"]


def _choose_corners(
    ray: NDArray[np.int64], corners: NDArray[np.integer], barycentric: NDArray[np.float64]
) -> NDArray[np.int64]:
    """One of the `corners` (n, 3) for each ray, as often as it has weight: by the fractions of a golden sequence."""
    chance = ray * (0.5 * (np.sqrt(5.0) - 1.0)) % 1.0
    place = (chance[:, None] >= np.cumsum(barycentric[:, :2], axis=1)).sum(axis=1)
    return np.take_along_axis(corners, place[:, None], 1)[:, 0].astype(np.int64)


def _view_weights(around: Surroundings, vertices: NDArray[np.int64], towards: Vectors) -> NDArray[np.float32]:
    """(n, K, 3) by which `vertices` send their terms into world directions `towards`; the ground's albedo is in [0]."""
    local = np.einsum("nij,ni->nj", around.frames[vertices], towards)
    weights = np.zeros((len(vertices), around.terms, 3), np.float32)
    front = local[:, 2] > 0.0
    model, ground = np.flatnonzero(front & (vertices < around.first)), front & (vertices >= around.first)
    for factors, some in split_by_kind(around.kind, around.terms, vertices[model]):
        weights[model[some]] = _look_up(around.factors, around.factors.first[factors], local[model[some]])
    weights[ground, 0] = around.ground_albedo / np.pi
    return weights


def _light_weights(around: Surroundings, vertices: NDArray[np.int64], direction: Vectors) -> NDArray[np.float32]:
    """(n, K, 3) by which `vertices`, all of the model or all of the ground, take light of `direction`."""
    if not len(vertices) or vertices[0] >= around.first:
        return np.ones((len(vertices), 1, 3), np.float32)
    local = np.einsum("nij,ni->nj", around.frames[vertices], direction)
    local[:, 2] = np.maximum(local[:, 2], 0.0)
    weights = np.empty((len(vertices), around.terms, 3), np.float32)
    for factors, some in split_by_kind(around.kind, around.terms, vertices):
        weights[some] = _look_up(around.factors, around.factors.second[factors], local[some])
    return weights


def _look_up(factors: SeparableFactors, maps: NDArray[np.float32], local: Vectors) -> NDArray[np.float32]:
    """(n, K, 3) values of the maps (K, rows, columns, 3) of all terms."""
    texture = np.moveaxis(maps, 0, 2).reshape(*maps.shape[1:3], -1)
    return factors.hemisphere_map.look_up(texture, local).reshape(len(local), len(maps), 3).astype(np.float32)


@parallel
def follow_bounce(
    start: NDArray[np.integer],
    taken: NDArray[np.floating],
    sent: NDArray[np.floating],
    row: NDArray[np.integer],
    count: NDArray[np.integer],
    first: NDArray[np.integer],
    indices: NDArray[np.integer],
    words: NDArray[np.integer],
    peaks: NDArray[np.floating],
    terms: int,
    coefficients: int,
    capacity: int,
    step: int,
    found_indices: NDArray[np.integer],
    found_words: NDArray[np.integer],
    found_peaks: NDArray[np.floating],
    found_counts: NDArray[np.integer],
    total_indices: NDArray[np.integer],
    total_words: NDArray[np.integer],
    total_peaks: NDArray[np.floating],
    total_counts: NDArray[np.integer],
) -> None:
    """Follow one bounce at vertices.

    Parameters
    ----------
    start : (B + 1,) first ray of each vertex. taken : (n, terms, 3) weights of a ray's light at the vertex.
    sent : (n, K, 3) weights of the terms where the ray meets the surface, whose `count` (n,) rows begin with `row`.
    first, indices, words, peaks : vectors of all rows (`Coarse`), whose indices are below `coefficients`.
    terms : rows of each vertex, which follow each other.
    capacity : as for `haar.select`. step : as for `quantise_vectors`.
    found_… : filled for the rows of the vertices. total_… : what was found before, to which it is added.
    """
    wanted = found_words.shape[1]
    for b in prange(len(start) - 1):
        sums = np.zeros((coefficients, terms, 3), np.float32)
        planes = np.empty((3, coefficients), np.float32)
        kept, values = np.empty(min(wanted, coefficients), np.int64), np.zeros((wanted, 3), np.float32)
        held, scratch = np.empty(capacity, np.float32), np.empty(capacity, np.float32)
        index = np.empty(capacity, np.int64)
        weight = np.empty((terms, 3), np.float32)
        for ray in range(start[b], start[b + 1]):
            for j in range(count[ray]):
                r = row[ray] + j
                for c in range(3):
                    scale = sent[ray, j, c] * peaks[r, c] / np.float32(511.0 if c == 2 else 1023.0)
                    for k in range(terms):
                        weight[k, c] = taken[ray, k, c] * scale
                for n in range(first[r], first[r + 1]):
                    place = np.int64(indices[n])
                    packed = words[n]
                    red = np.float32(np.int32(packed << 21) >> 21)
                    green = np.float32(np.int32(packed << 10) >> 21)
                    blue = np.float32(np.int32(packed) >> 22)
                    for k in range(terms):
                        sums[place, k, 0] += weight[k, 0] * red
                        sums[place, k, 1] += weight[k, 1] * green
                        sums[place, k, 2] += weight[k, 2] * blue
        for k in range(terms):
            r = b * terms + k
            for again in range(2):
                if again == 0:
                    for m in range(coefficients):
                        for c in range(3):
                            planes[c, m] = sums[m, k, c]
                else:
                    for n in range(total_counts[r]):
                        packed, at = total_words[r, n], total_indices[r, n]
                        planes[0, at] += total_peaks[r, 0] / np.float32(1023.0) * (np.int32(packed << 21) >> 21)
                        planes[1, at] += total_peaks[r, 1] / np.float32(1023.0) * (np.int32(packed << 10) >> 21)
                        planes[2, at] += total_peaks[r, 2] / np.float32(511.0) * (np.int32(packed) >> 22)
                number = select(planes, kept, held, scratch, index)
                for n in range(number):
                    for c in range(3):
                        values[n, c] = planes[c, kept[n]]
                if again == 0:
                    found_counts[r] = store_vector(
                        values[:number], kept, step, found_indices[r], found_words[r], found_peaks[r]
                    )
                else:
                    total_counts[r] = store_vector(
                        values[:number], kept, step, total_indices[r], total_words[r], total_peaks[r]
                    )
