"""Procedural samples of the virtual light arc: a tileable height field with its colour and sheen.

Every sample is periodic with its own size, so that it can be shifted by any fraction of a texel and tiled without a
seam. Features scale with the size (24 threads to a tile, whatever its resolution), and equal arguments give the same
bits on every machine with the same numpy.

Conventions: heights in texels (the grid spacing), row 0 on top, +x right, +y up the image, +z towards the camera.
Cost: some tenths of a second and 150 MB at 1024 x 1024.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.core.steps import Step, Steps, drain

Grid = NDArray[np.float64]

_NOTE = "Making the sample"


@dataclass(frozen=True, eq=False)
class Sample:
    """A flat material sample as seen from straight above.

    Attributes
    ----------
    height : (H, W) float32, texels, periodic.
    albedo : (H, W, 3) float32, diffuse reflectance in [0, 1], linear sRGB.
    specular : (H, W, 3) float32, Fresnel reflectance at normal incidence in [0, 1].
    roughness : (H, W) float32, GGX alpha in (0, 1].
    """

    height: NDArray[np.float32]
    albedo: NDArray[np.float32]
    specular: NDArray[np.float32]
    roughness: NDArray[np.float32]

    def __post_init__(self) -> None:
        shape = self.height.shape
        if len(shape) != 2 or (*shape, 3) != self.albedo.shape or self.albedo.shape != self.specular.shape:
            raise ValueError(f"maps of a sample differ in size: {shape}, {self.albedo.shape}, {self.specular.shape}")
        if self.roughness.shape != shape:
            raise ValueError(f"roughness is {self.roughness.shape}, height {shape}")
        for name in ("height", "albedo", "specular", "roughness"):
            map_ = getattr(self, name)
            if map_.dtype != np.float32 or not np.isfinite(map_).all():
                raise ValueError(f"{name} must be finite float32")
            map_.flags.writeable = False
        for name, low in (("albedo", 0.0), ("specular", 0.0), ("roughness", 1e-3)):
            map_ = getattr(self, name)
            if not low <= map_.min() <= map_.max() <= 1.0:
                raise ValueError(f"{name} must lie in [{low:g}, 1]")


def sample(name: str, size: int, seed: int = 1) -> Sample:
    """The sample called `name` (one of `SAMPLES`) on a grid of size x size texels."""
    return drain(making(name, size, seed))


def making(name: str, size: int, seed: int = 1) -> Steps[Sample]:
    """Make the sample called `name` (one of `SAMPLES`) on a grid of size x size texels."""
    if name not in SAMPLES:
        raise ValueError(f"unknown sample {name!r}; choose from {', '.join(SAMPLES)}")
    if not MIN_SIZE <= size <= MAX_SIZE:
        raise ValueError(f"size {size} is outside [{MIN_SIZE}, {MAX_SIZE}]")
    return (yield from SAMPLES[name](size, seed))


def plain(size: int, seed: int = 1) -> Steps[Sample]:
    """A flat, grey, perfectly diffuse card: radiance proportional to the sine of the light's elevation."""
    del seed
    yield Step(0.0, _NOTE)
    return _make(np.zeros((size, size)), np.full(3, 0.5), 0.0, 1.0)


