"""A finite sun at the planet's limb: twin, shader, probe, ground and frames, and that others do not pay for it."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference, terminator
from shadowatmo.passes.constants import medium_defines, medium_uniforms, transmittance_defines
from shadowatmo.passes.gl.source import compose_source
from shadowatmo.passes.terminator import terminator_defines, terminator_uniforms
from shadowatmo.quality import as_quality
from shadowatmo.shadow import cylinder
from tests.cameras import SUN, facing, level
from tests.test_probe import probed

EARTH = sa.EARTH
R = EARTH.bottom_radius
DISC = dataclasses.replace(SUN, disc_at_terminator=True)
ALPHA = terminator.angular_radius(DISC)
QUICK = sa.Quality(depth="analytic", orders=1)
ACCURATE = dataclasses.replace(as_quality("accurate"), orders=1)
# as good as none: the light on the ground then has a closed form
VACUUM = dataclasses.replace(
    EARTH,
    rayleigh_scattering=(1e-12,) * 3,
    mie_scattering=(1e-12,) * 3,
    mie_extinction=(1e-12,) * 3,
    ozone=None,
    ground_albedo=(1.0,) * 3,
)


def points(rng, count, air=EARTH, highest=25.0):
    """Return k and y (count,) of points all over the air, and the sun's elevation over their horizon in radii."""
    altitude = air.thickness * rng.uniform(0, 1, count) ** 3
    elevation = np.where(rng.uniform(size=count) < 0.6, rng.uniform(-1, 1, count), rng.uniform(-2, highest, count))
    r, k = air.bottom_radius + altitude, altitude * (2 * air.bottom_radius + altitude)
    zenith = np.pi / 2 + np.arctan2(np.sqrt(k), air.bottom_radius) - elevation * ALPHA
    return k, r * np.cos(zenith), elevation


def mean_cosine(elevation):
    """Return the mean cosine of incidence of a disc on level ground without air, by dense strips; `elevation` [rad]."""
    b = (np.arange(4000) + 0.5) * np.pi / 4000
    height = np.asarray(elevation)[..., None] + ALPHA * np.cos(b)
    return (2.0 / np.pi * np.sin(b) ** 2 * np.maximum(np.sin(height), 0.0)).sum(axis=-1) * np.pi / 4000


def shares(got, truth):
    """Return errors relative to each value, or to a ten-thousandth of its brightest channel."""
    return np.abs(got - truth) / np.maximum(truth, np.maximum(1e-4 * truth.max(axis=1, keepdims=True), 1e-12))


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_rule_is_gaussian(count):
    for q in (0.02, 0.4, 0.9, 1.0):
        nodes, weights = terminator.visible_rule(q, count)
        b = np.arccos(1 - 2 * q) * (np.arange(200000) + 0.5) / 200000
        measure = 2 / np.pi * np.sin(b) ** 2 * np.arccos(1 - 2 * q) / 200000
        v = np.sin(b / 2) ** 2 / q
        for power in range(2 * count + 1):
            # midpoint rule of 2e5 nodes: 1e-10; the first power beyond the rule's own is off by more
            off = abs(weights @ nodes**power - (measure * v**power).sum()) / measure.sum()
            assert (off < 1e-8) == (power < 2 * count), (q, power, off)


def test_whole_disc_is_exact_and_polynomials_are_close():
    nodes, weights = terminator.strip_polynomials(2)
    assert np.allclose(1 - 2 * nodes[0], [0.5, -0.5]) and np.allclose(weights[0], 0.5)  # Chebyshev's second kind
    for count in (2, 3):
        nodes, weights = terminator.strip_polynomials(count)
        for q in np.linspace(0.01, 1, 50):
            powers = np.sqrt(1 - q) ** np.arange(terminator.DEGREE + 1)
            true_nodes, true_weights = terminator.visible_rule(q, count)
            # the fits' own errors; a share of the disc, so that a sliver of it need not be known to a part of itself
            assert np.max(np.abs(powers @ nodes - true_nodes)) < 4e-3
            assert np.max(np.abs(powers @ weights * q**1.5 - true_weights)) < 2e-3
        assert np.max(np.abs(powers[:2] @ nodes[:2] - true_nodes)) < 1e-9  # all of them at q = 1
        assert not np.allclose(nodes[0], terminator.visible_rule(0.05, count)[0], atol=4e-3)


