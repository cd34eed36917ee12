"""The window of the viewer, by moderngl-window: events in, frames out; everything else is in viewer.py and controls.py.

moderngl-window is an extra (`pip install moderngl-window`); nothing but this module imports it.
"""

import logging

import moderngl_window
from moderngl_window.context.base import WindowConfig

from shadowatmo.controls import Controls, key_names
from shadowatmo.errors import ContextError
from shadowatmo.passes.gl.context import is_software
from shadowatmo.passes.viewer import Viewer

TITLE = "shadowatmo"
SIZE, SOFTWARE_SIZE = (1280, 720), (800, 450)  # a CPU that draws gets fewer pixels
TITLE_INTERVAL = 0.25  # s between two changes of the title


class ViewerWindow(WindowConfig):
    """Hands a window's events to the controls. `make_class` binds it to them and to a folder for pictures."""

    gl_version = (3, 3)
    title = TITLE
    resizable = True
    aspect_ratio = None
    samples = 0
    clear_color = None
    log_level = logging.ERROR
    controls: Controls
    folder: str

    def __init__(self, **settings):
        super().__init__(**settings)
        self.wnd.exit_key = None
        self.wnd.fullscreen_key = None
        self.viewer = Viewer(self.ctx, self.controls)
        self.names = key_names(self.wnd.keys)
        self._since_title = TITLE_INTERVAL

    def on_render(self, time, frame_time):
        """Draw a frame, and do what the controls want."""
        size = self.wnd.buffer_size
        if min(size) < 1:  # minimized
            return
        self.viewer.draw(self.wnd.fbo, size, max(frame_time, 0.0))
        self._since_title += frame_time
        if self._since_title >= TITLE_INTERVAL:
            self.wnd.title = f"{TITLE} | {self.controls.status()} | F1 help"
            self._since_title = 0.0
        if self.controls.wants_picture:
            self.controls.wants_picture = False
            print(f"saved {self.viewer.save_picture(self.folder)}", flush=True)
        if self.controls.wants_quit:
            self.wnd.close()

    def on_key_event(self, key, action, modifiers):
        """Hand a key on by its name."""
        name = self.names.get(key)
        if name is None:
            return
        if action == self.wnd.keys.ACTION_PRESS:
            self.controls.press(name)
        elif action == self.wnd.keys.ACTION_RELEASE:
            self.controls.release(name)

    def on_mouse_drag_event(self, x, y, dx, dy):
        """Hand a drag on, in picture heights."""
        states = self.wnd.mouse_states
        button = "left" if states.left and "shift" not in self.controls.held else "right"
        self.controls.drag(dx / max(self.wnd.height, 1), dy / max(self.wnd.height, 1), button)

    def on_mouse_scroll_event(self, x_offset, y_offset):
        """Hand the wheel on."""
        self.controls.wheel(y_offset)

    def on_iconify(self, iconified):
        """Forget held keys: their release may never be told."""
        self.controls.release_all()

    def on_close(self):
        """Release everything while the context is there."""
        self.viewer.close()


def make_class(controls, folder) -> type[ViewerWindow]:
    """Return the window's class for some controls; moderngl-window makes the instance."""
    return type("BoundViewerWindow", (ViewerWindow,), {"controls": controls, "folder": str(folder)})


def make_window(controls, folder, size=None, arguments=()):
    """Open the window and return its ViewerWindow; without a size it suits the renderer.

    Raises
    ------
    ContextError
        If no window, or no OpenGL 3.3 in it, can be had.
    """
    width, height = size or SIZE
    line = ["--size", f"{width}x{height}", *arguments]
    try:
        window = moderngl_window.create_window_config_instance(make_class(controls, folder), args=line)
    except Exception as error:  # window libraries raise exceptions of their own, of any class
        if isinstance(error, ContextError):
            raise
        text = " ".join(str(error).split()) or type(error).__name__
        remedy = "see that DISPLAY names a running display with OpenGL 3.3, or draw without: python demo.py --headless"
        raise ContextError(f"no window on this display: {text}; {remedy}") from error
    if size is None and is_software(window.ctx.info["GL_RENDERER"]):
        window.wnd.size = SOFTWARE_SIZE
    return window


def open_window(controls, folder, size=None) -> None:
    """Open the window and stay until it is closed."""
    moderngl_window.run_window_config_instance(make_window(controls, folder, size))
