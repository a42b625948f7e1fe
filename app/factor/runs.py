"""The live runs of the Factor workspace: their jobs, and the results of each so far.

The document says which runs there are; this follows it. A run that is no longer there is cancelled and keeps the best
that it had, so that undoing its removal brings it back. Pausing keeps everything, also the place in the search.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from app.commands.workbench import Workbench
from app.document.comparison import MARKERS
from app.document.document import Project
from app.document.factoring import MATERIAL, METHODS, Run, names_of
from app.jobs.jobs import Job
from app.widgets.labels import BRDF_NAMES
from engine.brdf.brdf import MODELS, brdf_from_text
from engine.core.errors import InputError, UsageError
from engine.core.steps import Step, Steps, part
from engine.factor.settings import FactorSettings

if TYPE_CHECKING:
    from engine.factor.errors import Factorisation, TermError

FULL = f"{len(MARKERS)} runs are listed at most; remove one first"
GONE = "The BRDF is no longer in the list of the BRDF workspace"


@dataclass(frozen=True, eq=False)
class Found:
    """The BRDF that is factored, and the factorisation so far, if there is one."""

    brdf: Any
    factorisation: Factorisation | None


@dataclass(eq=False)
class Live:
    """The state of a run: its job, if any, its last result, every error on the way, and the reason of a failure."""

    job: Job | None = None
    brdf: Any = None
    factorisation: Factorisation | None = None
    history: list[TermError] = field(default_factory=list)
    state: str = ""
    why: str = ""

    @property
    def ladder(self) -> tuple[TermError, ...]:
        """The errors of each number of terms."""
        return self.factorisation.ladder if self.factorisation is not None else ()

    def rung(self, terms: int | None) -> TermError | None:
        """The errors of so many terms; of all for None, and where there are no longer so many."""
        return next((rung for rung in self.ladder if rung.terms == terms), self.ladder[-1] if self.ladder else None)

    def factors(self, terms: int | None) -> Any:
        """The factors of so many terms, as `rung`."""
        rung = self.rung(terms)
        if rung is None or self.factorisation is None:
            return None
        factors = self.factorisation.factors
        return factors if factors.terms == rung.terms else factors.truncated(rung.terms)


class FactorRuns(QObject):
    """Starts, pauses, resumes and ends runs. `changed(number)` follows its state, `found(number)` its results."""

    changed = Signal(int)
    found = Signal(int)

    def __init__(self, bench: Workbench) -> None:
        super().__init__(bench)
        self.bench = bench
        self.live: dict[int, Live] = {}
        self._last_number = 0
        bench.document.changed.connect(self._follow)
        bench.jobs.changed.connect(self._job_changed)

    def of(self, run: Run) -> Live:
        """The state of `run`."""
        return self.live.setdefault(run.number, Live())

    def start(self) -> Run | None:
        """Start a run with the source and settings of the project; it becomes the chosen one."""
        factoring = self.bench.document.project.factoring
        identity = factoring.free_identity
        if identity is None or factoring.choices.why_not:
            return None
        name = name_of(self.bench.document.project, factoring.source)
        run = Run(self._next_number(), identity, name, factoring.source, factoring.choices)
        given = source_of(self.bench.document.project, factoring.source)
        if given is None:
            self.bench.said.emit(GONE)
            return None
        words = f"Factor {name}: {METHODS[factoring.choices.method]}"
        self.bench.document.change(words, factoring=factoring.with_run(run))
        self._begin(run, given, None)
        return run

    def more(self, run: Run, terms: int) -> None:
        """Go on to `terms` terms: a search from where it is, the others anew."""
        live, document = self.of(run), self.bench.document
        if live.job is not None or run.choices is None or live.brdf is None:
            return
        longer = replace(run, choices=run.choices.with_terms(terms))
        document.change(f"{terms} terms of {run.name}", factoring=document.project.factoring.changed(longer))
        self._begin(longer, live.brdf, live.factorisation if run.choices.method == "search" else None)

    def open(self, path: Path) -> Job:
        """Read factors that were exported; they are compared with the BRDF chosen then."""
        project = self.bench.document.project
        given = source_of(project, project.factoring.source)
        job = self.bench.jobs.submit(f"Opening {path.name}", lambda: _opened(path, given))
        job.succeeded.connect(lambda found: self._add_opened(path, found))
        return job

    def _add_opened(self, path: Path, found: Found) -> None:
        factoring = self.bench.document.project.factoring
        identity = factoring.free_identity
        if identity is None:
            self.bench.said.emit(FULL)
            return
        run = Run(self._next_number(), identity, path.name, factoring.source, None)
        self.live[run.number] = Live(None, found.brdf, found.factorisation, list(_ladder(found)), "opened")
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
        self._last_number += 1
        return self._last_number

    def _begin(self, run: Run, given: Any, resume: Factorisation | None) -> None:
        live, choices = self.of(run), run.choices
        assert choices is not None
        title = f"Factoring {run.name}: {METHODS[choices.method]}"
        job = self.bench.jobs.submit(title, lambda: _factored(run.name, given, choices, resume))
        live.job, live.state, live.why = job, "", ""
        job.progressed.connect(lambda step: self._progressed(run.number, step))
        job.succeeded.connect(lambda found: self._ended(run.number, "done", found))
        job.cancelled.connect(lambda: self._ended(run.number, "stopped", None))
        job.failed.connect(lambda error: self._failed(run.number, error))
        self.changed.emit(run.number)

    def _job_changed(self, job: Job) -> None:
        for number, live in self.live.items():
            if live.job is job and not job.over:
                self.changed.emit(number)

    def _progressed(self, number: int, step: Step) -> None:
        if step.partial is not None:
            self._take(self.live[number], step.partial)
            self.found.emit(number)
        self.changed.emit(number)

    def _take(self, live: Live, found: Found) -> None:
        live.brdf = found.brdf
        if found.factorisation is None or found.factorisation is live.factorisation:
            return
        live.factorisation = found.factorisation
        rungs = found.factorisation.ladder
        if rungs and (not live.history or live.history[-1] is not rungs[-1]):
            live.history.append(rungs[-1])

    def _failed(self, number: int, error: Exception) -> None:
        self.live[number].why = str(error)
        self._ended(number, "failed", None)

    def _ended(self, number: int, state: str, found: Found | None) -> None:
        live = self.live[number]
        live.job, live.state = None, state
        if found is not None:
            self._take(live, found)
        self.found.emit(number)
        self.changed.emit(number)

    def _follow(self, old: Project, new: Project) -> None:
        if old.factoring is new.factoring:
            return
        kept = {run.number for run in new.factoring.runs}
        for run in old.factoring.runs:
            if run.number not in kept:
                self.cancel(run)
        if not kept and not self.bench.document.undo_stack.count():
            self.live = {number: live for number, live in self.live.items() if live.job is not None}


def name_of(project: Project, source: str) -> str:
    """The displayed name of a source."""
    kind, words = names_of(source)
    if kind == "entry":
        entry = project.comparison.find(int(words))
        return entry.name if entry is not None else "–"
    if kind == "file":
        return Path(words).name
    if kind == "model":
        model, _, preset = words.partition(":preset=")
        return preset.replace("-", " ").capitalize() if preset else BRDF_NAMES.get(model, model)
    measured = project.material.measured
    if measured is not None:
        return str(measured.name)
    model = project.material.brdf.partition(":")[0]
    return f"{BRDF_NAMES.get(model, model)} of the material"


def source_of(project: Project, source: str) -> Any:
    """The BRDF of a source, the path of one in a file, or None for an entry that is no longer there."""
    kind, words = names_of(source)
    if kind == "entry":
        entry = project.comparison.find(int(words))
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


def _brdf(given: Any) -> Steps[Any]:
    if not isinstance(given, Path):
        return given
        yield
    from engine.brdf.readers.read import read_brdf_steps

    return (yield from read_brdf_steps(given))


def _factored(name: str, given: Any, choices: FactorSettings, resume: Factorisation | None) -> Steps[Found]:
    """Factor; each step's `partial` is the result so far."""
    yield Step(0.0, "preparing kernels")
    from engine.factor.factor import factor

    brdf = yield from part(_brdf(given), 0.0, 0.05)
    yield Step(0.05, "sampling", Found(brdf, resume))
    steps = part(factor(brdf, choices, resume), 0.05, 1.0)
    try:
        while True:
            try:
                step = next(steps)
            except StopIteration as finished:
                return Found(brdf, finished.value)
            except UsageError as error:
                raise InputError(name, str(error), "Choose another method or other settings") from error
            found = Found(brdf, step.partial) if step.partial is not None else None
            yield Step(step.done, step.note, found)
    finally:
        steps.close()


def _opened(path: Path, given: Any) -> Steps[Found]:
    yield Step(0.0, "reading factors")
    from engine.factor.factor_file import read_factors

    factorisation = read_factors(path)
    brdf = yield from part(_brdf(given), 0.5, 1.0)
    return Found(brdf, factorisation)


def _ladder(found: Found) -> tuple[TermError, ...]:
    return found.factorisation.ladder if found.factorisation is not None else ()
