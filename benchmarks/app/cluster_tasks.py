"""Constants of the price of a bake on a cluster (`engine.planning.costs.spread`), by the time of processors.

That time does not depend on what else the machine does. Tasks of each kind, as large as in a bake, are done here on
models that shade themselves, and what they take for a vertex varies by so much. On a cluster of one worker, tasks that
are as large but compute nothing tell what handing them out takes this process with its scheduler, and the worker; the
first task of a bake tells what getting ready takes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.app.cluster import load_distributed, wait
from benchmarks.measure import Accuracy
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Step, Steps, drain
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import open_mesh
from engine.planning.costs.sizes import LOBE_BYTES
from engine.transport.baking.chunks import Remote, each_of, open_workers
from engine.transport.baking.visibility_record import blocks as blocks_of
from engine.transport.gaussian import bake as gaussian_bake
from engine.transport.gaussian.diffuse import CHUNK
from engine.transport.gaussian.fitting.fit import Fit, Piece, blocks
from engine.transport.gaussian.fitting.flood_fill import flood
from engine.transport.gaussian.fitting.views import VIEWS
from engine.transport.gaussian.samples import glossy_surface
from engine.transport.sh import bake as sh_bake
from engine.transport.wavelet import bake as wavelet_bake

#: Models, the BRDF, and tasks of each kind on each model, at most.
MODELS, BRDF, TASKS = ("torus-knot", "cloth"), "ggx:kd=0.3,alpha=0.3,f0=0.2", 12

#: Tasks that compute nothing, and vertices whose lobes and visibility they send as the fit of a block does.
EMPTY, FITTED = 400, 32

Task = tuple[int, Callable[[], object]]


def cluster_tasks(_folder: Path) -> Steps[list[Accuracy]]:
    """Spread of the seconds of tasks, and seconds of the scheduler, of a worker, and until one is ready."""
    spreads: dict[str, list[float]] = {}
    for index, name in enumerate(MODELS):
        for kind, tasks in _list_tasks(open_mesh(name)):
            yield Step(0.8 * index / len(MODELS), f"{kind} of {name}")
            spreads.setdefault(kind, []).append(_measure_spread(tasks))
    found = [
        Accuracy(
            f"cluster-varies-{kind}",
            math.sqrt(sum(each * each for each in of_models) / len(of_models)),
            "standard deviation of the logarithm of the time of a task for a vertex, "
            + ", ".join(f"{model}: {each:.2f}" for model, each in zip(MODELS, of_models, strict=True)),
        )
        for kind, of_models in spreads.items()
    ]
    yield Step(0.8, "handing tasks out")
    return found + _measure_handing()


def _list_tasks(mesh: Mesh) -> Iterator[tuple[str, list[Task]]]:
    """Kinds of tasks, and some of each, which lie evenly over the model."""
    brdf = brdf_from_text(BRDF)
    model, settings = glossy_surface(mesh, brdf), gaussian_bake.BakeSettings()
    baker = gaussian_bake.Baker(model, settings)
    looked: list[Any] = _choose(blocks_of(model.of, settings.edge))
    yield "visibility", [(len(some), partial(baker.look, 0, some, False)) for some in looked]
    fitted = _choose(blocks(flood(mesh)))
    alone = Fit.empty(0, settings.lobes).lobes
    rows = [np.arange(start, min(start + CHUNK, len(model.of))) for start in range(0, len(model.of), CHUNK)]
    parts = {"fit": fitted, "diffuse": _choose(rows)}
    seen = {kind: [baker.look(0, some, False)[1] for some in chosen] for kind, chosen in parts.items()}
    pieces = [Piece(0, some, [np.zeros(0, np.int64)] * len(some), alone) for some in fitted]
    yield (
        "fit",
        [
            (len(each.vertices), partial(baker.fit, "direct", each, packed))
            for each, packed in zip(pieces, seen["fit"], strict=True)
        ],
    )
    yield (
        "diffuse",
        [
            (len(some), partial(baker.rows, some, packed))
            for some, packed in zip(parts["diffuse"], seen["diffuse"], strict=True)
        ],
    )
    sh = drain(sh_bake.prepare(mesh, brdf, sh_bake.BakeSettings()))
    yield "sh", _list_chunks(sh_bake.baker_of(sh, sh_bake.receivers_of(sh)), sh.bounds)
    wavelet = wavelet_bake.prepare(mesh, drain(wavelet_bake.factors_for(brdf, 2)), wavelet_bake.BakeSettings())
    of = wavelet.occluder.receivers(wavelet.surface)
    recipe = wavelet_bake.recipe_of(wavelet, of)
    yield "wavelet", _list_chunks(wavelet_bake.Baker(recipe, of), recipe["bounds"])


def _list_chunks(make: Callable[[int], object], bounds: Any) -> list[Task]:
    chosen = _choose(range(len(bounds) - 1))
    return [(int(bounds[number + 1] - bounds[number]), partial(make, number)) for number in chosen]


def _choose(whole: Sequence[Any]) -> list[Any]:
    return [whole[at] for at in np.unique(np.linspace(0, len(whole) - 1, TASKS).astype(int))]


def _measure_spread(tasks: Sequence[Task]) -> float:
    """The standard deviation of the logarithms of what tasks take for a vertex; the first is done beforehand."""
    tasks[0][1]()
    taken = []
    for vertices, work in tasks:
        begun = time.process_time()
        work()
        taken.append(math.log((time.process_time() - begun) / vertices))
    return float(np.std(taken, ddof=1))


def _measure_handing() -> list[Accuracy]:
    """Seconds of processors for a task that computes nothing, here and on a worker, and until a worker is ready."""
    distributed = load_distributed()
    sent, back = bytes(LOBE_BYTES * VIEWS * FITTED), 4 * VIEWS * 13 * FITTED
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        ) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        before = _read_clock(client)
        with open_workers(Remote(cluster.scheduler_address, gaussian_bake.maker, _recipe())) as run:
            list(each_of(run, [("look", (0, np.arange(2), False))]))
            ready_s = _read_clock(client) - before
        recipe = {"seconds": np.zeros(EMPTY), "back_bytes": np.full(EMPTY, back)}
        with open_workers(Remote(cluster.scheduler_address, wait, recipe)) as run:
            list(each_of(run, [(number, sent) for number in range(10)]))
            here, there, begun = time.process_time(), _read_clock(client), time.perf_counter()
            list(each_of(run, [(number, sent) for number in range(EMPTY)]))
            here, there = (time.process_time() - here) / EMPTY, (_read_clock(client) - there) / EMPTY
            taken_s = (time.perf_counter() - begun) / EMPTY
    return [
        Accuracy(
            "cluster-ready", ready_s, "seconds of a worker for its first task, of which all but some is getting ready"
        ),
        Accuracy("cluster-service", here, f"seconds for a task of client and scheduler; by the clock {taken_s:.4f}"),
        Accuracy("cluster-task", there, "seconds for a task of the worker, beside what it computes"),
    ]


def _recipe() -> Any:
    """What a worker gets of a Gaussian bake of the first model."""
    model, settings = glossy_surface(open_mesh(MODELS[0]), brdf_from_text(BRDF)), gaussian_bake.BakeSettings(samples=32)
    work = drain(gaussian_bake.lay_out(model, settings, probes=2))
    return gaussian_bake.recipe_of(work)


def _read_clock(client: Any) -> float:
    """Seconds of processors that the workers have taken."""

    def read() -> float:
        import time

        return time.process_time()

    return float(sum(client.run(read).values()))
