"""The project of a window: made at once, recorded all the time, opened, copied and closed without a question.

Files are read on the thread of a job; the thread of the window only takes over what was read.
"""

from __future__ import annotations

import logging
import tempfile
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import QObject, Qt, QTimer, Signal

from app.commands.making import prepare_to_draw
from app.commands.rebuilding import lacks_material, lacks_surface
from app.commands.workbench import Workbench
from app.document.document import Project
from app.jobs.jobs import Job
from app.project import places
from app.project.bakes import is_begun
from app.project.copying import collect, copy, in_memory
from app.project.interrupted import running
from app.project.made import cost_text, list_notes
from app.project.project_file import History, Opened, Writer, data_folder, read
from app.project.recording import CLOSING_S, Recording, is_worth_keeping
from app.project.recovery import recover
from app.session.settings import close_session, open_session
from engine.core.errors import FileError, InputError
from engine.core.steps import Step, Steps
from engine.light.light_tree import choose_lights

log = logging.getLogger(__name__)

#: Seconds between two looks at what is being written.
WAIT_S = 0.05

#: Title of the job that reads a project.
OPENING = "Opening the project"


#: Milliseconds until a project that was read looks again whether the one before it is saved.
AFTER_SAVING_MS = 20


@dataclass(frozen=True, eq=False)
class Read:
    """A project that was read and claimed for this window.

    Attributes
    ----------
    found : its content.
    why_read_only : the reason why it could not be claimed; empty where it was.
    was_interrupted : the process that had it open before ended without closing it.
    lost : what is gone from its data folder, and the time that making it again takes; empty for nothing.
    """

    found: Opened
    why_read_only: str
    was_interrupted: bool
    lost: str


def nothing() -> None:
    """Nothing follows."""


