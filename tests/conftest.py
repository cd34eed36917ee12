"""One OpenGL context for the whole run, a seeded generator, and no GL error left behind by any test."""

import os

import numpy as np
import pytest

from shadowatmo.errors import ContextError

SEED = 20261122
CONTEXT = pytest.StashKey()


def pytest_collection_modifyitems(items):
    """Whatever asks for the context is a GPU test."""
    for item in items:
        if "ctx" in getattr(item, "fixturenames", ()):
            item.add_marker("gpu")


@pytest.fixture(scope="session")
def ctx(request):
    """The one headless context: two in a process are asking for trouble.

    Without OpenGL the test fails and says the remedy, so that green never means that nothing ran; -m "not gpu" leaves
    out what needs it.
    """
    from shadowatmo.passes.gl.context import open_context

    try:
        context = open_context()
    except ContextError as error:
        pytest.fail(str(error), pytrace=False)
    request.session.stash[CONTEXT] = context
    yield context
    del request.session.stash[CONTEXT]
    context.release()


@pytest.fixture(autouse=True, scope="module")
def _no_programs_kept(request):
    """Programs are released after each file: a software renderer keeps megabytes of machine code for every one."""
    yield
    context = request.node.session.stash.get(CONTEXT, None)
    if context is not None:
        from shadowatmo.passes.gl.shader import release_programs

        release_programs(context)


@pytest.fixture(autouse=True)
def _no_gl_error(request):
    context = request.getfixturevalue("ctx") if "ctx" in request.fixturenames else None
    if context is not None:
        context.clear_errors()
    yield
    if context is not None:
        error = context.error
        assert error == "GL_NO_ERROR", f"the test left {error} behind"


@pytest.fixture
def rng():
    """A generator with a fixed seed, fresh for each test."""
    return np.random.default_rng(SEED)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A function that writes shader files into the folder the loader reads: a_frag="..." writes a.frag."""
    from shadowatmo.passes.gl.source import read_shader

    vertex = read_shader("fullscreen.vert")
    monkeypatch.setenv("SHADOWATMO_SHADER_DIR", str(tmp_path))

    def write(**files):
        for name, text in files.items():
            stem, _, suffix = name.rpartition("_")
            (tmp_path / f"{stem}.{suffix}").write_text(text)

    write(fullscreen_vert=vertex)
    return write


@pytest.fixture
def glsl(ctx, tmp_path, monkeypatch):
    """Run lines of GLSL on arrays, see tests/glsl_runner.py."""
    from tests.glsl_runner import GlslRunner

    runner = GlslRunner(ctx, tmp_path)
    monkeypatch.setenv("SHADOWATMO_SHADER_DIR", str(runner.folder))
    return runner


@pytest.fixture(autouse=True, scope="session")
def _own_cache(tmp_path_factory):
    """Tables are kept in a folder of this run: no test sees what an earlier one left."""
    before = os.environ.get("SHADOWATMO_CACHE_DIR")
    os.environ["SHADOWATMO_CACHE_DIR"] = str(tmp_path_factory.mktemp("cache"))
    yield
    if before is None:
        del os.environ["SHADOWATMO_CACHE_DIR"]
    else:
        os.environ["SHADOWATMO_CACHE_DIR"] = before
