"""The report: its rays, its statistics, what it measures of a few candidates, and how two reports compare."""

import copy
import json
import math

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import report_cases, report_text
from shadowatmo.candidates import candidates, changed_fields, describe, from_fields
from shadowatmo.passes import base, planet, report_errors, report_features
from shadowatmo.passes import report as report_pass
from shadowatmo.passes.clock import Clock, ratio, ratio_noise
from shadowatmo.passes.gl.source import compose_source
from shadowatmo.passes.report import Report, texture_bytes
from shadowatmo.quality import METHODS, NAMED
from shadowatmo.report import Options, beaten, compare, front, mean_cost, read_report, worst_cost, write_json
from shadowatmo.report_errors import FLOOR, budget_errors, ray_errors, statistics
from shadowatmo.report_rays import CAMERAS, KINDS, ray_set
from tests.test_cli import ROOT, shadowatmo_command

CASES = ROOT / "tests" / "data" / "cases_public.json"


# --- rays


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.name)
def test_rays_are_what_their_kind_says(kind):
    rays = ray_set(kind, 120)
    again, other = ray_set(kind, 120), ray_set(kind, 120, seed=1)
    assert len(rays) == 120
    air, scale = kind.atmosphere, kind.atmosphere.thickness / sa.EARTH.thickness
    for shot, same, new in zip(rays.shots, again.shots, other.shots, strict=True):
        assert np.array_equal(shot.directions, same.directions)
        half = len(shot.directions) // 2
        fixed = shot.directions[:half] == new.directions[:half]
        drawn = shot.directions[half:] == new.directions[half:]
        assert fixed.all() and not drawn.all(axis=1).any()
        altitude = np.linalg.norm(shot.origins, axis=1) - air.bottom_radius
        low, high = scale * kind.altitudes[0], scale * kind.altitudes[1]
        assert np.all((altitude > 0.99 * low - 1e-3) & (altitude < 1.01 * high))
        zenith = math.degrees(math.acos(shot.scene.suns[0].direction[2]))
        assert kind.zeniths[0] <= zenith <= kind.zeniths[1]
        assert bool(shot.scene.occluders) == kind.moon
        if kind.cut is not None:
            assert np.all((shot.t_max > 0.99 * scale * kind.cut[0]) & (shot.t_max < 1.01 * scale * kind.cut[1]))


def test_kinds_are_not_alike():
    """Limb rays miss the ground, moons shade the eclipse, and eyes in space see the planet."""
    by_name = {kind.name: ray_set(kind, 120) for kind in KINDS}
    ends = [sa.reference.lengths(s.scene, s.origins, s.directions).end for s in by_name["limb"].shots]
    assert set(np.concatenate(ends)) == {"top"}
    dark = [sa.sun_visibility(s.scene, s.origins) for s in by_name["eclipse"].shots]
    assert np.concatenate(dark).min() < 0.5
    seen = [sa.reference.lengths(s.scene, s.origins, s.directions).end for s in by_name["ground to space"].shots]
    assert {"top", "ground"} <= set(np.concatenate(seen))


# --- statistics


def test_errors_are_relative_to_the_brightest_channel():
    truth = np.array([[1.0, 0.5, 0.1], [0.1, 0.2, 0.05], [0.5 * FLOOR] * 3])
    relative, frame = ray_errors(truth + [[0.0, 0.01, 0.0], [0.0, 0.0, 0.02], [1.0, 0.0, 0.0]], truth)
    assert np.allclose(relative[:2], [0.01, 0.1]) and np.isnan(relative[2])  # too dark to be judged
    assert np.allclose(frame, [0.01, 0.02, 1.0])  # but counted against the maximum
    found = statistics(relative)
    assert found["rays"] == 2 and found["left_out"] == 1 and found["max"] == pytest.approx(0.1)
    assert statistics([np.nan])["p99"] == 0.0
    assert np.array_equal(budget_errors(np.array([np.nan, 0.2]), np.array([0.1, 0.1])), [0.1, 0.2])


def test_ratios_are_of_medians():
    pairs = np.array([(10.0, 1.0), (11.0, 1.1), (9.0, 0.9), (1e3, 1.0), (10.0, 1.0)])
    assert ratio(pairs) == pytest.approx(10.0)
    assert ratio_noise(pairs) < 0.5  # one disturbed frame does not count
    assert ratio_noise(np.array([(8.0, 1.0), (12.0, 1.0), (9.0, 1.0), (11.0, 1.0)])) > 0.5