class Projects(QObject):
    """Opens and records the projects of one window.

    Signals
    -------
    leaving : the document is about to be that of another project: what still moves in it comes to rest now.
    changed : another project is open, or its state of saving has changed.
    opened : the path of a project that was opened or given a place.
    switched : the document is that of another project now, or was read again.
    moved : the path that the project had, and the one that it has.
    confirmed : what was saved just now, and when, in words.
    refused : the error that keeps a project from being opened; all stays as it was.
    broken : the error that keeps the window from going on in a project that it has saved.
    """

    leaving = Signal()
    changed = Signal()
    opened = Signal(object)
    switched = Signal()
    moved = Signal(object, object)
    confirmed = Signal(str)
    broken = Signal(object)
    refused = Signal(object)

    def __init__(self, bench: Workbench, folder: Path) -> None:
        """`problem` is why the document is not on disk, without the path, and `details` all that is known of it.
        `lost` says what is gone from the data folder, and the time that making it again takes.

        Projects without a place of their own lie in `folder`."""
        super().__init__(bench)
        self.bench, self.folder = bench, folder
        self.path, self.first = Path(), Project()
        self.problem = self.details = ""
        self.is_read_only = False
        self.why_read_only = ""
        self.is_recovered = False
        self.lost = ""
        self._recording: Recording | None = None
        bench.jobs.around = self._around
        self._as_opened = bench.document.project
        self._is_elsewhere = False
        self._waits = True
        self._is_example = False
        self._target: Path | None = None
        self._opening: Job | None = None
        self._begun = Path()
        self._is_hurried = self._confirms = False
        bench.jobs.changed.connect(self._job_changed)

    @property
    def name(self) -> str:
        """The name of the file, without its ending."""
        return self.path.stem

    @property
    def shown_name(self) -> str:
        """The name of the file; that of the material where nobody has given the file one."""
        return self.bench.document.project.name if self.name.startswith(places.UNTITLED) else self.name

    @property
    def is_unchanged_example(self) -> bool:
        """True for an example in which nothing was done yet."""
        return self._is_example and not self.bench.document.undo_stack.count()

    @property
    def is_saved(self) -> bool:
        """True if every change is on disk."""
        return self._recording is not None and self._recording.is_idle and not self.problem

    @property
    def is_untitled(self) -> bool:
        """True if nobody has given the project a place."""
        folders = (places.projects_folder(), self.folder, self._begun.parent)
        return self.path.name.startswith(places.UNTITLED) and self.path.parent in folders

    @property
    def is_saving(self) -> bool:
        """True while a file is being saved, or the window is about to go on in a project that it has saved."""
        return self._target is not None or bool(self._saves())

    @property
    def is_opening(self) -> bool:
        """True while a project is being read that will take the place of this one."""
        return self._opening is not None

    @property
    def saved_as(self) -> str:
        """The name of the file in which the window will go on; empty for none."""
        return self._target.name if self._target is not None else ""

    @property
    def waits_for(self) -> str:
        """Title of the job that keeps the window from going on in a project that it has saved; empty for none."""
        is_saved = self._target is not None and not self._saves()
        busy = self._busy()
        return busy[0].title if is_saved and busy else ""

    def begin(self) -> None:
        """A new project, with nothing in it."""
        self.finish()
        path = places.new_path(self.folder)
        try:
            places.claim(path)
        except FileError as error:
            log.warning("%s. Until then the project lies in the folder for temporary files", error)
            path = places.new_path(Path(tempfile.mkdtemp(prefix="lightarc-")))
            places.claim(path)
        self._begun = path
        self._show(path, None, read_only=False)

    def open(self, path: Path, *, as_example: bool = False, then: Callable[[], object] = nothing) -> None:
        """Read a project and open it where its file lies, then call `then`; of two wishes the last counts.

        `refused` says why it cannot be opened. `as_example`: it was just made from an example, and goes when it is
        closed as it was opened.
        """
        path = path.absolute()
        self._stop_opening()
        if path == self.path or (path == self._target and self._is_being_written(path)):
            then()  # in the second case the window goes on there by itself
            return
        recording = self._recording
        if recording is not None:
            recording.hand_over()
        job = self.bench.jobs.submit(OPENING, lambda: _open(path, recording), lane="open", resource=_opening_of(path))
        self._opening = job
        job.succeeded.connect(lambda outcome: self._take(job, path, outcome, as_example, then))
        job.failed.connect(lambda _error: self._let_go_of(path))
        job.cancelled.connect(lambda: self._let_go_of(path))

    def _stop_opening(self) -> None:
        job, self._opening = self._opening, None
        if job is not None:
            self.bench.jobs.drop(job)

    def _let_go_of(self, path: Path) -> None:
        """A project that was read is not opened after all."""
        if self._opening is not None and self._opening.over:
            self._opening = None
        if path != self.path:
            places.release(path)

    def _take(
        self, job: Job, path: Path, outcome: Read | FileError, as_example: bool, then: Callable[[], object]
    ) -> None:
        if isinstance(outcome, FileError):
            self._opening = None
            self.refused.emit(outcome)
            return
        if self._opening is not job or not self.bench.jobs.accepting:  # another wish has followed, or the window closes
            self._let_go_of(path)
            return
        if self.is_saving:  # that began while the project was read, and reads the one that this would leave
            self.hurry()
            QTimer.singleShot(AFTER_SAVING_MS, self, lambda: self._take(job, path, outcome, as_example, then))
            return
        self._opening = None
        self.finish()
        self._show_read(path, outcome)
        self._is_example = as_example
        self.changed.emit()
        if not as_example:
            self.opened.emit(path)
        if self.lost:
            self.bench.said.emit(f"{path.name} is open. {self.lost}")
        QTimer.singleShot(0, self, then)  # the window answers between the new document and another workspace

    def read_again(self, then: Callable[[], object] = nothing) -> None:
        """Take the document and its history from the file, in which paths were changed, then call `then`."""
        recording, path, before = self._recording, self.path, self._history()
        if recording is not None:
            recording.hand_over()
        job = self.bench.jobs.submit(OPENING, lambda: _read_when_written(recording, path), lane="open")
        job.succeeded.connect(lambda found: self._restore(path, before, found, then))

    def _restore(self, path: Path, before: History, found: Opened, then: Callable[[], object]) -> None:
        if path != self.path:
            return
        if self._is_other(before):
            self.read_again(then)
            return
        self.bench.document.restore(found.current, found.steps, found.position, found.state)
        self.switched.emit()
        then()

    def _around(self, job: Job) -> AbstractContextManager[object]:
        """Note a job beside the project, which says so if the program is killed; reading a project leaves nothing."""
        return nullcontext() if job.title == OPENING else running(self.bench.own, job.title, job.again)

    def confirm(self) -> None:
        """Write what is not on disk yet, and say when that is done."""
        if self._target is not None:
            self._save()
        if self.problem:
            self.confirmed.emit(f"Not saved: {self.problem}")
        elif self._recording is not None:
            self._confirms = True
            self._recording.hand_over()

    def copy_to(self, path: Path) -> None:
        """Go on in a copy of the project at `path`, in place of what lies there; the old one stays as it is.

        An untitled one moves. The copy holds what could not be written to the old one, and what is done while it is
        made. It is there as soon as it is written; the window goes on in it when no job works for the old one any more.
        """
        if path.absolute() == self.path:
            self.confirm()
            return
        if self._target == path.absolute() and self._is_being_written(self._target):
            return  # what was done since is in the copy before the window goes on in it
        if self._opening is not None and self._opening.resource == _opening_of(path.absolute()):
            self._stop_opening()  # the states of its history are read when they are needed, from what is replaced now
        self._target, self._is_hurried = path.absolute(), False
        self._save()

    def _is_being_written(self, target: Path) -> bool:
        return any(job.resource == str(target) and not job.stopping for job in self._saves())

    def _saves(self) -> list[Job]:
        return [job for job in self.bench.jobs.active if job.lane == "save"]

    def _save(self) -> None:
        assert self._target is not None
        self.leaving.emit()
        source, target, own, now, moves = self.path, self._target, self.bench.own, self._history(), self.is_untitled
        is_unreadable = not self._is_kept()
        job = self.bench.jobs.submit(
            f"Saving as {target.name}",
            lambda: copy(source, target, now=now, own=own, is_unreadable=is_unreadable, with_links=moves),
            lane="save",
            resource=str(target),
        )
        job.succeeded.connect(lambda _: self._on_saved(source, target, now))
        job.failed.connect(lambda _error: self._forget_target(target))
        job.cancelled.connect(lambda: self._forget_target(target))
        self.changed.emit()

    def _on_saved(self, source: Path, target: Path, now: History) -> None:
        """Go on in the copy; once more with what was done while it was made."""
        if self.path != source or self._target != target:
            return
        if self._is_other(now):
            self._save()
        elif self._saves() or (self._busy() and not self._is_hurried):
            self.changed.emit()  # other saves read the project that this window would leave, and move
        else:
            self._go_on_in(target, now)

    def _is_other(self, history: History) -> bool:
        document = self.bench.document
        return document.project is not history.current or document.undo_stack.index() != history.position

    def _busy(self) -> list[Job]:
        """Jobs that work for this project, and whose results would come too late."""
        return [job for job in self.bench.jobs.active if job.lane in ("open", "compute")]

    def _job_changed(self, job: Job) -> None:
        """Go on in the saved copy when the last job has ended and nothing has followed it."""
        if job.over and self._target is not None:
            QTimer.singleShot(0, self, self._go_on)

    def _go_on(self) -> None:
        if self._target is not None and not self._saves():
            if self._is_hurried or not self._busy():
                self._save()
            else:
                self.changed.emit()

    def hurry(self, is_hurried: bool = True) -> None:
        """Go on in the saved copy without waiting for jobs, because the window is about to leave the project."""
        self._is_hurried = is_hurried
        self._go_on()

    def give_up_saving(self) -> None:
        """Cancel what is being saved; every target is as it was before, or whole."""
        self._target = None
        for job in self._saves():
            self.bench.jobs.cancel(job)
        self.changed.emit()

    def _forget_target(self, target: Path) -> None:
        if self._target == target:
            self._target = None
            self.changed.emit()

    def _go_on_in(self, target: Path, now: History) -> None:
        """Read the copy at `target`, which holds `now`, and go on in it."""
        source = self.path
        job = self.bench.jobs.submit(
            f"Saving as {target.name}", lambda: _open(target), lane="save", resource=str(target)
        )
        job.succeeded.connect(lambda outcome: self._gone_on(source, target, now, outcome))
        for ended in (job.failed, job.cancelled):
            ended.connect(lambda *_: self._let_go_of(target))
        job.failed.connect(lambda _error: self._forget_target(target))
        job.cancelled.connect(lambda: self._forget_target(target))

    def _gone_on(self, source: Path, target: Path, now: History, outcome: Read | FileError) -> None:
        if self.path != source or self._target != target:
            self._let_go_of(target)
            return
        if isinstance(outcome, FileError):
            self._forget_target(target)
            self.broken.emit(outcome)
            return
        if self._is_other(now) or (self._busy() and not self._is_hurried):
            self._let_go_of(target)
            self._on_saved(source, target, now)
            return
        moves = self.is_untitled
        self._target, self._is_elsewhere = None, True
        opening = self._opening if self._opening is not None and self._opening.over else None
        self._opening = None  # one that was read has waited for this, and follows
        self.finish()
        self._show_read(target, outcome)
        self._opening = opening
        self.changed.emit()
        self.opened.emit(target)
        if moves:
            places.remove(source)
            self.moved.emit(source, target)
        self.confirmed.emit(f"Saved as {target.name} {time.strftime('%H:%M')}")

    def _is_kept(self) -> bool:
        """True if the project file holds the document, or will in a moment."""
        return not self.problem and not (self.is_read_only and self._is_changed())

    def _is_changed(self) -> bool:
        return self.bench.document.project is not self._as_opened

    def _history(self) -> History:
        document = self.bench.document
        return History(document.project, document.steps, document.undo_stack.index())

    def collect_to(self, path: Path, *, with_derived: bool = True) -> None:
        """Write a project that needs nothing outside itself: photographs inside, derived data where wanted."""
        if not self._is_kept():
            raise InputError(self.path, "does not hold the latest changes", "Save the project elsewhere first")
        source, target, recording = self.path, path.absolute(), self._recording
        if recording is not None:
            recording.hand_over()
        job = self.bench.jobs.submit(
            f"Collecting {path.name}",
            lambda: _collect(recording, source, target, with_derived),
            lane="save",
            resource=str(target),
        )
        job.succeeded.connect(lambda _: self.bench.said.emit(f"{path.name} holds the project and all that it needs"))

    def recover_to(self, damaged: Path, target: Path) -> None:
        """Save what is sound in a damaged project at `target`, and open that."""
        title = f"Recovering {damaged.name}"
        job = self.bench.jobs.submit(title, lambda: recover(damaged, target.absolute()), lane="save")
        job.succeeded.connect(lambda lost: self._on_recovered(target.absolute(), lost))

    def _on_recovered(self, path: Path, lost: list[str]) -> None:
        words = "; ".join(lost[:3]) + (f"; and {len(lost) - 3} more" if len(lost) > 3 else "")
        said = f"{path.name} holds what was sound. Lost: {words}" if lost else f"{path.name} is whole"
        self.open(path, then=lambda: self.bench.said.emit(said))

    def write(self) -> None:
        """Wait until all changes are on disk, as long as that goes on, because the window closes.

        From then on its end is an ordinary one, also where jobs do not stop in time. Nothing changes the document any
        more: results of jobs that still run are dropped.
        """
        self.leaving.emit()
        self._drop_jobs()
        if self._recording is not None:
            self._waits = self._recording.wait(CLOSING_S)
            if self._waits:
                places.release(self.path)

    def finish(self) -> None:
        """Write what is missing and let go of the project; one that nobody put anything into is removed."""
        self.leaving.emit()
        self._stop_opening()
        self._drop_jobs()
        seconds = CLOSING_S if self._waits else 0.0  # what just took nothing would keep the end of the window waiting
        written = self._recording.close(seconds) if self._recording is not None else not self._is_changed()
        if not written and not self._is_elsewhere:
            self._rescue()
        if self._recording is not None:
            self._recording = None
            places.release(self.path)
            is_own = places.is_untitled(self.path) or self.is_unchanged_example
            if is_own and written and not self.is_worth_keeping():
                places.remove(self.path)
        if self.bench.own != self.bench.folder and written:
            close_session(self.bench.own)

    def _drop_jobs(self) -> None:
        """Stop all jobs but saves, whose results belong to the project that is left."""
        for job in self.bench.jobs.active:
            if job.lane != "save":
                self.bench.jobs.drop(job)

    def is_worth_keeping(self) -> bool:
        """True if the user has brought or made something, a bake too, or begun one; an unchanged example is not."""
        is_made = bool(list_notes(self.path)) or is_begun(data_folder(self.path))
        is_worth = is_worth_keeping(self.bench.document.project) or is_made
        return is_worth and not self.is_unchanged_example

    def _rescue(self) -> None:
        """Write the document elsewhere, because its own place takes nothing; the next start opens it."""
        path = places.new_path(places.projects_folder())
        try:
            places.claim(path)
            writer = Writer(path)
            writer.write(in_memory(self._history()))
            writer.close()
        except (FileError, OSError) as error:
            log.error("%s could not be written, nor could %s: %s", self.path, path, error)
            return
        log.warning("%s could not be written; everything is in %s", self.path, path)

    def _show_read(self, path: Path, read: Read) -> None:
        is_read_only = bool(read.why_read_only)
        self._show(path, read.found, is_read_only, is_recovered=read.was_interrupted, lost=read.lost)
        self.why_read_only = read.why_read_only

    def _show(
        self, path: Path, found: Opened | None, read_only: bool, is_recovered: bool = False, lost: str = ""
    ) -> None:
        self.is_recovered, self.lost, self._waits = is_recovered, lost, True
        self._is_example = False
        self._target, self._is_hurried, self._confirms = None, False, False
        self.path, self.is_read_only, self.problem, self._is_elsewhere = path, read_only, "", False
        self.bench.folder = data_folder(path)
        self.bench.own = open_session() if read_only else self.bench.folder
        document = self.bench.document
        if found is None:
            document.clear(self.first)
        else:
            document.restore(found.current, found.steps, found.position, found.state)
        self._as_opened = document.project
        if not read_only:
            self._recording = Recording(document, path, self)
            self._recording.failed.connect(self._on_failed, Qt.ConnectionType.QueuedConnection)
            self._recording.written.connect(self._written, Qt.ConnectionType.QueuedConnection)
            self._recording.restored.connect(self._on_restored, Qt.ConnectionType.QueuedConnection)
        self.changed.emit()
        self.switched.emit()

    def _on_restored(self) -> None:
        self.bench.said.emit(f"{self.path.name} had been removed, and was written again")

    def _on_failed(self, cause: str, details: str) -> None:
        self.problem, self.details = cause, details
        self.changed.emit()

    def _written(self) -> None:
        self.problem = ""
        if self._confirms and self.is_saved:
            self._confirms = False
            self.confirmed.emit(f"Saved {time.strftime('%H:%M')}")
        self.changed.emit()


