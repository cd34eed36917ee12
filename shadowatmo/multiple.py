"""Multiple scattering: a small table of the source of all orders from the second on, and its float64 solver.

Successive orders of the radiance field L_n(h, mu_s; v), v = direction one looks, on a grid of h and mu_s:

    L_1 = single scattering + sunlit ground,  L_n = integral of T J_n dt + T albedo/pi E_(n-1)(ground),
    J_n = scattering(h) . <L_(n-1), P>,       E_n(mu_s) = integral over the upper half of L_n mu at the ground.

<L, P> goes through real spherical harmonics about the local zenith, azimuth counted from the sun (even in it, so m >= 0
only): with the moments a_lm of L it is sum lambda_l a_lm Y_lm(v), lambda_l the Legendre coefficients of the phase
function. Every order's source is resolved into a table over (mu, azimuth; mu_s, altitude) and gathered from there; the
series ends in a geometric tail. Molecules scatter no degree above 2: three coefficients say all that they send.
The table over directions is for aerosols alone, and ends where there are hardly any. What the forward lobe has above
the table's degree is summed analytically in the small-angle limit (aureole_source).

GPU twin: shaders/multiple*.glsl and shaders/multiple_*.frag. Angular units: per steradian, per unit solar irradiance.
"""

import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.harmonics import aureole_kernel, band_coefficients, harmonic_indices, phase_moments, polar_basis
from shadowatmo.medium import densities, extinction, optical_depth, scattering
from shadowatmo.multiple_axes import (
    azimuth_coordinate,
    azimuth_cosine,
    azimuth_fit,
    finer_heights,
    finer_suns,
    height_coordinate,
    height_of,
    highest_layer,
    interpolate,
    layer_step,
    polar_fit,
    sun_coordinate,
    sun_height,
)
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.phase import rayleigh_phase
from shadowatmo.quadrature import cumulative_matrix, gauss_legendre
from shadowatmo.ray import Ray, altitude_of, ground_distance, k_of, make_ray, safe_sqrt
from shadowatmo.segments import k_along_nodes, make_map, map_node
from shadowatmo.shadow import AxisRay, cone_interval, cylinder
from shadowatmo.transmittance import columns_to_top, ozone_crossings, ozone_to

DARK = 1e-30  # floor under logarithms
AUREOLE_TEXELS = 256


def gather_polar(atmosphere, altitude, above, below):
    """Return mu and weights (N, above + below) of gathered directions: Gauss nodes squared away from the horizon."""
    k = k_of(atmosphere, altitude)
    horizon = (-np.sqrt(k) / (atmosphere.bottom_radius + altitude))[:, None]
    up, up_weights = gauss_legendre(above)
    down, down_weights = gauss_legendre(below)
    mu = np.concatenate([horizon + (1.0 - horizon) * up**2, horizon - (1.0 + horizon) * down**2], axis=1)
    weights = [(1.0 - horizon) * 2 * up * up_weights, (1.0 + horizon) * 2 * down * down_weights]
    return mu, np.concatenate(weights, axis=1)


@dataclass(eq=False)
class Piece:
    """Quadrature nodes of one piece of P paths, n nodes each.

    rays : (P,) which paths; weight : (P, n, 3) [m], times the transmittance to the eye; density : (P, n, 2);
    altitude [m], mu, mu_s : (P, n); light : (P, n, 3) transmittance to the sun, 0 in shadow; sun_column : (P, n) [m] of
    aerosols towards the sun; gain : (P, 3), see `gain`.
    """

    rays: np.ndarray
    weight: np.ndarray
    density: np.ndarray
    altitude: np.ndarray
    mu: np.ndarray
    mu_s: np.ndarray
    light: np.ndarray
    sun_column: np.ndarray
    gain: np.ndarray


def gain(taken, lost):
    """Return what keeps few nodes from scattering more light than a piece takes out of a ray, at most 1.

    In air so thick that the nodes step over many mean free paths, the orders of scattering would grow without bound.
    """
    return np.minimum(1.0, np.maximum(taken, 0.0) / np.maximum(lost, DARK))


