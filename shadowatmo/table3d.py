"""Float64 twin of the 3D tables: their mappings as pairs of functions, and single texels by quadrature.

Two published tables without azimuth, over height, view zenith and sun zenith. Schafhitzel, Falk, Ertl (2007, Real-Time
Rendering of Planets with Atmospheres) rescale all three linearly; Elek (2009, Rendering Parametrizable Planetary
Atmospheres with Multiple Scattering in Real-Time) crowds texels near the ground and around the low sun and sums K
orders. Neither holds the planet's shadow: frames cut it out. GLSL twins: shaders/table3d_mapping.glsl and
shaders/table3d_single.frag.
"""

import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.errors import ParameterError
from shadowatmo.medium import extinction, scattering
from shadowatmo.quadrature import cumulative_matrix, gauss_legendre
from shadowatmo.ray import Ray, altitude_of, far_root, ground_distance, k_of, safe_sqrt
from shadowatmo.segments import k_along_nodes, node_steps
from shadowatmo.table4d import TexelPaths
from shadowatmo.transmittance import columns_to_top, ozone_crossings, ozone_to, scale_heights
from shadowatmo.validation import choice, integer, number

MAPPINGS = ("linear", "curved")  # Schafhitzel; Elek
DEEPEST = 8.0  # scale heights under the ground at which the sun is out
SUN_SCALE = -math.expm1(-3.6)


@dataclass(frozen=True)
class Table3DSize:
    """Texels along the axes, how they are spread, and the azimuth that is not one of them.

    Parameters
    ----------
    heights, views, suns : int
        Over height, view zenith and sun zenith; at least 2.
    mapping : str
        "linear" (Schafhitzel 2007) or "curved" (Elek 2009).
    azimuth : float
        Azimuth between view and sun that every path of the table has [rad]; 0 as published.
    """

    heights: int = 128
    views: int = 128
    suns: int = 128
    mapping: str = "linear"
    azimuth: float = 0.0

    def __post_init__(self):
        for name in ("heights", "views", "suns"):
            integer(name, getattr(self, name), low=2, high=1024)
        choice("mapping", self.mapping, MAPPINGS)
        object.__setattr__(self, "azimuth", number("azimuth", self.azimuth, low=0, high=math.pi))
        if max(self.texels) > 16384:
            raise ParameterError("views", self.views, "an atlas of at most 16384 texels a side")

    @property
    def columns(self) -> int:
        """Slices side by side: the largest divisor of `heights` up to its square root."""
        return max(n for n in range(1, math.isqrt(self.heights) + 1) if self.heights % n == 0)

    @property
    def texels(self) -> tuple[int, int]:
        """Width and height of the atlas."""
        return self.suns * self.columns, self.views * (self.heights // self.columns)


def altitude_axis(atmosphere, k, mapping):
    """Return the place 0..1 of k [m^2]."""
    if mapping == "curved":
        return np.sqrt(np.clip(k / k_of(atmosphere, atmosphere.thickness), 0.0, 1.0))
    return np.clip(altitude_of(atmosphere, k) / atmosphere.thickness, 0.0, 1.0)


def altitude_axis_k(atmosphere, unit, mapping):
    """Return k [m^2] at a place; the inverse of altitude_axis."""
    if mapping == "curved":
        return unit * unit * k_of(atmosphere, atmosphere.thickness)
    return k_of(atmosphere, unit * atmosphere.thickness)


def sun_axis(mu_s, mapping):
    """Return the place 0..1 of mu_s; suns below mu_s = -0.2857 share the first of the curved one."""
    if mapping == "curved":
        return np.clip(-np.expm1(-2.8 * mu_s - 0.8) / SUN_SCALE, 0.0, 1.0)
    return 0.5 + 0.5 * mu_s


def sun_of_axis(unit, mapping):
    """Return mu_s at a place; the inverse of sun_axis."""
    if mapping == "curved":
        return np.clip((-np.log1p(-SUN_SCALE * unit) - 0.8) / 2.8, -1.0, 1.0)
    return 2.0 * unit - 1.0


def inscatter_place(atmosphere, k, x, sun_height, mapping):
    """Return places (N, 3) along height, view and sun of k [m^2], x = r mu [m] and r mu_s [m]."""
    r = atmosphere.bottom_radius + altitude_of(atmosphere, k)
    places = altitude_axis(atmosphere, k, mapping), 0.5 + 0.5 * x / r, sun_axis(sun_height / r, mapping)
    return np.clip(np.stack(places, axis=-1), 0.0, 1.0)


def inscatter_path(atmosphere, place, mapping, azimuth=0.0) -> TexelPaths:
    """Return the paths at places (N, 3); the inverse of inscatter_place."""
    place = np.asarray(place, np.float64)
    top_k = k_of(atmosphere, atmosphere.thickness)
    k = altitude_axis_k(atmosphere, place[..., 0], mapping)
    r = atmosphere.bottom_radius + altitude_of(atmosphere, k)
    mu, mu_s = 2.0 * place[..., 1] - 1.0, sun_of_axis(place[..., 2], mapping)
    nu = mu * mu_s + math.cos(azimuth) * safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s))
    x = r * mu
    tangent_k = k - x * x
    air = np.maximum(far_root(x, k - top_k, safe_sqrt(top_k - tangent_k)), 0.0)
    ray = Ray(x, k, tangent_k, np.zeros_like(x), air)
    distance = ground_distance(ray)
    ground = distance >= 0.0
    return TexelPaths(ray, np.where(ground, distance, air), ground, r * mu_s, nu)