# strips, then bars of the 95th and 99th percentile and the worst that one strip less does not meet
@pytest.mark.parametrize(("count", "bars"), [(2, (0.02, 0.25, 0.5)), (3, (0.004, 0.02, 0.1))])
def test_strips_against_the_converged_mean(rng, count, bars):
    k, y, _ = points(rng, 3000)
    truth = reference._disc_light(EARTH, DISC, k, y, reference.Accuracy())
    measured = {n: np.percentile(shares(terminator.disc_transmittance(EARTH, DISC, k, y, n), truth), (95, 99, 100))
                for n in (count - 1, count)}  # fmt: skip
    assert np.all(measured[count] < bars) and np.all(measured[count - 1] > bars)


def test_night_begins_where_the_whole_disc_has_set(rng):
    for cone, elevation in ((terminator.night_cone(R, DISC), -ALPHA), (cylinder(R), 0.0)):
        z = rng.uniform(0.01, 0.14, 200) * R
        r = np.hypot(cone.width(z), z)
        air = dataclasses.replace(EARTH, top_radius=1.1 * R)
        sine = terminator.elevation_sine(air, (r - R) * (r + R), -z)
        assert np.allclose(np.arcsin(sine), elevation, rtol=0, atol=1e-9)  # float64 over metres


def test_cuts_of_night_and_dusk(glsl):
    none = (1e30, 1e30)
    cases = {  # night, dusk, cut of a ray that ends at 10
        ((2, 5), (1, 6)): (2, 5),
        ((-3, 4), (-4, 5)): (-3, 4),
        (none, (4, 7)): (5.5, 5.5),  # the middle of a dusk that lies inside
        (none, (-90, 3)): (3, 3),
        (none, (8, 50)): (8, 8),
        (none, none): (10, 10),
        ((8, 3), (9, 2)): (10, 10),  # behind the plane where the cones begin
    }
    inputs = [np.array([pair[i] for pair in cases], np.float32) for i in (0, 1)]
    got = glsl(["night.glsl"], "out0.xy = night_or_dusk(in0.xy, in1.xy, 10.0);", inputs)[:, :2]
    assert np.array_equal(got, np.array(list(cases.values()), np.float32))


@pytest.mark.parametrize("quality", [QUICK, ACCURATE], ids=["2 strips", "3 strips"])
def test_disc_in_the_shader(glsl, rng, quality):
    k, y, elevation = (a.astype(np.float32).astype(float) for a in points(rng, 4000))
    defines = {**terminator_defines(DISC, quality), **medium_defines(EARTH), **transmittance_defines(EARTH, quality)}
    del defines["HAS_TERMINATOR"]
    uniforms = {**medium_uniforms(EARTH), **terminator_uniforms(DISC)}
    code = "out0.rgb = disc_light(vec3(0.0), in0.x, in0.y);"
    got = glsl(["terminator.glsl"], code, [np.stack([k, y], axis=1)], uniforms, defines)[:, :3]
    args = EARTH, DISC, k, y, defines["STRIPS"], quality.terms, "HAS_TOP" in defines
    truth = terminator.disc_transmittance(*args)
    assert np.isfinite(got).all() and np.all(got[elevation < -1.001] == 0.0)
    # float32 heights of 1e-7 of 800 km, over a scale height; and an elevation of 1e-8 of the disc's 0.005
    assert np.max(np.abs(got - truth)) < 2e-5
    other = dataclasses.replace(DISC, radius=1.01 * DISC.radius)
    assert np.max(np.abs(got - terminator.disc_transmittance(args[0], other, *args[2:]))) > 2e-4


def test_disc_where_the_shader_could_divide_by_nothing(glsl):
    """Sun overhead and underfoot, on the horizon, below the ground, at the center of the terminator plane."""
    k = np.array([0.0, 0.0, 0.0, 0.0, -1e6, 8e11, 8e11, 0.0])
    y = np.array([R, -R, 0.0, -1e-6, -1.0, R + 6e4, -R - 6e4, 1e-30])
    defines = {**terminator_defines(DISC, QUICK), **medium_defines(EARTH), **transmittance_defines(EARTH, QUICK)}
    del defines["HAS_TERMINATOR"]
    code = "out0.rgb = disc_light(vec3(0.0), in0.x, in0.y); out1.rgb = disc_irradiance(in0.x, in0.y, 0.5, 0.5);"
    uniforms = {**medium_uniforms(EARTH), **terminator_uniforms(DISC)}
    light, irradiance = glsl(["terminator.glsl"], code, [np.stack([k, y], axis=1)], uniforms, defines, outputs=2)
    assert np.isfinite(light).all() and np.isfinite(irradiance).all()
    assert np.all(light[[1, 6]] == 0.0) and np.all(light[[0, 5], :3] > 0.1) and np.all(light[:, :3] <= 1.0)