def path_pieces(atmosphere, ray, sun_height, nu, cuts, nodes, gap_nodes):
    """Return the pieces of paths cut at `cuts` (N, 4) [m] and the columns (N, 3) [m] of the whole paths.

    sun_height, nu (N,) = P . s [m] at the base points and cosine of ray and sun. Empty pieces are left out.
    """
    columns = np.zeros((len(cuts), 3))
    pieces = []
    for number, count in enumerate((nodes, gap_nodes, nodes)):
        near, far = cuts[:, number], cuts[:, number + 1]
        rays = np.flatnonzero(far > near)
        if len(rays):
            part = Ray(**{name: value[rays] for name, value in vars(ray).items()})
            lit = number != 1
            sun, ends = (sun_height[rays], nu[rays]), (near[rays], far[rays])
            pieces.append(_piece(atmosphere, part, rays, sun, ends, count, lit, columns))
    if atmosphere.ozone is not None:
        crossings = ozone_crossings(atmosphere, ray.tangent_k)
        inside = ozone_to(atmosphere, ray.tangent_k, crossings, ray.x + cuts[:, 3])
        columns[:, 2] = inside - ozone_to(atmosphere, ray.tangent_k, crossings, ray.x)
    return pieces, columns


def _piece(atmosphere, ray, rays, sun, ends, count, lit, columns):
    """Return one piece, and add its columns to `columns`."""
    s, weights = gauss_legendre(count)
    t, dt = map_node(make_map(atmosphere, ray, *ends), s)
    k = k_along_nodes(ray, t)
    altitude = altitude_of(atmosphere, k)
    density = densities(atmosphere, altitude)[..., :2]
    steps = density * dt[..., None]
    before, ends_columns = np.zeros((*t.shape, 3)), np.zeros((len(rays), 2, 3))
    ends_columns[:, 0, :2] = columns[rays, :2]
    before[..., :2] = columns[rays, None, :2] + np.einsum("ij,njs->nis", cumulative_matrix(count), steps)
    columns[rays, :2] += np.einsum("j,njs->ns", weights, steps)
    ends_columns[:, 1, :2] = columns[rays, :2]
    if atmosphere.ozone is not None:
        tangent_k = np.broadcast_to(ray.tangent_k[:, None], t.shape)
        crossings = ozone_crossings(atmosphere, tangent_k)
        start = ozone_to(atmosphere, tangent_k, crossings, np.broadcast_to(ray.x[:, None], t.shape))
        before[..., 2] = ozone_to(atmosphere, tangent_k, crossings, ray.x[:, None] + t) - start
        x = ray.x[:, None] + np.stack(ends, axis=1)
        ends_columns[..., 2] = ozone_to(atmosphere, tangent_k[:, :2], crossings[:, :2], x) - start[:, :2]
    r = atmosphere.bottom_radius + altitude
    y = sun[0][:, None] + sun[1][:, None] * t
    light, sun_column = np.zeros((*t.shape, 3)), np.zeros(t.shape)
    if lit:
        sun_columns = columns_to_top(atmosphere, k, y)
        light, sun_column = np.exp(-optical_depth(atmosphere, sun_columns)), sun_columns[..., 1]
    weight = (weights * dt)[..., None] * np.exp(-optical_depth(atmosphere, before))
    clear = np.exp(-optical_depth(atmosphere, ends_columns))
    lost = np.sum(weight * (density @ extinction(atmosphere)[:2]), axis=1)
    return Piece(
        rays=rays,
        weight=weight,
        density=density,
        altitude=altitude,
        mu=(ray.x[:, None] + t) / r,
        mu_s=y / r,
        light=light,
        sun_column=sun_column,
        gain=gain(clear[:, 0] - clear[:, 1], lost),
    )


