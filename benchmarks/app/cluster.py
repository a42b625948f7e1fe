"""Bakes on a cluster: memory by its growth with the vertices of the model, and how far prices of a plan are off.

For memory a relief of each size is baked by `lightarc bake --cluster` in each mode on a cluster of one worker on this
machine, each a process of its own, whose memory is sampled ten times a second (`large_memory.memory_of`), that of
mapped files apart. Arrays that large bakes keep in unnamed files are kept there from the first byte, and memory that
arrays have left goes back to the system at once, as that of arrays of millions of vertices does. The relief is open, so
that its back is baked as well: twice as many vertices as the model has. Directions are few, and the cube map has half
the edge of the usual one, because their number adds nothing that grows with the model but in files.

How tasks are done is nothing to the process that writes the file. So that large models can be measured, `writer_memory`
has the worker send made-up results, as many and as large as those of a bake.

For prices, the fits of a relief are given to workers that wait for known seconds, as various as those of a bake, and
send as many bytes back: nothing but the schedule is judged that `lightarc plan --cluster` plays through, with order,
stragglers, scheduler and transfer, also on a machine whose cores are busy. Workers are ready beforehand.
"""

from __future__ import annotations

import logging
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import trimesh

from benchmarks.app.large_memory import memory_of, run_watched
from benchmarks.measure import Accuracy
from engine.core.cluster import measure_cluster
from engine.core.errors import MissingCapability
from engine.core.steps import Step, Steps, part
from engine.geometry.shapes import open_mesh
from engine.planning.costs.sizes import LOBE_BYTES
from engine.planning.costs.spread import ROUNDS, SERVICE_S, TASK_S, VARIES, Stage, schedule_s
from engine.transport.baking.chunks import Chunk, Recipe, Remote, Run, each_of, open_workers
from engine.transport.gaussian.fitting.fit import Fit, Piece, Waits, blocks, list_touching
from engine.transport.gaussian.fitting.flood_fill import Flood, flood
from engine.transport.gaussian.fitting.views import VIEWS

#: Vertices of the models without `--vertices` and of the largest one, and the memory that a worker may take for that.
VERTICES, LARGEST, LIMIT_BYTES = (2_000, 5_000, 10_000, 20_000), 2_000_000, 8 * 2**30

#: Vertices whose fits are priced, seconds of all of these, and workers.
PRICED, PRICED_S, PRICED_WORKERS = 20_000, 40.0, (2, 4)

#: Options of the bakes, and those of each mode: with bounces where they are cheap.
WORDS = ("--brdf", "ggx:kd=0.3,alpha=0.3,f0=0.2", "--fine", "1", "--no-check")
WORDS_OF = {
    "sh": ("--cube", "8", "--interreflection"),
    "wavelet": ("--cube", "16", "--interreflection"),
    "gaussian": ("--cube", "32", "--samples", "32"),
}

#: The command line, with no array too small for a file.
_COMMAND = "import sys, engine.storage.scratch as s; s.IN_MEMORY_BYTES = 0; from app.__main__ import main; main()"

#: Arrays from which on the C library takes memory from the system for each, and gives it back.
_MAPPED_BYTES = 1 << 17

#: The same with tasks that are made up (`MADE_UP`), of which no record is kept; vertices of the models without
#: `--vertices`, and bytes of what a vertex sees.
_MADE_UP = (
    "import importlib, benchmarks.app.cluster as c\n"
    "for name, make in c.MADE_UP.items(): importlib.import_module(name).maker = make\n"
    "for mode in ('sh', 'wavelet', 'gaussian'):\n"
    "    importlib.import_module(f'engine.transport.{mode}.bake').keep_visibility = lambda of, _kept: of\n"
    f"{_COMMAND}"
)
WRITTEN, SEEN_BYTES = (5_000, 10_000, 20_000, 40_000), 450

_INTERVAL_S = 0.1


class Peak(NamedTuple):
    """The most memory at any moment: of the worker, and of `lightarc bake`, without the pages of mapped files; and of
    these."""

    worker_bytes: int
    client_bytes: int
    client_file_bytes: int
    time_s: float


