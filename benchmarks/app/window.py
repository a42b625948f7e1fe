"""Measures the window: the time until it can be used, and the longest delays of its thread.

    python -m benchmarks.app.window [FOLDER]

A timer that should fire every 5 ms runs while the capture in FOLDER (the built-in sample without it) is imported,
shaded and fitted; the longest delay of a tick while a job runs is the longest block. Then the material is looked
at under the built-in studio with 64 directions, rotated for 3 s, and left alone until its image is the finest. One
JSON object on standard output: `window_start_s`, `workspaces_s` and `workspaces_block_ms` (until those that are not in
front are there as well, and the longest block of that), `longest_block_ms`, `blocks_over_50_ms`, `jobs_s`, `complete`,
and for the view `turning_block_ms`, `turning_frame_ms` (median from image to image), `refining_block_ms`,
`refining_blocks_over_50_ms` and `refined_s`. Last, the reference refines beside the shading map while both are
compared, for 5 s, and the model is rotated in between: `reference_block_ms`, `reference_blocks_over_50_ms` and
`reference_samples`. Before that, each baked mode of a small ball is baked and its light rotated for 3 s:
`relight_sh_block_ms` and so on, and how many blocks were over 50 ms. Last, nothing is done for 5 s but what the window
does by itself to find the error of its image: `measuring_block_ms`.

Beside each `block_ms` stands an `own_block_ms`: the same without the time in which OpenGL drew the image or Qt
composed the window with it, which on a machine without a graphics card is work of the CPU.
"""

from __future__ import annotations

import time

STARTED_S = time.perf_counter()

import json  # noqa: E402 - the clock starts before anything is imported
import sys  # noqa: E402
import tempfile  # noqa: E402
from collections.abc import Callable  # noqa: E402
from itertools import pairwise  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Any  # noqa: E402

from benchmarks.app.gaps import LIMIT_MS, Drawing, Gaps  # noqa: E402

PATIENCE_S = 300.0
TURNING_S = 3.0
REFERENCE_S = 5.0
MEASURING_S = 5.0

#: Name of the model that is baked.
RELIT = "ball"


def main() -> int:
    from PySide6.QtCore import QTimer

    from app.window.application import start
    from app.window.main_window import MainWindow

    application = start()
    with tempfile.TemporaryDirectory() as folder:
        window = MainWindow(Path(folder))
        Drawing.watch(window.view.viewport.surface)
        window.show()
        handle = window.windowHandle()
        while handle is None or not handle.isExposed():
            application.processEvents()
        application.processEvents()
        start_s = time.perf_counter() - STARTED_S
        making = Gaps(lambda: True)
        window.expect_work()
        while not window.is_whole:
            application.processEvents()
        making.stop()
        behind_s = time.perf_counter() - STARTED_S
        bench = window.bench
        gaps = Gaps(lambda: any(job.is_asked_for for job in bench.jobs.active))
        begun = time.perf_counter()
        if len(sys.argv) > 1:
            window.open([Path(sys.argv[1])])
        else:
            bench.rebuild_sample()
        bench.jobs.failed.connect(lambda job, error: _give_up(f"{job.title}: {error}"))
        watch = QTimer()
        watch.timeout.connect(
            lambda: application.exit() if bench.document.project.has_map and not bench.jobs.active else None
        )
        watch.start(100)
        patience = QTimer()
        patience.setSingleShot(True)
        patience.timeout.connect(application.exit)
        patience.start(round(1000 * PATIENCE_S))
        application.exec()  # left by exit, because quit closes the window
        watch.stop()
        patience.stop()
        jobs_s = time.perf_counter() - begun
        complete = bench.document.project.has_map
        view = _look(window) if complete else {}
        window.close()
    print(
        json.dumps(
            {
                "window_start_s": round(start_s, 3),
                "workspaces_s": round(behind_s, 3),
                "workspaces_block_ms": round(max(making.gaps_ms), 1),
                "longest_block_ms": round(max(gaps.gaps_ms), 1),
                "longest_own_block_ms": round(max(gaps.own_ms), 1),
                "blocks_over_50_ms": sum(gap > LIMIT_MS for gap in gaps.gaps_ms),
                "jobs_s": round(jobs_s, 2),
                "complete": complete,
                **view,
            }
        )
    )
    return 0 if complete else 1


