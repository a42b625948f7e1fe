"""Bakes on a cluster: memory by its growth with the vertices of the model, and how far prices of a plan are off.

For memory a relief of each size is baked by `lightarc bake --mode gaussian --cluster` on a cluster of one worker on
this machine, each a process of its own, whose memory is sampled ten times a second (`large_memory.memory_of`), that of
mapped files apart. Arrays that large bakes keep in unnamed files are kept there from the first byte. Directions are
few, because their number adds nothing that grows with the model. The cube map has half the edge of the usual one, with
which what a vertex sees takes the process that writes some 0.4 kB more.

For prices, one relief is baked by one core of this machine, and by two workers that have a core each. The price is that
of `lightarc plan --cluster` with the seconds of the first bake in place of predicted ones, so that the schedule alone
is judged: order, stragglers, transfer and what stays behind. Workers have baked before, and are ready.
"""

from __future__ import annotations

import json
import logging
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import trimesh

from benchmarks.app.large_memory import memory_of
from benchmarks.measure import Accuracy
from engine.brdf.brdf import brdf_from_text
from engine.core.cluster import Link, measure_cluster
from engine.core.errors import InputError, MissingCapability
from engine.core.steps import Step, Steps, drain
from engine.geometry.camera import frame
from engine.geometry.shapes import open_mesh
from engine.planning.costs.cost_model import CostModel
from engine.planning.costs.machine_profile import quick_profile
from engine.planning.costs.planned import planning_of
from engine.planning.costs.setting import Setting
from engine.planning.costs.spread import MODEL_BYTES, READY_S, Price, price
from engine.scene.scene import Scene
from engine.tradeoff.predict import Predictions

#: Vertices of the models without `--vertices` and of the largest one, and the memory that a worker may take for that.
VERTICES, LARGEST, LIMIT_BYTES = (5_000, 10_000, 20_000), 2_000_000, 8 * 2**30

#: Vertices of the model of which bakes are priced.
PRICED = 5_000

#: Options of the bakes, and those of each mode.
WORDS = ("--brdf", "ggx:kd=0.3,alpha=0.3,f0=0.2", "--cube", "32", "--fine", "1", "--no-check")
MODES = {"gaussian": ("--mode", "gaussian", "--samples", "32"), "sh": ("--mode", "sh")}

#: The command line, with no array too small for a file.
_COMMAND = "import sys, engine.storage.scratch as s; s.IN_MEMORY_BYTES = 0; from app.__main__ import main; main()"

_INTERVAL_S = 0.1


class Peak(NamedTuple):
    """The most memory at any moment: of the worker, and of `lightarc bake`, without the pages of mapped files; and of
    these."""

    worker_bytes: int
    client_bytes: int
    client_file_bytes: int
    time_s: float


def cluster_memory(folder: Path, vertices: Sequence[int] = VERTICES) -> Steps[list[Accuracy]]:
    """Peaks of the worker and of the process that writes, and what both come to at `LARGEST` vertices, in GiB.

    The line through the peaks is taken to go on: nothing of a bake grows faster than the vertices.
    """
    distributed = _library()
    if not Path("/proc/self/smaps_rollup").exists():
        raise MissingCapability("This system does not tell the memory of a process by kind", "Measure on Linux")
    peaks = list[Peak]()
    for index, count in enumerate(sizes := sorted(vertices)):
        model = folder / f"relief-{count}.ply"
        sizes[index] = make_relief(model, count)
        with distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
        ) as cluster:
            words = ["bake", str(model), *WORDS, *MODES["gaussian"], "--cluster", cluster.scheduler_address]
            peaks.append((yield from _watch(words, folder, cluster, index / len(sizes), f"{count:,} vertices")))
    return [_find(who, sizes, peaks) for who in ("worker", "client")]


def _library() -> Any:
    try:
        import distributed
    except ImportError:
        raise MissingCapability("A cluster needs the library distributed", "pip install distributed") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    return distributed


