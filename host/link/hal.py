"""Where the tool is by LinuxCNC's HAL: a component whose pins a machine's own .hal file nets.

    loadusr -Wn triaxis triaxis watch .. --hal
    net x-pos => triaxis.x          float, in: where the tool is, in the frame of WORK.stl, in mm
    net y-pos => triaxis.y
    net z-pos => triaxis.z
    net tool <= iocontrol.0.tool-number => triaxis.tool          s32, in: which one is in the spindle
    net a-pos => triaxis.a          float, in: A, B, C in degrees, where the machine file has that axis
    net running <= halui.program.is-running => triaxis.running   bit, in: in a pause it is false, too
    net idle <= halui.program.is-idle => triaxis.idle            bit, in: true again at the end
    triaxis.go                      bit, out: what the last answer said, for people: no permission
    triaxis.full-speed              bit, out: the tool is beyond the zone of --slow, wherever it may be
    triaxis.quiet                   bit, out: and beyond that of --warn
    triaxis.beat                    bit, out: another with each answer, for HAL's component watchdog

A pin that nothing writes reads 0: until x, y, z, running, idle, those of a, b, c that turn, and tool where
the program has several tools, are netted, there is no position, and no go.
"""

import math
import sys
import threading
import time
from collections.abc import Collection
from fractions import Fraction
from importlib import import_module
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.host.motion.follow import Report
from triaxis.host.quantise import Vector, vector

NAME = "triaxis"
# Where Debian has LinuxCNC's modules; of its own Python alone.
_DEBIAN = "/usr/lib/python3/dist-packages"
# Until a position is read whole: the machine goes on meanwhile.
_READINGS = 1000
_LOOK_SECONDS = 0.005
# In which the pins are cleared, and the thread that does it ends, unless an interrupt has left it waiting.
_ENDS_SECONDS = 1.0
# What a position is read from.
_PLACE = "xyzabc"
# The pins that say that the tool is beyond one zone, and both.
_BEYOND = ("full-speed", "quiet")


def _hal() -> Any:
    """Import LinuxCNC's module; raise InputError where it is not there, or is of another Python."""
    sys.path.append(_DEBIAN)
    try:
        return import_module("hal")
    except ImportError as error:
        raise InputError(
            f"--hal: LinuxCNC's Python module is not found ({error}): install linuxcnc-uspace, and make "
            ".venv with the Python that it is for; or give positions in lines"
        ) from error
    finally:
        sys.path.remove(_DEBIAN)


class HalPositions:
    """The position that the pins have when it is asked for; of `positions.Positions` the form."""

    def __init__(self, rotary: Collection[str] = (), several: bool = False) -> None:
        """Make the component, for a machine with these of the axes A, B, C; ``several``: and several tools.

        Raises InputError where HAL is not running, or has one of that name.
        """
        self._module = _hal()
        kinds = self._module
        try:
            self._component = kinds.component(NAME)
            for name in _PLACE:
                self._component.newpin(name, kinds.HAL_FLOAT, kinds.HAL_IN)
            self._component.newpin("tool", kinds.HAL_S32, kinds.HAL_IN)
            for name in ("running", "idle"):
                self._component.newpin(name, kinds.HAL_BIT, kinds.HAL_IN)
            for name in ("go", *_BEYOND, "beat"):
                self._component.newpin(name, kinds.HAL_BIT, kinds.HAL_OUT)
            self._component.ready()
        except Exception as error:
            raise InputError(
                f"--hal: no component {NAME}: {error}: load it from the machine's .hal file, once"
            ) from error
        # Until when what the pins say is known: then they are cleared, though nobody says so.
        self._known, self._changed, self._closed = 0.0, threading.Condition(), False
        self._clearing = threading.Thread(target=self._clear_in_time, daemon=True)
        self._clearing.start()
        self._has_run = False
        self._wanted = {"x", "y", "z", "running", "idle", *map(str.lower, rotary), *["tool"] * several}
        self.angles: Vector | None = None

    @property
    def tool(self) -> int | None:
        """Return the number of the tool in the spindle; None where that was never netted."""
        if self._netted("tool"):
            self._wanted.add("tool")
        return int(self._component["tool"]) if "tool" in self._wanted else None

    def _netted(self, name: str) -> bool:
        return bool(self._module.pin_has_writer(f"{NAME}.{name}"))

    def wait(self, seconds: float) -> bool:
        """Return whether all pins that are needed are netted within a time."""
        until = time.monotonic() + seconds
        while not all(map(self._netted, self._wanted)):
            if time.monotonic() > until:
                return False
            time.sleep(_LOOK_SECONDS)
        return True

    def report(self) -> Report:
        """Return the position now; None once the program has run and does so no more.

        Raises InputError where a pin is not netted any more.
        """
        if missing := [name for name in sorted(self._wanted) if not self._netted(name)]:
            raise InputError(f"{NAME}.{missing[0]}: nothing writes this pin any more: the machine is stopped")
        # One is written before the other, whichever way they change.
        idle, running = bool(self._component["idle"]), bool(self._component["running"])
        if self._has_run and idle and not running:
            return None
        self._has_run |= running
        since, place = self._place()
        try:
            position, self.angles = (vector(map(Fraction, part)) for part in (place[:3], place[3:]))
            return position, since
        except (ValueError, OverflowError) as error:
            raise InputError(f"{NAME}: a position that is no number: the machine is stopped") from error

    def _place(self) -> tuple[float, list[float]]:
        """Return when and where the tool was, and its angles: twice the same, as pins are read in turn."""
        for _ in range(_READINGS):
            since = time.monotonic()
            one, other = ([self._component[name] for name in _PLACE] for _ in range(2))
            if one == other or any(map(math.isnan, one)):
                return since, one
        raise InputError(f"{NAME}: no two readings of the position are the same: the machine is stopped")

    def known_until(self, moment: float) -> None:
        """Have the pins cleared at a moment of the monotonic clock, unless that is put off."""
        with self._changed:
            self._known = moment
            self._clear_where_over()
            self._changed.notify()

    @property
    def _over(self) -> bool:
        return time.monotonic() >= self._known

    def _clear_where_over(self) -> float | None:
        """Clear the pins where it is time; return the seconds that are left, None where it is over."""
        # By one look at the clock: what is over at the next is not taken for cleared.
        left = self._known - time.monotonic()
        if left > 0:
            return left
        for name in ("go", *_BEYOND):
            self._component[name] = False
        return None

    def _clear_in_time(self) -> None:
        with self._changed:
            while not self._closed:
                self._changed.wait(self._clear_where_over())

    def said(self, go: bool) -> None:
        """Show on the pin what an answer was, for as long as that is known, and that there was one."""
        with self._changed:
            self._component["go"] = go and not self._over
            self._component["beat"] = not self._component["beat"]

    def beyond(self, zones: int) -> None:
        """Show on the pins how many zones the tool is beyond, for as long as that is known."""
        with self._changed:
            known = not self._over
            for number, name in enumerate(_BEYOND):
                self._component[name] = known and zones > number

    def close(self) -> None:
        """Take the component away; nothing is permitted any more."""
        self.known_until(0.0)
        with self._changed:
            self._closed = True
            self._changed.notify()
        # Pins that are gone cannot be cleared.
        self._clearing.join(_ENDS_SECONDS)
        self._component.exit()
