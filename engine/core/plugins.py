"""Parts that other installed packages bring: BRDF models, readers, exporters and modes, found by their entry points."""

from __future__ import annotations

import logging
from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

log = logging.getLogger(__name__)


def load(group: str, register: Callable[[Any], Any]) -> None:
    """Register what the installed packages declare under the entry points `group`.

    A package that cannot be loaded is named in a warning and changes nothing else.
    """
    for entry in sorted(entry_points(group=group), key=lambda entry: entry.name):
        try:
            register(entry.load())
        except Exception as error:
            package = entry.dist.name if entry.dist is not None else entry.value
            log.warning(
                "The plug-in %s of the package %s cannot be used (%s). Update or uninstall that package.",
                *(entry.name, package, error or type(error).__name__),
            )
