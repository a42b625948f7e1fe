"""Measures how soon a save begins and ends beside everything else that the window does.

    python -m benchmarks.app.saving [FOLDER OF PHOTOGRAPHS]

One JSON object on standard output. A factor search and, where a folder is given, an import run while the untitled
project is saved as a file, and once more while that file is copied to another. `begun_s`: from the wish to the first
step of the save; `file_s`: to the file; `block_ms`: the longest block of the thread of the window meanwhile.
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

from benchmarks.app.gaps import Gaps
from engine.factor.settings import FactorSettings

PATIENCE_S = 120.0


def main() -> int:
    from app.commands.brdf import add_model
    from app.window.application import start
    from app.window.main_window import MainWindow

    application = start()
    found: dict[str, Any] = {"load": round(os.getloadavg()[0], 2)}

    def until(done: Callable[[], bool]) -> float:
        begun = time.perf_counter()
        while (passed_s := time.perf_counter() - begun) < PATIENCE_S and not done():
            application.processEvents()
            time.sleep(0.0005)
        return passed_s

    with tempfile.TemporaryDirectory() as folder:
        window = MainWindow(Path(folder) / "config")
        window.show()
        window.expect_work()
        until(lambda: window.is_whole)
        bench, projects = window.bench, window.projects
        add_model(bench, "ggx:alpha=0.2")
        if sys.argv[1:]:
            window.open([Path(sys.argv[1])])
            until(lambda: bench.importing is not None and bench.importing.state == "running")
        window.show_workspace("factor")
        window.factor.settings.edited.emit(FactorSettings(method="homomorphic"), True)
        window.factor.start()
        until(lambda: any("Factoring" in job.title and job.step.note for job in bench.jobs.active))
        for name in ("untitled", "named"):
            found[name] = _save(bench, projects, Path(folder) / f"{name}.lap", until)
            for job in bench.jobs.active if name == "untitled" else ():
                bench.jobs.cancel(job)
            until(lambda: not projects.is_saving)
        window.close()
    print(json.dumps(found))
    return 0


def _save(bench: Any, projects: Any, target: Path, until: Callable[..., float]) -> dict[str, Any]:
    running = [job.title for job in bench.jobs.active if job.state == "running"]
    begun, gaps = time.perf_counter(), Gaps()
    projects.copy_to(target)
    job = next(job for job in bench.jobs.active if job.lane == "save")
    until(lambda: bool(job.step.note) or job.over)
    begun_s = time.perf_counter() - begun
    until(target.is_file)
    file_s = time.perf_counter() - begun
    gaps.stop()
    block_ms = round(max(gaps.gaps_ms), 1)
    return {"beside": running, "begun_s": round(begun_s, 3), "file_s": round(file_s, 3), "block_ms": block_ms}


if __name__ == "__main__":
    sys.exit(main())
