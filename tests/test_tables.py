"""Precomputed tables while running: made once, in slices when asked to, kept on disk, never taken from a bad file."""

import dataclasses

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.cache import TableCache
from tests.cameras import CAMERAS, SUN

SIZE, CAMERA = (61, 35), CAMERAS["2 m, sunset"]
SCENE = sa.Scene(suns=SUN)
DENSER = sa.Scene(dataclasses.replace(sa.EARTH, mie_scale_height=1500.0), SUN)


def drawn(ctx, cache, scene=SCENE, log=None):
    """Return a frame's pixels, and the labels of the steps that were computed."""
    labels = [] if log is None else log
    with sa.Renderer(ctx, scene, SIZE, cache=cache, progress=lambda label, *_: labels.append(label)) as renderer:
        return renderer.render(CAMERA).numpy(), labels


def test_second_start_reads_the_disk(ctx, tmp_path):
    cache = TableCache(tmp_path)
    first, computed = drawn(ctx, cache)
    second, again = drawn(ctx, cache)
    assert computed and not again
    assert np.array_equal(first, second)
    other, more = drawn(ctx, cache, DENSER)
    assert more and not np.array_equal(other, first)


def test_without_a_cache_nothing_is_kept(ctx, tmp_path, monkeypatch):
    monkeypatch.setenv("SHADOWATMO_CACHE_DIR", str(tmp_path))
    drawn(ctx, False)
    assert not list(tmp_path.iterdir())
    drawn(ctx, True)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("damage", ["truncated", "flipped", "older", "foreign", "empty"])
def test_bad_files_are_never_pictures(ctx, tmp_path, damage, monkeypatch):
    cache = TableCache(tmp_path)
    good, _ = drawn(ctx, cache)
    (file,) = tmp_path.iterdir()
    content = bytearray(file.read_bytes())
    if damage == "truncated":
        file.write_bytes(content[: len(content) // 2])
    elif damage == "flipped":
        content[len(content) // 2] ^= 1
        file.write_bytes(content)
    elif damage == "older":
        monkeypatch.setattr("shadowatmo.cache.FORMAT_VERSION", 0)
        found = TableCache(tmp_path)
        arrays = {"multiple_table": np.zeros((4, 4), np.float32)}
        found.save(file.stem, arrays)
        monkeypatch.undo()
    elif damage == "foreign":
        file.write_bytes(b"\x89PNG\r\n" + bytes(1000))
    else:
        file.write_bytes(b"")
    pixels, computed = drawn(ctx, cache)
    assert computed and np.array_equal(pixels, good)
    assert not drawn(ctx, cache)[1]  # and the file is mended


def test_slices_keep_a_frame_short(ctx):
    """With a budget no frame runs more than one step beyond it; pictures come at once, and end as the whole table's."""
    whole, steps = drawn(ctx, False)
    with sa.Renderer(ctx, SCENE, SIZE, cache=False, table_budget=1e-6) as renderer:
        single = renderer.render(CAMERA).numpy()
        frames = 1
        while not np.array_equal(renderer.render(CAMERA).numpy(), whole):
            frames += 1
            assert frames <= len(steps) + 1
        assert frames >= len(steps) - 1 and single.mean() < whole.mean()
        renderer.scene = DENSER
        stale = renderer.render(CAMERA).numpy()  # the old table serves on
        assert stale.mean() > 0.8 * whole.mean()


def test_bad_arguments(ctx):
    for arguments, name in (({"cache": "folder"}, "cache"), ({"table_budget": -1.0}, "table_budget")):
        with pytest.raises(sa.ParameterError, match=name):
            sa.Renderer(ctx, SCENE, SIZE, **arguments)
