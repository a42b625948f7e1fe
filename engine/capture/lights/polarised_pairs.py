"""Pairs of photographs under parallel and crossed polarisers: which photograph is which, and which two belong together.

File names tell by a part of their own (`img_001_par.tif`, `img_001_cross.tif`), or the names of two folders do
(`parallel`, `crossed`). Photographs of two folders belong together by equal names, else in the order of the names. The
photograph without its part, or the parallel one, is what the list of lights and all else is about.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from engine.capture.lights.file_names import comparable, join_names, natural
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict

#: Parts of names by which photographs under parallel and under crossed polarisers are known.
PARALLEL = frozenset(("par", "parallel", "ppol", "pp", "copol", "copolarised", "copolarized"))
CROSSED = frozenset(
    ("cross", "crossed", "crosspol", "crosspolarised", "crosspolarized", "xpol", "xp", "cpol", "cp", "perp")
)

_PARTS = re.compile(r"[^\W_]{1,255}")


@dataclass(frozen=True)
class PolarisedPairs:
    """The photographs under parallel polarisers, by each of them the one under crossed ones, and what to say of it."""

    parallel: tuple[Path, ...]
    crossed: Mapping[Path, Path]
    findings: tuple[Finding, ...]


def pair_by_names(photographs: Sequence[Path]) -> PolarisedPairs | None:
    """Pairs of which file names tell, None where they do not.

    Raises InputError where most names tell and photographs are left over.
    """
    kinds = [_kind(path.stem) for path in photographs]
    sides: tuple[dict[tuple[str, ...], Path], dict[tuple[str, ...], Path]] = ({}, {})
    for path, (crossed, rest) in zip(photographs, kinds, strict=True):
        if crossed is None or rest in sides[crossed]:
            return None
        sides[crossed][rest] = path
    parallel, crossed_ones = sides
    both = parallel.keys() & crossed_ones.keys()
    if not both or not parallel or not crossed_ones:
        return None
    alone = [path.name for side in sides for rest, path in side.items() if rest not in both]
    if alone:
        problem = f"holds photographs under parallel and crossed polarisers, but {join_names(alone)} has no counterpart"
        raise InputError(photographs[0].parent, problem, "Add the counterpart, or take it out of the folder")
    return _describe_pairs({path: crossed_ones[rest] for rest, path in parallel.items()}, "their file names")


def pair_of_folders(parallel: Sequence[Path], crossed: Sequence[Path], place: Path) -> PolarisedPairs:
    """Photographs of two folders as pairs. InputError about `place` where these are not as many."""
    if len(parallel) != len(crossed):
        problem = f"holds {len(crossed)} photographs under crossed polarisers and {len(parallel)} under parallel ones"
        raise InputError(place, problem, "Give one crossed photograph for each parallel one")
    by_name = {comparable(path.name): path for path in crossed}
    if by_name.keys() == {comparable(path.name) for path in parallel}:
        return _describe_pairs(
            {path: by_name[comparable(path.name)] for path in parallel}, "the folders, and equal names"
        )
    by_part = {_kind(path.stem)[1]: path for path in crossed}
    if len(by_part) == len(crossed) and by_part.keys() == {_kind(path.stem)[1] for path in parallel}:
        return _describe_pairs(
            {path: by_part[_kind(path.stem)[1]] for path in parallel}, "the folders, and their names"
        )
    ordered = (sorted(paths, key=lambda path: natural(path.name)) for paths in (parallel, crossed))
    return _describe_pairs(dict(zip(*ordered, strict=True)), "the folders, in the order of their names")


def folders_of_pairs(names: Sequence[str]) -> tuple[str, str] | None:
    """The names of the folders of parallel and of crossed photographs among `names`, None where there are not both."""
    kinds = [(_kind(name)[0], name) for name in names]
    sides = [[name for kind, name in kinds if kind is wanted] for wanted in (False, True)]
    return (sides[0][0], sides[1][0]) if [len(side) for side in sides] == [1, 1] else None


def _kind(stem: str) -> tuple[bool | None, tuple[str, ...]]:
    """Whether a name says crossed (True) or parallel (False), None for neither or both; and its other parts."""
    parts = tuple(_PARTS.findall(comparable(stem).casefold().replace("-pol", "pol")))
    said = {part in CROSSED for part in parts if part in PARALLEL | CROSSED}
    rest = tuple(part for part in parts if part not in PARALLEL | CROSSED)
    return (said.pop() if len(said) == 1 else None), rest


def _describe_pairs(crossed: Mapping[Path, Path], by: str) -> PolarisedPairs:
    first = next(iter(crossed.items()))
    text = (
        f"{len(crossed)} pairs under parallel and crossed polarisers were identified by {by}: {first[0].name} is "
        f"parallel, {first[1].parent.name}/{first[1].name} is crossed"
        if first[0].name == first[1].name
        else f"{len(crossed)} pairs under parallel and crossed polarisers were identified by {by}: {first[0].name} is "
        f"parallel, {first[1].name} is crossed"
    )
    return PolarisedPairs(tuple(crossed), crossed, (Finding(Verdict.NOTE, text),))
