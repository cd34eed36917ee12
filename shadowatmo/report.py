"""The report of speed against error: what it asks for, what it writes, and how two reports compare."""

import json
from dataclasses import asdict, dataclass

from shadowatmo.errors import ParameterError
from shadowatmo.report_rays import SEED
from shadowatmo.validation import integer

FORMAT, VERSION = "shadowatmo report", 1
WORSE_COST, WORSE_ALL, WORSE_ERROR = 1.20, 1.25, 1.10  # ratios to the baseline
LEAST_COST, LEAST_ERROR = 0.5, 1e-5  # and differences below these do not count: copies, relative


@dataclass(frozen=True)
class Options:
    """How much a report measures.

    Parameters
    ----------
    fast : bool
        Fewer candidates, cameras and rays.
    seed : int
        Of the random half of the rays.
    rays : int
        Of each set.
    frames : int
        Timed of each candidate with each camera in each round.
    rounds : int
        Passes over all candidates.
    pixels : int
        Judged of each frame.
    size : (int, int)
        Of the frames [pixels].
    """

    fast: bool = False
    seed: int = SEED
    rays: int = 300
    frames: int = 4
    rounds: int = 2
    pixels: int = 250
    size: tuple[int, int] = (1280, 720)

    def __post_init__(self):
        for name, low, high in (
            ("seed", 0, 2**63), ("rays", 12, 10**6), ("frames", 1, 1000), ("rounds", 1, 1000), ("pixels", 2, 10**6),
        ):  # fmt: skip
            integer(name, getattr(self, name), low=low, high=high)

    @classmethod
    def quick(cls, **changes) -> "Options":
        """Return what `--fast` measures."""
        return cls(**{"fast": True, "rays": 90, "frames": 6, "rounds": 2, "pixels": 90, **changes})

    def plain(self) -> dict:
        """Return the fields as JSON holds them."""
        return {**asdict(self), "size": list(self.size)}


# --- one number for each candidate


def worst_cost(candidate) -> float:
    """Return the cost of a candidate in copies with the camera that costs the most."""
    return max(candidate["cost"].values())


def mean_cost(candidate) -> float:
    """Return the mean cost of a candidate over the cameras in copies."""
    return sum(candidate["cost"].values()) / len(candidate["cost"])


def typical_error(candidate, kind="errors", name="all", statistic="p99") -> float:
    """Return a statistic of a candidate in the middle kind of rays ("errors") or camera ("frames"); nan without any."""
    values = sorted(errors[name][statistic] for errors in candidate[kind].values())
    return values[len(values) // 2] if values else float("nan")


def plotted_error(candidate, statistic="p99") -> float:
    """Return what a picture plots: the typical error of rays or of frames, whichever is larger."""
    return max(typical_error(candidate, kind, statistic=statistic) for kind in ("errors", "frames"))


def front(points) -> list[int]:
    """Return the indices of the best of (cost, error) points, cheapest first: no other is both cheaper and better."""
    best, found = float("inf"), []
    for index in sorted(range(len(points)), key=lambda i: points[i]):
        if points[index][1] < best:
            best = points[index][1]
            found.append(index)
    return found


# --- where another method is better than the nodes in the lit pieces


def beaten(report, method="segments", orders="single", statistic="p99") -> list[str]:
    """Return one line for every candidate of another method that is cheaper than a method's cheapest, or better.

    Published tables hold some orders only, or one; single scattering is what all are compared by.
    """
    lines = []
    own = [c for c in report["candidates"] if _method(c) == method]
    for other in (c for c in report["candidates"] if _method(c) != method):
        cost = mean_cost(other)
        affordable = [c for c in own if mean_cost(c) <= cost]
        if not affordable:
            lines.append(f"{other['name']}: {cost:.1f} copies, less than any {method}")
            continue
        for name, errors in other["errors"].items():
            error, best = errors[orders][statistic], min(c["errors"][name][orders][statistic] for c in affordable)
            if error < best:
                lines.append(f"{other['name']}: {statistic} {error:.2g} in {name}, {method} at no more cost {best:.2g}")
    return lines


def _method(candidate):
    return candidate["fields"].get("method", "segments")


# --- reports as files, and two of them


def read_report(path) -> dict:
    """Return a report from a JSON file.

    Raises
    ------
    ParameterError
        If it is not one, or of another version.
    """
    try:
        report = json.loads(path.read_text("utf-8"))
    except (ValueError, UnicodeDecodeError):
        raise ParameterError("--baseline", str(path), "a JSON file that `report --json` wrote") from None
    if not isinstance(report, dict) or (report.get("format"), report.get("version")) != (FORMAT, VERSION):
        raise ParameterError("--baseline", str(path), f"a report of version {VERSION}, as `report --json` writes it")
    return report


def write_json(path, report) -> None:
    """Write a report, its numbers with six digits."""
    path.write_text(json.dumps(_rounded(report), indent=1) + "\n", "utf-8")


def _rounded(value):
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    return [_rounded(item) for item in value] if isinstance(value, (list, tuple)) else value


def compare(report, baseline) -> list[str]:
    """Return one line for everything that got worse since an earlier report; what only one of them has is no matter.

    Costs are compared where both were taken by the same renderer and clock, errors where the rays are the same. A busy
    machine slows the copy and the frames by different factors, so that the middle factor of all costs is judged apart,
    and each cost beyond it.
    """
    worse = []
    before = {candidate["name"]: candidate for candidate in baseline["candidates"]}
    same_machine = all(report["machine"][key] == baseline["machine"][key] for key in ("renderer", "clock"))
    drift = _drift(report, before) if same_machine else 1.0
    _judge(worse, "all costs together", drift, 1.0, WORSE_ALL, 0.0)
    same_rays = all(report["options"][key] == baseline["options"][key] for key in ("seed", "rays", "pixels", "size"))
    for candidate in report["candidates"]:
        old = before.get(candidate["name"])
        if old is None:
            continue
        if same_machine:
            for camera, cost in candidate["cost"].items():
                what = f"{candidate['name']}: cost, {camera}"
                _judge(worse, what, cost, old["cost"].get(camera), WORSE_COST * max(drift, 1.0), LEAST_COST)
            _judge(worse, f"{candidate['name']}: memory", candidate["memory"], old["memory"], WORSE_ERROR, 0.0)
        for kind in ("errors", "frames") if same_rays else ():
            for place, errors in candidate[kind].items():
                for name in errors.keys() & old[kind].get(place, {}).keys():
                    for statistic in ("median", "p95", "p99"):
                        what = f"{candidate['name']}: {place}, {name}, {statistic}"
                        now, then = errors[name][statistic], old[kind][place][name][statistic]
                        _judge(worse, what, now, then, WORSE_ERROR, LEAST_ERROR)
    return worse


def _drift(report, before) -> float:
    """Return the median ratio of the costs of a report to those before; 1 where nothing is in both."""
    ratios = sorted(
        cost / before[candidate["name"]]["cost"][camera]
        for candidate in report["candidates"] if candidate["name"] in before
        for camera, cost in candidate["cost"].items() if camera in before[candidate["name"]]["cost"]
    )  # fmt: skip
    return ratios[len(ratios) // 2] if ratios else 1.0


def _judge(worse, what, now, then, factor, least):
    if then is not None and now > factor * then and now - then > least:
        worse.append(f"{what}: {then:.4g} before, {now:.4g} now")
