"""A host's own shader asks how much of the sun it sees: python examples/host_eclipse.py [picture.png].

A plain blue globe, drawn by ray tracing in the host's fragment shader, in the shadows of two moons and of rings.
"""

import sys

import moderngl
import numpy as np
from PIL import Image

import shadowatmo as sa

SIZE, RADIUS = (960, 540), sa.EARTH.bottom_radius
to_sun = np.array([0.94, 0.02, 0.34])
moons = [sa.Occluder(3.66e8 * to_sun + (0, s, 1.5e6 + 0.4 * s), 1.74e6) for s in (0.4e6, 1.8e6)]
ring = sa.Ring((0, 0, 0), normal=(0, 0, 1), inner_radius=1.5 * RADIUS, outer_radius=1.9 * RADIUS, optical_depth=1.0)
scene = sa.Scene(suns=sa.Sun(direction=to_sun), occluders=moons, rings=ring)
ctx = sa.open_context()
source = sa.visibility_source(ctx, scene)  # .text declares float visible_sun(vec3 point)
globe = """
in vec2 at;
out vec4 color;
uniform float u_radius;
void main() {
  vec2 p = at * vec2(16.0 / 9.0, 1.0) * 1.15;
  vec3 up = vec3(sqrt(max(1.0 - dot(p, p), 0.0)), p.x, p.y);  // seen from the direction of x, far away
  float light = visible_sun(up * u_radius) * max(dot(up, u_planet.xyz), 0.0);
  color = vec4(dot(p, p) < 1.0 ? sqrt(light * vec3(0.15, 0.35, 0.8)) : vec3(0.0, 0.0, 0.02), 1.0);
}"""
vertex = """#version 330 core
out vec2 at;
void main() { at = vec2(gl_VertexID % 2, gl_VertexID / 2) * 4.0 - 1.0; gl_Position = vec4(at, 0.0, 1.0); }"""
program = ctx.program(vertex_shader=vertex, fragment_shader="#version 330 core\n" + source.text + globe)
program["u_radius"] = RADIUS
source.apply(program)
target = ctx.simple_framebuffer(SIZE)
target.use()
ctx.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
pixels = np.frombuffer(target.read(components=3), np.uint8).reshape(*SIZE[::-1], 3)
Image.fromarray(pixels[::-1]).save(sys.argv[1] if len(sys.argv) > 1 else "host_eclipse.png")