@pytest.mark.parametrize("uses_cpu", [True, False])
def test_clocks_run_on_both_kinds_of_renderer(ctx, uses_cpu):
    clock = Clock(ctx, (256, 256), uses_cpu)
    small = Clock(ctx, (16, 16), uses_cpu)
    assert np.median([clock.copy() for _ in range(9)]) > np.median([small.copy() for _ in range(9)]) > 0
    assert clock.pairs(ctx.clear, 3).shape == (3, 2) and ("CPU" in clock.name) == uses_cpu
    for each in (clock, small):
        each.release()


def test_the_front_holds_what_nothing_beats():
    points = [(3.0, 0.1), (1.0, 1.0), (2.0, 2.0), (4.0, 0.1), (5.0, 0.01)]
    assert front(points) == [1, 0, 4]


# --- candidates


def test_candidates_cover_every_method_quality_and_depth():
    for fast in (False, True):
        wanted = candidates(fast)
        assert list(wanted)[:3] == list(NAMED)
        assert {q.method for q in wanted.values()} == set(METHODS)
        assert {q.depth for q in wanted.values()} == {"analytic", "textures"}
        assert {q.depth_bits for q in wanted.values()} == {24, 32}
        assert len(set(wanted.values())) == len(wanted)
        assert len({describe(q) for q in wanted.values()}) == len(wanted)
    assert len(candidates()) > 2 * len(candidates(True))


def test_candidates_survive_json():
    for quality in candidates().values():
        assert from_fields(json.loads(json.dumps(changed_fields(quality)))) == quality


# --- a small run

SMALL = Options.quick(rays=24, frames=2, rounds=1, pixels=40, size=(64, 36))
WANTED = {
    "balanced": NAMED["balanced"],
    "march": sa.Quality(method="march", steps=8),
    "widths": sa.Quality(method="widths"),
}


@pytest.fixture(scope="module")
def small(ctx):
    patch = pytest.MonkeyPatch()
    patch.setattr(report_pass, "KINDS", [k for k in KINDS if k.name in ("ground, day", "limb", "eclipse")])
    coarse = sa.Quality(nodes=4, gap_nodes=3, terms=6, multiple="accurate")  # the truth takes long
    patch.setattr(report_errors, "TRUTH_OF_MULTIPLE", coarse)
    bare = report_features.features()
    patch.setattr(report_pass, "features", lambda: [f for f in bare if f.name in ("bare", "second sun")])
    steps = []
    try:
        found = Report(ctx, SMALL, lambda *step: steps.append(step), WANTED).run(cold=False)
    finally:
        patch.undo()
    assert [done for _, done, _ in steps] == list(range(1, steps[-1][2] + 1))  # the bar ends at its end
    return found


@pytest.mark.slow
def test_a_report_says_what_it_measured(small):
    assert [c["name"] for c in small["candidates"]] == list(WANTED)
    assert small["machine"]["copy_seconds"] > 0 and small["options"]["seed"] == SMALL.seed
    balanced, march, widths = small["candidates"]
    for c in small["candidates"]:
        assert set(c["errors"]) == {"ground, day", "limb", "eclipse"} and len(c["frames"]) == len(c["cost"]) == 2
        assert worst_cost(c) >= mean_cost(c) > 0 and c["memory"] > 64 * 36 * 16
    assert balanced["table_cost"] > 0 and widths["table_cost"] == 0
    assert balanced["memory"] > widths["memory"]  # its table
    for kind in balanced["errors"]:
        p95 = [c["errors"][kind]["single"]["p95"] for c in (balanced, march, widths)]
        assert p95[0] < 0.02 < p95[1] < p95[2]
    assert balanced["errors"]["eclipse"]["all"] == balanced["errors"]["eclipse"]["single"]  # all that is judged there
    # a frame's own error is more than that of its rays, and still small
    assert all(f["all"]["median"] < 0.02 for f in balanced["frames"].values())
    assert balanced["budget"]["all"]["rays"] == 3 * 24


