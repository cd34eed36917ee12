"""What Hypothesis draws for the tests of properties: airs, rays, cameras, moons, rings, suns and depth conventions."""

import numpy as np
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

import shadowatmo as sa
from shadowatmo.parameters import MAX_LENGTH

CHECKS = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow]


def examples(count):
    """The same examples in every run: what was found once is kept below, not in a database."""
    return settings(derandomize=True, deadline=None, max_examples=count, database=None, suppress_health_check=CHECKS)


def powers(low, high):
    """Numbers between two powers of ten, uniform in the exponent."""
    return st.floats(low, high).map(lambda exponent: 10.0**exponent)


def triples(values):
    return st.tuples(values, values, values)


@st.composite
def directions(draw):
    v = np.array(draw(triples(st.floats(-1.0, 1.0))))
    length = np.linalg.norm(v)
    return tuple(v / length) if length > 1e-3 else draw(st.sampled_from([(1.0, 0.0, 0.0), (0.0, 0.0, -1.0)]))


@st.composite
def any_airs(draw):
    """Whatever an Atmosphere accepts, but for shells so thin that float64 rounds them away."""
    radius = draw(powers(-3, 14))
    top = min(radius * (1.0 + draw(powers(-6, 2))), MAX_LENGTH)
    beta = st.one_of(st.just(0.0), powers(-18, 3))
    extinction = draw(triples(beta))
    ozone = None
    if draw(st.booleans()):
        half_width = draw(powers(-3, 12))
        center = half_width * draw(powers(-1, 1))
        if center - half_width > -radius:
            ozone = sa.TentLayer(center, half_width, draw(triples(beta)))
    return sa.Atmosphere(
        radius, top, draw(triples(beta)), draw(powers(-3, 15)),
        tuple(e * draw(st.floats(0.0, 1.0)) for e in extinction), extinction, draw(powers(-3, 15)),
        draw(st.floats(-0.999, 0.999)), ozone, draw(triples(st.floats(0.0, 1.0))),
    )  # fmt: skip


@st.composite
def likely_airs(draw):
    """Planets that one could meet: radii from 100 m to 1e8 m, any depth of shell, optical depths up to 30."""
    radius = draw(powers(2, 8))
    thickness = radius * draw(powers(-3, 0.7))
    heights = [thickness * draw(powers(-1.7, 0.7)) for _ in range(2)]
    depths = [draw(triples(powers(-4, 0.7))) for _ in range(2)]
    rayleigh, mie = (tuple(d / h for d in depth) for depth, h in zip(depths, heights, strict=True))
    ozone = None
    if draw(st.booleans()):
        half_width = thickness * draw(powers(-1, -0.5))
        ozone = sa.TentLayer(
            thickness * draw(st.floats(0.2, 0.9)), half_width, tuple(0.1 / half_width for _ in range(3))
        )
    albedo = draw(st.floats(0.5, 1.0))
    return sa.Atmosphere(
        radius, radius + thickness, rayleigh, heights[0], tuple(albedo * m for m in mie), mie, heights[1],
        draw(st.floats(-0.9, 0.9)), ozone,
    )  # fmt: skip


@st.composite
def rays_about(draw, air, count=40):
    """Origins from within the ground to far away, rays to all sides and through the air."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    up = rng.normal(size=(count, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    heights = air.thickness * 10.0 ** rng.uniform(-6, 1, count) * rng.choice([1.0, 1.0, 1.0, -0.001], count)
    heights = np.where(rng.random(count) < 0.2, air.top_radius * 10.0 ** rng.uniform(0, 4, count), heights)
    origins = up * np.maximum(air.bottom_radius + heights, 0.01 * air.bottom_radius)[:, None]
    aims = rng.normal(size=(count, 3)) * air.top_radius - origins
    rays = np.where(rng.random((count, 1)) < 0.5, aims, rng.normal(size=(count, 3)))
    return origins, rays / np.linalg.norm(rays, axis=1, keepdims=True)


@st.composite
def cameras(draw, air=sa.EARTH):
    up = np.array(draw(directions()))
    height = draw(powers(-3, 11))
    position = (air.bottom_radius + height) * up
    aim = np.array(draw(directions()))
    forward = aim if height < 1e6 else 0.9 * air.bottom_radius * aim - position
    return sa.Camera(
        position=position, forward=forward, up=draw(directions()), vertical_fov=np.radians(draw(st.floats(0.01, 175.0)))
    )


@st.composite
def moons(draw, air):
    """A moon beyond the air; its distance and its size in radii of the air's top, so that most shade some of it."""
    away = np.array(draw(directions()))
    radius = min(air.top_radius * draw(powers(-3, 0.1)), MAX_LENGTH)
    return sa.Occluder(tuple(air.top_radius * draw(powers(0.2, 2.5)) * away), radius)


@st.composite
def rings(draw, air):
    inner = min(air.top_radius * draw(powers(0.0, 1.0)), 0.4 * MAX_LENGTH)
    return sa.Ring((0.0, 0.0, 0.0), draw(directions()), inner, inner * (1.0 + draw(powers(-3, 0))), draw(powers(-2, 1)))


@st.composite
def suns(draw, air, disc=None):
    distance = air.top_radius * draw(powers(3, 6))
    return sa.Sun(
        draw(directions()), distance, distance * draw(powers(-4, -1)), draw(triples(st.floats(0.0, 2.0))),
        draw(st.floats(0.0, 1.0)), draw(st.booleans()) if disc is None else disc,
    )  # fmt: skip


@st.composite
def scenes(draw, airs, disc=None):
    """An air with one or two suns, up to two moons and a ring."""
    air = draw(airs)
    light = [draw(suns(air, disc)) for _ in range(draw(st.integers(1, 2)))]
    bodies = [draw(moons(air)) for _ in range(draw(st.integers(0, 2)))]
    around = [draw(rings(air))] if draw(st.booleans()) and draw(st.booleans()) else []
    return sa.Scene(air, light, bodies, rings=around, sun_disc=draw(st.booleans()))


@st.composite
def conventions(draw):
    """A depth convention of a host, near planes from 1 cm to 1000 km, units from 1 mm to 1e7 m."""
    kind = draw(st.sampled_from(["distance", "linear", "standard", "reversed", "logarithmic"]))
    near, unit = draw(powers(-2, 6)), draw(powers(-3, 7))
    infinite = kind != "logarithmic" and draw(st.booleans())
    far = np.inf if infinite else near * draw(powers(0.5, 9)) / unit
    return sa.DepthConvention(kind, near / unit, far, unit / near, unit)
