"""Proxy meshes: closed convex volumes that cover every pixel whose ray can meet a shape. They give coverage, not depth.

A polygon inside a circle misses its rim, so the proxies stand around their shapes; only the published variant, whose
depth is the rasterized one, puts the vertices on the shape itself.
"""

import moderngl
import numpy as np

from shadowatmo.passes.gl.shader import build_program, set_uniforms

SEGMENTS = 256
MARGIN = 1.002  # also covers what float32 does to vertices


def cone_mesh(cone, axis, reach, circumscribed=True) -> np.ndarray:
    """Return triangles (n, 3, 3) [m], counter-clockwise from outside, around a shadow cone about `axis` (3,).

    The volume is cut at `reach` [m] from the center: nothing beyond the top of the air matters. Planet-centered.
    """
    grow = MARGIN / np.cos(np.pi / SEGMENTS) if circumscribed else 1.0
    near = cone.near - ((MARGIN - 1.0) * cone.radius if circumscribed else 0.0)
    far = min(cone.far, reach * MARGIN)
    z = np.array([near, far])
    radii = np.maximum(cone.width(z), 0.0) * grow
    angle = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    side, other = _perpendicular(axis)
    circle = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * other
    rings = [radius * circle + height * axis for radius, height in zip(radii, z, strict=True)]
    return _closed_surface(rings, [near * axis, far * axis])


def sphere_mesh(radius, circumscribed=True) -> np.ndarray:
    """Return triangles (n, 3, 3) [m], counter-clockwise from outside, around a sphere about the planet's center."""
    rows = SEGMENTS // 2
    grow = MARGIN / np.cos(np.pi / SEGMENTS) ** 2 if circumscribed else 1.0
    angle = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros(SEGMENTS)], axis=1)
    latitudes = np.pi * (np.arange(1, rows) / rows - 0.5)
    pole = np.array([0.0, 0.0, 1.0])
    rings = [radius * grow * (np.cos(b) * circle + np.sin(b) * pole) for b in latitudes]
    return _closed_surface(rings, [-radius * grow * pole, radius * grow * pole])


def _perpendicular(axis):
    """Return two unit vectors that complete `axis` to a right-handed frame."""
    side = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    side /= np.linalg.norm(side)
    return side, np.cross(axis, side)


def _closed_surface(rings, ends) -> np.ndarray:
    """Join rings of points along an axis and close both ends with fans."""
    faces = []
    for lower, upper in zip(rings[:-1], rings[1:], strict=True):
        a, b, c, d = lower, np.roll(lower, -1, axis=0), np.roll(upper, -1, axis=0), upper
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    first, last = rings[0], rings[-1]
    faces.append(np.stack([np.roll(first, -1, axis=0), first, np.broadcast_to(ends[0], first.shape)], axis=1))
    faces.append(np.stack([last, np.roll(last, -1, axis=0), np.broadcast_to(ends[1], last.shape)], axis=1))
    return np.concatenate(faces)


def contains(mesh, point) -> bool:
    """Whether a point (3,) [m] lies inside a convex mesh, or within float32's doubt of its faces."""
    a, b, c = mesh[:, 0], mesh[:, 1], mesh[:, 2]
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    solid = lengths > 0.0
    heights = np.einsum("ij,ij->i", normals[solid], point - a[solid]) / lengths[solid]
    doubt = 1e-5 * float(np.abs(mesh).max()) + 1e-6 * float(np.linalg.norm(point))
    return bool(np.all(heights < doubt))


class Proxy:
    """A mesh on the GPU, rebuilt only when its `key` changes."""

    def __init__(self, ctx):
        self.ctx = ctx
        self.mesh, self._key, self._buffer, self._arrays = None, None, None, {}

    def update(self, key, make_mesh) -> None:
        """Upload what `make_mesh()` returns, unless `key` is the one of the last call."""
        if key == self._key:
            return
        self.release()
        self.mesh, self._key = make_mesh(), key
        self._buffer = self.ctx.buffer(np.ascontiguousarray(self.mesh, np.float32).tobytes())

    def draw(self, fragment, defines, uniforms, view, faces) -> None:
        """Draw the "front" or "back" faces with an entry shader into the bound framebuffer.

        Where the camera is inside the proxy no front face is in view; the back faces then give the coverage of both
        sides. Not so in the published variant, whose depth is the faces' own: there the cleared depth stands.
        """
        program = build_program(self.ctx, fragment, vertex="proxy.vert", defines=defines)
        set_uniforms(program, {**uniforms, "u_to_clip": view.to_clip})
        if program not in self._arrays:
            self._arrays[program] = self.ctx.vertex_array(program, [(self._buffer, "3f", "in_position")])
        inside = view.quality.depth_bits == 32 and contains(self.mesh, view.position)
        self.ctx.enable(moderngl.CULL_FACE)
        self.ctx.cull_face = "back" if faces == "front" and not inside else "front"
        self._arrays[program].render(moderngl.TRIANGLES)
        self.ctx.disable(moderngl.CULL_FACE)

    def release(self) -> None:
        """Release the buffer and its vertex arrays."""
        for array in self._arrays.values():
            array.release()
        if self._buffer is not None:
            self._buffer.release()
        self.mesh, self._key, self._buffer, self._arrays = None, None, None, {}
