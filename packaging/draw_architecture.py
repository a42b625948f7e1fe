"""Draw the packages in layers as `resources/architecture.svg`, for ARCHITECTURE.md.

    python packaging/draw_architecture.py

A box is a package. A line leads from a package to one that it imports; of lines that others imply (a imports b,
b imports c, a imports c) only the longest path is drawn, so that the diagram shows the order.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
IMAGE = PROJECT / "resources" / "architecture.svg"

#: Pixels: of a box, and between boxes.
WIDTH, HEIGHT, ACROSS, DOWN, MARGIN = 150, 34, 14, 34, 24

#: An import from one of the packages.
FROM = re.compile(r"^[ \t]*from ((?:engine|app)\b[\w.]*) import ", re.MULTILINE)

Edges = Mapping[str, set[str]]


def packages() -> list[str]:
    """List the packages, named by their first two folders."""
    paths = (path for top in ("engine", "app") for path in (PROJECT / top).rglob("*.py"))
    return sorted({package_of(path) for path in paths if path.name not in {"__init__.py", "__main__.py"}})


def package_of(path: Path) -> str:
    parts = path.relative_to(PROJECT).parent.parts
    return "/".join(parts[:2])


def edges() -> dict[str, set[str]]:
    """Map each package to those that it imports anywhere in its files."""
    found: dict[str, set[str]] = {package: set() for package in packages()}
    for path in (path for top in ("engine", "app") for path in (PROJECT / top).rglob("*.py")):
        package = package_of(path)
        if package not in found:
            continue
        for module in FROM.findall(path.read_text(encoding="utf-8")):
            other = "/".join(module.split(".")[:2])
            if other in found and other != package:
                found[package].add(other)
    return found


def layers(below: Edges) -> dict[str, int]:
    """Number the layer of each package: one above the highest that it imports; `app`, which loads by name, on top."""
    found: dict[str, int] = {}

    def layer(package: str) -> int:
        if package not in found:
            found[package] = 1 + max((layer(other) for other in below[package]), default=-1)
        return found[package]

    for package in below:
        layer(package)
    return found | {"app": 1 + max(found.values())}


def direct(below: Edges) -> dict[str, set[str]]:
    """Drop the imports that others imply."""

    def reach(package: str) -> set[str]:
        return below[package] | {far for near in below[package] for far in reach(near)}

    return {package: below[package] - {far for near in below[package] for far in reach(near)} for package in below}


def draw() -> str:
    below = edges()
    level, near = layers(below), direct(below)
    rows: dict[int, list[str]] = defaultdict(list)
    for package in below:
        rows[level[package]].append(package)
    highest, widest = max(rows), max(len(row) for row in rows.values())
    width = 2 * MARGIN + widest * WIDTH + (widest - 1) * ACROSS
    height = 2 * MARGIN + (highest + 1) * HEIGHT + highest * DOWN
    place: dict[str, tuple[float, float]] = {}
    for row in range(highest + 1):
        ordered = sorted(rows[row], key=lambda package: middle(package, near, place, width))
        left = (width - len(ordered) * WIDTH - (len(ordered) - 1) * ACROSS) / 2
        for i, package in enumerate(ordered):
            place[package] = left + i * (WIDTH + ACROSS), height - MARGIN - HEIGHT - row * (HEIGHT + DOWN)
    lines = [line(place[package], place[other]) for package in below for other in sorted(near[package])]
    boxes = [box(package, *place[package]) for package in below]
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="Inter, Helvetica, Arial, sans-serif" font-size="14">'
    )
    return "\n".join([head, f'<rect width="{width}" height="{height}" fill="#ffffff"/>', *lines, *boxes, "</svg>\n"])


def middle(package: str, near: Edges, place: Mapping[str, tuple[float, float]], width: float) -> float:
    """Return the best position of a package across the diagram: the mean of those that it imports."""
    under = [place[other][0] for other in near[package] if other in place]
    return sum(under) / len(under) if under else width / 2


def line(top: tuple[float, float], bottom: tuple[float, float]) -> str:
    """Draw from the lower edge of one box to the upper edge of another."""
    x0, y0, x1, y1 = top[0] + WIDTH / 2, top[1] + HEIGHT, bottom[0] + WIDTH / 2, bottom[1]
    bend = (y1 - y0) / 2
    return (
        f'<path d="M{x0:.0f} {y0:.0f} C{x0:.0f} {y0 + bend:.0f} {x1:.0f} {y1 - bend:.0f} {x1:.0f} {y1:.0f}" '
        'fill="none" stroke="#8a94a3" stroke-width="1.2"/>'
    )


def box(package: str, x: float, y: float) -> str:
    colour = "#e7effa" if package.startswith("engine") else "#fbeedd"
    return (
        f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}" rx="5" fill="{colour}" stroke="#4b5563"/>'
        f'<text x="{x + WIDTH / 2:.0f}" y="{y + 22:.0f}" text-anchor="middle" fill="#111827">{package}</text>'
    )


if __name__ == "__main__":
    IMAGE.write_text(draw(), encoding="utf-8")
