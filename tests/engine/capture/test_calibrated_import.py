"""Calibration steps of the import against captures with known ground truth: R3, R8, lights, white balance, framing."""

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.lights.sources import find
from engine.capture.lights.sphere_lights import with_sphere
from engine.capture.photograph.grey_patch import GreyPatch
from engine.capture.registration.framing import crop
from engine.capture.registration.warp import Region
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images.decode import read_image
from engine.simulate.arc import EXPOSURE_S, LightArc, sphere
from engine.simulate.simulate import simulate
from engine.storage import untrusted

SNR = 100.0


def radians(*degrees: Any) -> Any:
    return tuple(math.radians(angle) for angle in degrees)


def capture(folder: Path, **settings: Any) -> tuple[Any, Any]:
    """A capture, and its truth by file name."""
    arc = LightArc(**{"size": 96, "misalignment_px": 0.0, "elevation": radians(30, 60, 90), **settings})
    drain(simulate(arc, folder))
    records = json.loads((folder / "truth" / "truth.json").read_text())["photographs"]
    return arc, {record["file"]: record for record in records}


def import_capture(folder: Path, sources: Any = None, **settings: Any) -> Any:
    found = find([folder]) if sources is None else sources
    chosen = ImportSettings(**{"motion": "none", **settings})
    return drain(import_stack(found, chosen, folder.parent / "stack"))


def errors(stack: Any, folder: Path, truth: Any, noise: Any, scale: float = 1.0) -> Iterator[Any]:
    """Relative errors where the signal-to-noise ratio of one photograph of the scale 1 is high, and nothing clipped."""
    for name, radiance, saturated in zip(stack.sources, stack.radiance, stack.saturated, strict=True):
        clean = read_image(folder / "truth" / truth[name]["radiance"]).pixels
        strong = (clean >= SNR * noise * np.sqrt(0.99 * clean + 0.01)) & (clean < 1) & ~saturated[..., None]
        assert strong.sum() > 1000
        yield radiance[strong] * scale / clean[strong] - 1


@pytest.mark.parametrize("format_", [pytest.param("tiff", marks=pytest.mark.long), "dng"])
def test_fall_off_and_dark_signal_are_taken_out(tmp_path: Path, format_: str) -> None:
    _, truth = capture(tmp_path / "c", format=format_, corner_loss=0.4, dark=0.02, calibration=True, sample="plain")
    stack = import_capture(tmp_path / "c")
    assert (stack.provenance["dark"], stack.provenance["flat"]) == tuple(
        f"{kind}{'.dng' if format_ == 'dng' else '.tif'}" for kind in ("dark", "flat")
    )
    scale = 1 / np.median(1 + np.concatenate(list(errors(stack, tmp_path / "c", truth, 0.004))))
    assert 1.0 < scale < 1.6
    for error in errors(stack, tmp_path / "c", truth, 0.004, scale):
        assert np.sqrt(np.mean(error**2)) < 0.01
    plain = import_capture(tmp_path / "c", flat="none", dark="none")
    assert np.sqrt(np.mean(next(errors(plain, tmp_path / "c", truth, 0.004)) ** 2)) > 0.05


