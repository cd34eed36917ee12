"""What the tests of the tables share: sets of rays, and the method's `scatter` run on them."""

import numpy as np

import shadowatmo as sa
from shadowatmo.passes.gl.shader import Fullscreen, bind_textures, build_program, set_uniforms
from shadowatmo.passes.gl.textures import Target
from shadowatmo.ray import ground_distance, ray_from_points
from shadowatmo.shadow import axis_ray, cone_interval, cylinder

# name -> altitudes [m], sun zenith angles [deg], t_max [m]
RAY_SETS = {
    "ground, day": ((2.0, 3e3), (0.0, 87.0), None),
    "ground, low sun": ((2.0, 3e3), (85.0, 92.0), None),
    "ground, twilight": ((2.0, 3e3), (92.0, 100.0), None),
    "limb": (None, (0.0, 110.0), None),
    "terrain cut": ((2.0, 3e3), (0.0, 87.0), (1e3, 1e5)),
}
ENTRY = """#version 330 core
#include "{library}"
uniform sampler2D u_ray;
uniform sampler2D u_sun;
uniform sampler2D u_cuts;
layout(location = 0) out vec4 out_radiance;
layout(location = 1) out vec4 out_transmittance;
void main() {{
  ivec2 texel = ivec2(gl_FragCoord.xy);
  vec4 a = texelFetch(u_ray, texel, 0);
  vec4 b = texelFetch(u_sun, texel, 0);
  Scattered air = scatter(Ray(a.x, a.y, a.z, 0.0, a.w), b.xy, b.z, texelFetch(u_cuts, texel, 0));
  out_radiance = vec4(air.radiance, 0.0);
  out_transmittance = vec4(air.transmittance, 0.0);
}}
"""


def make_rays(atmosphere, rng, name, count):
    """Return origins, directions, suns (N, 3) and t_max (N,) of a named set."""
    altitudes, zeniths, blocked = RAY_SETS[name]
    radius = atmosphere.bottom_radius
    zenith = np.radians(rng.uniform(*zeniths, count))
    suns = np.stack([np.sin(zenith), np.zeros(count), np.cos(zenith)], axis=1)
    azimuth = rng.uniform(0, 2 * np.pi, count)
    if altitudes is None:  # from 400 km, tangent between 1/60 and 5/6 of the air
        r, tangent = radius + 4e5 * radius / 6.36e6, radius + atmosphere.thickness * rng.uniform(0.02, 0.83, count)
        sine = tangent / r
        mu = -np.sqrt(1 - sine**2)
        origins = np.broadcast_to([0.0, 0.0, r], (count, 3))
    else:
        h = np.exp(rng.uniform(*np.log(altitudes), count))
        # half of them within 10 degrees of the horizontal
        elevation = np.where(rng.random(count) < 0.5, rng.uniform(-10, 10, count), rng.uniform(-90, 90, count))
        mu, sine = np.sin(np.radians(elevation)), np.cos(np.radians(elevation))
        origins = np.stack([0 * h, 0 * h, radius + h], axis=1)
    directions = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), mu], axis=1)
    t_max = np.full(count, np.inf) if blocked is None else np.exp(rng.uniform(*np.log(blocked), count))
    return origins, directions, suns, t_max


def cut_rays(atmosphere, origins, directions, suns, t_max):
    """Return the rays as `scatter` takes them: ray, sun height and cosine (N, 2), cuts (N, 4)."""
    ray = ray_from_points(atmosphere, origins, directions)
    base = origins + ray.start[:, None] * directions
    ground = ground_distance(ray)
    end = np.clip(np.minimum(np.where(ground >= 0, ground, ray.air), t_max - ray.start), 0.0, None)
    cuts = np.zeros((len(end), 4))
    for i in range(len(end)):
        axis = axis_ray(base[i : i + 1], directions[i : i + 1], -suns[i], np.zeros(3), atmosphere.bottom_radius)
        start, stop = cone_interval(axis, cylinder(atmosphere.bottom_radius))
        dark = np.clip(start[0], 0.0, end[i])
        cuts[i] = 0.0, dark, np.clip(stop[0], dark, end[i]), end[i]
    sun = np.stack([np.einsum("ij,ij->i", base, suns), np.einsum("ij,ij->i", directions, suns)], axis=1)
    return ray, sun, cuts


def looks_down(ray):
    """Return which rays meet the ground."""
    return (ray.tangent_k < 0) & (ray.x < 0)


def scatter_rays(glsl, library, ray, sun, cuts, uniforms, defines, samplers):
    """Return radiance and transmittance (N, 3) of the `scatter` of a shader library."""
    name = f"scatter_{library.replace('.glsl', '')}.frag"
    (glsl.folder / name).write_text(ENTRY.format(library=library))
    program = build_program(glsl.ctx, name, defines=defines)
    set_uniforms(program, uniforms)
    count = len(cuts)
    across = 1 - sun[:, 1] ** 2
    values = [np.stack([ray.x, ray.k, ray.tangent_k, ray.air], axis=1), np.column_stack([sun, across, across]), cuts]
    textures = [glsl.ctx.texture((count, 1), 4, v.astype(np.float32).tobytes(), dtype="f4") for v in values]
    bind_textures(program, {**samplers, "u_ray": textures[0], "u_sun": textures[1], "u_cuts": textures[2]})
    draw = Fullscreen(glsl.ctx, program)
    with Target(glsl.ctx, (count, 1), color=("rgba32f",) * 2) as target:
        target.framebuffer.use()
        draw.draw()
        result = [target.read_color(i).reshape(-1, 4)[:, :3].astype(float) for i in range(2)]
    for item in (draw, *textures):
        item.release()
    return result


def true_single(atmosphere, origins, directions, suns, t_max):
    """Return single scattering (N, 3) by the reference, ray by ray: each has a sun of its own."""
    return np.concatenate([
        sa.reference.probe(
            sa.Scene(atmosphere=atmosphere, suns=sa.Sun(direction=suns[i])), origins[i], directions[i], t_max[i]
        ).single
        for i in range(len(suns))
    ])  # fmt: skip


def relative_errors(got, truth):
    """Return |got - truth| / truth (N, 3), entries below 1e-4 of the set's brightest left out (nan)."""
    visible = truth > 1e-4 * truth.max()
    return np.where(visible, np.abs(got - truth) / np.where(visible, truth, 1.0), np.nan)