def test_reference_cases(ctx):
    for quality, bar in ((ACCURATE, 2e-3), (QUICK, 2e-2)):
        pairs = [(got["single"], np.array(case["expected"]["single"])) for case, got in
                 probed(ctx, "single_disc", quality)]  # fmt: skip
        got, truth = (np.array(side) for side in zip(*pairs, strict=True))
        # nodes and strips: measured 5e-4 with 20 and 3, 8e-3 with 8 and 2
        assert len(got) == 10 and np.percentile(shares(got, truth), 95) < bar


def dusk_rays(rng, count):
    """Return rays from 1 to 2000 km that cross the air about the terminator, not too near the ground."""

    def about(lowest, highest):
        zenith = np.radians(rng.uniform(86, 97, count))
        up = np.stack([np.cos(zenith), np.sin(zenith), rng.normal(size=count) * 0.03], axis=1)
        up /= np.linalg.norm(up, axis=1, keepdims=True)
        return up * (R + 10 ** rng.uniform(lowest, highest, (count, 1)))

    origins, aims = about(3, 6.3), about(4, 4.7)
    return origins, aims - origins



def test_probe_against_the_twin(ctx, rng):
    origins, directions = dusk_rays(rng, 12)
    truth, hard = (reference.probe(sa.Scene(suns=s), origins, directions) for s in (DISC, SUN))
    got = sa.probe(ctx, sa.Scene(suns=DISC), origins, directions, quality=ACCURATE)
    bright = truth.single.max(axis=1) > 1e-9
    assert bright.sum() > 8
    # nodes and strips of "accurate"; the hard shadow is further off by far
    assert np.percentile(shares(got.single, truth.single)[bright], 95) < 2e-3
    assert np.percentile(shares(hard.single, truth.single)[bright], 95) > 2e-2
    for name in ("lit", "shadow"):  # lengths are those of the parallel light, whatever the disc does
        assert np.allclose(getattr(got, name), getattr(hard, name), rtol=1e-6, atol=1.0)


def test_moon_over_dusk(ctx, rng):
    origins, directions = dusk_rays(rng, 6)
    moon = sa.Occluder((3.7e8, 5.9e6, 0.0), 1.6e6)
    got, truth, whole = (p(s) for p, s in (
        (lambda s: sa.probe(ctx, s, origins, directions, quality=ACCURATE), sa.Scene(suns=DISC, occluders=moon)),
        (lambda s: reference.probe(s, origins, directions), sa.Scene(suns=DISC, occluders=moon)),
        (lambda s: reference.probe(s, origins, directions), sa.Scene(suns=DISC)),
    ))  # fmt: skip
    bright = whole.single[:, 0] > 1e-9
    error = np.abs(got.single - truth.single)[bright] / whole.single[bright].max(axis=1, keepdims=True)
    # the eclipse pass is right to 1e-3 of the light without a moon
    assert bright.sum() > 3 and error.max() < 2e-3
    assert np.median((truth.single[:, 0] / whole.single[:, 0])[bright]) < 0.9


def ground_light(probe, sun, elevations, air=EARTH):
    """Return ground_direct (N, 3) seen from 1 m right above, by the sun's elevation there [rad]."""
    up = np.stack([np.sin(elevations), np.cos(elevations), 0 * elevations], axis=1)
    return probe(sa.Scene(air, sun), up * (air.bottom_radius + 1.0), -up).ground_direct


def test_ground_under_a_half_set_sun(ctx):
    elevations = ALPHA * np.linspace(-1.2, 1.2, 25)
    twin = ground_light(reference.probe, DISC, elevations, VACUUM)[:, 1]
    # 48 strips over a kink of sunlight that begins at the horizon, where the strips begin too; air of 1e-7
    assert np.allclose(twin, mean_cosine(elevations) / np.pi, rtol=0, atol=1e-5 * ALPHA)
    assert np.isclose(twin[12], 2 * ALPHA / (3 * np.pi) / np.pi, rtol=1e-4)  # half of it: closed form
    assert np.all(twin[elevations < -1.001 * ALPHA] == 0.0) and np.all(np.diff(twin) >= 0.0)
    assert ground_light(reference.probe, SUN, elevations, VACUUM)[12, 1] < 1e-3 * twin[12]

    def probe(*rays):
        return sa.probe(ctx, *rays, quality=ACCURATE)

    drawn = ground_light(probe, DISC, elevations, VACUUM)[:, 1]
    # 3 strips with fitted nodes: a hundredth of the largest cosine
    assert np.max(np.abs(drawn - twin)) < 0.01 * twin.max()
    in_air, truth = (ground_light(p, DISC, elevations) for p in (probe, reference.probe))
    assert np.max(np.abs(in_air - truth)) < 0.01 * truth.max()
    high = np.array([0.5, 1.0])
    assert np.allclose(*(ground_light(reference.probe, s, high) for s in (DISC, SUN)), rtol=1e-5)


