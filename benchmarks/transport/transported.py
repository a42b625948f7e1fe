"""A frame of baked transport beside the plain Phong model, on one mesh in one window, through the GL code of both."""

from __future__ import annotations

import numpy as np

from benchmarks.measure import Measure, best_of
from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.gl.context import create_context
from engine.gl.direct import DirectRenderer
from engine.gl.transported import TransportRenderer
from engine.light.environment import EnvironmentMap
from engine.scene.scene import Scene
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import view_directions
from engine.transport.gaussian.lighting import GaussianLight, filter_for, levels_for
from engine.transport.gaussian.transfer import GaussianTransport
from engine.transport.relight import RelightGaussians, RelightSh, RelightTransport, RelightWavelets
from engine.transport.sh.brdf_table import tabulate
from engine.transport.sh.transfer import ShTransport
from engine.transport.wavelet.bake import factors_for
from engine.transport.wavelet.transfer import Vectors16, WaveletTransport

BRUSHED = "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=10"
BRDF = "ggx:kd=0.5,alpha=0.3,f0=0.04"

#: The window of Kautz2002.
SIZE = (720, 760)

#: Pairs of frames; the shortest of each kind count.
ROUNDS = 12

#: Of the BRDF, as in Wang2004, and of the spherical harmonics.
TERMS, ORDER = 4, 5


def gl_wavelet_frame() -> Measure:
    """A frame of four terms, looked up at each fragment, under a light that stays."""
    return _frame("gl-wavelet-frame", wavelets())


def wavelets() -> RelightWavelets:
    """A mesh with random light in four terms of each vertex."""
    mesh = shape("torus-knot")
    factors = drain(factors_for(brdf_from_text(BRUSHED), TERMS))
    rows = len(mesh.positions) * TERMS
    nothing = Vectors16(
        np.zeros((rows, 1), np.uint16),
        np.zeros((rows, 1), np.uint32),
        np.zeros((rows, 3), np.float32),
        np.zeros(rows, np.uint16),
    )
    transport = WaveletTransport(mesh, len(mesh.positions), factors, 0.0, 64, nothing)
    return RelightWavelets(transport, np.random.default_rng(0).random((rows, 3)))


def gl_sh_frame() -> Measure:
    """A frame of spherical harmonics of order 5, evaluated at each vertex, under a light that stays."""
    return _frame("gl-sh-frame", spherical_harmonics())


def gl_sh_frame_brushed() -> Measure:
    """The same of a BRDF that is not isotropic, whose table is a map of the hemisphere."""
    return _frame("gl-sh-frame-brushed", spherical_harmonics(BRUSHED))


def spherical_harmonics(brdf: str = BRDF) -> RelightSh:
    """A mesh with random light in the harmonics of each vertex."""
    mesh = shape("torus-knot")
    table = drain(tabulate(brdf_from_text(brdf), ORDER))
    rows = np.random.default_rng(0).random((len(mesh.positions) * ORDER**2, 3))
    matrices = np.broadcast_to(np.float32(0.0), (len(rows), 1, ORDER**2))
    transport = ShTransport(mesh, len(mesh.positions), False, 0.0, table, False, matrices)
    return RelightSh(transport, rows)


def gl_gaussian_frame() -> Measure:
    """A frame of one lobe and a diffuse part, under an environment and a light that stays."""
    return _frame("gl-gaussian-frame", gaussians())


def gaussians() -> RelightGaussians:
    """A mesh with one lobe and diffuse light of each vertex, under random light."""
    mesh = shape("torus-knot")
    transport = GaussianTransport(mesh, len(mesh.positions), 0.0, (mirror_lobes(mesh),), None)
    environment = EnvironmentMap(np.random.default_rng(0).random((128, 256, 3)).astype(np.float32))
    light = GaussianLight(filter_for(environment, levels_for(transport.components)))
    return RelightGaussians(transport, light, np.ones((len(mesh.positions), 3)))


def mirror_lobes(mesh: Mesh, sigma: float = 0.1) -> Lobes:
    """One lobe of each vertex about every mirrored view, from 1 to 2 `sigma` wide; black below the horizon."""
    normals, views = normalize(mesh.normals), view_directions()
    cosine = normals @ views.T
    mean = 2.0 * cosine[..., None] * normals[:, None] - views
    weight = np.repeat(np.where(cosine > 0.0, 1.0, 0.0)[..., None], 3, axis=-1)
    width = sigma * (2.0 - np.abs(cosine))
    return Lobes(*(np.asarray(array[:, :, None], np.float32) for array in (weight, mean, width)))


def _frame(name: str, relit: RelightTransport) -> Measure:
    camera = frame(relit.mesh.positions, SIZE[0] / SIZE[1])
    plain = Scene(relit.mesh, camera, brdf_from_text("phong:exponent=20"))
    with create_context() as context:
        drawing, direct = TransportRenderer(context), DirectRenderer(context)
        target = context.framebuffer([context.renderbuffer(SIZE)])

        def draw_lit() -> None:
            drawing.draw(relit, camera, target, SIZE, samples=1)
            context.finish()

        def draw_plain() -> None:
            direct.draw(plain, target, SIZE, samples=1)
            context.finish()

        # in turn, so that whatever else the machine does disturbs both alike
        rounds = [(best_of(draw_lit, 1), best_of(draw_plain, 1)) for _ in range(ROUNDS)]
        time_s, limit_s = (min(times) for times in zip(*rounds, strict=True))
        drawing.release()
        direct.release()
        target.release()
    more = {"vertices": len(relit.mesh.positions), "target_ratio": 2.0}
    return Measure(name, time_s, limit_s, "the same frame of the plain Phong model", more)
