"""The renderer: plans the passes that a scene needs, runs them in order, and hands out the frame."""

from contextlib import ExitStack

import numpy as np

from shadowatmo.cache import TableCache
from shadowatmo.camera import Camera
from shadowatmo.eclipse_multiple import RATIO_RECIPES
from shadowatmo.errors import ParameterError, PassError
from shadowatmo.multiple_recipes import RECIPES
from shadowatmo.passes.adaptive import AdaptiveComposite
from shadowatmo.passes.atmosphere import AtmosphereComposite
from shadowatmo.passes.atmosphere_back_depth import AtmosphereBackDepth
from shadowatmo.passes.canvas import Canvas, color_mask, draws_into, has_dual_source, host_canvas, shares
from shadowatmo.passes.cone_depth import ConeDepth
from shadowatmo.passes.eclipse import Eclipse
from shadowatmo.passes.eclipse_multiple import EclipseMultiple
from shadowatmo.passes.eclipse_view import EclipseView
from shadowatmo.passes.frame import Frame
from shadowatmo.passes.gl.context import check_alive
from shadowatmo.passes.gl.functions import gl_functions
from shadowatmo.passes.gl.state import preserve_state
from shadowatmo.passes.gl.textures import check_size
from shadowatmo.passes.multiple import MultipleScattering
from shadowatmo.passes.multiple_view import MultipleView
from shadowatmo.passes.planet import Planet
from shadowatmo.passes.planning import composite_name, make_plan, warn_of_approximations
from shadowatmo.passes.shadow_back_depth import ShadowBackDepth
from shadowatmo.passes.shadow_front_depth import ShadowFrontDepth
from shadowatmo.passes.sun_visibility import SunVisibility
from shadowatmo.passes.table4d_view import Table4DView
from shadowatmo.passes.table_probe import make_table, method_orders
from shadowatmo.passes.tables import TableKeeper
from shadowatmo.passes.tonemap import Tonemap
from shadowatmo.passes.transmittance import TransmittanceTable
from shadowatmo.passes.view import View
from shadowatmo.passes.widths import Field, Widths, check_convention
from shadowatmo.plan import Plan
from shadowatmo.quality import Quality, as_quality
from shadowatmo.scene import Scene
from shadowatmo.validation import instance, integer, number


