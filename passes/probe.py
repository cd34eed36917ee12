"""Rays in, arrays out: the libraries of the composite pass evaluated for single rays.

Distances and everything that the air and the shadow axes need of a ray are taken to its entry into the air in float64
here (shadowatmo.ray, shadowatmo.shadow); from there on the shaders do in float32 what they do for a pixel.
"""

import numpy as np

from shadowatmo import shadow
from shadowatmo.eclipse_multiple import RATIO_RECIPES
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.passes.constants import (
    air_uniforms,
    cone_uniforms,
    medium_defines,
    medium_uniforms,
    segment_defines,
    segment_uniforms,
    transmittance_defines,
)
from shadowatmo.passes.eclipse import Eclipse, eclipse_inputs
from shadowatmo.passes.eclipse_multiple import EclipseMultiple, ratio_inputs
from shadowatmo.passes.gl.context import context_store
from shadowatmo.passes.gl.shader import Fullscreen, bind_textures, build_program, set_uniforms
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.march import march_light
from shadowatmo.passes.multiple import (
    MultipleScattering,
    multiple_defines,
    multiple_samplers,
    multiple_uniforms,
    path_defines,
)
from shadowatmo.passes.planning import warn_of_approximations
from shadowatmo.passes.table_probe import TABLE_METHODS, table_light
from shadowatmo.passes.tables import TableKeeper
from shadowatmo.passes.terminator import night_uniforms, terminator_defines, terminator_uniforms
from shadowatmo.passes.terminator_moons import terminator_moons_inputs
from shadowatmo.passes.transmittance import TransmittanceTable, table_samplers
from shadowatmo.quality import as_quality
from shadowatmo.ray import ray_from_points
from shadowatmo.rays import ProbeResult, Rays
from shadowatmo.segments import gap_nodes_for, nodes_for

ENDS = np.array(["miss", "top", "ground", "t_max"])  # by the code that probe.frag writes
COLUMNS = 1024  # rays side by side in the textures that carry them
NO_LIMIT = 3e38  # m, what inf becomes in float32


def probe(ctx, scene, origins, directions, t_max=None, quality="accurate") -> ProbeResult:
    """Evaluate rays with the shaders of the composite pass.

    Parameters
    ----------
    ctx : moderngl.Context
        A live context; its state is left as it was.
    scene : Scene
        Air, suns and occluders; the surface does not matter, the ground has the atmosphere's albedo.
    origins, directions : (N, 3) float
        Starting points [m] and directions (normalized here).
    t_max : (N,) float, optional
        Distance at which something solid ends each ray [m], >= 0, inf for nothing.
    quality : Quality or str
        Method and effort.

    Returns
    -------
    ProbeResult
        `multiple` and `ground_multiple` hold the orders that `quality.orders` asks for beyond the first.

    Raises
    ------
    ParameterError
        If an input is malformed or not finite.
    ContextError
        If the context has been released.
    """
    quality = as_quality(quality)
    rays = Rays.validated(origins, directions, t_max)
    warn_of_approximations(scene, quality)
    with preserve_state(ctx):
        return _Probe(ctx, scene, rays, quality).run()


def multiple_scattering(ctx, recipe) -> TableKeeper:
    """Return the context's own keeper of the table of one recipe: probing twice in the same air computes it once."""
    keepers = context_store(ctx).setdefault("probe_tables", {})
    if recipe not in keepers:
        keepers[recipe] = TableKeeper(ctx, lambda: MultipleScattering(ctx, RECIPES[recipe]))
    return keepers[recipe]


def eclipse_multiple(ctx, recipe) -> EclipseMultiple:
    """Return the context's own volumes of ratios of one recipe, likewise."""
    keepers = context_store(ctx).setdefault("probe_ratios", {})
    if recipe not in keepers:
        keepers[recipe] = EclipseMultiple(ctx, RATIO_RECIPES[recipe], RECIPES[recipe])
    return keepers[recipe]


