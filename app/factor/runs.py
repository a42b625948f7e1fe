"""The live runs of the Factor workspace: their jobs, and the results of each so far.

The document says which runs there are; this follows it. A run that is no longer there is cancelled and keeps the best
that it had, so that undoing its removal brings it back. Pausing keeps everything, also the place in the search. Results
of runs that were made before this start are read from beside the project (`app.project.factors`).
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from app.commands.workbench import Workbench
from app.document.comparison import MARKERS
from app.document.document import Project
from app.document.factoring import MATERIAL, METHODS, RUN_NUMBERS, Run, names_of
from app.jobs.jobs import Job
from app.project.factors import Keeping, read_kept
from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, label_of
from engine.brdf.readers.read import read_brdf_steps
from engine.core.errors import FileError, InputError, UsageError
from engine.core.steps import Step, Steps, part
from engine.factor.settings import FactorSettings
from engine.storage.text import whole_number

if TYPE_CHECKING:
    from engine.factor.errors import Factorisation, Factors, TermError

SAME = "This has been factored with these settings already: the list has it"
QUEUED = "{} waits for {}"
FULL = f"{len(MARKERS)} runs are listed at most; remove one first"
GONE = "The BRDF is no longer in the list of the BRDF workspace"
READING = "reading"
LOST = "Its result is missing from the data folder: factor again"


@dataclass(frozen=True, eq=False)
class Found:
    """The BRDF that is factored, and the factorisation so far, if there is one; why one of them is missing."""

    brdf: Brdf | None
    factorisation: Factorisation | None
    why: str = ""


@dataclass(eq=False)
class Live:
    """The state of a run: its job, if any, its last result, every error on the way, and the reason of a failure."""

    job: Job | None = None
    brdf: Brdf | None = None
    factorisation: Factorisation | None = None
    history: list[TermError] = field(default_factory=list)
    state: str = ""
    why: str = ""

    @property
    def may_go_on(self) -> bool:
        """True where nothing was found, or a search ended before its end."""
        if self.job is not None or self.state == READING:
            return False
        return self.factorisation is None or self.factorisation.searching

    @property
    def is_sum(self) -> bool:
        """True unless what was found is a product of projections."""
        return self.factorisation is None or hasattr(self.factorisation.factors, "hemisphere_map")

    @property
    def searched(self) -> Factorisation | None:
        """Factors that a search can go on from."""
        return self.factorisation if self.factorisation is not None and self.factorisation.method == "search" else None

    @property
    def term_errors(self) -> tuple[TermError, ...]:
        """The errors of each number of terms."""
        return self.factorisation.term_errors if self.factorisation is not None else ()

    def term_error(self, terms: int | None) -> TermError | None:
        """The errors of so many terms; of all for None, and where there are no longer so many."""
        return next(
            (term_error for term_error in self.term_errors if term_error.terms == terms),
            self.term_errors[-1] if self.term_errors else None,
        )

    def factors(self, terms: int | None) -> Factors | None:
        """The factors of so many terms, as `term_error`."""
        term_error = self.term_error(terms)
        if term_error is None or self.factorisation is None:
            return None
        factors = self.factorisation.factors
        return factors if factors.terms == term_error.terms else factors.truncate(term_error.terms)


class FactorRuns(QObject):
    """Starts, pauses, resumes and ends runs. `changed(number)` follows its state, `found(number)` its results."""

    changed = Signal(int)
    found = Signal(int)

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bench = bench
        self.live: dict[int, Live] = {}
        self._awaited = -1
        self._folder = bench.folder
        bench.document.changed.connect(self._follow)
        bench.jobs.changed.connect(self._job_changed)
        self._read(*bench.document.project.factoring.runs)  # of a project that was open before

    def of(self, run: Run) -> Live:
        """The state of `run`."""
        return self.live.setdefault(run.number, Live())

    def start(self) -> Run | None:
        """Start a run with the source and settings of the project; it becomes the chosen one."""
        factoring = self.bench.document.project.factoring
        identity = factoring.free_identity
        if factoring.choices.why_not:
            return None
        name = name_of(self.bench.document.project, factoring.source)
        given = source_of(self.bench.document.project, factoring.source)
        if given is None:
            self.bench.said.emit(GONE)
            return None
        same = next((run for run in factoring.runs if self._is_same(run, given, factoring.choices)), None)
        if same is not None:
            if factoring.current != same.number:
                self.bench.document.change(f"Choose {same.name}", factoring=replace(factoring, current=same.number))
            self.bench.said.emit(SAME)
            return None
        if identity is None:
            return None
        run = Run(self._next_number(), identity, name, factoring.source, factoring.choices, given)
        self.live[run.number] = Live()
        words = f"Factor {name}: {METHODS[factoring.choices.method]}"
        self.bench.document.change(words, factoring=factoring.with_run(run))
        self._begin(run, given, None)
        job = self.of(run).job
        if job is not None and job.waits_for:
            self.bench.said.emit(QUEUED.format(job.title, job.waits_for))
        return run

    def _is_same(self, run: Run, given: Brdf | Path, choices: FactorSettings) -> bool:
        """True if `run` is under way or done, of the same BRDF with the same settings."""
        live = self.of(run)
        ended_badly = live.job is None and live.state not in ("done", READING)
        return run.choices == choices and not ended_badly and (run.given is given or _equal(run.given, given))

    def again(self, run: Run) -> None:
        """Factor anew what has no result, and go on with a search that was stopped or interrupted."""
        live = self.of(run)
        if live.may_go_on and run.choices is not None:
            given = live.brdf if live.brdf is not None else run.given
            self._begin(run, given, live.searched)

    def go_on(self, number: object) -> None:
        """As `again`, once it is known what the run of this number has found; nothing where there is none."""
        run = next((each for each in self.bench.document.project.factoring.runs if each.number == number), None)
        if run is not None and self.of(run).state == READING:
            self._awaited = run.number
        elif run is not None:
            self.again(run)

    def more(self, run: Run, terms: int) -> None:
        """Go on to `terms` terms: a search from where it is, the others anew."""
        live, document = self.of(run), self.bench.document
        if live.job is not None or run.choices is None or live.brdf is None:
            return
        longer = replace(run, choices=run.choices.with_terms(terms))
        document.change(f"{terms} terms of {run.name}", factoring=document.project.factoring.changed(longer))
        self._begin(longer, live.brdf, live.searched)

    def open(self, path: Path) -> Job:
        """Read factors that were exported; they are compared with the BRDF chosen then."""
        project = self.bench.document.project
        given = source_of(project, project.factoring.source)
        job = self.bench.jobs.submit(f"Opening {path.name}", lambda: _open(path, given), lane="open")
        job.succeeded.connect(lambda found: self._add_opened(path, found))
        return job

    def _add_opened(self, path: Path, found: Found) -> None:
        factoring = self.bench.document.project.factoring
        identity = factoring.free_identity
        if identity is None:
            self.bench.said.emit(FULL)
            return
        run = Run(self._next_number(), identity, path.name, factoring.source, None, found.brdf, path.absolute())
        self.live[run.number] = Live(None, found.brdf, found.factorisation, list(_term_errors(found)), "opened")
        self.bench.document.change(f"Open factors {path.name}", factoring=factoring.with_run(run))

    def pause(self, run: Run) -> None:
        """Take no further step until `resume`."""
        job = self.of(run).job
        if job is not None:
            self.bench.jobs.pause(job)

    def resume(self, run: Run) -> None:
        """Go on after a pause."""
        job = self.of(run).job
        if job is not None:
            self.bench.jobs.resume(job)

    def cancel(self, run: Run) -> None:
        """End a run and keep the best that it has."""
        job = self.of(run).job
        if job is not None:
            self.bench.jobs.cancel(job)

    def _next_number(self) -> int:
        """A number by chance: the history may bring back runs of earlier starts, which nobody has counted."""
        return next(number for number in iter(lambda: random.randrange(RUN_NUMBERS), None) if number not in self.live)

    def _begin(self, run: Run, given: Brdf | Path, resume: Factorisation | None) -> None:
        live, choices, folder = self.of(run), run.choices, self.bench.own
        assert choices is not None
        title = f"Factoring {run.name}: {METHODS[choices.method]}"
        again = {"kind": "factor", "number": run.number}
        job = self.bench.jobs.submit(
            title,
            lambda: _factor(run, given, choices, resume, folder),
            lane="compute",
            again=again,
            resource=f"factors {run.number}",
        )
        live.job, live.state, live.why = job, "", ""
        job.progressed.connect(lambda step: self._on_progressed(run.number, live, step))
        job.succeeded.connect(lambda found: self._on_ended(run.number, live, "done", found))
        job.cancelled.connect(lambda: self._on_ended(run.number, live, "stopped", None))
        job.failed.connect(lambda error: self._on_failed(run.number, live, error))
        self.changed.emit(run.number)

    def _read(self, *runs: Run) -> None:
        """Read the results that runs found before this start."""
        for run in runs:
            live, reading = self.of(run), partial(_keep, run, self.bench.folder)
            live.state = READING
            job = self.bench.jobs.submit("Reading factors", reading, lane="open")
            job.succeeded.connect(partial(self._was_read, run.number, live))

    def _was_read(self, number: int, live: Live, found: Found) -> None:
        if live.job is None and live.factorisation is None:
            live.why = found.why
            whole = found.factorisation is not None and not found.factorisation.searching
            self._on_ended(number, live, "done" if whole else "not finished", found)
            live.history = list(live.term_errors)
            if number == self._awaited:
                self._awaited = -1
                self.go_on(number)

    def _job_changed(self, job: Job) -> None:
        for number, live in self.live.items():
            if live.job is job and not job.over:
                self.changed.emit(number)

    def _on_progressed(self, number: int, live: Live, step: Step) -> None:
        if step.partial is not None:
            self._take(live, step.partial)
            self.found.emit(number)
        self.changed.emit(number)

    def _take(self, live: Live, found: Found) -> None:
        live.brdf = found.brdf
        if found.factorisation is None or found.factorisation is live.factorisation:
            return
        live.factorisation = found.factorisation
        term_errors = found.factorisation.term_errors
        if term_errors and (not live.history or live.history[-1] is not term_errors[-1]):
            live.history.append(term_errors[-1])

    def _on_failed(self, number: int, live: Live, error: Exception) -> None:
        live.why = str(error)
        self._on_ended(number, live, "failed", None)

    def _on_ended(self, number: int, live: Live, state: str, found: Found | None) -> None:
        live.job, live.state = None, state
        if found is not None:
            self._take(live, found)
        self.found.emit(number)
        self.changed.emit(number)

    def _follow(self, old: Project, new: Project) -> None:
        if old.factoring is new.factoring:
            return
        if self._folder != self.bench.folder:  # another project
            self.live, self._folder = {}, self.bench.folder
        kept = {run.number for run in new.factoring.runs}
        for run in old.factoring.runs:
            if run.number not in kept:
                self.cancel(run)
        self._read(*(run for run in new.factoring.runs if run.number not in self.live))
        if not kept and not self.bench.document.undo_stack.count():
            self.live = {number: live for number, live in self.live.items() if live.job is not None}


def name_of(project: Project, source: str) -> str:
    """The displayed name of a source."""
    kind, words = names_of(source)
    if kind == "entry":
        entry = project.comparison.find(whole_number(words, 1 << 31))
        return entry.name if entry is not None else "–"
    if kind == "file":
        return Path(words).name
    if kind == "model":
        model, _, preset = words.partition(":preset=")
        return preset.replace("-", " ").capitalize() if preset else label_of(model)
    measured = project.material.measured
    if measured is not None:
        return str(measured.name)
    model = project.material.brdf.partition(":")[0]
    return f"{label_of(model)} of the material"


def source_of(project: Project, source: str) -> Any:
    """The BRDF of a source, the path of one in a file, or None for an entry that is no longer there."""
    kind, words = names_of(source)
    if kind == "entry":
        entry = project.comparison.find(whole_number(words, 1 << 31))
        return entry.brdf if entry is not None else None
    if kind == "file":
        return Path(words)
    if kind == "model":
        return MODELS[words]() if words in MODELS else brdf_from_text(words)
    assert source == MATERIAL
    measured = project.material.measured
    return measured if measured is not None else brdf_from_text(project.material.brdf)


def choices_of(project: Project) -> Sequence[tuple[str, str]]:
    """(source, name) of the project's own BRDFs: the compared ones, and that of the material."""
    entries = [(f"entry:{entry.identity}", entry.name) for entry in project.comparison.entries]
    return [*entries, (MATERIAL, name_of(project, MATERIAL))]


