"""The window on a real display. Without one these tests are skipped; Qt's warnings fail the test that causes them."""

from __future__ import annotations

import argparse
import contextlib
import ctypes
import gc
import os
import sys
from collections.abc import Callable, Collection, Iterator, Sequence
from functools import cache, lru_cache, partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from PySide6.QtCore import (
    QEvent,
    QMessageLogContext,
    QMimeData,
    QPoint,
    QPointF,
    Qt,
    QtMsgType,
    QUrl,
    qInstallMessageHandler,
)
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QApplication, QMenu, QWidget

from app import command_line
from app.viewport.gl_surface import request_format
from app.widgets import theme
from engine.core.figure_text import write_with
from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.images.encode import encode_png
from engine.transport import method

NO_DISPLAY = sys.platform.startswith("linux") and not os.environ.get("DISPLAY")

#: Few points, views, directions and texels in plans, trials and tables; how true they are is checked elsewhere.
COARSE = {
    "engine.planning.effects.estimates.FINE": (12, 2, 16),
    "engine.planning.effects.mode_error.FINE": (12, 2, 16),
    "engine.planning.effects.lobe_error.PAIRS": (4, 4, 4),
    "engine.planning.effects.lobe_error.PIXELS": 4,
    "engine.planning.choices.SAMPLES": 4,
    "engine.planning.plan.SMALL": ((),),
    "engine.render.environment_error.REFERENCE_ROWS": 16,
    "engine.transport.gaussian.bake.PROBE_VIEWS": 2,
    "engine.transport.gaussian.bake.TEST_EDGE": 16,
    "engine.transport.wavelet.bake.MAP_SIZE": 16,
    "engine.transport.sh.brdf_table.SAMPLES": 256,
    "engine.transport.sh.brdf_table.SAMPLES_OF_MAP": 128,
}

#: Few pixels of the window's references, and pauses that nobody has to wait for.
AT_ONCE = {
    "engine.exchange.loss.DIAMETER": 40,
    "app.document.measured.MAX_PIXELS": 6_000,
    "app.view.images.MAX_PIXELS": 20_000,
    "app.view.tab.MEASURED_PX": (96, 72),
    "app.view.tab.AT_REST_MS": 20,
    "app.view.planning.AT_REST_MS": 20,
    "app.view.images.SETTLED_MS": 20,
    "app.viewport.viewport.STILL_AFTER_MS": 20,
    "app.viewport.gl_surface.FADE_S": 0.02,
    "app.factor.preview.AT_REST_MS": 20,
    "app.factor.tab.SHOW_EVERY_MS": 20,
    "app.factor.tab.PREVIEW_EVERY_MS": 20,
    "app.brdf.tab.AT_REST_MS": 20,
    "app.brdf.lobe_view.STILL_AFTER_MS": 20,
}

#: Workspaces behind Capture and View that the tests of a package have from the beginning; the others have none of them.
IN_FRONT: dict[str, tuple[str, ...]] = {
    "brdf": ("brdf",),
    "export": ("export",),
    "factor": ("factor",),
    "material": ("material",),
}

#: Files whose tests are about all workspaces and have them from the beginning.
WHOLE = (
    "test_focus.py",
    "test_keys_and_themes.py",
    "test_manual.py",
    "test_random_gestures.py",
    "test_tour.py",
)

#: Files whose tests look at what the viewport shows, which is drawn there as finely as for a user.
LOOKED_AT = (
    "app/test_another_method.py",
    "view/test_baking.py",
    "view/test_error_line.py",
    "view/test_gaussian.py",
    "view/test_light_panel.py",
    "view/test_lobe_inspector.py",
    "view/test_tab.py",
    "window/test_keys_and_themes.py",
    "window/test_main_window.py",
)

#: Files beside `WHOLE` whose tests look at sizes, places or colours of widgets, which the style sheet makes; in other
#: files such tests are marked `dressed`.
DRESSED = (
    "app/test_faults.py",
    "app/test_filled.py",
    "capture/test_calibration.py",
    "capture/test_sphere_tool.py",
    "view/test_tab.py",
    "window/test_dialogs.py",
    "window/test_main_window.py",
)

BUILD_PARSER = command_line.build_parser

