"""A window with work in it: BRDFs compared, factors made, light baked, and the states in which a user sees all that.

`packaging/screenshots.py` takes images of these states, and the tests look for faults in them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from typing import Any, Literal

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget

from app.commands import brdf as commands_brdf
from app.document.variation import VariedParameter
from app.window.main_window import MainWindow
from engine.factor.settings import FactorSettings
from engine.light.lamps import LampSettings

#: BRDFs that are compared, by their texts.
COMPARED = ("lambert:albedo=0.6", "ggx:alpha=0.2", "ward", "cook-torrance", "lafortune:preset=blue-paint")

#: Methods of factoring that run.
METHODS: tuple[Literal["svd", "homomorphic"], ...] = ("svd", "homomorphic")

#: Waits until something is true, running the event loop.
Until = Callable[[Callable[[], bool]], object]


def fill(window: MainWindow, until: Until, *, method: str, cheap: bool = False) -> None:
    """Compare BRDFs, factor by two methods, light the model, and bake it, beside a capture that is made already.

    `cheap` takes the coarsest choices of a bake and of factors.
    """
    bench, view = window.bench, window.view
    window.show_workspace("brdf")
    for text in COMPARED:
        commands_brdf.add_model(bench, text)
    window.show_workspace("factor")
    small: dict[str, Any] = {"size": 8, "samples": 300, "side": 8} if cheap else {}
    for how in METHODS:
        window.factor.settings.edited.emit(FactorSettings(method=how, **small), True)
        window.factor.start()
    until(lambda: not bench.jobs.active)
    window.show_workspace("view")
    until(lambda: view.default_mesh is not None)
    bench.load_environment("studio")
    until(lambda: bench.document.project.environment is not None)
    view.choose_mode(method)
    baking, panel = view.bakings[method], view.bake_panels[method]
    for name, value in (("order", 3), ("terms", 2), ("cube", 16)) if cheap else ():
        if name in panel.choices:
            panel.choices[name].setCurrentIndex(max(0, panel.choices[name].findData(value)))
            panel.choices[name].activated.emit(0)
    until(lambda: baking.ready is not None)
    baking.bake()
    until(lambda: baking.is_made)
    lamps = (LampSettings(phi_deg=-60.0, radius_deg=4.0, colour=(1.0, 0.7, 0.4)), LampSettings(phi_deg=80.0))
    look = bench.document.project.look
    bench.document.change("Add lamps", look=dataclasses.replace(look, lamps=lamps))


def states(window: MainWindow) -> Iterator[str]:
    """Lead a filled window from state to state, and name each; what it shows may take a moment to come to rest."""
    yield from _capture(window)
    yield from _material(window)
    yield from _brdf(window)
    window.show_workspace("factor")
    for name, button in window.factor.against.buttons.items():
        button.click()
        yield f"factor-{name}"
    window.factor.against.buttons["terms"].click()
    yield from _view(window)
    window.show_workspace("export")
    for form in ("elsewhere", "bundle"):
        window.export.show_form(form)
        yield f"export-{form}"
    yield from _docks(window)


def _capture(window: MainWindow) -> Iterator[str]:
    window.show_workspace("capture")
    fold = window.capture.options.fold.head
    for is_open, name in ((False, "capture"), (True, "capture-calibration")):
        fold.setChecked(is_open)
        yield name
    fold.setChecked(False)
    for tool in ("points", "sphere"):
        window.capture.open_tool(tool)
        yield f"capture-{tool}"
        window.capture.close_tool()
    window.capture.magnify.trigger()
    yield "capture-loupe"
    window.capture.magnify.trigger()


def _material(window: MainWindow) -> Iterator[str]:
    window.show_workspace("material")
    for name, button in window.material.show_what.buttons.items():
        if button.isEnabled():
            button.click()
            yield f"material-{name}"
    window.material.show_page("surface")
    yield "material-surface"
    window.material.show_page("material")


def _brdf(window: MainWindow) -> Iterator[str]:
    window.show_workspace("brdf")
    tab = window.brdf
    for value, button in tab.scale.buttons.items():
        button.click()
        yield f"brdf-{value}"
    for name, tile in tab.tile_of.items():
        tab.tiles.enlarge(tile)
        yield f"brdf-{name}"
    tab.tiles.enlarge(None)
    tab.scale.buttons["log"].click()


def _view(window: MainWindow) -> Iterator[str]:
    window.show_workspace("view")
    document, before = window.bench.document, window.bench.document.project.look
    for comparing in ("", "wipe", "difference"):
        look = dataclasses.replace(document.project.look, comparing=comparing, against="direct")
        document.change("Compare", look=look)
        yield f"view-{comparing or 'baked'}"
    document.change("Compare", look=before)
    document.change("Vary", variations=(VariedParameter("alpha", 0.1, 0.5),))
    yield "view-varied"
    document.change("Vary no longer", variations=())


def _docks(window: MainWindow) -> Iterator[str]:
    """Each dock as large as it comes, and all that lie below at their lowest."""
    window.show_workspace("view")
    docks = window.docks
    for name in ("health", "lobes", "jobs", "log"):
        dock: QDockWidget = getattr(docks, name)
        dock.show()
        dock.raise_()
        yield f"dock-{name}"
        below = [each for each in window.findChildren(QDockWidget) if each.isVisible()]
        heights = [each.height() for each in below]
        window.resizeDocks(below, [1] * len(below), Qt.Orientation.Vertical)
        yield f"dock-{name}-lowest"
        window.resizeDocks(below, heights, Qt.Orientation.Vertical)
        dock.hide()
