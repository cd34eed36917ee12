"""The probe: the shaders along single rays, against the reference cases and against the float64 twin."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import reference
from shadowatmo.quality import as_quality

SINGLE = dataclasses.replace(as_quality("accurate"), orders=1)  # for what does not depend on the further orders
CASES = json.loads((Path(__file__).parent / "data" / "cases_public.json").read_text("utf-8"))


def atmosphere(name):
    p = CASES["presets"][name]
    ozone = p["ozone"] and sa.TentLayer(p["ozone"]["centre"], p["ozone"]["half_width"], tuple(p["ozone"]["peak"]))
    return sa.Atmosphere(
        p["Rb"], p["Rt"], tuple(p["beta_R"]), p["H_R"], tuple(p["beta_M"]), tuple(p["beta_Me"]), p["H_M"], p["g"],
        ozone or None, tuple(p["albedo"]),
    )  # fmt: skip


def scene_of(case):
    sun = case.get("sun") or {"dir": (0.0, 0.0, 1.0)}
    more = {name: sun[name] for name in ("distance", "radius") if name in sun}
    if sun.get("model") == "disc":
        more = {"radius": 1.496e11 * np.sin(sun["angular_radius"]), "disc_at_terminator": True}
    occluders = tuple(sa.Occluder(tuple(o["centre"]), o["radius"]) for o in case.get("occluders", ()))
    return sa.Scene(
        atmosphere(case["preset"]), sa.Sun(sun["dir"], limb_darkening=sun.get("limb_u", 0.0), **more), occluders
    )


def probed(ctx, kind, quality):
    """Return (case, its probe result) for every public case of a kind, one call per scene."""
    groups = {}
    for case in CASES["cases"]:
        if case["kind"] == kind:
            groups.setdefault(json.dumps([case["preset"], case.get("sun"), case.get("occluders")]), []).append(case)
    for cases in groups.values():
        rays = [np.array([c[name] for c in cases]) for name in ("origin", "direction")]
        t_max = [c.get("t_max", np.inf) for c in cases]
        result = sa.probe(ctx, scene_of(cases[0]), *rays, t_max=t_max, quality=quality)
        for i, case in enumerate(cases):
            assert result.end[i] == case["expected"]["end"], case["id"]
            yield case, {name: value[i] for name, value in vars(result).items() if value is not None}


def relative_errors(ctx, quality):
    errors = []
    for case, got in probed(ctx, "single", quality):
        want = np.array(case["expected"]["single"])
        errors.append(np.abs(got["single"] - want) / np.maximum(want, max(1e-4 * want.max(), 1e-12)))
    return np.concatenate(errors)


def test_transmittance_of_the_reference_cases(ctx):
    errors = []
    for case, got in probed(ctx, "transmittance", SINGLE):
        if case["expected"]["end"] == "miss":
            assert np.all(got["transmittance"] == 1) and np.isnan(got["t_in"]) and np.all(got["single"] == 0)
        else:
            errors.append(np.abs(got["transmittance"] - case["expected"]["transmittance"]))
            assert abs(got["t_out"] - case["expected"]["t_out"]) < 1.0 + 1e-6 * case["expected"]["t_out"]
    # float32, and 20 nodes over limb paths of 1700 km
    assert np.percentile(errors, 95) < 1e-5 and np.max(errors) < 1e-4


@pytest.mark.parametrize(
    ("quality", "p95", "p99"),
    [
        ("accurate", 1e-3, 4e-3),  # closed form, 20 nodes: the fit's 2e-5 in optical depth, float32
        (sa.Quality(nodes=20, gap_nodes=10, transmittance="table"), 2e-3, 8e-3),  # cells of the 256 x 64 table
        ("balanced", 2e-2, 5e-2),  # 8 nodes, 4 terms, no top: 1e-2 on the thick toy planet
        ("fast", 6e-2, 2.5e-1),
    ],
)
def test_single_scattering_of_the_reference_cases(ctx, quality, p95, p99):
    errors = relative_errors(ctx, quality)
    assert np.percentile(errors, 95) < p95 and np.percentile(errors, 99) < p99


def test_effort_buys_accuracy(ctx):
    p95 = [np.percentile(relative_errors(ctx, q), 95) for q in ("fast", "balanced", "accurate")]
    assert p95[0] > 1.5 * p95[1] > 10 * p95[2]


@pytest.mark.parametrize("kind", ["lengths_planet_shadow", "lengths_umbra", "lengths_penumbra"])
def test_lengths_of_the_reference_cases(ctx, kind):
    fields = {
        "lengths_planet_shadow": {"lit": "lit", "shadow": "shadow"},
        "lengths_umbra": {"planet_umbra": "umbra", "planet_penumbra": "penumbra"},
        "lengths_penumbra": {"umbra": "umbra", "antumbra": "antumbra", "penumbra": "penumbra"},
    }[kind]
    for case, got in probed(ctx, kind, SINGLE):
        # half a metre, or a share of a small planet; penumbrae of a moon 4e8 m away keep 6e-8 of that
        allowed = min(0.5, 1e-4 * CASES["presets"][case["preset"]]["Rt"]) + 3e-7 * np.linalg.norm(case["origin"])
        allowed += 2.0 if kind == "lengths_penumbra" else 0.0
        for name, key in fields.items():
            assert abs(np.ravel(got[name])[0] - case["expected"][key]) < allowed, (case["id"], name)


def test_ground_and_twin_on_random_rays(ctx, rng):
    scene = sa.Scene(suns=(sa.Sun((1, 0, 0.2)), sa.Sun((-0.3, 1, 0), irradiance=(0.3, 0.2, 0.1))))
    up = rng.normal(size=(300, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    origins = up * (scene.atmosphere.bottom_radius + 10 ** rng.uniform(0, 7, (300, 1)))
    directions = rng.normal(size=(300, 3)) - 0.7 * up
    got, truth = sa.probe(ctx, scene, origins, directions), reference.probe(scene, origins, directions)
    assert np.array_equal(got.end, truth.end) and {"ground", "miss", "top"} <= set(got.end)
    assert np.max(np.abs(got.transmittance - truth.transmittance)) < 2e-5
    for field in ("single", "ground_direct"):
        a, b = getattr(got, field), getattr(truth, field)
        error = np.abs(a - b) / np.maximum(b, 1e-4 * b.max())
        # sunlight at grazing incidence on the ground: its optical depth of 40 keeps the fit's 2e-5
        assert np.percentile(error, 99) < 5e-3, field
    swapped = reference.probe(sa.Scene(suns=scene.suns[:1]), origins, directions)
    assert not np.allclose(got.single, swapped.single, rtol=0.05)  # the second sun counts


def test_no_rays_and_one_ray(ctx):
    empty = sa.probe(ctx, sa.Scene(), np.zeros((0, 3)), np.zeros((0, 3)))
    assert len(empty) == 0 and empty.single.shape == (0, 3)
    one = sa.probe(ctx, sa.Scene(), (0, 0, 6.4e6), (0, 0, 1))
    assert one.single.shape == (1, 3) and one.umbra.shape == (1, 0)


def test_more_rays_than_a_row_of_the_textures(ctx):
    origins = np.tile([0.0, 0.0, 6.361e6], (2500, 1))
    directions = np.stack([np.linspace(0.1, 1, 2500), np.zeros(2500), np.ones(2500)], axis=1)
    many = sa.probe(ctx, sa.Scene(), origins, directions, quality="fast")
    few = sa.probe(ctx, sa.Scene(), origins[2000:2010], directions[2000:2010], quality="fast")
    assert np.array_equal(many.single[2000:2010], few.single)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (((np.nan, 0, 0), (0, 0, 1)), "origins"),
        (((0, 0, 7e6), (0, 0, 0)), "directions"),
        (((0, 0, 7e6), ((0, 0, 1), (0, 0, 1))), "directions"),
        (((0, 0, 7e6), (0, 0, 1), -1.0), "t_max"),
        (((0, 0, 7e6), (0, 0, 1), np.nan), "t_max"),
        (((0, 0, 7e6), (0, 0, 1), None, "superb"), "quality"),
    ],
)
def test_bad_rays(ctx, arguments, name):
    with pytest.raises(sa.ParameterError, match=name):
        sa.probe(ctx, sa.Scene(), *arguments)


@pytest.mark.parametrize(("quality", "median", "p95"), [("accurate", 0.005, 0.02), ("balanced", 0.01, 0.05)])
def test_multiple_scattering_of_the_reference_cases(ctx, quality, median, p95):
    errors = {"multiple": [], "ground_multiple": [], "ground_direct": []}
    keys = {"multiple": ("multi", "multi_se"), "ground_multiple": ("ground_multi", "ground_multi_se")}
    for case, got in probed(ctx, "multiple", quality):
        expected = case["expected"]
        for name, (key, deviation) in keys.items():
            if key in expected:
                want = np.array(expected[key])
                beyond = np.maximum(np.abs(got[name] - want) - 3 * np.array(expected[deviation]), 0.0)
                errors[name].append(beyond / np.maximum(want, 1e-4 * want.max()))
        if "ground_direct" in expected:
            want = np.array(expected["ground_direct"])
            errors["ground_direct"].append(np.abs(got["ground_direct"] - want) / max(want.max(), 1e-12))
    # beyond three standard errors of the Monte Carlo; what the table's resolution leaves
    assert np.median(errors["multiple"]) < median and np.percentile(errors["multiple"], 95) < p95
    assert np.percentile(errors["ground_multiple"], 95) < 0.01
    # the closed form with 4 terms is 5e-4 of an optical depth of a few
    assert np.percentile(errors["ground_direct"], 95) < 5e-3


def test_single_scattering_alone_has_no_more_orders(ctx):
    one = sa.probe(ctx, sa.Scene(), (0, 0, 6.361e6), (1, 0, 0.3), quality=sa.Quality(orders=1))
    every = sa.probe(ctx, sa.Scene(), (0, 0, 6.361e6), (1, 0, 0.3), quality=sa.Quality())
    assert np.all(one.multiple == 0) and np.all(every.multiple > 0) and np.array_equal(one.single, every.single)
