"""Commands of the window, without its widgets: each verb starts a job and changes the document when it succeeds.

The modules that compile kernels are imported inside the jobs, on their threads, so that the window opens at once.

The built-in capture: simulated when File > Rebuild sample first asks for it, and kept beside the user's projects.

File > Sample capture opens the woven cloth of `app.start.examples` instead, which is shipped ready-made.
"""

from __future__ import annotations

import dataclasses
import itertools
import logging
import secrets
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from app.commands import brdf as commands_brdf
from app.commands.bundle_view import (
    MODELS_WITH_MATERIALS,
    SCALE_NOTE,
    OpenedBundle,
    load_bundle,
    load_model_material,
    load_pbr_maps,
    settings_of_bundle,
    with_view,
)
from app.commands.export_bundle import Exported
from app.commands.export_bundle import export as export_bundle
from app.commands.making import keep_material, mark_stack
from app.commands.opening import load_environment, load_shape
from app.commands.recognise import CONTENT, Opening, Recognised, recognise
from app.document.document import ImportChoices, Look, Project
from app.document.open_document import Document
from app.jobs.jobs import Job, Jobs
from app.process.packages import load_shared
from app.project.photographs import INSIDE, photographs
from app.project.places import file_name, projects_folder
from app.project.project_file import path_of, state_name
from app.project.report import chain_of
from engine.capture.doubts import Doubtful
from engine.capture.lights.joined import join
from engine.capture.lights.sources import Sources, find, find_packed
from engine.capture.stack import ImageStack, open_stack
from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import SHAPES
from engine.light.environment import EnvironmentMap
from engine.light.sky import SKIES
from engine.scene.material import Material
from engine.simulate.built_in import make_built_in_sample

if TYPE_CHECKING:
    from engine.scene.scene import Scene

NAME = "Woven sample"


def samples_folder() -> Path:
    """The folder of the built-in capture; it may not exist."""
    return projects_folder().parent / "sample capture"


def capture_of_sample(folder: Path) -> Steps[Sources]:
    """The photographs of the built-in capture, simulated into `folder` where they are not there."""
    capture = yield from make_built_in_sample(folder)
    return find([capture])


log = logging.getLogger(__name__)

#: Said where a model comes with a material and another one was opened with it.
OWN_MATERIAL = "{} has a material of its own, which was not opened: {} came with it"


@dataclass(frozen=True, eq=False)
class Arrival:
    """A capture or a material for a project that has one already: the user chooses where it belongs.

    Attributes
    ----------
    name : what it is called.
    replace : opens it in place of what the project has.
    add : opens it beside what the project has; None where that has no meaning.
    added : what `add` does, in words that follow its name.
    """

    name: str
    replace: Callable[[], object]
    add: Callable[[], object] | None = None
    added: str = ""


