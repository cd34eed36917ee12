"""Tables on disk: what was saved comes back, and no damaged, foreign or older file is ever taken for a table."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo import cache
from shadowatmo.cache import TableCache


@pytest.fixture
def tables(tmp_path):
    return TableCache(tmp_path / "made" / "when needed")


ARRAYS = {"table": np.arange(60, dtype=np.float32).reshape(3, 5, 4), "level": np.linspace(0, 1, 7).astype(np.float16)}
KEY = TableCache.key(sa.EARTH, (16, 48), "shader text")


def test_round_trip(tables):
    assert tables.load(KEY) is None
    assert tables.save(KEY, ARRAYS)
    found = tables.load(KEY)
    assert found.keys() == ARRAYS.keys()
    assert all(np.array_equal(found[n], a) and found[n].dtype == a.dtype for n, a in ARRAYS.items())
    assert [p.suffix for p in tables.folder.iterdir()] == [".table"]  # nothing half-written is left


def test_keys_tell_contents_apart():
    keys = {KEY, TableCache.key(sa.MARS, (16, 48), "shader text"), TableCache.key(sa.EARTH, (16, 49), "shader text")}
    assert len(keys | {TableCache.key(sa.EARTH, (16, 48), "shader Text")}) == 4
    assert TableCache.key(sa.EARTH, (16, 48), "shader text") == KEY


def test_every_flipped_byte_is_noticed(tables):
    tables.save(KEY, ARRAYS)
    sound = tables.path(KEY).read_bytes()
    for position in range(len(sound)):
        damaged = bytearray(sound)
        damaged[position] ^= 0x10
        tables.path(KEY).write_bytes(damaged)
        assert tables.load(KEY) is None, position
    tables.path(KEY).write_bytes(sound)
    assert tables.load(KEY) is not None


def test_truncations_are_noticed(tables):
    tables.save(KEY, ARRAYS)
    sound = tables.path(KEY).read_bytes()
    for size in range(0, len(sound), 7):
        tables.path(KEY).write_bytes(sound[:size])
        assert tables.load(KEY) is None, size
    tables.path(KEY).write_bytes(sound + b"more")
    assert tables.load(KEY) is None


def test_older_format_is_noticed(tables, monkeypatch):
    monkeypatch.setattr(cache, "FORMAT_VERSION", 0)
    tables.save(KEY, ARRAYS)
    monkeypatch.undo()
    assert tables.load(KEY) is None


def test_file_of_another_key_is_noticed(tables):
    other = TableCache.key("other")
    tables.save(other, ARRAYS)
    tables.path(other).rename(tables.path(KEY))
    assert tables.load(KEY) is None


def test_a_folder_that_cannot_be_is_no_error(tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert not TableCache(tmp_path / "file" / "below").save(KEY, ARRAYS)


def test_folder_from_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv(cache.FOLDER_VARIABLE, str(tmp_path))
    assert TableCache().folder == tmp_path
    monkeypatch.delenv(cache.FOLDER_VARIABLE)
    assert "shadowatmo" in str(TableCache().folder)
