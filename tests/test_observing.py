"""A date and an observer on the command lines and in the viewer: what is seen, and one-line errors."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.__main__ import build_parser, main, make_view
from shadowatmo.controls import Controls
from shadowatmo.ephemeris import EYE
from shadowatmo.errors import ParameterError
from shadowatmo.observing import SkyRig, observed
from shadowatmo.places import azimuth_elevation
from shadowatmo.rigs import FlyRig, OrbitRig, SunRig
from shadowatmo.sequence import without_moons
from shadowatmo.worlds import WORLDS

ROOT = Path(__file__).resolve().parent.parent
DATE, OBSERVER = "2017-08-21T17:21Z", "44.633,-121.129,690"
PLACE = (44.633, -121.129, 690.0)
ECLIPSE = ("--date", DATE, "--observer", OBSERVER)


def view(*options):
    return make_view(build_parser().parse_args(["render", "-o", "x.png", *options]))


def load_demo():
    specification = importlib.util.spec_from_file_location("demo", ROOT / "demo.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


# --- the command line


def test_an_observer_looks_to_the_eclipsed_sun():
    scene, camera = view(*ECLIPSE, "--fov", "10")
    assert sa.sun_visibility(scene, camera.position)[0] == 0.0
    assert np.degrees(azimuth_elevation(camera.position, camera.forward)) == pytest.approx((119.5, 41.7), abs=0.1)
    assert camera.vertical_fov == pytest.approx(math.radians(10))
    assert scene.surface is not None and scene.sun_disc


def test_an_observer_may_look_elsewhere_and_a_camera_stand_elsewhere():
    scene, camera = view(*ECLIPSE, "--heading", "300", "--pitch", "5")
    assert np.degrees(azimuth_elevation(camera.position, camera.forward)) == pytest.approx((300, 5))
    there, far = view(*ECLIPSE, "--position=2e7,-2e8,4e7", "--target", "0,0,0")
    assert there == scene and far.position == (2e7, -2e8, 4e7)
    _, above = view(*ECLIPSE, "--altitude", "4e5", "--lat", "44", "--lon", "-121")
    assert np.linalg.norm(above.position) > scene.atmosphere.bottom_radius + 4e5


def test_a_date_alone_has_a_sun_and_a_moon():
    scene, camera = view("--date", DATE)
    assert len(scene.occluders) == 1 and camera.target == (0.0, 0.0, 0.0)
    assert scene.suns == (sa.sky_at(DATE).sun,)


def test_nobody_stands_below_the_ground():
    for height, above in ((0.0, EYE), (1e4, 1e4)):
        sky = observed(WORLDS["earth"], DATE, (33.0, 88.0, height))  # Tibet
        ground = WORLDS["earth"].ground.altitude(sky.position)
        altitude = np.linalg.norm(sky.position) - WORLDS["earth"].radius
        assert altitude == pytest.approx(max(above, ground + EYE), abs=1e-3)
    assert ground > 4000.0


@pytest.mark.parametrize(
    "options, words",
    [
        (("--date", "tomorrow"), "ISO 8601"),
        (("--date", "1066-10-14T12:00Z", "--observer", "50.9,0.5,10"), "ISO 8601"),
        (("--observer", OBSERVER), "--date"),
        (("--date", DATE, "--observer", "95,0,0"), "[-90, 90]"),
        (("--date", DATE, "--observer", "0,400,0"), "[-360, 360]"),
        (("--date", DATE, "--observer", "0,0,1e9"), "height"),
        (("--date", DATE, "--observer", "nan,0,0"), "latitude"),
        ((*ECLIPSE, "--scene", "mars"), "mars"),
        ((*ECLIPSE, "--sun-elevation", "3"), "--sun-elevation"),
    ],
)
def test_what_cannot_be_is_one_line(options, words, tmp_path, capsys):
    assert main(["render", "-o", str(tmp_path / "x.png"), *options]) == 1
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1 and "Traceback" not in error


def test_the_planet_must_be_as_large_as_the_earth():
    assert observed(WORLDS["thin_earth"], DATE, PLACE).position is not None
    with pytest.raises(ParameterError, match="toy_planet"):
        observed(WORLDS["toy_planet"], DATE, PLACE)


# --- the demo


def test_the_demo_draws_what_the_observer_sees(ctx, tmp_path, monkeypatch):
    monkeypatch.setattr(sa, "open_context", lambda: ctx, raising=False)
    monkeypatch.setattr(type(ctx), "release", lambda self: None)
    line = [*ECLIPSE, "--headless", "--size", "64x36", "--quality", "fast", "--out", str(tmp_path)]
    assert load_demo().main(line) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["observed.png"]


@pytest.mark.parametrize("line", [ECLIPSE[:2], ECLIPSE[2:], (*ECLIPSE, "--set=main"), (*ECLIPSE, "--only=widths")])
def test_the_demo_refuses_half_a_question(line, capsys):
    with pytest.raises(SystemExit) as caught:
        load_demo().main(list(line))
    assert caught.value.code == 2 and "--date" in capsys.readouterr().err


# --- the viewer


def test_the_clock_moves_sun_and_moon():
    controls = Controls("earth", date=DATE, observer=PLACE)
    assert isinstance(controls.rig, FlyRig) and "2017-08-21 17:21:00 UTC" in controls.status()
    camera = controls.camera()
    assert sa.sun_visibility(controls.scene(), camera.position)[0] == 0.0
    assert azimuth_elevation(camera.position, camera.forward) == pytest.approx(controls.sun.sky.toward_sun())
    controls.press("space")
    controls.advance(0.2)  # s, 120 s on the planet
    assert "17:23:00 UTC" in controls.status()
    assert 0.0 < sa.sun_visibility(controls.scene(), camera.position)[0] < 0.1


def test_arrows_do_not_move_a_real_sun():
    controls = Controls("earth", date=DATE, observer=PLACE)
    before = controls.scene()
    controls.press("left")
    controls.advance(0.2)
    assert controls.scene() == before


def test_other_planets_have_no_date():
    controls = Controls("earth", date=DATE, observer=PLACE)
    controls.press("p")
    assert isinstance(controls.sun, SunRig) and not controls.scene().occluders
    while controls.scene_name != "earth":
        controls.press("p")
    assert isinstance(controls.sun, SkyRig)


def test_a_date_without_an_observer_begins_in_orbit():
    controls = Controls("earth", date=DATE)
    assert isinstance(controls.rig, OrbitRig) and controls.scene().occluders


def test_the_clock_ends_with_what_is_known():
    rig = SkyRig(WORLDS["earth"], "2199-12-31T23:59Z", PLACE)
    rig.advance(3600.0)
    assert rig.moment.year == 2199


# --- the disc in a frame


def test_the_disc_stands_where_the_observer_sees_it(ctx):
    """Its middle is the picture's; by the direction from the planet's center it would be 6 seconds of arc beside it."""
    sky = observed(WORLDS["earth"], DATE, PLACE)
    fov, n = math.radians(0.7), 201
    camera, scene = sky.camera(vertical_fov=fov), sky.scene(surface=None)
    with sa.Renderer(ctx, without_moons(scene), (n, n), "fast") as renderer:
        light = renderer.render(camera).numpy()[..., 1].astype(float)
    disc = light > 0.1 * light.max()
    middle = np.argwhere(disc).mean(axis=0) - (n - 1) / 2
    pixel = math.degrees(fov) * 3600.0 / n
    assert np.abs(middle * pixel).max() < 1.0  # seconds of arc
    offset = np.array(scene.suns[0].direction) @ camera.basis()[:2].T  # right and up, of the parallel direction
    assert np.degrees(np.linalg.norm(offset)) * 3600.0 > 5.0
    assert disc.mean() == pytest.approx(math.pi / 4 * (2 * 948.5 / pixel / n) ** 2, rel=0.01)
