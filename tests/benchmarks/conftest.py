"""Benchmarks use the program as a user does, so their tests take the fixtures of its tests."""

from tests.app.conftest import (  # noqa: F401 - fixtures
    _figures_of_the_command_line,
    _no_context_of_others,
    _no_garbage_on_threads_of_jobs,
    _no_qt_warnings,
    _own_folders,
    coarse,
    lightarc,
    photographs,
    qapp,
    window,
)
from tests.engine.conftest import gl  # noqa: F401 - a fixture