#: Qt messages about the machine, not about this program.
HARMLESS = ("propagateSizeHints", "XDG_RUNTIME_DIR", "QStandardPaths", "Detected locale", "iCCP")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        needs_display = {"qapp", "qtbot"} & set(getattr(item, "fixturenames", ()))
        if NO_DISPLAY and needs_display:
            item.add_marker(pytest.mark.skip(reason="DISPLAY is not set: window tests need an X display (Xvfb)"))


@pytest.fixture(scope="session")
def qapp() -> Iterator[QApplication]:
    """The one application, dressed as in a real start."""
    request_format()
    application = QApplication.instance() or QApplication(["lightarc"])
    assert isinstance(application, QApplication)
    theme.apply(application, "dark")
    return application  # type: ignore[return-value]


@pytest.fixture(autouse=True)
def _own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Working data and settings of a test stay in its own folder."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))


@pytest.fixture(autouse=True)
def _no_context_of_others() -> None:
    """Give up the EGL context that another test may have left current, beside which Qt can make none of its own."""
    with contextlib.suppress(OSError):
        ctypes.CDLL("libEGL.so.1").eglReleaseThread()


@pytest.fixture(autouse=True)
def _no_garbage_on_threads_of_jobs() -> Iterator[None]:
    """Cycles are searched for between tests, on the main thread, as the window does (`app.process.garbage`)."""
    gc.disable()
    yield
    gc.enable()


@pytest.fixture(autouse=True)
def _figures_of_the_command_line() -> Iterator[None]:
    """A window writes figures in its own form from when it is made; what follows is not to notice."""
    yield
    write_with(".")


@pytest.fixture(autouse=True)
def _no_qt_warnings() -> Iterator[None]:
    said: list[str] = []

    def listen(kind: QtMsgType, _context: QMessageLogContext, words: str) -> None:
        if kind in (QtMsgType.QtWarningMsg, QtMsgType.QtCriticalMsg) and not any(word in words for word in HARMLESS):
            said.append(words)

    before = qInstallMessageHandler(listen)
    yield
    qInstallMessageHandler(before)
    assert not said, "\n".join(said)


@pytest.fixture(scope="session")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of five small photographs of stripes that brighten with the light's elevation."""
    folder = tmp_path_factory.mktemp("capture") / "Felt sample"
    folder.mkdir()
    noise = np.random.default_rng(5).normal(0.0, 0.01, (96, 128, 3))
    rows, columns = np.mgrid[0:96, 0:128]
    weave = 0.5 + 0.35 * np.sin(rows / 3.0) * np.sin(columns / 4.0)
    tint = np.array([0.9, 0.7, 0.5])
    for angle in (10, 30, 50, 70, 90):
        share = np.sin(np.radians(angle))
        radiance = share * tint * weave[..., None] ** (2.0 - share) + noise * share
        (folder / f"felt_{angle}deg.png").write_bytes(
            encode_png(np.array(np.clip(radiance, 0, 1) ** (1 / 2.2) * 65535, np.uint16))
        )
    return folder


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Plans, trial bakes and tables are coarse (`COARSE`), and of a scene that an earlier test planned remembered."""
    from engine.planning.effects.sample import sample

    monkeypatch.setattr("engine.planning.effects.estimates.sample", partial(sample, points=24))
    monkeypatch.setattr("engine.planning.plan.scenery", _look_once)
    for name, value in COARSE.items():
        monkeypatch.setattr(name, value)


def _look_once(mesh: Mesh, brdf: Any, environment: Any, *, variations: Sequence[Any] = (), **place: Any) -> Any:
    """Take the samples of a scene, once for the same objects where nothing varies."""
    from engine.planning.effects.estimates import scenery

    if variations:
        return scenery(mesh, brdf, environment, variations=variations, **place)
    return _remembered(mesh, brdf, environment, **place)


@lru_cache(maxsize=16)
def _remembered(mesh: Mesh, brdf: Any, environment: Any, **place: Any) -> Any:
    from engine.planning.effects.estimates import scenery

    return scenery(mesh, brdf, environment, **place)


@pytest.fixture
def window(
    qapp: QApplication,
    qtbot: object,
    coarse: None,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
) -> Iterator[object]:
    """The main window without remembered settings, closed at the end; an error that nobody expected fails the test, and
    so does a project that cannot be written.

    To make all workspaces takes two thirds of its time; those that `IN_FRONT` leaves out are made when they are asked
    for.

    What this machine costs is made up, since measuring it takes longer than most tests. The error of the image is
    measured only where a test asks for it (`window.view.pictures.measure`): it takes a reference.
    """
    from app.window.top_bar import WORKSPACES

    file = f"{request.path.parent.name}/{request.path.name}"
    if file not in LOOKED_AT:
        monkeypatch.setattr("app.viewport.viewport.IDLE_S", 0.0)  # the first, coarse image will do
    names = WORKSPACES if request.path.name in WHOLE else IN_FRONT.get(request.path.parent.name, ())
    is_dressed = file in DRESSED or request.path.name in WHOLE or request.node.get_closest_marker("dressed")
    with contextlib.nullcontext() if is_dressed else undressed(qapp), open_window(monkeypatch, names) as made:
        qtbot.waitExposed(made)  # type: ignore[attr-defined]
        yield made


@contextlib.contextmanager
def undressed(application: QApplication) -> Iterator[None]:
    """Widgets in here have Qt's own look, in which a window is made and drawn in four fifths of the time."""
    sheet = application.styleSheet()
    application.setStyleSheet("")
    try:
        yield
    finally:
        application.setStyleSheet(sheet)


