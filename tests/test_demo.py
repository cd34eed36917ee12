"""The demo set: every picture is there, shows what its caption says, and failures are told."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import shadowatmo
from shadowatmo.errors import ParameterError
from shadowatmo.false_color import contact_sheet, false_color, font, left_half, metres, round_up, widths_image, wrap
from shadowatmo.gallery import pictures, select

ROOT = Path(__file__).resolve().parent.parent
SIZE = (161, 91)  # odd on purpose: nothing may lean on even sizes
WANTED = {  # what the project promises to show
    "earth_orbit_day", "limb_sunset", "night_ring", "shadow_side", "ground_sunset", "altitude_10km", "widths",
    "mars_day", "mars_sunset", "method_widths", "camera_inside_cone", "very_close",
}  # fmt: skip


def load_demo():
    """Import demo.py, which is no module of the package."""
    specification = importlib.util.spec_from_file_location("demo", ROOT / "demo.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def demo_command(*options, **changes):
    """Run demo.py in a process of its own without a display."""
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")} | changes
    line = [sys.executable, str(ROOT / "demo.py"), *map(str, options)]
    return subprocess.run(line, capture_output=True, text=True, env=environment, timeout=300)


# --- the set as data


def test_the_set_is_whole():
    names = [p.name for p in pictures()]
    assert set(names) == WANTED and len(names) == len(set(names))
    assert all(p.caption for p in pictures())


def test_select():
    assert [p.name for p in select(["widths", "limb_sunset"])] == ["limb_sunset", "widths"]
    with pytest.raises(ParameterError, match="limb_sunset"):
        select(["limb_sunrise"])


@pytest.mark.parametrize("name, height", [("ground_sunset", 2.0), ("mars_sunset", 2.0), ("altitude_10km", 1e4)])
def test_cameras_stand_above_the_ground(name, height):
    from shadowatmo.worlds import WORLDS

    picture = select([name])[0]
    world = WORLDS["mars" if name.startswith("mars") else "earth"]
    above = np.linalg.norm(picture.camera.position) - world.radius - world.ground.altitude(picture.camera.position)
    assert above == pytest.approx(height, abs=1e-3)  # m


# --- the set as pictures


@pytest.fixture(scope="module")
def frames(ctx):
    """Linear radiance and widths of every picture, (h, w, 3) and twice (h, w), and the finished pictures."""
    from shadowatmo.passes.gallery import Gallery

    found = {}
    with Gallery(ctx, SIZE) as gallery:
        for picture in pictures():
            image = np.asarray(gallery.draw(picture))
            frame = gallery._frame(picture, picture.quality)
            widths = (frame.read(name)[..., 0] for name in ("lit_width", "shadow_width"))
            found[picture.name] = (frame.numpy(), *widths, image)
    return found


@pytest.mark.parametrize("name", sorted(WANTED))
def test_every_picture_is_finite_and_not_black(frames, name):
    radiance, lit, shadow, image = frames[name]
    assert image.shape == (SIZE[1], SIZE[0], 3)
    for values in (radiance, lit, shadow):
        assert np.isfinite(values).all() and values.min() >= 0
    assert image.max() > 120 and len(np.unique(image.reshape(-1, 3), axis=0)) > 50


def test_the_night_ring_is_whole_and_surrounds_a_dark_disc(frames):
    radiance = frames["night_ring"][0].sum(axis=2)
    y, x = np.indices(radiance.shape)
    angle = np.arctan2(y - (SIZE[1] - 1) / 2, x - (SIZE[0] - 1) / 2)
    around = np.floor((angle + np.pi) / (2 * np.pi) * 12).astype(int).clip(0, 11)
    brightest = np.array([radiance[around == sector].max() for sector in range(12)])
    assert brightest.min() > 0.05 * brightest.max()
    assert radiance[35:56, 65:96].max() < 1e-6 * brightest.min()


def test_the_umbra_hides_all_ground_but_not_the_air(frames):
    radiance, lit, shadow, _ = frames["camera_inside_cone"]
    ground = slice(60, None)
    assert lit[ground].max() == 0 and shadow[ground].min() > 1e4  # m: no hole in the shadow, no cap
    assert radiance[ground].max() < 1e-3 * radiance.max()
    assert ((lit > 0) & (shadow > 0)).sum() > 200


def test_close_air_has_no_steps(frames):
    lit = frames["very_close"][1].astype(float)
    ground = np.diff(lit[50:], axis=0)  # nearer rows see shorter paths
    assert (ground < 0).all()
    assert np.abs(np.diff(ground, axis=0)).max() < 0.15 * np.abs(ground).max()


def test_close_air_shows_the_steps_of_the_published_depth_on_the_left(frames):
    image = frames["very_close"][3][50:, :, 2].astype(float)  # the ground side, in blue
    rough = np.abs(np.diff(image, 2, axis=0)).mean(axis=0)
    assert rough[:80].mean() > 1.5 * rough[81:].mean()


def test_the_shadow_from_the_side_has_day_and_night(frames):
    radiance, lit, shadow, _ = frames["shadow_side"]
    assert (shadow[-1] == 0).any() and (lit[-1] == 0).any() and ((lit > 0) & (shadow > 0)).any()
    assert radiance[-1, 0].min() > 1e3 * radiance[-1, -1].max()


def test_ground_is_in_view_and_not_black(frames):
    for name in ("ground_sunset", "mars_sunset", "altitude_10km"):
        radiance, _, _, image = frames[name]
        assert image[-8:].min(axis=(0, 1)).max() > 10, name


def test_sunset_is_red_and_noon_is_blue(frames):
    limb = frames["limb_sunset"][0]
    row, column = np.unravel_index(np.argmax(limb[..., 0] * (limb[..., 0] < 10)), limb.shape[:2])  # without the disc
    assert limb[row, column, 0] > 2 * limb[row, column, 2]
    sky = frames["altitude_10km"][0][0, 80]
    assert sky[2] > 1.5 * sky[0]


def test_no_picture_is_mostly_white(frames):
    for name, (_, _, _, image) in frames.items():
        assert (image.min(axis=2) > 250).mean() < 0.2, name


# --- false color and sheet


def test_false_color_keeps_the_widths_apart():
    lit, dark, none = false_color([1e6, 0, 0], [0, 1e6, 0], 1e6)
    assert lit[0] > lit[2] and dark[2] > dark[0] and not none.any()


@pytest.mark.parametrize("value, above", [(1, 1), (1.01, 2), (3.2e5, 5e5), (6e6, 1e7), (1e7, 1e7)])
def test_round_up(value, above):
    assert round_up(value) == pytest.approx(above)


def test_legend_names_metres():
    assert metres(2e6) == "2 000 000 m"
    empty = np.zeros((360, 640))
    assert np.asarray(widths_image(empty, empty)).max() > 200  # words
    assert np.asarray(widths_image(empty[:50, :50], empty[:50, :50])).max() == 0  # no room for them


def test_split_picture_keeps_its_left_half():
    left = left_half(Image.new("RGB", (60, 40), (1, 2, 3)))
    image = np.asarray(widths_image(np.full((40, 60), 1e5), np.zeros((40, 60)), left))
    assert (image[:, :30] == (1, 2, 3)).all() and not (image[:, 30:] == (1, 2, 3)).all()


def test_contact_sheet_holds_every_picture():
    colors = [(250, 0, 0), (0, 250, 0), (0, 0, 250), (250, 250, 0)]
    sheet = contact_sheet([(Image.new("RGB", (160, 90), c), "name", "a caption " * 20) for c in colors], width=300)
    found = {tuple(c) for c in np.asarray(sheet).reshape(-1, 3)}
    assert set(colors) <= found
    assert sheet.width == 12 + 3 * 312


def test_wrap():
    lines = wrap("one two three four five", font(14), 60)
    assert " ".join(lines) == "one two three four five" and len(lines) > 2
    assert all(font(14).getlength(line) <= 60 for line in lines)


# --- the script


@pytest.mark.usefixtures("ctx")
def test_demo_writes_what_was_asked_for(tmp_path):
    done = demo_command("--only", "night_ring,mars_day", "--size", "97x55", "--quality", "fast", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["contact_sheet.png", "mars_day.png", "night_ring.png"]
    with Image.open(tmp_path / "mars_day.png") as image:
        assert image.size == (97, 55)
    lines = done.stdout.splitlines()
    for name in ("mars_day.png", "night_ring.png"):
        line = next(line for line in lines if line.startswith(name))
        assert " s  " in line and len(line) > 50
    assert str(tmp_path) in lines[-1]
    assert not done.stderr


def test_list(capsys):
    assert load_demo().main(["--list"]) == 0
    assert {line.split()[0] for line in capsys.readouterr().out.splitlines()} == WANTED


@pytest.mark.parametrize(
    "options, words",
    [(("--only", "moon"), "one of"), (("--headless", "--size", "90000x90000"), "size"), (("--headless",), "blocked")],
    ids=["name", "size", "folder"],
)
def test_what_cannot_be_done_is_one_line(options, words, tmp_path, ctx, monkeypatch, capsys):
    monkeypatch.setattr(shadowatmo, "open_context", lambda: ctx, raising=False)
    monkeypatch.setattr(type(ctx), "release", lambda self: None)
    blocked = tmp_path / "blocked"
    blocked.write_text("a file stands where the folder should be")
    out = blocked if words == "blocked" else tmp_path / "out"
    assert load_demo().main([*options, "--out", str(out)]) == 1
    error = capsys.readouterr().err
    assert words in error and "Traceback" not in error


def test_a_failed_picture_is_told_and_the_others_are_made(tmp_path, ctx, monkeypatch, capsys):
    from shadowatmo.passes.gallery import Gallery

    def draw(self, picture):
        if picture.name == "widths":
            raise ParameterError("exposure", -1, "a positive number")
        return Image.new("RGB", self.size)

    monkeypatch.setattr(Gallery, "draw", draw)
    monkeypatch.setattr(shadowatmo, "open_context", lambda: ctx, raising=False)
    monkeypatch.setattr(type(ctx), "release", lambda self: None)
    line = ["--only", "widths,mars_day", "--size", "8x8", "--out", str(tmp_path)]
    assert load_demo().main(line) == 1
    error = capsys.readouterr().err
    assert "picture widths" in error and "1 of 2" in error
    assert (tmp_path / "mars_day.png").is_file() and not (tmp_path / "widths.png").exists()


def test_missing_packages_are_told_with_the_remedy(monkeypatch, capsys):
    demo = load_demo()
    monkeypatch.setattr(demo, "find_spec", lambda name: None)
    assert demo.main([]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "numpy" in error and "make setup" in error


def test_a_missing_window_package_is_told_with_the_remedy(monkeypatch, capsys):
    demo = load_demo()
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(demo, "find_spec", lambda name: None if name == "moderngl_window" else object())
    assert demo.main([]) == 1
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "pip install moderngl-window" in error


def test_a_display_that_does_not_answer_is_told(tmp_path):
    done = demo_command("--out", tmp_path, DISPLAY=":1717")
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and "--headless" in done.stderr
