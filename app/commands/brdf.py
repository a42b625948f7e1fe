"""Operations of the BRDF workspace on the document and on files, without widgets; each long one is a job."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from app.arguments.results import TABLE
from app.document.comparison import MARKERS, Entry, Fitted
from app.widgets.resources import RESOURCES
from engine.brdf.brdf import MODELS, Brdf, brdf_from_text, brdf_to_text, label_of, model_name
from engine.brdf.models.microfacet import Ggx
from engine.brdf.models.model import Model
from engine.brdf.readers.merl import write_merl
from engine.brdf.readers.read import MeasuredBrdf, read_brdf_steps
from engine.brdf.resample import SHAPE, resample
from engine.brdf.table import DirectionTable, HalfDifferenceTable
from engine.brdf.written import WrittenBrdf, write
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, part
from engine.gl.brdf_textures import factor_source
from engine.storage.atomic import write_bytes
from engine.storage.outputs import check_outputs

if TYPE_CHECKING:
    from app.commands.workbench import Workbench
    from app.jobs.jobs import Job
    from engine.brdf.fit import FitError, Residual, Weighting

#: Texts in GLSL to begin with, by the names of their files.
TEMPLATES = {"ggx": "GGX", "blinn-phong": "Blinn–Phong"}

FULL = f"{len(MARKERS)} BRDFs are compared at most; remove one first"

#: Samples on which the error is followed while a fit runs, and on which the model nearest to a measurement is found.
FOLLOWED, NEAREST = 2000, 2000


@dataclass(frozen=True, eq=False)
class FitSoFar:
    """The best of a fit until now: the model, the errors where it began and now, and both by half angle."""

    brdf: Brdf
    before: FitError
    after: FitError
    start: Residual
    now: Residual


def is_model(brdf: object) -> TypeGuard[Model]:
    """True if `brdf` has parameters and a text, and is quick to evaluate."""
    return type(brdf) in MODELS.values()


def has_shader(brdf: Brdf) -> bool:
    """True if `brdf` is drawn as it is, without a table: a model, or factors, which are textures already."""
    return is_model(brdf) or factor_source(brdf) is not None


def add_model(bench: Workbench, text: str) -> None:
    """Compare the model or preset that `text` names."""
    brdf = brdf_from_text(text)
    preset = text.partition("preset=")[2]
    add(bench, preset.replace("-", " ").capitalize() if preset else label_of(model_name(brdf)), brdf)


def add(bench: Workbench, name: str, brdf: Brdf, path: Path | None = None, fitted: Fitted | None = None) -> None:
    """Compare `brdf`; its file, if it has one, stays in the library, and it is what is factored next."""
    comparison = bench.document.project.comparison
    if comparison.free_identity is None:
        bench.said.emit(FULL)
        return
    parts: dict[str, Any] = {}
    identity = comparison.free_identity
    comparison = comparison.added(name, brdf, path, fitted)
    if path is not None:
        comparison = comparison.with_file(path)
        parts["factoring"] = dataclasses.replace(bench.document.project.factoring, source=f"entry:{identity}")
    bench.document.change(f"Compare {name}", comparison=comparison, **parts)


def open_file(bench: Workbench, path: Path, *, instead_of: Path | None = None) -> Job:
    """Read a measured BRDF and compare it; in the library it takes the place of `instead_of`."""
    job = bench.jobs.submit(f"Opening {path.name}", lambda: _read(path), lane="open")
    job.succeeded.connect(lambda brdf: _open(bench, path, brdf, instead_of))
    return job


def _open(bench: Workbench, path: Path, brdf: MeasuredBrdf, instead_of: Path | None) -> None:
    if instead_of is not None:
        moved = bench.document.project.comparison.with_file(path, instead_of)
        entries = tuple(dataclasses.replace(e, path=path) if e.path == instead_of else e for e in moved.entries)
        bench.document.change(f"Find {path.name}", comparison=dataclasses.replace(moved, entries=entries))
        if any(entry.path == path for entry in entries):
            return
    add(bench, brdf.name or path.stem, brdf, path)


def _read(path: Path) -> Steps[MeasuredBrdf]:
    yield Step(0.0, "reading")

    return (yield from read_brdf_steps(path))


def add_written(bench: Workbench, template: str) -> Job:
    """Compare a BRDF written in GLSL that begins as `template`, one of `TEMPLATES`."""
    name = f"My {TEMPLATES[template]}"
    job = bench.jobs.submit(f"Compiling {name}", lambda: _from_template(template, name), lane="open")
    job.succeeded.connect(lambda brdf: add(bench, name, brdf))
    return job


def _from_template(template: str, name: str) -> Steps[WrittenBrdf]:
    yield Step(0.0, "compiling")
    return write((RESOURCES / "brdf" / f"{template}.brdf").read_text(encoding="utf-8"), name)


def save_text(bench: Workbench, text: str, path: Path) -> Job:
    """Write the text of a BRDF to a file. A user was asked before a file is replaced."""
    job = bench.jobs.submit(f"Writing {path.name}", lambda: _write_text(text, path), lane="save", resource=str(path))
    job.succeeded.connect(bench.said.emit)
    return job


def _write_text(text: str, path: Path) -> Steps[str]:
    yield Step(0.0, "writing")
    write_bytes(path, text.encode("utf-8"))
    return f"{path.name} written"


def use(bench: Workbench, entry: Entry) -> Job | None:
    """Make `entry` the BRDF of the material; a measurement becomes a table first, in a job. Factors stay."""
    if is_model(entry.brdf):
        _use(bench, entry.name, {"brdf": brdf_to_text(entry.brdf), "measured": None})
        return None
    job = bench.jobs.submit(f"Preparing {entry.name}", lambda: _as_material(entry.brdf), lane="compute")
    job.succeeded.connect(lambda parts: _use(bench, entry.name, parts))
    return job


def _use(bench: Workbench, name: str, parts: dict[str, Any]) -> None:
    material = dataclasses.replace(bench.document.project.material, **parts)
    bench.document.change(f"Use {name} for the material", material=material)
    bench.said.emit(f"The material reflects as {name}")


def _as_material(brdf: Brdf) -> Steps[dict[str, Any]]:
    """The table of a measurement, or factors as they are, and the model nearest to it for what holds neither."""
    yield Step(0.0, "compiling (first use only)")
    from engine.brdf.fit import fit, fit_data
    from engine.brdf.readers.table_file import keep_table

    measured = brdf if has_shader(brdf) else (yield from part(keep_table(brdf), 0.0, 0.5))
    nearest = yield from part(fit(fit_data(measured, count=NEAREST), Ggx()), 0.5, 1.0)
    return {"brdf": brdf_to_text(nearest.brdf), "measured": measured}


def save_table(bench: Workbench, brdf: Brdf, path: Path) -> Job:
    """Write `brdf` as a table: .binary as MERL, .exr as ours; never over a file of the library."""
    files = [str(file) for file in bench.document.project.comparison.files]
    job = bench.jobs.submit(f"Writing {path.name}", lambda: _write(brdf, path, files), lane="save", resource=str(path))
    job.succeeded.connect(bench.said.emit)
    return job


def _write(brdf: Brdf, path: Path, inputs: Sequence[str]) -> Steps[str]:
    """Write the table and report its error in a sentence. A user was asked before a file is replaced."""
    yield Step(0.0, "compiling (first use only)")
    from engine.brdf.readers.table_file import write_table

    check_outputs([(str(path), TABLE)], inputs, overwrite=True)
    merl = path.suffix.lower() == ".binary"
    kept = isinstance(brdf, HalfDifferenceTable) and (brdf.missing.shape == SHAPE or not merl)
    lost = ""
    table: Any = brdf
    if not kept and (merl or not isinstance(brdf, DirectionTable)):
        table = yield from part(resample(brdf), 0.0, 0.95)
        lost = f"; as a table it has an error of {percent(table.health.figures['resampling_rms_rel'])} RMS"
    yield Step(0.96, "writing")
    if merl:
        write_merl(path, table)
    else:
        write_table(path, table)
    return f"{path.name} written{lost}"


def fit(brdf: Brdf, model: str, weighting: Weighting) -> Steps[FitSoFar]:
    """Fit `model` to `brdf`; steps carry the best so far."""
    yield Step(0.0, "taking samples")
    from engine.brdf.fit import fit, fit_data, fit_error, residual_by_angle

    start = MODELS[model]()
    data = fit_data(brdf)
    few = data.first(FOLLOWED)
    residual = residual_by_angle(start, data)["theta_h"]
    error = fit_error(start, data, weighting)
    best = FitSoFar(start, error, error, residual, residual)
    lowest = np.inf
    yield Step(0.02, "comparing starts", best)
    steps = fit(data, start, weighting=weighting)
    try:
        while True:
            step = next(steps)
            found = None
            if step.partial is not None and step.partial != best.brdf:
                now = fit_error(step.partial, few, weighting)
                if now.objective < lowest:
                    lowest = now.objective
                    remains = residual_by_angle(step.partial, few)["theta_h"]
                    found = best = dataclasses.replace(best, brdf=step.partial, after=now, now=remains)
            yield Step(step.done, step.note, found)
    except StopIteration as finished:
        done = finished.value
        return dataclasses.replace(
            best, brdf=done.brdf, before=done.before, after=done.after, now=done.by_angle["theta_h"]
        )
    finally:
        steps.close()
