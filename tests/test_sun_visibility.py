"""The visible sun for a host: over its depth as a texture, and as GLSL in its own shader, both against the twin."""

import moderngl
import numpy as np
import pytest

import shadowatmo as sa

RADIUS = sa.EARTH.bottom_radius
SUN = sa.Sun(direction=(0.9, 0.1, 0.3))
OTHER = sa.Sun(direction=(-0.2, 1.0, 0.1))
TO_SUN = np.array(SUN.direction)
MOONS = (sa.Occluder(3.7e8 * TO_SUN + (0, 1e6, 0), 1.7374e6), sa.Occluder(4.5e8 * TO_SUN + (0, 2.5e6, 4e5), 2e6))
RING = sa.Ring((0, 0, 0), (0, 0, 1), 9e6, 1.2e7, 0.8)
DISC = sa.Sun(direction=SUN.direction, disc_at_terminator=True)
EDGE = np.cross(SUN.direction, (0, 0, 1)) / np.linalg.norm(np.cross(SUN.direction, (0, 0, 1)))  # of day and night
SETTING = {  # as seen from there; the moon covers the upper half
    "a setting disc": sa.Scene(suns=DISC),
    "a moon before it": sa.Scene(suns=DISC, occluders=sa.Occluder(3.7e8 * TO_SUN + (RADIUS + 9e5) * EDGE, 1.7374e6)),
}
SCENES = {
    "moons and a ring": sa.Scene(suns=(SUN, OTHER), occluders=MOONS, rings=RING),
    "a ring": sa.Scene(suns=SUN, rings=RING),
    "nothing": sa.Scene(suns=SUN),
}
DISTANCES = sa.DepthConvention("distance")
CAMERA = sa.Camera(position=2.2e7 * TO_SUN, target=(0, 0, 0), vertical_fov=0.7, depth=DISTANCES)
SIZE = (161, 91)


def globe(camera, height=1e3):
    """Directions (N, 3) of the pixels and distances (N,) to a globe above the ground [m]; nan where there is none."""
    directions = camera.pixel_rays(SIZE).reshape(-1, 3)
    b = directions @ np.array(camera.position)
    below = b * b - np.dot(camera.position, camera.position) + (RADIUS + height) ** 2
    distance = np.where(below > 0, -b - np.sqrt(np.maximum(below, 0)), np.nan)
    return directions, distance


@pytest.mark.parametrize("name", SCENES)
def test_texture_over_a_hosts_depth(ctx, name):
    scene = SCENES[name]
    camera = CAMERA
    directions, distance = globe(camera)
    data = np.nan_to_num(distance, nan=np.inf).astype(np.float32).reshape(SIZE[::-1])[::-1]
    depth = ctx.texture(SIZE, 1, data.tobytes(), dtype="f4")
    with sa.Renderer(ctx, scene, SIZE, sa.Quality(depth="analytic", orders=1)) as renderer:
        for sun in range(len(scene.suns)):
            found = renderer.read_texture(renderer.sun_visibility(depth, camera, sun)).ravel()
            points = np.array(camera.position) + np.nan_to_num(distance)[:, None] * directions
            expected = np.where(np.isnan(distance), 1.0, sa.visible_sun(scene, points, sun))
            # the terminator's step takes a pixel either way; the rest is the table
            error = np.abs(found - expected)
            assert np.isfinite(found).all() and np.mean(error > 2e-3) < 2e-3
            assert expected.min() < 0.5 or name == "nothing"
        with pytest.raises(sa.ParameterError):
            renderer.sun_visibility(depth, camera, sun=5)
        with pytest.raises(sa.ParameterError):
            renderer.sun_visibility(ctx.texture((3, 3), 1, dtype="f4"), camera)
    depth.release()


def in_a_hosts_shader(ctx, scene, points):
    """Run a host's shader over (4096, 3) points; return the source and what it found."""
    source = sa.visibility_source(ctx, scene)
    places = ctx.texture((64, 64), 3, points.astype(np.float32).tobytes(), dtype="f4")
    fragment = "uniform sampler2D u_points; out float visible; void main() { "
    fragment += "visible = visible_sun(texelFetch(u_points, ivec2(gl_FragCoord.xy), 0).xyz); }"
    corner = "ivec2(gl_VertexID % 2, gl_VertexID / 2) * 4 - 1"
    vertex = f"#version 330 core\nvoid main() {{ gl_Position = vec4({corner}, 0, 1); }}"
    program = ctx.program(vertex_shader=vertex, fragment_shader="#version 330 core\n" + source.text + fragment)
    source.apply(program)
    places.use(5)
    program["u_points"].value = 5
    target = ctx.framebuffer(color_attachments=[ctx.texture((64, 64), 1, dtype="f4")])
    target.use()
    ctx.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    return source, np.frombuffer(target.read(components=1, dtype="f4"), np.float32)


