"""Results of factor runs, kept beside the project under the hash of the BRDF and the settings that they are of."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import TYPE_CHECKING

from app.document.factoring import Run
from app.project.made import keep_newest, key_of, note, use
from engine.core.errors import FileError

if TYPE_CHECKING:
    from engine.factor.errors import Factorisation

log = logging.getLogger(__name__)

#: A search writes its best result at most this often, in seconds.
WRITE_EVERY_S = 5.0

#: Results that a data folder keeps: more than all steps of a history name at once.
KEPT = 200

_NAME = "factors-"


def place_of(run: Run, folder: Path) -> Path:
    """Place of the result of `run`. OSError where the file of its BRDF cannot be read."""
    return folder / f"{_NAME}{key_of(run.given, run.choices)}"


class Keeping:
    """Writes the best result of one run: now and then while it goes on, and at its end.

    Where that cannot be written the run goes on all the same, and a line of the log says so.
    """

    def __init__(self, run: Run, folder: Path) -> None:
        self._run, self._folder = run, folder
        self._written: Factorisation | None = None
        self._last_s = time.monotonic()

    def now_and_then(self, found: Factorisation) -> None:
        """Write `found`, unless something was written just before."""
        if time.monotonic() - self._last_s > WRITE_EVERY_S:
            self.keep(found)

    def keep(self, found: Factorisation | None) -> None:
        """Write `found`, if it is new and its errors are known."""
        if found is None or found is self._written or not found.term_errors:
            return
        from engine.factor.factor_file import is_whole, write_factors

        if not is_whole(found):
            return
        self._written, self._last_s = found, time.monotonic()
        try:
            place = place_of(self._run, self._folder)
            write_factors(place, found)
        except (FileError, OSError) as error:
            log.warning("The result of %s is not kept: %s", self._run.name, error)
            return
        note(place, "factors", found.term_errors[-1].time_s)
        keep_newest(self._folder, f"{_NAME}*", KEPT)


def read_kept(run: Run, folder: Path) -> Factorisation | None:
    """The result of `run`; None where it is gone. InputError where it is damaged, or opened factors are gone."""
    from engine.factor.factor_file import holds_factors, read_factors

    if run.choices is None:
        return read_factors(run.folder) if run.folder is not None else None
    try:
        place = place_of(run, folder)
    except OSError:
        return None
    if not holds_factors(place):
        return None
    use(place)
    return read_factors(place)
