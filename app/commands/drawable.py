"""A BRDF in the form that a viewport draws at once: one without a shader of its own becomes a table, in a job."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from app.commands.brdf import has_shader
from app.commands.brdf_figures import drawable
from app.jobs.jobs import Jobs
from app.jobs.newest import Latest
from engine.brdf.table import HalfDifferenceTable
from engine.core.figure_text import percent

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf


class Drawable(QObject):
    """Keeps the newest table; `ready` follows when the requested one is made."""

    ready = Signal()

    def __init__(self, jobs: Jobs) -> None:
        super().__init__()
        self.latest = Latest(jobs, "Preparing a BRDF")
        self.note = self.shorter = ""
        self._asked: Any = None
        self._made: tuple[Any, Any] = (None, None)

    def of(self, brdf: Brdf) -> Any:
        """`brdf` or its table; None while that is under way. `note` tells the form shown, `shorter` in few words."""
        self.note = self.shorter = ""
        if has_shader(brdf) or isinstance(brdf, HalfDifferenceTable):
            return brdf
        if self._made[0] is not brdf:
            self.note = "preparing…"
            if self._asked is not brdf:
                self._asked = brdf
                self.latest.ask(lambda: drawable(brdf), lambda table: self._keep(brdf, table))
            return None
        table = self._made[1]
        error = percent(table.health.figures["resampling_rms_rel"])
        self.note = f"as a table: {error} RMS off{'' if brdf.isotropic else ', mean over azimuths'}"
        self.shorter = f"table: {error} off"
        return table

    def _keep(self, brdf: Brdf, table: HalfDifferenceTable) -> None:
        self._made = (brdf, table)
        self.ready.emit()
