"""Light scattered more than once under a moon's shadow: a small volume of ratios to the air without the moon.

The field of all orders is smooth where the shadow is not, and away from the shadow it is the one that the table of
`multiple` knows. So what is stored is relative to that: on a grid about the shadow's axis, over the distance rho from
the point p where the axis meets the ground, the angle alpha about it and the altitude,

    R = log(a_00 / a_00') - log g(f),      d_lm = a_lm / a_00 - a_lm' / a_00',       g(f) = (f + c) / (1 + c),

a the moments of the radiance under the moon, a' those without it, f the visible fraction of the sun. The source is then

    J = g(f) exp(R) [J' + a_00' sum lambda_l d_lm Y_lm(v')].

at most J', since a moon only takes light. Where the sun is whole wherever light comes from, both moments are the same
sums, and R = d = 0 exactly.

Frame: e1 = the sun's direction made normal to p, e2 = p x e1. The centers of planet, sun and moon lie in the plane of
e1 and p, so half the angles do: a coefficient odd in e2 changes its sign across. A direction is turned with the point's
zenith onto p; there plain real spherical harmonics serve every column, with no azimuth that would jump.

The ratio is a fixed point: with M the moments of single scattering and lit ground and G[J] those of what the source J
sends, r = (M + G[r J']) / (M' + G[J']), so no order is stored and none is left out.

GPU twin: shaders/eclipse_multiple*.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shadowatmo.eclipse import visible_fraction
from shadowatmo.harmonics import harmonic_indices, polar_basis
from shadowatmo.multiple import gather_polar
from shadowatmo.multiple_axes import height_of
from shadowatmo.multiple_recipes import Effort
from shadowatmo.shadow import penumbra_cone, umbra_cone

SHADE = 0.003  # c: about the light that totality leaves, so that R has no edge where the umbra has one
EDGE_WIDTH = 0.3  # of the umbra's radius, about which the rings crowd at its edge
REACH = 1.25  # of the penumbra's radius: the last ring
LEAST_EDGE = 0.5  # of the air's thickness: a smaller umbra is blurred by the air
STEEPEST = 0.25  # least squeeze of the shadow's long axis on the ground
FARTHEST = 1.99  # of the ground's radius in the plane of the map, whose rim, 2, is the point opposite p
NOTHING = 1e-28  # radiance without a moon below which no ratio is formed
LARGEST = 30.0  # of |d|


@dataclass(frozen=True)
class RatioRecipe:
    """Resolution of a volume of ratios.

    Parameters
    ----------
    rings, sectors, heights : int
        Nodes over rho, alpha and altitude. An odd number of sectors has one across the plane of symmetry.
    degree : int
        Of the spherical harmonics.
    band : int
        Degree to which the aerosols' phase function counts in the first gather.
    first, later : Effort
        Of the first gather and of the iterations; azimuths over a whole turn.
    iterations : int
        Gathers of the source after the first.
    """

    rings: int = 16
    sectors: int = 5
    heights: int = 6
    degree: int = 4
    band: int = 12
    first: Effort = Effort(8, 6, 16, 6, 3)
    later: Effort = Effort(6, 4, 8, 5, 3)
    iterations: int = 3

    @property
    def columns(self) -> int:
        """Columns of the grid."""
        return self.rings * self.sectors

    @property
    def coefficients(self) -> int:
        """Spherical harmonics: those with a cosine of the azimuth, then those with a sine."""
        return (self.degree + 1) ** 2


RATIO_RECIPES = {
    "balanced": RatioRecipe(),
    "accurate": RatioRecipe(18, 5, 7, 4, 12, Effort(10, 7, 16, 6), Effort(6, 4, 10, 5), 3),
}
RATIO_RECIPES |= {name: RATIO_RECIPES["accurate"] for name in ("finest", "truth")}  # no finer ones yet


def shade(visible):
    """Return g(f): the visible fraction, brightened by what totality leaves; 1 for 1."""
    return (visible + SHADE) / (1.0 + SHADE)


def azimuth_harmonics(azimuth, degree):
    """Return the azimuthal parts (N, coefficients): cos(m azimuth) in the order of harmonic_indices, then sines."""
    m = harmonic_indices(degree)[1]
    turns = np.outer(azimuth, m)
    return np.concatenate([np.cos(turns), np.sin(turns[:, m > 0])], axis=1)


def zenith_harmonics(mu, degree):
    """Return the polar parts (..., coefficients) in the same order."""
    polar = polar_basis(mu, degree)
    return np.concatenate([polar, polar[..., harmonic_indices(degree)[1] > 0]], axis=-1)


@dataclass(frozen=True, eq=False)
class ShadowFrame:
    """Axes and map of a moon's shadow on a planet.

    axes : (3, 3) rows e1, e2, p; squeeze : of e1 on the map, against the shadow's slant; edge, width, reach [m]: rho at
    the umbra's edge, scale of the rings about it, and the last ring; radius [m] of the ground.
    """

    axes: np.ndarray
    squeeze: float
    edge: float
    width: float
    reach: float
    radius: float

    @cached_property
    def rings(self) -> tuple[float, float]:
        """Arcsinh of the distance from the edge over the width, at the center and at the last ring."""
        return math.asinh(-self.edge / self.width), math.asinh((self.reach - self.edge) / self.width)

    def place(self, up):
        """Return the places 0..1 over rho and alpha of unit vectors (..., 3) to points, and the sign of their e2."""
        u = up @ self.axes.T
        b = u[..., :2] * (self.squeeze, 1.0) * np.sqrt(2.0 / np.maximum(1.0 + u[..., 2:], 1e-4))
        rho = self.radius * np.linalg.norm(b, axis=-1)
        low, high = self.rings
        ring = np.clip((np.arcsinh((rho - self.edge) / self.width) - low) / (high - low), 0.0, 1.0)
        return ring, np.arctan2(np.abs(b[..., 1]), b[..., 0]) / np.pi, np.where(b[..., 1] < 0.0, -1.0, 1.0)

    def up(self, ring, sector):
        """Return unit vectors (..., 3) at places 0..1 on the side of e2; the inverse of `place`."""
        low, high = self.rings
        rho = self.edge + self.width * np.sinh(low + (high - low) * ring)
        c = (rho / self.radius)[..., None] * np.stack([np.cos(np.pi * sector), np.sin(np.pi * sector)], axis=-1)
        c = c / (self.squeeze, 1.0)
        length = np.linalg.norm(c, axis=-1, keepdims=True)
        c = c * np.minimum(1.0, FARTHEST / np.maximum(length, 1e-30))
        square = np.sum(c * c, axis=-1, keepdims=True)
        return np.concatenate([c * np.sqrt(1.0 - 0.25 * square), 1.0 - 0.5 * square], axis=-1) @ self.axes

    def turn(self, up, directions):
        """Return directions (..., 3) in the frame's axes, turned as `up` is turned onto p, the last axis."""
        u, v = up @ self.axes.T, directions @ self.axes.T
        pole = np.array([0.0, 0.0, 1.0])
        s = u + pole
        along = np.sum(v * s, axis=-1, keepdims=True) / np.maximum(1.0 + u[..., 2:], 1e-4)
        return v - along * s + 2.0 * np.sum(v * u, axis=-1, keepdims=True) * pole

    def turn_back(self, up, turned):
        """Return directions (..., 3) from turned ones; the inverse of `turn`."""
        u = up @ self.axes.T
        s = u + np.array([0.0, 0.0, 1.0])
        along = np.sum(turned * s, axis=-1, keepdims=True) / np.maximum(1.0 + u[..., 2:], 1e-4)
        return (turned - along * s + 2.0 * turned[..., 2:] * u) @ self.axes


