"""The built-in capture: simulated when File > Rebuild sample first asks for it, and kept beside the user's projects.

File > Sample capture opens the woven cloth of `app.start.examples` instead, which is shipped ready-made.
"""

from __future__ import annotations

from pathlib import Path

from app.project.places import projects_folder
from engine.capture.lights.sources import Sources, find
from engine.core.steps import Steps
from engine.simulate.built_in import make_built_in_sample

NAME = "Woven sample"


def samples_folder() -> Path:
    """The folder of the built-in capture; it may not exist."""
    return projects_folder().parent / "sample capture"


def capture_of_sample(folder: Path) -> Steps[Sources]:
    """The photographs of the built-in capture, simulated into `folder` where they are not there."""
    capture = yield from make_built_in_sample(folder)
    return find([capture])