def cluster_price(folder: Path, vertices: Sequence[int] = (PRICED,)) -> Steps[list[Accuracy]]:
    """Errors of the predicted seconds of bakes on two workers, by Gaussians and by spherical harmonics."""
    distributed, count = _library(), max(vertices)
    if not hasattr(os, "sched_setaffinity") or (os.cpu_count() or 1) < 2:
        raise MissingCapability("Processes cannot be kept on one core each", "Measure on Linux with two cores")
    small, model = folder / "small.ply", folder / f"relief-{count}.ply"
    make_relief(small, 400)
    count, found = make_relief(model, count), list[Accuracy]()
    yield Step(0.0, "measuring this machine")
    costs = drain(quick_profile())
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=50
    ) as cluster:
        for core, worker in enumerate(cluster.workers.values()):
            os.sched_setaffinity(worker.process.pid, {core})
        _, link = measure_cluster(cluster.scheduler_address)
        for index, (mode, own) in enumerate(MODES.items()):
            words, there = [*WORDS, *own], ["--cluster", cluster.scheduler_address]
            for number, mesh in enumerate((small, model)):
                yield Step((index + 0.4 * number) / 2, f"{mode}, one core")
                here_s = _bake_s([str(mesh), *words], folder, core=0)
                yield Step((index + 0.4 * number + 0.3) / 2, f"{mode}, two workers")
                there_s = _bake_s([str(mesh), *words, *there], folder)
            expected = _price(costs, mode, model, here_s, link)
            what = (
                f"of the seconds of a bake of {count:,} vertices ({mode}) on two workers: {expected.bake_s:.1f} s "
                f"predicted, {there_s:.1f} s taken, {here_s:.1f} s on one core; {expected.waiting_s:.1f} s of waiting "
                f"and {expected.transfer_s:.1f} s of transfer at {link.bytes_per_s / 1e6:.0f} MB/s are part of it"
            )
            more = {**asdict(expected), "taken_s": there_s, "here_s": here_s, "link_bytes_per_s": link.bytes_per_s}
            found.append(Accuracy(f"cluster-price-{mode}", abs(expected.bake_s / there_s - 1.0), what, None, more))
    return found


def _price(costs: CostModel, mode: str, path: Path, here_s: float, link: Link) -> Price:
    """The price of a bake on two workers that are ready, each like the one core that took `here_s`."""
    mesh = open_mesh(str(path))
    brdf = brdf_from_text("ggx:kd=0.3,alpha=0.3,f0=0.2")
    scene = Scene(mesh, frame(mesh.positions), brdf)
    load, setting = Predictions(costs, scene, (1, 1), 1, 1, tables_made=False).load, Setting(mode)
    predicted_s = planning_of(mode).cost(costs, setting, load).bake_s
    stages = [each.scale(here_s / predicted_s) for each in planning_of(mode).stages(costs, setting, load, mesh)]
    rest_s = here_s - sum(each.seconds for each in stages)
    cold = price(stages, rest_s, MODEL_BYTES * load.vertices, [1.0, 1.0], link)
    return replace(cold, bake_s=cold.bake_s - READY_S, waiting_s=cold.waiting_s - READY_S)


def _bake_s(words: Sequence[str], folder: Path, core: int | None = None) -> float:
    """Seconds of a bake, by one core where one is named."""
    pinned = "" if core is None else f"import os; os.sched_setaffinity(0, {{{core}}}); "
    command = f"{pinned}import sys; from app.__main__ import main; main()"
    output = ["-o", str(folder / "baked.transport"), "--restart", "--json"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", command, "bake", *words, *output], capture_output=True, text=True, env=environment
    )
    if done.returncode:
        raise InputError(words[0], f"could not be baked: {done.stderr.strip()[-300:]}", "Measure another model")
    return float(json.loads(done.stdout)["bake_s"])


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
    command = [sys.executable, "-c", _COMMAND, *words, "-o", str(folder / "baked.transport")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        try:
            while process.poll() is None:
                everything, mapped = memory_of(process.pid)
                most, files = max(most, everything - mapped), max(files, mapped)
                for each in cluster.workers.values():
                    everything, mapped = memory_of(each.process.pid) if each.process is not None else (0, 0)
                    worker = max(worker, everything - mapped)
                yield Step(done, note)
                time.sleep(_INTERVAL_S)
        finally:
            process.kill()
        message = process.stderr.read() if process.stderr else ""
    if process.returncode:
        raise InputError(words[1], f"could not be measured: {message.strip()[-300:]}", "Make room, or measure less")
    return Peak(worker, most, files, time.monotonic() - start)


def _find(who: str, sizes: Sequence[int], peaks: Sequence[Peak]) -> Accuracy:
    found = [getattr(peak, f"{who}_bytes") for peak in peaks]
    slope, base = np.polyfit(sizes, found, 1) if len(sizes) > 1 else (0.0, float(found[0]))
    table = "; ".join(
        f"{size:,} vertices: {each / 2**30:.3f} GiB, {peak.time_s:.0f} s"
        for size, each, peak in zip(sizes, found, peaks, strict=True)
    )
    words = {"worker": "a worker", "client": "the process that writes, without mapped files,"}
    what = f"GiB of {words[who]} at {LARGEST:,} vertices by a line of {slope:,.0f} bytes a vertex; {table}"
    more = {
        "vertices": list(sizes),
        "peak_bytes": found,
        "time_s": [peak.time_s for peak in peaks],
        "slope_bytes_per_vertex": float(slope),
        **({"mapped_file_bytes": [peak.client_file_bytes for peak in peaks]} if who == "client" else {}),
    }
    return Accuracy(f"cluster-memory-{who}", float(base + slope * LARGEST) / 2**30, what, LIMIT_BYTES / 2**30, more)
