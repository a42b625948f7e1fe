"""BRDFs of the parts of a model: each vertex is baked with the BRDF of its part, in the shade of the whole model.

A model that brings materials names the part of each face (`Mesh.part`), and its vertices belong to one part each
(`engine.geometry.parts`). Parts with equal BRDFs are of one kind; tables, factors and lobes are made once for a kind.
A transport file names the parts, the BRDF of each kind, and the part of each vertex.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import MODELS, Brdf, brdf_to_text
from engine.core.cached import cached_property
from engine.core.errors import UsageError
from engine.core.figure_text import count_text
from engine.geometry.mesh import Mesh
from engine.geometry.parts import parts_of_vertices

if TYPE_CHECKING:
    from engine.transport.baking.file import TransportFile

#: Most different BRDFs of one bake: each has tables and textures of its own.
MAX_KINDS = 64

#: Most parts that a file names, and characters of a name and of a BRDF.
MAX_PARTS, MAX_NAME, MAX_TEXT = 1000, 200, 1000


@dataclass(frozen=True, eq=False)
class Kinds:
    """Different BRDFs of the parts of a model.

    Attributes
    ----------
    brdfs : each once. names : of the parts.
    of_part : (parts,) the kind of each part, its number among `brdfs`.
    part : (V,) the part of each vertex of the model.
    colours : (V, 3) of the vertices, which the file keeps for images with maps; None for none.
    """

    brdfs: tuple[Brdf, ...]
    names: tuple[str, ...]
    of_part: NDArray[np.int64]
    part: NDArray[np.int32]
    colours: NDArray[np.float32] | None = None

    @cached_property
    def number(self) -> NDArray[np.int64]:
        """(V,) the kind of each vertex."""
        return self.of_part[self.part]

    @property
    def isotropic(self) -> bool:
        """True if all BRDFs are isotropic."""
        return all(each.isotropic for each in self.brdfs)

    def at(self, vertex: int) -> Brdf:
        """The BRDF of a vertex of the model."""
        return self.brdfs[self.number[vertex]]

    def choose(self, vertices: NDArray[np.int64]) -> Kinds:
        """The same of some vertices alone."""
        return replace(self, part=self.part[vertices])

    def settings(self) -> dict[str, Any]:
        """Settings of a transport file."""
        return {
            "part_names": [name[:MAX_NAME] for name in self.names],
            "part_kinds": self.of_part.tolist(),
            "part_brdfs": [text_of(brdf)[:MAX_TEXT] for brdf in self.brdfs],
        }

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays of a transport file."""
        return {"part": self.part, **({} if self.colours is None else {"colours": self.colours})}


def kinds_of(mesh: Mesh, brdfs: Sequence[Brdf]) -> Kinds | None:
    """The kinds of BRDFs of the parts of `mesh`, one for each of its part names; None where there are no parts.

    UsageError for more than `MAX_KINDS` that differ, or more parts than `MAX_PARTS`.
    """
    if not brdfs:
        return None
    if len(brdfs) != len(mesh.part_names):
        raise ValueError(f"{len(brdfs)} BRDFs do not fit {len(mesh.part_names)} parts")
    part = parts_of_vertices(mesh)
    used = {brdfs[number] for number in np.unique(part)}
    kinds = list(dict.fromkeys(brdf for brdf in brdfs if brdf in used))
    if len(kinds) > MAX_KINDS or len(brdfs) > MAX_PARTS:
        raise UsageError(
            f"the model has {count_text(len(brdfs))} parts with {len(kinds)} different BRDFs; at most "
            f"{count_text(MAX_PARTS)} parts with {MAX_KINDS} are baked: give one --material FILE#NAME or --brdf for all"
        )
    of_part = np.array([kinds.index(brdf) if brdf in used else 0 for brdf in brdfs], np.int64)
    return Kinds(tuple(kinds), mesh.part_names, of_part, part, mesh.colours)


def text_of(brdf: Brdf) -> str:
    """The text that names a BRDF: that of a model with its parameters, or the name of a measurement."""
    return brdf_to_text(brdf) if type(brdf) in MODELS.values() else str(getattr(brdf, "name", ""))


def text_of_bake(brdf: Brdf, kinds: Kinds | None) -> str:
    """The same of a bake, of the BRDFs of all its kinds where there are `kinds`."""
    return text_of(brdf) if kinds is None else " | ".join(map(text_of, kinds.brdfs))


@dataclass(frozen=True, eq=False)
class BakedParts:
    """The parts of a baked model: their `names`, the `kind` of each, and (V,) the `part` of each vertex.

    `colours` are those of the vertices (V, 3); None for white.
    """

    names: tuple[str, ...]
    kind: NDArray[np.int64]
    part: NDArray[np.int32]
    colours: NDArray[np.float32] | None = None


def parts_in(file: TransportFile, vertices: int) -> BakedParts | None:
    """The parts of the model of so many `vertices` in a file; None where it was baked with one BRDF.

    ValueError, KeyError or TypeError where they cannot be.
    """
    if "part_names" not in file.settings:
        return None
    names = tuple(str(name) for name in file.settings["part_names"])
    kinds = len(file.settings["part_brdfs"])
    kind, part = np.array(file.settings["part_kinds"], np.int64), file.arrays["part"]
    if kind.shape != (len(names),) or part.shape != (vertices,) or part.dtype != np.int32 or not len(names):
        raise ValueError("its parts do not fit its model")
    if kind.min() < 0 or kind.max() >= min(kinds, MAX_KINDS):
        raise ValueError("a part has a BRDF that is not there")
    if part.size and not 0 <= part.min() <= part.max() < len(names):
        raise ValueError("a vertex has a part that is not there")
    colours = file.arrays.get("colours")
    if colours is not None and (
        colours.dtype != np.float32 or colours.shape != (vertices, 3) or not np.isfinite(colours).all()
    ):
        raise ValueError("its colours of vertices are none")
    return BakedParts(names, kind, part, colours)


def refuse_another_brdf(file: TransportFile) -> None:
    """UsageError where the parts of the bake in `file` have BRDFs of their own."""
    if "part_names" in file.settings:
        raise UsageError(f"the parts of the model in {file.path} have BRDFs of their own; bake the model with another")
