"""Float64 twin of shaders/march.glsl: single scattering by uniform steps over the whole path."""

import numpy as np

from shadowatmo.medium import densities, extinction
from shadowatmo.ray import altitude_of
from shadowatmo.segments import Inscatter, apply_phases, finish_columns, k_along_nodes
from shadowatmo.transmittance import columns_to_top, ozone_crossings, ozone_to


def scatter(atmosphere, ray, sun_height, sun_cosine, cuts, steps=32):
    """Return transmittance (N, 3) and radiance (N, 3) of paths cut at `cuts` (N, 4) [m]: near, shadow, light, far.

    sun_height, sun_cosine (N,) = P . s [m] at the base point and d . s. The sun's columns come from the closed form and
    not, as in the shader, from a table.
    """
    near, dark, lit, far = np.asarray(cuts, np.float64).T[..., None]
    length = (far - near) / steps
    t = near + (np.arange(steps) + 0.5) * length
    k = k_along_nodes(ray, t)
    amount = densities(atmosphere, altitude_of(atmosphere, k))[..., :2] * length[..., None]
    columns = columns_to_top(atmosphere, k, sun_height[:, None] + sun_cosine[:, None] * t)
    columns[..., :2] += np.cumsum(amount, axis=1) - 0.5 * amount
    if atmosphere.ozone is not None:
        tangent_k, start = (np.broadcast_to(v[:, None], t.shape) for v in (ray.tangent_k, ray.x))
        crossings = ozone_crossings(atmosphere, tangent_k)
        behind = ozone_to(atmosphere, tangent_k, crossings, start + t)
        columns[..., 2] += behind - ozone_to(atmosphere, tangent_k, crossings, start)
    light = np.exp(-columns @ extinction(atmosphere)) * ~((t > dark) & (t < lit))[..., None]
    total = Inscatter(*(np.einsum("nic,ni->nc", light, amount[..., i]) for i in range(2)), np.zeros((len(t), 3)))
    total.columns[:, :2] = amount.sum(axis=1)
    finish_columns(atmosphere, ray, far[:, 0], total)
    return np.exp(-total.columns @ extinction(atmosphere)), apply_phases(atmosphere, total, sun_cosine)
