"""Baked light in the View workspace: what a bake would take, the bake, and what it makes of each new light.

For each method one bake is kept, in the working folder of the run. It belongs to a model on a ground and, but for
harmonics, which can have another reflectance tabulated, to a reflectance. Estimates, bakes and light all come from
jobs; of the light only the newest matters, and until it is there the picture keeps the one before.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from PySide6.QtCore import QObject, Signal

from app.jobs import Job
from app.latest import Latest
from app.workbench import Workbench
from engine.brdf.brdf import Brdf
from engine.ground import Ground
from engine.mesh import Mesh
from engine.scene import Scene
from engine.steps import Step, Steps, part

if TYPE_CHECKING:
    from engine.lamps import Lamp
    from engine.transport.lit import Lit
    from engine.transport.sh import Window
    from engine.transport.sh_transfer import ShTransport
    from engine.transport.wavelet_relight import Relighter

Method = Literal["sh", "wavelet", "gaussian"]

WORDS: dict[Method, str] = {"sh": "Baking harmonics", "wavelet": "Baking wavelets", "gaussian": "Baking Gaussians"}

NAMES: dict[Method, str] = {"sh": "harmonics", "wavelet": "wavelets", "gaussian": "Gaussians"}


@dataclass(frozen=True)
class BakeChoices:
    """What is chosen for the next bake, and for the light on it.

    Attributes
    ----------
    order : bands of harmonics.
    interreflection : with light that comes by way of the model; of harmonics and Gaussians.
    window : what damps high bands of harmonics against ringing. It belongs to the light, and asks for no bake.
    terms : of the factors of wavelets.
    coefficients : wavelets kept for each vertex and term.
    edge : texels along a face of the wavelets' light.
    occluder_cells : cells in which what shades wavelets is simplified; 0 for the model itself.
    lobes : Gaussians for each vertex and view.
    """

    order: int = 5
    interreflection: bool = False
    window: Window = "none"
    terms: int = 4
    coefficients: int = 96
    edge: int = 64
    occluder_cells: int = 0
    lobes: int = 1

    @property
    def baked(self) -> BakeChoices:
        """The same where nothing is chosen of the light."""
        return replace(self, window="none")


@dataclass(frozen=True, eq=False)
class Wanted:
    """What a bake would be of."""

    mesh: Mesh
    ground: Ground | None
    brdf: Brdf
    choices: BakeChoices

    def is_as(self, other: Wanted | None) -> bool:
        return other is not None and self.fits(other) and (self.brdf, self.choices) == (other.brdf, other.choices)

    def fits(self, other: Wanted) -> bool:
        """Whether both are of one surface."""
        return self.mesh is other.mesh and self.ground == other.ground


@dataclass(frozen=True, eq=False)
class Estimate:
    """A bake that could begin: its work, and the seconds and bytes that it would take; or why it cannot."""

    wanted: Wanted
    work: Any
    bake_s: float
    why_not: str = ""

    @property
    def size_bytes(self) -> int:
        return int(self.work.size_bytes) if self.work is not None else 0


@dataclass(frozen=True, eq=False)
class Made:
    """A finished bake: `engine.transport` of one method, and what it took."""

    wanted: Wanted
    transport: Any
    bake_s: float
    size_bytes: int

    @cached_property
    def relighter(self) -> Relighter:
        """Of wavelets: what keeps of one light what is the same under the next."""
        from engine.transport.wavelet_relight import Relighter

        return Relighter(self.transport)


class Baking(QObject):
    """One method's bake. `changed` follows what there is to say of it, `lit_changed` each light that can be drawn."""

    changed = Signal()
    lit_changed = Signal()

    def __init__(self, bench: Workbench, method: Method) -> None:
        super().__init__()
        self.bench, self.method = bench, method
        self.choices = BakeChoices()
        self.estimate: Estimate | None = None
        self.made: Made | None = None
        self.job: Job | None = None
        self._wanted: Wanted | None = None
        self._scene: Scene | None = None
        self._asked: Wanted | None = None
        self._lit: tuple[Wanted, Lit] | None = None
        self._light: tuple[Scene, Window] | None = None
        self._estimating = Latest(bench.jobs, "Estimating a bake")
        self._lighting = Latest(bench.jobs, "Relighting")
        self._tabled: tuple[Brdf, ShTransport] | None = None

    def want(self, scene: Scene) -> None:
        """Show `scene`: have its light ready where its bake is, or say what that would take."""
        self._wanted, self._scene = Wanted(scene.mesh, scene.ground, scene.brdf, self.choices.baked), scene
        if self._usable(self._wanted):
            self._relight(scene)
        if not self.is_made and self.job is None:
            self._ask(self._wanted)
        self.changed.emit()

    def choose(self, choices: BakeChoices) -> None:
        """Bake the next time with these choices."""
        self.choices = choices
        if self._wanted is not None:
            self._wanted = replace(self._wanted, choices=choices.baked)
            if not self.is_made and self.job is None:
                self._ask(self._wanted)
            if self._scene is not None and self._usable(self._wanted):
                self._relight(self._scene)
        self.changed.emit()

    @property
    def is_made(self) -> bool:
        """Whether the picture is what the bake that is wanted would give."""
        made, wanted = self.made, self._wanted
        return (
            made is not None
            and self._usable(wanted)
            and wanted is not None
            and made.wanted.choices == self.choices.baked
        )

    @property
    def is_drawn(self) -> bool:
        """Whether the picture shows a bake, if one of other choices."""
        return self._usable(self._wanted)

    def is_drawable(self, scene: Scene) -> bool:
        """Whether the bake that there is can be drawn of `scene`."""
        return self._usable(Wanted(scene.mesh, scene.ground, scene.brdf, self.choices.baked))

    def _usable(self, wanted: Wanted | None) -> bool:
        return self.made is not None and wanted is not None and not self._why_stale(self.made, wanted)

    @property
    def why_stale(self) -> str:
        """Why the bake that there is cannot be drawn; empty where it can, or where there is none."""
        return self._why_stale(self.made, self._wanted) if self.made is not None and self._wanted is not None else ""

    def _why_stale(self, made: Made, wanted: Wanted) -> str:
        if made.wanted.mesh is not wanted.mesh:
            return "The model is another one than was baked."
        if not made.wanted.fits(wanted):
            return "The ground is another one than was baked."
        if made.wanted.brdf == wanted.brdf:
            return ""
        if self.method != "sh":
            return f"The reflectance is another one, and {NAMES[self.method]} are baked for one."
        if made.transport.interreflection:
            return "The reflectance is another one, and light from the model itself was baked for one."
        matt = made.transport.diffuse
        return "A matt model was baked, which holds nothing of the view." if matt else ""

    def lit(self, scene: Scene) -> Lit | None:
        """What can be drawn of `scene`: its light, or the light before while its own is on the way."""
        if self._lit is None or self.made is None or self._lit[0] is not self.made.wanted:
            return None
        return self._lit[1] if self.is_drawable(scene) else None

    def _ask(self, wanted: Wanted) -> None:
        if not wanted.is_as(self._asked):
            self._asked, self.estimate = wanted, None
            self._estimating.ask(lambda: _estimated(self.method, wanted), self._keep_estimate)

    def _keep_estimate(self, estimate: Estimate) -> None:
        if estimate.wanted.is_as(self._asked):
            self.estimate = estimate
            self.changed.emit()

    def bake(self) -> None:
        """Bake what was estimated; an equal bake that was cancelled goes on where it stopped."""
        estimate = self.estimate
        if estimate is None or estimate.why_not or self.job is not None:
            return
        path = self.bench.folder / f"baked-{self.method}.transport"
        job = self.bench.jobs.submit(WORDS[self.method], lambda: _baked(self.method, path, estimate))
        self.job = job
        job.succeeded.connect(self._keep)
        job.failed.connect(lambda _error: self._ended())
        job.cancelled.connect(self._ended)
        job.progressed.connect(lambda _step: self.changed.emit())
        self.changed.emit()

    def cancel(self) -> None:
        """Stop the bake; what is done of it is kept for the next."""
        if self.job is not None:
            self.bench.jobs.cancel(self.job)

    def _keep(self, made: Made) -> None:
        self.made, self._lit, self._light, self._tabled = made, None, None, None
        self._ended()
        self.lit_changed.emit()

    def _ended(self) -> None:
        self.job = self._asked = None
        self.changed.emit()

    def _relight(self, scene: Scene) -> None:
        """Work out the light of `scene` for the bake, unless it is there or under way."""
        made = self.made
        assert made is not None
        window = self.choices.window
        before = self._light
        if before is not None and before[1] == window and _same_light(before[0], scene, self.method):
            return
        self._light = (scene, window)
        self._lighting.ask(
            lambda: _lit(self.method, made, scene, self._tabled, window), lambda lit: self._take(made, scene, lit)
        )

    def _take(self, made: Made, scene: Scene, lit: Lit) -> None:
        if made is self.made:
            if self.method == "sh":
                self._tabled = (scene.brdf, lit.transport)  # type: ignore[assignment]
            self._lit = (made.wanted, lit)
            self.lit_changed.emit()


