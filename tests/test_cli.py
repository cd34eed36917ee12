"""The command line `shadowatmo`: what it makes of its options, its exit statuses and its one-line errors."""

import io
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import shadowatmo
from shadowatmo.__main__ import build_parser, main, make_view
from shadowatmo.errors import ContextError, ParameterError
from shadowatmo.options import ProgressBar, explain, has_display, run, size
from shadowatmo.places import azimuth_elevation
from shadowatmo.presets import MARS
from shadowatmo.quality import METHODS
from shadowatmo.worlds import WORLDS

ROOT = Path(__file__).resolve().parent.parent
R = 6.36e6
SMALL = ("--size", "64x36", "--quality", "fast")


def view(*options):
    return make_view(build_parser().parse_args(["render", "-o", "x.png", *options]))


def shadowatmo_command(*options, **environment):
    """Run the command in a process of its own, as people do."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
    line = [sys.executable, "-m", "shadowatmo", *map(str, options)]
    return subprocess.run(line, capture_output=True, text=True, env=environment, timeout=120)


# --- where the camera and the sun are


def test_without_options_the_whole_earth_is_in_view():
    scene, camera = view()
    distance = math.hypot(*camera.position)
    assert math.asin(scene.atmosphere.top_radius / distance) < camera.vertical_fov / 2
    assert scene.surface is not None
    assert np.dot(camera.position, scene.suns[0].direction) > 0  # by day


@pytest.mark.parametrize("name", WORLDS)
def test_every_planet_is_in_view_without_options(name):
    scene, camera = view("--scene", name)
    atmosphere, distance = scene.atmosphere, math.hypot(*camera.position)
    assert atmosphere is WORLDS[name].atmosphere and camera.target == (0, 0, 0)
    assert 0.3 < math.asin(atmosphere.bottom_radius / distance) / (camera.vertical_fov / 2) < 1


def test_altitude_counts_from_the_ground():
    _, camera = view("--altitude", "2", "--lat", "33", "--lon", "88")  # Tibet
    assert 4500 < math.hypot(*camera.position) - R < 5500


def test_a_low_camera_looks_to_the_horizon():
    _, camera = view("--altitude", "10000", "--lat", "0", "--lon", "-30", "--heading", "90")
    azimuth, elevation = azimuth_elevation(camera.position, camera.forward)
    assert math.degrees(azimuth) == pytest.approx(90)
    assert elevation == pytest.approx(-math.acos(R / (R + 1e4)))


def test_heading_and_pitch_and_sun():
    options = ("--altitude", "2", "--heading", "200", "--pitch", "5", "--sun-azimuth", "210", "--sun-elevation", "-3")
    scene, camera = view(*options)
    looks = np.degrees(azimuth_elevation(camera.position, camera.forward))
    sun = np.degrees(azimuth_elevation(camera.position, scene.suns[0].direction))
    assert looks == pytest.approx((200, 5)) and sun == pytest.approx((210, -3))


def test_position_target_and_sun_direction():
    line = ("--position=-2e7,1e6,0", "--target", "0,0,6e6", "--sun-direction", "0,-2,0", "--fov", "30")
    scene, camera = view(*line, "--scene", "mars")
    assert camera.position == (-2e7, 1e6, 0) and camera.target == (0, 0, 6e6)
    assert scene.suns[0].direction == (0, -1, 0) and scene.atmosphere == MARS
    assert camera.vertical_fov == pytest.approx(math.radians(30))


def test_looking_straight_down_has_north_at_the_top():
    _, camera = view("--altitude", "5e5", "--lat", "20", "--pitch", "-90")
    assert camera.up == (0, 0, 1)
    assert camera.basis()[1][2] > 0.9


@pytest.mark.parametrize(
    "options, names",
    [
        (("--position=7e6,0,0", "--lat", "3"), "--position --lat"),
        (("--target=0,0,0", "--pitch", "3"), "--target --pitch"),
        (("--forward=0,0,1", "--heading", "3"), "--forward --heading"),
        (("--sun-direction=0,0,1", "--sun-elevation", "3"), "--sun-direction --sun-elevation"),
        (("--lat", "91"), "lat"),
        (("--fov", "180"), "fov"),
        (("--sun-elevation", "nan"), "sun-elevation"),
        (("--position=nan,0,0",), "position"),
        (("--position=0,0,0",), "position"),
        (("--altitude", "inf"), "altitude"),
    ],
)
def test_bad_views_are_refused(options, names):
    with pytest.raises(ParameterError) as caught:
        view(*options)
    assert all(name in str(caught.value) for name in names.split())


# --- typed values


@pytest.mark.parametrize("text", ["1283", "1283x", "0x10", "-3x4", "3.5x4", "axb", "9999999x1"])
def test_bad_sizes_are_refused(text, capsys):
    with pytest.raises(SystemExit) as caught:
        build_parser().parse_args(["render", "-o", "x.png", f"--size={text}"])
    assert caught.value.code == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "expected WIDTHxHEIGHT" in error and "--help" in error


def test_sizes():
    assert size("1283x719") == (1283, 719) and size(" 2 X 1 ") == (2, 1)


@pytest.mark.parametrize("text", ["1,2", "1,2,3,4", "a,b,c", ""])
def test_bad_points_are_refused(text, capsys):
    with pytest.raises(SystemExit):
        build_parser().parse_args(["render", "-o", "x.png", f"--position={text}"])
    assert "three numbers X,Y,Z" in capsys.readouterr().err


@pytest.mark.parametrize(
    "environment, platform, expected",
    [
        ({}, "linux", False),
        ({"DISPLAY": ""}, "linux", False),
        ({"DISPLAY": ":0"}, "linux", True),
        ({"WAYLAND_DISPLAY": "wayland-0"}, "linux", True),
        ({}, "darwin", True),
        ({}, "win32", True),
    ],
)
def test_has_display(environment, platform, expected):
    assert has_display(environment, platform) is expected


# --- progress


class Screen(io.StringIO):
    """A terminal that remembers; `line` is what its one line shows."""

    terminal = True

    def isatty(self):
        return self.terminal

    @property
    def line(self):
        shown = ""
        for text in self.getvalue().split("\r"):
            shown = text + shown[len(text) :]
        return shown.rstrip()


def steps(bar, clock, count, seconds):
    """Do `count` steps of equal length; return the line after each."""
    lines = []
    for done in range(1, count + 1):
        clock[0] += seconds
        bar("table", done, count)
        lines.append(bar._stream.line)
    return lines


def test_a_long_computation_shows_a_bar_and_leaves_nothing():
    clock = [0.0]
    bar = ProgressBar(Screen(), clock=lambda: clock[0])
    lines = steps(bar, clock, 20, 0.1)
    assert not any(lines[:5])  # not before half a second
    assert all("table" in line and f"{n}/20" in line for n, line in list(enumerate(lines, 1))[6:19])
    assert lines[18].count("#") > lines[8].count("#") > 0
    assert lines[19] == "" and "\n" not in bar._stream.getvalue()


def test_short_computations_show_no_bar_however_many():
    clock = [0.0]
    bar = ProgressBar(Screen(), clock=lambda: clock[0])
    for _ in range(5):
        steps(bar, clock, 4, 0.1)
    assert not bar._stream.getvalue()


def test_no_bar_without_a_terminal():
    clock, stream = [0.0], Screen()
    stream.terminal = False
    bar = ProgressBar(stream, wait=lambda: pytest.fail("work was waited for"), clock=lambda: clock[0])
    steps(bar, clock, 20, 1.0)
    assert not stream.getvalue()


def test_an_error_erases_the_bar():
    clock = [0.0]
    with pytest.raises(ZeroDivisionError), ProgressBar(Screen(), clock=lambda: clock[0]) as bar:
        for done in (1, 2, 3):
            clock[0] += 1.0
            bar("table", done, 9)
        assert bar._stream.line
        raise ZeroDivisionError
    assert not bar._stream.line


# --- errors


@pytest.mark.parametrize(
    "error, words",
    [
        (ContextError("no OpenGL; install it"), "no OpenGL; install it"),
        (ModuleNotFoundError("No module", name="moderngl"), "moderngl is missing"),
        (PermissionError(13, "Permission denied", "folder/x"), "folder/x"),
        (ZeroDivisionError("division by zero"), "--debug"),
        (ValueError("two\nlines"), "two lines"),
    ],
)
def test_errors_are_one_line_and_the_status_is_1(error, words, capsys):
    def fail():
        raise error

    assert run("tool", fail) == 1
    said = capsys.readouterr().err
    assert said.startswith("tool: ") and said.count("\n") == 1 and words in said
    assert explain(error) in said


def test_debug_shows_the_traceback(capsys):
    assert run("tool", lambda: 1 / 0, debug=True) == 1
    assert "Traceback" in capsys.readouterr().err


def test_the_status_of_a_command_is_handed_on():
    assert run("tool", lambda: None) == 0 and run("tool", lambda: 7) == 7


@pytest.mark.parametrize("out", ["x.bmp", "x", "missing/x.png"])
def test_bad_files_are_refused_before_anything_is_drawn(out, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(shadowatmo, "open_context", lambda: pytest.fail("a context was opened"), raising=False)
    assert main(["render", "-o", out]) == 1
    assert "--out" in capsys.readouterr().err


# --- the commands themselves


@pytest.fixture
def same_context(ctx, monkeypatch):
    """Commands open and release a context; here they get the one that there is, and cannot end it."""

    class Kept:
        def __init__(self):
            self.released = False

    kept = Kept()
    monkeypatch.setattr(shadowatmo, "open_context", lambda: ctx, raising=False)
    monkeypatch.setattr(type(ctx), "release", lambda self: setattr(kept, "released", True))
    return kept


def test_render_writes_a_picture(same_context, tmp_path, capsys):
    path = tmp_path / "x.png"
    assert main(["render", "-o", str(path), *SMALL]) == 0
    with Image.open(path) as image:
        assert image.size == (64, 36) and np.asarray(image)[18, 32].max() > 60
    assert capsys.readouterr().out.startswith(f"{path}  64x36")
    assert same_context.released


def test_render_writes_linear_radiance(same_context, tmp_path):
    path = tmp_path / "x.npy"
    assert main(["render", "-o", str(path), *SMALL]) == 0
    radiance = np.load(path)
    assert radiance.shape == (36, 64, 3) and radiance.dtype == np.float32
    assert np.isfinite(radiance).all() and radiance.max() > 0


def test_exposure_and_method_matter(same_context, tmp_path):
    means, exposure = {}, ("--exposure", "5")
    cases = {"plain": exposure, "brighter": ("--exposure", "10"), "widths": (*exposure, "--method", "widths")}
    for name, options in cases.items():
        assert main(["render", "-o", str(tmp_path / f"{name}.png"), *SMALL, *options]) == 0
        with Image.open(tmp_path / f"{name}.png") as image:
            means[name] = np.asarray(image).mean()
    assert means["brighter"] > means["plain"] + 1 and abs(means["widths"] - means["plain"]) > 1


@pytest.mark.parametrize("method", METHODS)
def test_every_method_is_a_choice(method):
    assert build_parser().parse_args(["render", "-o", "x.png", "--method", method]).method == method


def test_no_cache_keeps_nothing_on_disk(same_context, tmp_path, monkeypatch):
    tables = tmp_path / "tables"
    monkeypatch.setenv("SHADOWATMO_CACHE_DIR", str(tables))
    line = ["render", "-o", str(tmp_path / "x.png"), *SMALL]
    assert main([*line, "--no-cache"]) == 0
    assert not tables.exists()
    assert main(line) == 0
    assert list(tables.glob("*.table"))


def test_a_bad_exposure_is_refused(same_context, tmp_path, capsys):
    assert main(["render", "-o", str(tmp_path / "x.png"), *SMALL, "--exposure", "-1"]) == 1
    assert "exposure" in capsys.readouterr().err
    assert not (tmp_path / "x.png").exists() and same_context.released


@pytest.mark.usefixtures("ctx")
def test_check_as_a_process():
    done = shadowatmo_command("check")
    assert done.returncode == 0, done.stderr
    for words in ("python", "moderngl", "gl renderer", "gl version", "earth color", "64x36", "everything needed works"):
        assert words in done.stdout
    assert not done.stderr


def test_check_without_opengl():
    done = shadowatmo_command("check", GLCONTEXT_DEVICE_INDEX="999")
    assert done.returncode == 1
    assert "FAILED" in done.stdout and "not usable" in done.stdout


def test_render_without_opengl(tmp_path):
    done = shadowatmo_command("render", "-o", tmp_path / "x.png", GLCONTEXT_DEVICE_INDEX="999")
    assert done.returncode == 1
    assert done.stderr.startswith("shadowatmo: no OpenGL") and done.stderr.count("\n") == 1


def test_version(capsys):
    with pytest.raises(SystemExit) as caught:
        main(["--version"])
    assert caught.value.code == 0 and capsys.readouterr().out == f"shadowatmo {shadowatmo.__version__}\n"


@pytest.mark.parametrize("line, words", [(["--help"], "shadowatmo render -o"), (["render", "--help"], "--sun-azimuth")])
def test_help(line, words, capsys):
    with pytest.raises(SystemExit) as caught:
        main(line)
    assert caught.value.code == 0 and words in capsys.readouterr().out


@pytest.mark.parametrize("line", [[], ["render"], ["paint"], ["render", "-o", "x.png", "--no-such-thing"]])
def test_misuse_is_one_line_and_status_2(line, capsys):
    with pytest.raises(SystemExit) as caught:
        main(line)
    error = capsys.readouterr().err
    assert caught.value.code == 2 and error.count("\n") == 1 and "--help" in error
