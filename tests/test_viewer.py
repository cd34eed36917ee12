"""The viewer without and with a window: what it draws follows the controls."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from shadowatmo.controls import HELP, KEYS, Controls
from shadowatmo.quality import METHODS

ROOT = Path(__file__).resolve().parent.parent
SIZE = (96, 54)


@pytest.fixture
def screen(ctx):
    framebuffer = ctx.simple_framebuffer(SIZE, components=4)
    yield framebuffer
    framebuffer.release()


@pytest.fixture
def viewer(ctx):
    from shadowatmo.passes.viewer import Viewer

    controls = Controls(quality="fast")
    controls.wants_help = False
    made = Viewer(ctx, controls)
    yield made
    made.close()


@pytest.fixture
def fresh_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SHADOWATMO_CACHE_DIR", str(tmp_path / "tables"))


def pixels(framebuffer):
    data = np.frombuffer(framebuffer.read(components=3, alignment=1), np.uint8)
    return data.reshape(framebuffer.size[1], framebuffer.size[0], 3)[::-1].astype(int)


def test_frames_show_the_planet_well_exposed(viewer, screen):
    viewer.draw(screen, SIZE, 0.1)
    image = pixels(screen)
    middle = image[22:32, 43:53].mean(axis=(0, 1))
    assert np.all(middle > 40) and np.all(middle < 240)
    assert image[:3, :3].max() <= 1  # space, but for the dither


def test_time_and_keys_change_the_frame(viewer, screen):
    viewer.draw(screen, SIZE, 0.1)
    before = pixels(screen)
    viewer.controls.press("d")
    viewer.draw(screen, SIZE, 0.2)
    assert np.abs(pixels(screen) - before).mean() > 1.0


def test_help_is_drawn_over_the_frame_and_taken_away(viewer, screen):
    size, screen_large = (640, 360), viewer.ctx.simple_framebuffer((640, 360), components=4)
    viewer.draw(screen_large, size, 0.1)
    before = pixels(screen_large)
    viewer.controls.press("f1")
    viewer.draw(screen_large, size, 0.0)
    helped = pixels(screen_large)
    changed = (np.abs(helped - before).max(axis=2) > 40).nonzero()
    assert len(changed[0]) > 500
    assert changed[0].max() < 300 and changed[1].max() < 620  # the lower right corner stays
    viewer.controls.press("f1")
    viewer.draw(screen_large, size, 0.0)
    assert np.abs(pixels(screen_large) - before).max() <= 2  # the exposure may have moved by a hair
    screen_large.release()


def test_words_fit_and_name_every_key():
    from shadowatmo.passes.overlay import words

    image = np.asarray(words(HELP, 14))
    assert image[:, :4, :3].max() < 40 and image[:, -4:, :3].max() < 40  # no letter is cut at the sides
    text = " ".join(keys for keys, _ in HELP).lower()
    for key in KEYS:
        if len(key) == 1 or key.startswith("f"):
            assert key in text


def test_meter_takes_means(ctx, rng):
    from shadowatmo.passes.meter import Meter

    blocks = rng.random((36, 64, 3)).astype(np.float32)
    picture = np.ones((180, 320, 4), np.float32)
    picture[..., :3] = blocks.repeat(5, axis=0).repeat(5, axis=1)
    texture = ctx.texture((320, 180), 4, picture[::-1].tobytes(), dtype="f4")
    meter = Meter(ctx, (320, 180))
    meter.draw({"color": texture})
    assert np.allclose(meter.read(), blocks, atol=1e-6)  # 16 equal float32 summed
    meter.release()
    texture.release()


def test_a_resize_is_followed(viewer, ctx):
    for size in (SIZE, (41, 77), (1, 1), SIZE):
        framebuffer = ctx.simple_framebuffer(size, components=4)
        viewer.draw(framebuffer, size, 0.1)
        assert viewer.size == size
        framebuffer.release()


@pytest.mark.parametrize("key", ["m", "n", "k", "p", "tab"])
def test_every_mode_draws(viewer, screen, key):
    viewer.draw(screen, SIZE, 0.1)
    viewer.controls.press(key)
    viewer.draw(screen, SIZE, 0.1)
    assert pixels(screen)[20:34, 40:56].mean() > 10


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.usefixtures("fresh_cache")
def test_frames_do_not_wait_for_tables(viewer, screen, monkeypatch, method):
    """Without a kept table the first frame is there before the table is."""
    from shadowatmo.passes.tables import TableKeeper

    spent, advance = [], TableKeeper._advance

    def timed(self):
        steps = len(self._steps)
        advance(self)
        spent.append((steps, self._done, self.budget))

    monkeypatch.setattr(TableKeeper, "_advance", timed)
    viewer.controls.quality = replace(viewer.controls.quality, method=method)
    viewer.draw(screen, SIZE, 0.0)
    assert spent and all(steps > done > 0 and budget == 0.03 for steps, done, budget in spent)
    assert pixels(screen).shape == (SIZE[1], SIZE[0], 3)


def test_the_cache_can_be_switched_off(ctx, screen):
    from shadowatmo.passes.viewer import Viewer

    for cache in (True, False):
        viewer = Viewer(ctx, Controls(quality="fast", cache=cache))
        viewer.draw(screen, SIZE, 0.0)
        assert (viewer._renderer._cache is not None) == cache
        viewer.close()


def test_pictures_are_numbered(viewer, screen, tmp_path):
    viewer.draw(screen, SIZE, 0.1)
    paths = [viewer.save_picture(tmp_path / "new") for _ in range(2)]
    assert [p.name for p in paths] == ["view_001.png", "view_002.png"]
    with Image.open(paths[0]) as image:
        assert np.abs(np.asarray(image).astype(int) - pixels(screen)).max() <= 1


def test_a_closed_viewer_draws_again(viewer, screen):
    viewer.draw(screen, SIZE, 0.1)
    viewer.close()
    viewer.draw(screen, SIZE, 0.1)
    assert pixels(screen).max() > 40


@pytest.mark.parametrize("name, height", [("Andes", 500.0), ("Tibet", 1e4)])
def test_ground_agrees_with_the_relief_that_is_drawn(ctx, name, height):
    """The distance straight down is the height above `Ground`: rigs stand on what is drawn."""
    import shadowatmo as sa
    from shadowatmo.places import place
    from shadowatmo.worlds import world

    earth = world("earth")
    latitude, longitude = {"Andes": (-0.57, -1.215), "Tibet": (0.56, 1.53)}[name]
    below = place(earth.radius, latitude, longitude)
    altitude = earth.ground.altitude(below)
    camera = sa.Camera(position=place(earth.radius, latitude, longitude, altitude + height), target=(0, 0, 0))
    with sa.Renderer(ctx, earth.scene((1, 0, 0)), size=(3, 3)) as renderer:
        distance = renderer.render(camera).read("depth")[1, 1, 0]
    assert altitude > 1000.0
    assert distance == pytest.approx(height, abs=1.0 + 1e-3 * height)  # m; the drawn relief has flat facets


# --- with a window

WINDOW_SCRIPT = """
import json, sys
from shadowatmo.controls import KEYS, Controls
from shadowatmo.passes.window import make_window
controls = Controls("earth", "fast")
config = make_window(controls, sys.argv[1], (160, 90), ("-wnd", "headless", "--backend", "egl"))
config.names = {name: name for name in KEYS}  # a headless window has no key codes of its own
keys, frames, heights = config.wnd.keys, 0, []
def tap(name):
    config.on_key_event(name, keys.ACTION_PRESS, None)
    config.on_key_event(name, keys.ACTION_RELEASE, None)