@pytest.mark.parametrize("name", SCENES)
def test_glsl_in_a_hosts_shader(ctx, rng, name):
    scene = SCENES[name]
    points = rng.normal(size=(4096, 3))
    points *= (RADIUS + rng.uniform(0, 6e4, (4096, 1))) / np.linalg.norm(points, axis=1)[:, None]
    source, found = in_a_hosts_shader(ctx, scene, points)
    assert "#version" not in source.text and "#line" not in source.text and "u_sun_angle" not in source.text
    assert ("u_overlaps" in source.textures) == (name == "moons and a ring")
    error = np.abs(found - sa.visible_sun(scene, points))
    # where a ring's edge and a moon stand before the sun at once, shaders multiply their fractions
    assert np.mean(error > 2e-3) < 2e-3 and error.max() < 0.1
    source.release()


@pytest.mark.parametrize("name", SETTING)
def test_a_disc_sets_bit_by_bit(ctx, rng, name):
    """A host's surface in the band where the limb cuts the disc: twin, texture over depth, and GLSL."""
    scene, flat = SETTING[name], sa.Scene(suns=SUN, occluders=SETTING[name].occluders)
    camera = sa.Camera(position=(RADIUS + 2e5) * EDGE, target=(0, 0, 0), vertical_fov=0.5, depth=DISTANCES)
    directions, distance = globe(camera, height=10.0)
    points = np.array(camera.position) + distance[:, None] * directions
    expected = sa.visible_sun(scene, points)
    assert np.mean((expected > 0.02) & (expected < 0.98)) > 0.2 and expected.min() == 0.0
    assert np.abs(expected - sa.visible_sun(flat, points)).max() > 0.2  # which a hard limb misses
    depth = ctx.texture(SIZE, 1, distance.astype(np.float32).reshape(SIZE[::-1])[::-1].tobytes(), dtype="f4")
    with sa.Renderer(ctx, scene, SIZE, sa.Quality(depth="analytic", orders=1)) as renderer:
        found = renderer.read_texture(renderer.sun_visibility(depth, camera)).ravel()
    assert np.isfinite(found).all() and np.abs(found - expected).max() < 8e-3  # 16 strips leave 0.006 of a moon
    depth.release()
    chosen = points[rng.integers(0, len(points), 4096)].astype(np.float32)
    source, found = in_a_hosts_shader(ctx, scene, chosen)
    # planet-centered metres in 32 bits: half a metre of height is 4e-4 rad of dip at most, 4 % of the disc
    error = np.abs(found - sa.visible_sun(scene, chosen.astype(float)))
    assert error.max() < 0.03 and np.percentile(error, 95) < 0.01
    source.release()


def test_visible_sun_rejects_what_it_cannot_read():
    for bad in (np.nan, np.zeros((3, 2))):
        with pytest.raises(sa.ParameterError, match="points"):
            sa.visible_sun(SCENES["nothing"], bad)
    with pytest.raises(sa.ParameterError, match="sun"):
        sa.visible_sun(SCENES["nothing"], (RADIUS, 0, 0), sun=1)


def test_a_moved_moon_moves_the_texture(ctx):
    camera = CAMERA
    _, distance = globe(camera)
    data = np.nan_to_num(distance, nan=np.inf).astype(np.float32).reshape(SIZE[::-1])[::-1]
    depth = ctx.texture(SIZE, 1, data.tobytes(), dtype="f4")
    with sa.Renderer(ctx, sa.Scene(suns=SUN, occluders=MOONS[0]), SIZE, sa.Quality(orders=1)) as renderer:
        first = renderer.read_texture(renderer.sun_visibility(depth, camera))
        renderer.scene = sa.Scene(suns=SUN, occluders=MOONS[1])
        second = renderer.read_texture(renderer.sun_visibility(depth, camera))
        renderer.scene = sa.Scene(suns=SUN)
        third = renderer.read_texture(renderer.sun_visibility(depth, camera))
    assert np.abs(first - second).max() > 0.1 and third.min() == 1.0
    depth.release()