class _Probe:
    """One call of `probe`: the textures that carry its rays, and what was read back."""

    def __init__(self, ctx, scene, rays, quality):
        self.ctx, self.scene, self.rays, self.quality = ctx, scene, rays, quality
        self.count = len(rays)
        self.size = (max(1, min(self.count, COLUMNS)), max(1, -(-self.count // COLUMNS)))
        self.ray = ray_from_points(scene.atmosphere, rays.origins, rays.directions)
        self.base = rays.origins + self.ray.start[:, None] * rays.directions
        self.hit = self.ray.air >= 0.0
        self.tables, self.eclipse = {}, Eclipse(ctx)
        self.textures = [self.eclipse]

    def run(self) -> ProbeResult:
        table = None
        try:
            if self.quality.column_table:
                table = TransmittanceTable(self.ctx)
                table.draw(self.scene.atmosphere, self.tables)
            radiometry = [self._radiometry(sun) for sun in self.scene.suns]
            ends, first = radiometry[0][1], radiometry[0]
            end_distance = first[0][:, 3].astype(np.float64)
            shadow_length = first[2][:, 3].astype(np.float64)
            planet = self._lengths(end_distance, np.zeros(3), self.scene.atmosphere.bottom_radius)
            moons = [self._lengths(end_distance, np.array(o.center), o.radius) for o in self.scene.occluders]
        finally:
            for resource in (*self.textures, *([table] if table else [])):
                resource.release()
        moons = np.stack(moons, axis=1) if moons else np.zeros((self.count, 0, 3))
        scattered = [[r[i][:, :3] if len(r) > i else np.zeros((self.count, 3)) for i in range(5)] for r in radiometry]
        irradiance = [np.array(sun.irradiance) for sun in self.scene.suns]
        nowhere = np.where(self.hit, 0.0, np.nan)

        def total(index):
            return sum(s[index] * e for s, e in zip(scattered, irradiance, strict=True))

        return ProbeResult(
            t_in=self.ray.start + nowhere,
            t_out=self.ray.start + self.ray.air + nowhere,
            t_end=self.ray.start + end_distance + nowhere,
            end=ENDS[np.rint(ends[:, 3]).astype(int)],
            transmittance=first[0][:, :3].astype(np.float64),
            single=total(1),
            multiple=total(3),
            ground_direct=total(2),
            ground_multiple=total(4),
            lit=end_distance - shadow_length,
            shadow=shadow_length,
            planet_umbra=planet[:, 0],
            planet_penumbra=planet[:, 2] + planet[:, 1],
            umbra=moons[:, :, 0],
            antumbra=moons[:, :, 1],
            penumbra=moons[:, :, 2],
        )

    def _texture(self, *columns):
        """Upload up to four arrays (N,) as the channels of a texture of rays."""
        data = np.zeros((self.size[0] * self.size[1], 4), np.float32)
        for channel, values in enumerate(columns):
            data[: self.count, channel] = np.clip(values, -NO_LIMIT, NO_LIMIT)
        texture = self.ctx.texture(self.size, 4, data.tobytes(), dtype="f4")
        self.textures.append(texture)
        return texture

    def _axis_textures(self, axis, extra=None):
        columns = (axis.impact, axis.rim) if extra is None else (axis.impact, axis.rim, extra)
        return {"u_axis": self._texture(axis.z, axis.dz, axis.across, axis.drift), "u_limits": self._texture(*columns)}

    def _draw(self, fragment, defines, uniforms, textures, outputs):
        """Draw all rays and return the outputs, each (N, 4) float32."""
        program = build_program(self.ctx, fragment, defines=defines)
        set_uniforms(program, uniforms)
        bind_textures(program, textures)
        draw = Fullscreen(self.ctx, program)
        with Target(self.ctx, self.size, color=("rgba32f",) * outputs) as target:
            target.framebuffer.use()
            draw.draw()
            result = [target.read_color(i).reshape(-1, 4)[: self.count] for i in range(outputs)]
        draw.release()
        return result

    def _radiometry(self, sun):
        """Return what probe.frag writes for one sun."""
        atmosphere, quality, ray = self.scene.atmosphere, self.quality, self.ray
        axis = shadow.axis_ray(
            self.base, self.rays.directions, -np.array(sun.direction), np.zeros(3), atmosphere.bottom_radius
        )
        defines = {**medium_defines(atmosphere), **transmittance_defines(atmosphere, quality)}
        defines |= segment_defines(quality, atmosphere)
        uniforms = {**medium_uniforms(atmosphere), **segment_uniforms(atmosphere)}
        uniforms["u_ground_albedo"] = atmosphere.ground_albedo
        uniforms |= cone_uniforms("u_shadow", shadow.cylinder(atmosphere.bottom_radius))
        if sun.disc_at_terminator:
            defines |= terminator_defines(sun, quality)
            uniforms |= {**terminator_uniforms(sun), **night_uniforms(atmosphere, sun)}
        self.eclipse.draw(self.scene, self.tables)
        moons = eclipse_inputs(sun, self.tables)
        for part in (moons, terminator_moons_inputs(sun, self.tables)):
            defines |= part[0]
            uniforms |= part[1]
        textures = {"u_ray": self._texture(ray.x, ray.k, ray.tangent_k, ray.air)}
        textures |= self._axis_textures(axis, self.rays.t_max - ray.start)
        textures |= table_samplers(uniforms, self.tables)
        if moons[0]:
            textures |= moons[2]
            textures |= {"u_base": self._texture(*self.base.T), "u_direction": self._texture(*self.rays.directions.T)}
        if quality.method in TABLE_METHODS:
            found = self._draw("probe.frag", defines, uniforms, textures, 3)
            rays = self._ray_textures(textures, moons)
            single, *others = table_light(self.ctx, atmosphere, quality, self._draw, rays, moons)
            return [found[0], np.column_stack([single, found[1][:, 3]]), found[2], *others]
        if quality.orders == 1:
            found = self._draw("probe.frag", defines, uniforms, textures, 3)
            return self._marched(found, textures, moons) if quality.method == "march" else found
        recipe = RECIPES[quality.multiple]
        multiple_scattering(self.ctx, quality.multiple).draw(atmosphere, self.tables)
        counts = nodes_for(atmosphere, quality.nodes), gap_nodes_for(atmosphere, quality.gap_nodes)
        defines |= {**multiple_defines(recipe), **path_defines(*counts), "HAS_AUREOLE": True}
        uniforms |= multiple_uniforms(atmosphere)
        textures |= multiple_samplers(self.tables)
        eclipse_multiple(self.ctx, quality.multiple).draw(self.scene, self.tables)
        ratio = ratio_inputs(self.scene, sun, self.tables, RATIO_RECIPES[quality.multiple])
        if ratio[0]:
            uniforms["u_node_count"] = counts[0]
        defines, uniforms, textures = ({**a, **b} for a, b in zip((defines, uniforms, textures), ratio, strict=True))
        found = self._draw("probe.frag", defines, uniforms, textures, 5)
        return self._marched(found, textures, moons) if quality.method == "march" else found

    @staticmethod
    def _ray_textures(textures, moons):
        """Return the textures of the rays alone."""
        names = ("u_ray", "u_axis", "u_limits", *(("u_base", "u_direction") if moons[0] else ()))
        return {name: textures[name] for name in names}

    def _marched(self, found, textures, moons):
        """Put transmittance and single scattering of "march" into what probe.frag found."""
        size = {}
        table = table_samplers(size, self.tables), size
        rays = self._ray_textures(textures, moons)
        air = march_light(self.scene.atmosphere, self.quality, self._draw, rays, table, moons)
        return [np.column_stack([a[:, :3], f[:, 3]]) for a, f in zip(air, found, strict=False)] + found[2:]

    def _lengths(self, end_distance, center, radius):
        """Return lengths (N, 3) [m] in umbra, antumbra and penumbra of a sphere in the light of sun 0."""
        sun = self.scene.suns[0]
        offset = center - sun.distance * np.array(sun.direction)
        distance = float(np.linalg.norm(offset))
        axis = shadow.axis_ray(self.base, self.rays.directions, offset / distance, center, radius)
        uniforms = air_uniforms(self.scene.atmosphere)
        for name, cone in (
            ("u_umbra", shadow.umbra_cone(radius, sun.radius, distance)),
            ("u_antumbra", shadow.antumbra_cone(radius, sun.radius, distance)),
            ("u_outer", shadow.penumbra_cone(radius, sun.radius, distance)),
        ):
            uniforms |= cone_uniforms(name, cone)
        textures = {"u_ray": self._texture(self.ray.x, self.ray.k, self.ray.tangent_k, end_distance)}
        textures |= self._axis_textures(axis)
        return self._draw("lengths.frag", {}, uniforms, textures, 1)[0][:, :3].astype(np.float64)
