"""Budgets: the cheapest quality for an error, or the best for a cost, by measured curves that come with the package.

The curve (data/curve.json) is what `shadowatmo report --calibrate` measured of every candidate: the error that 97 of
100 rays keep, over all kinds of rays of the report together, or 95 of 100 pixels of its frames, the larger of the two;
and the cost of a frame with the camera that costs the most, in full-screen copies. A budget for the error asks that 95
of 100 other rays keep it: two in a hundred are the margin.

The environment variable SHADOWATMO_CURVE names another file, for a machine whose own curve was measured.
"""

import functools
import json
import os
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from shadowatmo.errors import ParameterError
from shadowatmo.report import worst_cost
from shadowatmo.report_errors import BUDGET_PERCENTILE, FRAMES_PERCENTILE
from shadowatmo.validation import number

VARIABLE = "SHADOWATMO_CURVE"
FORMAT, VERSION = "shadowatmo curve", 1
FREE = ("orders", "shadow")  # fields that a budget does not choose: which light is asked for, and in which shape


@dataclass(frozen=True)
class Choice:
    """What a budget chose.

    Parameters
    ----------
    fields : dict
        Of the quality, those that differ from the defaults.
    reason : str
        Which, and why.
    """

    fields: dict
    reason: str


def curve_path() -> Path:
    """Return the file of the curve in use."""
    return Path(os.environ.get(VARIABLE) or str(files("shadowatmo.data") / "curve.json"))


def calibrated(report) -> dict:
    """Return the curve of a report: fields, error by orders and cost of every candidate."""
    points = []
    for c in report["candidates"]:
        error = {name: c["budget"][name][BUDGET_PERCENTILE] for name in ("single", "all")}
        error["all"] = max(error["all"], c["budget"]["frames"][FRAMES_PERCENTILE])
        points.append({"name": c["name"], "fields": c["fields"], "error": error, "cost": worst_cost(c),
                       "table_cost": c["table_cost"]})  # fmt: skip
    return {"format": FORMAT, "version": VERSION, "machine": report["machine"], "options": report["options"],
            "percentile": BUDGET_PERCENTILE, "points": points}  # fmt: skip


def read_curve(path=None) -> list[dict]:
    """Return the points of a curve file, the one in use without a path.

    Raises
    ------
    ParameterError
        If it is not one.
    """
    path = curve_path() if path is None else path
    return _read(str(path), path.stat().st_mtime_ns)


@functools.lru_cache(maxsize=4)
def _read(path, _changed):
    try:
        curve = json.loads(Path(path).read_text("utf-8"))
        if (curve["format"], curve["version"]) != (FORMAT, VERSION):
            raise ValueError("another format or version")
        return curve["points"]
    except (ValueError, KeyError, TypeError) as error:
        what = f"a curve of version {VERSION}, as `shadowatmo report --calibrate FILE` writes it ({error})"
        raise ParameterError(VARIABLE, path, what) from None


def choose(error=None, cost=None, given=None, points=None) -> Choice:
    """Return the cheapest point for an error, or the best for a cost.

    Parameters
    ----------
    error : float, optional
        Largest error, relative, > 0, that 95 of 100 rays are to keep.
    cost : float, optional
        Largest cost of a frame in full-screen copies, > 0. Exactly one of the two.
    given : dict, optional
        Fields of the quality that the caller fixed: only points that have them are looked at, apart from FREE ones.
    points : list of dict, optional
        Of the curve; the one in use without.

    Raises
    ------
    ParameterError
        If both or neither are given, if no point keeps the budget, or none has the fields.
    """
    if (error is None) == (cost is None):
        raise ParameterError("error", error, "to be given without cost: a budget is one of the two")
    name, value = ("error", error) if cost is None else ("cost", cost)
    limit = number(name, value, low=0.0, open_low=True)
    given = given or {}
    points = read_curve() if points is None else points
    orders = "single" if given.get("orders", "all") == 1 else "all"
    fitting = [p for p in points if _has(p, given)]
    if not fitting:
        fixed = ", ".join(f"{k}={v!r}" for k, v in given.items() if k not in FREE)
        raise ParameterError(name, limit, f"it without {fixed}: no measured quality has that; leave one of them out")

    def error_of(point):
        return point["error"][orders]

    def cost_of(point):
        return point["cost"]

    wanted, other = (error_of, cost_of) if cost is None else (cost_of, error_of)
    kept = [p for p in fitting if wanted(p) <= limit]
    if not kept:
        best = min(fitting, key=wanted)
        raise ParameterError(name, limit, f">= {wanted(best):.3g}, which {best['name']} reaches")
    point = min(kept, key=lambda p: (other(p), wanted(p)))
    aim = "cheapest" if cost is None else "most accurate"
    measured = f"measured within {100 * error_of(point):.2g} %, {point['cost']:.1f} copies"
    counts = f"of {len(kept)} that keep it, of {len(fitting)} measured"
    reason = f"{name}={limit:g}: {point['name']} ({measured}) is the {aim} {counts}"
    return Choice(dict(point["fields"]), reason)


def _has(point, given) -> bool:
    from shadowatmo.quality import Quality

    fields = {**vars(Quality()), **point["fields"]}
    return all(fields.get(name) == value for name, value in given.items() if name not in FREE)