def files_of(project: Project) -> Sequence[Path]:
    """The files of the library that no BRDF of the comparison was read from."""
    shown = {entry.path for entry in project.comparison.entries if entry.fitted is None}
    return [path for path in project.comparison.files if path not in shown]


def _equal(one: object, other: object) -> bool:
    """True for equal models and paths; tables are the same only where they are one object."""
    return type(one) is type(other) and isinstance(one, (Path, *MODELS.values())) and bool(one == other)


def _brdf(given: Brdf | Path) -> Steps[Brdf]:
    if not isinstance(given, Path):
        return given
        yield

    return (yield from read_brdf_steps(given))


def _factor(
    run: Run, given: Brdf | Path, choices: FactorSettings, resume: Factorisation | None, folder: Path
) -> Steps[Found]:
    """Factor; each step's `partial` is the result so far. The best is kept in `folder`, however this ends."""
    yield Step(0.0, "compiling (first use only)")
    from engine.factor.factor import factor

    brdf = yield from part(_brdf(given), 0.0, 0.05)
    yield Step(0.05, "sampling", Found(brdf, resume))
    best, keeping = resume, Keeping(run, folder)
    steps = part(factor(brdf, choices, resume), 0.05, 1.0)
    try:
        while True:
            try:
                step = next(steps)
            except StopIteration as finished:
                best = finished.value
                return Found(brdf, best)
            except UsageError as error:
                raise InputError(run.name, str(error), "Choose another method or other settings") from error
            if step.partial is not None:
                best = step.partial
                keeping.now_and_then(best)
            yield Step(step.done, step.note, Found(brdf, best) if step.partial is not None else None)
    finally:
        steps.close()
        keeping.keep(best)


def _keep(run: Run, folder: Path) -> Steps[Found]:
    """A result that was found before, and the BRDF that it is of; what is gone is said and not raised."""
    yield Step(0.0, "reading factors")
    brdf, factorisation, why = None, None, ""
    try:
        factorisation = read_kept(run, folder)
        why = LOST if factorisation is None else ""
    except FileError as error:
        why = str(error)
    try:
        brdf = yield from part(_brdf(run.given), 0.5, 1.0)
    except FileError as error:
        why = why or str(error)
    return Found(brdf, factorisation, why)


def _open(path: Path, given: Brdf | Path) -> Steps[Found]:
    yield Step(0.0, "reading factors")
    from engine.factor.factor_file import read_factors

    factorisation = read_factors(path)
    brdf = yield from part(_brdf(given), 0.5, 1.0)
    return Found(brdf, factorisation)


def _term_errors(found: Found) -> tuple[TermError, ...]:
    return found.factorisation.term_errors if found.factorisation is not None else ()
