"""Fitting Gaussians to the transport of every vertex towards the 92 views.

Green2006 Sec. 4.2: all views of a vertex are fitted at once, so that the distance to
the data (Green2006 Eq. 7), the agreement of means (8) and of widths (9) with those of neighbouring views, and of the
arrangement of several lobes with that of neighbouring vertices (10) are small together. Where we differ:

- The distance of a view is relative to the square of its transport (of a dim view, to a hundredth of the brightest).
- Green2006 Eq. 10 as printed squares before the max, which punishes agreement like flipping; we take max(−⟨a, b⟩, 0)².
- Views that reflect nothing take no part in the averages of (8) and (9). They are filled afterwards with means and
  widths that are harmonic over the graph of views, which is where (8) and (9) vanish.
- After the flood fill the lobes of all vertices are numbered anew until no exchange brings neighbours nearer, and
  vertices that often disagree with neighbours are fitted again, with all of these in (10); kept is what is better.
  Single views that still disagree are fitted last (`flip_repair`).

What a vertex takes from others are lobes of neighbours that do not change meanwhile, so a block of vertices can be
fitted anywhere from its samples and a copy of these (`Piece`), to the same bits. While the flood goes on, a block can
be begun when the blocks of the front before that it touches are done; afterwards, vertices that are fitted again are
coloured so that neighbours differ, and one colour follows the other.

With beta = gamma = delta = 0 every view is a least-squares fit by itself. With alpha = 0 nothing is fitted: the start
from peak and moments is drawn together by the other terms. With one lobe (10) is empty, and neighbouring vertices give
a start and nothing else.

A plain least-squares fit of one lobe loses a tenth to a quarter of the energy; `Fit.preserving` has it all, and a
larger distance. Which of them is nearer in radiance depends on the light, so whoever knows the light chooses.

Bound by exponentials: about 0.3 ms of a core for a vertex, view and lobe with 350 samples (`python -m benchmarks --only
gaussian-fit-speed`). Memory: the samples of one block, and 52
bytes for each vertex and view (28 of them for each lobe), in unnamed files where that is much.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.core.figure_text import count_text
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import in_chunks
from engine.storage.scratch import scratch_array
from engine.transport.gaussian.fitting import lobe_matching as labels
from engine.transport.gaussian.fitting import vertex_kernel as kernel
from engine.transport.gaussian.fitting.flip_repair import repair_vertex
from engine.transport.gaussian.fitting.flood_fill import Flood, flood
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import VIEWS, view_directions, view_neighbours

Indices = NDArray[np.int64]

#: Lobes that a vertex and view may have.
MAX_LOBES = 3

#: Vertices of a block, at most, and of those that are worked on at once where it is little work.
BLOCK, ROWS = 32, 4096

#: Share of its pairs that are flipped from which on a vertex is fitted again.
OFTEN = 0.05

#: Most sweeps in which lobes are numbered anew, and in which single views are fitted again.
RENUMBERINGS, REPAIRS = 20, 3


@dataclass(frozen=True)
class FitSettings:
    """Settings of a fit; UsageError for impossible ones.

    Attributes
    ----------
    lobes : for each vertex and view, 1 to 3.
    data, mean_alignment, sigma_alignment, spatial : the weights alpha, beta, gamma, delta of Green2006 Eq. 6. The
    distance
        to the data is relative to the square of the transport, so the others do not depend on how bright a material is.
        With delta 1 in place of 0.1, 5 % fewer pairs of vertices and 13 % fewer of views were flipped, at 0.2 % more
        distance (two lobes, GGX of alpha 0.3, 250 vertices of a head).
    sweeps : over the views of a vertex, at most; fewer where nothing changes any more.
    steps : of each start, of the best start, and of a view in a sweep, at most.
    relaxations : passes over vertices that disagree with neighbours once all are fitted.
    """

    lobes: int = 1
    data: float = 1.0
    mean_alignment: float = 0.01
    sigma_alignment: float = 0.01
    spatial: float = 1.0
    sweeps: int = 8
    steps: tuple[int, int, int] = (6, 40, 8)
    relaxations: int = 2

    def __post_init__(self) -> None:
        if not 1 <= self.lobes <= MAX_LOBES:
            raise UsageError(f"{self.lobes} lobes are not possible; 1 to {MAX_LOBES} are")
        weights = self.data, self.mean_alignment, self.sigma_alignment, self.spatial
        if not all(0.0 <= weight <= 1e6 for weight in weights):
            raise UsageError("the weights of the energies must be from 0 to 1,000,000")
        if not (1 <= self.sweeps <= 1000 and 0 <= self.relaxations <= 100):
            raise UsageError(f"{self.sweeps} sweeps and {self.relaxations} relaxations are not possible")
        if not all(0 <= steps <= 1000 for steps in self.steps):
            raise UsageError(f"{self.steps} steps are not possible; each is from 0 to 1,000")

    @property
    def strengths(self) -> NDArray[np.float64]:
        """(4,) the weights alpha, beta, gamma, delta."""
        return np.array([self.data, self.mean_alignment, self.sigma_alignment, self.spatial])


@dataclass(frozen=True, eq=False)
class TransportSamples:
    """The transport of B vertices towards all 92 views at directions that suit each.

    The samples of vertex b and view v are the rows start[92 b + v] … start[92 b + v + 1] − 1; none says that nothing is
    reflected there (below the horizon). They cover the whole sphere, also where the transport is 0, densely where it
    is large: Σ area · value approximates its integral, and Σ area is 4 π.

    Attributes
    ----------
    start : (92 B + 1,) int64, rising from 0.
    direction : (N, 3) float64 unit vectors in the world, towards the light.
    value : (N, 3) float64 ≥ 0: BRDF, cosine and visibility, linear RGB in 1/sr.
    area : (N,) float64 > 0 solid angle in sr that a sample counts for.
    """

    start: NDArray[np.int64]
    direction: NDArray[np.float64]
    value: NDArray[np.float64]
    area: NDArray[np.float64]

    def __post_init__(self) -> None:
        count = len(self.area)
        if (len(self.start) - 1) % VIEWS or self.start[0] != 0 or self.start[-1] != count:
            raise ValueError("the samples are not those of 92 views of each vertex")
        if self.direction.shape != (count, 3) or self.value.shape != (count, 3):
            raise ValueError("directions, values and areas of samples do not fit together")

    def __len__(self) -> int:
        return (len(self.start) - 1) // VIEWS


@dataclass(frozen=True, eq=False)
class Fit:
    """Lobes of V vertices and what they leave over.

    Attributes
    ----------
    lobes : with the weights of least squares.
    energy : (V, 92, 3) float32 integral of the transport over the sphere.
    norm : (V, 92) float32 root of the integral of its square, summed over RGB; 0 where nothing is reflected.
    error_rel : (V, 92) float32 distance between lobes and transport over `norm`; 0 where that is 0.
    preserving_error_rel : the same with the weights of `preserving`.
    slope : (V,) float32 the largest derivative of the energy that was left, by steps of means in units of sigma and of
        log sigma: 0 in a minimum, or where only bounds are in the way.
    health : of a whole mesh: `flipped_pairs` of `compared_pairs` of neighbouring vertices, and `flipped_views` of
        `compared_views` of neighbouring views (see `engine.transport.gaussian.fitting.lobe_matching`); `views_filled`,
        `dark_vertices`, `refitted_vertices`, `largest_slope`.
    """

    lobes: Lobes
    energy: NDArray[np.float32]
    norm: NDArray[np.float32]
    error_rel: NDArray[np.float32]
    preserving_error_rel: NDArray[np.float32]
    slope: NDArray[np.float32]
    health: Health = field(default_factory=Health)

    @staticmethod
    def empty(vertices: int, lobes: int) -> Fit:
        """Room for so many vertices; arrays that are too large for memory lie in files."""
        shape = (vertices, VIEWS)
        three, one = (*shape, lobes, 3), (*shape, lobes)
        weight, mean, sigma, energy, norm, error, other = (
            scratch_array(each, np.float32) for each in (three, three, one, (*shape, 3), shape, shape, shape)
        )
        sigma[...] = 1.0
        return Fit(Lobes(weight, mean, sigma), energy, norm, error, other, np.zeros(vertices, np.float32))

    def arrays(self) -> tuple[NDArray[np.float32], ...]:
        """All arrays, vertex by vertex along the first axis."""
        lobes = self.lobes
        rest = self.energy, self.norm, self.error_rel, self.preserving_error_rel, self.slope
        return (lobes.weight, lobes.mean, lobes.sigma, *rest)

    def of(self, vertices: Indices) -> Fit:
        """A copy of some vertices."""
        some = Fit.empty(len(vertices), self.lobes.count)
        for own, array in zip(some.arrays(), self.arrays(), strict=True):
            own[:] = array[vertices]
        return some

    def put(self, vertices: Indices, other: Fit) -> None:
        """Overwrite some vertices with those of `other`."""
        for own, new in zip(self.arrays(), other.arrays(), strict=True):
            own[vertices] = new

    def preserving(self) -> Lobes:
        """The same lobes with weights scaled, for each view and colour, to the energy of the transport."""
        lobes = self.lobes
        weight = scratch_array(lobes.weight.shape, np.float32)
        for rows, obtained in self.energies():
            factor = np.where(obtained > 0.0, self.energy[rows], 1.0) / np.where(obtained > 0.0, obtained, 1.0)
            weight[rows] = lobes.weight[rows] * factor[:, :, None]
        return Lobes(weight, lobes.mean, lobes.sigma)

    def choose_lit(self, values: NDArray[np.float32]) -> NDArray[np.float32]:
        """Those of `values` (V, 92) where something is reflected; many lie in a file."""
        found, end = scratch_array((int(np.count_nonzero(self.norm > 0.0)),), np.float32), 0
        for rows in self._rows():
            some = values[rows][self.norm[rows] > 0.0]
            found[end : end + len(some)], end = some, end + len(some)
        return found

    def energies(self) -> Iterator[tuple[slice, NDArray[np.float64]]]:
        """Some rows after the other with the energies (rows, 92, 3) of their lobes, which are large."""
        for rows in self._rows():
            yield rows, Lobes(*(array[rows] for array in _list_arrays(self.lobes))).energy()

    def _rows(self) -> Iterator[slice]:
        return (slice(start, start + ROWS) for start in range(0, len(self.norm), ROWS))


@dataclass(frozen=True, eq=False)
class Piece:
    """Vertices (B,) that do not look at each other, with all that their fit takes beside samples (`fit_piece`).

    Attributes
    ----------
    number : tells it from others that are under way.
    around : for each vertex the rows of `near` that are its neighbours. near : lobes of these.
    own : fits of the vertices, where only those views are fitted anew that disagree (`flip_repair`); else None.
    hurried : with some short starts alone.
    """

    number: int
    vertices: Indices
    around: list[Indices]
    near: Lobes
    own: Fit | None = None
    hurried: bool = False


#: Makes the pieces that a function hands out until it has no more, in any order: their numbers and fits.
RunPieces = Callable[[Callable[[], "Piece | None"]], Generator[tuple[int, Fit], None, None]]


@dataclass(frozen=True, eq=False)
class Block:
    """Some vertices (B,) that were fitted, and their fit; blocks have numbers from 0 in the order of the flood."""

    index: int
    vertices: Indices
    fit: Fit


#: Gives the samples of vertices (B,).
Sampling = Callable[[Indices], TransportSamples]


def blocks(order: Flood) -> tuple[Indices, ...]:
    """The vertices of a mesh in blocks of `BLOCK` at most, in the order of the flood; none holds two fronts."""
    return tuple(front[start : start + BLOCK] for front in order.fronts for start in range(0, len(front), BLOCK))


def fit(
    mesh: Mesh,
    samples_of: Sampling,
    settings: FitSettings | None = None,
    *,
    count: int | None = None,
    known: Callable[[int], Fit | None] | None = None,
    limit_s: float | None = None,
) -> Steps[Fit]:
    """Fit the first `count` vertices of `mesh` (all by default) in this process, as `fit_pieces`.

    `samples_of` is called for a block at a time.
    """
    settings = FitSettings() if settings is None else settings
    run = partial(run_here, samples_of, settings)
    return (yield from fit_pieces(flood(mesh, count), run, settings, known=known, limit_s=limit_s))


def fit_pieces(
    order: Flood,
    run: RunPieces,
    settings: FitSettings,
    *,
    known: Callable[[int], Fit | None] | None = None,
    limit_s: float | None = None,
) -> Steps[Fit]:
    """Fit vertices in the `order` of a flood; each step's `partial` is a `Block`.

    The result does not depend on the number of threads, or on where pieces are fitted. Blocks that the relaxation
    changes come once more, with the same index. Whoever stops has valid lobes in the blocks so far.

    Parameters
    ----------
    run : fits pieces (`fit_piece`), here or elsewhere.
    known : a block that was fitted before by its number, or None; it must be what this function gave.
    limit_s : after so many seconds, vertices get the best of some short starts; they are valid, but not minimal.
    """
    parts = blocks(order)
    whole = Fit.empty(len(order.front_of), settings.lobes)
    started, done, vertices = time.perf_counter(), 0, len(order.front_of)
    found_before = np.zeros(len(parts), bool)
    for index, part in enumerate(parts if known is not None else ()):
        found = known(index) if known is not None else None
        if found is not None:
            whole.put(part, found)
            found_before[index], done = True, done + len(part)
            yield Step(
                0.95 * done / vertices,
                f"fitting vertex {count_text(done)} of {count_text(vertices)}",
                Block(index, part, found),
            )
    waits = Waits(order, parts, found_before)

    def ask() -> Piece | None:
        if not waits.ready:
            return None
        index = waits.ready.popleft()
        hurried = limit_s is not None and time.perf_counter() - started > limit_s
        around = [_before(order, int(vertex)) for vertex in parts[index]]
        return _cut(index, parts[index], around, whole, hurried=hurried)

    with closing(run(ask)) as pieces:
        for index, found in pieces:
            whole.put(parts[index], found)
            waits.finish(index)
            done += len(parts[index])
            note = f"fitting vertex {count_text(done)} of {count_text(vertices)}"
            yield Step(0.95 * done / vertices, note, Block(index, parts[index], found))
    figures = yield from _relax(whole, order, parts, run, settings)
    return replace(whole, health=_health(whole, figures))


def list_touching(order: Flood, parts: Sequence[Indices]) -> tuple[Indices, Indices]:
    """Pairs (P,) of blocks that touch, of which the second is in the next front and starts from the first."""
    count, block_of = len(parts), np.empty(len(order.front_of), np.int64)
    for number, part in enumerate(parts):
        block_of[part] = number
    vertex = np.repeat(np.arange(len(block_of)), np.diff(order.start))
    earlier = order.front_of[order.neighbour] < order.front_of[vertex]
    pairs = np.unique(block_of[order.neighbour[earlier]] * count + block_of[vertex[earlier]])
    before, after = np.divmod(pairs, max(count, 1))
    return before, after


class Waits:
    """Blocks that can be begun, `ready`, as those of the front before that they touch are done.

    `done` (blocks,) are those that are from the beginning.
    """

    def __init__(self, order: Flood, parts: Sequence[Indices], done: NDArray[np.bool_]) -> None:
        count = len(parts)
        before, after = list_touching(order, parts)
        left = ~done[before] & ~done[after]
        self._after, self._waiting = after[left], np.bincount(after[left], minlength=count)
        self._start = np.concatenate([[0], np.cumsum(np.bincount(before[left], minlength=count))])
        self.ready = deque(np.flatnonzero(~done & (self._waiting == 0)).tolist())

    def finish(self, index: int) -> None:
        """Let those begin that waited for this block alone."""
        for other in self._after[self._start[index] : self._start[index + 1]].tolist():
            self._waiting[other] -= 1
            if not self._waiting[other]:
                self.ready.append(other)


def _before(order: Flood, vertex: int) -> Indices:
    """The neighbours of a vertex in earlier fronts, as many as a fit looks at."""
    around = order.neighbours(vertex)
    return around[order.front_of[around] < order.front_of[vertex]][: kernel.NEAR]


def _cut(
    number: int, vertices: Indices, around: Sequence[Indices], whole: Fit, own: Fit | None = None, hurried: bool = False
) -> Piece:
    """`vertices` with the lobes of those `around` each, and nothing else."""
    some, row = np.unique(np.concatenate(around), return_inverse=True)
    lobes = whole.lobes
    near = Lobes(lobes.weight[some], lobes.mean[some], lobes.sigma[some])
    return Piece(number, vertices, np.split(row, np.cumsum([len(each) for each in around])[:-1]), near, own, hurried)


def run_here(
    samples_of: Sampling, settings: FitSettings, ask: Callable[[], Piece | None]
) -> Generator[tuple[int, Fit], None, None]:
    """Fit one piece after the other in this process, as `RunPieces`."""
    while (piece := ask()) is not None:
        yield piece.number, fit_piece(piece, samples_of(piece.vertices), settings)


def fit_piece(piece: Piece, samples: TransportSamples, settings: FitSettings) -> Fit:
    """The fit of the vertices of a piece from their `samples`."""
    if piece.own is not None:
        return _repair_piece(piece, piece.own, samples, settings)
    return fit_vertices(samples, piece.around, piece.near, settings, hurried=piece.hurried)


def fit_vertices(
    samples: TransportSamples,
    around: list[Indices],
    known: Lobes,
    settings: FitSettings,
    *,
    hurried: bool = False,
) -> Fit:
    """Fit B vertices, each by itself, beside neighbours (…,) that are done: rows of `known`, of which few are used."""
    lobes, (neighbours, _) = settings.lobes, view_neighbours()
    found = Fit.empty(len(samples), lobes)
    steps, sweeps = (kernel.HURRIED, 0) if hurried else (np.array(settings.steps, np.int64), settings.sweeps)

    def work(rows: slice) -> None:
        for vertex in range(rows.start, min(rows.stop, len(samples))):
            near = around[vertex][: kernel.NEAR]
            weight, mean, sigma = np.zeros((VIEWS, lobes, 3)), np.zeros((VIEWS, lobes, 3)), np.zeros((VIEWS, lobes))
            energy, norm, error = np.zeros((VIEWS, 3)), np.zeros(VIEWS), np.zeros((VIEWS, 2))
            slope = kernel.fit_vertex(
                samples.start[VIEWS * vertex : VIEWS * (vertex + 1) + 1],
                *(samples.direction, samples.value, samples.area),
                *(known.mean[near].astype(np.float64), known.sigma[near].astype(np.float64), settings.strengths),
                sweeps,
                steps,
                neighbours,
                view_directions(),
                kernel.ORDERS[lobes - 1],
                *(weight, mean, sigma, energy, norm, error),
            )
            parts = weight, mean, sigma, energy, norm, error[:, 0], error[:, 1], np.asarray(slope)
            for array, part in zip(found.arrays(), parts, strict=True):
                array[vertex] = part

    in_chunks(work, len(samples), 1)
    return found


def _relax(
    whole: Fit, order: Flood, parts: tuple[Indices, ...], run: RunPieces, settings: FitSettings
) -> Steps[dict[str, float]]:
    """Make neighbours agree, in place; figures of what was found and done."""
    changed, refitted = np.zeros(len(whole.norm), bool), np.zeros(len(whole.norm), bool)
    for _ in range(settings.relaxations):
        if settings.lobes > 1:
            changed |= labels.align(whole.lobes, order) | labels.renumber(whole.lobes, order, RENUMBERINGS)
        wanting = (labels.compute_flipped_share(whole.lobes, order) > OFTEN) | _dark_beside_lit(whole, order)
        if not wanting.any():
            break
        for same in _apart(np.flatnonzero(wanting), order):
            for vertices, found in _run_again(whole, order, same, run):
                before = labels.compute_flipped_share(whole.lobes, order, vertices=vertices)
                after = labels.compute_flipped_share(whole.lobes, order, found.lobes, vertices)
                better = (after < before) | (found.norm.max(axis=1) == 0.0)
                whole.put(vertices[better], found.of(np.flatnonzero(better)))
                refitted[vertices[better]] = True
                yield Step(0.97, f"fitting {count_text(len(vertices))} vertices again")
    if settings.lobes > 1 and settings.relaxations:
        changed |= labels.renumber(whole.lobes, order, RENUMBERINGS)
        changed |= yield from _repair(whole, order, run)
    changed |= refitted
    for index, vertices in enumerate(parts):
        if changed[vertices].any():
            yield Step(0.99, "making neighbours agree", Block(index, vertices, whole.of(vertices)))
    seen = labels.flips(whole.lobes, order)
    return {
        "flipped_pairs": seen.vertices,
        "compared_pairs": seen.vertices_compared,
        "flipped_views": seen.views,
        "compared_views": seen.views_compared,
        "refitted_vertices": int(refitted.sum()),
    }


def _run_again(
    whole: Fit, order: Flood, groups: Sequence[Indices], run: RunPieces, *, repair: bool = False
) -> Iterator[tuple[Indices, Fit]]:
    """Fit the vertices of groups of one colour anew beside all their neighbours, or `repair` their views."""
    left = iter(range(len(groups)))

    def ask() -> Piece | None:
        number = next(left, None)
        if number is None:
            return None
        around = [order.neighbours(int(vertex)) for vertex in groups[number]]
        if repair:
            return _cut(number, groups[number], around, whole, whole.of(groups[number]))
        return _cut(number, groups[number], [each[: kernel.NEAR] for each in around], whole)

    with closing(run(ask)) as pieces:
        for number, found in pieces:
            yield groups[number], found


def _repair(whole: Fit, order: Flood, run: RunPieces) -> Steps[NDArray[np.bool_]]:
    """Fit single views that still disagree anew, in place (`flip_repair`); which vertices (V,) have changed."""
    changed = np.zeros(len(whole.norm), bool)
    for _ in range(REPAIRS):
        flipped = np.flatnonzero(labels.compute_flipped_share(whole.lobes, order) > 0.0)
        before = changed.sum()
        for same in _apart(flipped, order):
            for vertices, found in _run_again(whole, order, same, run, repair=True):
                for new, old in zip(_list_arrays(found.lobes), _list_arrays(whole.lobes), strict=True):
                    changed[vertices] |= (new != old[vertices]).reshape(len(vertices), -1).any(axis=1)
                whole.put(vertices, found)
                yield Step(0.98, f"fitting single views of {count_text(len(flipped))} vertices again")
        if changed.sum() == before:
            break
    return changed


def _repair_piece(piece: Piece, own: Fit, samples: TransportSamples, settings: FitSettings) -> Fit:
    """Fits of a piece with those views fitted anew that disagree."""
    found, (neighbours, _) = own.of(np.arange(len(own.norm))), view_neighbours()
    orders = kernel.ORDERS[settings.lobes - 1]

    def work(rows: slice) -> None:
        for number in range(rows.start, min(rows.stop, len(samples))):
            views = samples.start[VIEWS * number : VIEWS * (number + 1) + 1]
            lit, energy = own.norm[number] > 0.0, own.energy[number].astype(np.float64)
            beside, row = piece.around[number], slice(number, number + 1)
            weight, mean, sigma = (  # of the vertex itself, and of those around it
                np.concatenate([one[row], other[beside]])
                for one, other in zip(_list_arrays(own.lobes), _list_arrays(piece.near), strict=True)
            )
            repair_vertex(
                0, views, samples.direction, samples.value, samples.area, lit, energy, np.arange(1, len(mean)),
                neighbours, orders, settings.strengths, weight, mean, sigma, found.error_rel[row],
                found.preserving_error_rel[row],
            )  # fmt: skip
            for array, repaired in zip(_list_arrays(found.lobes), (weight, mean, sigma), strict=True):
                array[number] = repaired[0]

    in_chunks(work, len(samples), 1)
    return found


def _list_arrays(lobes: Lobes) -> tuple[NDArray[np.float32], ...]:
    return lobes.weight, lobes.mean, lobes.sigma


def _dark_beside_lit(whole: Fit, order: Flood) -> NDArray[np.bool_]:
    """(V,) vertices that reflect nothing and were filled before a neighbour that does was known."""
    dark = whole.norm.max(axis=1) == 0.0
    return np.array([dark[vertex] and not dark[order.neighbours(vertex)].all() for vertex in range(len(dark))], bool)


def _apart(vertices: Indices, order: Flood) -> list[list[Indices]]:
    """`vertices` by colours that differ between neighbours, each in groups of at most `BLOCK`.

    So all of one colour can be worked on at once.
    """
    if not len(vertices):
        return []
    colour: dict[int, int] = {}
    for vertex in vertices:
        taken = {colour.get(int(other)) for other in order.neighbours(int(vertex))}
        colour[int(vertex)] = next(number for number in range(len(taken) + 1) if number not in taken)
    number = np.array([colour[int(vertex)] for vertex in vertices])
    same = [vertices[number == which] for which in range(int(number.max()) + 1)]
    return [[group[start : start + BLOCK] for start in range(0, len(group), BLOCK)] for group in same]


def _health(whole: Fit, figures: dict[str, Any]) -> Health:
    lit = whole.norm > 0.0
    dark = len(lit) - int(np.count_nonzero(lit.any(axis=1)))
    found = {
        **figures,
        "views_filled": lit.size - int(np.count_nonzero(lit)),
        "dark_vertices": dark,
        "largest_slope": float(whole.slope.max(initial=0.0)),
    }
    findings = []
    if figures["flipped_pairs"]:
        text = (
            f"{count_text(figures['flipped_pairs'])} of {count_text(figures['compared_pairs'])} pairs of neighbours "
            "disagree on their lobes"
        )
        findings.append(Finding(Verdict.NOTE, text))
    if dark:
        findings.append(Finding(Verdict.NOTE, f"{count_text(dark)} vertices reflect no light towards any view"))
    return Health(MappingProxyType(found), tuple(findings))
