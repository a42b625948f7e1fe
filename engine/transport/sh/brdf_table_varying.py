"""Reflectances in spherical harmonics whose parameters differ from vertex to vertex (Kautz2002 Sec. 3).

There are tables at the nodes of a grid over one or two numbers in [0, 1], which move a parameter each
(`engine.transport.baking.spatially_varying`), and a vertex mixes those of the corners of its cell: linear in one
number, bilinear in two. Only numbers that vertices have are covered. An interval gets a node in its middle where the
BRDF there differs from the mean of its ends by more than `TOLERANCE` of its size (root mean square over
coefficients and some views), beside three values of the other number. What is left is measured in the middles of cells:
`interpolation_rel`.

A table takes 0.5 s at order 5 where the BRDF is isotropic and 1.5 s where it is brushed, and looking for where
tables are needed a tenth of that for each; a smooth parameter needs 2 to 9, and two of a brushed one up to 25 in all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.core.cached import cached_property
from engine.core.directions import Vectors
from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps, part, relay
from engine.factor.hemisphere_map import HemisphereMap
from engine.geometry.mesh import Mesh
from engine.transport.baking.spatially_varying import (
    Variation,
    check_variations,
    vary_brdf,
    vertex_values,
)
from engine.transport.sh.brdf_table import (
    MAP_SIZE,
    BrdfTable,
    coefficients_towards,
    isotropic_views,
    tabulate,
)

#: Numbers that may move a parameter each.
MAX_VARIATIONS = 2

#: An interval between tables is halved while its middle is off by more than this, relative.
TOLERANCE = 0.01

#: Most tables along the only number, and along each of two; the same of brushed BRDFs, whose tables are large.
MAX_NODES, MAX_BRUSHED_NODES = (17, 9), (9, 5)

#: Most bytes of the tables of a brushed BRDF while they are made.
MAX_BYTES = 1 << 29

#: Cells whose middles are compared.
MAX_CELLS = 16

#: Views towards which a BRDF is compared.
VIEWS = 24

Result = TypeVar("Result")

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class VariedTable:
    """Tables at the nodes of a grid, and where in the grid each vertex of the model is.

    Attributes
    ----------
    tables : as `varied_brdfs` orders them: the last number runs fastest. All isotropic or none, all diffuse or none.
    nodes : for each number where its tables are, rising within 0 … 1.
    numbers : (V, K) of the vertices, within their nodes.
    interpolation_rel : how far mixed tables are from those of their own, at most in the middles of the cells tried.
    """

    tables: tuple[BrdfTable, ...]
    nodes: tuple[Floats, ...]
    numbers: Floats
    interpolation_rel: float = 0.0

    def __post_init__(self) -> None:
        shape = tuple(len(some) for some in self.nodes)
        if not 1 <= len(shape) <= MAX_VARIATIONS or len(self.tables) != int(np.prod(shape)) or 0 in shape:
            raise ValueError(f"{len(self.tables)} tables do not fill a grid of {shape}")
        first = self.tables[0]
        if any((t.values.shape, t.diffuse) != (first.values.shape, first.diffuse) for t in self.tables):
            raise ValueError("tables of one reflectance are of one kind")
        if self.numbers.ndim != 2 or self.numbers.shape[1] != len(shape) or not np.isfinite(self.numbers).all():
            raise ValueError("vertices need a finite number for each parameter")
        for some, number in zip(self.nodes, self.numbers.T, strict=True):
            if not (np.diff(some) > 0.0).all() or some[0] < 0.0 or some[-1] > 1.0:
                raise ValueError("nodes do not rise within 0 … 1")
            if number.size and not (some[0] <= number.min() and number.max() <= some[-1]):
                raise ValueError("a vertex lies outside the tables")

    @property
    def order(self) -> int:
        return self.tables[0].order

    @property
    def isotropic(self) -> bool:
        return self.tables[0].isotropic

    @property
    def diffuse(self) -> bool:
        return self.tables[0].diffuse

    @property
    def error_rel(self) -> float:
        """The largest relative error of the sums in the tables."""
        return max(table.error_rel for table in self.tables)

    @property
    def health(self) -> Health:
        figures = {"table_error_rel": self.error_rel, "interpolation_rel": self.interpolation_rel}
        findings = next((table.health.findings for table in self.tables if table.health.findings), ())
        if self.interpolation_rel > 2.0 * TOLERANCE:
            text = f"Between its tables the varied BRDF has an error of up to {percent(self.interpolation_rel, 3)}."
            findings = (*findings, Finding(Verdict.WARNING, text))
        return Health(MappingProxyType(figures), findings)

    @cached_property
    def places(self) -> NDArray[np.float32]:
        """(V, 2) where each vertex is in the grid, in steps of nodes from the first; 0 for a number that is not."""
        places = np.zeros((len(self.numbers), 2), np.float32)
        for axis, (some, number) in enumerate(zip(self.nodes, self.numbers.T, strict=True)):
            places[:, axis] = np.interp(number, some, np.arange(len(some)))
        return places

    @property
    def steps(self) -> tuple[int, int]:
        """Tables along the first and the second number; 1 for a number that is not."""
        return len(self.nodes[0]), len(self.nodes[1]) if len(self.nodes) > 1 else 1

    def corners(self, vertices: ArrayLike) -> tuple[NDArray[np.int64], Floats]:
        """Tables (N, 4) of the corners of the cells of `vertices`, and their shares, sum 1."""
        places = self.places[np.asarray(vertices, np.int64)].astype(np.float64)
        steps = np.array(self.steps)
        low = np.clip(places.astype(np.int64), 0, np.maximum(steps - 2, 0))
        share, high = places - low, np.minimum(low + 1, steps - 1)
        index, weight = [], []
        for first, second in product((0, 1), repeat=2):
            row, column = (high if first else low)[:, 0], (high if second else low)[:, 1]
            index.append(row * steps[1] + column)
            weight.append(np.abs(1 - first - share[:, 0]) * np.abs(1 - second - share[:, 1]))
        return np.stack(index, axis=-1), np.stack(weight, axis=-1)

    def at(self, wo: ArrayLike, vertices: ArrayLike) -> Floats:
        """Coefficients (N, order², 3) of `vertices` (N,) towards wo (N, 3), as `BrdfTable.at`."""
        directions = np.ascontiguousarray(wo, np.float64).reshape(-1, 3)
        total = np.zeros((len(directions), self.order**2, 3))
        for table, some, share in self._users(vertices):
            total[some] += table.at(directions[some]) * share[:, None, None]
        return total

    def radiance(self, light: NDArray[Any], wo: ArrayLike, vertices: ArrayLike) -> Floats:
        """(N, 3) of `vertices` (N,) towards wo (N, 3) under `light` (N, order², 3), as `BrdfTable.radiance`."""
        directions = np.ascontiguousarray(wo, np.float64).reshape(-1, 3)
        total = np.zeros((len(directions), 3))
        for table, some, share in self._users(vertices):
            total[some] += table.radiance(light[some], directions[some]) * share[:, None]
        return total

    def _users(self, vertices: ArrayLike) -> list[tuple[BrdfTable, NDArray[np.int64], Floats]]:
        """Each table that is needed, by which of `vertices`, and its share there."""
        index, weight = self.corners(vertices)
        users = []
        for number, table in enumerate(self.tables):
            share = np.where(index == number, weight, 0.0).sum(axis=1)
            some = np.flatnonzero(share)
            if some.size:
                users.append((table, some, share[some]))
        return users

    @cached_property
    def even_albedo(self) -> Floats:
        """(V, 3) as `BrdfTable.even_albedo`."""
        albedo = np.array([table.even_albedo for table in self.tables])
        index, weight = self.corners(np.arange(len(self.numbers)))
        return np.asarray(np.einsum("vk,vkc->vc", weight, albedo[index]))

    def reduce_order(self, order: int) -> VariedTable:
        tables = tuple(table.reduce_order(order) for table in self.tables)
        return VariedTable(tables, self.nodes, self.numbers, self.interpolation_rel)


#: The BRDF of a model, the same for all vertices or not.
Table = BrdfTable | VariedTable


def tables_of(table: Table) -> tuple[BrdfTable, ...]:
    """All that there are."""
    return table.tables if isinstance(table, VariedTable) else (table,)


def table_of(
    brdf: Brdf, order: int, variations: Sequence[Variation], mesh: Mesh, count: int | None = None
) -> Steps[Table]:
    """The table of `brdf`, or where there are `variations` the tables for the first `count` vertices of `mesh`."""
    if not variations:
        return (yield from tabulate(brdf, order))
    check_variations(brdf, variations)
    numbers = np.stack([vertex_values(mesh, variation.source, count) for variation in variations], axis=1)
    return (yield from tabulate_varied(brdf, order, variations, numbers))


def tabulate_varied(brdf: Brdf, order: int, variations: Sequence[Variation], numbers: Floats) -> Steps[VariedTable]:
    """Tables of `brdf` for vertices whose parameters the `numbers` (V, K) in [0, 1] move; as many as are needed.

    UsageError for parameters that the BRDF does not have, and for more variations than `MAX_VARIATIONS`.
    """
    if not 1 <= len(variations) <= MAX_VARIATIONS:
        raise UsageError(f"{len(variations)} parameters are to vary; spherical harmonics have tables over 1 or 2")
    probes = _Probes(brdf, order, check_variations(brdf, variations))
    nodes = [_ends(number) for number in numbers.T]
    for axis in range(len(nodes)):
        nodes[axis] = yield from _refine(probes, nodes, axis)
    left = yield from _between(probes, nodes)
    grid, tables = vary_brdf(brdf, variations, nodes), []
    for number, one in enumerate(grid):
        named = _name_steps(tabulate(one, order), f"table {number + 1} of {len(grid)}")
        tables.append((yield from part(named, 0.3 + 0.7 * number / len(grid), 0.3 + 0.7 * (number + 1) / len(grid))))
    return VariedTable(tuple(tables), tuple(nodes), np.asarray(numbers, np.float64), left)


def tabulate_kinds(brdfs: Sequence[Brdf], kind: NDArray[np.int64], order: int) -> Steps[Table]:
    """The tables of several BRDFs, of which each vertex has the one that `kind` (V,) says.

    They are the nodes of one number, at which each vertex lies. Where a BRDF is brushed, all have maps.
    """
    tables: list[BrdfTable] = []
    for number, brdf in enumerate(brdfs):
        named = _name_steps(tabulate(brdf, order), f"table {number + 1} of {len(brdfs)}")
        tables.append((yield from part(named, number / len(brdfs), (number + 1) / len(brdfs))))
    if len(tables) == 1:
        return tables[0]
    nodes = np.linspace(0.0, 1.0, len(tables))
    return VariedTable(tuple(_unify_shapes(tables)), (nodes,), nodes[kind][:, None])


def _unify_shapes(tables: Sequence[BrdfTable]) -> list[BrdfTable]:
    """The same tables with values of one shape, and diffuse only where all are."""
    diffuse = all(table.diffuse for table in tables)
    if all(table.isotropic for table in tables):
        rows = max(len(table.values) for table in tables)
        values = [table.at(isotropic_views(rows)) if len(table.values) < rows else table.values for table in tables]
    else:
        values = [_make_map(table) if table.isotropic else table.values for table in tables]
    return [replace(table, values=value, diffuse=diffuse) for table, value in zip(tables, values, strict=True)]


def _make_map(table: BrdfTable) -> Floats:
    """The values of an isotropic table as the map of a brushed one."""
    hemisphere_map = HemisphereMap("parabolic", MAP_SIZE)
    values = np.zeros((*hemisphere_map.shape, table.order**2, 3))
    values[hemisphere_map.mask] = table.at(hemisphere_map.directions)
    return values


class _Probes:
    """Coefficients of a BRDF towards a few views, by the numbers that they are for."""

    def __init__(self, brdf: Brdf, order: int, variations: Sequence[Variation]) -> None:
        self.brdf, self.order, self.variations = brdf, order, variations
        self._views = isotropic_views(VIEWS) if brdf.isotropic else _views_around(VIEWS)
        self._known: dict[tuple[float, ...], Floats] = {}

    @property
    def max_nodes(self) -> int:
        """Along each number."""
        count = len(self.variations)
        if self.brdf.isotropic:
            return MAX_NODES[count - 1]
        most = MAX_BRUSHED_NODES[count - 1]
        size_bytes = 8 * 3 * MAP_SIZE**2 * self.order**2
        return max(2, min(most, int((MAX_BYTES // size_bytes) ** (1.0 / count))))

    def at(self, place: tuple[float, ...]) -> Steps[Floats]:
        """(N, order², 3) for the numbers `place`."""
        if place not in self._known:
            (brdf,) = vary_brdf(self.brdf, self.variations, [[number] for number in place])
            finding = coefficients_towards(brdf, self.order, self._views)
            words = f"looking where tables are needed, {len(self._known) + 1}"
            self._known[place] = yield from part(_name_steps(finding, words), 0.1, 0.1)
        return self._known[place]

    def error(self, between: Sequence[tuple[float, ...]], place: tuple[float, ...]) -> Steps[float]:
        """Relative error of the mean of the tables at `between` against the table at `place`."""
        mean = np.zeros(())
        for one in between:
            mean = mean + (yield from self.at(one)) / len(between)
        return _distance(mean, (yield from self.at(place)))


def _views_around(count: int) -> Vectors:
    """(count, 3) directions above the horizon, spread in a spiral."""
    index = np.arange(count)
    z, azimuth = 1.0 - (index + 0.5) / count, index * np.pi * (3.0 - np.sqrt(5.0))
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(azimuth), across * np.sin(azimuth), z], axis=-1)


def _name_steps(steps: Steps[Result], words: str) -> Steps[Result]:
    """`steps` that tell `words`."""
    return relay(steps, lambda step: Step(step.done, f"tabulating the reflectance, {words}"))


def _ends(number: Floats) -> Floats:
    """The least and the greatest number, or the one that all vertices have."""
    return np.unique([number.min(), number.max()]) if number.size else np.zeros(1)


def _refine(probes: _Probes, nodes: Sequence[Floats], axis: int) -> Steps[Floats]:
    """The nodes along `axis`: intervals are halved, the worst first, until all are fine or there are enough."""
    others = [np.unique([some[0], 0.5 * (some[0] + some[-1]), some[-1]]).tolist() for some in nodes]
    across = list(product(*(others[k] if k != axis else [0.0] for k in range(len(nodes)))))

    def error(low: float, high: float) -> Steps[float]:
        worst = 0.0
        for place in across:
            a, b, c = ((*place[:axis], number, *place[axis + 1 :]) for number in (low, 0.5 * (low + high), high))
            worst = max(worst, (yield from probes.error([a, c], b)))
        return worst

    found = nodes[axis].tolist()
    errors = {}
    if len(found) == 2:
        errors[found[0], found[1]] = yield from error(found[0], found[1])
    while errors and max(errors.values()) > TOLERANCE and len(found) < probes.max_nodes:
        low, high = max(errors, key=lambda interval: errors[interval])
        middle = 0.5 * (low + high)
        del errors[low, high]
        for interval in ((low, middle), (middle, high)):
            errors[interval] = yield from error(*interval)
        found = sorted([*found, middle])
    return np.array(found)


def _between(probes: _Probes, nodes: Sequence[Floats]) -> Steps[float]:
    """Relative error of the mean of a cell's corners against its middle, at most in up to `MAX_CELLS` cells."""
    sides = [list(pairwise(some)) if len(some) > 1 else [(some[0],)] for some in nodes]
    cells = list(product(*sides))
    worst = 0.0
    for number in np.unique(np.linspace(0, len(cells) - 1, MAX_CELLS).astype(np.int64)):
        cell = cells[number]
        middle = tuple(float(np.mean(side)) for side in cell)
        worst = max(worst, (yield from probes.error(list(product(*cell)), middle)))
    return worst


def _distance(values: Floats, exact: Floats) -> float:
    """The root mean square of their difference over that of `exact`."""
    size = float(np.linalg.norm(exact))
    return float(np.linalg.norm(values - exact)) / size if size > 0.0 else float(np.linalg.norm(values) > 0.0)
