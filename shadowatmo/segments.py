"""Float64 twin of shaders/segments.glsl: single scattering over lit pieces by Gauss-Legendre nodes in a sinh map."""

from dataclasses import dataclass

import numpy as np

from shadowatmo.extremes import (
    dominant_layer,
    has_dense_top,
    has_opaque_ozone,
    is_deep,
    is_small,
    is_thick,
    needs_more_nodes,
    reach_altitude,
)
from shadowatmo.medium import densities, extinction, optical_depth, scattering
from shadowatmo.phase import mie_phase, rayleigh_phase
from shadowatmo.quadrature import cumulative_matrix, gauss_legendre
from shadowatmo.quality import MAX_NODES
from shadowatmo.ray import altitude_of, k_along, k_of, safe_sqrt
from shadowatmo.transmittance import columns_to_top, ozone_crossings, ozone_levels, ozone_to, scale_heights

# Thick air (see_no_farther): optical depth of a piece that needs no care, optical depth beyond which nothing is seen,
# bisections; width of the map in mean free paths about a center ahead, about an eye in dense air, beneath a dense top.
DIM, OPAQUE, HALVINGS = 10.0, 16.0, 24
AHEAD, AROUND, HAIR = 3.0, 1.0, 0.05


@dataclass(frozen=True, eq=False)
class SinhMap:
    """t = center + width sinh(start + span s) for s in 0..1; fields (N,), lengths [m].

    `eased`: for s^2 (3 - 2 s) in place of s, which follows a square root at either end.
    """

    center: np.ndarray
    width: np.ndarray
    start: np.ndarray
    span: np.ndarray
    eased: bool = False


