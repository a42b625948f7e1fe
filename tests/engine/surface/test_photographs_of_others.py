"""Real photographs: normals beside plain least squares, a sphere whose shape is known, and lamps that are left out."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from scipy.io import loadmat

from engine.capture.stack import ImageStack
from engine.core.colour import srgb_decode, srgb_encode
from engine.core.steps import drain
from engine.surface.recover import recover
from tests.engine.surface.photographs import Array, angle_deg, stack

STACKS = Path(__file__).resolve().parents[4] / "shared" / "data" / "stacks"


def needs(name: str) -> Path:
    if not (STACKS / name).exists():
        pytest.skip(f"../shared/data/stacks/{name} is not here")
    return STACKS / name


def light_up(radiance: Array, direction: Array) -> ImageStack:
    """A stack of radiance (N, H, W, 3) under lamps in these directions (N, 3), by rising elevation."""
    order = np.argsort(direction[:, 2], kind="stable")
    direction = direction[order] / np.linalg.norm(direction[order], axis=1, keepdims=True)
    azimuth = np.arctan2(direction[:, 1], direction[:, 0])
    return stack(radiance[order], np.arcsin(direction[:, 2]), azimuth)


def plain(radiance: Array, direction: Array) -> Array:
    """Normals (H, W, 3) of least squares over all photographs."""
    found = np.linalg.lstsq(direction, radiance.mean(axis=-1).reshape(len(direction), -1), rcond=None)[0]
    found /= np.maximum(np.linalg.norm(found, axis=0), 1e-12)
    return np.asarray(found.T.reshape(*radiance.shape[1:3], 3))


def tga(path: Path) -> Array:
    """(H, W, 3) codes over 255 of an uncompressed TGA file of 24 bits."""
    content = path.read_bytes()
    width, height = int.from_bytes(content[12:14], "little"), int.from_bytes(content[14:16], "little")
    codes = np.frombuffer(content, np.uint8, width * height * 3, 18 + content[0]).reshape(height, width, 3)
    return np.asarray((codes if content[17] & 0x20 else codes[::-1])[..., ::-1] / 255.0)


def test_a_ring_under_a_dome() -> None:
    """Every fourth of 64 lamps, over gold, glass and cloth, of which a diffuse surface explains little."""
    folder = needs("ring_rti64")
    lines = [line.split() for line in (folder / "lights.lp").read_text().splitlines()[1:65]]
    direction = np.array([[float(number) for number in words[-3:]] for words in lines])
    codes = np.stack([np.asarray(cv2.imread(str(folder / words[0])))[4::16, 4::16, ::-1] for words in lines]) / 255.0
    radiance = np.asarray(srgb_decode(codes), np.float64)
    radiance, direction = radiance[::4], direction[::4]
    found = drain(recover(light_up(radiance, direction), np.arange(16)))
    errors = found.maps.errors
    assert errors.in_sample <= errors.left_out < errors.mean_picture
    linear = np.linalg.lstsq(direction, radiance.reshape(16, -1), rcond=None)[0]
    shown = srgb_encode(np.clip(direction @ linear, 0.0, 1.0)).reshape(radiance.shape)
    assert found.maps.mask is not None  # behind the cloth nothing is lit
    assert 0.05 < found.maps.mask.mean() < 0.4
    theirs = 255.0 * np.sqrt(np.mean((shown - srgb_encode(radiance))[:, found.maps.mask > 0.0] ** 2))
    bright = radiance.mean(axis=(0, -1)) > 0.02
    apart = angle_deg(found.maps.normal, plain(radiance, direction))[bright]
    print(f"ring: {np.median(apart):.2f}° from least squares, whose error is {theirs:.2f} codes; {errors}")
    assert errors.in_sample < theirs


def test_a_grey_sphere_is_a_sphere() -> None:
    """The normals of the sphere by its outline; the error of least squares is 5.1°, and shadows no longer bend ours."""
    folder = needs("uw_psm")
    numbers = [line.split() for line in (folder / "lights.txt").read_text().splitlines()[1:13]]
    direction = np.array(numbers, np.float64)
    radiance = np.stack([tga(folder / "gray" / f"gray.{index}.tga") for index in range(12)])
    mask = tga(folder / "gray" / "gray.mask.tga")[..., 0] > 0.5
    rows, columns = np.nonzero(mask)
    radius = 0.5 * (np.ptp(columns) + 1)
    y, x = np.mgrid[: mask.shape[0], : mask.shape[1]]
    x = (x - columns.min() - radius + 0.5) / radius
    y = (rows.min() + radius - 0.5 - y) / radius
    inside = mask & (np.hypot(x, y) < 0.95)
    known = np.stack([x, y, np.sqrt(np.clip(1.0 - x**2 - y**2, 0.0, 1.0))], axis=-1)
    every = np.s_[rows.min() : rows.max() + 1 : 4, columns.min() : columns.max() + 1 : 4]
    maps = drain(recover(light_up(radiance[:, every[0], every[1]], direction), np.arange(12))).maps
    ours = angle_deg(maps.normal, known[every])[inside[every]].mean()
    theirs = angle_deg(plain(radiance, direction), known)[inside].mean()
    print(f"sphere: {ours:.2f}° of ours, {theirs:.2f}° of least squares, {maps.errors}")
    assert ours < theirs < 5.5


def test_a_statue_in_a_matlab_file() -> None:
    content = loadmat(needs("Buddha.mat"))
    images = np.moveaxis(np.asarray(content["I"], np.float64), -1, 0)[:, ::8, ::8]
    direction = np.asarray(content["S"], np.float64) * (1.0, 1.0, 1.0)
    if (direction[:, 2] < 0).all():
        direction = direction * (1.0, 1.0, -1.0)
    radiance = np.repeat((images / images.max())[..., None], 3, axis=-1)
    inside = np.asarray(content["mask"])[::8, ::8] > 0
    found = drain(recover(light_up(radiance, direction), np.arange(len(direction))))
    unit = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    apart = angle_deg(found.maps.normal, plain(radiance, unit))[inside]
    print(f"statue: {np.median(apart):.2f}° from least squares, {found.maps.errors}")
    assert np.median(apart) < 10.0
    assert found.maps.errors.in_sample < found.maps.errors.mean_picture
