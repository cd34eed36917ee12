"""Float64 twin of shaders/transmittance.glsl: columns of air from a point towards the sun, in closed form.

A point and a direction are given by k = r^2 - R^2 [m^2] and y = r mu_s [m]; see the shader for the derivation. Columns
are in metres at altitude 0: molecules, aerosols, ozone (at its peak). The fits of E and kappa are our own: with 4 terms
the column's relative error is 5e-4, with 6 it is 2e-5, for r/H above a few hundred.
"""

import numpy as np

from shadowatmo.extremes import closed_form_holds, has_curved_ozone
from shadowatmo.medium import densities, optical_depth
from shadowatmo.quadrature import gauss_legendre
from shadowatmo.ray import altitude_of, far_root, k_of, safe_sqrt

COLUMN_NODES = 16  # of columns by quadrature
# t = 1/(1 + p z) and the coefficients of t, t^2, ... in sqrt(pi) exp(z^2) erfc(z)
EXPONENTIAL_INTEGRAL = {
    4: (0.749563, (0.74999401, 0.72509822, 0.75344855, -0.4570285)),
    6: (0.460463, (0.4604722, 0.45956096, 0.4267281, 0.22249795, 0.42758318, -0.22441785)),
}


def exponential_integral(z, terms):
    """Return sqrt(pi) exp(z^2) erfc(z), z >= 0, by a rational fit."""
    p, coefficients = EXPONENTIAL_INTEGRAL[terms]
    t = 1.0 / (1.0 + p * z)
    total = 0.0
    for c in reversed(coefficients):
        total = t * (c + total)
    return total


def curvature(z, x, terms):
    """Return kappa(z) / x, the first correction of the column; x = r/H."""
    if terms == 6:
        return (0.375 + z * (0.64674 + 0.43184 * z)) / (x + x * z * (0.62824 + 0.43184 * z))
    return (0.375 + 1.4714 * z) / (x + x * 1.4714 * z)


def scale_heights(atmosphere):
    """Return the scale heights [m] of molecules and aerosols, (2,)."""
    return np.array([atmosphere.rayleigh_scale_height, atmosphere.mie_scale_height])


def upward_columns(atmosphere, altitude, y, terms):
    """Return the columns (N, 2) [m] of both layers to infinity, y >= 0."""
    heights = scale_heights(atmosphere)
    r = np.asarray(atmosphere.bottom_radius + altitude)[..., None]
    scale = np.sqrt(2.0 * heights * r)
    z = np.asarray(y)[..., None] / scale
    shape = exponential_integral(z, terms) * (1.0 + curvature(z, r / heights, terms))
    return 0.5 * scale * np.exp(-np.maximum(altitude, 0.0)[..., None] / heights) * shape


def integrate_layers(atmosphere, k_start, start, end):
    """Return the columns (N, 2) [m] of both layers between distances [m] from the tangent point, rising from `k_start`.

    By quadrature in a sinh map whose width follows the thinner layer: where the closed form does not hold.
    """
    nodes, weights = gauss_legendre(COLUMN_NODES)
    r = atmosphere.bottom_radius + altitude_of(atmosphere, k_start)
    scale = min(*scale_heights(atmosphere), atmosphere.thickness)
    width = (scale / np.sqrt((start / r) ** 2 + 0.5 * scale / r))[..., None]
    span = np.arcsinh((end - start)[..., None] / width)
    step = width * np.sinh(span * nodes)
    altitude = altitude_of(atmosphere, k_start[..., None] + step * (step + 2.0 * start[..., None]))
    steps = densities(atmosphere, np.minimum(altitude, atmosphere.thickness))[..., :2]
    return np.einsum("...ns,...n->...s", steps, weights * width * span * np.cosh(span * nodes))


