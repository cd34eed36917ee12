"""The cold start of one quality, measured in a process of its own: `python -m shadowatmo.passes.cold_start '{...}'`.

Prints JSON: CPU seconds and wall seconds from the interpreter's start to the end of the first frame. Neither the tables
that are kept on disk nor the driver's own shader cache help, so it is what a new user waits for.
"""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

NO_SHADER_CACHE = {
    "MESA_SHADER_CACHE_DISABLE": "true",
    "MESA_GLSL_CACHE_DISABLE": "true",  # its name before Mesa 20
    "__GL_SHADER_DISK_CACHE": "0",  # NVIDIA
}
TIMEOUT = 300.0  # s


def cold_start(changes, size) -> dict:
    """Return {"cpu": s, "wall": s} of a first frame with a quality's `changed_fields`, by a new process."""
    root = Path(__file__).resolve().parent.parent  # a checkout, or the package's folder inside site-packages
    root = root.parent if (root / "reference.py").is_file() else root
    paths = [str(root), *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = {**os.environ, **NO_SHADER_CACHE, "PYTHONPATH": os.pathsep.join(paths)}
    line = [sys.executable, "-m", "shadowatmo.passes.cold_start", json.dumps(changes), *map(str, size)]
    start = time.perf_counter()
    done = subprocess.run(line, env=environment, capture_output=True, text=True, timeout=TIMEOUT, check=True)
    return {**json.loads(done.stdout), "wall": time.perf_counter() - start}


def main(changes, width, height):
    """Draw one frame and print what it took."""
    import shadowatmo
    from shadowatmo.candidates import from_fields
    from shadowatmo.report_rays import CAMERAS, SUN

    ctx = shadowatmo.open_context()
    scene, size = shadowatmo.Scene(suns=SUN), (int(width), int(height))
    with shadowatmo.Renderer(ctx, scene, size, from_fields(json.loads(changes)), cache=False) as renderer:
        renderer.render(next(iter(CAMERAS.values()))).numpy()
    print(json.dumps({"cpu": time.process_time()}))


if __name__ == "__main__":
    main(*sys.argv[1:])
