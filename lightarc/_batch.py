"""Many captures in one run: what `lightarc batch` does, for scripts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from app.batch.report import describe
from app.batch.run import TIME_LIMIT_S, Settings, go_on
from app.project.project_file import read
from engine.core.cluster import check_cluster
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.targets import EXPORTERS
from lightarc._border import public
from lightarc._inputs import File, Progress


@public
def run_batch(
    sources: File | Sequence[File],
    folder: File,
    *,
    template: File | None = None,
    to: str | Sequence[str] | None = None,
    workers: int | None = None,
    time_limit_s: float = TIME_LIMIT_S,
    memory_limit_bytes: int | None = None,
    cluster: str | None = None,
    progress: Progress | None = None,
) -> list[dict[str, Any]]:
    """Make materials, projects, maps and exports of many captures in one run.

    The same call goes on where a run was stopped or killed: it makes captures that are missing or failed, and those
    whose files, choices or version have changed.

    Parameters
    ----------
    sources : path, pattern, or sequence of them
        Folders of captures with all below them, archives, patterns, or tables (.csv); none for those of the last run
        in `folder`.
    folder : path
        Folder of the results: one for each capture, the record of the batch, and the report (.html, .csv, .json).
    template : path, optional
        A project (.lap) whose choices hold for all captures; None for those of the last run, or of a new project.
    to : str or sequence of str, optional
        Targets of an export of each material, an empty sequence for none; None for those of the template.
    workers : int, optional
        Captures that are made at a time, each by a process on one thread; None for one on each core.
    time_limit_s : float
        A capture that takes longer has failed.
    memory_limit_bytes : int, optional
        A capture that takes more has failed; None for an even share of what is free.
    cluster : str, optional
        Address of the scheduler of a Dask cluster whose workers make the captures (`tls://…`).
    progress : callable, optional
        Called with a step.

    Returns
    -------
    list of dict
        The captures as `report.json` has them: name, path, state ('done' or 'failed'), reason, figures, files.

    Raises
    ------
    UsageError
        Without a capture, and for targets and limits that cannot be.
    InputError
        Where sources, template or record cannot be read, and where no cluster answers.
    OutputError
        Where the folder cannot be written. What fails in one capture is the reason of that capture instead.

    Examples
    --------
    >>> from pathlib import Path
    >>> Path("museum").mkdir()
    >>> angles = [15, 30, 45, 60, 75]
    >>> for name in ("woven", "leather"):
    ...     made = lightarc.simulate_capture(f"museum/{name}", sample=name, size=48, elevations_deg=angles)
    >>> done = lightarc.run_batch("museum", "results", to=(), workers=1)
    >>> [(each["name"], each["state"]) for each in done]
    [('leather', 'done'), ('woven', 'done')]
    """
    places = [sources] if isinstance(sources, str | os.PathLike) else list(sources)
    if workers is not None and workers < 1:
        raise UsageError(f"workers {workers} is not a number of processes")
    targets = None if to is None else (to,) if isinstance(to, str) else tuple(dict.fromkeys(to))
    unknown = [name for name in targets or () if name not in EXPORTERS]
    if unknown:
        raise UsageError(f"unknown target {unknown[0]}; choose from {', '.join(EXPORTERS)}")
    chosen = None if template is None else read(Path(template)).current
    address = "" if cluster is None else check_cluster(cluster)
    choices = Settings(chosen, targets, workers, time_limit_s, memory_limit_bytes, address)
    rows = drain(go_on(Path(folder), [os.fspath(place) for place in places], choices), progress)
    return [describe(row) for row in rows]
