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
from shadowatmo.ephemeris import contacts
from shadowatmo.errors import ParameterError
from shadowatmo.observing import DATE_HELP, OBSERVER_HELP, observed, observed_scene, observer_radians
from shadowatmo.options import FAILED, Parser, ProgressBar, numbers, run, size
from shadowatmo.places import bearing, place
from shadowatmo.quality import METHODS, NAMED, as_quality
from shadowatmo.report_command import add_report
from shadowatmo.sequence import compare_steps, explained_share, frame_times, strip
from shadowatmo.validation import number, vector
from shadowatmo.worlds import WORLDS, world

DESCRIPTION = """\
Pictures of planets through their atmospheres, with the shadow of the planet in the air.

  shadowatmo render -o orbit.png                       the Earth from orbit
  shadowatmo render --altitude 2 --lat -33 --lon -68.9 --heading 268 --pitch 4 \\
                    --sun-azimuth 270 --sun-elevation 2 -o sunset.png
  shadowatmo render --scene mars --altitude 3e5 -o mars.png
  shadowatmo render --date 2017-08-21T17:21Z --observer 44.633,-121.129,690 -o totality.png
  shadowatmo sequence --date 2017-08-21T17:21Z --observer 44.633,-121.129,690 -o strip.png
                                                       the whole eclipse, from first to last contact
  shadowatmo check                                     does OpenGL work here?
  shadowatmo report --fast                             how fast and how exact is each method here?
"""
PLACES = """\
Lengths are metres, angles degrees. The planet's center is the origin, longitude 0 lies on +x, 90 E on +y, the north
pole on +z. Without a direction of view the camera looks at the planet's center from far away, and to the horizon from
below 1000 km or a third of the radius. Without a sun it stands 40 degrees high, to the right of the view's heading.
A date puts sun and moon where they are; an observer then looks to the sun, unless told where to stand or look.
"""
SEQUENCE = """\
Frames are dense about the greatest eclipse. Each step of their brightness is compared to what the moon explains, which
is known without pictures; the exit status is 1 if one is larger than that, and the strip is written all the same.
"""
SUNS = ("sun-direction", "sun-elevation", "sun-azimuth")
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
    sequence = commands.add_parser("sequence", help="an eclipse from first to last contact as a strip of frames",
                                   epilog=SEQUENCE, formatter_class=raw)  # fmt: skip
    _add_sequence(sequence)
    sequence.set_defaults(action=_sequence)
    check = commands.add_parser("check", help="versions, OpenGL, data files, one tiny frame; exit status 0 or 1")
    check.set_defaults(action=_check)
    for command in (render, sequence, check, add_report(commands)):
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
    group.add_argument("--date", metavar="TIME", help=DATE_HELP)
    group.add_argument("--observer", type=numbers, metavar="LAT,LON,HEIGHT", help=OBSERVER_HELP)


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


def _add_sequence(parser):
    """Add what a sequence needs."""
    parser.add_argument("--date", metavar="TIME", required=True, help="within 6 hours of a solar eclipse (UTC)")
    parser.add_argument("--observer", type=numbers, metavar="LAT,LON,HEIGHT", required=True, help=OBSERVER_HELP)
    parser.add_argument("--frames", type=int, default=60, help="how many (default: %(default)s)")
    parser.add_argument("--heading", type=float, help="compass bearing of the view axis (default: the eclipsed sun's)")
    parser.add_argument("--pitch", type=float, default=20.0, help="of it above the horizontal (default: %(default)g)")
    parser.add_argument("--fov", type=float, default=60.0, help="angle of a frame's height (default: %(default)g)")
    parser.add_argument("-o", "--out", type=Path, required=True, metavar="FILE", help="a picture (.png, .jpg)")
    parser.add_argument("--size", type=size, default=(192, 108), metavar="WxH", help="of a frame (default: 192x108)")
    parser.add_argument("--quality", choices=tuple(NAMED), default="balanced", help="effort (default: %(default)s)")
    parser.add_argument("--no-cache", action="store_true", help="neither read nor keep precomputed tables on disk")


