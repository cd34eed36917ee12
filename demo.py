"""The demo: a window where there is a display, a folder of pictures where there is none.

    python demo.py                        look around
    python demo.py --headless             render the main set into pictures/, and a sheet of all planets
    python demo.py --only limb_sunset     one picture of it
    python demo.py --set presets          the planets in full: from space, from within their air, at sunset
    python demo.py --set eclipses         shadows of moons from space, from the air and from within
    python demo.py --date 2017-08-21T17:21Z --observer 44.633,-121.129,690
                                          sun and moon of a time and place, in the window or as a picture
"""

import argparse
import math
import os
import sys
import time
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

START = time.perf_counter()
NEEDED = ("numpy", "PIL", "moderngl", "pyrr")
# of each set
SHEETS = {"main": "contact_sheet", "presets": "contact_sheet_presets", "eclipses": "contact_sheet_eclipses"}
THUMB = 480  # pixels, width of the pictures on a sheet
SMOOTHED_UP_TO = 4_000_000  # pixels: larger pictures have one sample in each
WINDOW_LINE = "pip install moderngl-window (or `make setup`), or draw without a window: python demo.py --headless"


def build_parser():
    """Return the parser of the command line."""
    from shadowatmo.gallery import SETS
    from shadowatmo.observing import DATE_HELP, OBSERVER_HELP
    from shadowatmo.options import Parser, names, numbers, size
    from shadowatmo.quality import METHODS, NAMED
    from shadowatmo.worlds import WORLDS

    raw = argparse.RawDescriptionHelpFormatter
    parser = Parser("demo.py", description=__doc__, formatter_class=raw)
    parser.add_argument("--headless", action="store_true", help="write pictures; the default without a display")
    parser.add_argument("--out", type=Path, default=Path("pictures"), metavar="DIR", help="folder (default: pictures)")
    parser.add_argument("--only", type=names, metavar="NAME[,NAME]", help="only these pictures; implies --headless")
    parser.add_argument("--set", choices=SETS, help="one set in full, or all; implies --headless (default: the "
                        "main set in full, and of the presets a sheet)")  # fmt: skip
    parser.add_argument("--list", action="store_true", help="say which pictures there are, and stop")
    parser.add_argument("--size", type=size, metavar="WxH", help="pixels (default: 1283x719, window 1280x720 or less)")
    parser.add_argument("--quality", choices=tuple(NAMED), default="balanced", help="effort (default: %(default)s)")
    parser.add_argument("--method", choices=METHODS, help="of the air's light (default: the quality's)")
    parser.add_argument("--no-cache", action="store_true", help="neither read nor keep precomputed tables on disk")
    parser.add_argument("--scene", choices=sorted(WORLDS), default="earth", help="the window's planet")
    parser.add_argument("--date", metavar="TIME", help=DATE_HELP)
    parser.add_argument("--observer", type=numbers, metavar="LAT,LON,HEIGHT", help=OBSERVER_HELP)
    parser.add_argument("--check", action="store_true", help="versions, OpenGL, data; exit status 0 or 1")
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    return parser


def list_pictures():
    """Write the names of the pictures of all sets and what each shows."""
    from shadowatmo.gallery import pictures

    for picture in pictures("all"):
        print(f"{picture.name:<20} {picture.caption}")


def chosen_quality(arguments):
    """Return the quality of the command line, with the method of the command line."""
    from shadowatmo.quality import as_quality

    quality = as_quality(arguments.quality)
    return replace(quality, method=arguments.method) if arguments.method else quality


