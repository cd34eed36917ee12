"""The command line: `render` makes one picture, `check` says whether this machine can, `report` how fast and exact."""

import argparse
import math
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import shadowatmo
from shadowatmo.camera import Camera
from shadowatmo.errors import ParameterError
from shadowatmo.options import Parser, ProgressBar, numbers, run, size
from shadowatmo.places import bearing, place
from shadowatmo.quality import METHODS, NAMED, as_quality
from shadowatmo.report_command import add_report
from shadowatmo.validation import number, vector
from shadowatmo.worlds import WORLDS, world

DESCRIPTION = """\
Pictures of planets through their atmospheres, with the shadow of the planet in the air.

  shadowatmo render -o orbit.png                       the Earth from orbit
  shadowatmo render --altitude 2 --lat -33 --lon -68.9 --heading 268 --pitch 4 \\
                    --sun-azimuth 270 --sun-elevation 2 -o sunset.png
  shadowatmo render --scene mars --altitude 3e5 -o mars.png
  shadowatmo check                                     does OpenGL work here?
  shadowatmo report --fast                             how fast and how exact is each method here?
"""
PLACES = """\
Lengths are metres, angles degrees. The planet's center is the origin, longitude 0 lies on +x, 90 E on +y, the north
pole on +z. Without a direction of view the camera looks at the planet's center from far away, and to the horizon from
below 1000 km or a third of the radius. Without a sun it stands 40 degrees high, to the right of the view's heading.
"""
LOOKS_AHEAD_BELOW = 1e6  # m, or a third of the radius where that is less


def build_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command line."""
    raw = argparse.RawDescriptionHelpFormatter
    parser = Parser("shadowatmo", description=DESCRIPTION, formatter_class=raw)
    parser.add_argument("--version", action="version", version=f"shadowatmo {shadowatmo.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=Parser)
    render = commands.add_parser("render", help="make one picture", epilog=PLACES, formatter_class=raw)
    _add_view(render)
    _add_picture(render)
    render.set_defaults(action=_render)
    check = commands.add_parser("check", help="versions, OpenGL, data files, one tiny frame; exit status 0 or 1")
    check.set_defaults(action=_check)
    for command in (render, check, add_report(commands)):
        command.add_argument("--debug", action="store_true", help="show the traceback of an error")
    return parser


def _add_view(parser):
    """Add where the camera and the sun are."""
    group = parser.add_argument_group("where the camera is")
    group.add_argument("--scene", choices=sorted(WORLDS), default="earth", help="planet (default: %(default)s)")
    group.add_argument("--position", type=numbers, metavar="X,Y,Z", help="planet-centered; write --position=-1,0,0")
    group.add_argument("--altitude", type=float, help="above the ground at --lat and --lon (default: 2.12 radii)")
    group.add_argument("--lat", type=float, help="latitude, north positive (default: 15)")
    group.add_argument("--lon", type=float, help="longitude, east positive (default: 25)")
    group = parser.add_argument_group("where it looks")
    group.add_argument("--target", type=numbers, metavar="X,Y,Z", help="point in the middle of the picture")
    group.add_argument("--forward", type=numbers, metavar="X,Y,Z", help="direction of the view axis")
    group.add_argument("--heading", type=float, help="compass bearing of the view axis")
    group.add_argument("--pitch", type=float, help="of the view axis above the horizontal")
    group.add_argument("--fov", type=float, default=45.0, help="angle of the picture's height (default: %(default)g)")
    group = parser.add_argument_group("where the sun is")
    group.add_argument("--sun-direction", type=numbers, metavar="X,Y,Z", help="from the planet's center to the sun")
    group.add_argument("--sun-elevation", type=float, help="above the horizontal at the camera")
    group.add_argument("--sun-azimuth", type=float, help="compass bearing at the camera")


def _add_picture(parser):
    """Add what is made of the view."""
    group = parser.add_argument_group("the picture")
    group.add_argument("-o", "--out", type=Path, required=True, metavar="FILE",
                       help="a picture (.png, .jpg), or linear radiance as .npy")  # fmt: skip
    group.add_argument("--size", type=size, default=(1283, 719), metavar="WxH", help="pixels (default: 1283x719)")
    group.add_argument("--quality", choices=tuple(NAMED), default="balanced", help="effort (default: %(default)s)")
    group.add_argument("--method", choices=METHODS, help="of the air's light (default: the quality's)")
    group.add_argument("--exposure", type=float, help="factor on radiance (default: automatic)")
    group.add_argument("--no-cache", action="store_true", help="neither read nor keep precomputed tables on disk")


def make_view(arguments):
    """Return the scene and the camera that the command line asks for.

    Raises
    ------
    ParameterError
        If options exclude each other or a value is out of range.
    """
    planet = world(arguments.scene)
    position = _position(arguments, planet)
    height = float(np.linalg.norm(position)) - planet.radius
    heading = math.radians(0.0 if arguments.heading is None else number("heading", arguments.heading))
    fov = math.radians(number("fov", arguments.fov, low=0.0, high=180.0, open_low=True, open_high=True))
    camera = Camera(position=position, vertical_fov=fov, **_axis(arguments, position, planet, height, heading))
    return planet.scene(_sun_direction(arguments, position, heading)), camera


def _position(arguments, planet):
    """Return the camera's position (3,) [m]."""
    angles = {"lat": arguments.lat, "lon": arguments.lon, "altitude": arguments.altitude}
    if arguments.position is not None:
        _exclude("position", arguments.position, angles)
        return np.array(vector("position", arguments.position, low=-1e15, high=1e15, nonzero=True))
    latitude = math.radians(number("lat", 15.0 if arguments.lat is None else arguments.lat, low=-90, high=90))
    longitude = math.radians(number("lon", 25.0 if arguments.lon is None else arguments.lon))
    height = planet.far_height if arguments.altitude is None else arguments.altitude
    height = number("altitude", height, low=-1e5, high=1e12)
    ground = planet.ground.altitude(place(planet.radius, latitude, longitude))
    return place(planet.radius, latitude, longitude, ground + height)


