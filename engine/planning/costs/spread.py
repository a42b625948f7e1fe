"""Price of a bake on the workers of a cluster: what they compute, what travels, what waits, and what stays behind.

The tasks of a bake are given out one by one as workers can take them (`engine.transport.baking.chunks`). That schedule
is played through with the seconds that the cost model predicts for this machine:

- A worker that has `speed` of this machine takes seconds / speed for a task, times a factor that is lognormal of mean 1
  (`VARIES`), because vertices differ in what they see; the largest of many is what stragglers cost. It takes `TASK_S`
  besides, to receive the task and to send the result.
- A task begins when the tasks whose results it takes are known. Fits of Gaussians go front by front over the model, so
  no more workers than blocks of a front are busy.
- All that the workers are sent and send back goes through the one link of this machine, at its `bytes_per_s` and with
  `SERVICE_S` of the scheduler for each task. Each worker gets the model once, and gets ready (`READY_S`).
- Tables and the file are made here, before and after (`rest_s`).

No worker is lost; each that is costs the tasks that it had, and READY_S of another.
"""

from __future__ import annotations

import heapq
import math
import random
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from engine.core.cluster import Link
from engine.transport.baking.chunks import AHEAD

#: Logarithmic standard deviation of the seconds of tasks with equally many vertices, root mean square over those of all
#: bakes (fits .13, diffuse rows .26, SH .27, wavelets .37, visibility .47; `benchmarks --only cluster-tasks`).
VARIES = 0.32

#: Seconds of processors for a task beside what it computes, of client and scheduler and of the worker, and until a
#: worker has loaded its kernels and the model (likewise).
SERVICE_S, TASK_S, READY_S = 8.2e-3, 4.3e-3, 1.8

#: Bytes of a model for each vertex, two triangles for each: positions, frames, and what rays and their origins take.
MODEL_BYTES = 240.0

#: Bytes of what a vertex sees over a cube map with an edge of 64, packed; over others they are as many for an edge.
SEEN_BYTES = 500.0

#: Schedules whose mean is told.
ROUNDS = 5


@dataclass(frozen=True, eq=False)
class Stage:
    """A part of a bake whose tasks workers do; the next part begins when all are done.

    Attributes
    ----------
    seconds : of all tasks on this machine.
    vertices : (T,) of each task, which its seconds grow with.
    sent_bytes, back_bytes : for each vertex, to a worker and back.
    before, after : (P,) pairs of tasks, of which the second takes results of the first.
    shared_bytes : that each worker gets before its first task, beside the model.
    """

    seconds: float
    vertices: NDArray[np.int64]
    sent_bytes: float
    back_bytes: float
    before: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    after: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    shared_bytes: float = 0.0

    def scale(self, factor: float) -> Stage:
        """The same with so many times the seconds."""
        return replace(self, seconds=factor * self.seconds)

    @property
    def bytes(self) -> float:
        """All that travels."""
        return float(self.vertices.sum()) * (self.sent_bytes + self.back_bytes)


@dataclass(frozen=True)
class Price:
    """Seconds of a bake on `workers`, which are those of its four parts together.

    Attributes
    ----------
    compute_s : of the tasks, shared evenly. waiting_s : for tasks that take longer, for others' results, and for
        workers to get ready. transfer_s : of what travels, `bytes`, beyond the time that hides it. rest_s : of what is
        made on this machine alone.
    """

    workers: int
    bake_s: float
    compute_s: float
    waiting_s: float
    transfer_s: float
    rest_s: float
    bytes: float


def price(stages: Sequence[Stage], rest_s: float, model_bytes: float, speeds: Sequence[float], link: Link) -> Price:
    """Price of the `stages` on workers with `speeds`, each a share of this machine's; each gets `model_bytes` once."""
    compute_s = sum(stage.seconds for stage in stages) / sum(speeds)
    free = Link(math.inf, 0.0)
    unhindered_s = READY_S + _mean_s(stages, speeds, free, 0.0, 0.0)
    shared = len(speeds) * (model_bytes + sum(stage.shared_bytes for stage in stages))
    linked_s = READY_S + shared / link.bytes_per_s + _mean_s(stages, speeds, link, SERVICE_S, TASK_S)
    travels = sum(stage.bytes for stage in stages) + shared
    parts = compute_s, max(0.0, unhindered_s - compute_s), max(0.0, linked_s - unhindered_s), rest_s
    return Price(len(speeds), sum(parts), *parts, travels)


def _mean_s(stages: Sequence[Stage], speeds: Sequence[float], link: Link, service_s: float, task_s: float) -> float:
    rounds = [
        sum(schedule_s(stage, speeds, link, service_s, seed, task_s) for stage in stages) for seed in range(ROUNDS)
    ]
    return sum(rounds) / len(rounds)


def schedule_s(
    stage: Stage, speeds: Sequence[float], link: Link, service_s: float, seed: int, task_s: float = 0.0
) -> float:
    """Seconds from the first task that is sent to the last result, where factors of tasks are drawn by `seed`.

    A task takes `service_s` of the scheduler and `task_s` of its worker, beside what it computes.
    """
    count, draw = len(stage.vertices), random.Random(seed)
    each_s = (stage.seconds * stage.vertices / max(int(stage.vertices.sum()), 1)).tolist()
    sent_s, back_s = (
        (stage.vertices * each / link.bytes_per_s + 0.5 * service_s).tolist()
        for each in (stage.sent_bytes, stage.back_bytes)
    )
    waiting, start = np.bincount(stage.after, minlength=count), np.searchsorted(np.sort(stage.before), range(count + 1))
    after = stage.after[np.argsort(stage.before, kind="stable")]
    ready, under_way, done = deque(np.flatnonzero(waiting == 0).tolist()), list[tuple[float, int]](), 0
    workers = [(0.0, number) for number in range(len(speeds))]
    link_s = now = 0.0
    while done < count:
        while ready and len(under_way) < AHEAD * len(speeds):
            task = ready.popleft()
            link_s = max(link_s, now) + sent_s[task]
            free_s, number = heapq.heappop(workers)
            varies = math.exp(draw.gauss(-0.5 * VARIES**2, VARIES))
            free_s = max(free_s, link_s + link.latency_s) + task_s + each_s[task] * varies / speeds[number]
            heapq.heappush(workers, (free_s, number))
            heapq.heappush(under_way, (free_s, task))
        ended_s, task = heapq.heappop(under_way)
        link_s = max(link_s, ended_s) + back_s[task]
        now, done = link_s + link.latency_s, done + 1
        for other in after[start[task] : start[task + 1]].tolist():
            waiting[other] -= 1
            if not waiting[other]:
                ready.append(other)
    return now