def make_view(arguments):
    """Return the scene and the camera that the command line asks for.

    Raises
    ------
    ParameterError
        If options exclude each other or a value is out of range.
    """
    planet = world(arguments.scene)
    sky = _sky(arguments, planet)
    there = sky is not None and sky.position is not None
    there = there and not _given(arguments, "position", "lat", "lon", "altitude")
    if there and not _given(arguments, "target", "forward", "heading", "pitch"):
        return observed_scene(planet, sky), sky.camera(vertical_fov=_fov(arguments))
    position = np.array(sky.position) if there else _position(arguments, planet)
    height = float(np.linalg.norm(position)) - planet.radius
    heading = math.radians(0.0 if arguments.heading is None else number("heading", arguments.heading))
    axis = _axis(arguments, position, planet, height, heading)
    camera = Camera(position=position, vertical_fov=_fov(arguments), **axis)
    if sky is not None:
        return observed_scene(planet, sky), camera
    return planet.scene(_sun_direction(arguments, position, heading)), camera


def _fov(arguments) -> float:
    """Return the angle of the picture's height [rad]."""
    return math.radians(number("fov", arguments.fov, low=0.0, high=180.0, open_low=True, open_high=True))


def _sky(arguments, planet):
    """Return the sky of a date, or None without one."""
    if arguments.date is None:
        if arguments.observer is not None:
            raise ParameterError("--observer", arguments.observer, "it with --date: it says whose sun and moon")
        return None
    suns = {name: getattr(arguments, name.replace("-", "_")) for name in SUNS}
    _exclude("date", arguments.date, suns)
    return observed(planet, arguments.date, arguments.observer)


def _given(arguments, *options) -> bool:
    """Return whether any of some options was given."""
    return any(getattr(arguments, option) is not None for option in options)


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


def _check_out(out, suffixes) -> None:
    """Raise ParameterError if a file to be written has another suffix, or no folder."""
    if out.suffix.lower() not in (*suffixes, ".jpeg"):
        words = f"{', '.join(suffixes[:-1])} or {suffixes[-1]}"
        raise ParameterError("--out", str(out), f"a file name that ends in {words}")
    if out.parent and not out.parent.is_dir():
        raise ParameterError("--out", str(out), f"a file in an existing folder; make {out.parent} first")


def _render(arguments) -> None:
    out = arguments.out
    _check_out(out, (".png", ".jpg", ".npy"))
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


def _sequence(arguments) -> int:
    from shadowatmo.passes.sequence import draw_sequence

    _check_out(arguments.out, (".png", ".jpg"))
    planet, place_and_height = world("earth"), arguments.observer
    found = contacts(arguments.date, observer_radians(place_and_height))
    times = frame_times(found, arguments.frames)
    pitch = math.radians(number("pitch", arguments.pitch, low=-90, high=90))
    heading = None if arguments.heading is None else math.radians(number("heading", arguments.heading))
    camera = observed(planet, found.greatest, place_and_height).camera(heading, pitch, _fov(arguments))
    ctx = shadowatmo.open_context()
    try:
        options = {"cache": not arguments.no_cache}
        drawn = draw_sequence(
            ctx, planet, times, place_and_height, camera, arguments.size, arguments.quality, **options
        )
    finally:
        ctx.release()
    strip(drawn.images).save(arguments.out)
    explained = [explained_share(scene, camera, arguments.size) for scene in drawn.scenes]
    excess = compare_steps(drawn.share, explained).excess
    worst, least = int(np.argmax(excess)), int(np.argmin(drawn.share))
    print(f"{arguments.out}  {len(times)} frames, {times[0]:%Y-%m-%d %H:%M:%S} to {times[-1]:%H:%M:%S} UTC")
    print(f"darkest at {times[least]:%H:%M:%S}: {drawn.share[least]:.2e} of the light without the moon")
    print(f"largest unexplained step at {times[worst]:%H:%M:%S}: {excess[worst]:.2f} of what is granted")
    return 0 if excess[worst] <= 1.0 else FAILED


def _check(arguments) -> int:
    from shadowatmo.passes.check import check

    return 0 if check() else 1


def main(argv=None) -> int:
    """Run the command line and return its exit status."""
    arguments = build_parser().parse_args(argv)
    return run("shadowatmo", lambda: arguments.action(arguments), arguments.debug)


if __name__ == "__main__":
    sys.exit(main())
