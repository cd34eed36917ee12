"""The health check: versions, OpenGL, capabilities, data files, and one tiny frame with its time."""

import logging
import platform
import time
from importlib.metadata import PackageNotFoundError, version

import numpy as np

import shadowatmo
from shadowatmo.errors import ShadowAtmoError
from shadowatmo.gallery import select
from shadowatmo.passes.gallery import Gallery
from shadowatmo.passes.gl.context import describe_context, open_context
from shadowatmo.worlds import WORLDS

PACKAGES = ("moderngl", "glcontext", "numpy", "pyrr", "pillow", "moderngl-window", "ephem")
OPTIONAL = {"moderngl-window": "the window of demo.py", "ephem": "the sky of a date"}  # what needs them
TINY = (64, 36)


def check(write=print) -> bool:
    """Write what was found, line by line, and return whether pictures can be made here."""
    sound = [_check_packages(write), _check_data(write), _check_drawing(write)]
    write("result".ljust(17) + ("everything needed works" if all(sound) else "not usable: see what is marked FAILED"))
    return all(sound)


def _check_packages(write) -> bool:
    """Write the versions of Python and of the packages; return whether all required ones are there."""
    write(f"shadowatmo       {shadowatmo.__version__}")
    write(f"python           {platform.python_version()} ({platform.system()} {platform.machine()})")
    sound = True
    for name in PACKAGES:
        try:
            write(f"{name:<16} {version(name)}")
        except PackageNotFoundError:
            needed = name not in OPTIONAL
            sound = sound and not needed
            why = "FAILED: needed" if needed else f"not installed; only {OPTIONAL[name]} needs it"
            write(f"{name:<16} {why}; pip install {name}")
    return sound


def _check_data(write) -> bool:
    """Write which maps were found; return whether none is missing."""
    for world in WORLDS.values():
        for kind in ("color", "height"):
            path = getattr(world.surface, kind)
            found = "none: the same everywhere" if path is None else f"{path} ({path.stat().st_size} bytes)"
            write(f"{world.name + ' ' + kind:<16} {found}")
    return True


def _check_drawing(write) -> bool:
    """Write what OpenGL there is and draw one tiny frame; return whether that worked."""
    logger = logging.getLogger("shadowatmo")
    level = logger.level
    logger.setLevel(logging.ERROR)  # the renderer's name is about to be written anyway
    try:
        ctx = open_context()
    except ShadowAtmoError as error:
        write(f"opengl           FAILED: {error}")
        return False
    finally:
        logger.setLevel(level)
    try:
        for name, value in describe_context(ctx).items():
            write(f"gl {name.replace('_', ' '):<16} {value}")
        picture = select(["earth_orbit_day"])[0]
        start = time.perf_counter()
        with Gallery(ctx, TINY, "fast") as gallery:
            image = np.asarray(gallery.draw(picture))
        seconds = time.perf_counter() - start
        bright = bool(image.max() > 0)
        state = "" if bright else "FAILED: it is black; "
        write(f"frame            {state}{TINY[0]}x{TINY[1]} in {seconds:.2f} s, shaders included")
        return bright
    except ShadowAtmoError as error:
        write(f"frame            FAILED: {error}")
        return False
    finally:
        ctx.release()
