"""The same call twice gives the same bits on the same driver."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.cache import TableCache
from shadowatmo.multiple_recipes import Recipe
from shadowatmo.passes.multiple import MultipleScattering
from shadowatmo.passes.tables import TableKeeper
from shadowatmo.passes.transmittance import TransmittanceTable
from shadowatmo.rays import ProbeResult
from tests.cameras import CAMERAS, R

SIZE = (61, 37)
MOON = sa.Occluder((1.8e8, 7e7, 0.0), 1.7e6)
SCENE = sa.Scene(suns=(sa.Sun((1.0, 0.4, 0.0)), sa.Sun((-0.2, 1.0, 0.3), irradiance=(0.3, 0.2, 0.1))), occluders=MOON)
CAMERA_NAMES = ("2 m, sunset", "400 km, sunset", "1e9 m, behind the planet")
SMALL = Recipe(heights=8, suns=16, polar=8, azimuths=6, degree=4, orders=3)


def same(first, second):
    """Whether two arrays hold the same bits, those of nan included."""
    first, second = np.ascontiguousarray(first), np.ascontiguousarray(second)
    return first.dtype == second.dtype and first.shape == second.shape and first.tobytes() == second.tobytes()


def test_bits_are_compared():
    """The rejected cases: one last bit, and the sign of zero."""
    one = np.ones(3, np.float32)
    assert same(one, one.copy()) and not same(one, np.nextafter(one, np.float32(2)))
    assert not same(np.zeros(1), -np.zeros(1)) and same(np.full(2, np.nan), np.full(2, np.nan))


def fields_of(frame):
    return [frame.read(name).copy() for name in ("color", "depth", "lit_width", "shadow_width")]


@pytest.fixture(scope="module")
def renderers(ctx):
    """Two renderers of the same scene, made one after the other."""
    with sa.Renderer(ctx, SCENE, SIZE, cache=False) as first, sa.Renderer(ctx, SCENE, SIZE, cache=False) as second:
        yield first, second


@pytest.mark.parametrize("name", CAMERA_NAMES)
def test_render(ctx, renderers, name):
    first, second = renderers
    frame = fields_of(first.render(CAMERAS[name]))
    assert np.isfinite(frame[0]).all() and frame[0].max() > 0.0
    first.render(CAMERAS["2 m, deep night"])  # what was drawn in between leaves no trace
    for again in (first.render(CAMERAS[name]), second.render(CAMERAS[name])):
        assert all(same(a, b) for a, b in zip(frame, fields_of(again), strict=True))
    moved = replace(CAMERAS[name], target=None, position=tuple(1.001 * np.array(CAMERAS[name].position)))
    assert not same(frame[0], first.render(moved).read("color"))


METHODS = {
    "tiles": sa.Quality(depth="analytic", tolerance=0.006),
    "march": sa.Quality(method="march", steps=16),
    "widths": sa.Quality(method="widths"),
    "table3d": sa.Quality(method="table3d", depth="analytic", tolerance=0.006),
    "table3d-multiple": sa.Quality(method="table3d-multiple", depth="analytic"),
    "table4d": sa.Quality(method="table4d", depth="analytic"),
    "24 bits": sa.Quality(orders=1, depth_bits=24),
}


@pytest.mark.parametrize("method", METHODS)
def test_every_method_after_another_scene(ctx, tmp_path, method):
    """Drawn, drawn again after another scene, and by a renderer that reads its tables from disk: the same bits."""
    scene, camera = sa.Scene(suns=SCENE.suns[0], surface=sa.Surface()), CAMERAS["2 m, sunset"]
    # another air for what is solved fast; tables of the published methods take seconds
    other = replace(SCENE, atmosphere=sa.MARS if not method.startswith("table") else sa.EARTH)
    frames = []
    for _ in range(2):
        with sa.Renderer(ctx, scene, SIZE, METHODS[method], cache=TableCache(tmp_path)) as renderer:
            frames.append(fields_of(renderer.render(camera)))
            renderer.scene = other
            between = renderer.render(CAMERAS["400 km, sunset"]).read("color").copy()
            renderer.scene = scene
            frames.append(fields_of(renderer.render(camera)))
    assert not same(frames[0][0], between)
    for again in frames[1:]:
        assert all(same(a, b) for a, b in zip(frames[0], again, strict=True))


PRINTED = """
import hashlib, numpy as np, shadowatmo as sa
from tests.cameras import CAMERAS
from tests.test_determinism import SCENE, SIZE, rays
ctx = sa.open_context()
quality = sa.Quality(orders=1, depth="analytic")
found = sa.probe(ctx, SCENE, *rays(np.random.default_rng(1), 300), quality=quality)
with sa.Renderer(ctx, SCENE, SIZE, quality) as renderer:
    frame = renderer.render(CAMERAS["400 km, sunset"]).read("color")