@pytest.mark.slow
def test_a_report_as_text(small):
    text = report_text.report_text(small)
    assert all(name in text for name in (*WANTED, "limb", "second sun", "left out", small["machine"]["renderer"]))
    page = report_text.report_page(small)
    assert "report.png" in page and all(f"| {name} |" in page for name in WANTED)
    heading, rows = report_text.candidate_rows(small)
    assert report_text.markdown(heading, rows).count("\n") == len(rows) + 1
    lines = report_text.aligned(heading, rows).splitlines()
    assert len(lines) == len(rows) + 1


@pytest.mark.slow
def test_a_report_draws_its_picture(small, tmp_path):
    from PIL import Image

    from shadowatmo.report_picture import map_figure, save, speed_error_figure

    save(speed_error_figure(small), tmp_path / "a.png")
    save(map_figure(np.array([[1e-3, 0.1], [np.nan, 2.0]]), "a map", 16 / 9), tmp_path / "b.png")
    for name in ("a.png", "b.png"):
        with Image.open(tmp_path / name) as picture:
            assert len(picture.convert("RGB").getcolors(2**24)) > 20  # not a blank page


@pytest.mark.slow
def test_a_baseline_tells_what_got_worse(small, tmp_path):
    path = tmp_path / "report.json"
    write_json(path, small)
    assert compare(small, read_report(path)) == []  # rounding to six digits is not worse
    worse = copy.deepcopy(small)
    camera = next(iter(worse["candidates"][0]["cost"]))
    worse["candidates"][0]["cost"][camera] *= 1.3
    worse["candidates"][1]["errors"]["limb"]["single"]["p99"] *= 1.3
    worse["candidates"][2]["memory"] *= 2
    found = compare(worse, read_report(path))
    assert len(found) == 3
    assert any(camera in line for line in found) and any("limb" in line for line in found)
    slower = copy.deepcopy(small)
    for candidate in slower["candidates"]:
        candidate["cost"] = {name: 1.4 * cost for name, cost in candidate["cost"].items()}
    assert [line.split(":")[0] for line in compare(slower, small)] == ["all costs together"]
    assert len(compare({**worse, "machine": {**worse["machine"], "renderer": "another"}}, small)) == 1  # errors alone
    assert len(compare({**worse, "options": {**worse["options"], "seed": 5}}, small)) == 2  # other rays


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "shadowatmo report", "version": 0}'])
def test_a_file_that_is_no_report_is_refused(text, tmp_path):
    path = tmp_path / "report.json"
    path.write_text(text)
    with pytest.raises(sa.ParameterError, match="baseline"):
        read_report(path)


def test_methods_that_beat_segments_are_named():
    def point(method, cost, error):
        errors = {"limb": {"single": {"p99": error}}}
        return {"name": method, "fields": {"method": method}, "cost": {"a": cost}, "errors": errors}

    points = [point("segments", 10.0, 0.01), point("march", 20.0, 0.02), point("table3d", 12.0, 0.005)]
    lines = beaten({"candidates": [*points, point("widths", 5.0, 1.0)]})
    assert [line.split(":")[0] for line in lines] == ["table3d", "widths"]


# --- what a scene does not need

WORDS = {  # feature: what only its shaders mention
    "ozone": "u_ozone_k",
    "multiple scattering": "u_multiple_view",
    "eclipse": "visibility_along",
    "finite disc at the terminator": "u_sun_angle",
    "sun's disc in view": "u_sun_disc",
    "lit ground": "u_planet_color",
    "terrain cut by a host's depth": "u_host_depth",
    "depth textures": "u_shadow_back",
}
STEPS = {
    "multiple scattering": "multiple",
    "eclipse": "eclipse",
    "lit ground": "planet",
    "depth textures": "shadow_back_depth",
}


def shader_texts(ctx, monkeypatch, feature):
    """Return the text of all shaders that draw a feature, and its plan."""
    made = []

    def recorded(build):
        def record(context, fragment, vertex="fullscreen.vert", geometry=None, defines=None, optional=()):
            made.append(compose_source(fragment, defines, (*defines, *optional) if defines else ()).text)
            return build(context, fragment, vertex, geometry, defines, optional)

        return record

    with monkeypatch.context() as patch:
        for module in (base, planet):
            patch.setattr(module, "build_program", recorded(module.build_program))
        clock = Clock(ctx, (16, 9))
        bench = report_features.FeatureBench(ctx, clock, (16, 9), False)
        bench.time(feature, 1)
        clock.release()
    with sa.Renderer(ctx, feature.scene, (16, 9), feature.quality) as renderer:
        return "\n".join(made), renderer.plan


