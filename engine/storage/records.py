"""The manifest of a bundle: what it holds, where it came from, and how well it fits.

Floats are written so that they come back bit for bit (shortest decimal that does); a health figure that is not finite
is written as the text "nan", "inf" or "-inf".
A bundle of a newer schema is refused, never half understood. Schema 1 holds shading maps of one arc; schema 2 is
written where there is a directional map, and knows the key `directional` besides; schema 3 where there are PBR maps,
with the key `pbr`.
"""

from __future__ import annotations

import hashlib
import json
import math
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, JsonValue, ValidationError, model_validator

from engine.core.errors import InputError
from engine.core.health import Finding, Health, Verdict
from engine.storage.text import read_json, valid

if TYPE_CHECKING:
    import os

FORMAT: Literal["lightarc-bundle"] = "lightarc-bundle"

#: Planes that a directional map may have.
MAX_PLANES = 128
SCHEMA_VERSION: Literal[6] = 6

#: The member that holds a measured BRDF (`engine.brdf.readers.table_file`), where there is one.
TABLE = "brdf_table.exr"

#: Units of the numbers in a bundle, for those who read it without this program.
UNITS = {
    "radiance": "linear sRGB, 1 = white level of the photographs",
    "r": "mean luminance of a photograph, radiance; r = sigma * f_r * cos(theta_i)",
    "brdf": "1/sr, the cosine is not included",
    "elevation_deg": "degrees above the sample plane",
    "image_origin": "row 0 on top, texel centres at half-integers",
}

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Side = Annotated[int, Field(ge=1, le=1 << 20)]
Text = Annotated[str, Field(max_length=10_000)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class Member(_Strict):
    """Fingerprint of a member."""

    sha256: Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
    size_bytes: Annotated[int, Field(ge=0, le=64 << 30)]


class Observation(_Strict):
    """A finding of `engine.core.health`."""

    verdict: Literal["GOOD", "NOTE", "WARNING", "BAD"]
    text: Text
    source: Text | None


class HealthRecord(_Strict):
    """Counts and findings."""

    figures: dict[str, Finite | Literal["nan", "inf", "-inf"]] = {}
    findings: list[Observation] = []

    @staticmethod
    def of(health: Health) -> HealthRecord:
        figures: Any = {
            name: float(value) if math.isfinite(value) else repr(float(value)) for name, value in health.figures.items()
        }
        findings = [
            Observation(
                verdict=f.verdict.name,  # type: ignore[arg-type]
                text=valid(f.text),
                source=valid(f.source),
            )
            for f in health.findings
        ]
        return HealthRecord(figures=figures, findings=findings)

    def restored(self) -> Health:
        figures = {name: float(value) for name, value in self.figures.items()}
        findings = tuple(Finding(Verdict[f.verdict], f.text, f.source) for f in self.findings)
        return Health(MappingProxyType(figures), findings)


class ShadingMapRecord(_Strict):
    """The numbers of a shading map; its pixels are in shading_map.exr."""

    slices: Annotated[int, Field(ge=2, le=4096)]
    height_px: Side
    width_px: Side
    r_max: Positive
    mean_radiance: list[Finite]
    order: list[Annotated[int, Field(ge=0)]]
    clipped: bool
    health: HealthRecord


class StorageRecord(_Strict):
    """Coding of the pair of a power law, and the change by its rounding: at most, and at the slices."""

    exponent_bits: Literal[8, 16, 32] = 32
    scale_bits: Literal[16, 32] = 32
    exponent_step: NonNegative = 0.0
    bound_radiance: NonNegative = 0.0
    measured_radiance: NonNegative = 0.0

    @model_validator(mode="after")
    def _has_a_step(self) -> StorageRecord:
        if (self.exponent_bits < 32) != (self.exponent_step > 0):
            raise ValueError("exponent_step belongs to codes and to nothing else")
        return self


class KeptTilesRecord(_Strict):
    """The numbers of the tiles that keep their slices; their pixels are in power_law_kept_tiles.exr."""

    size_px: Annotated[int, Field(ge=1, le=1 << 20)]
    slices: Annotated[int, Field(ge=2, le=4096)]


class PowerLawRecord(_Strict):
    """The numbers of a power-law pair; its pixels are in the power_law_*.exr members."""

    height_px: Side
    width_px: Side
    r_max: Positive
    rms: NonNegative
    rms_per_channel: Annotated[list[NonNegative], Field(min_length=3, max_length=3)]
    health: HealthRecord
    storage: StorageRecord = StorageRecord()
    kept_tiles: KeptTilesRecord | None = None


class DirectionalRecord(_Strict):
    """The numbers of a directional map for users; its planes are in directional_plane*.png, the rest in one JSON.

    Errors are root mean squares in codes of 8-bit sRGB, as in `DirectionalMap`; None where one is not known.
    """

    planes: Annotated[int, Field(ge=1, le=MAX_PLANES)]
    photographs: Annotated[int, Field(ge=1, le=1024)]
    height_px: Side
    width_px: Side
    r_max: Positive
    leave_one_out_rmse_srgb8: NonNegative | None
    in_sample_rmse_srgb8: NonNegative | None
    mean_picture_rmse_srgb8: NonNegative | None


class PbrErrorsRecord(_Strict):
    """Errors of PBR maps against their photographs, as `MapErrors`; None where one is not known."""

    in_sample: NonNegative | None = None
    left_out: NonNegative | None = None
    mean_picture: NonNegative | None = None
    normal_sigma: NonNegative | None = None


class WideColoursRecord(_Strict):
    """Base colours of PBR maps in a wider space than Rec.709, `wide.base_colour` in pbr_maps.exr.

    `beyond_rec709` is the share of texels that base_colour shows clipped, and `distance` by how much at most.
    """

    space: Literal["rec2020", "acescg"]
    sigma: bool
    beyond_rec709: Annotated[float, Field(ge=0, le=1)]
    distance: NonNegative


class PbrRecord(_Strict):
    """The numbers of PBR maps; their pixels are in pbr_maps.exr, `maps` by name, and one sigma of each if known.

    `white_radiance` is that of the white card which maps beside a shading map or a directional map are relative to;
    `wide` is of base colours in a wider space.
    `multiple_scattering` says whether light that facets scatter more than once is added to the highlight. `layers` is
    the text of an OpenPBR model, of which all but the base counts, or of a metallic-roughness, of which sheen and
    clear coat count.
    `tiles` is how many UDIM tiles a side the maps hold: texture coordinates are divided by it.
    """

    height_px: Side
    width_px: Side
    maps: Annotated[list[Text], Field(min_length=5, max_length=7)]
    uncertainty: bool
    observed_slopes: Literal["both", "along the arc", "none"]
    observed_azimuth: Finite | None
    errors: PbrErrorsRecord
    white_radiance: Positive | None = None
    multiple_scattering: bool = False
    layers: Text | None = None
    wide: WideColoursRecord | None = None
    tiles: Annotated[int, Field(ge=1, le=10)] = 1


Direction = Annotated[list[Annotated[float, Field(ge=-1, le=1)]], Field(min_length=3, max_length=3)]


class DirectionalNumbers(_Strict):
    """Content of directional.json, for N photographs and K planes (`DirectionalMap`).

    A texel's code in channel c under light l is sum over photographs n of w_n(l) (mean[3 n + c] + sum over planes k of
    vectors[3 n + c][k] (low[k] + step[k] code_k)), where w are the weights of kriging, or those of `kernel_basis` where
    another program stated it (ptm, hsh, sh, gauss, octahedron); directional_weights.exr holds the sums over photographs
    at a grid of directions.
    """

    lights: Annotated[list[Direction], Field(min_length=1, max_length=1024)]
    kernel_length: Positive
    kernel_noise: NonNegative
    kernel_power: Positive = 1.0
    kernel_upward: NonNegative = 0.0
    kernel_basis: Literal["free", "linear", "polynomial", "harmonic", "ptm", "hsh", "sh", "gauss", "octahedron"] = (
        "free"
    )
    kernel_trend: NonNegative = 0.0
    mean: list[Finite]
    vectors: list[list[Finite]]
    low: list[Finite]
    step: list[Positive]


class MaskRecord(_Strict):
    """Size of mask.png, which is white for texels of the object and black for those of the background."""

    height_px: Side
    width_px: Side


class Manifest(_Strict):
    """Everything of a bundle that is not pixels."""

    format: Literal["lightarc-bundle"] = FORMAT
    schema_version: Literal[1, 2, 3, 4, 5, 6] = 1
    name: Text
    brdf: Text
    sigma: Positive | None
    elevation_deg: list[Finite]
    units: dict[str, str]
    software: dict[str, str]
    provenance: dict[str, JsonValue]
    figures: dict[str, JsonValue]
    shading_map: ShadingMapRecord | None
    power_law: PowerLawRecord | None
    directional: DirectionalRecord | None = None
    pbr: PbrRecord | None = None
    mask: MaskRecord | None = None
    health: HealthRecord
    members: dict[str, Member]

    @model_validator(mode="after")
    def _has_its_schema(self) -> Manifest:
        if (self.schema_version == 6) != (self.mask is not None):
            raise ValueError("a mask belongs to schema 6")
        if self.schema_version == 6:
            return self
        looked_up = self.shading_map is not None or self.power_law is not None
        if (self.schema_version == 5) != (self.pbr is not None and self.pbr.wide is not None):
            raise ValueError("schema 5 is of PBR maps with base colours in a wider space")
        if self.schema_version == 5:
            return self
        if self.schema_version == 4:
            if self.pbr is None or self.pbr.white_radiance is None or not (looked_up or self.directional is not None):
                raise ValueError("schema 4 is of maps of a surface beside a shading map or a directional map")
            return self
        if (self.schema_version == 2) != (self.directional is not None):
            raise ValueError("a directional map belongs to schema 2 and to schema 4")
        if (self.schema_version == 3) != (self.pbr is not None):
            raise ValueError("PBR maps belong to schema 3 and to schema 4")
        return self


def manifest_schema() -> dict[str, Any]:
    """The JSON schema of manifest.json as it is written: of a `Manifest` and the fingerprint that seals it."""
    schema = Manifest.model_json_schema()
    schema["properties"]["manifest_sha256"] = {
        "description": "SHA-256 of all other values, as JSON with sorted keys, separators , and : and ASCII only.",
        "pattern": "^[0-9a-f]{64}$",
        "type": "string",
    }
    schema["required"].append("manifest_sha256")
    return schema


def write_manifest(manifest: Manifest) -> bytes:
    """The manifest, sealed with its own fingerprint, as indented JSON in UTF-8."""
    absent = {name for name in ("directional", "pbr", "mask") if getattr(manifest, name) is None}
    value = manifest.model_dump(exclude=absent)
    if manifest.pbr is not None and manifest.pbr.white_radiance is None:
        del value["pbr"]["white_radiance"]  # as versions before schema 4 wrote and sealed it
    if manifest.pbr is not None and manifest.pbr.wide is None:
        del value["pbr"]["wide"]  # as versions before schema 5 did
    sealed = {**value, "manifest_sha256": seal(value)}
    return (json.dumps(sealed, indent=2, ensure_ascii=False, allow_nan=False) + "\n").encode()


def seal(value: dict[str, Any]) -> str:
    """SHA-256 of a JSON object, independent of the order and the spacing in which it is written."""
    canonical = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


def read_manifest(content: bytes, path: str | os.PathLike[str]) -> Manifest:
    """The manifest in `content`; InputError about `path` for anything that is not exactly one."""
    return manifest_of(read_json(content, path, "manifest.json"), path)


def manifest_of(value: object, path: str | os.PathLike[str]) -> Manifest:
    """The manifest that a value of JSON is; errors as above."""
    if not isinstance(value, dict) or value.get("format") != FORMAT:
        raise InputError(path, "manifest.json is not the manifest of a Lightarc bundle", "Choose a bundle")
    version = value.get("schema_version")
    if isinstance(version, int) and version > SCHEMA_VERSION:
        problem = f"was written by a newer Lightarc (schema {version}, this one reads {SCHEMA_VERSION})"
        raise InputError(path, problem, "Update Lightarc")
    try:
        sealed = value.pop("manifest_sha256", None) == seal(value)
    except RecursionError:
        raise InputError(path, "manifest.json is nested too deeply", "Export the bundle again") from None
    if not sealed:
        raise InputError(path, "manifest.json is not as it was written", "Ask for the bundle again from where it came")
    try:
        return Manifest.model_validate(value)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(step) for step in first["loc"])[:120]
        raise InputError(path, f"manifest.json: {where}: {first['msg']}", "Export the bundle again") from None