def shadow_frame(atmosphere, sun, occluder) -> ShadowFrame:
    """Return the frame of a moon's shadow, about where its axis meets the ground or passes closest to the center."""
    toward_sun, center = np.array(sun.direction), np.array(occluder.center)
    offset = center - sun.distance * toward_sun
    distance = float(np.linalg.norm(offset))
    axis = offset / distance
    along = -center @ axis  # from the moon to the point of the axis that is closest to the center
    closest = center + along * axis
    depth = math.sqrt(max(atmosphere.bottom_radius**2 - closest @ closest, 0.0))
    point, z = closest - depth * axis, along - depth
    p = point / np.linalg.norm(point)
    e1 = toward_sun - (toward_sun @ p) * p
    if np.linalg.norm(e1) < 1e-7:
        e1 = np.cross(p, np.eye(3)[np.argmin(np.abs(p))])
    e1 /= np.linalg.norm(e1)
    umbra = abs(umbra_cone(occluder.radius, sun.radius, distance).width(z))
    penumbra = penumbra_cone(occluder.radius, sun.radius, distance).width(z)
    edge = min(max(umbra, LEAST_EDGE * atmosphere.thickness), 2.0 * atmosphere.bottom_radius)
    reach = min(max(REACH * penumbra, 2.0 * edge), 2.0 * atmosphere.bottom_radius)
    squeeze = max(STEEPEST, float(toward_sun @ p))
    axes = np.stack([e1, np.cross(p, e1), p])
    return ShadowFrame(axes, squeeze, edge, EDGE_WIDTH * edge, reach, atmosphere.bottom_radius)


