"""The menu of the photographs that are selected: use them or not, what each is for, and its file."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QAction, QDesktopServices
from PySide6.QtWidgets import QFileDialog, QMenu, QWidget

from app.commands.workbench import Workbench
from app.document.document import ImportChoices
from app.document.import_choices import choices_without, choose, path_of, reference_of, with_file, without
from engine.capture.lights.sources import Sources
from engine.core.steps import Step, Steps

if TYPE_CHECKING:
    from app.capture.photograph_list import PhotographList

NO_FILES = "The stack was opened without its photographs"

#: Calibration frames that a photograph of the capture can be, which it leaves then.
FRAMES = {"dark": "Dark frame", "flat": "Flat field"}


def menu_of(parent: QWidget, bench: Workbench, photographs: PhotographList, others: Sequence[QAction]) -> QMenu:
    """The menu of the rows of `photographs` that are selected; `others` are commands that are elsewhere too."""
    rows = photographs.photographs.rows
    places = photographs.selection
    names = [rows[place].name for place in places]
    project = bench.document.project
    one = names[0] if len(names) == 1 else None
    menu = QMenu(parent)
    menu.setToolTipsVisible(True)
    menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    these = "" if len(names) == 1 else f" {len(names)} photographs"
    unread = "" if project.stack is not None else "Waiting for the photographs"
    used = [name for name in names if name not in project.excluded]
    _add(menu, f"Use{these}", partial(bench.set_excluded, names, False), unread or _if(len(used) == len(names), "used"))
    _add(menu, f"Exclude{these}", partial(bench.set_excluded, names, True), unread or _if(not used, "excluded"))
    few = "" if len(names) > 1 else "Select two photographs or more"
    _add(menu, "Use only these", partial(bench.use_only, names), unread or few)
    menu.addSeparator()
    alone = "" if one is not None else "Select one photograph"
    no_file = alone or ("" if path_of(project, one) is not None else NO_FILES)
    purposes = menu.addMenu("Set as")
    purposes.setToolTipsVisible(True)
    reference = "All are aligned to it already" if one is not None and one == reference_of(project) else ""
    to_this = partial(choose, bench.document, f"Align to {one}", reference=one)
    _add(purposes, "Reference of the alignment", to_this, no_file or reference)
    for frame, words in FRAMES.items():
        _add(purposes, words, partial(use_as_frame, bench, frame, one), no_file)
    _add(menu, "Replace file…", partial(_ask_for_another, parent, bench, one), no_file)
    _add(menu, "Show file", partial(_show, bench, one), no_file)
    menu.addSeparator()
    _add(menu, "Select all\tCtrl+A", photographs.selectAll)
    inverse = [place for place in photographs.shown if place not in places]
    _add(menu, "Invert selection", partial(photographs.pick, inverse), "" if inverse else "All are selected")
    menu.addSeparator()
    menu.addActions(others)
    return menu


def _add(menu: QMenu, words: str, run: Callable[[], object], why_not: str = "") -> None:
    action = menu.addAction(words)
    action.setEnabled(not why_not)
    action.setToolTip(why_not)
    action.triggered.connect(lambda _checked=False: run())


def _if(is_so: bool, state: str) -> str:
    """The reason against what is so already."""
    return f"Already {state}" if is_so else ""


def _show(bench: Workbench, name: str | None) -> None:
    """Open the folder of a photograph; its path is said as well, since some file managers show nothing."""
    path = path_of(bench.document.project, name)
    if path is not None:
        QDesktopServices.openUrl(QUrl.fromLocalFile(str(path.parent)))
        bench.said.emit(str(path))


def _ask_for_another(parent: QWidget, bench: Workbench, name: str | None) -> None:
    path = path_of(bench.document.project, name)
    if path is not None and name is not None:
        chosen, _ = QFileDialog.getOpenFileName(parent, f"A photograph in place of {name}", str(path.parent))
        if chosen:
            replace_file(bench, name, Path(chosen))


def replace_file(bench: Workbench, name: str, path: Path) -> None:
    """Import the capture again with the file `path` in place of the photograph `name`, as one step of the history."""
    sources, choices, place = _find(bench, name)
    if sources is not None and place is not None:
        words, kept = f"Replace {name}", choices_without(choices, {name})
        job = bench.jobs.submit(words, lambda: _change(partial(with_file, sources, place, path)), lane="open")
        job.succeeded.connect(lambda changed: _import(bench, changed, kept, words))


def use_as_frame(bench: Workbench, frame: str, name: str | None) -> None:
    """Import the capture again without the photograph `name`, which becomes its 'dark' frame or its 'flat' field."""
    sources, choices, place = _find(bench, name)
    if sources is not None and place is not None and name is not None:
        words, path = f"{FRAMES[frame]}: {name}", sources.photographs[place]
        kept = choices_without(choices, {name})
        kept = dataclasses.replace(kept, dark=path) if frame == "dark" else dataclasses.replace(kept, flat=path)
        job = bench.jobs.submit(words, lambda: _change(partial(without, sources, {place})), lane="open")
        job.succeeded.connect(lambda changed: _import(bench, changed, kept, words))


def _find(bench: Workbench, name: str | None) -> tuple[Sources | None, ImportChoices, int | None]:
    """The photographs, the choices of their import, and the number of the photograph `name`."""
    project = bench.document.project
    path = path_of(project, name)
    if project.sources is None or path is None:
        return None, project.import_choices, None
    return project.sources, project.import_choices, project.sources.photographs.index(path)


def _import(bench: Workbench, sources: Sources, choices: ImportChoices, words: str) -> None:
    bench.import_photographs(sources, choices, bench.document.project.name, words)


def _change(change: Callable[[], Sources]) -> Steps[Sources]:
    yield Step(0.0, "looking at the photographs")
    return change()