def profile(ctx, camera, sun, air=VACUUM, size=(121, 31), quality=QUICK):
    """Return a frame of the lit ground and the middle row of its green channel."""
    with sa.Renderer(ctx, sa.Scene(air, sun, surface=sa.Surface()), size, quality) as renderer:
        frame = renderer.render(camera).numpy()
    return frame, frame[size[1] // 2, :, 1]


# the penumbra on the ground is 59 km wide: 20 to 40 pixels
@pytest.mark.parametrize(("distance", "fov"), [(R + 4e5, 6.0), (2e7, 0.15)], ids=["400km", "space"])
def test_edge_of_day_is_smooth(ctx, distance, fov):
    camera = facing((0, 1, 0), distance, fov)
    hard, soft = (profile(ctx, camera, sun)[1] for sun in (SUN, DISC))
    rise = np.abs(np.diff(hard)).max()
    bend = [np.abs(np.diff(row, n=2)).max() / rise for row in (hard, soft)]
    # without a disc the slope begins within a pixel or two; with it, over 20
    assert bend[0] > 0.4 and bend[1] < 0.15
    assert (soft > 1e-3 * soft.max()).sum() > (hard > 1e-3 * hard.max()).sum() + 5  # day reaches farther
    rays = camera.pixel_rays((121, 31))[15]
    ends = reference.lengths(sa.Scene(VACUUM), np.tile(camera.position, (121, 1)), rays).t_end
    hits = np.array(camera.position) + ends[:, None] * rays
    truth = mean_cosine(np.arcsin(hits[:, 0] / R)) / np.pi
    assert np.max(np.abs(soft - truth)) < 0.02 * truth.max()  # 2 strips


def test_air_of_a_frame_against_the_twin(ctx):
    camera, size = level(92, 2e4, 90, -3, 40), (32, 18)
    scene = sa.Scene(suns=DISC)
    frames = []
    for quality in (QUICK, sa.Quality(depth="textures", orders=1)):
        with sa.Renderer(ctx, scene, size, quality) as renderer:
            frames.append(renderer.render(camera).numpy())
    rays = camera.pixel_rays(size)[::3, 5::9].reshape(-1, 3)
    truth = reference.probe(scene, np.tile(camera.position, (len(rays), 1)), rays).single
    for frame in frames:
        error = np.abs(frame[::3, 5::9].reshape(-1, 3) - truth) / truth.max(axis=1, keepdims=True)
        assert error.max() < 1e-2  # 8 nodes, 2 strips
    assert np.allclose(*frames, rtol=1e-3, atol=1e-7)  # night from depth textures, or solved


def test_high_sun_is_a_point(ctx):
    camera = level(40, 2.0, 30, 10)
    frames = []
    for sun in (SUN, DISC):
        with sa.Renderer(ctx, sa.Scene(suns=sun), (32, 18), QUICK) as renderer:
            frames.append(renderer.render(camera).numpy())
    assert np.array_equal(*frames)
    assert not np.array_equal(*(profile(ctx, level(89, 2.0, 30, 10), sun, EARTH)[0] for sun in (SUN, DISC)))


def test_who_asks_for_no_disc_pays_nothing(ctx):
    features = {"HAS_AIR": True, "HAS_SEGMENTS": True, "HAS_SHADOW": True}
    words = ("disc_light", "u_sun_angle", "STRIP", "u_dusk", "u_high_sun", "night_or_dusk")
    for name in ("probe.frag", "atmosphere.frag", "widths.frag", "planet.frag"):
        plain = compose_source(name, features, optional=features).text
        assert not any(word in plain for word in words), name
        asked = compose_source(name, {**features, "HAS_TERMINATOR": True}, optional=features).text
        assert any(word in asked for word in words), name
    assert terminator_defines(SUN, QUICK) == {} and terminator_uniforms(SUN) == {}


def test_plan_tells(ctx, caplog):
    with sa.Renderer(ctx, sa.Scene(suns=DISC), (8, 8), QUICK) as renderer:
        assert "2 strips of the disc above the limb" in str(renderer.plan) and "whole disc" in str(renderer.plan)
    with sa.Renderer(ctx, sa.Scene(suns=SUN), (8, 8), QUICK) as renderer:
        assert "disc" not in str(renderer.plan)
    assert not caplog.records
    with sa.Renderer(ctx, sa.Scene(suns=DISC), (8, 8), sa.Quality(method="widths")) as renderer:
        assert "disc_at_terminator: left out" in str(renderer.plan)
    assert "disc_at_terminator" in caplog.text