def integrated_columns(atmosphere, k, y):
    """Return the columns (N, 2) [m] of both layers to the top of the air by quadrature."""
    tangent_k = np.maximum(k - y * y, -((0.5 * atmosphere.bottom_radius) ** 2))
    top = safe_sqrt(k_of(atmosphere, atmosphere.thickness) - (k - y * y))
    rising = y >= 0.0
    low, start = np.where(rising, k, tangent_k), np.where(rising, y, 0.0)
    columns = integrate_layers(atmosphere, low, start, np.maximum(top, start))
    back = integrate_layers(atmosphere, low, np.zeros_like(y), np.where(rising, 0.0, -y))
    return columns + back


def layer_columns(atmosphere, k, y, terms, subtract_top):
    """Return the columns (N, 2) [m] of both layers to infinity, or to the top of the air."""
    if not closed_form_holds(atmosphere):
        return integrated_columns(atmosphere, k, y)
    floor = -0.5 * atmosphere.mie_scale_height * atmosphere.bottom_radius
    lowest = altitude_of(atmosphere, np.maximum(k - y * y, floor))
    outward = upward_columns(atmosphere, altitude_of(atmosphere, k), np.abs(y), terms)
    through = 2.0 * upward_columns(atmosphere, lowest, np.zeros_like(y), terms) - outward
    columns = np.where((y < 0.0)[..., None], through, outward)
    if subtract_top:
        y_top = safe_sqrt(k_of(atmosphere, atmosphere.thickness) - k + y * y)
        columns = columns - upward_columns(atmosphere, np.full_like(y, atmosphere.thickness), y_top, terms)
    return np.maximum(columns, 0.0)


def ozone_altitudes(atmosphere):
    """Return the altitudes (3,) [m] at which the tent begins, peaks and ends."""
    return atmosphere.ozone.center + atmosphere.ozone.half_width * np.array([-1.0, 0.0, 1.0])


def ozone_levels(atmosphere):
    """Return k (3,) [m^2] at which the tent begins, peaks and ends when its sides are taken as straight over k.

    Over k they bend a little, by half_width / (2 R) of themselves; the ends are moved so that either side keeps its
    column. Around a small planet nothing is moved: there the sides are straight over the altitude.
    """
    layer = atmosphere.ozone
    if has_curved_ozone(atmosphere):
        return k_of(atmosphere, ozone_altitudes(atmosphere))
    begin, half_up, peak, half_down, end = (
        k_of(atmosphere, layer.center + side * layer.half_width) for side in (-1.0, -0.5, 0.0, 0.5, 1.0)
    )
    up, down = (half_up - begin) / (peak - begin), (end - half_down) / (end - peak)
    bend_up, bend_down = ((0.5 - half) / (half * (1.0 - half)) for half in (up, down))
    return np.array([begin - bend_up / 3.0 * (peak - begin), peak, end + bend_down / 3.0 * (end - peak)])


def ozone_ramps(atmosphere):
    """Return (3,): how much the tent's slope changes where it begins, peaks and ends, over k [1/m^2] or r [1/m]."""
    if has_curved_ozone(atmosphere):
        return np.array([1.0, -2.0, 1.0]) / atmosphere.ozone.half_width
    begin, peak, end = ozone_levels(atmosphere)
    rising, falling = 1.0 / (peak - begin), 1.0 / (end - peak)
    return np.array([rising, -rising - falling, falling])


def ozone_crossings(atmosphere, tangent_k):
    """Return the distances (N, 3) [m] from the tangent point at which the tent begins, peaks and ends."""
    levels = np.minimum(ozone_levels(atmosphere), k_of(atmosphere, atmosphere.thickness))
    return safe_sqrt(levels - np.asarray(tangent_k)[..., None])


def ozone_to(atmosphere, tangent_k, crossings, x):
    """Return the tent's column [m] from the tangent point out to |x|, with the sign of x."""
    if has_curved_ozone(atmosphere):
        ramps = curved_ramps(atmosphere, tangent_k, crossings, x)
        return np.where(x < 0.0, -1.0, 1.0) * np.maximum(ramps @ ozone_ramps(atmosphere), 0.0)
    beyond = np.maximum(np.minimum(np.abs(x), crossings[..., 2])[..., None] - crossings, 0.0)
    begun = np.maximum(np.asarray(tangent_k)[..., None] - ozone_levels(atmosphere), 0.0)
    ramps = beyond * (beyond * (beyond + 3.0 * crossings) / 3.0 + begun)
    return np.where(x < 0.0, -1.0, 1.0) * np.maximum(ramps @ ozone_ramps(atmosphere), 0.0)