while not config.wnd.is_closing and frames < 20:
    config.wnd.use()
    config.wnd.render(frames * 0.1, 0.1)
    config.wnd.swap_buffers()
    heights.append(controls.rig.height)
    if frames == 1: config.on_mouse_scroll_event(0, 4)
    if frames == 2: config.on_mouse_drag_event(10, 10, 8, 4)
    if frames == 3: config.wnd.size = 100, 70; config.wnd._buffer_width, config.wnd._buffer_height = 100, 70
    if frames == 4: tap("f12")
    if frames == 5: tap("tab")
    if frames == 6: tap("escape")
    frames += 1
title, error = config.wnd.title, config.ctx.error
print(json.dumps([frames, heights[0], heights[-1], title, error, config.viewer.size]))
config.wnd.destroy()
"""


def test_window(tmp_path):
    """A process of its own, because the window brings a second OpenGL context."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "ignore"}
    line = [sys.executable, "-c", WINDOW_SCRIPT, str(tmp_path)]
    done = subprocess.run(line, capture_output=True, text=True, env=environment, cwd=tmp_path, timeout=120)
    assert done.returncode == 0, done.stderr
    frames, first, last, title, error, size = json.loads(done.stdout.splitlines()[-1])
    assert frames == 8  # the one in which Escape is seen is the last
    assert last == pytest.approx(first / 1.25**4, rel=1e-6)
    assert title.startswith("shadowatmo | earth") and "above ground" in title
    assert error == "GL_NO_ERROR"
    assert size is None  # closing the window released what draws
    with Image.open(tmp_path / "view_001.png") as image:
        assert image.size == (100, 70)
