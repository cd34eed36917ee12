"""The demo set: every picture is there, shows what its caption says, and failures are told."""

import importlib.util
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import shadowatmo
from shadowatmo.errors import ParameterError
from shadowatmo.false_color import contact_sheet, false_color, font, left_half, metres, round_up, widths_image, wrap
from shadowatmo.gallery import pictures, select
from shadowatmo.worlds import WORLDS

ROOT = Path(__file__).resolve().parent.parent
SIZE = (161, 91)  # odd on purpose: nothing may lean on even sizes
WANTED = {  # what the project promises to show
    "earth_orbit_day", "limb_sunset", "night_ring", "shadow_side", "ground_sunset", "altitude_10km", "widths",
    "mars_day", "mars_sunset", "method_widths", "camera_inside_cone", "very_close",
}  # fmt: skip
ECLIPSES = {
    "shadow_from_moon", "shadow_from_400km", "shadow_from_10km", "totality_north", "totality_east", "totality_south",
    "totality_west", "totality_fisheye", "annular_sky", "annular_ring", "jupiter_shadows", "two_suns_set",
    "two_suns_shadows",
}  # fmt: skip
PRESETS = {f"{world}_{shown}" for world in WORLDS for shown in ("space", "aloft", "low_sun")}


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


EVERY = {"main": WANTED, "presets": PRESETS, "eclipses": ECLIPSES, "all": WANTED | PRESETS | ECLIPSES}


@pytest.mark.parametrize("which, wanted", EVERY.items())
def test_the_set_is_whole(which, wanted):
    names = [p.name for p in pictures(which)]
    assert set(names) == wanted and len(names) == len(set(names))
    assert all(p.caption.endswith(".") for p in pictures(which))


def test_an_unknown_set_is_refused():
    with pytest.raises(ParameterError, match="presets"):
        pictures("planets")


@pytest.mark.parametrize("name", WORLDS)
def test_preset_pictures_name_their_preset_and_their_height(name):
    space, aloft, low_sun = (p for p in pictures("presets") if p.scene.atmosphere is WORLDS[name].atmosphere)
    assert WORLDS[name].atmosphere is getattr(shadowatmo, name.upper())
    assert all(p.caption.startswith(f"{name.upper()} from ") for p in (space, aloft, low_sun))
    world = WORLDS[name]
    heights = [
        np.linalg.norm(p.camera.position) - world.radius - world.ground.altitude(p.camera.position)
        for p in (aloft, low_sun)
    ]
    thickness = world.atmosphere.top_radius - world.radius
    words = "660 m, a third" if name == "toy_planet" else "130 km, a third" if name == "titan" else "20 km"
    assert words in aloft.caption
    assert heights[0] == pytest.approx(2e4 if words == "20 km" else thickness / 3.0, rel=0.03)
    assert heights[1] == pytest.approx(2.0, abs=1e-3)  # m
    assert np.linalg.norm(space.camera.position) > world.atmosphere.top_radius


def test_select():
    assert [p.name for p in select(["widths", "limb_sunset"])] == ["limb_sunset", "widths"]
    assert [p.name for p in select(["titan_space", "widths"])] == ["widths", "titan_space"]
    assert select() == pictures() and select(None, "presets") == pictures("presets")
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
        for picture in (*pictures("main"), *pictures("presets")):
            image = np.asarray(gallery.draw(picture))
            frame = gallery._frame(picture, picture.quality)
            widths = (frame.read(name)[..., 0] for name in ("lit_width", "shadow_width"))
            found[picture.name] = (frame.numpy(), *widths, image)
    return found


@pytest.mark.parametrize("name", sorted(WANTED | PRESETS))
def test_every_picture_is_finite_and_not_black(frames, name):
    radiance, lit, shadow, image = frames[name]
    assert image.shape == (SIZE[1], SIZE[0], 3)
    for values in (radiance, lit, shadow):
        assert np.isfinite(values).all() and values.min() >= 0
    assert image.max() > 120 and len(np.unique(image.reshape(-1, 3), axis=0)) > 50


