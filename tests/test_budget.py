"""Budgets: what they choose of a curve, what they refuse, and that the choice keeps them for rays nobody has seen."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import budget
from shadowatmo.budget import choose, read_curve
from shadowatmo.candidates import candidates, changed_fields, from_fields
from shadowatmo.passes.report_errors import ProbeErrors
from shadowatmo.quality import NAMED, Quality, as_quality
from shadowatmo.report_rays import KINDS, ray_set

POINTS = [
    {"name": name, "fields": fields, "error": {"single": single, "all": every}, "cost": cost}
    for name, fields, single, every, cost in (
        ("widths", {"method": "widths"}, 9.0, 9.5, 4.0),
        ("few", {"nodes": 4, "depth": "analytic"}, 0.05, 0.06, 10.0),
        ("some", {"nodes": 8, "depth": "analytic"}, 0.004, 0.02, 15.0),
        ("textures", {}, 0.004, 0.02, 20.0),
        ("many", {"nodes": 20, "depth": "analytic"}, 0.0003, 0.01, 30.0),
    )
]


def test_the_cheapest_that_keeps_the_error():
    assert choose(error=0.02, points=POINTS).fields == {"nodes": 8, "depth": "analytic"}
    assert choose(error=0.0199, points=POINTS).fields["nodes"] == 20
    assert choose(error=0.0199, given={"orders": 1}, points=POINTS).fields["nodes"] == 8  # less light, less error
    assert choose(error=10.0, points=POINTS).fields == {"method": "widths"}


def test_the_most_accurate_at_a_cost():
    assert choose(cost=29.0, points=POINTS).fields["nodes"] == 8  # textures are as good, and dearer
    assert choose(cost=10.0, points=POINTS).fields["nodes"] == 4


def test_the_reason_names_the_measured_figures():
    reason = choose(error=0.02, points=POINTS).reason
    assert all(words in reason for words in ("error=0.02", "some", "2 %", "15.0 copies", "cheapest of 3", "of 5"))


def test_fields_given_beside_a_budget_are_kept():
    assert choose(error=0.05, given={"depth": "textures"}, points=POINTS).fields == {}  # a default that was asked for
    assert choose(error=9.9, given={"nodes": 20}, points=POINTS).fields["nodes"] == 20


@pytest.mark.parametrize(
    "asked, words",
    [
        ({"error": 0.001}, "many"),  # what can be had
        ({"cost": 1.0}, "widths"),
        ({"error": 0.1, "cost": 5.0}, "one of the two"),
        ({}, "one of the two"),
        ({"error": 0.1, "given": {"nodes": 7}}, "nodes=7"),
        ({"error": 0.0}, "error"),
        ({"error": float("nan")}, "error"),
        ({"cost": -1.0}, "cost"),
        ({"cost": "8"}, "cost"),
    ],
)
def test_what_cannot_be_kept_is_refused(asked, words):
    with pytest.raises(sa.ParameterError, match=words):
        choose(**asked, points=POINTS)


# --- the curve that comes with the package


def test_the_names_are_points_of_the_curve():
    """Whoever changes a preset, or the candidates, runs `shadowatmo report --calibrate`."""
    fields = [point["fields"] for point in read_curve()]
    for name, quality in NAMED.items():
        assert changed_fields(quality) in fields, name
    assert {from_fields(f) for f in fields} == set(candidates().values())


def test_a_quality_by_budget_is_a_quality():
    quality = Quality(error=0.05)
    assert quality in {from_fields(point["fields"]) for point in read_curve()}
    plain = from_fields(changed_fields(quality))
    assert plain == quality and hash(plain) == hash(quality) and plain.budget == ""
    for other in (copy.deepcopy(quality), pickle.loads(pickle.dumps(quality))):
        assert other == quality and other.budget == quality.budget
    assert replace(quality, orders=1).budget == ""  # no longer what was chosen
    assert as_quality(quality) is quality


def test_a_looser_budget_is_never_dearer():
    cost = {str(point["fields"]): point["cost"] for point in read_curve()}
    costs = [cost[str(changed_fields(Quality(error=e)))] for e in (0.03, 0.05, 0.2, 2.0)]
    assert costs == sorted(costs, reverse=True) and costs[0] > costs[-1]


def test_explicit_fields_win_or_are_refused():
    assert Quality(error=0.2, depth="textures").depth == "textures"  # although it is the default
    assert Quality(error=0.5, method="march").method == "march"
    assert Quality(error=0.05, shadow="cone", orders=1).shadow == "cone"
    assert Quality(error=0.05, orders=1).orders == 1
    with pytest.raises(sa.ParameterError, match="nodes=7"):
        Quality(error=0.05, nodes=7)
    with pytest.raises(sa.ParameterError, match="nodes"):
        Quality(error=0.05, nodes=77)  # out of range in itself
    with pytest.raises(sa.ParameterError, match="method"):
        Quality(cost=20, method="magic")
    with pytest.raises(sa.ParameterError):
        Quality(error=1e-9)


def test_the_plan_says_what_was_chosen(ctx):
    quality = Quality(cost=30)
    with sa.Renderer(ctx, sa.Scene(), (8, 8), quality) as renderer:
        assert str(renderer.plan).startswith("quality by cost=30") and quality.budget in str(renderer.plan)
    with sa.Renderer(ctx, sa.Scene(), (8, 8), "fast") as renderer:
        assert "quality by" not in str(renderer.plan)


def test_another_curve(tmp_path, monkeypatch):
    path = tmp_path / "curve.json"
    monkeypatch.setenv(budget.VARIABLE, str(path))
    path.write_text("{}")
    with pytest.raises(sa.ParameterError, match="calibrate"):
        Quality(error=0.1)
    import json

    path.write_text(json.dumps({"format": budget.FORMAT, "version": budget.VERSION, "points": POINTS}))
    assert Quality(error=0.02).nodes == 8


# --- it holds


def kept(ctx, quality, orders, seed, rays=36):
    """Return the share of fresh rays of all kinds that keep a budget, as a function of the budget."""
    sets = [ray_set(kind, rays, seed, suns=4, lattice=False) for kind in KINDS]
    probes = ProbeErrors(ctx, sets)
    for rays_ in sets:
        probes.prepare(rays_, multiple=orders == "all")
        probes.judge(quality, rays_)
    errors = probes.counted(quality, orders)
    probes.release()
    return lambda limit: float(np.mean(errors[~np.isnan(errors)] <= limit))


@pytest.mark.slow
@pytest.mark.parametrize("limit", [0.1, 0.01])
def test_fresh_rays_keep_the_budget(ctx, limit):
    """Single scattering and transmittance: 95 of 100 fresh rays of all kinds, and no cheaper quality would do."""
    quality = Quality(error=limit, orders=1)
    assert kept(ctx, quality, 1, seed=7)(limit) >= 0.95
    points = read_curve()
    own = next(p for p in points if from_fields(p["fields"]) == replace(quality, orders="all"))
    assert all(p["error"]["single"] > limit for p in points if p["cost"] < own["cost"])


@pytest.mark.slow
def test_the_share_is_not_met_by_less(ctx):
    """The check above rejects a quality that is too coarse for the budget."""
    assert kept(ctx, Quality(nodes=3, gap_nodes=2, depth="analytic", orders=1), 1, seed=7)(0.01) < 0.95