def cluster_memory(
    folder: Path, vertices: Sequence[int] = VERTICES, modes: Sequence[str] = tuple(WORDS_OF)
) -> Steps[list[Accuracy]]:
    """Peaks of the worker and of the process that writes, and what both come to at `LARGEST` vertices, in GiB.

    The line through the peaks is taken to go on: nothing of a bake grows faster than the vertices.
    """
    found = list[Accuracy]()
    for index, mode in enumerate(modes):
        steps = _find_peaks(folder, vertices, _COMMAND, mode)
        sizes, peaks = yield from part(steps, index / len(modes), (index + 1) / len(modes))
        found += [_find(who, mode, sizes, peaks) for who in ("worker", "client")]
    return found


def writer_memory(
    folder: Path, vertices: Sequence[int] = WRITTEN, modes: Sequence[str] = ("gaussian",)
) -> Steps[list[Accuracy]]:
    """The same of the process that writes, with results of a worker that are made up."""
    found = list[Accuracy]()
    for index, mode in enumerate(modes):
        steps = _find_peaks(folder, vertices, _MADE_UP, mode)
        sizes, peaks = yield from part(steps, index / len(modes), (index + 1) / len(modes))
        found.append(_find("client", mode, sizes, peaks))
    return found


def make_up_rows(recipe: Recipe) -> Callable[[Any], Chunk]:
    """Maker of chunks of a bake in spherical harmonics that compute nothing."""
    order, bounds = recipe["order"], recipe["bounds"]

    def make(task: Any) -> Chunk:
        count, on_model = int(np.diff(bounds[task[0] :][:2])[0]), bounds[task[0]] < recipe["ground_vertex"]
        rows = count * (order**2 if on_model and not recipe["diffuse"] else 1)
        return Chunk(task[0], {"rows": np.full((rows, recipe["channels"], order**2), 0.5, np.float32)}, 0.0)

    return make


def make_up_light(recipe: Recipe) -> Callable[[Any], Any]:
    """Maker of bounces in spherical harmonics that compute nothing."""
    return lambda vertices: (vertices, np.full((len(vertices), 1, recipe["order"] ** 2), 0.5, np.float32))


def make_up_wavelets(recipe: Recipe) -> Callable[[Any], Chunk]:
    """Maker of chunks of wavelets, full vectors, that compute nothing."""
    bounds, terms = recipe["bounds"], len(recipe["light_maps"]) // recipe["kinds"]

    def make(task: Any) -> Chunk:
        count, on_model = int(np.diff(bounds[task[0] :][:2])[0]), bounds[task[0]] < recipe["ground_vertex"]
        return Chunk(task[0], _make_up_vectors(count * (terms if on_model else 1), recipe["coefficients"]), 0.0)

    return make


def make_up_bounces(recipe: Recipe) -> Callable[[Any], Any]:
    """Maker of bounces in wavelets that compute nothing."""
    terms, width = recipe["factors"].terms // recipe["kinds"], max(1, recipe["coefficients"] // 2)

    def make(task: Any) -> Any:
        rows = len(task[0]) * (terms if task[0][0] < recipe["first"] else 1)
        return task[0], _make_up_vectors(rows, width), _make_up_vectors(rows, width)

    return make


def _make_up_vectors(rows: int, width: int) -> dict[str, Any]:
    return {
        "indices": np.tile(np.arange(width, dtype=np.uint16), (rows, 1)),
        "words": np.ones((rows, width), np.uint32),
        "peaks": np.ones((rows, 3), np.float32),
        "counts": np.full(rows, width, np.uint16),
    }