def woven(size: int, seed: int = 1) -> Steps[Sample]:
    """Herringbone cloth: ochre weft over indigo warp, two over and two under, the threads twisted of fibres.

    A thread is an elliptic cylinder about a centre line that rises where it passes over and sinks where it passes
    under; of the two threads at a texel the higher one is seen.
    """
    yield Step(0.0, _NOTE)
    threads, pitch = 24, size / 24
    x, y = _texel_centres(size) / pitch
    wander = _noise(size, seed, 1, 9, 1.0)
    sway = _noise(size, seed + 1, 1, 9, 1.0)
    yield Step(0.2, _NOTE)
    over = _herringbone(threads)
    warp = _threads(x + 0.07 * wander, y, over.T, seed + 2)
    yield Step(0.4, _NOTE)
    weft = _threads(y + 0.07 * sway, x, ~over, seed + 3)
    yield Step(0.6, _NOTE)
    front = np.where(weft[0] > warp[0], 1, 0)
    rise, strand, along, shade = (np.choose(front, pair) for pair in zip(warp, weft, strict=True))
    yield Step(0.8, _NOTE)
    fuzz = _noise(size, seed + 4, size // 12, size // 3, 0.4)
    rise = rise + 0.016 * strand + 0.005 * fuzz
    colour = np.where(front[..., None] == 1, np.array([0.62, 0.42, 0.19]), np.array([0.055, 0.10, 0.22]))
    tone = 1.0 + 0.16 * shade + 0.10 * strand + 0.05 * fuzz + 0.05 * along
    return _make(rise * pitch, colour * tone[..., None], 0.045, 0.34 + 0.03 * fuzz)


def hammer(size: int, seed: int = 1) -> Steps[Sample]:
    """Hand-hammered brass: each blow leaves a spherical dent, and where dents meet they leave a soft ridge."""
    yield Step(0.0, _NOTE)
    blows, spread = 72, size / np.sqrt(72)
    random = np.random.default_rng((seed, 11))
    centres = _relax(random.random((blows, 2)), 2) * size
    depth = random.uniform(-0.10, 0.10, blows)
    yield Step(0.2, _NOTE)
    distance, which = _nearest(size, centres, 5)
    yield Step(0.6, _NOTE)
    dents = (distance / spread) ** 2 * 0.62 + depth[which]
    sharpness = 34.0
    lowest = dents.min(axis=-1, keepdims=True)
    floor = lowest[..., 0] - np.log(np.exp(-sharpness * (dents - lowest)).sum(axis=-1)) / sharpness
    yield Step(0.8, _NOTE)
    grain = _noise(size, seed + 1, size // 8, size // 3, 0.3)
    tarnish = _noise(size, seed + 2, 1, 14, 1.2)
    worn = np.clip((floor - floor.mean()) / (3 * floor.std()) + 0.5, 0, 1)
    height = floor * spread * 0.42 + 0.03 * grain
    albedo = np.array([0.20, 0.125, 0.045]) * (1 + 0.35 * worn + 0.20 * tarnish)[..., None]
    specular = np.array([0.62, 0.46, 0.20]) * (0.80 + 0.15 * worn + 0.05 * tarnish)[..., None]
    return _make(height, albedo, specular, 0.36 - 0.08 * worn + 0.02 * grain)


def leather(size: int, seed: int = 1) -> Steps[Sample]:
    """Saddle leather: rounded pebbles parted by creases (the difference of the two nearest distances), with pores."""
    yield Step(0.0, _NOTE)
    pebbles, spread = 520, size / np.sqrt(520)
    random = np.random.default_rng((seed, 21))
    centres = _relax(random.random((pebbles, 2)), 1) * size
    bend = 0.22 * spread * np.stack([_noise(size, seed + n, 3, 24, 0.8) for n in (1, 2)], axis=-1)
    yield Step(0.3, _NOTE)
    distance, which = _nearest(size, centres, 2, bend)
    yield Step(0.6, _NOTE)
    gap = (distance[..., 1] - distance[..., 0]) / spread
    pebble = 1 - np.exp(-((gap / 0.30) ** 1.5))
    swell = random.uniform(0.75, 1.1, pebbles)[which[..., 0]]
    yield Step(0.8, _NOTE)
    folds = _noise(size, seed + 3, 1, 6, 1.0)
    grain = _noise(size, seed + 4, size // 16, size // 3, 0.5)
    pore = np.clip(_noise(size, seed + 5, 20, size // 4, 0.3) - 1.7, 0, 1)
    height = spread * (0.15 * pebble * swell + 0.06 * folds - 0.06 * pore) + 0.05 * grain
    tone = 0.55 + 0.55 * pebble * swell + 0.06 * folds + 0.04 * grain - 0.25 * pore
    albedo = np.array([0.36, 0.155, 0.062]) * tone[..., None]
    return _make(height, albedo, 0.05, 0.42 - 0.12 * pebble + 0.02 * grain)


def medal(size: int, seed: int = 1) -> Steps[Sample]:
    """A cast bronze medal on a matt ground: a rim, a ring of beads, sixteen rays, and a boss of spiral seeds.

    An object with depth edges, unlike the flat materials. Verdigris lies in its recesses.
    """
    yield Step(0.0, _NOTE)
    x, y = (2 * _texel_centres(size) / size - 1) / 0.8
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    inside = _step((0.985 - radius) / 0.02)
    rim = np.exp(-(((radius - 0.91) / 0.045) ** 4))
    bead_angle = (angle * 48 / (2 * np.pi)) % 1.0 - 0.5
    beads = _dome(np.hypot((radius - 0.79) / 0.036, bead_angle * 2 * np.pi * 0.79 / 48 / 0.036))
    between = _step((radius - 0.36) / 0.03) * _step((0.73 - radius) / 0.03)
    reach = np.clip((0.73 - radius) / 0.37, 0, 1)
    rays = between * np.clip(1 - np.abs(((angle * 16 / (2 * np.pi)) % 1.0 - 0.5) / (0.10 + 0.34 * reach)), 0, 1)
    yield Step(0.3, _NOTE)
    ring = np.exp(-(((radius - 0.345) / 0.02) ** 4))
    count = np.arange(1, 110)
    golden = count * np.pi * (3 - np.sqrt(5))
    seeds = 0.0285 * np.sqrt(count)[:, None] * np.stack([np.cos(golden), np.sin(golden)], axis=-1)

    from scipy.spatial import cKDTree

    distance, _ = cKDTree(seeds).query(np.stack([x, y], axis=-1), workers=-1)
    boss = _step((0.315 - radius) / 0.02) * (0.55 * _dome(radius / 0.42) + 0.42 * _dome(distance / 0.0245))
    yield Step(0.6, _NOTE)
    hammer, grain = _noise(size, seed + 61, 3, 18, 0.6), _noise(size, seed + 62, size // 10, size // 3, 0.3)
    patina = _noise(size, seed + 63, 2, 40, 0.9)
    relief = 0.9 * rim + 0.55 * beads + 0.75 * rays + 0.5 * ring + boss
    height = size * inside * (0.030 + 0.026 * relief) + inside * 0.25 * hammer * size / 256 + 0.04 * grain
    worn = np.clip(0.25 + relief, 0, 1)
    green = np.clip(1.1 - 1.5 * worn + 0.45 * patina, 0, 1)[..., None]
    bronze = np.array([0.17, 0.105, 0.042]) * (0.7 + 0.6 * worn + 0.08 * patina)[..., None]
    verdigris = np.array([0.07, 0.155, 0.115]) * (1 + 0.15 * patina)[..., None]
    metal = bronze * (1 - 0.75 * green) + verdigris * 0.75 * green
    ground = np.array([0.105, 0.10, 0.098]) * (1 + 0.05 * grain + 0.05 * hammer)[..., None]
    cover = inside[..., None]
    shine = np.array([0.50, 0.36, 0.18]) * (1 - 0.8 * green) * (0.35 + 0.65 * worn)[..., None]
    roughness = inside * (0.40 - 0.14 * worn + 0.2 * green[..., 0]) + (1 - inside) * 0.75
    albedo = cover * metal + (1 - cover) * ground
    return _make(height, albedo, cover * shine + (1 - cover) * 0.03, roughness)


def _step(distance: Grid) -> Grid:
    """0 below 0 and 1 beyond 1, smooth between."""
    share = np.clip(distance, 0, 1)
    return np.asarray(share * share * (3 - 2 * share))


def _dome(radius: Grid) -> Grid:
    """Half a sphere of radius one over the plane."""
    return np.asarray(np.sqrt(np.clip(1 - radius * radius, 0, None)))


#: The samples a user can ask for; the first is the program's built-in one.
SAMPLES = {"woven": woven, "hammered": hammer, "leather": leather, "medal": medal, "plain": plain}
MIN_SIZE, MAX_SIZE = 16, 16384


def _make(height: Grid, albedo: Grid, specular: float | Grid, roughness: float | Grid) -> Sample:
    """Clip to the allowed ranges, spread constants over the grid and store in single precision."""
    shape = height.shape
    return Sample(
        height=height.astype(np.float32),
        albedo=np.clip(np.broadcast_to(albedo, (*shape, 3)), 0.0, 1.0).astype(np.float32),
        specular=np.clip(np.broadcast_to(specular, (*shape, 3)), 0.0, 1.0).astype(np.float32),
        roughness=np.clip(np.broadcast_to(roughness, shape), 0.02, 1.0).astype(np.float32),
    )


def _texel_centres(size: int) -> Grid:
    """(2, H, W): x to the right and y up the image, both in texels, at the centres."""
    centre = np.arange(size) + 0.5
    return np.stack(np.broadcast_arrays(centre[None, :], size - centre[:, None]))


def _noise(size: int, seed: int, low: int, high: int, falloff: float) -> Grid:
    """Periodic Gaussian noise, mean 0 and deviation 1, with waves of `low` to `high` periods per tile.

    Amplitudes fall as frequency^-(1 + falloff). A band that the grid cannot hold is cut at its Nyquist frequency.
    """
    high = max(low, min(high, size // 2 - 1))
    random = np.random.default_rng((seed, low, high))
    waves = random.standard_normal((2, 2 * high + 1, high + 1))
    row, column = np.meshgrid(np.arange(-high, high + 1), np.arange(high + 1), indexing="ij")
    frequency = np.hypot(row, column)
    inside = (frequency >= low) & (frequency <= high)
    gain = np.where(inside, np.maximum(frequency, 1.0) ** -(1.0 + falloff), 0.0)
    spectrum = np.zeros((size, size // 2 + 1), complex)
    spectrum[row % size, column] = gain * (waves[0] + 1j * waves[1])
    noise = np.fft.irfft2(spectrum, s=(size, size))
    deviation = noise.std()
    return (noise - noise.mean()) / deviation if deviation > 0 else noise


def _herringbone(threads: int) -> NDArray[np.bool_]:
    """(weft, warp) True where the warp is on top: a 2/2 twill whose diagonal turns every sixth warp thread."""
    warp = np.arange(threads)
    turn = np.where(warp // 6 % 2 == 0, warp, 5 - warp)
    return (turn[None, :] + np.arange(threads)[:, None]) % 4 < 2


def _threads(across: Grid, along: Grid, over: NDArray[np.bool_], seed: int) -> tuple[Grid, Grid, Grid, Grid]:
    """Height (thread pitches), fibre pattern, mottling and tone of one set of parallel threads.

    `across` and `along` count thread pitches; `over` is (this set, crossing set).
    """
    threads = len(over)
    random = np.random.default_rng((seed, 31))
    width, lift, twist, tone = (random.normal(size=threads) for _ in range(4))
    index = np.floor(across).astype(int) % threads
    offset = across - np.floor(across) - 0.5
    half_width = 0.485 * (1 + 0.03 * width[index])
    bulge = np.sqrt(np.clip(1 - (offset / half_width) ** 2, 0, None))
    crown = np.where(np.abs(offset) < half_width, 0.17 * bulge, -0.17)
    height = crown + 0.07 * _centre_line(index, along, over) + 0.012 * lift[index]
    phase = 2 * np.pi * (2.0 * along + twist[index])
    strand = np.cos(3 * np.arcsin(np.clip(offset / half_width, -1, 1)) * 1.6 + phase)
    mottling = np.cos(2 * np.pi * (along * 3 / threads + twist[index])) * tone[index]
    return height, strand * (0.35 + 0.65 * bulge), mottling, tone[index]


def _centre_line(index: NDArray[np.int_], along: Grid, over: NDArray[np.bool_]) -> Grid:
    """Height of each thread's centre line, +1 at the crossings where it is over and -1 where under, eased between."""
    crossings = over.shape[1]
    before = np.floor(along - 0.5)
    ease = 0.5 - 0.5 * np.cos(np.pi * (along - 0.5 - before))
    state = np.where(over, 1.0, -1.0)
    crossing = before.astype(int)
    return (1 - ease) * state[index, crossing % crossings] + ease * state[index, (crossing + 1) % crossings]


def _relax(points: Grid, rounds: int) -> Grid:
    """Points of the unit torus spread more evenly by `rounds` of Lloyd's relaxation on a coarse grid."""
    edge = 128
    for _ in range(rounds):
        _, which = _nearest(edge, points * edge, 1)
        step = (_grid_points(edge) / edge - points[which] + 0.5) % 1.0 - 0.5
        count = np.maximum(np.bincount(which.ravel(), minlength=len(points)), 1)
        shift = [np.bincount(which.ravel(), step[..., axis].ravel(), len(points)) / count for axis in (0, 1)]
        points = (points + np.stack(shift, axis=-1)) % 1.0
    return points


def _grid_points(size: int) -> Grid:
    return np.moveaxis(_texel_centres(size), 0, -1)


def _nearest(size: int, centres: Grid, count: int, bend: Grid | float = 0.0) -> tuple[Grid, NDArray[np.int_]]:
    """Distances (H, W, count) of each texel, displaced by `bend`, to its nearest centres on the torus, and which."""
    from scipy.spatial import cKDTree

    tree = cKDTree(centres % size, boxsize=size)
    distance, which = tree.query((_grid_points(size) + bend) % size, k=count, workers=-1)
    return distance, which