def curved_ramps(atmosphere, tangent_k, crossings, x):
    """Return columns (N, 3) [m^2] of ramps over the radius, by the integral of sqrt(p^2 + s^2)."""
    square = atmosphere.bottom_radius**2
    p2 = np.maximum(square + np.asarray(tangent_k), 1e-12 * square)[..., None]
    end = np.minimum(np.abs(x), crossings[..., 2])[..., None]
    start = np.minimum(crossings, end)
    r_end, r_start = np.sqrt(p2 + end * end), np.sqrt(p2 + start * start)
    areas = 0.5 * (end * r_end - start * r_start + p2 * np.log((end + r_end) / (start + r_start)))
    return np.maximum(areas - (atmosphere.bottom_radius + ozone_altitudes(atmosphere)) * (end - start), 0.0)


def ozone_to_top(atmosphere, k, y):
    """Return the tent's column [m] from a point to the top of the air."""
    tangent_k = k - y * y
    crossings = ozone_crossings(atmosphere, tangent_k)
    whole = ozone_to(atmosphere, tangent_k, crossings, np.full_like(y, 1e18))
    return np.maximum(whole - ozone_to(atmosphere, tangent_k, crossings, y), 0.0)


def columns_to_top(atmosphere, k, y, terms=6, subtract_top=True):
    """Return the columns (N, 3) [m] of molecules, aerosols and ozone towards the sun, the ground ignored."""
    k, y = np.broadcast_arrays(np.asarray(k, np.float64), np.asarray(y, np.float64))
    ozone = np.zeros_like(y) if atmosphere.ozone is None else ozone_to_top(atmosphere, k, y)
    return np.concatenate([layer_columns(atmosphere, k, y, terms, subtract_top), ozone[..., None]], axis=-1)


def transmittance_to_top(atmosphere, k, y, terms=6, subtract_top=True):
    """Return the transmittance (N, 3) from points to the top of the air, the ground ignored."""
    return np.exp(-optical_depth(atmosphere, columns_to_top(atmosphere, k, y, terms, subtract_top)))


def table_coordinates(atmosphere, k, y, size):
    """Return texture coordinates (N, 2) of the column table of `size` (columns, rows). Bruneton and Neyret 2008, 4."""
    top_k = k_of(atmosphere, atmosphere.thickness)
    rho, rho_top = safe_sqrt(k), np.sqrt(top_k)
    nearest = atmosphere.thickness - altitude_of(atmosphere, np.maximum(k, 0.0))
    to_top = far_root(y, k - top_k, safe_sqrt(y * y + top_k - k))
    unit = [(to_top - nearest) / np.maximum(rho + rho_top - nearest, 1e-6 * rho_top), rho / rho_top]
    size = np.asarray(size, np.float64)
    return (np.clip(np.stack(unit, axis=-1), 0.0, 1.0) * (size - 1.0) + 0.5) / size


def table_point(atmosphere, texel, size):
    """Return k [m^2] and y [m] at texel centers (N, 2), counted from 0.5; the inverse of table_coordinates."""
    unit = (np.asarray(texel, np.float64) - 0.5) / (np.asarray(size, np.float64) - 1.0)
    top_k = k_of(atmosphere, atmosphere.thickness)
    rho_top = np.sqrt(top_k)
    rho = unit[..., 1] * rho_top
    k = rho * rho
    altitude = altitude_of(atmosphere, k)
    nearest = atmosphere.thickness - altitude
    to_top = nearest + unit[..., 0] * (rho + rho_top - nearest)
    y = (top_k - k - to_top * to_top) / np.maximum(2.0 * to_top, 1e-6 * rho_top)
    return k, np.clip(y, -rho, atmosphere.bottom_radius + altitude)
