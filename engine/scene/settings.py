"""Defaults of a scene, declared once: engine, window, command line and Python API take them from here."""

from __future__ import annotations

from dataclasses import dataclass

from engine.core.params import check, param


@dataclass(frozen=True)
class SceneSettings:
    """Light and material of a scene where nothing else is given."""

    light_theta_deg: float = param(50.0, 0.0, 180.0, unit="°", doc="Angle of the light from straight up.")
    light_phi_deg: float = param(30.0, -180.0, 180.0, unit="°", doc="Angle of the light around the vertical.")
    irradiance: float = param(1.0, 0.0, 1e100, doc="Irradiance of the light, or the factor on the environment.")
    environment_rotation_deg: float = param(0.0, -360.0, 360.0, unit="°", doc="Rotation of the environment about +Y.")
    repeats: float = param(4.0, 1e-9, 1e9, doc="Repetitions of the material over one unit of texture coordinates.")

    def __post_init__(self) -> None:
        check(self)

    @property
    def light_deg(self) -> tuple[float, float]:
        """The angles of the light from +Y, and from +Z towards +X, in degrees."""
        return self.light_theta_deg, self.light_phi_deg


DEFAULTS = SceneSettings()
