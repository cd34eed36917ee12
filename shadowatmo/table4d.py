"""Float64 twin of the 4D table: its mapping as a pair of functions, and single texels by quadrature.

The table of Bruneton and Neyret (2008, Precomputed Atmospheric Scattering) over r, mu, mu_s, nu, in the mapping of
Bruneton 2017: r by the distance to the horizon, mu by the distance to where the ray ends, apart for rays that meet the
ground and rays that do not, mu_s by a rational function of the distance to the top at sea level, nu linearly. GLSL
twins: shaders/table4d_mapping.glsl and shaders/table4d_single.frag.
"""

import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.errors import ParameterError
from shadowatmo.medium import densities, extinction, scattering
from shadowatmo.phase import mie_phase, rayleigh_phase
from shadowatmo.quadrature import cumulative_matrix, gauss_legendre
from shadowatmo.ray import Ray, altitude_of, far_root, k_of, safe_sqrt
from shadowatmo.segments import add_lit, k_along_nodes, make_map, map_node, no_inscatter, pass_gap
from shadowatmo.shadow import AxisRay, cone_interval, cylinder
from shadowatmo.transmittance import columns_to_top, ozone_crossings, ozone_to, transmittance_to_top
from shadowatmo.validation import integer

NODES = 24  # of a piece of a texel's path


@dataclass(frozen=True)
class Table4DSize:
    """Texels along the four axes.

    Parameters
    ----------
    heights, views, suns, cosines : int
        Over r, mu (even: half for rays that meet the ground), mu_s and nu; at least 2, views at least 4.
    """

    heights: int = 32
    views: int = 128
    suns: int = 32
    cosines: int = 8

    def __post_init__(self):
        for name in ("heights", "suns", "cosines"):
            integer(name, getattr(self, name), low=2, high=512)
        if integer("views", self.views, low=4, high=1024) % 2:
            raise ParameterError("views", self.views, "an even number: half of the views meet the ground")

    @property
    def texels(self) -> tuple[int, int]:
        """Width and height of the atlas."""
        return self.suns * self.cosines, self.views * self.heights


@dataclass(frozen=True, eq=False)
class TexelPaths:
    """View paths (N,) and the sun over their base points.

    ray : base points in k and x; end : length [m]; ground : whether it ends there; sun_height [m] = r mu_s; nu.
    """

    ray: Ray
    end: np.ndarray
    ground: np.ndarray
    sun_height: np.ndarray
    nu: np.ndarray


def lowest_sun(atmosphere) -> float:
    """Return the lowest mu_s of the axis: three dips of the horizon, beyond which no ray from the top meets light."""
    dip = math.acos(atmosphere.bottom_radius / atmosphere.top_radius)
    return -math.sin(min(math.radians(85.0), 3.0 * dip))


def rational_sun(atmosphere, mu_s):
    """Return the distance to the top at sea level, 0 at the zenith and 1 at the horizon."""
    top_k = k_of(atmosphere, atmosphere.thickness)
    y = atmosphere.bottom_radius * np.asarray(mu_s, np.float64)
    distance = far_root(y, -top_k, np.sqrt(y * y + top_k))
    return (distance - atmosphere.thickness) / (np.sqrt(top_k) - atmosphere.thickness)


def sun_axis(atmosphere, mu_s):
    """Return the place 0..1 of mu_s."""
    a = rational_sun(atmosphere, mu_s)
    return np.maximum(1.0 - a / rational_sun(atmosphere, lowest_sun(atmosphere)), 0.0) / (1.0 + a)


def sun_of_axis(atmosphere, unit):
    """Return mu_s at a place 0..1; the inverse of sun_axis."""
    lowest = rational_sun(atmosphere, lowest_sun(atmosphere))
    top_k = k_of(atmosphere, atmosphere.thickness)
    a = lowest * (1.0 - unit) / (1.0 + unit * lowest)
    distance = atmosphere.thickness + a * (np.sqrt(top_k) - atmosphere.thickness)
    return np.clip((top_k - distance**2) / (2.0 * distance * atmosphere.bottom_radius), -1.0, 1.0)