class Gather:
    """All rays of a gather: (heights, suns, polar, azimuths) directions at the table's nodes, with their pieces."""

    def __init__(self, atmosphere, recipe, effort):
        self.atmosphere = atmosphere
        altitude = height_of(atmosphere, np.linspace(0.0, 1.0, recipe.heights))
        mu_s = sun_height(atmosphere, np.linspace(0.0, 1.0, recipe.suns))
        self.polar, self.polar_weights = gather_polar(atmosphere, altitude, effort.above, effort.below)
        self.azimuth = effort.azimuths
        self.shape = (recipe.heights, recipe.suns, effort.polar, effort.around)
        mu = np.broadcast_to(self.polar[:, None, :, None], self.shape).ravel()
        h = np.broadcast_to(altitude[:, None, None, None], self.shape).ravel()
        sun = np.broadcast_to(mu_s[None, :, None, None], self.shape).ravel()
        cosine = np.broadcast_to(np.cos(self.azimuth), self.shape).ravel()
        self.nu = mu * sun + safe_sqrt((1.0 - mu * mu) * (1.0 - sun * sun)) * cosine
        ray, sun_y, cuts, self.hits = point_paths(atmosphere, h, mu, sun, self.nu)
        self.pieces, columns = path_pieces(atmosphere, ray, sun_y, self.nu, cuts, effort.nodes, effort.gap_nodes)
        self.transmittance = np.exp(-optical_depth(atmosphere, columns))
        self.ground_sun = (sun_y + self.nu * cuts[:, 3]) / atmosphere.bottom_radius

    def first(self, band):
        """Return L_1 (rays, 3): single scattering by a phase function up to degree `band`, and the sunlit ground."""
        phase = np.polynomial.legendre.legval(self.nu, band_coefficients(self.atmosphere.mie_g, band))
        phases = np.stack([rayleigh_phase(self.nu), phase], axis=-1)
        radiance = np.zeros((len(self.nu), 3))
        for piece in self.pieces:
            source = np.einsum("pns,ps,sc->pnc", piece.density, phases[piece.rays], scattering(self.atmosphere))
            radiance[piece.rays] += np.sum(piece.weight * piece.light * source, axis=1)
        mu_s = np.maximum(self.ground_sun, 0.0)
        sun = np.exp(-columns_to_top(self.atmosphere, np.zeros_like(mu_s), mu_s * self.atmosphere.bottom_radius)
                     @ extinction(self.atmosphere))  # fmt: skip
        return radiance + self._ground(mu_s[:, None] * sun)

    def following(self, table):
        """Return L_n (rays, 3) from the table of the order before."""
        radiance = np.zeros((len(self.nu), 3))
        for piece in self.pieces:
            nu = np.broadcast_to(self.nu[piece.rays, None], piece.mu.shape)
            source = table.source(piece.altitude, piece.mu_s, piece.mu, nu)
            radiance[piece.rays] += piece.gain * np.sum(piece.weight * source, axis=1)
        return np.maximum(radiance, 0.0) + self._ground(table.ground_irradiance(self.ground_sun))

    def _ground(self, irradiance):
        albedo = np.array(self.atmosphere.ground_albedo)
        return self.hits[:, None] * self.transmittance * albedo / np.pi * irradiance

    def moments(self, radiance, degree):
        """Return a_lm (heights, suns, coefficients, 3) and the ground's irradiance (suns, 3)."""
        radiance = radiance.reshape(*self.shape, 3)
        turn = 2.0 * np.pi / self.shape[3]
        fourier = np.einsum("hsiac,am->hsimc", radiance, turn * np.cos(np.outer(self.azimuth, np.arange(degree + 1))))
        basis = self.polar_weights[..., None] * polar_basis(self.polar, degree)
        m = harmonic_indices(degree)[1]
        moments = np.einsum("hsikc,hik->hskc", fourier[:, :, :, m], basis)
        up = np.where(self.polar[0] > 0.0, self.polar[0] * self.polar_weights[0], 0.0)
        return moments, np.einsum("i,sic->sc", up, fourier[0, :, :, 0])


