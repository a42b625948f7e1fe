"""The project that the user edits, as one frozen value, and the steps of its history.

A change makes another `Project`; arrays are shared between old and new. `app.document.open_document` holds the current
one with its history, and needs Qt; this module does not.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import radians
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from app.document.comparison import Comparison
from app.document.exporting import Exporting
from app.document.factoring import Factoring
from app.document.variation import Variation
from engine.capture.diffuse_part import Part
from engine.capture.lights.sources import Sources
from engine.capture.stack import ImageStack
from engine.core.colour import Operator
from engine.core.directions import Vectors, world_direction
from engine.core.params import check, param, same_as
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import FLAT, flat_image
from engine.light.environment import EnvironmentMap
from engine.light.lamps import LampSettings
from engine.light.near_lamps import NearLampSettings
from engine.scene.material import Material
from engine.scene.mode import REFERENCE, SHADING_MAP
from engine.scene.scene import Lookup, Source, TilingMode
from engine.scene.settings import SceneSettings
from engine.shading.lookup import Above
from engine.shading.power_law import Scale
from engine.shading.representation import Representation

if TYPE_CHECKING:
    from app.document.measured import Accuracy
    from engine.capture.registration.framing import Framing
    from engine.surface.recover import Surface

#: Arrangements of two images.
Comparing = Literal["", "wipe", "difference"]

#: Appearances of the environment behind the model.
Behind = Literal["", "sharp", "soft", "blurred"]

#: A point in two photographs: x and y in the one, x and y in the other.
Pair = tuple[float, float, float, float]

#: Parts of a project, beside its material, that hold for one capture or material alone.
OF_CAPTURE = (
    *("sources", "imported_with", "stack", "excluded", "representation", "tileable", "evened", "part_of_light"),
    "built_from",
    *("provenance", "surface", "surface_from", "white", "accuracy"),
)

#: BRDF of a new project: a soft sheen, like that of most cloth, leather and hand-worked metal.
BRDF = "ggx:alpha=0.5"


@dataclass(frozen=True)
class ImportChoices:
    """Choices for reading photographs: the part of `engine.capture.import_stack.ImportSettings` that the window offers.

    Attributes
    ----------
    dark, flat : calibration frames: 'auto' for those found beside the photographs, 'none', or a file.
    lamp_distance : of a near lamp in widths of the image; None for what the sources say.
    sphere : measure the lights on a mirror sphere in the image.
    outline, highlights : column, row and radius of the sphere, and column and row of the lamp's reflection by file
        name, where a user corrected what was found (pixels, the upper left corner of the image is (0, 0)).
    second_sphere : a second mirror sphere is in the image, which tells where near lamps stand.
    equalise : lamps differ in intensity, which is divided out by the 'object' or by the grey 'patch'; '' for not.
    reference : file name of the photograph that the others are aligned to, None for what the sources say.
    control_points : by file name, x and y in the reference and in the photograph (pixel centres at integers).
    patch : (left, top, width, height) in pixels of a grey patch, which then decides the white balance.
    framing : the part of the photographs that becomes the image, and its size; None for all.
    without_estimates : what is not estimated from the photographs, of `engine.capture.import_plan.CALIBRATED`.
    lights_form : the form in which the list of lights is taken, see `engine.capture.lights.list_forms`.
    chart : the colour chart by which colours are corrected: 'auto' for one that a photograph of the capture shows,
        'none', or a file that shows one or that an import has written.
    lens : a `.lens` file, whose distortion is taken off, or 'none'.
    mask : an image whose white pixels show the object, 'alpha' for the opaque pixels of the photographs, or 'none'.
    outline_px : in its place, x and y of an outline around the object in the reference photograph (pixels).
    scale_mm, chart_pitch_mm : millimetres per pixel of the photographs, or between the middles of neighbouring patches
        of the chart, which tells it; None where it is not known.
    known_length : in their place, x and y of two points in the reference photograph (pixels), and the millimetres
        between them.
    scale_by_camera, camera_distance_mm : in their place, estimate the scale from what the camera notes; the distance
        from the sample to the sensor where a user measured it.
    pair_gain : of pairs under polarisers, the brightness of crossed over parallel photographs; None to estimate it.
    trust_angles : take angles that nobody stated also where the photographs do not grow brighter with them.
    leave_out : leave photographs out that cannot be read or show nothing, where enough remain.
    use_all : use photographs that show nothing too: black ones, and ones that are clipped all over.
    working_space : the linear space in which maps are made, or 'auto' (`engine.capture.gamut`).
    """

    motion: Literal["auto", "none", "translation", "euclidean", "affine", "homography"] = "auto"
    white_balance: Literal["camera", "none"] = "camera"
    transfer: Literal["auto", "srgb", "linear"] = "auto"
    dark: Path | Literal["auto", "none"] = "auto"
    flat: Path | Literal["auto", "none"] = "auto"
    lamp_distance: float | None = None
    sphere: bool = False
    outline: tuple[float, float, float] | None = None
    highlights: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    second_sphere: bool = False
    equalise: Literal["", "object", "patch"] = ""
    reference: str | None = None
    control_points: Mapping[str, tuple[Pair, ...]] = field(default_factory=dict)
    patch: tuple[int, int, int, int] | None = None
    framing: Framing | None = None
    without_estimates: tuple[str, ...] = ()
    lights_form: str = "listed"
    chart: Path | Literal["auto", "none"] = "none"
    pair_gain: float | None = None
    lens: Path | Literal["none"] = "none"
    mask: Path | Literal["alpha", "none"] = "none"
    outline_px: tuple[tuple[float, float], ...] = ()
    scale_mm: float | None = None
    chart_pitch_mm: float | None = None
    known_length: tuple[float, float, float, float, float] | None = None
    scale_by_camera: bool = False
    camera_distance_mm: float | None = None
    trust_angles: bool = False
    leave_out: bool = False
    use_all: bool = False
    working_space: Literal["rec709", "rec2020", "acescg", "auto"] = "rec709"

    @property
    def for_another_capture(self) -> ImportChoices:
        """The choices that hold for other photographs too: no positions in these images, no frames, no lamps."""
        space = self.working_space
        return ImportChoices(self.motion, self.white_balance, self.transfer, working_space=space)


_SLIDER_OF_STRENGTH: dict[str, Any] = {"high": 100.0, "slider": (0.1, 10.0), "log": True}


@dataclass(frozen=True)
class Look:
    """Display settings of the View workspace. None of them changes the material itself.

    Attributes
    ----------
    mode, against : what is drawn, and what that is compared with (`app.document.modes`).
    comparing : two images side by side, their difference, or the first alone.
    bounces : interreflections in the reference: path segments after the first surface.
    lamps : lights beside the one or the environment; `only_lamps` puts out the one. near_lamps : lights near the model.
    forced, skipped : effects that the plan works out, or leaves out, whatever they add (`engine.planning`).
    plan_budget : what the plan keeps within, as a user writes it: '1 %' or '8 ms'.
    tiling_mode : how maps repeat (`engine.scene.scene.Scene`).
    behind : the environment behind the model, and how blurred it is; '' for the plain canvas.
    """

    # The window begins with a brighter light from the left and larger repeats, because it shows and does not compute.
    light_theta_deg: float = same_as(SceneSettings, "light_theta_deg", default=55.0)
    light_phi_deg: float = same_as(SceneSettings, "light_phi_deg", default=-30.0)
    irradiance: float = same_as(
        SceneSettings, "irradiance", default=2.2, doc="Strength of the light.", **_SLIDER_OF_STRENGTH
    )
    rotation_deg: float = same_as(
        SceneSettings, "environment_rotation_deg", low=-180.0, high=180.0, slider=(-180.0, 180.0)
    )
    gain: float = same_as(SceneSettings, "irradiance", doc="Strength of the environment.", **_SLIDER_OF_STRENGTH)
    directions: int = 64
    repeats: float = same_as(SceneSettings, "repeats", default=3.0, low=0.1, high=100.0, slider=(0.5, 16.0), log=True)
    tiling_mode: TilingMode = "grid"
    exposure_ev: float = param(0.0, -20.0, 20.0, slider=(-6.0, 6.0), unit="EV", doc="Brightness of the image.")
    tone_map: Operator = "neutral"
    source: Source = "slices"
    lookup: Lookup = "radiance"
    above: Above = "clamp"
    mode: str = SHADING_MAP.name
    against: str = REFERENCE.name
    comparing: Comparing = ""
    bounces: int = 0
    lamps: tuple[LampSettings, ...] = ()
    near_lamps: tuple[NearLampSettings, ...] = ()
    only_lamps: bool = False
    has_ground: bool = False
    ground_albedo: float = param(0.5, 0.0, 1.0, doc="Albedo of the ground.")
    forced: tuple[str, ...] = ()
    skipped: tuple[str, ...] = ()
    plan_budget: str = "1 %"
    behind: Behind = ""

    def __post_init__(self) -> None:
        check(self)

    @property
    def light(self) -> Vectors:
        """World direction (3,) towards the light."""
        return world_direction(radians(self.light_theta_deg), radians(self.light_phi_deg))

    @property
    def ground(self) -> Ground | None:
        """The ground below the model, or None."""
        return Ground(albedo=self.ground_albedo) if self.has_ground else None


@dataclass(frozen=True, eq=False)
class Project:
    """The photographs, the results made of them, and the display settings; `provenance` is the origin of the material.

    `variations` are ways in which the BRDF is not the same all over the model.
    `part_of_light` is that of pairs under polarisers which the material is made of.
    `evened` divides the slow change of brightness over the sample out before the material is made `tileable`.
    `bakes` are the settings of bakes in the View workspace by method, those that are not its defaults, by name.
    `exporting` are the settings of exports. `accuracy` is what was measured of settings in View.
    `came_from` are files of models and environments by their names.
    `camera` is where the model is seen from; None where it is framed. `views` are those that a user keeps, by name.
    `notes` are a user's own words.
    `surface` are the maps of the surface behind the photographs, and `surface_from` the stack and the photographs left
    out of which they were made. `white` is the radiance of a white card that faces a lamp, in units of the photographs'
    white level, where a user knows it.
    """

    sources: Sources | None = None
    import_choices: ImportChoices = ImportChoices()
    imported_with: ImportChoices | None = None
    stack: ImageStack | None = None
    excluded: frozenset[str] = field(default_factory=frozenset)
    representation: Representation = "auto"
    slices: int = 8
    tileable: bool = False
    evened: bool = True
    part_of_light: Part = "diffuse"
    scale: Scale = "last-slice"
    exponent_bits: Literal[8, 16, 32] = 32
    mixed: bool = False
    error_bound_percent: float = 5.0
    material: Material = field(default_factory=lambda: Material(None, None, brdf=BRDF, name="Untitled"))
    built_from: tuple[Any, ...] = ()
    provenance: Mapping[str, Any] = field(default_factory=dict)
    surface: Surface | None = None
    surface_from: tuple[Any, ...] | None = None
    white: float | None = None
    mesh: Mesh | None = None
    environment: EnvironmentMap | None = None
    look: Look = field(default_factory=Look)
    camera: Camera | None = None
    views: Mapping[str, Camera] = field(default_factory=dict)
    variations: tuple[Variation, ...] = ()
    bakes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    comparison: Comparison = field(default_factory=Comparison)
    factoring: Factoring = field(default_factory=Factoring)
    exporting: Exporting = field(default_factory=Exporting)
    accuracy: Accuracy | None = None
    came_from: Mapping[str, Path] = field(default_factory=dict)
    name: str = "Untitled"
    notes: str = ""

    @property
    def recipe(self) -> tuple[Any, ...]:
        """The inputs that the material depends on; it is out of date where they differ from `built_from`."""
        bound = self.error_bound_percent if self.mixed else None
        made = (self.stack, self.excluded, self.slices, self.tileable, self.scale, self.exponent_bits, bound)
        evened = ("evened",) if self.tileable and self.evened else ()
        has_pairs = self.stack is not None and self.stack.diffuse is not None
        diffuse = ("diffuse",) if has_pairs and self.part_of_light == "diffuse" else ()
        return (*made, *evened, *diffuse, *((self.representation,) if self.representation != "auto" else ()))

    @property
    def surface_recipe(self) -> tuple[Any, ...]:
        """The inputs that the surface maps depend on; they are out of date where these are not `surface_from`."""
        made = (self.stack, self.excluded)
        return made if self.white is None else (*made, self.white)

    @property
    def has_map(self) -> bool:
        return self.material.has_map

    @property
    def is_flat(self) -> bool:
        """True if the material is shown as a flat image."""
        return self.mesh is not None and self.mesh.name == FLAT

    def lay_flat(self, material: Material) -> dict[str, Any]:
        """The parts that show `material` once, flat and from the front; it has texels."""
        height, width = material.size
        mesh = flat_image(width, height)
        mesh.tangents.flags.writeable = False
        return {
            "mesh": mesh,
            "camera": None,
            "look": dataclasses.replace(self.look, repeats=1.0, mode=SHADING_MAP.name),
        }

    @property
    def without_capture(self) -> dict[str, Any]:
        """The parts that belong to the capture or the material, as they are where there is none; the BRDF stays."""
        brdf = {name: getattr(self.material, name) for name in ("brdf", "measured", "sigma")}
        empty = Project()
        parts = {name: getattr(empty, name) for name in OF_CAPTURE}
        if self.is_flat:
            parts |= {"mesh": None, "camera": None, "look": dataclasses.replace(self.look, repeats=Look().repeats)}
        return {**parts, "material": dataclasses.replace(empty.material, **brdf)}


@dataclass(frozen=True, eq=False)
class Step:
    """One step of the undo history: its words for a user, its gesture, and the projects before and after it.

    A project that was not read yet is the name of its state in the project file.
    """

    text: str
    gesture: str
    old: Project | str
    new: Project | str
