"""The report as text: tables for the terminal, and for a page."""

from shadowatmo.quality import NAMED
from shadowatmo.report import beaten, front, mean_cost, plotted_error, typical_error
from shadowatmo.report_errors import FLOOR

MEGABYTE = 2.0**20
LIGHT_NOTE = (
    "light: median over the kinds of rays of the percentile named, single + multiple; frames: the same over the "
    f"cameras; relative to a ray's brightest channel, rays below {FLOOR:g} of their scene's brightest left out"
)

TRUTH_NOTE = (
    "Single scattering and transmittance are judged by the float64 twin, eclipses by single scattering alone; the "
    "truth of multiple scattering is the solver's own, finer than any candidate's."
)


def percent(error) -> str:
    """Return an error in percent with two digits."""
    value = 100.0 * error
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}" if value < 1e5 else f"{value:.0e}"


def candidate_rows(report) -> tuple[list[str], list[list[str]]]:
    """Return heading and rows of the table of candidates, cheapest first, the best front marked."""
    shown = sorted(report["candidates"], key=mean_cost)
    best = {shown[i]["name"] for i in front([(mean_cost(c), plotted_error(c)) for c in shown])}
    cameras = list(shown[0]["cost"])
    heading = ["", "candidate", *cameras[:2], "mean", "tables", "MiB", "cold s"]
    heading += ["light median", "p95", "p99", "frames p99", "single p99", "T p99"]
    rows = []
    for c in shown:
        cold = f"{c['cold_start']['cpu']:.1f}" if "cold_start" in c else ""
        rows.append([
            "*" if c["name"] in best else "", c["name"], *(f"{c['cost'][camera]:.1f}" for camera in cameras[:2]),
            f"{mean_cost(c):.1f}", f"{c['table_cost']:.0f}", f"{c['memory'] / MEGABYTE:.0f}", cold,
            *(percent(typical_error(c, "errors", "all", s)) for s in ("median", "p95", "p99")),
            percent(typical_error(c, "frames")), percent(typical_error(c, "errors", "single", "p99")),
            percent(typical_error(c, "errors", "transmittance", "p99")),
        ])  # fmt: skip
    return heading, rows


def short_rows(report) -> tuple[list[str], list[list[str]]]:
    """Return what a page shows of `candidate_rows`: the best ones, the named ones, and the cheapest of each method."""
    heading, rows = candidate_rows(report)
    methods = {c["name"]: c["fields"].get("method", "segments") for c in report["candidates"]}
    kept, seen = [], set()
    for row in rows:
        name, first = row[1], methods[row[1]] not in seen
        seen.add(methods[name])
        if row[0] or first or name in NAMED:
            kept.append(row)
    return heading, kept


def report_page(report) -> str:
    """Return the report as a page: the short table of candidates, kinds of rays, features, and all candidates."""
    machine = report["machine"]
    size = "x".join(map(str, report["options"]["size"]))
    copied = f"a copy at {size} takes {1e3 * machine['copy_seconds']:.2f} ms"
    where = f"{machine['renderer']}, {machine['clock']}; {copied}."
    parts = ["# Speed against error", f"Written by `shadowatmo report --out`. {where}"]
    parts.append("![speed against error](report.png)")
    parts += [markdown(*short_rows(report)), f"Errors in percent. {LIGHT_NOTE}."]
    parts += ["## Kinds of rays", markdown(*set_rows(report)), TRUTH_NOTE]
    parts += ["## Features", markdown(*feature_rows(report))] if report["features"] else []
    parts += ["## Everything measured", markdown(*candidate_rows(report))]
    return "\n\n".join(parts)


def set_rows(report, name="balanced", others=("fast", "accurate")) -> tuple[list[str], list[list[str]]]:
    """Return heading and rows of errors by kind of rays: all statistics of one candidate, p99 of some others."""
    known = {c["name"]: c["errors"] for c in report["candidates"]}
    others = [other for other in others if other in known]
    rows = []
    for kind, errors in known[name].items():
        row = [kind, str(errors["all"]["rays"]), str(errors["all"]["left_out"])]
        row += [percent(errors["all"][statistic]) for statistic in ("median", "p95", "p99", "max")]
        row += [percent(errors["frame"]["p99"]), percent(errors["frame"]["max"])]
        rows.append(row + [percent(known[other][kind]["all"]["p99"]) for other in others])
    heading = ["rays", "judged", "left out", f"{name}: median", "p95", "p99", "max", "of maximum: p99", "max"]
    return heading + [f"{other}: p99" for other in others], rows


def feature_rows(report) -> tuple[list[str], list[list[str]]]:
    """Return heading and rows of what features cost alone."""
    rows = []
    for f in report["features"]:
        on = "" if f["name"] == "bare" else f["base"]
        extra = "" if f["name"] == "bare" else f"{f['extra']:+.1f}"
        rows.append([f["name"], f"{f['cost']:.1f}", extra, f"{f['noise']:.1f}", on, "unused: 0" if f["unused"] else ""])
    return ["feature", "copies", "extra", "noise", "on top of", ""], rows


def aligned(heading, rows) -> str:
    """Return a table for the terminal: text to the left, numbers to the right."""
    table = [heading, *rows]
    widths = [max(len(row[i]) for row in table) for i in range(len(heading))]
    left = [not any(row[i][:1].isdigit() or row[i][:1] in "+-" for row in rows) for i in range(len(heading))]
    lines = []
    for row in table:
        cells = (c.ljust(w) if to_left else c.rjust(w) for c, w, to_left in zip(row, widths, left, strict=True))
        lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def markdown(heading, rows) -> str:
    """Return a table for a page."""
    lines = ["| " + " | ".join(row) + " |" for row in [heading, *rows]]
    lines.insert(1, "|" + " --- |" * len(heading))
    return "\n".join(lines)


def report_text(report) -> str:
    """Return the whole report for the terminal."""
    machine, options = report["machine"], report["options"]
    size = "x".join(map(str, options["size"]))
    parts = [
        f"{machine['renderer']}; {machine['clock']}; one copy at {size} takes {1e3 * machine['copy_seconds']:.2f} ms",
        aligned(*candidate_rows(report)),
        f"* = best at its cost. Errors in percent. {LIGHT_NOTE}.",
        *([aligned(*set_rows(report))] if any(c["name"] == "balanced" for c in report["candidates"]) else []),
        TRUTH_NOTE,
    ]
    if report["features"]:
        parts.append(aligned(*feature_rows(report)))
    others = beaten(report)
    if others:
        parts.append("Other methods ahead of segments (single scattering, mean cost):\n  " + "\n  ".join(others))
    return "\n\n".join(parts)
