"""Imports run one way, the model needs no OpenGL, and the files stay of a readable size."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
MODEL, PASSES = sorted((ROOT / "shadowatmo").glob("*.py")), sorted((ROOT / "passes").rglob("*.py"))


def imported_at_top(path):
    """Names of the modules that a file imports when it is imported itself."""
    names = set()
    for node in ast.parse(path.read_text("utf-8")).body:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add(node.module or ".")
    return names


@pytest.mark.parametrize("path", MODEL, ids=lambda p: p.name)
def test_model_does_not_know_what_draws(path):
    forbidden = ("moderngl", "shadowatmo.passes", "passes", "tests")
    assert not [name for name in imported_at_top(path) if name.startswith(forbidden)]


@pytest.mark.parametrize("path", PASSES, ids=lambda p: p.name)
def test_passes_import_absolutely(path):
    forbidden = ("passes", "shaders", "tests", "demo", "")
    assert not [name for name in imported_at_top(path) if name.split(".")[0] in forbidden]


def test_the_check_sees_an_import():
    assert "moderngl" in imported_at_top(ROOT / "passes" / "gl" / "textures.py")


def test_import_needs_no_opengl():
    code = "import sys; import shadowatmo, shadowatmo.reference; sys.exit('moderngl' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT).returncode == 0


def test_files_stay_readable():
    shaders = [p for p in (ROOT / "shaders").iterdir() if p.suffix in (".glsl", ".frag", ".vert")]
    long = {p.name: n for p in [*MODEL, *PASSES, *shaders] if (n := len(p.read_text("utf-8").splitlines())) > 400}
    assert not long


def test_no_double_precision_in_shaders():
    words = {w for p in (ROOT / "shaders").glob("*.*") for w in p.read_text("utf-8").replace("(", " ").split()}
    assert not words & {"double", "dvec2", "dvec3", "dvec4", "dmat3", "dmat4"}