def _same_light(one: Scene, other: Scene, method: Method) -> bool:
    names = ["light", "irradiance", "environment", "environment_rotation", "lamps"] + ["brdf"] * (method == "sh")
    return all(getattr(one, name) == getattr(other, name) for name in names)


def _estimated(method: Method, wanted: Wanted) -> Steps[Estimate]:
    yield Step(0.0, "preparing kernels")
    try:
        return (yield from ESTIMATES[method](wanted))
    except ValueError as reason:
        return Estimate(wanted, None, 0.0, f"{str(reason)[:1].upper()}{str(reason)[1:]}.")


def _estimated_sh(wanted: Wanted) -> Steps[Estimate]:
    from engine.transport import sh_bake

    settings = sh_bake.BakeSettings(wanted.choices.order, bounces=int(wanted.choices.interreflection))
    work = yield from part(sh_bake.prepare(wanted.mesh, wanted.brdf, settings, wanted.ground), 0.0, 0.8)
    return Estimate(wanted, work, sh_bake.estimate_s(work))


def _estimated_wavelets(wanted: Wanted) -> Steps[Estimate]:
    from engine.transport import wavelet_bake

    choices = wanted.choices
    factors = yield from part(wavelet_bake.factors_for(wanted.brdf, choices.terms), 0.0, 0.8)
    settings = wavelet_bake.BakeSettings(choices.edge, choices.coefficients, occluder_cells=choices.occluder_cells)
    work = wavelet_bake.prepare(wanted.mesh, factors, settings, wanted.ground)
    yield Step(0.8, "estimating")
    return Estimate(wanted, work, wavelet_bake.estimate_s(work))


