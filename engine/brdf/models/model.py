"""The interface of every BRDF, and the base of the analytic models: one class each, declared once by `register`.

A BRDF value is in 1/sr and does not contain the cosine. Directions are unit vectors in the surface frame (normal +z),
`wi` towards the light, `wo` towards the viewer; the value is 0 where either is at or below the horizon.

A model is a frozen dataclass derived from `Model`. It declares its parameters by `param`, its `name` and `label`, and
its formula; from these follow the command line, forms of the window, files of projects and bundles, fits and plots. Its
GLSL counterpart is one file with the parameters as uniforms: `resources/shaders/brdf/NAME.glsl`, or for a model from
outside the package the file `shader` beside its module. Its sampling lobes and its diffuse part may be stated in closed
form; otherwise they are found from values of `f`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.evaluate import evaluate
from engine.brdf.models.sampling import Lobes, Reflectance
from engine.core.directions import Vectors
from engine.core.params import check

Floats = NDArray[np.float64]

_BLACK = (0.0, 0.0, 0.0)


class Brdf(Protocol):
    """A BRDF. `isotropic` never depends on the parameters, the other two may."""

    @property
    def isotropic(self) -> bool: ...

    @property
    def reciprocal(self) -> bool: ...

    @property
    def energy_conserving(self) -> bool: ...

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Values (..., 3) in 1/sr for unit directions (..., 3) that broadcast against each other."""
        ...


@dataclass(frozen=True)
class DiffusePart:
    """`colour` / π · g(cos θ_i) g(cos θ_o); `grazing` says whether g falls towards grazing, else it is 1."""

    colour: tuple[float, float, float]
    grazing: bool = False

    def gain(self, cosine: ArrayLike) -> NDArray[np.float64]:
        """g (...) of cosines (...), 0 below the horizon where it falls towards it."""
        cosine = np.asarray(cosine, np.float64)
        return 1.0 - (1.0 - 0.5 * np.maximum(cosine, 0.0)) ** 5 if self.grazing else np.ones(cosine.shape)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        above = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
        share = np.where(above, self.gain(wi[..., 2]) * self.gain(wo[..., 2]) / np.pi, 0.0)
        return np.asarray(share[..., None] * np.asarray(self.colour))


class Model(Reflectance):
    """Base of the analytic models.

    Attributes
    ----------
    name : of the model in texts, projects and shaders: lower case, words joined by hyphens.
    label : the name that the window shows.
    form_of : name of the model whose text this one shares (`ggx`), where its parameters tell the two apart.
    shader : file of the GLSL counterpart; None for `resources/shaders/brdf/NAME.glsl`.
    isotropic : as that of `Brdf`. reciprocal, energy_conserving : a model states them, as constants or properties; the
        first is True by default.
    diffuse_parameter : name of the parameter whose value / π is the diffuse part of `f`, "" where none is.
    """

    name: ClassVar[str] = ""
    label: ClassVar[str] = ""
    form_of: ClassVar[str] = ""
    shader: ClassVar[Path | None] = None
    isotropic: ClassVar[bool] = True
    diffuse_parameter: ClassVar[str] = ""

    if TYPE_CHECKING:

        @property
        def reciprocal(self) -> Any:
            """A constant of the class, or a property."""

        @property
        def energy_conserving(self) -> Any:
            """A constant of the class, or a property."""

    else:
        reciprocal = True

    def __post_init__(self) -> None:
        check(self)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        return evaluate(self.formula, wi, wo)

    @property
    def shader_definitions(self) -> dict[str, str]:
        """Definitions of the preprocessor by which a shader leaves out what these parameters do not need.

        Without them the shader is right for all parameters.
        """
        return {}

    def formula(self, wi: Floats, wo: Floats) -> Floats:
        """Values, (3, n) or what broadcasts to it, for components (3, n) of directions above the horizon."""
        raise NotImplementedError

    def sampling_lobes(self) -> Lobes | None:
        """The lobes with their energies, and the diffuse energy; None where tables of `f` are to serve."""
        return None

    def diffuse(self) -> DiffusePart | None:
        """The diffuse part in closed form, None where there is none."""
        return DiffusePart(getattr(self, self.diffuse_parameter)) if self.diffuse_parameter else None

    def glossy(self) -> Brdf | None:
        """The model without its diffuse part, None where that is not in closed form."""
        model: Any = self
        return replace(model, **{self.diffuse_parameter: _BLACK}) if self.diffuse_parameter else None