def texel_places(size, texel):
    """Return places (N, 3) of texels (N, 2) of the atlas, counted from 0."""
    texel = np.asarray(texel)
    column, row = texel[..., 0], texel[..., 1]
    place = [
        ((row // size.views) * size.columns + column // size.suns) / (size.heights - 1),
        (row % size.views) / (size.views - 1),
        (column % size.suns) / (size.suns - 1),
    ]
    return np.stack(place, axis=-1)


def texel_paths(atmosphere, size, texel) -> TexelPaths:
    """Return the paths of texels (N, 2) of the atlas, counted from 0."""
    return inscatter_path(atmosphere, texel_places(size, texel), size.mapping, size.azimuth)


def fading_columns(atmosphere, k, y, terms=6):
    """Return columns (..., 3) [m] to the sun that grow with the depth of their path under the ground.

    In the planet's shadow a table must hold something: this goes on smoothly from the grazing path into the dark.
    """
    columns = columns_to_top(atmosphere, k, y, terms)
    floor = -0.5 * atmosphere.bottom_radius**2
    depth = np.where(y < 0.0, np.maximum(-altitude_of(atmosphere, np.maximum(k - y * y, floor)), 0.0), 0.0)
    columns[..., :2] *= np.exp(np.minimum(depth[..., None] / scale_heights(atmosphere), DEEPEST))
    return columns


def single_scattering(atmosphere, paths, nodes=24):
    """Return single scattering before the phases, molecules and aerosols (N, 3) each, the planet's shadow left out."""
    ray, weights = paths.ray, gauss_legendre(nodes)[1]
    t, steps = node_steps(atmosphere, ray, np.zeros_like(paths.end), paths.end, nodes)
    y = paths.sun_height[:, None] + paths.nu[:, None] * t
    columns = fading_columns(atmosphere, k_along_nodes(ray, t), y)
    columns[..., :2] += np.einsum("ij,njs->nis", cumulative_matrix(nodes), steps)
    if atmosphere.ozone is not None:
        tangent_k, start = np.broadcast_to(ray.tangent_k[:, None], t.shape), np.broadcast_to(ray.x[:, None], t.shape)
        crossings = ozone_crossings(atmosphere, tangent_k)
        columns[..., 2] += ozone_to(atmosphere, tangent_k, crossings, start + t)
        columns[..., 2] -= ozone_to(atmosphere, tangent_k, crossings, start)
    light = weights[:, None] * np.exp(-columns @ extinction(atmosphere))
    rayleigh, mie = scattering(atmosphere)
    return rayleigh * np.einsum("nic,ni->nc", light, steps[..., 0]), mie * np.einsum("nic,ni->nc", light, steps[..., 1])


def ad_hoc_phase(nu):
    """Return Elek's phase of molecules for the sum of all orders (eq. 15) [1/sr]; darkest opposite the sun."""
    return 0.8 * (1.4 + 0.5 * np.asarray(nu, np.float64)) / (4.0 * np.pi)
