"""The limb by day, rendered without a window: python examples/headless.py [picture.png]."""

import math
import sys

import shadowatmo as sa

scene = sa.Scene(suns=sa.Sun(direction=(1.0, 0.3, 0.0)), surface=sa.Surface.earth(), sun_disc=True)
camera = sa.Camera(
    position=(-1.9e6, 6.6e6, 5e5), forward=(1.0, -0.02, 0.05), up=(0, 1, 0), vertical_fov=math.radians(50)
)
with sa.Renderer(sa.open_context(), scene, size=(960, 540)) as renderer:
    renderer.render(camera).image().save(sys.argv[1] if len(sys.argv) > 1 else "limb.png")
    print(renderer.plan)