def test_samples_average_the_edges_and_nothing_else(ctx):
    """Half a pixel of limb is half as bright, the middle of the disc as before; widths keep their legend."""
    from shadowatmo.passes.gallery import Gallery

    size = (128, 72)
    earth, widths = select(["earth_orbit_day", "widths"])
    found = []
    for samples in (1, 2, 6):
        with Gallery(ctx, size, "fast", samples=samples) as gallery:
            found.append(np.asarray(gallery.draw(replace(earth, exposure=10.0))).astype(float))
            assert gallery.draw(widths).size == size
    coarse, smooth, finest = found
    assert coarse.shape == smooth.shape == finest.shape == (72, 128, 3)
    assert np.abs(smooth - finest).max() < 0.6 * np.abs(coarse - finest).max()
    assert np.abs(coarse - finest).max() > 20 and np.median(np.abs(coarse - finest)) < 2


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
    # what little is seen there was scattered into the umbra by lit air and once more by its own: 1.1e-4 of the limb
    assert radiance[ground].max() < 2e-4 * radiance.max()
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


def colors(frames, name):
    """Return the mean linear color (3,) of a picture's middle third, as shares of their sum."""
    radiance = frames[name][0]
    mean = radiance[SIZE[1] // 3 : -SIZE[1] // 3, SIZE[0] // 3 : -SIZE[0] // 3].mean(axis=(0, 1))
    return mean / mean.sum()


def test_planets_have_their_colors(frames):
    red, _, blue = colors(frames, "titan_aloft")
    assert red > 2 * blue
    assert colors(frames, "mars_space")[0] > 1.5 * colors(frames, "mars_space")[2]
    assert colors(frames, "toy_planet_space")[2] > colors(frames, "toy_planet_space")[0]


def test_denser_air_veils_the_ground(frames):
    """Contrast of Africa from space: the thicker the air, the less."""
    contrast = []
    for name in ("thin_earth_space", "earth_space", "dense_earth_space"):
        middle = frames[name][0][30:60, 65:95, 0]
        contrast.append(middle.std() / middle.mean())
    assert contrast[0] > contrast[1] > contrast[2]


def test_denser_air_reddens_the_low_sun(frames):
    sky = [frames[f"{name}_low_sun"][0][30, 80] for name in ("thin_earth", "earth", "dense_earth")]
    shares = [color[0] / color[2] for color in sky]
    assert shares[0] < shares[1] < shares[2]


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


@pytest.fixture
def instant(ctx, monkeypatch):
    """The script in this process, with the context that there is and pictures without drawing."""
    from shadowatmo.passes.gallery import Gallery

    monkeypatch.setattr(Gallery, "draw", lambda self, picture: Image.new("RGB", self.size, (9, 9, 9)))
    monkeypatch.setattr(shadowatmo, "open_context", lambda: ctx, raising=False)
    monkeypatch.setattr(type(ctx), "release", lambda self: None)


@pytest.mark.parametrize(
    "options, names, sheets",
    [
        (("--headless",), WANTED, {"contact_sheet", "contact_sheet_presets"}),
        (("--set", "main"), WANTED, {"contact_sheet"}),
        (("--set", "presets"), PRESETS, {"contact_sheet_presets"}),
        (("--set", "eclipses"), ECLIPSES, {"contact_sheet_eclipses"}),
        (("--set", "all"), EVERY["all"], {"contact_sheet", "contact_sheet_presets", "contact_sheet_eclipses"}),
        (("--only", "titan_space,mars_day"), {"titan_space", "mars_day"}, {"contact_sheet"}),
    ],
    ids=["default", "main", "presets", "eclipses", "all", "only"],
)
@pytest.mark.usefixtures("instant")
def test_sets_and_their_sheets(options, names, sheets, tmp_path):
    assert load_demo().main([*options, "--size", "64x36", "--out", str(tmp_path)]) == 0
    assert {p.stem for p in tmp_path.iterdir()} == names | sheets


def test_no_cache_and_method_reach_the_renderer(ctx, tmp_path, monkeypatch):
    from shadowatmo.passes import gallery

    made = []

    def renderer(ctx, scene, size, quality, **options):
        made.append((quality.method, options["cache"]))
        raise ParameterError("size", size, "nothing: this is a test")

    monkeypatch.setattr(gallery, "Renderer", renderer)
    monkeypatch.setattr(shadowatmo, "open_context", lambda: ctx, raising=False)
    monkeypatch.setattr(type(ctx), "release", lambda self: None)
    for options in ((), ("--no-cache", "--method", "table4d")):
        assert load_demo().main(["--only", "mars_day", *options, "--out", str(tmp_path)]) == 1
    assert made == [("segments", True), ("table4d", False)]


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
    assert {line.split()[0] for line in capsys.readouterr().out.splitlines()} == EVERY["all"]


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