def _look(window: Any) -> dict[str, float]:
    """Rotate the material under 64 lights, then let its image refine."""
    from PySide6.QtCore import QEventLoop, QTimer

    view, loop = window.view, QEventLoop()
    viewport = view.viewport

    def until(done: Callable[[], bool], min_s: float = 0.0) -> float:
        begun = time.perf_counter()

        def look() -> None:
            passed_s = time.perf_counter() - begun
            if passed_s > PATIENCE_S or (passed_s >= min_s and done()):
                loop.quit()

        watch = QTimer()
        watch.timeout.connect(look)
        watch.start(20)
        loop.exec()
        watch.stop()
        return time.perf_counter() - begun

    window.show_workspace("view")
    window.bench.load_environment("studio")
    until(lambda: viewport.scene is not None and viewport.scene.environment is not None)
    view.at_rest.blockSignals(True)  # the error of the directions is another job, measured apart
    until(lambda: viewport.surface.is_finished)
    turning, images = Gaps(lambda: True), [time.perf_counter()]
    viewport.drawn.connect(lambda _seconds: images.append(time.perf_counter()))
    hand = QTimer()
    hand.timeout.connect(lambda: viewport.turn(0.02, 0.0))
    hand.start(16)
    until(lambda: True, TURNING_S)
    hand.stop()
    between = sorted(after - before for before, after in pairwise(images[1:]))
    turning.stop()
    refining = Gaps(lambda: True)
    refined_s = until(lambda: viewport.surface.is_finished)
    refining.stop()
    relit = {key: value for method in view.bakings for key, value in _relight(window, method, until).items()}
    view.choose_mode("shading-map")
    measuring = _measure(view, until)
    reference = _refer(view, until)
    return {
        **turning.figures("turning"),
        "turning_frame_ms": round(1000 * between[len(between) // 2], 1),
        **refining.figures("refining"),
        "refined_s": round(refined_s, 2),
        **relit,
        **measuring,
        **reference,
    }


def _measure(view: Any, until: Callable[..., float]) -> dict[str, float]:
    """Find the error of the image in the background, with kernels that are prepared."""
    until(lambda: view.images.error is not None)
    view.viewport.turn(0.02, 0.0)
    until(lambda: view.viewport.surface.is_finished)
    gaps = Gaps(lambda: True)
    until(lambda: True, MEASURING_S)
    gaps.stop()
    return gaps.figures("measuring")


def _relight(window: Any, method: str, until: Callable[..., float]) -> dict[str, float]:
    """Bake a mode, and rotate the light with every tick."""
    import dataclasses

    from PySide6.QtCore import QTimer

    view, document = window.view, window.bench.document
    if document.project.mesh is None or document.project.mesh.name != RELIT:
        material = dataclasses.replace(document.project.material, brdf="ggx:kd=0.5,alpha=0.3,f0=0.04")
        document.change("Model", mesh=_sphere(), material=material)
    view.choose_mode(method)
    baking = view.bakings[method]
    until(lambda: baking.estimate is not None)
    baking.bake()
    until(lambda: baking.made is not None and view.viewport.scene is not None and view.viewport.scene.relit is not None)
    until(lambda: view.viewport.surface.is_finished)
    gaps, angle = Gaps(lambda: True), [0.0]

    def turn() -> None:
        angle[0] = (angle[0] + 2.0) % 180.0
        view.viewport.environment_rotated.emit(angle[0], False)

    hand = QTimer()
    hand.timeout.connect(turn)
    hand.start(16)
    until(lambda: True, TURNING_S)
    hand.stop()
    gaps.stop()
    return gaps.figures(f"relight_{method}")


def _sphere() -> Any:
    """A sphere of 642 vertices."""
    import numpy as np
    import trimesh

    from engine.geometry.mesh import Mesh

    made = trimesh.creation.icosphere(subdivisions=3)
    positions = np.asarray(made.vertices, np.float64)
    normals, uv = positions.astype(np.float32), np.zeros((len(positions), 2), np.float32)
    return Mesh(positions, normals, uv, np.asarray(made.faces, np.int32), RELIT)


def _refer(view: Any, until: Callable[..., float]) -> dict[str, float]:
    """Let the reference refine beside the shading map, rotate the model, and let it restart."""
    view.compare.toggle("wipe")
    found = view.images.reference
    until(lambda: found.found is not None and found.found.samples > 0)  # kernels are prepared once
    gaps = Gaps(lambda: True)
    for _ in range(2):
        view.viewport.turn(0.02, 0.0)
        until(lambda: True, REFERENCE_S)
    samples = found.found.samples if found.found is not None else 0
    gaps.stop()
    return {**gaps.figures("reference"), "reference_samples": samples}


def _give_up(words: str) -> None:
    from PySide6.QtWidgets import QApplication

    print(words, file=sys.stderr)
    QApplication.exit(1)


if __name__ == "__main__":
    sys.exit(main())
