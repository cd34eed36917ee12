"""The demo: a window where there is a display, a folder of pictures where there is none.

    python demo.py                        look around
    python demo.py --headless             render the whole set into pictures/
    python demo.py --only limb_sunset     one picture of it
"""

import argparse
import os
import sys
import time
from importlib.util import find_spec
from pathlib import Path

START = time.perf_counter()
NEEDED = ("numpy", "PIL", "moderngl", "pyrr")
WINDOW_LINE = "pip install moderngl-window (or `make setup`), or draw without a window: python demo.py --headless"


def build_parser():
    """Return the parser of the command line."""
    from shadowatmo.options import Parser, names, size
    from shadowatmo.quality import NAMED
    from shadowatmo.worlds import WORLDS

    raw = argparse.RawDescriptionHelpFormatter
    parser = Parser("demo.py", description=__doc__, formatter_class=raw)
    parser.add_argument("--headless", action="store_true", help="write pictures; the default without a display")
    parser.add_argument("--out", type=Path, default=Path("pictures"), metavar="DIR", help="folder (default: pictures)")
    parser.add_argument("--only", type=names, metavar="NAME[,NAME]", help="only these pictures; implies --headless")
    parser.add_argument("--list", action="store_true", help="say which pictures there are, and stop")
    parser.add_argument("--size", type=size, metavar="WxH", help="pixels (default: 1283x719, window 1280x720 or less)")
    parser.add_argument("--quality", choices=tuple(NAMED), default="balanced", help="effort (default: %(default)s)")
    parser.add_argument("--scene", choices=sorted(WORLDS), default="earth", help="the window's planet")
    parser.add_argument("--check", action="store_true", help="versions, OpenGL, data; exit status 0 or 1")
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    return parser


def list_pictures():
    """Write the names of the set and what each shows."""
    from shadowatmo.gallery import pictures

    for picture in pictures():
        print(f"{picture.name:<20} {picture.caption}")


def write_pictures(arguments):
    """Render the set, or a part of it, and a contact sheet; the exit status is 0 when all of it was written."""
    from shadowatmo import open_context
    from shadowatmo.false_color import contact_sheet
    from shadowatmo.gallery import select
    from shadowatmo.options import explain
    from shadowatmo.passes.gallery import Gallery

    chosen = select(arguments.only)
    folder, size = arguments.out, arguments.size or (1283, 719)
    folder.mkdir(parents=True, exist_ok=True)
    ctx = open_context()
    print(f"{len(chosen)} pictures of {size[0]}x{size[1]} on {ctx.info['GL_RENDERER']}", flush=True)
    done, failed = [], []
    with Gallery(ctx, size, arguments.quality) as gallery:
        for picture in chosen:
            start, path = time.perf_counter(), folder / f"{picture.name}.png"
            try:
                image = gallery.draw(picture)
                image.save(path, compress_level=4)
            except Exception as error:
                if arguments.debug:
                    raise
                failed.append(picture.name)
                print(f"demo.py: picture {picture.name}: {explain(error)}", file=sys.stderr)
                continue
            done.append((image, picture.name, picture.caption))
            print(f"{path.name:<24} {time.perf_counter() - start:5.2f} s  {picture.caption}", flush=True)
    if done:
        contact_sheet(done).save(folder / "contact_sheet.png")
        print(f"{'contact_sheet.png':<24} {'':7}  all of them on one sheet")
    ctx.release()
    print(f"{len(done)} pictures in {folder.resolve()}, {time.perf_counter() - START:.1f} s since the start")
    if failed:
        print(f"demo.py: {len(failed)} of {len(chosen)} pictures failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def show_window(arguments):
    """Open the viewer."""
    if find_spec("moderngl_window") is None:
        print(f"demo.py: the window needs moderngl-window, which is not installed; {WINDOW_LINE}", file=sys.stderr)
        return 1
    from shadowatmo.controls import Controls
    from shadowatmo.passes.window import open_window

    open_window(Controls(arguments.scene, arguments.quality), arguments.out, arguments.size)
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

    arguments = build_parser().parse_args(argv)
    headless = arguments.headless or arguments.only or not has_display()
    if arguments.list:
        command = list_pictures
    elif arguments.check:
        command = lambda: check(arguments)  # noqa: E731
    else:
        command = (lambda: write_pictures(arguments)) if headless else (lambda: show_window(arguments))
    return run("demo.py", command, arguments.debug)


if __name__ == "__main__":
    sys.exit(main())
