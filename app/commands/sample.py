"""The built-in capture with its stack and its material, ready made, so that it opens in about a second.

It lies beside the person's projects. Set-up makes it (`python -m app.commands.sample`), or whoever opens it first:
some 20 s of work, and 25 s more where kernels must be compiled. What is damaged is made again.
"""

from __future__ import annotations

import logging
import shutil
import sys
import tempfile
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from app.arguments.usage import BAD_FILE, DONE
from app.commands.bundle_view import SCALE_NOTE, settings_of_bundle
from app.commands.making import keep_marks, material_of, stack_of
from app.document.document import ImportChoices, Project
from app.project.photographs import taken
from app.project.places import projects_folder
from engine.capture.lights.sources import Sources, find
from engine.capture.stack import RADIANCE, RECORD, SATURATED, ImageStack, open_stack
from engine.core.errors import InputError, LightarcError
from engine.core.steps import Step, Steps, drain, part
from engine.scene.material import Material
from engine.storage.atomic import atomic_folder, discard, perform
from engine.storage.untrusted import expect

log = logging.getLogger(__name__)

NAME = "Woven sample"

#: The decoder of the maps of a bundle; that of the notes of a capture is there from the start of the window on.
MAPS = "engine.bundle.member_maps"


@dataclass(frozen=True, eq=False)
class Sample:
    """The capture, its photographs as a stack, and the material made of them, with the provenance of all."""

    sources: Sources
    stack: ImageStack
    material: Material
    provenance: dict[str, Any]

    @property
    def parts(self) -> dict[str, Any]:
        """Parts of a project that has just this capture, imported and built by the settings of a new project."""
        made = {"sources": self.sources, "stack": self.stack, "excluded": frozenset[str](), "name": NAME}
        choices = {"import_choices": ImportChoices(), "imported_with": ImportChoices()}
        settings = settings_of_bundle(self.material, self.provenance)
        recipe = Project(stack=self.stack, **settings).recipe
        return {**made, **choices, **settings, "built_from": recipe, "provenance": self.provenance}


def samples_folder() -> Path:
    """The folder of the built-in capture and of what was made of it; it may not exist."""
    return projects_folder().parent / "sample capture"


def marked_sample(target: Path) -> Steps[Sample]:
    """The sample, its stack in `target`; the project keeps the marks of its photographs."""
    expect(MAPS)
    sample = yield from part(ready_sample(samples_folder(), target), 0.0, 0.9)
    marks = yield from part(taken(sample.sources.photographs), 0.9, 1.0)
    keep_marks(target.parent, marks)
    return sample


def made_of_sample() -> list[Path]:
    """The results made of the sample's photographs, which stay: projects refer to them."""
    return [*samples_folder().glob("*-stack"), *samples_folder().glob("*.lightarc")]


def capture_of_sample(folder: Path) -> Steps[Sources]:
    """The photographs of the built-in capture, made where they are not there."""
    from engine.simulate.built_in import built_in_sample

    place = yield from built_in_sample(folder)
    return find([place])


def ready_sample(folder: Path, target: Path) -> Steps[Sample]:
    """The sample from `folder`, where it is made if need be; its stack is copied to `target`, which the project has.

    Raises FileError where either cannot be written.
    """
    sources = yield from part(capture_of_sample(folder), 0.0, 0.4)
    place = sources.photographs[0].parent
    stack, bundle = place.with_name(f"{place.name}-stack"), place.with_name(f"{place.name}.lightarc")
    yield Step(0.4, "opening the sample")
    from engine.bundle.bundle import describe_bundle, open_bundle

    try:
        material, provenance = open_bundle(bundle), describe_bundle(bundle)["provenance"]
        open_stack(stack)
    except InputError as error:
        log.info("the sample is made anew: %s", error)
        yield from part(_make(sources, stack, bundle), 0.4, 0.95)
        material, provenance = open_bundle(bundle), describe_bundle(bundle)["provenance"]
    with atomic_folder(target, RECORD) as copy:
        for file in (RECORD, RADIANCE, SATURATED):
            yield Step(0.95, "opening the sample")
            perform("write", copy / file, partial(shutil.copyfile, stack / file, copy / file))
    return Sample(sources, open_stack(target, verify=False), material, provenance)


def _make(sources: Sources, stack_folder: Path, bundle: Path) -> Steps[None]:
    """Import the photographs and build the material, by the settings of a new project."""
    from engine.bundle.bundle import save_bundle

    for place in (bundle, stack_folder):
        discard(place)
    stack = yield from part(stack_of(sources, ImportChoices(), stack_folder), 0.0, 0.6)
    material = yield from part(material_of(Project(sources=sources, stack=stack, name=NAME)), 0.6, 0.9)
    provenance = {**stack.provenance, "excluded_photographs": [], SCALE_NOTE: Project().scale}
    yield from part(save_bundle(bundle, material, provenance=provenance), 0.9, 1.0)


def main() -> int:
    """Make the sample ready in the person's own folder; 3 where that cannot be done, with the reason."""
    try:
        with tempfile.TemporaryDirectory() as folder:
            drain(ready_sample(samples_folder(), Path(folder) / "stack"))
    except LightarcError as error:
        print(error, file=sys.stderr)
        return BAD_FILE
    return DONE


if __name__ == "__main__":
    sys.exit(main())
