"""Where moons' shadows lie in the air, as the shaders see it: in a frame whose third axis points to the sun.

In the plane through a point across that axis a moon at c casts, drawn from the sun's center at the distance D, its
outline magnified about the point (D - z) / (D - c_z) c, and every point of the outline is blurred to an image of the
sun. All these lengths are linear in the height z of the plane.
"""

from dataclasses import dataclass

import numpy as np

from shadowatmo import shadow

FLAT = 4e-4  # squared angle times separation in solar radii up to which a moon's disc may be taken for flat
EVEN, EVEN_BESIDE_ONE = 1.5, 1.05  # largest change of a moon's size over the air; where it passes the sun's own size
SLICES = 129  # heights at which two shadows are tested for an overlap
SLACK = 1.02  # of a shadow's radius, for the cut of a cone that is not quite upright


@dataclass(frozen=True)
class ShadowPath:
    """A moon's shadow over the height z [m]; each pair is the value at z = 0 [m] and its change with z.

    Parameters
    ----------
    center : (2, 2) float
        Of the two coordinates across the sun's direction.
    blur, size : (2,) float
        Radius of the sun's image, and of the moon's outline.
    """

    center: np.ndarray
    blur: np.ndarray
    size: np.ndarray


def sun_axes(sun) -> np.ndarray:
    """Return (3, 3): as columns two axes across the direction to the sun, and that direction."""
    direction = np.array(sun.direction)
    side = np.cross(np.eye(3)[np.argmin(np.abs(direction))], direction)
    side /= np.linalg.norm(side)
    return np.stack([side, np.cross(direction, side), direction], axis=1)


def shadow_path(sun, occluder) -> ShadowPath:
    """Return the shadow of an occluder in the frame of `sun_axes`."""
    x, y, z = np.array(occluder.center) @ sun_axes(sun)
    line = np.array([sun.distance, -1.0]) / (sun.distance - z)
    blur = sun.radius * np.array([z, -1.0]) / (sun.distance - z)
    return ShadowPath(np.outer([x, y], line), blur, occluder.radius * line)


def is_narrow(atmosphere, sun, occluder) -> bool:
    """Whether an occluder stands beyond the air and looks small enough from it for its disc to be flat.

    Its size must also change little over the air, for a few rows of a table stand for all of it.
    """
    reach, height = atmosphere.top_radius, np.array(occluder.center) @ np.array(sun.direction)
    if height - occluder.radius <= reach or sun.distance <= reach + sun.radius:
        return False
    largest = occluder.radius / (height - reach) * (sun.distance + reach) / sun.radius
    smallest = occluder.radius / (height + reach) * (sun.distance - reach) / sun.radius
    if largest / smallest > (EVEN_BESIDE_ONE if smallest < 1.0 < largest else EVEN):
        return False
    angle = (reach + (1.0 + largest) * sun.radius) / (sun.distance - reach)
    return angle * angle * (1.0 + largest) < FLAT


def sorted_by_width(atmosphere, sun, occluders) -> tuple[tuple, tuple]:
    """Return the narrow occluders and the others."""
    narrow = tuple(o for o in occluders if is_narrow(atmosphere, sun, o))
    return narrow, tuple(o for o in occluders if o not in narrow)


def overlap_box(atmosphere, sun, occluders) -> np.ndarray | None:
    """Return (2, 3), corners of a box in the frame of `sun_axes` [m]; outside of it no two penumbrae meet in the air.

    None where no two of them do: there the light that moons take is a sum.
    """
    reach = atmosphere.top_radius
    z = np.linspace(-reach, reach, SLICES)
    # Between two slices a shadow moves and widens; the slices stand for what is up to one of them away.
    air = np.sqrt(np.maximum(reach**2 - np.maximum(np.abs(z) - 2.0 * reach / (SLICES - 1), 0.0) ** 2, 0.0))
    discs = [_penumbra_slices(sun, o, z) for o in occluders]
    low, high = np.full((len(z), 2), np.inf), np.full((len(z), 2), -np.inf)
    for i, (center, radius) in enumerate(discs):
        for other, other_radius in discs[:i]:
            meets = np.linalg.norm(center - other, axis=1) < radius + other_radius
            for middle, size in ((center, radius), (other, other_radius)):
                meets &= (np.linalg.norm(middle, axis=1) < size + air) & (size > 0.0)
            r, other_r, edge = radius[:, None], other_radius[:, None], np.column_stack([air, air])
            first = np.maximum.reduce([center - r, other - other_r, -edge])
            last = np.minimum.reduce([center + r, other + other_r, edge])
            meets &= (first < last).all(axis=1)
            low[meets], high[meets] = np.minimum(low, first)[meets], np.maximum(high, last)[meets]
    slices = np.flatnonzero(np.isfinite(low[:, 0]))
    if not slices.size:
        return None
    ends = z[max(slices[0] - 1, 0)], z[min(slices[-1] + 1, SLICES - 1)]
    return np.array([[*low.min(axis=0), ends[0]], [*high.max(axis=0), ends[1]]])


def _penumbra_slices(sun, occluder, z):
    """Return centers (n, 2) and radii (n,) [m] of a penumbra at heights z; radius 0 on the sun's side of the moon."""
    x, y, height = np.array(occluder.center) @ sun_axes(sun)
    path = shadow_path(sun, occluder)
    distance = float(np.hypot(np.hypot(x, y), sun.distance - height))
    cone = shadow.penumbra_cone(occluder.radius, sun.radius, max(distance, sun.radius + occluder.radius))
    slice_height = z[1] - z[0]
    along = (height - z) * distance / (sun.distance - height)
    change = abs(cone.slope) + np.abs(path.center[:, 1]).sum()
    radius = SLACK * cone.width(np.maximum(along, cone.near)) + slice_height * change
    shaded = (along > cone.near - slice_height) & (height < sun.distance)
    center = path.center[:, 0] + z[:, None] * path.center[:, 1]
    return center, np.where(shaded, radius, 0.0)