def nodes_for(atmosphere, nodes) -> int:
    """Return the nodes of a lit piece: half as many again where the air is dense or its horizon far.

    Where opaque ozone cuts the piece in two they are as many for each.
    """
    more = needs_more_nodes(atmosphere) and not has_opaque_ozone(atmosphere)
    return min(nodes + nodes // 2, MAX_NODES) if more else nodes


def gap_nodes_for(atmosphere, nodes) -> int:
    """Return the nodes of a dark piece: half as many again in a deep shell, whose pieces are that much longer."""
    return min(nodes + nodes // 2, MAX_NODES) if is_deep(atmosphere) else nodes


def make_map(atmosphere, ray, near, far) -> SinhMap:
    """Return the map of pieces [near, far] (N,) [m] of rays."""
    scale, beta = dominant_layer(atmosphere)
    if is_deep(atmosphere):
        half = safe_sqrt(k_of(atmosphere, reach_altitude(atmosphere)) - ray.tangent_k)
        near, far = np.clip(-ray.x - half, near, far), np.clip(-ray.x + half, near, far)
    lowest = np.clip(-ray.x, near, far)
    altitude = altitude_of(atmosphere, k_along(ray, lowest))
    r = atmosphere.bottom_radius + altitude
    bump = np.sqrt(r * scale)
    depth = beta * bump * np.exp(-np.maximum(altitude, 0.0) / scale)
    center = np.clip(-ray.x - 0.45 * bump * np.log1p(depth), near, far)
    slope = (ray.x + lowest) / r
    turn = 0.5 * scale / r * (1.0 + scale / r if is_small(atmosphere) else 1.0)
    width = np.hypot(0.9 * scale / np.sqrt(slope * slope + turn), 0.5 * (center - lowest))
    if is_thick(atmosphere):
        center, width, far = see_no_farther(atmosphere, ray, near, far, center, width)
    start = np.arcsinh((near - center) / width)
    return SinhMap(center, width, start, np.arcsinh((far - center) / width) - start, has_dense_top(atmosphere))


def slant_depth(atmosphere, ray, t):
    """Return an optical depth (N, 3) that grows along rays, up to a constant of each.

    Twice the tangent's less what lies beyond. Columns of the exponential layers alone, by a bound of the closed form
    that is 1 percent off.
    """

    def outward(x, altitude):
        scale = np.sqrt(2.0 * scale_heights(atmosphere) * (atmosphere.bottom_radius + altitude)[..., None])
        z = x[..., None] / scale
        return scale * densities(atmosphere, altitude)[..., :2] / (z + np.sqrt(z * z + 4.0 / np.pi))

    x = ray.x + t
    columns = outward(np.abs(x), altitude_of(atmosphere, k_along(ray, t)))
    through = 2.0 * outward(np.zeros_like(x), altitude_of(atmosphere, np.maximum(ray.tangent_k, 0.0))) - columns
    return np.where((x < 0.0)[..., None], columns, through) @ extinction(atmosphere)[:2]


def see_no_farther(atmosphere, ray, near, far, center, width):
    """Return center, width and far end of maps of pieces in thick air: where something can be seen.

    The center goes to an optical depth of 1 in the thickest channel, the far end to OPAQUE in the thinnest. Where
    the air is dense from the near end on, the center goes there; beneath a dense top the light may even come from a
    hair of the piece.
    """
    before = slant_depth(atmosphere, ray, near)
    thick = (slant_depth(atmosphere, ray, far) - before).max(axis=-1) > DIM
    low, high = np.stack([near, near]), np.stack([far, far])
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        depths = [slant_depth(atmosphere, ray, t) - before for t in middle]
        beyond = np.stack([depths[0].max(axis=-1) > 1.0, depths[1].min(axis=-1) > OPAQUE])
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    ends = (densities(atmosphere, altitude_of(atmosphere, k_along(ray, t)))[:, :2] for t in (near, high[0]))
    here, there = ((density @ extinction(atmosphere)[:2]).max(axis=-1) for density in ends)
    immersed = here > 0.2 * there
    middle = np.where(immersed, near, high[0])
    below_top = k_along(ray, near) > 0.999 * k_of(atmosphere, atmosphere.thickness)
    paths = np.where(immersed, np.where(below_top, HAIR, AROUND), AHEAD)
    length = paths / np.maximum(np.where(immersed, here, there), 1e-30)
    return (np.where(thick, new, old) for new, old in ((middle, center), (length, width), (high[1], far)))


def map_node(sinh_map, s):
    """Return t [m] and dt/ds [m] of nodes s (n,), each (N, n)."""
    stretch = 6.0 * s * (1.0 - s) if sinh_map.eased else np.ones_like(s)
    s = s * s * (3.0 - 2.0 * s) if sinh_map.eased else s
    u = sinh_map.start[:, None] + sinh_map.span[:, None] * s
    width = sinh_map.width[:, None]
    return sinh_map.center[:, None] + width * np.sinh(u), width * sinh_map.span[:, None] * stretch * np.cosh(u)


@dataclass(eq=False)
class Inscatter:
    """Integrals of density x transmittance to the eye x transmittance to the sun (N, 3) [m], and columns (N, 3) [m]."""

    rayleigh: np.ndarray
    mie: np.ndarray
    columns: np.ndarray


def no_inscatter(count) -> Inscatter:
    """Return the sum before the first piece."""
    return Inscatter(*(np.zeros((count, 3)) for _ in range(3)))


def node_steps(atmosphere, ray, near, far, count):
    """Return t (N, n) [m] of a piece's nodes, and density x dt/ds there for molecules and aerosols (N, n, 2) [m]."""
    t, dt = map_node(make_map(atmosphere, ray, near, far), gauss_legendre(count)[0])
    altitude = altitude_of(atmosphere, k_along_nodes(ray, t))
    return t, densities(atmosphere, altitude)[..., :2] * dt[..., None]


def k_along_nodes(ray, t):
    """Return k [m^2] at distances t (N, n) [m]."""
    return ray.k[:, None] + t * (t + 2.0 * ray.x[:, None])


def pass_gap(atmosphere, ray, near, far, total, count):
    """Add the columns of pieces that send no light of their own."""
    _, steps = node_steps(atmosphere, ray, near, far, count)
    total.columns[:, :2] += np.einsum("j,njs->ns", gauss_legendre(count)[1], steps)


def add_lit(atmosphere, ray, sun_height, sun_cosine, near, far, total, count, terms=6, subtract_top=True):
    """Add inscatter and columns of lit pieces; sun_height, sun_cosine (N,) = P . s [m] at the base point and d . s."""
    sun = sun_height, sun_cosine
    if has_opaque_ozone(atmosphere):
        middle = ozone_cut(atmosphere, ray, near, far)
        add_piece(atmosphere, ray, *sun, near, middle, total, count, terms, subtract_top)
        near = middle
    add_piece(atmosphere, ray, *sun, near, far, total, count, terms, subtract_top)


def ozone_cut(atmosphere, ray, near, far):
    """Return where pieces (N,) [m] leave the absorbing layer through its upper end, or else enter it there."""
    half = safe_sqrt(ozone_levels(atmosphere)[2] - ray.tangent_k)
    leaves = half - ray.x
    return np.where((leaves > near) & (leaves < far), leaves, np.clip(-half - ray.x, near, far))


def add_piece(atmosphere, ray, sun_height, sun_cosine, near, far, total, count, terms, subtract_top):
    """Add inscatter and columns of lit pieces without a kink inside."""
    weights = gauss_legendre(count)[1]
    t, steps = node_steps(atmosphere, ray, near, far, count)
    y = sun_height[:, None] + sun_cosine[:, None] * t
    columns = columns_to_top(atmosphere, k_along_nodes(ray, t), y, terms, subtract_top)
    columns[..., :2] += total.columns[:, None, :2] + np.einsum("ij,njs->nis", cumulative_matrix(count), steps)
    if atmosphere.ozone is not None:
        tangent_k, x = np.broadcast_to(ray.tangent_k[:, None], t.shape), ray.x[:, None] + t
        crossings = ozone_crossings(atmosphere, tangent_k)
        before = ozone_to(atmosphere, tangent_k, crossings, np.broadcast_to(ray.x[:, None], t.shape))
        columns[..., 2] += ozone_to(atmosphere, tangent_k, crossings, x) - before
    light = weights[:, None] * np.exp(-optical_depth(atmosphere, columns))
    total.rayleigh += np.einsum("nic,ni->nc", light, steps[..., 0])
    total.mie += np.einsum("nic,ni->nc", light, steps[..., 1])
    total.columns[:, :2] += np.einsum("j,njs->ns", weights, steps)


def finish_columns(atmosphere, ray, end, total):
    """Set the ozone's column of the whole path, base point to `end` (N,) [m]."""
    if atmosphere.ozone is not None:
        crossings = ozone_crossings(atmosphere, ray.tangent_k)
        inside = ozone_to(atmosphere, ray.tangent_k, crossings, ray.x + end)
        total.columns[:, 2] = np.maximum(inside - ozone_to(atmosphere, ray.tangent_k, crossings, ray.x), 0.0)


def apply_phases(atmosphere, total, nu):
    """Return radiance (N, 3) per unit irradiance [1/sr]."""
    rayleigh, mie = scattering(atmosphere)
    return (
        rayleigh_phase(nu)[:, None] * rayleigh * total.rayleigh
        + mie_phase(nu, atmosphere.mie_g)[:, None] * mie * total.mie
    )


def scatter(atmosphere, ray, sun_height, sun_cosine, cuts, nodes=16, gap_nodes=8):
    """Return transmittance (N, 3) and radiance (N, 3) of paths cut at `cuts` (N, 4) [m]: near, shadow, light, far."""
    total = no_inscatter(len(cuts))
    near, dark, light, far = np.asarray(cuts, np.float64).T
    add_lit(atmosphere, ray, sun_height, sun_cosine, near, dark, total, nodes)
    pass_gap(atmosphere, ray, dark, light, total, gap_nodes)
    add_lit(atmosphere, ray, sun_height, sun_cosine, light, far, total, nodes)
    finish_columns(atmosphere, ray, far, total)
    transmittance = np.exp(-optical_depth(atmosphere, total.columns))
    return transmittance, apply_phases(atmosphere, total, sun_cosine)
