"""`lightarc plan --cluster`: what bakes take on the workers of a cluster, beside what they take here."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from app.arguments.options import refuse_plain_cluster
from app.arguments.quantities import MEGABYTES
from app.session import machine_profile
from engine.core.budget import thread_count
from engine.core.cluster import Link, measure_cluster
from engine.core.errors import UsageError
from engine.core.figure_text import number, size_text, time_text
from engine.core.steps import Step, drain
from engine.planning.costs.planned import planning_of
from engine.planning.costs.setting import Setting
from engine.planning.costs.spread import MODEL_BYTES, READY_S, price
from engine.tradeoff.predict import Predictions
from engine.transport import method as transport

if TYPE_CHECKING:
    from engine.planning.plan import EffectsPlan
    from engine.scene.scene import Scene

#: Most workers that a bake is priced for.
MAX_WORKERS = 1000

#: Seconds of bakes over their prices from those here, least and largest, rounded outwards: nine of three models on two
#: workers, without the time in which other programs had the cores (`benchmarks --only cluster-bakes`).
SHORTER, LONGER = 0.7, 1.4


def add_arguments(parser: argparse._ArgumentGroup) -> None:
    parser.add_argument(
        "--cluster",
        type=str,
        metavar="N|ADDRESS",
        help="price bakes on a cluster too: of so many workers, each a machine like this one, or of those of the Dask "
        "scheduler at an address, which are asked for their threads and sent some megabytes to measure the connection",
    )
    parser.add_argument(
        "--bandwidth-mb",
        type=MEGABYTES,
        metavar="MB",
        help="megabytes a second between this machine and N workers (100)",
    )
    parser.add_argument(
        "--plain-cluster",
        action="store_true",
        help="ask an address without TLS (tcp://) of another computer; anybody in that network can then run code on "
        "this one",
    )


def check(arguments: argparse.Namespace) -> None:
    """UsageError for what is neither a number of workers nor an address, and for options that need one of these."""
    workers = _workers(arguments)
    if workers is None:
        refuse_plain_cluster(arguments)
    elif not 1 <= workers <= MAX_WORKERS:
        raise UsageError(f"--cluster {workers}: bakes are priced for 1 to {MAX_WORKERS:,} workers")
    elif arguments.plain_cluster:
        raise UsageError("--plain-cluster needs the address of a cluster")
    if arguments.bandwidth_mb is not None:
        if workers is None:
            raise UsageError("--bandwidth-mb needs --cluster with a number of workers; that of an address is measured")
        if not 0.0 < arguments.bandwidth_mb < 1e6:
            raise UsageError(f"--bandwidth-mb {arguments.bandwidth_mb:g} is outside 0 … 1,000,000")


def _workers(arguments: argparse.Namespace) -> int | None:
    """The number of workers that was given in place of an address."""
    asked = arguments.cluster
    return int(asked) if asked is not None and asked.isdecimal() and len(asked) < 9 else None


def record(
    arguments: argparse.Namespace, scene: Scene, found: EffectsPlan, show: Callable[[Step], None]
) -> dict[str, Any]:
    """Prices of the bakes of all methods that can draw `scene`, the planned one by its setting, as JSON: `cluster`."""
    if arguments.cluster is None:
        return {}
    show(Step(0.95, "pricing bakes on a cluster"))
    workers = _workers(arguments)
    if workers is None:
        threads, link = measure_cluster(arguments.cluster)
        speeds = [[each / thread_count() for each in threads]]
    else:
        bandwidth_mb = arguments.bandwidth_mb
        link = Link() if bandwidth_mb is None else Link(bytes_per_s=1e6 * bandwidth_mb)
        speeds = [[1.0] * count for count in sorted({max(1, workers // 2), workers, 2 * workers})]
    model = drain(machine_profile.cost_model())
    predictions = Predictions(model, scene, (1, 1), 1, 1, tables_made=False)
    bakes = []
    for method in transport.METHODS:
        if not planning_of(method.name).can_draw(scene):
            continue
        setting = found.setting if found.mode == method.name else Setting(method.name)
        planning, load = planning_of(method.name), predictions.load
        raw, here = planning.cost(model, setting, load), model.predict(setting, load.vertices, 1, load=load)
        stages, seen = planning.stages(model, setting, load, scene.mesh), here.bake_s / raw.bake_s
        stages = tuple(each.scale(seen) for each in stages)
        rest_s = max(0.0, here.bake_s - sum(each.seconds for each in stages))
        prices = [price(stages, rest_s, MODEL_BYTES * load.vertices, each, link) for each in speeds]
        bakes.append({**setting.as_json(), "here_s": here.bake_s, "prices": [asdict(each) for each in prices]})
    return {
        "cluster": {
            "workers": len(speeds[-1]) if workers is None else workers,
            "speed": sum(speeds[-1]) if workers is None else float(workers),
            "link_bytes_per_s": link.bytes_per_s,
            "link_latency_s": link.latency_s,
            "link_measured": workers is None,
            "ready_s": READY_S,
            "measured_rel": [SHORTER, LONGER],
            "bakes": bakes,
        }
    }


def lines(result: dict[str, Any]) -> list[str]:
    """The prices in sentences."""
    found = result.get("cluster")
    if found is None:
        return []
    count, speed = found["workers"], f"{size_text(found['link_bytes_per_s'])} a second"
    if found["link_measured"]:
        times = f"{number(found['speed'], 2)} times as fast as this machine"
        begin = f"On the workers of the cluster ({count:,}), together {times}, over a link of {speed} as measured"
    else:
        like = "1 worker" if count == 1 else f"{count:,} workers"
        begin = f"On {like} like this machine, over a link of {speed} (--bandwidth-mb)"
    table = [f"{begin}, none of them lost:"]
    for bake in found["bakes"]:
        table.append(f"{Setting(bake['mode'], bake['knobs'])}: {time_text(bake['here_s'])} to bake on this machine")
        for each in bake["prices"]:
            workers = "1 worker" if each["workers"] == 1 else f"{each['workers']:,} workers"
            table.append(
                f"    {workers}: {time_text(each['bake_s'])}, of which {time_text(each['compute_s'])} compute, "
                f"{time_text(each['waiting_s'])} wait, {time_text(each['transfer_s'])} transfer "
                f"({size_text(each['bytes'])}), {time_text(each['rest_s'])} on this machine alone"
            )
    table.append(
        f"Measured bakes took {SHORTER:g} to {LONGER:g} times what their seconds on one machine let expect; workers "
        "that are busy with other work take longer."
    )
    return ["", *table]