def test_scenes_pay_only_for_what_they_need(ctx, monkeypatch):
    texts, plans = {}, {}
    for feature in report_features.features():
        if feature.name in ("bare", "ozone of no density", "a moon that shades no air", "aerosols", *WORDS):
            texts[feature.name], plans[feature.name] = shader_texts(ctx, monkeypatch, feature)
    for name, word in WORDS.items():
        if name != "lit ground":
            assert word in texts[name]
        assert word not in texts["bare"]
    for unused in ("ozone of no density", "a moon that shades no air"):
        assert texts[unused] == texts["bare"]
    for name, step in STEPS.items():
        assert step in plans[name] and step not in plans["bare"]
    # without aerosols their density is the constant 0, which the driver drops with all that it multiplies
    assert "u_falloff.x), 0.0)" in texts["bare"] and "u_falloff.x), 0.0)" not in texts["aerosols"]


def test_textures_are_weighed(ctx):
    before = texture_bytes()
    textures = [ctx.texture((10, 20), 4, dtype="f2"), ctx.depth_texture((5, 5))]
    assert texture_bytes() - before == 10 * 20 * 8 + 25 * 4
    for texture in textures:
        texture.release()
    assert texture_bytes() == before


def test_cameras_are_those_of_the_issue():
    altitudes = [math.hypot(*c.position) - sa.EARTH.bottom_radius for c in CAMERAS.values()]
    assert np.isclose(altitudes[0], 2.0, atol=1e-3) and np.isclose(altitudes[1], 4e5)


# --- reference files


def test_reference_cases_are_judged(ctx):
    groups = report_cases.read_cases(CASES)
    kept = [g for g in groups if g.cases[0]["kind"] in ("transmittance", "single", "lengths_penumbra")][:24]
    quality = sa.Quality(nodes=20, gap_nodes=10, terms=6, orders=1)
    errors = report_cases.judge_cases(kept, lambda *rays: sa.probe(ctx, *rays, quality=quality))
    assert len(errors["single"]["rel"]) > 9 and len(errors["transmittance"]["abs"]) > 9
    assert not report_cases.missed_bars({k: v for k, v in errors.items() if k == "transmittance"})
    spoiled = {kind: {name: values + 0.2 for name, values in found.items()} for kind, found in errors.items()}
    assert len(report_cases.missed_bars(spoiled)) >= 3
    spoiled = {"single": {**errors["single"], "rel": np.full(5, report_cases.NOT_FINITE)}}
    assert report_cases.missed_bars(spoiled)


def test_the_twin_meets_every_bar_it_has_values_for():
    kinds = ("transmittance", "lengths_planet_shadow", "lengths_umbra", "eclipse_single", "single_disc")
    groups = [g for g in report_cases.read_cases(CASES) if g.cases[0]["kind"] in kinds]
    errors = report_cases.judge_cases(groups, sa.reference.probe)
    assert set(errors) == set(kinds) and not report_cases.missed_bars(errors)


# --- the command


@pytest.mark.parametrize(
    "options, words",
    [
        (("--baseline", "nowhere.json"), "nowhere.json"),
        (("--reference", "pyproject.toml"), "--reference"),
        (("--json", "no/such/folder/x.json"), "--json"),
        (("--rays", "1"), "rays"),
        (("--calibrate",), "--fast"),
        (("--size", "0x9"), "size"),
    ],
)
def test_mistakes_are_one_line(options, words):
    done = shadowatmo_command("report", "--fast", *options)
    assert done.returncode != 0 and words in done.stderr
    assert len([line for line in done.stderr.splitlines() if line.startswith("shadowatmo")]) == 1


def test_help_tells_the_exit_status():
    done = shadowatmo_command("report", "--help")
    assert done.returncode == 0 and "Exit status" in done.stdout and "--baseline" in done.stdout


def test_pictures_without_matplotlib_name_the_extra(tmp_path):
    missing = "raise ModuleNotFoundError(\"No module named 'matplotlib'\", name='matplotlib')"
    (tmp_path / "matplotlib.py").write_text(missing)
    path = f"{tmp_path}:{ROOT}"
    done = shadowatmo_command("report", "--fast", "--out", tmp_path / "new", PYTHONPATH=path)
    assert done.returncode == 1 and "[report]" in done.stderr and not (tmp_path / "new").exists()
