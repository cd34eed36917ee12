"""The float64 probe: the published cases, closed forms, symmetry, convergence."""

import json
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from shadowatmo import reference
from shadowatmo.errors import ParameterError
from shadowatmo.parameters import Atmosphere, Occluder, Sun, TentLayer
from shadowatmo.phase import rayleigh_phase
from shadowatmo.presets import EARTH, MARS
from shadowatmo.rays import Rays
from shadowatmo.reference import Accuracy, _probe, lengths, probe, transmittance_to_sun
from shadowatmo.scene import Scene

FILE = json.loads((Path(__file__).parent / "data" / "cases_public.json").read_text(encoding="utf-8"))
SUN = Sun((1, 0, 0))
R = EARTH.bottom_radius
# Twelve digits are printed: up to 5e-12 of t, up to 1e9 m away. Lengths of grazing rays add the rounding of
# their inputs.
T_TOLERANCE = {"rtol": 6e-12, "atol": 1e-6}
LENGTH_TOLERANCE = {"rtol": 6e-12, "atol": 1e-5}
PRESET_FIELDS = {
    "Rb": "bottom_radius",
    "Rt": "top_radius",
    "beta_R": "rayleigh_scattering",
    "H_R": "rayleigh_scale_height",
    "beta_M": "mie_scattering",
    "beta_Me": "mie_extinction",
    "H_M": "mie_scale_height",
    "g": "mie_g",
    "albedo": "ground_albedo",
}


def case_scene(case):
    preset = FILE["presets"][case["preset"]]
    tent = preset["ozone"] and TentLayer(*(preset["ozone"][key] for key in ("centre", "half_width", "peak")))
    air = Atmosphere(**{name: preset[key] for key, name in PRESET_FIELDS.items()}, ozone=tent)
    sun = case.get("sun", {"dir": (0, 0, 1)})
    values = {"direction": sun["dir"], "limb_darkening": sun.get("limb_u", 0.0)}
    if "distance" in sun:
        values.update(distance=sun["distance"], radius=sun["radius"])
    if sun.get("model") == "disc":
        values.update(radius=1.496e11 * np.sin(sun["angular_radius"]), disc_at_terminator=True)
    moons = tuple(Occluder(moon["centre"], moon["radius"]) for moon in case.get("occluders", ()))
    return Scene(air, Sun(**values), moons)


def probed(kind):
    """Yield (expected, result of its ray) for the cases of a kind; rays of one scene are traced together."""
    groups = defaultdict(list)
    for case in FILE["cases"]:
        if case["kind"] == kind:
            groups[json.dumps([case["preset"], case.get("sun"), case.get("occluders")])].append(case)
    for cases in groups.values():
        t_max = [case.get("t_max", np.inf) for case in cases]
        origins, directions = ([case[key] for case in cases] for key in ("origin", "direction"))
        result = probe(case_scene(cases[0]), origins, directions, t_max)
        for i, case in enumerate(cases):
            yield case["expected"], _row(result, i)


def _row(result, i):
    return {name: None if value is None else value[i] for name, value in vars(result).items()}


@pytest.mark.parametrize(
    "kind",
    ["transmittance", "lengths_planet_shadow", "lengths_umbra", "lengths_penumbra", "single", "single_disc"],
)
def test_segments_of_the_cases(kind):
    for expected, got in probed(kind):
        assert got["end"] == expected["end"]
        for name in ("t_in", "t_out", "t_end"):
            value = np.nan if expected[name] is None else expected[name]
            assert np.allclose(got[name], value, **T_TOLERANCE, equal_nan=True)


@pytest.mark.parametrize("kind", ["transmittance", "single", "eclipse_single", "multiple"])
def test_transmittance_of_the_cases(kind):
    # twelve printed digits and the rounding of inputs 1e9 m away; measured 5e-12
    for expected, got in probed(kind):
        assert np.allclose(got["transmittance"], expected.get("transmittance", 1.0), rtol=0, atol=1e-11)


@pytest.mark.parametrize("kind", ["single", "single_disc", "eclipse_single", "multiple"])
def test_single_scattering_of_the_cases(kind):
    # the values are converged to 1e-9, printed to 12 digits; measured 2e-10 (an eye 0.5 m up: altitude known
    # to 1e-10)
    for expected, got in probed(kind):
        single = np.array(expected["single"])
        assert np.allclose(got["single"], single, rtol=1e-9, atol=1e-11 * single.max() + 1e-16)


