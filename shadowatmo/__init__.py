"""The deferred atmosphere: a scene with depth goes in, the same scene with a physically right atmosphere comes out.

The physics (parameters, scene, camera, the float64 twin `reference`) needs no OpenGL. What draws (`open_context`,
`Renderer`, `probe`) is loaded when it is first asked for.
"""

from importlib import import_module
from pathlib import Path

_root = Path(__file__).resolve().parent.parent  # a checkout has passes/ and shaders/ beside us, a wheel inside us
if (_root / "pyproject.toml").is_file() and (_root / "passes").is_dir():
    __path__.insert(0, str(_root))

from shadowatmo.camera import Camera  # noqa: E402  (the path above must stand first)
from shadowatmo.depth import DepthConvention  # noqa: E402
from shadowatmo.errors import ContextError, ParameterError, PassError, ShaderError, ShadowAtmoError  # noqa: E402
from shadowatmo.parameters import Atmosphere, Occluder, Sun, TentLayer  # noqa: E402
from shadowatmo.presets import DENSE_EARTH, EARTH, MARS, THIN_EARTH, TITAN, TOY_PLANET  # noqa: E402
from shadowatmo.quality import Quality  # noqa: E402
from shadowatmo.ring import Ring  # noqa: E402
from shadowatmo.scene import Scene  # noqa: E402
from shadowatmo.surface import Surface  # noqa: E402

__version__ = "0.1.0"

_LAZY = {  # public name -> module that needs OpenGL, or is large
    "open_context": "shadowatmo.passes.gl.context",
    "probe": "shadowatmo.passes.probe",
    "Renderer": "shadowatmo.passes.pipeline",
    "Frame": "shadowatmo.passes.frame",
    "sun_visibility": "shadowatmo.eclipse",
    "visible_sun": "shadowatmo.sunlit",
    "Sky": "shadowatmo.ephemeris",
    "sky_at": "shadowatmo.ephemeris",
    "contacts": "shadowatmo.ephemeris",
    "visibility_source": "shadowatmo.passes.sun_visibility",
    "reference": None,  # a module itself
}

__all__ = [
    "DENSE_EARTH", "EARTH", "MARS", "THIN_EARTH", "TITAN", "TOY_PLANET", "Atmosphere", "Camera", "ContextError",
    "DepthConvention", "Frame", "Occluder", "ParameterError", "PassError", "Quality",
    "Renderer", "Ring", "Scene", "ShaderError", "ShadowAtmoError", "Sky", "Sun", "Surface", "TentLayer",
    "contacts", "open_context", "probe", "reference", "sky_at", "sun_visibility", "visibility_source",
    "visible_sun",
]  # fmt: skip


def __getattr__(name):
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = _LAZY[name]
    value = import_module(f"shadowatmo.{name}") if module is None else getattr(import_module(module), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *_LAZY})
