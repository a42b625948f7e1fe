"""Draw the rooms of the program as `resources/rooms.svg`, for ARCHITECTURE.md: floors as in tests/test_rooms.py.

    python packaging/rooms.py

A box is a room with its number of modules. A line leads from a room to one that it imports; of lines that others
imply (a imports b, b imports c, a imports c) only the longest way is drawn, so that the image shows the order.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
IMAGE = PROJECT / "resources" / "rooms.svg"

#: Pixels: of a box, and between boxes.
WIDTH, HEIGHT, ACROSS, DOWN, MARGIN = 150, 40, 14, 34, 24

Edges = Mapping[str, set[str]]


def rooms() -> dict[str, int]:
    """Every room, named by its two first folders, and the modules in it and in the rooms within."""
    found: dict[str, int] = defaultdict(int)
    for path in sorted(path for top in ("engine", "app") for path in (PROJECT / top).rglob("*.py")):
        if path.name not in {"__init__.py", "__main__.py"}:
            found[room_of(path)] += 1
    return dict(found)


def room_of(path: Path) -> str:
    parts = path.relative_to(PROJECT).parent.parts
    return "/".join(parts[:2])


def edges() -> dict[str, set[str]]:
    """Room → the rooms that it imports anywhere in its files."""
    found: dict[str, set[str]] = {room: set() for room in rooms()}
    for path in (path for top in ("engine", "app") for path in (PROJECT / top).rglob("*.py")):
        room = room_of(path)
        if room not in found:
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module:
                other = "/".join(node.module.split(".")[:2])
                if other in found and other != room:
                    found[room].add(other)
    return found


def floors(below: Edges) -> dict[str, int]:
    """The floor of each room: one above the highest of those that it imports; the entry, which loads by name, on
    top.
    """
    found: dict[str, int] = {}

    def floor(room: str) -> int:
        if room not in found:
            found[room] = 1 + max((floor(other) for other in below[room]), default=-1)
        return found[room]

    for room in below:
        floor(room)
    return found | {"app": 1 + max(found.values())}


def direct(below: Edges) -> dict[str, set[str]]:
    """Without the imports that others imply."""

    def reach(room: str) -> set[str]:
        return below[room] | {far for near in below[room] for far in reach(near)}

    return {room: below[room] - {far for near in below[room] for far in reach(near)} for room in below}


def draw() -> str:
    sizes, below = rooms(), edges()
    level, near = floors(below), direct(below)
    rows: dict[int, list[str]] = defaultdict(list)
    for room in sizes:
        rows[level[room]].append(room)
    highest, widest = max(rows), max(len(row) for row in rows.values())
    width = 2 * MARGIN + widest * WIDTH + (widest - 1) * ACROSS
    height = 2 * MARGIN + (highest + 1) * HEIGHT + highest * DOWN
    place: dict[str, tuple[float, float]] = {}
    for row in range(highest + 1):
        ordered = sorted(rows[row], key=lambda room: middle(room, near, place, width))
        left = (width - len(ordered) * WIDTH - (len(ordered) - 1) * ACROSS) / 2
        for i, room in enumerate(ordered):
            place[room] = left + i * (WIDTH + ACROSS), height - MARGIN - HEIGHT - row * (HEIGHT + DOWN)
    lines = [line(place[room], place[other]) for room in sizes for other in sorted(near[room])]
    boxes = [box(room, sizes[room], *place[room]) for room in sizes]
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="Inter, Helvetica, Arial, sans-serif" font-size="14">'
    )
    return "\n".join([head, f'<rect width="{width}" height="{height}" fill="#ffffff"/>', *lines, *boxes, "</svg>\n"])


def middle(room: str, near: Edges, place: Mapping[str, tuple[float, float]], width: float) -> float:
    """The best place of a room across the image: the mean of the rooms that it imports."""
    under = [place[other][0] for other in near[room] if other in place]
    return sum(under) / len(under) if under else width / 2


def line(top: tuple[float, float], bottom: tuple[float, float]) -> str:
    """From the lower edge of one box to the upper edge of another."""
    x0, y0, x1, y1 = top[0] + WIDTH / 2, top[1] + HEIGHT, bottom[0] + WIDTH / 2, bottom[1]
    bend = (y1 - y0) / 2
    return (
        f'<path d="M{x0:.0f} {y0:.0f} C{x0:.0f} {y0 + bend:.0f} {x1:.0f} {y1 - bend:.0f} {x1:.0f} {y1:.0f}" '
        'fill="none" stroke="#8a94a3" stroke-width="1.2"/>'
    )


def box(room: str, size: int, x: float, y: float) -> str:
    colour = "#e7effa" if room.startswith("engine") else "#fbeedd"
    return (
        f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}" rx="5" fill="{colour}" stroke="#4b5563"/>'
        f'<text x="{x + WIDTH / 2:.0f}" y="{y + 18:.0f}" text-anchor="middle" fill="#111827">{room}</text>'
        f'<text x="{x + WIDTH / 2:.0f}" y="{y + 33:.0f}" text-anchor="middle" fill="#6b7280" font-size="11">'
        f"{size} {'module' if size == 1 else 'modules'}</text>"
    )


if __name__ == "__main__":
    IMAGE.write_text(draw(), encoding="utf-8")