class RatioGrid:
    """The nodes of one volume, the moments of what was gathered at them, and the volume's values.

    Attributes
    ----------
    frame : ShadowFrame
    up : (columns, 3)
        Unit vectors of the columns, the rings of a sector side by side.
    altitude : (heights,) [m]
    visible : (heights, columns)
        Fraction of the sun that the moon leaves.
    """

    def __init__(self, atmosphere, sun, occluder, recipe):
        self.atmosphere, self.recipe = atmosphere, recipe
        self.frame = shadow_frame(atmosphere, sun, occluder)
        sectors, rings = np.meshgrid(
            np.linspace(0.0, 1.0, recipe.sectors), np.linspace(0.0, 1.0, recipe.rings), indexing="ij"
        )
        self.up = self.frame.up(rings.ravel(), sectors.ravel())
        self.altitude = height_of(atmosphere, np.linspace(0.0, 1.0, recipe.heights))
        points = (atmosphere.bottom_radius + self.altitude)[:, None, None] * self.up
        self.visible = visible_fraction(points.reshape(-1, 3), sun, occluder).reshape(recipe.heights, -1)

    def polar(self, effort):
        """Return mu and weights (heights, polar) of an effort's directions."""
        return gather_polar(self.atmosphere, self.altitude, effort.above, effort.below)

    @staticmethod
    def azimuths(effort) -> np.ndarray:
        """Azimuths [rad] from e1 of turned directions, a whole turn."""
        return 2.0 * np.pi * (np.arange(effort.around) + 0.5) / effort.around

    def moments(self, radiance, effort):
        """Return moments (heights, columns, coefficients + 1, 3), last the irradiance at the ground.

        radiance : (heights, columns, polar x azimuths, 3), the azimuths of one mu side by side.
        """
        recipe = self.recipe
        mu, weights = self.polar(effort)
        basis = (weights[..., None] * zenith_harmonics(mu, recipe.degree))[:, :, None]
        basis = basis * azimuth_harmonics(self.azimuths(effort), recipe.degree)[None, None]
        up = np.broadcast_to((weights * np.maximum(mu, 0.0))[:, :, None, None], (*basis.shape[:3], 1))
        weight = np.concatenate([basis, up], axis=-1).reshape(recipe.heights, -1, recipe.coefficients + 1)
        return 2.0 * np.pi / effort.around * np.einsum("hdk,hudc->hukc", weight, radiance, optimize=True)

    def values(self, without, shaded):
        """Return the volume (tiles, heights, sectors, rings, 3) from the two fields' moments.

        Tile 0 is R, then d by coefficient; the last is R of the ground's irradiance, at altitude 0 alone.
        """
        log_shade = np.log(shade(self.visible))[..., None]
        ratio = np.log(_ratio(shaded[:, :, 0], without[:, :, 0])) - log_shade
        sky = np.log(_ratio(shaded[:, :, -1], without[:, :, -1])) - log_shade
        seen = (without[:, :, :1] > NOTHING) & (shaded[:, :, :1] > 0.0)
        lead = [np.where(seen, field[:, :, :1], 1.0) for field in (shaded, without)]
        shapes = shaded[:, :, 1:-1] / lead[0] - without[:, :, 1:-1] / lead[1]
        shapes = np.where(seen, np.clip(shapes, -LARGEST, LARGEST), 0.0)
        tiles = np.concatenate([ratio[:, :, None], shapes, sky[:, :, None]], axis=2)
        tiles = tiles.reshape(self.recipe.heights, self.recipe.sectors, self.recipe.rings, -1, 3)
        return np.moveaxis(tiles, 3, 0)


def _ratio(shaded, without):
    """Return the ratio of two positive fields, 1 where there is no light; never below what a logarithm takes."""
    dark = without <= NOTHING
    return np.where(dark, 1.0, np.maximum(shaded / np.where(dark, 1.0, without), 1e-9))
