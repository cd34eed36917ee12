"""One OpenGL context for the whole run, a seeded generator, and a check that no test leaves a GL error behind."""

import os

import numpy as np
import pytest

from shadowatmo.errors import ContextError

SEED = 20261122


def pytest_collection_modifyitems(items):
    """Whatever asks for the context is a GPU test."""
    for item in items:
        if "ctx" in getattr(item, "fixturenames", ()):
            item.add_marker("gpu")


@pytest.fixture(scope="session")
def ctx():
    """The one headless context: two in a process are asking for trouble.

    Without OpenGL the test is skipped with the reason, or fails where SHADOWATMO_REQUIRE_GL=1 says that there must
    be one, so that green never means that nothing ran.
    """
    from shadowatmo.passes.gl.context import open_context

    try:
        context = open_context()
    except ContextError as error:
        if os.environ.get("SHADOWATMO_REQUIRE_GL") == "1":
            pytest.fail(str(error), pytrace=False)
        pytest.skip(str(error))
    yield context
    context.release()


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