def inscatter_place(atmosphere, k, x, sun_height, nu, ground):
    """Return places (N, 4) along r, mu (in its half), mu_s and nu.

    Parameters
    ----------
    k, x, sun_height : (N,) float
        r^2 - Rb^2 [m^2], r mu [m], r mu_s [m].
    nu : (N,) float
        Cosine of view and sun.
    ground : (N,) bool
        Whether the ray meets the ground.
    """
    top_k = k_of(atmosphere, atmosphere.thickness)
    rho, rho_top = safe_sqrt(k), np.sqrt(top_k)
    altitude = altitude_of(atmosphere, k)
    to_ground = k / np.maximum(safe_sqrt(x * x - k) - x, 1e-30)
    to_top = far_root(x, k - top_k, safe_sqrt(x * x + top_k - k))
    nearest = np.where(ground, altitude, atmosphere.thickness - altitude)
    farthest = np.where(ground, rho, rho + rho_top)
    view = (np.where(ground, to_ground, to_top) - nearest) / np.maximum(farthest - nearest, 1e-6 * rho_top)
    sun = sun_axis(atmosphere, np.clip(sun_height / (atmosphere.bottom_radius + altitude), -1.0, 1.0))
    return np.clip(np.stack([rho / rho_top, view, sun, 0.5 + 0.5 * nu], axis=-1), 0.0, 1.0)


def inscatter_path(atmosphere, place, ground) -> TexelPaths:
    """Return the paths at places (N, 4); the inverse of inscatter_place.

    A nu that no path of its mu and mu_s has is moved to the nearest that one has.
    """
    place = np.asarray(place, np.float64)
    top_k = k_of(atmosphere, atmosphere.thickness)
    rho_top = np.sqrt(top_k)
    rho = place[..., 0] * rho_top
    k = rho * rho
    altitude = altitude_of(atmosphere, k)
    r = atmosphere.bottom_radius + altitude
    nearest = np.where(ground, altitude, atmosphere.thickness - altitude)
    farthest = np.where(ground, rho, rho + rho_top)
    d = nearest + place[..., 1] * (farthest - nearest)
    safe = np.where(d > 1e-3, d, 1.0)
    x = np.where(d > 1e-3, -0.5 * (safe + np.where(ground, k, k - top_k) / safe), np.where(ground, -r, r))
    x = np.where(ground, np.clip(x, -r, -rho), np.clip(x, -rho, r))
    mu, mu_s = x / r, sun_of_axis(atmosphere, place[..., 2])
    spread = safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s))
    nu = np.clip(2.0 * place[..., 3] - 1.0, mu * mu_s - spread, mu * mu_s + spread)
    tangent_k = np.where(ground, np.minimum(k - x * x, 0.0), np.where(x < 0, np.maximum(k - x * x, 0.0), k - x * x))
    return TexelPaths(Ray(x, k, tangent_k, np.zeros_like(x), d), d, np.broadcast_to(ground, x.shape), r * mu_s, nu)


