"""What the tests of hard cases share: fans of rays, suns, perturbations, and the comparison with the float64 twin."""

from dataclasses import dataclass, replace

import numpy as np

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.extremes import is_thick
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

    Up, down, to and from the sun and beside it, `offset` [rad] beside the horizon and the limb, and a few between.
    """
    radius, bottom, top = air.bottom_radius + altitude, air.bottom_radius, air.top_radius
    sun = np.array(sun) / np.linalg.norm(sun)
    rays = {"up": [1.0, 0.0, 0.0], "down": [-1.0, 0.0, 0.0], "to the sun": sun, "from the sun": -sun}

    # where (1 - g)^2 + 2 g (1 - nu) of a sharp phase function is a matter of the last digits
    for angle in (1e-3, 1e-2):
        rays[f"{angle:g} beside the sun"] = turned(sun[None], angle)[0]
        rays[f"{angle:g} from opposite"] = -turned(sun[None], angle)[0]

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


def shell_fan(air, sun):
    """Return origins (N, 3), directions (N, 3) and names of rays from six altitudes, in the shell and above it."""
    origins, directions, names = [], [], []
    for share in (1e-6, 0.03, 0.5, 0.999, 1.5, 10.0 * air.top_radius / air.thickness):
        for name, ray in ray_fan(air, share * air.thickness, sun).items():
            origins.append([air.bottom_radius + share * air.thickness, 0.0, 0.0])
            directions.append(ray)
            names.append(f"{name}, from {share:.3g} of the shell")
    return np.array(origins), np.array(directions), names


@dataclass(frozen=True)
class Case:
    """An air and how far the shaders may be off, with the reason.

    transmittance : absolute; light : relative, of light down to 1e-4 of the rays' brightest, in thick air to 1e-3;
    smooth : of the light, what float32 may add to a small change of the input.
    """

    air: sa.Atmosphere
    transmittance: float = 1e-4
    light: float = 2.5e-3
    smooth: float = 2e-5
    reason: str = "closed form 2e-5, float32, ozone's straight sides 1.6e-3 where sunlight grazes them"


NO_OZONE = 5e-4  # light where no layer has straight sides: the closed form and 20 nodes leave 3e-4


class Compared:
    """Rays of one scene by the shaders and by the twin, fields (N, ...) by name."""

    def __init__(self, ctx, scene, origins, directions, t_max=None, quality=QUALITY, names=None):
        self.scene, self.names = scene, names
        self.got = sa.probe(ctx, scene, origins, directions, t_max=t_max, quality=quality)
        self.twin = reference.probe(scene, origins, directions, t_max=t_max)

    def errors(self, field, floor=1e-4, dark=1e-30):
        """Return (N,) errors: absolute of transmittances, in metres of lengths, relative of light.

        Light below `floor` of the rays' brightest, or below `dark` [1/sr], counts as that much.
        """
        got, twin = getattr(self.got, field), getattr(self.twin, field)
        error = np.abs(got - twin)
        if field in ("single", "ground_direct"):
            error = error / np.maximum(twin, max(floor * twin.max(), dark))
        return error.reshape(len(error), -1).max(axis=1)

    def check_sane(self):
        """Finite, not negative, no more light than there is."""
        for field in (*COLORS, *LENGTHS):
            assert np.isfinite(getattr(self.got, field)).all(), field
            assert (getattr(self.got, field) >= 0.0).all(), field
        assert (self.got.transmittance <= 1.0).all()

    def check(self, limit, *fields, floor=1e-4, dark=1e-30):
        """Every error of the fields is below `limit`, a number or (N,)."""
        for field in fields:
            error = self.errors(field, floor, dark)
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


def check_air(ctx, case):
    """Hold an air against the twin: from six altitudes, under five suns."""
    air = case.air
    for sun in SUNS.values():
        origins, directions, names = shell_fan(air, sun)
        rays = Compared(ctx, sa.Scene(air, sa.Sun(sun)), origins, directions, names=names)
        rays.check_sane()
        rays.check_ends()
        rays.check(case.transmittance, "transmittance")
        # In thick air what is dimmer than 1e-3 of the brightest came through 7 mean free paths, and what is dimmer than
        # 1e-6 of a white wall through the 16 behind which nothing is looked for.
        limits = {"floor": 1e-3, "dark": 1e-6} if is_thick(air) else {}
        rays.check(case.light, "single", "ground_direct", **limits)
        rays.check(1e-6 * air.top_radius + 1e-7 * np.linalg.norm(origins, axis=1), "lit", "shadow")


def check_small_changes(ctx, case):
    """Rays turned by 1e-6, air 1e-6 denser: the light changes by what the twin says, and by a share that is stated."""
    air, sun = case.air, SUNS["80 degrees"]
    origins, directions, names = shell_fan(air, sun)
    before = Compared(ctx, sa.Scene(air, sa.Sun(sun)), origins, directions, names=names)
    rayleigh = tuple((1.0 + 1e-6) * beta for beta in air.rayleigh_scattering)
    denser = replace(air, rayleigh_scattering=rayleigh, mie_scale_height=air.mie_scale_height * (1.0 - 1e-6))
    for rays, other in ((turned(directions, 1e-6), air), (directions, denser)):
        after = Compared(ctx, sa.Scene(other, sa.Sun(sun)), origins, rays, names=names)
        check_change(before, after, case.smooth, dark=1e-6 if is_thick(air) else 1e-30)


def check_change(before, after, limit, dark=1e-30):
    """What changed from one comparison to the other is what changed in the twin, and at most `limit` more.

    A ray that leaves the ground changes by a jump in both, and is left out.
    """
    same = before.twin.end == after.twin.end
    assert same.mean() > 0.4
    for field in COLORS:
        found, wanted = (
            np.abs(getattr(b, field) - getattr(a, field))
            for a, b in ((before.got, after.got), (before.twin, after.twin))
        )
        light = np.maximum(getattr(before.twin, field), getattr(after.twin, field))
        unit = 1.0 if field == "transmittance" else np.maximum(light, max(1e-3 * light.max(), dark))
        excess = np.where(same[:, None], (found - wanted) / unit, 0.0).max(axis=1)
        worst = int(np.argmax(excess))
        assert excess[worst] < limit, (field, before.names[worst], excess[worst])