class Workbench(QObject):
    """Document, jobs and the working folder together.

    Attributes
    ----------
    folder : data of the project.
    own : the folder of new stacks, and of what archives held; another one where the project is read-only.
    output_folder : where a user wrote something last, proposed for what is written next.

    Signals
    -------
    said : a sentence for the status bar.
    wanted : the name of the workspace that shows what was just opened.
    partial : a partial result of the running import.
    factors : the folder of factors that is to be opened.
    arrived : an `Arrival`, where a capture or a material would replace the one of the project.
    excluded : an error for each file that was not opened with the others, and the number of files given.
    output_moved : the new `output_folder`.
    """

    said = Signal(str)
    wanted = Signal(str)
    partial = Signal(object)
    factors = Signal(object)
    arrived = Signal(object)
    excluded = Signal(object, int)
    output_moved = Signal(object)

    def __init__(self, folder: Path, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.folder = self.own = folder
        self.output_folder = Path.home() if Path.home().is_dir() else Path.cwd()
        self.document = Document(self)
        self.jobs = Jobs(self)
        self.jobs.before = load_shared
        self.importing: Job | None = None
        self._last_import: tuple[Sources, ImportChoices, str] | None = None
        self.building: Job | None = None
        self.loading: Job | None = None
        self._taken: set[Path] = set()

    def propose(self, name: str, instead: str = "untitled") -> Path:
        """A path without ending for what is called `name`, where something was written last."""
        return self.output_folder / file_name(name, instead)

    def write_into(self, folder: Path) -> None:
        """Propose `folder` for what is written next."""
        if folder != self.output_folder:
            self.output_folder = folder
            self.output_moved.emit(folder)

    def open(self, paths: Sequence[Path]) -> None:
        """Open `paths`, files and folders of any kinds, each by its content where it belongs."""
        count = len(paths)
        job = self.jobs.submit("Opening", lambda: _recognise(tuple(paths)), lane="open")
        job.succeeded.connect(lambda found: self._open_recognised(found, count))

    def rebuild_sample(self) -> None:
        """Simulate the built-in capture at full size, and import and build it as any other."""
        self._place(NAME, self._rebuild_sample)

    def _rebuild_sample(self) -> None:
        self.wanted.emit("capture")
        job = self.jobs.submit(
            "Preparing the sample capture",
            lambda: capture_of_sample(samples_folder()),
            lane="compute",
            resource="samples",
        )
        job.succeeded.connect(lambda sources: self._import_others(sources, NAME))

    def _place(
        self, name: str, replace: Callable[[], object], add: Callable[[], object] | None = None, added: str = ""
    ) -> None:
        """Call `replace`, or ask where content called `name` belongs if the project has a capture or a material."""
        if self._has_capture:
            self.arrived.emit(Arrival(name, replace, add, added))
        else:
            replace()

    def _open_recognised(self, found: Opening, count: int) -> None:
        """Open all groups; where one of them is a capture or a material, as soon as the user has chosen its place."""
        content = next((group for group in found.groups if group.kind in CONTENT), None)

        def report() -> None:
            if found.excluded:
                self.excluded.emit(found.excluded, count)

        def replace() -> None:
            for group in found.groups:
                self._open_group(group, found)
            report()

        def add() -> None:
            for group in found.groups:
                if group is content:
                    self.add_photographs(group.paths)
                else:
                    self._open_group(group, found)
            report()

        if content is None:
            replace()
            return
        paths = content.paths
        name = paths[0].name if len(paths) == 1 else f"{len(paths)} files"
        can_add = content.kind == "photographs" and self.document.project.sources is not None
        about = "imports all photographs together, as one capture of one sample"
        self._place(name, replace, add if can_add else None, about if can_add else "")

    def _open_group(self, group: Recognised, among: Opening) -> None:
        """Open files of one kind, which were given `among` others."""
        path, others = group.paths[0], {each.kind for each in among.groups} - {group.kind}
        if group.kind == "mesh":
            self._open_model(path, among)
        elif group.kind == "material":
            job = self.jobs.submit("Opening the material", lambda: load_pbr_maps(*group.paths), lane="open")
            job.succeeded.connect(lambda bundle: self._bundle_opened(bundle, others))
        elif group.kind == "environment":
            self.wanted.emit("view")
            self.load_environment(str(path))
        elif group.kind == "brdf":
            self.wanted.emit("brdf")
            for each in group.paths:
                commands_brdf.open_file(self, each)
        elif group.kind == "factors":
            self.wanted.emit("factor")
            self.factors.emit(path)
        elif group.kind == "bundle":
            job = self.jobs.submit("Opening the bundle", lambda: load_bundle(path), lane="open")
            job.succeeded.connect(lambda bundle: self._bundle_opened(bundle, others))
        elif group.kind == "stack":
            job = self.jobs.submit("Opening the stack", lambda: _stack(path), lane="open")
            job.succeeded.connect(lambda stack: self._stack_opened(stack, path.stem))
        else:
            self.open_photographs(group.paths)

    def _open_model(self, path: Path, among: Opening) -> None:
        """Load a model, and the materials that it may bring unless another one was given `among` the files."""
        self.wanted.emit("view")
        if path.suffix.lower() not in MODELS_WITH_MATERIALS:
            self.load_model(str(path))
            return
        content = next((group.paths[0].name for group in among.groups if group.kind in CONTENT), "")
        job = self.jobs.submit("Looking for its material", lambda: load_model_material(path), lane="open")
        job.failed.connect(lambda _error: self.load_model(str(path)))
        job.succeeded.connect(lambda found: self._material_of_model_opened(path, found, content))

    def _material_of_model_opened(self, path: Path, found: OpenedBundle | None, content: str) -> None:
        def load() -> None:
            self.load_model(str(path))

        def both() -> None:
            load()
            self._bundle_opened(found, {"mesh"}) if found is not None else None

        if found is None or content:
            load()
            if found is not None:
                self.said.emit(OWN_MATERIAL.format(path.name, content))
        else:
            self._place(path.name, both, load, "opens the model alone, and keeps the material of this project")

    @property
    def _has_work(self) -> bool:
        """True if there is a capture or a material."""
        return self.document.project.stack is not None or self.document.project.has_map

    @property
    def _has_capture(self) -> bool:
        """True if there is or was a capture or a material, or one is being read."""
        importing, was_read = self.importing, self.document.project.imported_with is not None
        return self._has_work or was_read or (importing is not None and not importing.over)

    def open_photographs(self, paths: Sequence[Path]) -> None:
        """Import the capture that `paths` hold, in place of the one that is there."""
        self._look_for(paths).succeeded.connect(self._import_others)

    def add_photographs(self, paths: Sequence[Path]) -> None:
        """Import the capture that `paths` hold together with the one that is there."""
        before = self.document.project.sources
        if before is None:
            self.open_photographs(paths)
            return
        job = self._look_for(paths)
        job.succeeded.connect(lambda found: self._import_joined(before, found))

    def _look_for(self, paths: Sequence[Path]) -> Job:
        self.wanted.emit("capture")
        place, own = self._free(f"{INSIDE}/archive"), tuple(paths)
        return self.jobs.submit("Looking for photographs", lambda: find_packed(own, keep=place), lane="open")

    def _import_joined(self, before: Sources, found: Sources) -> None:
        job = self.jobs.submit("Joining the photographs", lambda: _join(before, found), lane="open")
        name = self.document.project.name
        job.succeeded.connect(lambda sources: self.import_photographs(sources, name=name))

    def _import_others(self, sources: Sources, name: str = "") -> None:
        """Import another capture; the project lets go of everything that belongs to the one it has, now."""
        choices, name = self.document.project.import_choices.for_another_capture, name or sources.name or "Untitled"
        before = self.document.project
        if not self._has_work and before.imported_with is None:
            self.import_photographs(sources, choices, name)
            return
        words, parts = f"Open {len(sources.photographs)} photographs", before.without_capture
        self.document.change(words, **{**parts, "sources": sources, "import_choices": choices, "name": name})
        begun = self.document.project
        job = self.import_photographs(sources, choices, name)

        def take_back() -> None:
            if self.jobs.accepting and not job.is_dropped:
                self.document.take_back(begun)

        job.failed.connect(lambda error: None if isinstance(error, Doubtful) else take_back())
        job.cancelled.connect(take_back)

    def import_photographs(
        self, sources: Sources, choices: ImportChoices | None = None, name: str = "", words: str = ""
    ) -> Job:
        """Import `sources` into the working folder, then build the material; `words` name the step of the history.

        Where there is a capture or a material already, other photographs come into the document when their import has
        succeeded as a whole. Into an empty one they come at once, so that an import that is killed can go on.
        """
        before = self.document.project.sources
        choices = choices or self.document.project.import_choices
        name = name or sources.name or "Untitled"
        are_others = before is None or before.photographs != sources.photographs
        if sources is not before and not (are_others and self._has_work):
            opened = f"Open {len(sources.photographs)} photographs"
            named = {"name": name} if before is None else {}
            self.document.change(words or opened, sources=sources, import_choices=choices, **named)
        if self.importing is not None:
            self.jobs.cancel(self.importing)
        files = photographs(dataclasses.replace(self.document.project, sources=sources, import_choices=choices))
        again = {"kind": "import", "name": name} if sources is self.document.project.sources else None
        folders, now = (self.folder, self.own), self.document.project.stack
        job = self.jobs.submit(
            "Importing photographs",
            lambda: mark_stack(sources, choices, folders, files, now),
            lane="compute",
            again=again,
            resource=f"stacks of {self.own}",
        )
        job.progressed.connect(self._show_partial)
        parts = {"sources": sources, "import_choices": choices}
        job.succeeded.connect(lambda stack: self._on_imported(stack, name, choices, parts, words))
        self.importing, self._last_import = job, (sources, choices, name)
        return job

    def import_all_the_same(self, consent: str) -> None:
        """Import again what was imported last, with the `consent` of a user to what was doubtful."""
        if self._last_import is not None:
            sources, choices, name = self._last_import
            agreed: dict[str, Any] = {consent: True}
            self.import_photographs(sources, dataclasses.replace(choices, **agreed), name)

    def _free(self, name: str) -> Path:
        """A path for something new, which nothing in the folder of the project has either, nor any job that runs."""
        if self.own != self.folder:
            return self.own / f"{name}-{secrets.token_hex(4)}"
        paths = (self.own / f"{name}-{at}" for at in itertools.count(1))
        free = next(path for path in paths if not path.exists() and path not in self._taken)
        self._taken.add(free)
        return free

    def _show_partial(self, step: Step) -> None:
        if step.partial is not None:
            self.partial.emit(step.partial)

    def _on_imported(
        self,
        stack: ImageStack,
        name: str,
        choices: ImportChoices | None = None,
        parts: Mapping[str, Any] = MappingProxyType({}),
        words: str = "",
    ) -> None:
        now = self.document.project
        if parts.get("sources") is now.sources:
            parts = {}  # what a user set meanwhile stays
        excluded = now.excluded & frozenset(stack.sources)
        gone = {"surface": None, "surface_from": None}
        made = {"stack": stack, "excluded": excluded, "name": name, **gone}
        self.document.change(words or "Import photographs", **{**made, "imported_with": choices, **parts})
        self.said.emit(f"{len(stack.sources)} photographs imported")
        self.build_material()

    def _stack_opened(self, stack: ImageStack, name: str) -> None:
        if self.importing is not None:
            self.jobs.drop(self.importing)
        now = self.document.project
        opened = {"stack": stack, "name": name, "import_choices": now.import_choices.for_another_capture}
        self.document.change(f"Open {name}", **{**now.without_capture, **opened})
        self.said.emit(f"The stack {name} is open")
        self.build_material()

    def set_excluded(self, sources: Collection[str], excluded: bool) -> None:
        """Leave the photographs `sources` out of the material, or take them in again."""
        now = self.document.project.excluded
        what = next(iter(sources)) if len(sources) == 1 else f"{len(sources)} photographs"
        words = f"{'Exclude' if excluded else 'Include'} {what}"
        self.document.change(words, excluded=now | frozenset(sources) if excluded else now - frozenset(sources))

    def use_only(self, sources: Collection[str]) -> None:
        """Make the material of the photographs `sources` alone."""
        stack = self.document.project.stack
        if stack is not None:
            words = "Use all photographs" if len(sources) == len(stack.sources) else f"Use {len(sources)} photographs"
            self.document.change(words, excluded=frozenset(stack.sources) - frozenset(sources))

    def build_material(self) -> None:
        """Linearise the stack into slices and compress them, as the project says."""
        project = self.document.project
        if project.stack is None:
            return
        if self.building is not None:
            self.jobs.cancel(self.building)
        again = {"kind": "build"}
        folder, own = self.folder, self.own
        self.building = self.jobs.submit(
            "Building the material",
            lambda: keep_material(project, folder, own),
            lane="compute",
            again=again,
            resource="material",
        )
        self.building.succeeded.connect(lambda material: self._on_built(project, material))

    def _on_built(self, project: Project, material: Material) -> None:
        now = self.document.project
        if now.stack is not project.stack or project.stack is None:
            return  # undone, or another capture was opened in the meantime
        kept = {name: getattr(now.material, name) for name in ("brdf", "measured", "sigma")}
        material = dataclasses.replace(material, **kept)
        provenance = {
            **project.stack.provenance,
            "excluded_photographs": sorted(project.excluded),
            SCALE_NOTE: project.scale,
        }
        made = {"material": material, "built_from": project.recipe, "provenance": provenance}
        self.document.change("Build material", **{**made, **self._flat_at_first(now, material)})
        self.said.emit("Material built")

    def _flat_at_first(self, now: Project, material: Material) -> dict[str, Any]:
        """Parts that show `material` flat where it comes from a dome, `now` has none, and nobody chose a model."""
        is_loading = self.loading is not None and not self.loading.over
        is_first = material.directional is not None and not now.has_map
        return now.lay_flat(material) if is_first and now.mesh is None and not is_loading else {}

    def show_flat(self) -> None:
        """Show the material once, flat and from the front."""
        now = self.document.project
        if now.has_map:
            if self.loading is not None:
                self.jobs.drop(self.loading)
            self.document.change("Show the image flat", **now.lay_flat(now.material))

    def load_model(self, name_or_path: str) -> None:
        """Show the material on a built-in model or on a mesh from a file, and cancel a model that is still loading."""
        if self.loading is not None:
            self.jobs.drop(self.loading)
        job = self.jobs.submit("Loading the model", lambda: load_shape(name_or_path), lane="open")
        job.succeeded.connect(lambda mesh: self._model_loaded(mesh, name_or_path))
        self.loading = job

    def _model_loaded(self, mesh: Mesh, name_or_path: str) -> None:
        files = self._came_from(mesh.name, name_or_path, SHAPES)
        look = self.document.project.look
        if self.document.project.is_flat:
            look = dataclasses.replace(look, repeats=Look().repeats)
        self.document.change(f"Model {mesh.name}", mesh=mesh, camera=None, look=look, came_from=files)

    def _came_from(self, name: str, name_or_path: str, built_in: Collection[str]) -> dict[str, Path]:
        """Files by the names of what was read from them, with this one."""
        files = {known: file for known, file in self.document.project.came_from.items() if known != name}
        return files if name_or_path in built_in else {**files, name: Path(name_or_path).absolute()}

    def load_environment(self, name_or_path: str) -> None:
        """Light the model by a built-in environment or by one from a file."""
        job = self.jobs.submit("Opening the environment", lambda: load_environment(name_or_path), lane="open")
        job.succeeded.connect(lambda environment: self._environment_opened(environment, name_or_path))

    def _environment_opened(self, environment: EnvironmentMap, name_or_path: str) -> None:
        files = self._came_from(environment.name, name_or_path, SKIES)
        self.document.change(f"Light from {environment.name}", environment=environment, came_from=files)
        for warning in environment.health.warnings:
            log.warning("%s: %s", environment.name, warning)
        self.said.emit(next(iter(environment.health.warnings), f"Light from {environment.name}"))

    def export(self, path: Path, include: frozenset[str], scene: Scene | None) -> Job:
        """Write the bundle `path` with the parts in `include` ('slices', 'power-law'), then verify it: `Exported`.

        Its preview shows `scene`; its provenance names the project, this state of it, and how it came to be.
        """
        project, folder, steps = self.document.project, self.folder, self.document.steps
        done = steps[: self.document.undo_stack.index()]

        def work() -> Steps[Exported]:
            yield Step(0.0, "naming the state of the project")
            origin = {"name": project.name, "state": state_name(project, folder), "history_steps": len(steps)}
            chain = chain_of(path_of(folder), project, done)
            return (yield from export_bundle(project, path, scene, include, {"project": origin, **chain}))

        again = {"kind": "bundle", "folder": str(path.parent), "name": path.name, "parts": sorted(include)}
        return self.jobs.submit(
            f"Writing {path.name}",
            work,
            lane="compute",
            again=again,
            resource=str(path),
            on_stop="Nothing is written if you stop it.",
        )

    def _bundle_opened(self, bundle: OpenedBundle, others: Collection[str] = ()) -> None:
        """Take the material and its view, without the model and the environment where `others` were opened with it."""
        now, found = self.document.project, bundle.referred
        if self.importing is not None:
            self.jobs.drop(self.importing)
        own = {"mesh": ("mesh", "camera"), "environment": ("environment",)}
        left = {part for kind in own.keys() & set(others) for part in own[kind]}
        found = dataclasses.replace(found, parts={name: part for name, part in found.parts.items() if name not in left})
        if self.loading is not None and "mesh" in found.parts:
            self.jobs.drop(self.loading)
        parts = now.without_capture
        look = with_view(parts.get("look", now.look), bundle.provenance)
        flat: dict[str, Any] = {}
        if "view" not in bundle.provenance and "mesh" not in others:
            flat = self._flat_at_first(dataclasses.replace(now, **parts), bundle.material)
        self.document.change(
            f"Open {bundle.name}",
            **{
                **parts,
                **found.parts,
                "material": bundle.material,
                "provenance": bundle.provenance,
                "name": bundle.name,
                "look": look,
                "came_from": {**now.came_from, **found.parts.get("came_from", {})},
                **settings_of_bundle(bundle.material, bundle.provenance),
                **flat,
            },
        )
        has_model = "mesh" in others or self.document.project.mesh is not None
        self.wanted.emit("view" if has_model else "material")
        what = "Bundle" if bundle.material.pbr is None else "Material"
        self.said.emit(". ".join([f"{what} {bundle.name} opened", *found.missing]))


def _recognise(paths: tuple[Path, ...]) -> Steps[Opening]:
    yield Step(0.0, "recognising files")
    return recognise(paths)


def _join(one: Sources, other: Sources) -> Steps[Sources]:
    yield Step(0.0, "joining the photographs")
    return join(one, other)


def _stack(folder: Path) -> Steps[ImageStack]:
    yield Step(0.0, "opening the stack")
    return open_stack(folder)