class Renderer:
    """Draws a scene through its atmosphere.

    Parameters
    ----------
    ctx : moderngl.Context
        A live context, the host's own; nothing but its objects made here is released by `close`.
    scene : Scene
        What is drawn. May be replaced between frames by assigning `scene`.
    size : (int, int)
        Width and height of the frames [pixels], from 1x1 to the driver's limit.
    quality : Quality or str
        Method and effort.
    cache : bool or TableCache
        Keep precomputed tables on disk: True for the user's cache folder, False for not at all.
    progress : callable, optional
        Called as progress(label, done, total) while a table is computed.
    table_budget : float, optional
        Seconds that one frame may spend on computing tables, > 0. Until a table is ready frames do without it, or with
        the one for the air before. None: the first frame waits.

    Raises
    ------
    ParameterError
        If an argument is malformed. ContextError if the context is gone or has no memory for the frame.
    """

    def __init__(
        self, ctx, scene, size=(1280, 720), quality="balanced", *, cache=True, progress=None, table_budget=None
    ):
        check_alive(ctx)
        instance("cache", cache, (bool, TableCache), "True, False or a TableCache")
        self._cache = TableCache() if cache is True else cache or None
        self._progress = progress
        self._table_budget = table_budget and number("table_budget", table_budget, low=0, open_low=True, high=1e6)
        self.ctx = ctx
        self._quality = as_quality(quality)
        self.size = check_size(ctx, size)
        self.frame_number = 0
        self._passes, self._closed, self._blends = {}, False, has_dual_source(ctx)
        self.scene = scene
        with preserve_state(ctx):
            try:
                self._make_passes()
            except BaseException:
                self.close()
                raise

    @property
    def scene(self) -> Scene:
        """The scene that the next frame shows."""
        return self._scene

    @scene.setter
    def scene(self, scene):
        instance("scene", scene, Scene, "a Scene")
        before, self._scene = getattr(self, "_scene", None), scene
        if before == scene:
            return
        warn_of_approximations(scene, self.quality)
        if before is None:
            return
        if before.surface != scene.surface:
            self._release("planet")
        with preserve_state(self.ctx):
            self._make_passes()

    @property
    def quality(self) -> Quality:
        """Method and effort; another one needs another renderer."""
        return self._quality

    def _make_passes(self):
        depth_format = "d32f" if self.quality.depth_bits == 32 else "d24"
        makers = {
            "transmittance": lambda: TransmittanceTable(self.ctx),
            "table3d": self._make_inscatter,
            "table4d": self._make_inscatter,
            "table4d_view": lambda: Table4DView(self.ctx),
            "multiple": self._make_multiple,
            "multiple_view": lambda: MultipleView(self.ctx, self.size),
            "eclipse": lambda: Eclipse(self.ctx),
            "eclipse_multiple": self._make_eclipse_multiple,
            "eclipse_view": lambda: EclipseView(self.ctx, self.size),
            "shadow_back_depth": lambda: ShadowBackDepth(self.ctx, self.size, depth_format),
            "shadow_front_depth": lambda: ShadowFrontDepth(self.ctx, self.size, depth_format),
            "planet": lambda: Planet(self.ctx, self.size, depth_format, self.scene.surface),
            "atmosphere_back_depth": lambda: AtmosphereBackDepth(self.ctx, self.size, depth_format),
            "widths": lambda: Widths(self.ctx, self.size),
            "atmosphere": lambda: AtmosphereComposite(self.ctx, self.size),
            "adaptive": lambda: AdaptiveComposite(self.ctx, self.size, self._blends),
        }
        for step in self.plan.steps:
            if step.name not in self._passes:
                self._passes[step.name] = makers[step.name]()

    def _make_multiple(self):
        def table():
            return MultipleScattering(self.ctx, RECIPES[self.quality.multiple])

        return TableKeeper(self.ctx, table, self._cache, self._progress, self._table_budget)

    def _make_eclipse_multiple(self):
        effort = self.quality.multiple
        return EclipseMultiple(self.ctx, RATIO_RECIPES[effort], RECIPES[effort])

    def _make_inscatter(self):
        method, orders = self.quality.method, method_orders(self.quality)

        def table():
            return make_table(self.ctx, method, orders)

        return TableKeeper(self.ctx, table, self._cache, self._progress, self._table_budget)

    @property
    def plan(self) -> Plan:
        """The passes that `render` runs, each with its reason, and what was left out and why."""
        return make_plan(self.scene, self.quality, self._blends)

    def render(self, camera) -> Frame:
        """Draw the scene as the camera sees it and return the frame.

        Raises
        ------
        ParameterError
            If `camera` is no Camera. PassError after `close`; ContextError if the context is gone.
        """
        return self._frame(camera, {})

    def compose(self, color, depth, camera, target=None) -> Frame:
        """Put a host's picture behind the atmosphere.

        Parameters
        ----------
        color, depth : moderngl.Texture or int
            The host's linear color and its depth, of the renderer's size; an int is the name of an OpenGL texture of
            that size. `camera.depth` says how the depth is to be read.
        camera : Camera
            The one that the host drew with.
        target : moderngl.Framebuffer, optional
            Also draw the composed linear color into it. Its size must be the renderer's. Where its color is `color`
            itself, alpha stays the host's, and with a tolerance above 0 the air is blended into what is there: nothing
            is copied, and pixels without air keep every bit.

        Raises
        ------
        ParameterError
            If a texture has another size, or the depth's kind does not go with its convention. Nothing is drawn then.
        """
        textures = {
            "background": self._host_texture("color", color, 4, False),
            "host_depth": self._host_texture("depth", depth, 1, None),
        }
        instance("camera", camera, Camera, "a Camera")
        check_convention(textures["host_depth"], camera.depth)
        if target is not None and tuple(target.size) != self.size:
            raise ParameterError("target", f"size {tuple(target.size)}", f"a framebuffer of size {self.size}")
        return self._frame(camera, textures, target)

    def sun_visibility(self, depth, camera, sun=0):
        """Return how much of a sun is left on the surfaces of a host's depth, as a texture.

        Parameters
        ----------
        depth : moderngl.Texture or int
            As in `compose`, of the renderer's size; `camera.depth` says how it is to be read.
        camera : Camera
            The one that the host drew with.
        sun : int
            Which of the scene's suns.

        Returns
        -------
        moderngl.Texture
            One 32-bit float channel, in [0, 1], without the air: moons, rings and the planet's own shadow, that of a
            parallel sun. 1 where the host drew nothing. It is the renderer's; the next call draws into it again.
        """
        self._check_open()
        instance("camera", camera, Camera, "a Camera")
        star = self.scene.suns[integer("sun", sun, low=0, high=len(self.scene.suns) - 1)]
        textures = {"host_depth": self._host_texture("depth", depth, 1, None)}
        check_convention(textures["host_depth"], camera.depth)
        view = View(self.scene, self.quality, camera, self.size)
        with preserve_state(self.ctx):
            if "eclipse" in self._passes:
                self._passes["eclipse"].draw(self.scene, textures)
            if "sun_visibility" not in self._passes:
                self._passes["sun_visibility"] = SunVisibility(self.ctx, self.size)
            self._passes["sun_visibility"].draw(view, textures, star)
        return textures["sun_visibility"]

    def cone_depths(self, camera, sun=0) -> tuple:
        """Return where pixels' rays are in the shadow cones of the occluders whose penumbra reaches the air.

        Parameters
        ----------
        camera : Camera
            Whose rays.
        sun : int
            Which of the scene's suns.

        Returns
        -------
        tuple of passes.cone_depth.ConeDepths
            One for each occluder; its textures are the renderer's until the next call.
        """
        self._check_open()
        instance("camera", camera, Camera, "a Camera")
        star, textures = self.scene.suns[integer("sun", sun, low=0, high=len(self.scene.suns) - 1)], {}
        with preserve_state(self.ctx):
            if "cone_depth" not in self._passes:
                self._passes["cone_depth"] = ConeDepth(self.ctx, self.size)
            self._passes["cone_depth"].draw(View(self.scene, self.quality, camera, self.size), textures, star)
        return textures["cone_depths"]

    def _host_texture(self, name, texture, components, is_depth):
        """Return a host's texture as a moderngl one, of the right size."""
        check_alive(self.ctx)
        if isinstance(texture, (int, np.integer)) and not isinstance(texture, bool):
            return self.ctx.external_texture(int(texture), self.size, components, 0, "f4")
        size = getattr(texture, "size", None)
        if size is None or not hasattr(texture, "use"):
            raise ParameterError(name, texture, f"a moderngl.Texture or the name of a GL texture, of size {self.size}")
        if tuple(size) != self.size:
            raise ParameterError(name, f"a texture of size {tuple(size)}", f"a texture of size {self.size}")
        return texture

    def _frame(self, camera, textures, target=None) -> Frame:
        self._check_open()
        instance("camera", camera, Camera, "a Camera")
        view = View(self.scene, self.quality, camera, self.size)
        with preserve_state(self.ctx), ExitStack() as stack:
            textures = dict(textures)
            if target is not None and self._composite.blends and draws_into(self.ctx, target, textures["background"]):
                textures["canvas"] = stack.enter_context(host_canvas(self.ctx, textures["background"]))
            textures = self._run(view, textures)
            if textures.pop("canvas", None) is not None and target is not None:
                textures["composed"] = textures.pop("color")
            elif target is not None:
                self._copy(textures["color"], target, keeps_alpha=shares(self.ctx, target, textures["background"]))
        self.frame_number += 1
        return Frame(self, self.frame_number, textures)

    def _run(self, view, textures) -> dict:
        """Draw all passes of a view and return every texture by name."""
        composed, composite = "host_depth" in textures, self._composite
        self._view, in_view = view, view.air_window is not None
        for name in ("transmittance", "table3d", "table4d", "multiple"):
            if name in self._passes:
                self._passes[name].draw(self.scene.atmosphere, textures)
        if "eclipse" in self._passes:
            self._passes["eclipse"].draw(self.scene, textures)
        if "eclipse_multiple" in self._passes:
            self._passes["eclipse_multiple"].draw(self.scene, textures)
        if "planet" in self._passes and not composed:
            if self.scene.surface is not None and composite.blends:
                textures["canvas"] = composite.canvas
            self._passes["planet"].draw(view, textures)
            if "planet_color" in textures:
                textures["background"] = textures["planet_color"]
        if "atmosphere_back_depth" in self._passes:
            self._passes["atmosphere_back_depth"].draw(view, textures)
        # The first sun comes last, so that the textures of widths that remain are its own.
        for place, sun in enumerate(reversed(self.scene.suns)):
            for name in ("shadow_back_depth", "shadow_front_depth"):
                if name in self._passes:
                    self._passes[name].draw(view, textures, sun)
            window = view.windows(sun)[0] or (0, 0, 0, 0)
            if "widths" in self._passes:
                self._passes["widths"].draw(view, textures, sun, window)
            if "table4d_view" in self._passes and in_view:
                self._passes["table4d_view"].draw(view, textures, sun)
            if "eclipse_view" in self._passes and in_view:
                self._passes["eclipse_view"].draw(view, textures, sun)
            if "multiple_view" in self._passes and in_view and "multiple_table" in textures:
                self._passes["multiple_view"].draw(view, textures, sun, RECIPES[self.quality.multiple])
            composite.draw(view, textures, sun, first=place == 0)
        if window != (0, 0, *self.size):
            textures.pop("cuts", None)  # it holds a part of the frame
        return textures

    @property
    def _composite(self):
        return self._passes[composite_name(self.quality)]

    def _copy(self, texture, framebuffer, keeps_alpha=False):
        framebuffer.use()
        if keeps_alpha:
            gl_functions(self.ctx).ColorMask(*color_mask(framebuffer)[:3], False)
        self._composite.fullscreen("copy.frag", {}, {}, {"u_color": texture})

    def field(self, name, textures):
        """Return the texture of a field of the frame just drawn: "depth", "lit_width" or "shadow_width".

        "color" where it was composed in place.
        """
        self._check_open()
        with preserve_state(self.ctx):
            if name == "color":
                if "composed" not in self._passes:
                    self._passes["composed"] = Canvas(self.ctx, self.size)
                self._copy(textures["composed"], self._passes["composed"].framebuffer)
                return self._passes["composed"].color
            if "cuts" not in textures:  # pass 5 went without
                if "late_widths" not in self._passes:
                    self._passes["late_widths"] = Widths(self.ctx, self.size)
                self._passes["late_widths"].draw(self._view, textures, self._view.scene.suns[0])
            if name not in self._passes:
                self._passes[name] = Field(self.ctx, self.size, name)
            return self._passes[name].draw(textures)

    def read_texture(self, texture) -> np.ndarray:
        """Return a texture's contents as float32 (h, w, channels), row 0 at the top."""
        self._check_open()
        with preserve_state(self.ctx):
            data = np.frombuffer(texture.read(alignment=1), np.float32)
        return data.reshape(self.size[1], self.size[0], -1)[::-1]

    def tonemapped(self, color, exposure) -> np.ndarray:
        """Return a linear color texture as display values, uint8 (h, w, 3), row 0 at the top."""
        self._check_open()
        with preserve_state(self.ctx):
            if "tonemap" not in self._passes:
                self._passes["tonemap"] = Tonemap(self.ctx, self.size)
            tonemap = self._passes["tonemap"]
            tonemap.draw({"color": color}, exposure)
            data = np.frombuffer(tonemap.target.color[0].read(alignment=1), np.uint8)
        return np.ascontiguousarray(data.reshape(self.size[1], self.size[0], 4)[::-1, :, :3])

    def _check_open(self):
        if self._closed:
            raise PassError("this renderer is closed; make a new one")
        check_alive(self.ctx)

    def _release(self, name):
        if name in self._passes:
            self._passes.pop(name).release()

    def close(self) -> None:
        """Release everything that the renderer made; a second call does nothing."""
        if self._closed:
            return
        # No state guard here: OpenGL itself unbinds what is deleted, and a guard would bind the dead names again.
        self._closed, self.frame_number = True, -1
        for name in list(self._passes):
            self._release(name)

    def __enter__(self) -> "Renderer":
        return self

    def __exit__(self, *exception) -> None:
        self.close()
