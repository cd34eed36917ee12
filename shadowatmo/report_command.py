"""`shadowatmo report`: its options, what it prints and writes, and its exit status."""

import argparse
from dataclasses import replace
from pathlib import Path

from shadowatmo.errors import ParameterError
from shadowatmo.options import ProgressBar, size
from shadowatmo.quality import NAMED
from shadowatmo.report import Options, compare, read_report, write_json

EPILOG = """\
Measures every method and quality on this machine. Frames: cost as a ratio to a full-screen copy pass timed beside it
(CPU time where the renderer is software, timer queries on hardware). Rays: errors against a float64 twin, the same
fixed and seeded rays for all. --fast leaves out most candidates, the other planets and most cameras.

  shadowatmo report --out report --json report.json       everything, with pictures
  shadowatmo report --fast --baseline report.json         did anything get worse?
  shadowatmo report --reference cases.json                judge a file of reference rays instead
  shadowatmo report --calibrate                           and renew the curve that Quality(error=...) chooses from

Exit status: 1 if something got worse than the baseline (a cost by 20 % more than the middle one of all, all costs by
25 %, errors or memory by 10 %), if a reference file's bar is missed, or if something asked for was not done; otherwise
0.
"""
MAP_QUALITY, MAP_CAMERAS, MAP_STRIDE = "balanced", 2, 12


def add_report(commands) -> argparse.ArgumentParser:
    """Add the command to the sub-commands of the command line and return its parser."""
    raw = argparse.RawDescriptionHelpFormatter
    what = "speed against error of every method"
    parser = commands.add_parser("report", help=what, description=what, epilog=EPILOG, formatter_class=raw)
    parser.add_argument("--fast", action="store_true", help="about a minute and a half on two cores without a GPU")
    parser.add_argument("--size", type=size, metavar="WxH", help="pixels of the frames (default: 1280x720)")
    parser.add_argument("--seed", type=int, help="of the random half of the rays")
    parser.add_argument("--rays", type=int, help="of each kind")
    parser.add_argument("--frames", type=int, help="timed with each camera in each round")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write everything that was measured")
    parser.add_argument("--baseline", type=Path, metavar="FILE", help="say what got worse since an earlier --json")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write pictures and tables (needs matplotlib)")
    parser.add_argument("--reference", type=Path, metavar="FILE", help="judge a file of reference rays by the probe")
    parser.add_argument("--quality", choices=tuple(NAMED), default="accurate",
                        help="of --reference (default: %(default)s)")  # fmt: skip
    parser.add_argument("--calibrate", nargs="?", type=Path, const=True, metavar="FILE",
                        help="also write the curve that budgets choose from (default: the package's own)")  # fmt: skip
    parser.set_defaults(action=report)
    return parser


def options_of(arguments) -> Options:
    """Return what the command line asks to be measured.

    Raises
    ------
    ParameterError
        If a number is out of range, or a curve is asked of what --fast leaves out.
    """
    if arguments.fast and arguments.calibrate is not None:
        raise ParameterError("--calibrate", arguments.calibrate, "it without --fast, which measures too few qualities")
    options = Options.quick() if arguments.fast else Options()
    names = ("size", "seed", "rays", "frames")
    given = {name: getattr(arguments, name) for name in names if getattr(arguments, name) is not None}
    return replace(options, **given)


def report(arguments) -> int:
    """Run the command and return its exit status."""
    import shadowatmo

    options = options_of(arguments)
    for name in ("json", "out", "calibrate"):
        _check_folder(name, getattr(arguments, name))
    baseline = read_report(arguments.baseline) if arguments.baseline is not None else None
    pictures = _Pictures(arguments.out) if arguments.out is not None else None
    ctx = shadowatmo.open_context()
    try:
        if arguments.reference is not None:
            return _judge_reference(ctx, arguments.reference, arguments.quality)
        found = _measure(ctx, options)
        if arguments.json is not None:
            write_json(arguments.json, found)
        if arguments.calibrate is not None:
            _calibrate(found, arguments.calibrate)
        if pictures is not None:
            pictures.write(ctx, found)
    finally:
        ctx.release()
    worse = [] if baseline is None else compare(found, baseline)
    if worse:
        print("\nworse than the baseline:\n  " + "\n  ".join(worse))
    elif baseline is not None:
        print("\nnothing is worse than the baseline")
    return 1 if worse else 0


def _check_folder(name, path) -> None:
    if isinstance(path, Path) and not path.parent.is_dir():
        raise ParameterError(f"--{name}", str(path), f"a place in an existing folder; make {path.parent} first")


def _measure(ctx, options) -> dict:
    from shadowatmo.passes.report import Report
    from shadowatmo.report_text import report_text

    with ProgressBar(wait=ctx.finish) as bar:
        found = Report(ctx, options, bar).run()
    print(report_text(found))
    return found


def _judge_reference(ctx, path, quality) -> int:
    """Print errors by kind and metric of a reference file; return 1 where a bar is missed."""
    import numpy as np

    import shadowatmo
    from shadowatmo.report_cases import judge_cases, missed_bars, read_cases

    errors = judge_cases(read_cases(path), lambda *rays: shadowatmo.probe(ctx, *rays, quality=quality))
    for kind, found in errors.items():
        for metric, values in sorted(found.items()):
            median, p95, p99, worst = np.percentile(values, [50, 95, 99, 100])
            numbers = f"median {median:.2g}  p95 {p95:.2g}  p99 {p99:.2g}  max {worst:.2g}"
            print(f"{kind:22s} {metric:5s} {len(values):5d}  {numbers}")
    missed = missed_bars(errors)
    print("all bars are met" if not missed else "missed:\n  " + "\n  ".join(missed))
    return 1 if missed else 0


def _calibrate(found, path) -> None:
    """Write the curve of a report."""
    from shadowatmo.budget import calibrated, curve_path

    path = curve_path() if path is True else path
    write_json(path, calibrated(found))
    print(f"\n{path}: the curve of {len(found['candidates'])} qualities")


class _Pictures:
    """The folder of pictures; made, and matplotlib looked for, before anything is measured."""

    def __init__(self, folder):
        from shadowatmo.report_picture import figure_class

        figure_class()
        folder.mkdir(exist_ok=True)
        self.folder = folder

    def write(self, ctx, found) -> None:
        """Write report.png, report.md and the maps of the worst cameras."""
        from shadowatmo import report_text
        from shadowatmo.passes.report_errors import error_map, report_scene
        from shadowatmo.quality import as_quality
        from shadowatmo.report_picture import map_figure, save, speed_error_figure
        from shadowatmo.report_rays import CAMERAS, SUN

        save(speed_error_figure(found), self.folder / "report.png")
        (self.folder / "report.md").write_text(report_text.report_page(found) + "\n", "utf-8")
        frames = next(c["frames"] for c in found["candidates"] if c["name"] == MAP_QUALITY)
        worst = sorted(frames, key=lambda name: -frames[name]["all"]["p99"])[:MAP_CAMERAS]
        size = tuple(found["options"]["size"])
        for number, name in enumerate(worst, 1):
            errors = error_map(ctx, report_scene(SUN), CAMERAS[name], as_quality(MAP_QUALITY), size, MAP_STRIDE)
            title = f"{MAP_QUALITY}, {name}: error of each pixel"
            save(map_figure(errors, title, size[0] / size[1]), self.folder / f"worst_{number}.png")
        print(f"\n{self.folder}: report.png, report.md and {len(worst)} maps of errors")