print(hashlib.sha256(found.single.tobytes() + found.transmittance.tobytes() + frame.tobytes()).hexdigest())
"""


def test_two_contexts_agree():
    """In two processes, since two headless contexts in one are asking for trouble."""
    first, second = (
        subprocess.run([sys.executable, "-c", PRINTED], check=True, capture_output=True, text=True, timeout=120).stdout
        for _ in range(2)
    )
    assert len(first.strip()) == 64 and first == second


def test_compose(ctx, renderers, rng):
    color = ctx.texture(SIZE, 4, rng.random((*SIZE[::-1], 4), np.float32).tobytes(), dtype="f4")
    depth = ctx.texture(SIZE, 1, (10 ** rng.uniform(0, 6, SIZE[::-1])).astype(np.float32).tobytes(), dtype="f4")
    frames = [fields_of(r.compose(color, depth, CAMERAS["2 m, sunset"])) for r in (*renderers, *renderers)]
    for again in frames[1:]:
        assert all(same(a, b) for a, b in zip(frames[0], again, strict=True))
    color.release()
    depth.release()


def rays(rng, count=1500):
    up = rng.normal(size=(count, 3))
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    return up * (R + 10 ** rng.uniform(0, 8, (count, 1))), rng.normal(size=(count, 3)) - 0.8 * up


def test_probe(ctx, rng):
    origins, directions = rays(rng)
    first, second = (sa.probe(ctx, SCENE, origins, directions, quality="fast") for _ in range(2))
    assert {"top", "ground", "miss"} <= set(first.end)
    for name in ProbeResult.__dataclass_fields__:
        if name != "end":
            assert same(getattr(first, name), getattr(second, name)), name
    # a ray's result does not depend on the company it is probed in
    alone = sa.probe(ctx, SCENE, origins[700:703], directions[700:703], quality="fast")
    assert same(alone.single, first.single[700:703]) and same(alone.multiple, first.multiple[700:703])


@pytest.mark.parametrize("method", ["march", "table3d"])
def test_probe_by_other_methods(ctx, rng, method):
    origins, directions = rays(rng, 300)
    quality = sa.Quality(method=method, orders=1)
    first = sa.probe(ctx, SCENE, origins, directions, quality=quality)
    sa.probe(ctx, sa.Scene(sa.MARS), origins, directions, quality=quality)
    again = sa.probe(ctx, SCENE, origins, directions, quality=quality)
    assert first.single.max() > 0.0
    for name in ("single", "transmittance", "ground_direct"):
        assert same(getattr(first, name), getattr(again, name)), name


def test_twin(rng):
    origins, directions = rays(rng, 40)
    first, second = (sa.reference.probe(SCENE, origins, directions) for _ in range(2))
    assert same(first.single, second.single) and same(first.transmittance, second.transmittance)


def test_table_of_columns(ctx):
    tables = []
    for _ in range(2):
        table = TransmittanceTable(ctx)
        table.draw(sa.EARTH, {})
        tables.append(table.target.read_color(0).copy())
        table.release()
    assert same(*tables)


def solved(ctx, cache=None, budget=None):
    """Return the finished table's arrays, from a cache where there is one."""
    keeper = TableKeeper(ctx, lambda: MultipleScattering(ctx, SMALL), cache, budget=budget)
    textures = {}
    while not textures:
        keeper.draw(sa.EARTH, textures)
    arrays = {name: np.array(values) for name, values in keeper._ready.arrays().items()}
    keeper.release()
    return arrays


def test_table_solved_read_and_sliced(ctx, tmp_path):
    """Solved, solved again, in slices over many frames, and read from disk: the same bits."""
    from shadowatmo.passes.gl.state import preserve_state

    with preserve_state(ctx):
        first = solved(ctx)
        cache = TableCache(tmp_path)
        others = {
            "again": solved(ctx),
            "to the cache": solved(ctx, cache),
            "from the cache": solved(ctx, cache),
            "in slices": solved(ctx, budget=1e-6),
        }
    assert any(tmp_path.rglob("*")), "nothing was kept"
    for way, arrays in others.items():
        assert all(same(first[name], arrays[name]) for name in first), way


def test_frames_with_a_table_from_the_cache(ctx, tmp_path):
    cache = TableCache(tmp_path)
    frames = []
    for _ in range(2):
        with sa.Renderer(ctx, sa.Scene(suns=SCENE.suns[0]), SIZE, cache=cache) as renderer:
            frames.append(renderer.render(CAMERAS["2 m, sunset"]).read("color").copy())
    assert same(*frames)
