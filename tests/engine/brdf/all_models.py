"""The parameter sets on which every model is tested, and the pairs of directions they are tested with."""

from __future__ import annotations

import numpy as np

from engine.core.directions import normalize

TEXTS = (
    "lambert:albedo=0.2/0.5/0.9",
    "oren-nayar:albedo=0.2/0.5/0.9,sigma_deg=35",
    "oren-nayar:sigma_deg=0",
    "phong:kd=0.3/0.2/0.1,ks=0.4,exponent=20",
    "phong:exponent=0",
    "phong:exponent=10000",
    "blinn-phong:kd=0.1,ks=0.6/0.3/0.2,exponent=50",
    "blinn-phong:exponent=1000000",
    "lafortune:kd=0.2,ks=0.3/0.2/0.1,cxy=-0.6,cz=0.5,exponent=30",
    "lafortune:cxy=0.7,cz=0.4,exponent=8",
    "lafortune:cxy=-0.577,cz=0.577,exponent=10000",
    "lafortune:cxy=-0.5,cz=-0.5,exponent=3",
    "lafortune:preset=alum-bronze",
    "lafortune:preset=blue-paint",
    "lafortune:preset=clay",
    "ward:kd=0.1,ks=0.3/0.2/0.1,alpha_x=0.1,alpha_y=0.4",
    "ward:alpha_x=0.0001,alpha_y=0.001",
    "ashikhmin-shirley:kd=0.5,ks=0.05/0.5/1,nu=10,nv=100",
    "ashikhmin-shirley:nu=0,nv=0",
    "ashikhmin-shirley:nu=10000,nv=1000000",
    "cook-torrance:kd=0.2,ks=0.7/0.5/0.3,m=0.2,f0=0.04/0.5/1",
    "cook-torrance:kd=0,ks=1,m=0.0001,f0=0.5",
    "ggx:kd=0.2,alpha=0.3,f0=0.04/0.5/1",
    "ggx:kd=0,alpha=0.0001,f0=0.5",
    "ggx:kd=0,alpha=1,f0=1",
    "ggx:kd=0.2,alpha_x=0.05,alpha_y=0.6,f0=0.04/0.5/1",
    "poulin-fournier:kd=0.2,ks=0.6/0.5/0.3,exponent=40,spacing=2.5,floor=0.2",
    "poulin-fournier:kd=0.2,ks=0.8,exponent=7,spacing=2,floor=0",
    "poulin-fournier:kd=0.1,ks=0.5,exponent=300,spacing=4,floor=0.6",
    "metallic-roughness:base_color=0.2/0.5/0.9,metallic=0.4,roughness=0.5",
    "metallic-roughness:base_color=0.9,metallic=1,roughness=0.01",
    "metallic-roughness:base_color=1/0.6/0.3,metallic=0.9,roughness=0.8,multiple_scattering=1",
)

#: Layers, which are not reciprocal and have no printed formula of one line.
LAYERED = (
    "openpbr:base_color=0.2/0.5/0.9,specular_roughness=0.4,base_diffuse_roughness=0.6,specular_color=1/0.8/0.6",
    "openpbr:base_color=0.9/0.6/0.3,base_metalness=1,specular_color=0.9/0.8/1,thin_film_weight=1,thin_film_ior=1.7",
    "openpbr:coat_weight=0.8,coat_roughness=0.2,coat_color=0.9/0.5/0.4,fuzz_weight=0.4,thin_film_weight=0.5",
    "openpbr:specular_roughness_anisotropy=0.6,coat_weight=0.5,coat_roughness=0.4,coat_roughness_anisotropy=0.3,"
    "rotation_deg=30",
    "metallic-roughness:base_color=1/0.6/0.3,metallic=0.4,roughness=0.5,coat_weight=0.8,coat_roughness=0.3",
    "metallic-roughness:multiple_scattering=1,coat_weight=1,coat_roughness=0",
    "metallic-roughness:metallic=0.4,roughness=0.5,sheen_color=0.9/0.5/0.2,sheen_roughness=0.4,coat_weight=0.5",
    "metallic-roughness:metallic=0.4,roughness=0.5,sheen_color=0.2/0.1/0,sheen_roughness=0.05",
)


def pairs(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions on the upper hemisphere; half of the pairs near their mirror direction, where lobes are."""
    rng = np.random.default_rng(seed)
    wi, wo = (normalize(rng.normal(size=(count, 3))) for _ in range(2))
    wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
    near = wi[::2] * (-1, -1, 1) + 10.0 ** -rng.uniform(0, 4, (len(wi[::2]), 1)) * rng.normal(size=wi[::2].shape)
    wo[::2] = normalize(near)
    wo[:, 2] = np.abs(wo[:, 2])
    return wi, wo
