"""Measures what a user meets for the first time in the window.

    python -m benchmarks.app.first_use [workspaces] [sample] [bakes]

One JSON object on standard output. `workspaces`: the longest block while those behind the one in front are made, and
while each is shown for the first time. `sample`: seconds from File > Sample capture to its project, to its material on
the model in View, and to its material in Material, with the longest block of that. `bakes`: for each baked mode the
seconds from the press of Bake on the sample to the first progress that the window shows, which is that of its
preparation (tables of the BRDF, an estimate), to the start of the bake itself, and to its first chunk.
Settings, projects and the cache of the user are used as they are: for a machine that was set up and never used,
point `HOME` and `NUMBA_CACHE_DIR` at what set-up left. `benchmarks.app.gaps` says what blocks are.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks.app.gaps import Drawing, Gaps

PATIENCE_S = 300.0

#: Seconds for which a workspace is watched from the moment that it is asked for.
VISIT_S = 1.5


def main() -> int:
    from app.window.application import start
    from app.window.main_window import MainWindow

    wanted = sys.argv[1:] or ["workspaces", "sample", "bakes"]
    application = start()
    found: dict[str, Any] = {"load": round(os.getloadavg()[0], 2)}

    def until(done: Callable[[], bool], min_s: float = 0.0) -> float:
        begun = time.perf_counter()
        while (passed_s := time.perf_counter() - begun) < PATIENCE_S and not (passed_s >= min_s and done()):
            application.processEvents()
            time.sleep(0.0005)
        return time.perf_counter() - begun

    with tempfile.TemporaryDirectory() as folder:
        window = MainWindow(Path(folder))
        Drawing.watch(window.view.viewport.surface)
        making = Gaps()
        window.show()
        until(lambda: window.isActiveWindow() or window.windowHandle().isExposed())
        window.expect_work()
        found.update(window_made_s=round(until(lambda: window.is_whole), 2), **_describe(making, "making"))
        if "workspaces" in wanted:
            found.update(_visits(window, until))
        if "sample" in wanted:
            found.update(_sample(window, until))
        if "bakes" in wanted:
            found.update(_bakes(window, until))
        window.close()
    print(json.dumps(found))
    return 0


def _describe(gaps: Gaps, name: str) -> dict[str, float]:
    gaps.stop()
    figures = gaps.figures(name)
    return {key: figures[key] for key in figures if not key.endswith("over_50_ms")}


def _visits(window: Any, until: Callable[..., float]) -> dict[str, float]:
    from app.window.top_bar import WORKSPACES

    found: dict[str, float] = {}
    for name in WORKSPACES:
        gaps = Gaps()
        window.show_workspace(name)
        until(lambda: True, VISIT_S)
        found.update(_describe(gaps, name))
    return found


def _sample(window: Any, until: Callable[..., float]) -> dict[str, float]:
    bench, drawn, gaps, begun = window.bench, list[float](), Gaps(), time.perf_counter()
    window.view.drawn.connect(lambda _seconds: drawn.append(time.perf_counter()) if _has_sample(window) else None)
    window.menus.sample_wanted.emit()
    until(lambda: bench.document.project.has_map)
    opened_s = time.perf_counter() - begun
    until(lambda: bool(drawn))
    relit_s = time.perf_counter() - begun
    until(lambda: not bench.jobs.active)
    found = _describe(gaps, "sample")
    gaps, begun = Gaps(), time.perf_counter()
    window.show_workspace("material")
    until(lambda: window.material.image.image is not None)
    shown_s = time.perf_counter() - begun
    seconds = {"sample_opened_s": opened_s, "sample_relit_s": relit_s, "sample_in_material_s": shown_s}
    found.update(_describe(gaps, "sample_in_material"))
    return {**{name: round(value, 2) for name, value in seconds.items()}, **found}


def _has_sample(window: Any) -> bool:
    return window.bench.document.project.has_map and window.view.viewport.scene is not None


def _bakes(window: Any, until: Callable[..., float]) -> dict[str, float]:
    bench, view, found = window.bench, window.view, {}
    if not bench.document.project.has_map:
        window.menus.sample_wanted.emit()
        until(lambda: bench.document.project.has_map)
    window.show_workspace("view")
    bench.load_environment("studio")
    until(lambda: view.viewport.scene is not None and view.viewport.scene.environment is not None)
    for method, baking in view.bakings.items():
        view.choose_mode(method)
        gaps, begun = Gaps(), time.perf_counter()
        baking.begin_or_stop()
        until(lambda baking=baking: baking.is_made or _says_something(bench, baking))
        said_s = time.perf_counter() - begun
        until(lambda baking=baking: baking.job is not None or baking.is_made)
        job_s = time.perf_counter() - begun
        until(lambda baking=baking: baking.is_made or (baking.job is not None and baking.job.step.done > 0.0))
        done_s = time.perf_counter() - begun
        baking.cancel()
        until(lambda baking=baking: baking.job is None)
        found.update(
            {
                f"{method}_first_progress_s": round(said_s, 2),
                f"{method}_begun_s": round(job_s, 2),
                f"{method}_first_chunk_s": round(done_s, 2),
                **_describe(gaps, method),
            }
        )
    return found


def _says_something(bench: Any, baking: Any) -> bool:
    """True once a job of this bake has told what it does: its preparation, or the bake itself."""
    titles = ("Estimating a bake", f"Baking {baking.method.noun}")
    return any(job.title in titles and job.step.note for job in bench.jobs.active)


if __name__ == "__main__":
    sys.exit(main())