def make_up(recipe: Recipe) -> Callable[[Any], Any]:
    """Maker of tasks of a Gaussian bake that compute nothing: every vertex has the same lobes in half of its views."""
    lobes = int(recipe["settings"]["lobes"])
    one = Fit.empty(1, lobes)
    one.lobes.mean[..., 2] = 1.0
    for array in (one.lobes.weight, one.energy, one.norm, one.error_rel, one.preserving_error_rel):
        array[:, ::2] = 0.5

    def fit(_component: str, piece: Piece, _packed: list[bytes]) -> tuple[int, Any]:
        count = len(piece.vertices)
        return piece.number, np.concatenate([np.repeat(array, count, axis=0).reshape(-1) for array in one.arrays()])

    def look(number: int, vertices: Any, _as_block: bool) -> tuple[int, list[bytes], bytes]:
        return number, [os.urandom(SEEN_BYTES) for _ in vertices], b""

    def rows(vertices: Any, _packed: list[bytes]) -> tuple[Any, Any]:
        return vertices, np.zeros((len(vertices), 1, recipe["settings"]["order"] ** 2), np.float32)

    made: dict[str, Callable[..., Any]] = {"fit": fit, "look": look, "rows": rows}
    return lambda task: made[task[0]](*task[1])


#: Makers in place of those of a module.
MADE_UP = {
    "engine.transport.sh.bake": make_up_rows,
    "engine.transport.sh.interreflection": make_up_light,
    "engine.transport.wavelet.bake": make_up_wavelets,
    "engine.transport.wavelet.interreflection": make_up_bounces,
    "engine.transport.gaussian.bake": make_up,
}


def _find_peaks(folder: Path, vertices: Sequence[int], command: str, mode: str) -> Steps[tuple[list[int], list[Peak]]]:
    distributed = load_distributed()
    if not Path("/proc/self/smaps_rollup").exists():
        raise MissingCapability("This system does not tell the memory of a process by kind", "Measure on Linux")
    peaks = list[Peak]()
    for index, count in enumerate(sizes := sorted(vertices)):
        model = folder / f"relief-{count}.ply"
        sizes[index] = make_relief(model, count)
        with distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        ) as cluster:
            words = [command, "bake", str(model), "--mode", mode, *WORDS, *WORDS_OF[mode]]
            words += ["--cluster", cluster.scheduler_address]
            peaks.append((yield from _watch(words, folder, cluster, index / len(sizes), f"{mode}, {count:,} vertices")))
    return sizes, peaks


def load_distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise MissingCapability("A cluster needs the library distributed", "pip install distributed") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    return distributed


def cluster_price(folder: Path) -> Steps[list[Accuracy]]:
    """Errors of the predicted seconds of the fits of a bake on two and four workers that wait in place of computing."""
    distributed = load_distributed()
    mesh = open_mesh(str(_make_model(folder / "relief.ply", PRICED)))
    order = flood(mesh)
    parts, found = blocks(order), list[Accuracy]()
    starts, fitted = LOBE_BYTES * VIEWS, 4 * VIEWS * 13
    sizes = np.array([len(part) for part in parts])
    stage = Stage(PRICED_S, sizes, float(starts), float(fitted), *list_touching(order, parts))
    varies = np.exp(np.random.default_rng(1).normal(-0.5 * VARIES**2, VARIES, len(parts)))
    recipe = {"seconds": PRICED_S * sizes / sizes.sum() * varies, "back_bytes": fitted * sizes}
    for index, workers in enumerate(PRICED_WORKERS):
        with distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        ) as cluster:
            _, link = measure_cluster(cluster.scheduler_address)
            with open_workers(Remote(cluster.scheduler_address, wait, recipe)) as run:
                list(each_of(run, [(number, b"") for number in range(4 * workers)]))  # until workers are ready
                taken_s = yield from part(_run_all(order, parts, run, starts * sizes), index / 2, (index + 1) / 2)
        rounds = [schedule_s(stage, [1.0] * workers, link, SERVICE_S, seed, TASK_S) for seed in range(ROUNDS)]
        expected_s = sum(rounds) / ROUNDS
        what = (
            f"of the seconds of {len(parts):,} fits of {len(mesh.positions):,} vertices on {workers} workers: "
            f"{expected_s:.1f} s predicted, {taken_s:.1f} s taken, {PRICED_S / workers:.1f} s of waiting each"
        )
        more = {"predicted_s": expected_s, "taken_s": taken_s, "link_bytes_per_s": link.bytes_per_s}
        found.append(Accuracy(f"cluster-price-{workers}", abs(expected_s / taken_s - 1.0), what, None, more))
    return found