def point_paths(atmosphere, altitude, mu, mu_s, nu):
    """Return rays, P . s [m], cuts (N, 4) [m] and whether the ground ends them, of directions at points."""
    k = k_of(atmosphere, altitude)
    r = atmosphere.bottom_radius + altitude
    ray = make_ray(atmosphere, r * mu, k, k - (r * mu) ** 2)
    z = -r * mu_s
    across = np.maximum(1.0 - nu * nu, 0.0)
    drift = ray.x + z * nu
    impact = safe_sqrt(across * (r * r - z * z) - drift * drift)
    start, stop = cone_interval(AxisRay(z, -nu, across, drift, impact, k - z * z), cylinder(atmosphere.bottom_radius))
    ground = ground_distance(ray)
    hits = (ground >= 0.0) & (mu < 0.0)
    end = np.where(hits, ground, ray.air)
    dark = np.clip(start, 0.0, end)
    return ray, -z, np.stack([np.zeros_like(end), dark, np.clip(stop, dark, end), end], axis=1), hits


class MultipleTable:
    """The source of a radiance field, for lookups; the field's own order is whatever its moments hold.

    Attributes
    ----------
    values : (layers, suns, polar, azimuths, 3)
        Source of aerosols over scattering coefficient and mean radiance.
    level : (finer heights, finer suns, 3)
        Logarithm of the mean radiance [1/sr].
    molecules : (finer heights, finer suns, 3, 3)
        What molecules scatter, over coefficient and mean radiance, beyond 1: coefficients of 3/2 mu^2 - 1/2, of
        mu sin cos(azimuth), and of sin^2 cos(2 azimuth).
    ground : (finer suns, 3)
        Logarithm of the field's irradiance of the ground.
    """

    def __init__(self, atmosphere, recipe, moments, irradiance):
        self.atmosphere, self.recipe = atmosphere, recipe
        l, m = harmonic_indices(recipe.degree)  # noqa: E741
        mean = np.maximum(moments[:, :, 0] / math.sqrt(4.0 * np.pi), DARK)
        shape = moments / mean[:, :, None]
        place = np.arange(recipe.layers) * layer_step(atmosphere, recipe)
        low = np.minimum(place.astype(int), recipe.heights - 2)
        part = (place - low)[:, None, None, None]
        scaled = (1.0 - part) * shape[low] + part * shape[low + 1]
        scaled *= phase_moments(atmosphere.mie_g, recipe.degree)[l, None]
        basis = polar_fit(recipe.polar, recipe.degree)
        turns = azimuth_fit(recipe.azimuths, recipe.degree)
        per_m = [scaled[:, :, m == n].transpose(0, 1, 3, 2) @ basis[:, m == n].T for n in range(recipe.degree + 1)]
        # A truncated series may dip below zero beside a sharp peak.
        self.values = np.clip(np.einsum("mhsci,am->hsiac", np.stack(per_m), turns), 0.0, 6e4)
        self.level = finer_heights(finer_suns(np.log(mean)))
        norms = 0.1 * np.sqrt(np.array([5.0, 15.0, 3.75]) / (4.0 * np.pi))  # the phase moment times those of degree 2
        second = shape[:, :, l == 2] * norms[:, None]
        self.molecules = np.stack([finer_heights(finer_suns(second[:, :, i])) for i in range(3)], axis=2)
        self.ground = finer_suns(np.log(np.maximum(irradiance, DARK)))

    def source(self, altitude, mu_s, mu, nu):
        """Return the source [1/m 1/sr] (..., 3) of the next order at points, in directions of zenith cosine mu."""
        height, sun = height_coordinate(self.atmosphere, altitude), sun_coordinate(self.atmosphere, mu_s)
        c = azimuth_cosine(mu, mu_s, nu)
        second = [interpolate(self.molecules[:, :, i], [height, sun]) for i in range(3)]
        s = safe_sqrt(1.0 - mu * mu)
        functions = 1.5 * mu * mu - 0.5, mu * s * c, s * s * (2.0 * c * c - 1.0)
        molecules = 1.0 + sum(f[..., None] * q for f, q in zip(functions, second, strict=True))
        layer = np.minimum(height / highest_layer(self.atmosphere), 1.0)
        units = [layer, sun, 1.0 - np.arccos(np.clip(mu, -1.0, 1.0)) / np.pi, azimuth_coordinate(c)]
        aerosols = interpolate(self.values, units)
        beta = densities(self.atmosphere, altitude)[..., :2, None] * scattering(self.atmosphere)
        source = beta[..., 0, :] * molecules + beta[..., 1, :] * aerosols
        return np.exp(interpolate(self.level, [height, sun])) * source

    def ground_irradiance(self, mu_s):
        """Return the field's irradiance (..., 3) of the ground per unit solar irradiance."""
        return np.exp(interpolate(self.ground, [sun_coordinate(self.atmosphere, mu_s)]))