def texel_places(size, texel):
    """Return places (N, 4) and which half of mu of texels (N, 2) of the atlas, counted from 0."""
    texel = np.asarray(texel)
    half = size.views // 2
    column, row = texel[..., 0], texel[..., 1]
    view = row % size.views
    ground = view < half
    place = [
        (row // size.views) / (size.heights - 1),
        np.where(ground, view, view - half) / (half - 1),
        (column % size.suns) / (size.suns - 1),
        (column // size.suns) / (size.cosines - 1),
    ]
    return np.stack(place, axis=-1), ground


def texel_paths(atmosphere, size, texel) -> TexelPaths:
    """Return the paths of texels (N, 2) of the atlas, counted from 0."""
    return inscatter_path(atmosphere, *texel_places(size, texel))


def shadow_cuts(atmosphere, paths):
    """Return the cuts (N, 4) [m] of paths: near end, where the planet's shadow begins and ends, far end."""
    z, nu = -paths.sun_height, paths.nu
    across = np.maximum(1.0 - nu * nu, 0.0)
    drift = paths.ray.x + z * nu
    r = atmosphere.bottom_radius + altitude_of(atmosphere, paths.ray.k)
    impact = safe_sqrt(across * (r - z) * (r + z) - drift * drift)
    start, stop = cone_interval(
        AxisRay(z, -nu, across, drift, impact, paths.ray.k - z * z), cylinder(atmosphere.bottom_radius)
    )
    dark = np.clip(start, 0.0, paths.end)
    return np.stack([np.zeros_like(dark), dark, np.clip(stop, dark, paths.end), paths.end], axis=1)


def single_scattering(atmosphere, paths, nodes=NODES):
    """Return single scattering before the phases, molecules and aerosols (N, 3) each, of paths."""
    near, dark, light, far = shadow_cuts(atmosphere, paths).T
    total = no_inscatter(len(far))
    add_lit(atmosphere, paths.ray, paths.sun_height, paths.nu, near, dark, total, nodes)
    pass_gap(atmosphere, paths.ray, dark, light, total, nodes)
    add_lit(atmosphere, paths.ray, paths.sun_height, paths.nu, light, far, total, nodes)
    rayleigh, mie = scattering(atmosphere)
    return rayleigh * total.rayleigh, mie * total.mie


def path_transmittance(atmosphere, paths):
    """Return the transmittance (N, 3) of whole paths."""
    sense = np.where(paths.ground, -1.0, 1.0)
    ray = paths.ray
    far_k = np.where(paths.ground, 0.0, ray.k + paths.end * (paths.end + 2.0 * ray.x))
    near = columns_to_top(atmosphere, ray.k, sense * ray.x)
    far = columns_to_top(atmosphere, far_k, sense * (ray.x + paths.end))
    return np.exp(-np.maximum(sense[:, None] * (near - far), 0.0) @ extinction(atmosphere))


def first_order(atmosphere, paths, nodes=NODES):
    """Return the radiance (N, 3) of the first order: single scattering, and the sunlit ground at the end of a path."""
    rayleigh, mie = single_scattering(atmosphere, paths, nodes)
    radiance = rayleigh_phase(paths.nu)[:, None] * rayleigh + mie_phase(paths.nu, atmosphere.mie_g)[:, None] * mie
    height = np.maximum(paths.sun_height + paths.nu * paths.end, 0.0)
    direct = transmittance_to_top(atmosphere, np.zeros_like(height), height)
    direct *= (height / atmosphere.bottom_radius)[:, None]
    reflected = path_transmittance(atmosphere, paths) * np.array(atmosphere.ground_albedo) / np.pi * direct
    return radiance + np.where(paths.ground[:, None], reflected, 0.0)


def paths_around(atmosphere, k, mu_s, above, below, around):
    """Return the paths from one point in all directions, their mu, azimuths and weights [sr], all (D,)."""
    r = atmosphere.bottom_radius + altitude_of(atmosphere, k)
    horizon = -math.sqrt(max(k, 0.0)) / r
    (up, up_weights), (down, down_weights) = gauss_legendre(above), gauss_legendre(below)
    mu = np.concatenate([horizon + (1.0 - horizon) * up**2, horizon - (1.0 + horizon) * down**2])
    weights = np.concatenate([(1.0 - horizon) * 2 * up * up_weights, (1.0 + horizon) * 2 * down * down_weights])
    azimuth = np.pi * (np.arange(around) + 0.5) / around
    mu, azimuth = (a.ravel() for a in np.meshgrid(mu, azimuth, indexing="ij"))
    weights = np.repeat(weights, around) * 2 * np.pi / around
    nu = mu * mu_s + safe_sqrt((1.0 - mu * mu) * (1.0 - mu_s * mu_s)) * np.cos(azimuth)
    ground = np.repeat(np.arange(above + below) >= above, around)
    x, k = r * mu, np.full_like(mu, k)
    tangent_k = np.where(ground, np.minimum(k - x * x, 0.0), k - x * x)
    top_k = k_of(atmosphere, atmosphere.thickness)
    top = far_root(x, k - top_k, safe_sqrt(top_k - tangent_k))
    end = np.where(ground, k / (safe_sqrt(-tangent_k) - x + 1e-30), np.maximum(top, 0.0))
    ray = Ray(x, k, tangent_k, np.zeros_like(x), end)
    return TexelPaths(ray, end, ground, np.full_like(mu, r * mu_s), nu), mu, azimuth, weights


def gathered_first_order(atmosphere, k, mu_s, mu, nu, directions=(24, 24, 48)):
    """Return the mean (2 species, 3) of the first order's radiance at one point, weighted by the phase functions.

    mu, nu : zenith cosine of the direction one looks in, and its cosine with the sun's.
    """
    paths, mu_w, azimuth, weights = paths_around(atmosphere, k, mu_s, *directions)
    radiance = first_order(atmosphere, paths, 12) * weights[:, None]
    sine = math.sqrt(max(1.0 - mu * mu, 0.0))
    spread = sine * math.sqrt(max(1.0 - mu_s * mu_s, 0.0))
    turn = math.acos(min(max((nu - mu * mu_s) / spread, -1.0), 1.0)) if spread > 1e-9 else 0.0
    result = np.zeros((2, 3))
    for side in (-1.0, 1.0):
        cosine = mu * mu_w + sine * safe_sqrt(1.0 - mu_w * mu_w) * np.cos(side * azimuth - turn)
        result[0] += 0.5 * rayleigh_phase(cosine) @ radiance
        result[1] += 0.5 * mie_phase(cosine, atmosphere.mie_g) @ radiance
    return result


def second_order(atmosphere, paths, nodes=10, directions=(16, 16, 24)):
    """Return the second order's radiance (N, 3) of paths, by nested quadrature; slow, for single texels."""
    s, weights = gauss_legendre(nodes)
    ray = paths.ray
    t, dt = map_node(make_map(atmosphere, ray, np.zeros_like(paths.end), paths.end), s)
    k = k_along_nodes(ray, t)
    altitude = altitude_of(atmosphere, k)
    density = densities(atmosphere, altitude)[..., :2]
    steps = density * dt[..., None]
    columns = np.zeros((*t.shape, 3))
    columns[..., :2] = np.einsum("ij,njs->nis", cumulative_matrix(nodes), steps)
    if atmosphere.ozone is not None:
        tangent_k = np.broadcast_to(ray.tangent_k[:, None], t.shape)
        crossings, start = ozone_crossings(atmosphere, tangent_k), np.broadcast_to(ray.x[:, None], t.shape)
        columns[..., 2] = ozone_to(atmosphere, tangent_k, crossings, start + t)
        columns[..., 2] -= ozone_to(atmosphere, tangent_k, crossings, start)
    clear = weights[:, None] * np.exp(-columns @ extinction(atmosphere))
    r = atmosphere.bottom_radius + altitude
    result = np.zeros((len(paths.end), 3))
    for i, j in np.ndindex(t.shape):
        mu, mu_s = (ray.x[i] + t[i, j]) / r[i, j], (paths.sun_height[i] + paths.nu[i] * t[i, j]) / r[i, j]
        gathered = gathered_first_order(atmosphere, k[i, j], mu_s, mu, paths.nu[i], directions)
        result[i] += clear[i, j] * np.einsum("s,sc,sc->c", steps[i, j], scattering(atmosphere), gathered)
    return result