def write_pictures(arguments):
    """Render a set, or a part of it, and a contact sheet; the exit status is 0 when all of it was written."""
    from shadowatmo import open_context
    from shadowatmo.gallery import pictures, select
    from shadowatmo.options import ProgressBar

    chosen = [observed_picture(arguments)] if arguments.date else select(arguments.only, arguments.set or "main")
    folder, size = arguments.out, arguments.size or (1283, 719)
    folder.mkdir(parents=True, exist_ok=True)
    ctx = open_context()
    print(f"{len(chosen)} pictures of {size[0]}x{size[1]} on {ctx.info['GL_RENDERER']}", flush=True)
    failed, tried = [], len(chosen)
    with ProgressBar(wait=ctx.finish) as bar:
        done = draw_pictures(ctx, chosen, size, bar, arguments, failed)
        write_sheets(done, folder, arguments)
        if done and not arguments.only and not arguments.set and not arguments.date:
            small = (THUMB, max(round(THUMB * size[1] / size[0]), 1))
            presets = pictures("presets")
            sheet = draw_pictures(ctx, presets, small, bar, arguments, failed, keep=False)
            tried += len(presets)
            write_sheets(sheet, folder, arguments)
    ctx.release()
    print(f"{len(done)} pictures in {folder.resolve()}, {time.perf_counter() - START:.1f} s since the start")
    if failed:
        print(f"demo.py: {len(failed)} of {tried} pictures failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def observed_picture(arguments):
    """Return the picture of an observer who looks to the sun at a date."""
    from shadowatmo.gallery import Picture
    from shadowatmo.observing import observed, observed_scene
    from shadowatmo.worlds import world

    planet, observer = world(arguments.scene), arguments.observer
    sky = observed(planet, arguments.date, observer)
    caption = f"Toward the sun at {arguments.date} from {observer}."
    return Picture("observed", caption, observed_scene(planet, sky), sky.camera())


def draw_pictures(ctx, chosen, size, bar, arguments, failed, keep=True):
    """Draw pictures and return [(image, name, caption)]; names of those that failed are added to `failed`.

    `keep` says whether each gets a file and a line of its own.
    """
    from shadowatmo.options import explain
    from shadowatmo.passes.gallery import Gallery

    done = []
    samples = 2 if keep and math.prod(size) <= SMOOTHED_UP_TO else 1
    effort = {"samples": samples, "cache": not arguments.no_cache, "progress": bar}
    with Gallery(ctx, size, chosen_quality(arguments), **effort) as gallery:
        for picture in chosen:
            start, path = time.perf_counter(), arguments.out / f"{picture.name}.png"
            try:
                image = gallery.draw(picture)
                if keep:
                    image.save(path, compress_level=4)
            except Exception as error:
                if arguments.debug:
                    raise
                bar.erase()
                failed.append(picture.name)
                print(f"demo.py: picture {picture.name}: {explain(error)}", file=sys.stderr)
                continue
            done.append((image, picture.name, picture.caption))
            if keep:
                print(f"{path.name:<24} {time.perf_counter() - start:5.2f} s  {picture.caption}", flush=True)
    return done


def write_sheets(done, folder, arguments):
    """Write the contact sheet of each set that pictures [(image, name, caption)] belong to."""
    from shadowatmo.false_color import contact_sheet
    from shadowatmo.gallery import pictures

    for name, title in SHEETS.items():
        if arguments.only and name != "main":  # a choice of pictures makes one sheet
            break
        members = {picture.name for picture in pictures("all" if arguments.only else name)}
        shown = [entry for entry in done if entry[1] in members]
        if shown:
            contact_sheet(shown, width=THUMB).save(folder / f"{title}.png")
            print(f"{title + '.png':<24} {'':7}  {len(shown)} pictures on one sheet", flush=True)


def show_window(arguments):
    """Open the viewer."""
    if find_spec("moderngl_window") is None:
        print(f"demo.py: the window needs moderngl-window, which is not installed; {WINDOW_LINE}", file=sys.stderr)
        return 1
    from shadowatmo.controls import Controls
    from shadowatmo.passes.window import open_window

    sky = {"date": arguments.date, "observer": arguments.observer}
    controls = Controls(arguments.scene, chosen_quality(arguments), not arguments.no_cache, **sky)
    open_window(controls, arguments.out, arguments.size)
    return 0


def check(_arguments):
    """Say whether this machine can make pictures."""
    from shadowatmo.passes.check import check

    return 0 if check() else 1


def main(argv=None) -> int:
    """Run the demo and return its exit status."""
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        python = os.path.join(".venv", "bin", "python")
        print(
            f"demo.py: {', '.join(missing)} not found by {sys.executable}; run `make demo`, or `make setup` and then "
            f"{python} demo.py (Windows and macOS: see README.md)",
            file=sys.stderr,
        )
        return 1
    from shadowatmo.options import has_display, run

    parser = build_parser()
    arguments = parser.parse_args(argv)
    if (arguments.date is None) != (arguments.observer is None):
        parser.error("--date and --observer belong together")
    if arguments.date and (arguments.only or arguments.set):
        parser.error("--date makes a picture of its own: leave out --only and --set")
    headless = arguments.headless or arguments.only or arguments.set or not has_display()
    if arguments.list:
        command = list_pictures
    elif arguments.check:
        command = lambda: check(arguments)  # noqa: E731
    else:
        command = (lambda: write_pictures(arguments)) if headless else (lambda: show_window(arguments))
    return run("demo.py", command, arguments.debug)


if __name__ == "__main__":
    sys.exit(main())