def test_what_a_flat_field_cannot_tell_is_masked_and_frames_of_another_size_are_named(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    capture(folder, format="tiff", calibration=True, corner_loss=0.3)
    from engine.images.encode import write_tiff16

    flat = np.full((96, 96, 3), 40000, np.uint16)
    flat[10:20, 30:40] = 0
    write_tiff16(folder / "flat.tif", flat, transfer="linear")
    stack = import_capture(folder)
    assert stack.saturated[:, 10:20, 30:40].all()
    assert stack.saturated[:].mean() < 0.1
    write_tiff16(folder / "flat.tif", flat[:50], transfer="linear")
    with pytest.raises(InputError, match=r"flat.tif: has not the size of the dark frame dark.tif"):
        import_capture(folder)
    with pytest.raises(InputError, match=r"woven_30.tif: has 96 × 96 px, but the flat field has 96 × 50 px"):
        import_capture(folder, dark="none")
    write_tiff16(folder / "flat.tif", np.zeros_like(flat), transfer="linear")
    with pytest.raises(InputError, match=r"flat.tif: is not a usable flat field: .*not brighter"):
        import_capture(folder, dark="none")


def test_a_near_lamp_is_evened_out(tmp_path: Path) -> None:
    arc, _ = capture(tmp_path / "c", sample="plain", noise=0.0, lamp_distance=1.5, azimuth=(0.5,), size=128)
    inner = np.s_[8:-8, 8:-8]
    for settings, bound in (({}, (0.0, 0.01)), ({"lamp_distance": math.inf}, (0.05, 1.0))):
        stack = import_capture(tmp_path / "c", **settings)
        assert stack.provenance["lamp_distance_widths"] == (None if settings else arc.lamp_distance)
        for radiance, saturated in zip(stack.radiance, stack.saturated, strict=True):
            card = radiance[inner][~saturated[inner]].astype(float)
            unevenness = card.std() / card.mean()
            assert bound[0] <= unevenness <= bound[1] or not settings
            assert settings or unevenness < 0.01
    assert stack.azimuth is not None


def test_R8_exposures_of_one_light_are_merged(tmp_path: Path) -> None:
    """Radiance 1 is the white level of the reference exposure, which of equally frequent ones is the shortest."""
    folder = tmp_path / "c"
    _, truth = capture(folder, sample="hammered", exposure=(1.0, 0.25, 4.0))
    stack = import_capture(folder)
    assert len(stack.sources) == 3
    reference = stack.provenance["reference_exposure_s"]
    assert reference == pytest.approx(0.25 * EXPOSURE_S, rel=1e-2)
    assert [len(one["exposures"]) for one in stack.provenance["photographs"]] == [3, 3, 3]
    for error in errors(stack, folder, truth, 0.004, EXPOSURE_S / reference):
        assert np.sqrt(np.mean(error**2)) < 0.01
        assert abs(np.median(error)) < 0.002
    assert any("Exposures differ" in finding.text for finding in stack.health.findings)


def test_R8_merging_with_a_dark_frame_and_fall_off(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    _, truth = capture(folder, exposure=(1.0, 4.0), calibration=True, dark=0.03, corner_loss=0.3, format="dng",
                        sample="plain")  # fmt: skip
    stack = import_capture(folder)
    scale = 1 / np.median(1 + np.concatenate(list(errors(stack, folder, truth, 0.004))))
    for error in errors(stack, folder, truth, 0.004, scale):
        assert np.sqrt(np.mean(error**2)) < 0.02


def test_photographs_of_different_exposure_come_to_one_scale(tmp_path: Path, dng: Any) -> None:
    folder = tmp_path / "c"
    folder.mkdir()
    mosaic = np.random.default_rng(0).integers(300, 800, (64, 80)).astype(float)
    for name, light, time_s in (("a_20deg", 1.0, 10), ("b_40deg", 1.5, 10), ("c_60deg", 3.0, 20)):
        samples = 64 + (mosaic - 64) * light * 10 / time_s
        (folder / f"{name}.dng").write_bytes(dng(np.rint(samples).astype(np.uint16), exposure=(1, time_s)))
    stack = import_capture(folder)
    assert stack.mean_radiance / stack.mean_radiance[0] == pytest.approx([1, 1.5, 3], rel=2e-3)
    assert stack.provenance["reference_exposure_s"] == pytest.approx(0.1)
    (folder / "c_60deg.dng").write_bytes(dng(np.rint(1.2 * mosaic).astype(np.uint16)))
    warnings = import_capture(folder).health.warnings
    assert any("the exposure of c_60deg.dng is unknown" in warning for warning in warnings)


def test_lights_are_measured_on_a_mirror_sphere(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    arc, truth = capture(folder, sphere=True, size=256, elevation=radians(15, 50, 85), azimuth=(2.0,))
    stack = import_capture(folder)
    assert stack.angle_source == "mirror sphere"
    for name, elevation, azimuth in zip(stack.sources, stack.elevation, stack.azimuth, strict=True):
        found = [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)]
        assert math.degrees(math.acos(min(1.0, np.dot(found, truth[name]["sphere_light"])))) < 1.0
    ball = sphere(arc)
    (folder / "capture.toml").unlink()
    for outline in (Circle(ball.column, ball.row, ball.radius), "auto"):
        again = import_capture(folder, find([folder], sphere=outline))
        assert np.degrees(np.abs(again.elevation - stack.elevation)).max() < (1e-6 if outline != "auto" else 3.0)


def test_highlights_can_be_corrected_and_failures_name_the_photograph(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    arc, _ = capture(folder, sphere=True, size=256)
    ball = sphere(arc)
    text = (folder / "capture.toml").read_text()
    corrected = text.replace(
        "elevation_deg = 60.0", f"elevation_deg = 60.0\nhighlight_px = [{ball.column}, {ball.row}]"
    )
    (folder / "capture.toml").write_text(corrected)
    stack = import_capture(folder)
    assert stack.elevation_deg[-1] == pytest.approx(90.0)
    assert any("measured at 90.0° on the sphere, but said to be at 60.0°" in text for text in stack.health.warnings)
    (folder / "capture.toml").write_text(corrected.replace(f"column_px = {ball.column}", "column_px = 128.0"))
    with pytest.raises(InputError, match=r"woven_\d\d.tif: .*highlight"):
        import_capture(folder)


def test_a_grey_patch_balances_raw_and_images(tmp_path: Path, dng: Any) -> None:
    folder = tmp_path / "c"
    folder.mkdir()
    camera = np.array([0.5, 1.0, 0.7])
    for angle, light in ((20, 600), (40, 1600), (60, 9000)):
        mosaic = np.empty((64, 80))
        for (row, column), colour in zip(((0, 0), (0, 1), (1, 0), (1, 1)), (0, 1, 1, 2), strict=True):
            mosaic[row::2, column::2] = 64 + light * camera[colour]
        (folder / f"card_{angle}deg.dng").write_bytes(dng(np.rint(mosaic.clip(0, 4095)).astype(np.uint16)))
    stack = import_capture(folder, white_balance=GreyPatch(10, 12, 20, 16))
    assert stack.provenance["photographs"][0]["white_balance"] == pytest.approx(1 / camera, rel=2e-3)
    assert stack.radiance[1].std(axis=(0, 1)).max() < 1e-3
    assert np.ptp(stack.radiance[1].mean(axis=(0, 1))) < 1e-3
    with pytest.raises(InputError, match="outside"):
        import_capture(folder, white_balance=GreyPatch(70, 0, 20, 20))


def test_a_grey_patch_balances_images(tmp_path: Path) -> None:
    from engine.images.encode import write_tiff16

    folder = tmp_path / "c"
    folder.mkdir()
    for angle in (20, 40, 60):
        codes = np.broadcast_to(np.array([0.4, 0.5, 0.2]) * 655 * angle, (40, 50, 3)).astype(np.uint16).copy()
        codes[0, 0] = angle
        write_tiff16(folder / f"card_{angle}deg.tif", codes, transfer="linear")
    stack = import_capture(folder, white_balance=GreyPatch(4, 4, 30, 30))
    assert stack.provenance["picture_balance"] == pytest.approx([1.25, 1, 2.5], rel=1e-3)
    assert np.ptp(stack.radiance[1:, 5:].mean(axis=(1, 2)), axis=1).max() < 1e-3


def test_a_framing_is_resampled_once_and_control_points_are_followed(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    capture(folder, misalignment_px=3.0)
    whole = import_capture(folder).radiance[:]
    framed = import_capture(folder, framing=crop(Region(10, 20, 50, 40)))
    assert np.array_equal(framed.radiance, whole[:, 20:60, 10:60])
    half = import_capture(folder, framing=crop(Region(10, 20, 50, 40), 25, 20))
    assert half.radiance.shape == (3, 20, 25, 3)
    assert half.mean_radiance == pytest.approx(framed.mean_radiance, rel=1e-3)
    with pytest.raises(InputError, match="beyond what all"):
        import_capture(folder, framing=crop(Region(60, 20, 50, 40)))
    pairs = [[x, y, x + 5, y - 2] for x, y in ((10, 10), (80, 15), (70, 85), (12, 70))]
    moved = import_capture(folder, control_points={"woven_60.tif": pairs})
    assert moved.radiance.shape[1:3] == (94, 91)
    assert np.allclose(moved.radiance[1], whole[1, :94, 5:], atol=1e-4)
    with pytest.raises(InputError, match=r"holds no other\.tif"):
        import_capture(folder, control_points={"other.tif": pairs})


def test_fault_17_cancelling_does_not_wait_for_the_photograph_that_is_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The decoder here would take a quarter of an hour."""
    folder = tmp_path / "c"
    capture(folder)
    monkeypatch.setattr("engine.capture.photograph.decode.PATIENCE_S", 0.01)
    sources = find([folder])
    untrusted.stop_children()
    monkeypatch.setattr(untrusted, "_START", f"import time; time.sleep(900)\n{untrusted._START}")
    steps = import_stack(sources, ImportSettings(motion="none"), tmp_path / "stack")
    while not (busy := [child.process for child in untrusted._running]):
        next(steps)
    steps.close()
    assert not (tmp_path / "stack").exists()
    assert all(process.poll() is not None for process in busy)


def test_a_near_lamp_of_unknown_azimuth_is_warned_of(tmp_path: Path) -> None:
    """Nothing says on which side the lamp stood; the correction for the right side is announced in words."""
    folder = tmp_path / "c"
    capture(folder, sample="plain", lamp_distance=1.5, azimuth=(0.5,))
    said = "nothing says on which side it stood"
    assert not any(said in text for text in import_capture(folder).health.warnings)
    (folder / "capture.toml").unlink()
    known = find([folder], [30, 60, 90])
    assert any(said in text for text in import_capture(folder, known, lamp_distance=1.5).health.warnings)
    assert not any(said in text for text in import_capture(folder, known).health.warnings)


def test_lights_assumed_or_named_are_forgotten_for_those_of_the_sphere(tmp_path: Path) -> None:
    folder = tmp_path / "c"
    arc, truth = capture(folder, sphere=True, size=256, elevation=radians(30, 50, 70))
    (folder / "capture.toml").unlink()
    for number, name in enumerate(truth):
        (folder / name).rename(folder / f"{'abc'[number]}.tif")
    sources = find([folder])
    assert sources.angle_source == "assumed"
    ball = sphere(arc)
    outline = Circle(ball.column, ball.row, ball.radius)
    corrected = ball.column + 0.4 * ball.radius, ball.row
    stack = import_capture(folder, with_sphere(sources, outline, {"b.tif": corrected}))
    assert stack.angle_source == "mirror sphere"
    assert not any("assumed" in text or "said to be" in text for text in stack.health.warnings)
    elevation = dict(zip(stack.sources, stack.elevation_deg, strict=True))
    assert elevation["b.tif"] == pytest.approx(90 - 2 * math.degrees(math.asin(0.4)), abs=1e-6)
    assert elevation["a.tif"] == pytest.approx(30, abs=2)
    assert stack.provenance["highlights_px"] == {"b.tif": list(corrected)}
