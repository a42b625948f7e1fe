"""The health of everything that the window holds: what it is of, its figures in words, its findings and a verdict."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Any

from app.document import Project
from app.number_field import plain
from app.status_bar import size_text
from engine.files.untrusted import protection
from engine.health import Health, Verdict

#: Units at the end of a figure's name, and how they are written; the longest that fits is taken.
UNITS = (
    ("_bytes", "B"),
    ("_deg", "°"),
    ("_px", "px"),
    ("_ms", "ms"),
    ("_s", "s"),
    ("_rel", "%"),
    ("_percent", "%"),
)

#: Figures that count what is wrong: any of them is worth a look.
COUNTS = re.compile(r"clamp|mask|fill|invalid|non_?finite|reject|negative|degenerate|dropped|clipped|missing")


@dataclass(frozen=True)
class Part:
    """One result and what is known of its numbers."""

    name: str
    health: Health

    @property
    def summary(self) -> str:
        """The worst finding, or that there is none."""
        worst = [each.text for each in self.health.findings if each.verdict == self.health.verdict]
        if worst and self.health.verdict > Verdict.GOOD:
            return worst[0] + (f" (and {len(worst) - 1} more)" if len(worst) > 1 else "")
        return "Nothing to report"


def parts_of(project: Project, reflectance: Any, bakings: Iterable[tuple[str, Any]]) -> list[Part]:
    """Every result of `project` that has a health, the `reflectance` that is drawn, and what is baked (label, bake).

    How files are decoded stands at their end, once one has been.
    """
    material = project.material
    offered: list[tuple[str, Any]] = [
        ("Photographs", project.stack),
        ("Shading map", material.shading_map),
        ("Power law", material.power_law),
        ("Material", None if project.stack is not None else material if project.has_map else None),
        ("Model", project.mesh),
        ("Light", project.environment),
        ("Measured reflectance", material.measured),
        ("Reflectance", reflectance),
    ]
    for label, made in bakings:
        if made is not None:
            offered += [(label, made), (f"{label}: reflectance", getattr(made.transport, "table", None))]
    found: list[Part] = []
    for name, value in offered:
        health = getattr(value, "health", None)
        if isinstance(health, Health) and not any(health is part.health for part in found):
            found.append(Part(name, health))
    if found and (confined := protection()) is not None:
        found.append(Part("Reading of files", confined.health))
    return found


def worst_of(parts: Iterable[Part]) -> Health:
    """All of them together, for one verdict."""
    whole = Health()
    for part in parts:
        whole = whole.merged(part.health)
    return whole


def figures_of(health: Health) -> Iterator[tuple[str, str, bool]]:
    """Each figure as a person reads it: its name, its value with the unit, and whether it counts what is wrong."""
    for name, value in sorted(health.figures.items()):
        words, unit = _named(name)
        is_doubtful = bool(COUNTS.search(name)) and value > 0
        yield words, _valued(100.0 * value if name.endswith("_rel") else value, unit), is_doubtful


def _valued(value: float, unit: str) -> str:
    """A number with its unit, in digits that are read at a glance."""
    if not isfinite(value):
        return "not known" if value != value else "infinite"
    return size_text(value) if unit == "B" else f"{plain(float(f'{value:.4g}'))} {unit}".strip()


def _named(name: str) -> tuple[str, str]:
    """'edge_error_px' → 'Edge error', 'px'."""
    ending, unit = next(((ending, unit) for ending, unit in UNITS if name.endswith(ending)), ("", ""))
    words = name.removesuffix(ending).replace("_", " ").strip() or name
    return f"{words[:1].upper()}{words[1:]}", unit
