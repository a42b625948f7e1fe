"""A reflectance in the form that a viewport draws at once: what has no shader of its own becomes a table, in a job."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QObject, Signal

from app.brdf_figures import drawable
from app.brdf_verbs import has_shader
from app.jobs import Jobs
from app.latest import Latest
from engine.brdf.table import HalfDifferenceTable


class Drawable(QObject):
    """Keeps the table that was made last; `ready` follows when the one that was asked for is there."""

    ready = Signal()

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.latest = Latest(jobs, "Preparing a reflectance")
        self.note = ""
        self._asked: Any = None
        self._made: tuple[Any, Any] = (None, None)

    def of(self, brdf: Any) -> Any:
        """`brdf` or its table; None while that is under way. `note` says in a few words what is shown."""
        self.note = ""
        if has_shader(brdf) or isinstance(brdf, HalfDifferenceTable):
            return brdf
        if self._made[0] is not brdf:
            self.note = "preparing…"
            if self._asked is not brdf:
                self._asked = brdf
                self.latest.ask(lambda: drawable(brdf), lambda table: self._keep(brdf, table))
            return None
        table = self._made[1]
        error = 100.0 * table.health.figures["resampling_rms_rel"]
        self.note = f"as a table: {error:.2g} % RMS off{'' if brdf.isotropic else ', mean over azimuths'}"
        return table

    def _keep(self, brdf: Any, table: HalfDifferenceTable) -> None:
        self._made = (brdf, table)
        self.ready.emit()