def test_ground_of_the_cases():
    grounds = [(e, got) for e, got in probed("multiple") if "ground_direct" in e]
    assert grounds
    for expected, got in grounds:
        assert np.allclose(got["ground_direct"], expected["ground_direct"], rtol=1e-8, atol=1e-15)


@pytest.mark.parametrize(
    ("kind", "fields"),
    [
        ("lengths_planet_shadow", {"shadow": "shadow", "lit": "lit"}),
        ("lengths_umbra", {"planet_umbra": "umbra", "planet_penumbra": "penumbra"}),
        ("lengths_penumbra", {"umbra": "umbra", "antumbra": "antumbra", "penumbra": "penumbra"}),
    ],
)
def test_lengths_of_the_cases(kind, fields):
    for expected, got in probed(kind):
        for name, key in fields.items():
            assert np.allclose(got[name], expected[key], **LENGTH_TOLERANCE)


def test_a_wrong_sun_is_noticed():
    """The tolerances above reject a direction that is off by 1e-6."""
    case = next(c for c in FILE["cases"] if c["kind"] == "single" and c["expected"]["end"] != "miss")
    scene = case_scene(case)
    moved = scene.with_sun_direction(np.array(scene.suns[0].direction) + [1e-6, 0, 0])
    got = probe(moved, case["origin"], case["direction"], case.get("t_max", np.inf)).single[0]
    assert not np.allclose(got, case["expected"]["single"], rtol=1e-9, atol=0)


def test_vacuum_is_clear():
    empty = replace(
        EARTH, rayleigh_scattering=(0, 0, 0), mie_scattering=(0, 0, 0), mie_extinction=(0, 0, 0), ozone=None
    )
    result = probe(Scene(empty, SUN), [[R + 10, 0, 0], [R + 10, 0, 0]], [[0, 1, 0], [-1, 0, 0]])
    assert np.all(result.transmittance == 1) and np.all(result.single == 0)
    # albedo / pi with the sun at the zenith
    assert np.allclose(result.ground_direct, [[0, 0, 0], [0.1 / np.pi] * 3], rtol=1e-14, atol=0)


def test_level_air_in_closed_form():
    """Level density, the sun at the zenith: light passes the same air wherever it scatters."""
    beta = 1e-5
    level = replace(
        EARTH,
        rayleigh_scattering=(beta,) * 3,
        rayleigh_scale_height=1e14,
        mie_scattering=(0, 0, 0),
        mie_extinction=(0, 0, 0),
        ozone=None,
    )
    result = probe(Scene(level, SUN), [R + 5e3, 0, 0], [1, 0, 0])
    depth = beta * 55e3
    # the density falls by 6e-10 over the layer
    assert np.allclose(result.transmittance, np.exp(-depth), rtol=1e-9, atol=0)
    assert np.allclose(result.single, depth * np.exp(-depth) * rayleigh_phase(1.0), rtol=2e-9, atol=0)


def test_a_miss_and_no_rays():
    result = probe(Scene(EARTH, SUN), [[2 * R, 0, 0]], [[1, 0, 0]])
    assert result.end[0] == "miss" and np.isnan(result.t_in[0])
    assert np.all(result.transmittance == 1) and np.all(result.single == 0) and result.lit[0] == 0
    assert result.multiple is None and result.ground_multiple is None
    none = probe(Scene(EARTH, SUN), np.empty((0, 3)), np.empty((0, 3)))
    assert len(none) == 0 and none.single.shape == (0, 3) and none.umbra.shape == (0, 0)


