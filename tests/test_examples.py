"""The examples run as a newcomer would run them, and their pictures show what they promise."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda p: p.stem)
def test_example_draws(ctx, tmp_path, example):
    picture = tmp_path / "picture.png"
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, example, picture], env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with Image.open(picture) as image:
        pixels = np.asarray(image).astype(int)
    assert pixels.shape == (540, 960, 3) and pixels.max() > 100
    blue = pixels[..., 2] > pixels[..., 0]
    assert blue.mean() > 0.2
    if example.stem == "host_scene":
        triangle, sky = pixels[250, 480], pixels[250, 200]
        assert triangle[0] / triangle[2] > 1.1 * sky[0] / sky[2]  # red through the veil of 60 km of air