def wait(recipe: Recipe) -> Callable[[Any], Any]:
    """Maker of tasks that wait, and send bytes back."""

    def make(task: tuple[int, bytes]) -> tuple[int, bytes]:
        time.sleep(recipe["seconds"][task[0]])
        return task[0], bytes(recipe["back_bytes"][task[0]])

    return make


def _run_all(order: Flood, parts: Sequence[Any], run: Run, sent_bytes: Any) -> Steps[float]:
    """Seconds of all blocks, each begun when those are done that it starts from."""
    waits, begun = Waits(order, parts, np.zeros(len(parts), bool)), time.monotonic()

    def ask() -> tuple[int, bytes] | None:
        return (number := waits.ready.popleft(), bytes(sent_bytes[number])) if waits.ready else None

    for done, (number, _) in enumerate(run(ask)):
        waits.finish(number)
        yield Step(done / len(parts), f"fit {done:,} of {len(parts):,}")
    return time.monotonic() - begun


def _make_model(path: Path, count: int) -> Path:
    make_relief(path, count)
    return path


def make_relief(path: Path, count: int) -> int:
    """Write waves of about `count` vertices, which shade each other; the number of vertices."""
    side = round(count**0.5)
    x, y = np.meshgrid(np.linspace(-1.0, 1.0, side), np.linspace(-1.0, 1.0, side))
    z = 0.1 * np.sin(12.0 * x) * np.cos(9.0 * y)
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).reshape(-1)
    faces = np.concatenate(
        [np.stack([corner, corner + 1, corner + side + 1], 1), np.stack([corner, corner + side + 1, corner + side], 1)]
    )
    points = np.stack([x, y, z], -1).reshape(-1, 3)
    trimesh.Trimesh(points, faces, process=False).export(path)
    return side * side


def _watch(words: Sequence[str], folder: Path, cluster: Any, done: float, note: str) -> Steps[Peak]:
    """Run a bake and look at its memory, and at that of the worker."""
    start, worker, most, files = time.monotonic(), 0, 0, 0
    command = [sys.executable, "-c", *words, "-o", str(folder / "baked.transport")]
    path = os.pathsep.join(sys.path)
    environment = {**os.environ, "PYTHONPATH": path, "MALLOC_MMAP_THRESHOLD_": str(_MAPPED_BYTES)}

    def look(process: int) -> None:
        nonlocal worker, most, files
        everything, mapped = memory_of(process)
        most, files = max(most, everything - mapped), max(files, mapped)
        for each in cluster.workers.values():
            everything, mapped = memory_of(each.process.pid) if each.process is not None else (0, 0)
            worker = max(worker, everything - mapped)

    yield from run_watched(command, words[2], look, Step(done, note), environment)
    return Peak(worker, most, files, time.monotonic() - start)


def _find(who: str, mode: str, sizes: Sequence[int], peaks: Sequence[Peak]) -> Accuracy:
    found = [getattr(peak, f"{who}_bytes") for peak in peaks]
    slope, base = np.polyfit(sizes, found, 1) if len(sizes) > 1 else (0.0, float(found[0]))
    table = "; ".join(
        f"{size:,} vertices: {each / 2**30:.3f} GiB, {peak.time_s:.0f} s"
        for size, each, peak in zip(sizes, found, peaks, strict=True)
    )
    words = {"worker": "a worker", "client": "the process that writes, without mapped files,"}
    both = float(base + slope * LARGEST) / 2**30
    what = f"{mode}: GiB of {words[who]} at {LARGEST:,} vertices by a line of {slope / 2:,.0f} bytes for each that is "
    what += f"baked, {both:.1f} where their backs are, too; {table}"
    more = {
        "vertices": list(sizes),
        "peak_bytes": found,
        "time_s": [peak.time_s for peak in peaks],
        "slope_bytes_per_baked_vertex": float(slope) / 2,
        "with_backs_bytes": both * 2**30,
        **({"mapped_file_bytes": [peak.client_file_bytes for peak in peaks]} if who == "client" else {}),
    }
    return Accuracy(
        f"cluster-memory-{mode}-{who}", float(base + slope * LARGEST / 2) / 2**30, what, LIMIT_BYTES / 2**30, more
    )