def _estimated_gaussians(wanted: Wanted) -> Steps[Estimate]:
    from engine.transport import gaussian_bake

    settings = gaussian_bake.BakeSettings(wanted.choices.lobes, indirect=wanted.choices.interreflection)
    work = yield from gaussian_bake.prepare(wanted.mesh, wanted.brdf, settings, wanted.ground)
    return Estimate(wanted, work, gaussian_bake.estimate_s(work))


ESTIMATES: dict[Method, Callable[[Wanted], Steps[Estimate]]] = {
    "sh": _estimated_sh,
    "wavelet": _estimated_wavelets,
    "gaussian": _estimated_gaussians,
}


def _baked(method: Method, path: Path, estimate: Estimate) -> Steps[Made]:
    yield Step(0.0, "preparing kernels")
    bake: Any
    if method == "sh":
        from engine.transport.sh_bake import bake
    elif method == "wavelet":
        from engine.transport.wavelet_bake import bake
    else:
        from engine.transport.gaussian_bake import bake
    made = yield from bake(path, estimate.work)
    return Made(estimate.wanted, made.transport, made.bake_s, made.file.size_bytes)


def _lit(
    method: Method, made: Made, scene: Scene, tabled: tuple[Brdf, ShTransport] | None, window: Window
) -> Steps[Lit]:
    """The light of `scene` on what was baked; `tabled` is the transport of the reflectance before."""
    yield Step(0.0, "preparing kernels")
    from engine.transport.lit import LitHarmonics, LitWavelets

    if method == "wavelet":
        rows = _tuples(made, scene)
        return LitWavelets(made.transport, rows)
    if method == "gaussian":
        return _lobes_under(made, scene)
    from engine.transport.sh import windowed
    from engine.transport.sh_lighting import scene_coefficients
    from engine.transport.sh_transfer import transferred

    transport: ShTransport = made.transport
    if tabled is not None and tabled[0] == scene.brdf:
        transport = tabled[1]
    elif made.wanted.brdf != scene.brdf:
        transport = yield from _with_brdf(transport, scene.brdf)
    transport.mesh.tangents.flags.writeable = False  # drawing would otherwise wait for them
    coefficients = windowed(scene_coefficients(scene, transport.order), window)
    return LitHarmonics(transport, transferred(transport, coefficients))


def _lobes_under(made: Made, scene: Scene) -> Lit:
    """Lobes under the light of `scene`, with everything that drawing would otherwise wait for."""
    from engine.transport.lit import lit_gaussians

    lit = lit_gaussians(
        made.transport,
        scene.environment,
        rotation=scene.environment_rotation,
        factor=scene.irradiance,
        lamps=_lamps(scene),
    )
    lit.transport.texels.flags.writeable = False
    lit.light.atlas.texels.flags.writeable = False
    return lit


def _lamps(scene: Scene) -> tuple[Lamp, ...]:
    """All lamps, the one light among them where there is no environment."""
    from engine.lamps import Lamp

    if scene.environment is not None or scene.irradiance <= 0.0:
        return scene.lamps
    return (Lamp(scene.light, (scene.irradiance,) * 3), *scene.lamps)


def _with_brdf(transport: ShTransport, brdf: Brdf) -> Steps[ShTransport]:
    from engine.transport.sh_table import tabulate
    from engine.transport.sh_transfer import with_table

    return with_table(transport, (yield from tabulate(brdf, transport.order)))


def _tuples(made: Made, scene: Scene) -> Any:
    from engine.transport.wavelet_lighting import dark, lighting_of

    edge, lamps = made.transport.edge, _lamps(scene)
    if scene.environment is None:
        return made.relighter.tuples(dark(edge, lamps))
    turn, factor = scene.environment_rotation, scene.irradiance
    return made.relighter.tuples(lighting_of(scene.environment, edge, rotation=turn, factor=factor, lamps=lamps))
