"""Contexts: which device is taken, what is said when there is none, and what a released one does."""

import subprocess
import sys
from pathlib import Path

import moderngl
import pytest

from shadowatmo.errors import ContextError, ParameterError, PassError, ShaderError, ShadowAtmoError
from shadowatmo.passes.gl import context as context_module
from shadowatmo.passes.gl.context import (
    check_alive,
    context_store,
    describe_context,
    explain_failure,
    is_software,
    open_context,
)

ROOT = Path(__file__).resolve().parent.parent


class FakeBackend:
    """Stands in for `moderngl.create_context`; a device is a renderer name, or an exception it raises."""

    def __init__(self, *devices):
        self.devices = devices
        self.alive = []
        self.most_alive = 0

    def __call__(self, require, standalone, backend=None, device_index=0):
        if device_index >= len(self.devices):
            raise Exception(f"requested device index {device_index}, but found {len(self.devices)} devices")
        device = self.devices[device_index]
        if isinstance(device, Exception):
            raise device
        self.alive.append(device)
        self.most_alive = max(self.most_alive, len(self.alive))
        return FakeContext(self, device)


class FakeContext:
    def __init__(self, backend, renderer):
        self.backend = backend
        self.info = {"GL_RENDERER": renderer, "GL_VERSION": "4.5"}

    def release(self):
        self.backend.alive.remove(self.info["GL_RENDERER"])


@pytest.fixture
def devices(monkeypatch):
    """Install a fake machine with the given devices."""

    def install(*names):
        backend = FakeBackend(*names)
        monkeypatch.setattr(context_module.moderngl, "create_context", backend)
        monkeypatch.setattr(context_module.sys, "platform", "linux")
        monkeypatch.delenv("GLCONTEXT_DEVICE_INDEX", raising=False)
        return backend

    return install


BROKEN = Exception("eglInitialize failed (0x3001)")


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["llvmpipe (LLVM 15)"], "llvmpipe (LLVM 15)"),
        (["llvmpipe (LLVM 15)", "NVIDIA H200"], "NVIDIA H200"),
        (["NVIDIA A", "NVIDIA B", "llvmpipe"], "NVIDIA A"),
        ([BROKEN, "llvmpipe", "softpipe"], "llvmpipe"),
        ([BROKEN, "llvmpipe", "AMD Radeon"], "AMD Radeon"),
    ],
)
def test_hardware_comes_first(devices, names, expected):
    backend = devices(*names)
    assert open_context().info["GL_RENDERER"] == expected
    assert backend.alive == [expected]  # every other one was released
    assert backend.most_alive == 1  # and never were two alive at once


def test_no_usable_device_says_why(devices):
    devices(BROKEN, BROKEN)
    with pytest.raises(ContextError, match=r"eglInitialize failed \(0x3001\).*libgl1-mesa-dri"):
        open_context()


def test_a_chosen_device_is_taken_as_it_is(devices):
    devices("llvmpipe", "NVIDIA H200")
    assert open_context(device=0).info["GL_RENDERER"] == "llvmpipe"
    with pytest.raises(ContextError, match="found 2 devices.*leave `device` out"):
        open_context(device=2)


@pytest.mark.parametrize(
    ("raw", "remedy"),
    [
        ("libEGL.so.1 not loaded", "apt-get install -y libegl1"),
        ("Cannot find OpenGL support library libEGL", "apt-get install -y libegl1"),
        ("requested device index 0, but found 0 devices", "NVIDIA_DRIVER_CAPABILITIES=graphics"),
        ("requested device index 3, but found 1 devices", "leave `device` out"),
        ("eglInitialize failed (0x3001)", "libgl1-mesa-dri"),
        ("eglCreateContext failed (0x3009)", "version is too low"),
        ("Requested OpenGL version 460, got version 450", "version is too low"),
        ("something never seen", "something never seen; run `python -m shadowatmo check`"),
        ("", "python -m shadowatmo check"),
    ],
)
def test_every_raw_failure_has_a_remedy(raw, remedy):
    message = explain_failure(raw)
    assert remedy in message
    assert "\n" not in message
    assert raw in message  # the driver's own words are kept for the bug report


@pytest.mark.parametrize(
    ("kwargs", "name"),
    [
        ({"require": 210}, "require"),
        ({"require": 3.3}, "require"),
        ({"require": True}, "require"),
        ({"device": -1}, "device"),
        ({"device": "0"}, "device"),
        ({"device": True}, "device"),
    ],
)
def test_bad_arguments(kwargs, name):
    with pytest.raises(ParameterError, match=name) as info:
        open_context(**kwargs)
    assert info.value.name == name
    assert info.value.value == kwargs[name]
    assert info.value.allowed in str(info.value)


def test_errors_share_one_base():
    for kind in (ContextError, ShaderError, PassError, ParameterError):
        assert issubclass(kind, ShadowAtmoError)
    assert issubclass(ParameterError, ValueError)


def test_software_renderers_are_known():
    assert is_software("llvmpipe (LLVM 15.0.6, 256 bits)")
    assert is_software("Google SwiftShader")
    assert not is_software("NVIDIA H200/PCIe/SSE2")
    assert not is_software("AMD Radeon RX 580")


def test_describe(ctx):
    about = describe_context(ctx)
    assert about["renderer"] == ctx.info["GL_RENDERER"]
    assert about["version_code"] >= 330
    assert about["max_texture_size"] >= 1024  # OpenGL 3.3 guarantees that much
    assert about["clip_control"] or about["version_code"] < 450


@pytest.mark.parametrize("thing", [None, "ctx", 3])
def test_not_a_context(thing):
    with pytest.raises(ContextError, match="expected a moderngl.Context"):
        check_alive(thing)


def test_store_lives_with_the_context(ctx):
    check_alive(ctx)
    assert context_store(ctx) is context_store(ctx)


SCRIPT = """
from shadowatmo.errors import ContextError
from shadowatmo.passes.gl.context import check_alive, describe_context, open_context
ctx = open_context()
renderer = describe_context(ctx)["renderer"]
ctx.release()
for call in (check_alive, describe_context):
    try:
        call(ctx)
    except ContextError as error:
        assert "released" in str(error), error
    else:
        raise SystemExit("a released context passed " + call.__name__)
again = open_context()
assert describe_context(again)["renderer"] == renderer
print("done")
"""


def test_released_context_is_refused_and_a_new_one_works(ctx):
    """In a process of its own, for a second context beside the session's could upset the driver."""
    assert isinstance(ctx, moderngl.Context)
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], cwd=ROOT, capture_output=True, text=True, timeout=60
    )
    assert done.stdout.strip() == "done", done.stderr