def _axis(arguments, position, planet, height, heading) -> dict:
    """Return the camera's target or forward, and its up."""
    turned = {"heading": arguments.heading, "pitch": arguments.pitch}
    if arguments.target is not None:
        _exclude("target", arguments.target, {**turned, "forward": arguments.forward})
        return {"target": arguments.target, "up": _upright(position, np.subtract(arguments.target, position))}
    if arguments.forward is not None:
        _exclude("forward", arguments.forward, turned)
        return {"forward": arguments.forward, "up": _upright(position, arguments.forward)}
    far = height > min(LOOKS_AHEAD_BELOW, planet.radius / 3.0)
    if far and arguments.heading is None and arguments.pitch is None:
        return {"target": (0.0, 0.0, 0.0)}
    dip = math.acos(min(planet.radius / (planet.radius + max(height, 0.0)), 1.0))
    pitch = -dip if arguments.pitch is None else math.radians(number("pitch", arguments.pitch, low=-90, high=90))
    forward = bearing(position, heading, pitch)
    return {"forward": forward, "up": _upright(position, forward)}


def _upright(position, forward):
    """Return the direction at the top of the picture: away from the planet, or north when looking down or up."""
    level = np.linalg.norm(np.cross(position, forward))
    return position if level > 1e-3 * np.linalg.norm(position) * np.linalg.norm(forward) else (0.0, 0.0, 1.0)


def _sun_direction(arguments, position, heading):
    """Return the direction (3,) to the sun."""
    if arguments.sun_direction is not None:
        local = {"sun-elevation": arguments.sun_elevation, "sun-azimuth": arguments.sun_azimuth}
        _exclude("sun-direction", arguments.sun_direction, local)
        return arguments.sun_direction
    elevation = 40.0 if arguments.sun_elevation is None else arguments.sun_elevation
    azimuth = math.degrees(heading) + 110.0 if arguments.sun_azimuth is None else arguments.sun_azimuth
    elevation = number("sun-elevation", elevation, low=-90, high=90)
    return bearing(position, math.radians(number("sun-azimuth", azimuth)), math.radians(elevation))


def _exclude(name, value, others):
    """Raise ParameterError if any of the other options was given beside `name`."""
    given = [f"--{other}" for other, there in others.items() if there is not None]
    if given:
        raise ParameterError(f"--{name}", value, f"it without {' and '.join(given)}: they say the same thing twice")


def _render(arguments) -> None:
    out = arguments.out
    if out.suffix.lower() not in (".png", ".jpg", ".jpeg", ".npy"):
        raise ParameterError("--out", str(out), "a file name that ends in .png, .jpg or .npy")
    if out.parent and not out.parent.is_dir():
        raise ParameterError("--out", str(out), f"a file in an existing folder; make {out.parent} first")
    scene, camera = make_view(arguments)
    quality = as_quality(arguments.quality)
    if arguments.method is not None:
        quality = replace(quality, method=arguments.method)
    start = time.perf_counter()
    ctx = shadowatmo.open_context()
    try:
        with (
            ProgressBar(wait=ctx.finish) as bar,
            shadowatmo.Renderer(
                ctx, scene, size=arguments.size, quality=quality, cache=not arguments.no_cache, progress=bar
            ) as renderer,
        ):
            frame = renderer.render(camera)
            if out.suffix.lower() == ".npy":
                np.save(out, frame.numpy())
            else:
                frame.image(arguments.exposure).save(out)
    finally:
        ctx.release()
    print(f"{out}  {arguments.size[0]}x{arguments.size[1]}  {time.perf_counter() - start:.2f} s")


def _check(arguments) -> int:
    from shadowatmo.passes.check import check

    return 0 if check() else 1


def main(argv=None) -> int:
    """Run the command line and return its exit status."""
    arguments = build_parser().parse_args(argv)
    return run("shadowatmo", lambda: arguments.action(arguments), arguments.debug)


if __name__ == "__main__":
    sys.exit(main())
