"""The Gaussian fit: how long it takes beside the limit that is set, and how near it comes to an unhurried search.

The search looks for the lowest distance of a vertex and view by itself: trust-region least squares of scipy on means
and logarithms of widths, with the best weights that are not negative at each step, from many starts. The fit has the
same samples, but all views at once and 1 ms. Models are the bunny and the armadillo where the folder of real data lies
beside the project, and otherwise the built-in torus knot.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, nnls

from benchmarks.measure import Accuracy, Measure
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Step, Steps, part
from engine.geometry.mesh import Mesh, read_mesh
from engine.geometry.shapes import shape
from engine.light.gaussian_prefilter import gaussian_integral
from engine.transport.gaussian.fitting.fit import Fit, FitSettings, TransportSamples, blocks, fit_vertices
from engine.transport.gaussian.fitting.flood_fill import flood
from engine.transport.gaussian.fitting.lobes import NARROWEST, WIDEST_LOBE, gaussian
from engine.transport.gaussian.fitting.view_kernel import COARSE
from engine.transport.gaussian.fitting.views import VIEWS
from engine.transport.gaussian.samples import direct_samples, glossy_surface

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "mesh" / "classic"
MODELS = ("stanford-bunny.obj", "armadillo.obj")

#: Reflectances whose lobes are searched for, and the one whose fit is timed.
BRDFS = ("ashikhmin-shirley:kd=0,ks=0.5,nu=10,nv=10", "ggx:kd=0,alpha=0.3,f0=1", "ggx:kd=0,alpha=0.1,f0=1")

#: Directions of a vertex and view; views of each vertex that are looked at; starts of the search for each lobe.
SAMPLES, VIEWS_EACH, STARTS = 256, 5, 10

#: Pairs of vertex and view in all, by the number of lobes.
PAIRS = {1: 500, 2: 120}

#: Vertices that are timed, those that a bake is judged by, and the seconds that it may take.
TIMED, WHOLE, LIMIT_S = 320, 10_000, 600.0

Floats = NDArray[np.float64]


def gaussian_fit_speed() -> Measure:
    """One lobe for 10,000 vertices from some blocks of the torus knot, samples and all, against the ten minutes."""
    mesh = shape("torus-knot")
    surface = glossy_surface(mesh, brdf_from_text(BRDFS[1]))
    order = blocks(flood(mesh))
    chosen = [order[index] for index in np.linspace(0, len(order) - 1, TIMED // 20).astype(int)]
    settings, nobody = FitSettings(), Fit.empty(0, 1).lobes
    fit_vertices(direct_samples(surface, order[0][:2], SAMPLES), [np.zeros(0, np.int64)] * 2, nobody, settings)
    sampled_s, fitted_s, count, cpu = 0.0, 0.0, 0, time.process_time()
    for vertices in chosen:
        start = time.perf_counter()
        samples = direct_samples(surface, vertices, SAMPLES)
        between = time.perf_counter()
        fit_vertices(samples, [np.zeros(0, np.int64)] * len(vertices), nobody, settings)
        sampled_s += between - start
        fitted_s += time.perf_counter() - between
        count += len(vertices)
    scale = WHOLE / count
    more = {
        "vertices": WHOLE,
        "vertices_timed": count,
        "samples": SAMPLES,
        "fit_s": fitted_s * scale,
        "sampling_s": sampled_s * scale,
        "processor_s": (time.process_time() - cpu) * scale,
    }
    return Measure("gaussian-fit-speed", (sampled_s + fitted_s) * scale, LIMIT_S, "ten minutes", more)


def gaussian_fit_quality(_folder: Path) -> Steps[list[Accuracy]]:
    """The mean relative L² distance of the fit over that of the search, less 1; a twentieth is promised."""
    meshes = [read_mesh(DATA / name) for name in MODELS if (DATA / name).is_file()] or [shape("torus-knot")]
    found = []
    for index, (lobes, pairs) in enumerate(PAIRS.items()):
        each = -(-pairs // (len(meshes) * len(BRDFS)))
        steps = compare_with(meshes, lobes, each)
        pair = yield from part(steps, index / len(PAIRS), (index + 1) / len(PAIRS))
        found += _accuracies(pair, lobes)
    return found


@dataclass(frozen=True, eq=False)
class Compared:
    """Relative L² distances (P,) of pairs of vertex and view: of the fit, and the least that the search found."""

    fitted: Floats
    searched: Floats


def compare_with(meshes: list[Mesh], lobes: int, pairs: int, *, seed: int = 1) -> Steps[Compared]:
    """For so many random pairs of each mesh and BRDF of `BRDFS`."""
    random, rows = np.random.default_rng(seed), []
    cases = [(mesh, text) for mesh in meshes for text in BRDFS]
    for index, (mesh, text) in enumerate(cases):
        surface = glossy_surface(mesh, brdf_from_text(text))
        count = -(-pairs // VIEWS_EACH)
        vertices = np.sort(random.choice(len(mesh.positions), count, replace=False))
        samples = direct_samples(surface, vertices, SAMPLES)
        alone = [np.zeros(0, np.int64)] * count
        found = fit_vertices(samples, alone, Fit.empty(0, lobes).lobes, FitSettings(lobes=lobes))
        lit = np.argwhere(found.norm > 0.0)
        chosen = lit[random.choice(len(lit), min(pairs, len(lit)), replace=False)]
        for done, (vertex, view) in enumerate(chosen):
            best = search(*_rows(samples, int(vertex), int(view)), lobes, random)
            if best is not None:
                rows.append((found.error_rel[vertex, view], best))
            share = (index + (done + 1) / len(chosen)) / len(cases)
            yield Step(share, f"searching for {lobes} lobes of {mesh.name}")
    return Compared(*np.array(rows, np.float64).T)


def _rows(samples: TransportSamples, vertex: int, view: int) -> tuple[Floats, Floats, Floats]:
    place = VIEWS * vertex + view
    rows = slice(samples.start[place], samples.start[place + 1])
    return samples.direction[rows], samples.value[rows], samples.area[rows]


def search(direction: Floats, value: Floats, area: Floats, lobes: int, random: np.random.Generator) -> float | None:
    """Least relative distance of so many Gaussians from samples (S, 3); None where no start leads anywhere.

    Gaussians that fall between the samples are left out, as the fit leaves them out.
    """
    root, norm = np.sqrt(area)[:, None], float(np.sqrt((area[:, None] * value**2).sum()))
    weighted, bright = value * root, area * value.sum(axis=1)

    def functions(parameters: Floats) -> Floats:
        own = parameters.reshape(lobes, 4)
        mean = own[:, :3] / np.linalg.norm(own[:, :3], axis=1)[:, None]
        return gaussian(direction[:, None], mean, np.exp(own[:, 3])) * root

    def leave(parameters: Floats) -> Floats:
        basis = functions(parameters)
        weights = np.stack([nnls(basis, weighted[:, c])[0] for c in range(3)], axis=1)
        result: Floats = ((basis @ weights - weighted) / norm).ravel()
        return result

    low, high = [-np.inf] * 3 + [np.log(NARROWEST)], [np.inf] * 3 + [np.log(WIDEST_LOBE)]
    best = []
    for number in range(STARTS * lobes):
        mean = direction[random.choice(len(direction), lobes, p=bright / bright.sum() if number % 2 else None)]
        start = np.column_stack([mean, random.uniform(np.log(0.03), 0.0, lobes)]).ravel()
        end: Any = least_squares(leave, start, bounds=(low * lobes, high * lobes), max_nfev=100)
        width = np.exp(end.x.reshape(lobes, 4)[:, 3])
        share = (functions(end.x) ** 2).sum(axis=0) / gaussian_integral(width / np.sqrt(2.0))
        if share.max() < COARSE and share.min() > 1.0 / COARSE:
            best.append(float(np.sqrt(2.0 * end.cost)))
    return min(best, default=None)


def _accuracies(pairs: Compared, lobes: int) -> list[Accuracy]:
    many, words = len(pairs.fitted), f"{lobes} lobe{'s' if lobes > 1 else ''}"
    worse = float(np.mean(pairs.fitted > 1.05 * pairs.searched))
    return [
        Accuracy(
            f"gaussian-fit-{lobes}",
            float(pairs.fitted.mean() / pairs.searched.mean()) - 1.0,
            f"mean relative L² of {words} over that of a search from {STARTS * lobes} starts, less 1; {many} pairs",
            0.05,
        ),
        Accuracy(f"gaussian-fit-{lobes}-worse", worse, f"share of these pairs that are worse by a twentieth; {words}"),
        Accuracy(f"gaussian-fit-{lobes}-distance", float(pairs.fitted.mean()), f"mean relative L² itself; {words}"),
    ]
