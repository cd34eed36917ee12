"""Precomputed tables of a renderer: kept while the air stays the same, read from disk, or computed in slices."""

import time

from shadowatmo.passes.base import RenderPass


class TableKeeper(RenderPass):
    """The finished tables of one kind for the air of the last frame.

    While a table for new air is being computed in slices, the old one goes on serving; before the first is ready there
    is none.

    Parameters
    ----------
    ctx : moderngl.Context
    make : callable
        Returns a new table pass: with `key`, `steps`, `restore`, `arrays`, `textures` and `release`, see
        passes/multiple.py.
    cache : TableCache, optional
        Where finished tables are kept on disk.
    progress : callable, optional
        Called as progress(label, done, total) after every step of a computation.
    budget : float, optional
        Seconds that a frame may spend on a table; None: until it is finished.
    """

    def __init__(self, ctx, make, cache=None, progress=None, budget=None):
        super().__init__(ctx, (1, 1))
        self._make, self._cache, self._progress, self.budget = make, cache, progress, budget
        self._ready, self._ready_for = None, None
        self._pending, self._pending_for, self._steps, self._done = None, None, [], 0

    def draw(self, atmosphere, textures):
        """Put the textures of the table for `atmosphere` into `textures`, or of the one before while it is computed."""
        if atmosphere != self._ready_for:
            if atmosphere != self._pending_for:
                self._start(atmosphere)
            if self._pending is not None:
                self._advance()
        elif self._pending is not None:
            self._drop_pending()
        if self._ready is not None:
            textures |= self._ready.textures

    def _start(self, atmosphere):
        self._drop_pending()
        table = self._make()
        found = self._cache.load(table.key(atmosphere)) if self._cache is not None else None
        if found is not None:
            table.restore(atmosphere, found)
            self._take(table, atmosphere)
        else:
            self._pending, self._pending_for = table, atmosphere
            self._steps, self._done = table.steps(atmosphere), 0

    def _advance(self):
        """Run steps until the table is finished or the frame's time is up; one step at least."""
        end = None if self.budget is None else time.perf_counter() + self.budget
        for label, run in self._steps[self._done :]:
            run()
            self._done += 1
            if self._progress is not None:
                self._progress(label, self._done, len(self._steps))
            if end is not None:
                self.ctx.finish()  # or the work would be billed to a later frame
                if time.perf_counter() >= end:
                    break
        if self._done == len(self._steps):
            table, atmosphere = self._pending, self._pending_for
            self._pending, self._pending_for, self._steps = None, None, []
            if self._cache is not None:
                self._cache.save(table.key(atmosphere), table.arrays())
            self._take(table, atmosphere)

    def _take(self, table, atmosphere):
        if self._ready is not None:
            self._ready.release()
        self._ready, self._ready_for = table, atmosphere

    def _drop_pending(self):
        if self._pending is not None:
            self._pending.release()
        self._pending, self._pending_for, self._steps = None, None, []

    def release(self):
        super().release()
        self._drop_pending()
        if self._ready is not None:
            self._ready.release()
        self._ready, self._ready_for = None, None
