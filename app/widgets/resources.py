"""The folder of resources and the colours of lines, for modules that work without Qt."""

from __future__ import annotations

from pathlib import Path

RESOURCES = Path(__file__).resolve().parents[2] / "resources"

#: Okabe and Ito's colour-vision-safe lines, in the order in which plots use them.
LINES = ("#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#d55e00", "#f0e442")
