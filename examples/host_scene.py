"""A host's own triangle, 20 km wide and 60 km away, seen through the air: python examples/host_scene.py [picture.png].

The host draws linear color and depth as it always did (here reversed depth, 32-bit float) and hands both textures over.
"""

import math
import sys

import numpy as np

import shadowatmo as sa
from shadowatmo.passes.gl.textures import Target  # a framebuffer with 32-bit depth; yours may come from anywhere

SIZE, NEAR = (960, 540), 1.0
ctx = sa.open_context()
scene = sa.Scene(suns=sa.Sun(direction=(0.3, 0.2, 0.9)), surface=None, sun_disc=True)
camera = sa.Camera(
    position=(0, 0, scene.atmosphere.bottom_radius + 4e3),
    forward=(1, 0, 0.02),
    vertical_fov=math.radians(40),
    depth=sa.DepthConvention("reversed", near=NEAR),
)
host = ctx.program(
    vertex_shader="#version 330 core\nin vec4 clip; void main() { gl_Position = clip; }",
    fragment_shader="#version 330 core\nout vec4 color; void main() { color = vec4(0.04, 0.008, 0.004, 1.0); }",
)
right, up, forward = camera.basis()
tan_x, tan_y = camera.tangents(SIZE)
corners = np.array([[-1e4, -4e3, 6e4], [1e4, -4e3, 6e4], [0.0, 8e3, 6e4]])  # right, up, forward [m]
# window depth near / z, with OpenGL's clip range of -1..1
clip = [[x / tan_x, y / tan_y, (2 * NEAR / z - 1) * z, z] for x, y, z in corners]
with Target(ctx, SIZE, color=("rgba16f",), depth="d32f") as picture, sa.Renderer(ctx, scene, SIZE) as renderer:
    picture.framebuffer.clear(depth=0.0)
    picture.framebuffer.use()
    ctx.enable(ctx.DEPTH_TEST)
    ctx.depth_func = "1"
    ctx.vertex_array(host, [(ctx.buffer(np.array(clip, "f4").tobytes()), "4f", "clip")]).render()
    frame = renderer.compose(picture.color[0], picture.depth, camera)
    frame.image().save(sys.argv[1] if len(sys.argv) > 1 else "host_scene.png")
