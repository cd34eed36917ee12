"""What the command lines share: values typed by people, and errors in one line on stderr.

An error says what, where, what was expected and what was got, and the remedy; a traceback comes with --debug only.
"""

import argparse
import logging
import os
import re
import shutil
import sys
import time
import traceback

from shadowatmo.errors import ShadowAtmoError

FAILED, MISUSED = 1, 2  # exit statuses: something asked for was not done; the command line was wrong
INTERRUPTED = 130
BAR_AFTER = 0.5  # s of work before a progress bar appears: what is shorter would only flicker
BAR_CELLS = 30
EXTRAS = {"matplotlib": "report"}  # package: the extra that brings it; the others come with "demo"


class Parser(argparse.ArgumentParser):
    """An argument parser whose errors are one line."""

    def error(self, message):
        """Print the message and where to read more; exit with status 2."""
        self.exit(MISUSED, f"{self.prog}: {' '.join(str(message).split())}; see `{self.prog} --help`\n")


def size(text) -> tuple[int, int]:
    """Return (width, height) of "1283x719"."""
    match = re.fullmatch(r"\s*(\d{1,6})\s*[xX]\s*(\d{1,6})\s*", text)
    if not match or not all(int(n) > 0 for n in match.groups()):
        raise argparse.ArgumentTypeError(f"expected WIDTHxHEIGHT in pixels, as in 1283x719, got {text!r}")
    return int(match[1]), int(match[2])


def numbers(text) -> tuple[float, float, float]:
    """Return three numbers of "1,2.5,-3e6"."""
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) != 3:
        raise argparse.ArgumentTypeError(f"expected three numbers X,Y,Z without blanks, got {text!r}")
    return values


def names(text) -> list[str]:
    """Return the names of "a,b"."""
    found = [part.strip() for part in text.split(",") if part.strip()]
    if not found:
        raise argparse.ArgumentTypeError(f"expected NAME or NAME,NAME, got {text!r}")
    return found


def has_display(environment=None, platform=None) -> bool:
    """Return whether a window can be expected to open: always but on a Linux without X or Wayland."""
    environment = os.environ if environment is None else environment
    if not (platform or sys.platform).startswith("linux"):
        return True
    return bool(environment.get("DISPLAY") or environment.get("WAYLAND_DISPLAY"))


class ProgressBar:
    """A bar on one line of a terminal, for work that is long enough to wonder about; erased when it ends.

    Call it as bar(label, done, total) after each step; leaving it as a context manager erases what an error left.

    Parameters
    ----------
    stream : text file, optional
        stderr without one. Nothing is written where it is no terminal.
    wait : callable, optional
        Called before the clock is read, so that steps that were only queued count when they are done.
    clock : callable
        Seconds.
    """

    def __init__(self, stream=None, wait=None, clock=time.perf_counter):
        self._stream = sys.stderr if stream is None else stream
        self._is_terminal = bool(getattr(self._stream, "isatty", bool)())
        self._wait, self._clock = wait, clock
        self._start, self._done, self._width = None, 0, 0

    def __call__(self, label, done, total):
        """Take the end of step `done` of `total`."""
        if not self._is_terminal:
            return
        if self._wait is not None:
            self._wait()
        now = self._clock()
        if self._start is None or done <= self._done:
            self._start = now
        self._done = done
        if done >= total:
            self._start = None
            self.erase()
        elif now - self._start >= BAR_AFTER:
            filled = BAR_CELLS * done // total
            text = f"[{'#' * filled}{'.' * (BAR_CELLS - filled)}] {done}/{total} {label}"[: terminal_columns() - 1]
            self._write(text.ljust(self._width))
            self._width = len(text)

    def erase(self) -> None:
        """Blank the line, if there is anything on it."""
        if self._width:
            self._write(" " * self._width)
            self._write("")
            self._width = 0

    def _write(self, text):
        self._stream.write(f"\r{text}")
        self._stream.flush()

    def __enter__(self) -> "ProgressBar":
        return self

    def __exit__(self, *exception) -> None:
        self.erase()


def terminal_columns() -> int:
    """Return the width of the terminal, in letters."""
    return shutil.get_terminal_size().columns


def run(program, command, debug=False) -> int:
    """Call `command()` and return its exit status; say on stderr, in one line, why it failed.

    Parameters
    ----------
    program : str
        Name that the line begins with.
    command : callable
        Returns an exit status, or None for 0.
    debug : bool
        Print the traceback too.
    """
    level = logging.INFO if debug else logging.ERROR  # warnings are said in the output proper, where they matter
    logging.basicConfig(level=level, format=f"{program}: %(message)s")
    try:
        status = command() or 0
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the interpreter complains on its way out
        return FAILED
    except Exception as error:
        if debug:
            traceback.print_exc()
        print(f"{program}: {explain(error)}", file=sys.stderr)
        return FAILED


def explain(error) -> str:
    """Return one line for an exception that the user should be able to act on."""
    text = " ".join(str(error).split())
    if isinstance(error, ShadowAtmoError):
        return text
    if isinstance(error, ModuleNotFoundError):
        extra = EXTRAS.get(error.name, "demo")
        remedy = f"run `make setup`, or `pip install -e '.[{extra}]'` with this Python"
        return f"the package {error.name} is missing; {remedy}"
    if isinstance(error, OSError) and error.filename is not None:
        return f"cannot use {error.filename}: {error.strerror}; give another path, or mend its permissions"
    return f"{type(error).__name__}: {text}; this is a fault of the program: run again with --debug and report it"