def solve(atmosphere, recipe=RECIPES["accurate"]) -> MultipleTable:
    """Return the table of all orders from the second on, its ground row that of all orders from the first on."""
    gather = Gather(atmosphere, recipe, recipe.first)
    fields = [gather.moments(gather.first(recipe.band), recipe.degree)]
    if recipe.later != recipe.first:
        gather = Gather(atmosphere, recipe, recipe.later)
    for _ in range(1, recipe.orders):
        table = MultipleTable(atmosphere, recipe, *fields[-1])
        fields.append(gather.moments(gather.following(table), recipe.degree))
    moments = [f[0] for f in fields]
    tail = geometric_tail(moments[-2][:, :, :1], moments[-1][:, :, :1])
    ground_tail = geometric_tail(fields[-2][1], fields[-1][1])
    return MultipleTable(
        atmosphere, recipe, sum(moments) + tail * moments[-1], sum(f[1] for f in fields) + ground_tail * fields[-1][1]
    )


def geometric_tail(before, last):
    """Return what all orders after the last amount to, in units of the last."""
    ratio = np.clip(last / np.maximum(before, DARK), 0.0, 0.95)
    return ratio / (1.0 - ratio)


def aureole_source(atmosphere, density, mu_s, light, sun_column, kernel):
    """Return the source [1/m 1/sr] (..., 3) of the forward lobe's degrees above the table's, at lit points.

    Orders from the second on in the small-angle limit: each adds a factor lambda_l times the optical depth towards the
    sun. density, sun_column [m] : of aerosols, the latter towards the sun; light, kernel : (..., 3).
    """
    weight = np.clip(0.5 + mu_s / 0.3, 0.0, 1.0)
    tau = sun_column[..., None] * np.array(atmosphere.mie_scattering)
    series = kernel[..., 0:1] + tau * (kernel[..., 1:2] / 2.0 + tau * kernel[..., 2:3] / 6.0)
    return (weight * density)[..., None] * np.array(atmosphere.mie_scattering) * light * tau * series


def scatter_multiple(table, ray, sun_height, nu, cuts, nodes=16, gap_nodes=8):
    """Return inscatter (N, 3) [1/sr] of all orders from the second on, and transmittance (N, 3), along paths."""
    atmosphere = table.atmosphere
    pieces, columns = path_pieces(atmosphere, ray, sun_height, nu, cuts, nodes, gap_nodes)
    kernel = aureole_kernel(atmosphere.mie_g, table.recipe.degree, nu)
    radiance = np.zeros((len(nu), 3))
    for piece in pieces:
        cosine = np.broadcast_to(nu[piece.rays, None], piece.mu.shape)
        source = table.source(piece.altitude, piece.mu_s, piece.mu, cosine)
        source = source + aureole_source(
            atmosphere, piece.density[..., 1], piece.mu_s, piece.light, piece.sun_column, kernel[piece.rays, None]
        )
        radiance[piece.rays] += piece.gain * np.sum(piece.weight * source, axis=1)
    return np.maximum(radiance, 0.0), np.exp(-optical_depth(atmosphere, columns))
