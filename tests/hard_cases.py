"""What the tests of hard cases share: fans of rays, suns, perturbations, and the comparison with the float64 twin."""

from dataclasses import replace

import numpy as np

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.quality import NAMED

# "accurate", light scattered once; two more nodes for the dark part of a ray, which alone may graze the ground
QUALITY = replace(NAMED["accurate"], gap_nodes=12, orders=1)
SUNS = {
    "zenith": (1.0, 0.0, 0.0),
    "80 degrees": (np.cos(np.radians(80.0)), np.sin(np.radians(80.0)), 0.0),
    "horizon": (0.0, 1.0, 0.0),
    "92 degrees": (np.cos(np.radians(92.0)), np.sin(np.radians(92.0)), 0.0),
    "nadir": (-1.0, 0.0, 0.0),
}
AZIMUTHS = (0.0, 1.2, np.pi)  # from the sun
COLORS = ("transmittance", "single", "ground_direct")
LENGTHS = ("lit", "shadow", "planet_umbra", "planet_penumbra")


def direction(elevation, azimuth):
    """Return a unit vector (3,) at a point on the x axis, azimuth counted from the y axis [rad]."""
    e, a = elevation, azimuth
    return np.array([np.sin(e), np.cos(e) * np.cos(a), np.cos(e) * np.sin(a)])


def ray_fan(air, altitude, sun, offset=1e-6):
    """Return {name: direction} of rays from the point at `altitude` [m] on the x axis.

    Up, down, along and against the sun, `offset` [rad] beside the horizon and the top's limb, and a few between.
    """
    radius, bottom, top = air.bottom_radius + altitude, air.bottom_radius, air.top_radius
    sun = np.array(sun) / np.linalg.norm(sun)
    rays = {"up": [1.0, 0.0, 0.0], "down": [-1.0, 0.0, 0.0], "to the sun": sun, "from the sun": -sun}

    def tangent(sphere):
        return -np.arccos(min(sphere / radius, 1.0))

    for name, sphere in (("horizon", bottom), ("limb", top)):
        for side in (-1.0, 1.0):
            for azimuth in AZIMUTHS:
                angle = tangent(sphere) + side * offset
                rays[f"{name} {side:+.0f}, azimuth {azimuth:.1f}"] = direction(angle, azimuth)
    for elevation in (-0.5, -0.01, 0.01, 0.5):
        rays[f"elevation {elevation}"] = direction(elevation, 0.7)
    if radius > top:
        for part in (0.1, 0.5, 0.9):
            rays[f"tangent at {part} of the air"] = direction(tangent(bottom + part * air.thickness), 0.7)
            rays[f"impact of {part} radii"] = direction(-np.arccos(part * bottom / radius), 0.7)
    return {name: np.asarray(ray) for name, ray in rays.items()}


class Compared:
    """Rays of one scene by the shaders and by the twin, fields (N, ...) by name."""

    def __init__(self, ctx, scene, origins, directions, t_max=None, quality=QUALITY, names=None):
        self.scene, self.names = scene, names
        self.got = sa.probe(ctx, scene, origins, directions, t_max=t_max, quality=quality)
        self.twin = reference.probe(scene, origins, directions, t_max=t_max)

    def errors(self, field, floor=1e-4):
        """Return (N,) errors: absolute of transmittances, in metres of lengths, relative of light.

        Light below `floor` of the rays' brightest counts as that much.
        """
        got, twin = getattr(self.got, field), getattr(self.twin, field)
        error = np.abs(got - twin)
        if field in ("single", "ground_direct"):
            error = error / np.maximum(twin, max(floor * twin.max(), 1e-30))
        return error.reshape(len(error), -1).max(axis=1)

    def check_sane(self):
        """Finite, not negative, no more light than there is."""
        for field in (*COLORS, *LENGTHS):
            assert np.isfinite(getattr(self.got, field)).all(), field
            assert (getattr(self.got, field) >= 0.0).all(), field
        assert (self.got.transmittance <= 1.0).all()

    def check(self, limit, *fields, floor=1e-4):
        """Every error of the fields is below `limit`, a number or (N,)."""
        for field in fields:
            error = self.errors(field, floor)
            worst = int(np.argmax(error / np.broadcast_to(limit, error.shape)))
            name = worst if self.names is None else self.names[worst]
            where = f"{field} of {name}: {getattr(self.got, field)[worst]} for {getattr(self.twin, field)[worst]}"
            assert (error <= limit).all(), f"{error[worst]:.2e}, {where}"

    def check_ends(self):
        """What ends each ray is what the twin says."""
        differ = np.flatnonzero(self.got.end != self.twin.end)
        assert not differ.size, [(self.names[i], self.got.end[i], self.twin.end[i]) for i in differ]


def turned(directions, angle):
    """Return unit vectors (N, 3) turned by `angle` [rad], each about an axis of its own."""
    helper = np.where(np.abs(directions[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    side = np.cross(directions, helper)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    return np.cos(angle) * directions + np.sin(angle) * side