def _opening_of(path: Path) -> str:
    """The resource of the job that opens the project `path`."""
    return f"opening {path}"


def _open(path: Path, recording: Recording | None = None) -> Steps[Read | FileError]:
    """Read a project and claim it for this window, or say why not; `recording` has written what it was given then."""
    yield Step(0.0, "reading")
    try:
        found = read(path)
        prepare_to_draw(found.current.material)
        if found.current.environment is not None:
            choose_lights(found.current.environment, found.current.look.directions)  # or the window's thread would
        was_interrupted = places.was_interrupted(path)
        lost = cost_text(each for each in list_notes(path) if not each.present)
        why_not = _why_not_claimed(path)
    except FileError as error:
        return error
    if found.missing and not (lacks_material(found.current) or lacks_surface(found.current)):
        lost = lost or "What was made from the sources is gone, and can be made again"
    while recording is not None and not recording.has_written(WAIT_S) and not recording.is_failing:
        yield Step(0.9, "writing the project that was open")
    return Read(found, why_not, was_interrupted, lost)


def _read_when_written(recording: Recording | None, path: Path) -> Steps[Opened]:
    """Read a project once all that was handed over is in its file. InputError where that cannot be written."""
    while recording is not None and not recording.has_written(WAIT_S):
        yield Step(0.0, "writing the latest changes")
        if recording.is_failing:
            raise InputError(path, "cannot be written now", "Check the disk that it lies on")
    return read(path)


def _collect(recording: Recording | None, source: Path, target: Path, with_derived: bool) -> Steps[Path]:
    """Collect a project once all that was handed over is in its file. InputError where that cannot be written."""
    while recording is not None and not recording.has_written(WAIT_S):
        yield Step(0.0, "writing the latest changes")
        if recording.is_failing:
            raise InputError(source, "does not hold the latest changes", "Save the project elsewhere first")
    return (yield from collect(source, target, with_derived, include_outside=True))  # the dialog has named them


def _why_not_claimed(path: Path) -> str:
    """Take a project for this window; the reason where that cannot be, empty where it is done."""
    try:
        return "" if places.claim(path) else "is open in another window"
    except FileError:
        return "cannot be written"
