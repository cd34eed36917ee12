"""Frames by the 4D table: the table of one camera gives what lookups in all four axes give."""

import numpy as np
import pytest

import shadowatmo as sa
from shadowatmo.passes.table4d_view import Table4DView
from shadowatmo.passes.view import View
from tests.cameras import CAMERAS, SUN, level

SIZE = (48, 27)
SCENE = sa.Scene(suns=SUN)
QUALITY = sa.Quality(method="table4d", depth="analytic")
INSIDE = ("2 m, sunset", "2 m, twilight, away from the sun", "10 km, low sun", "59 km, dusk")


def probed(ctx, camera):
    """Return radiance (N, 3) of the pixels' rays by lookups in the whole table."""
    rays = camera.pixel_rays(SIZE).reshape(-1, 3)
    p = sa.probe(ctx, SCENE, np.broadcast_to(camera.position, rays.shape), rays, quality=QUALITY)
    return p.single + p.multiple


@pytest.mark.parametrize("name", [*INSIDE, "400 km, day"])
def test_a_frame_is_what_single_rays_are(ctx, name):
    camera = CAMERAS[name]
    with sa.Renderer(ctx, SCENE, SIZE, QUALITY, cache=False) as renderer:
        pixels = renderer.render(camera).numpy().reshape(-1, 3)
        moved = renderer.render(level(80, 2e4, 20, 5)).numpy().reshape(-1, 3)
    want = probed(ctx, camera)
    # the same mixture in another order, and a pixel's ray in float32 where a probe's begins in float64; measured 2.8e-5
    error = np.abs(pixels - want).max(axis=1) / want.max()
    assert error.max() < 1e-4
    assert np.percentile(np.abs(moved - want).max(axis=1) / want.max(), 99) > 0.02  # another camera's table


def test_only_cameras_inside_the_air_have_one(ctx):
    textures = {name: ctx.texture((1, 1), 4, dtype="f4") for name in ("inscatter", "inscatter_multiple")}
    render_pass = Table4DView(ctx)
    for name, inside in (("2 m, sunset", True), ("400 km, day", False)):
        render_pass.draw(View(SCENE, QUALITY, CAMERAS[name], SIZE), textures, SUN)
        assert ("view_inscatter" in textures) == inside
    for texture in (textures["inscatter"], textures["inscatter_multiple"], render_pass):
        texture.release()