def grazing_rays(count, seed=7):
    """Rays from 1 m to 1000 km up, most of them close to the horizon; the sun in all positions."""
    rng = np.random.default_rng(seed)
    up = rng.normal(size=(count, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    side = np.cross(up, rng.normal(size=(count, 3)))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    radius = R + 10 ** rng.uniform(0, 6, count)
    elevation = rng.choice([-1, 1, 1], count) * 10 ** rng.uniform(-4, 0, count) - np.arccos(R / radius)
    return up * radius[:, None], up * np.sin(elevation)[:, None] + side * np.cos(elevation)[:, None]


def relative(a, b):
    # below 1e-20 nothing is left but light through 40 optical depths at the edge of the shadow
    return (np.abs(a - b) / np.maximum(b, 1e-4 * b.max(axis=1, keepdims=True) + 1e-20)).max()


MOON = Occluder((3.8e8, 1e5, 0), 1.74e6)
FINE = Accuracy(nodes=24, column_nodes=24, disc_nodes=96, tolerance=1e-11)


@pytest.mark.parametrize(
    ("scene", "count"),
    [
        (Scene(EARTH, SUN), 150),
        (Scene(EARTH, SUN, MOON), 100),
        (Scene(EARTH, replace(SUN, disc_at_terminator=True)), 5),
    ],
)
def test_twice_the_nodes_change_nothing(scene, count):
    rays = Rays.validated(*grazing_rays(count))
    usual, fine = _probe(scene, rays, Accuracy()), _probe(scene, rays, FINE)
    assert relative(usual.single, fine.single) < 1e-9
    assert relative(usual.transmittance, fine.transmittance) < 1e-9
    rough = _probe(scene, rays, Accuracy(nodes=3, column_nodes=3, disc_nodes=3, tolerance=1e-1))
    assert relative(rough.single, fine.single) > 1e-6


def test_turning_everything_changes_nothing():
    rng = np.random.default_rng(4)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    origins, directions = grazing_rays(40)
    plain = probe(Scene(EARTH, SUN, MOON), origins, directions)
    turned_scene = Scene(EARTH, Sun(turn @ (1, 0, 0)), Occluder(turn @ MOON.center, MOON.radius))
    turned = probe(turned_scene, origins @ turn.T, directions @ turn.T)
    # turned coordinates are rounded by 1e-9 m, which moves grazing rays by up to 1e-5 m
    assert relative(turned.single, plain.single) < 1e-7
    for name in ("shadow", "planet_umbra", "planet_penumbra", "umbra", "antumbra", "penumbra"):
        assert np.allclose(getattr(turned, name), getattr(plain, name), rtol=0, atol=1e-2)


def test_light_of_several_suns_adds_up():
    origins, directions = grazing_rays(15)
    one, other = Sun((1, 0, 0), irradiance=(1, 0.5, 2)), Sun((0, 1, 0.2), irradiance=(0.1, 3, 0))
    both, first, second = (
        probe(Scene(EARTH, suns), origins, directions) for suns in ((one, other), one, other)
    )
    for name in ("single", "ground_direct"):
        total = getattr(first, name) + getattr(second, name)
        assert np.allclose(getattr(both, name), total, rtol=1e-14, atol=0)  # the same panels, added once
    assert np.array_equal(both.shadow, first.shadow)


def test_moon_in_front_takes_light_away():
    big = Occluder((3.8e8, 0, 0), 2e7)  # hides the sun from the whole planet
    origins, directions = grazing_rays(10)
    dark = probe(Scene(EARTH, SUN, big), origins, directions)
    assert np.all(dark.single == 0) and np.all(dark.ground_direct == 0)
    assert np.allclose(dark.umbra[:, 0], np.nan_to_num(dark.t_end - dark.t_in), rtol=1e-12, atol=1e-8)


def test_lengths_are_those_of_the_probe():
    origins, directions = grazing_rays(30)
    scene = Scene(MARS, SUN, MOON)
    full, quick = probe(scene, origins, directions, 5e5), lengths(scene, origins, directions, 5e5)
    assert quick.single is None and quick.transmittance is None and quick.ground_direct is None
    for name in (
        "t_in",
        "t_end",
        "end",
        "lit",
        "shadow",
        "planet_umbra",
        "planet_penumbra",
        "umbra",
        "penumbra",
    ):
        assert np.array_equal(getattr(full, name), getattr(quick, name), equal_nan=name.startswith("t_"))


def test_transmittance_to_the_sun():
    points = np.array([[R + 1.0, 0, 0], [-R - 1.0, 0, 0], [0, 2 * R, 0]])
    result = transmittance_to_sun(EARTH, points, (1, 0, 0))
    assert np.array_equal(result[1], [0, 0, 0]) and np.array_equal(result[2], [1, 1, 1])
    assert np.array_equal(result[:1], probe(Scene(EARTH, SUN), points[:1], (1, 0, 0)).transmittance)


def test_malformed_rays_are_refused():
    with pytest.raises(ParameterError, match="directions"):
        reference.probe(Scene(EARTH, SUN), [[R, 0, 0]], [[0, 0, 0]])