@contextlib.contextmanager
def open_window(monkeypatch: pytest.MonkeyPatch, names: Collection[str]) -> Iterator[Any]:
    """The main window with the workspaces `names` from the beginning, shown, and closed at the end."""
    from app.window.main_window import MainWindow
    from app.window.top_bar import WORKSPACES

    unwritten: list[Path] = []
    monkeypatch.setattr("app.window.projects.Projects._rescue", lambda projects: unwritten.append(projects.path))
    monkeypatch.setattr("app.session.machine_profile.cost_model", _costs)
    for name, value in AT_ONCE.items():
        monkeypatch.setattr(name, value)
    if names is not WORKSPACES:
        monkeypatch.setattr(MainWindow, "make_next", lambda _window: None)
    # Each workspace that is made by itself would dress the whole window anew.
    with theme.dressing_at_once():
        made = MainWindow(None)
        for name in names:
            getattr(made, name)
    made.view.images.measure(False)
    made.show()
    yield made
    for box in tuple(made.failures.open_dialogs.values()):
        box.close()
    made.files.leaving.stop_others()  # nobody is there to be asked
    made.close()
    made.deleteLater()
    for left in QApplication.topLevelWidgets():
        if isinstance(left, QMenu):  # those of buttons have no parent, and each theme would dress them again
            left.deleteLater()
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    assert not unwritten, "the project could not be written when the window closed"


def _costs(*, anew: bool = False) -> Steps[object]:
    from engine.planning.costs.cost_model import NAMES, CostModel

    yield Step(float(anew), "the costs of this machine are made up")
    return CostModel("test", "test", dict.fromkeys(NAMES, ((1.0, 1e-6),)))


@pytest.fixture
def drop() -> Callable[[QWidget, list[Path]], None]:
    """Drop files on a widget, with the event that a file manager sends."""

    def send(widget: QWidget, paths: list[Path]) -> None:
        data = QMimeData()
        data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
        place = QPointF(QPoint(widget.width() // 2, widget.height() // 2))
        none = Qt.KeyboardModifier.NoModifier
        copy, left = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
        for event in (
            QDragEnterEvent(place.toPoint(), copy, data, left, none),
            QDropEvent(place, copy, data, left, none),
        ):
            QApplication.sendEvent(widget, event)
            assert event.isAccepted()

    return send


@pytest.fixture
def mesh(tmp_path: Path) -> Path:
    """A tetrahedron."""
    path = tmp_path / "tetrahedron.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    return path


@cache
def _parser(_verbs: object, _methods: object) -> argparse.ArgumentParser:
    """The parser of these verbs and transport methods, which it takes some time to build."""
    return BUILD_PARSER()


@pytest.fixture
def lightarc(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[..., SimpleNamespace]:
    """Runs the command line in this process; gives exit code, standard output and standard error."""
    monkeypatch.setattr(command_line, "build_parser", lambda _only: _parser(command_line.VERBS, method.METHODS))

    def run(*words: object) -> SimpleNamespace:
        try:
            code = command_line.main(list(map(str, words)))
        except SystemExit as stop:
            code = cast(Any, stop.code)
        return SimpleNamespace(code=code, **dict(zip(("out", "err"), capsys.readouterr(), strict=True)))

    return run
