"""Files of shaders: those in `resources/shaders`, and those that BRDF models from outside the package bring."""

from __future__ import annotations

from pathlib import Path

SHADERS = Path(__file__).resolve().parents[2] / "resources" / "shaders"

_added: dict[str, Path] = {}


def add(name: str, path: Path | None) -> None:
    """Let `name`, as `brdf/minnaert.glsl`, stand for the file `path`; with None the file is in `SHADERS`.

    Raises ValueError where there is no such file.
    """
    place = SHADERS / name if path is None else Path(path)
    if not place.is_file():
        raise ValueError(f"there is no shader file {place}")
    if path is not None:
        _added[name] = place


def remove(name: str) -> None:
    """Take back what `add` did."""
    _added.pop(name, None)


def find(name: str, folder: Path = SHADERS) -> Path:
    """The file of a shader by its name in `folder`, or the one that was added under this name."""
    return _added.get(name, folder / name)
