"""The board's end of the line, as docs/board.md has it: bytes to whole frames; what is wrong with others."""

from collections.abc import Callable

from triaxis.verif.board.protocol import END, ESC, ESC_END, ESC_ESC, LONGEST, SHORTEST, checked


class FrameReceiver:
    """Takes bytes one by one; ``failed`` is told what is wrong. Before the first END nothing is a frame."""

    def __init__(self, failed: Callable[[str], None]) -> None:
        """Begin as after a reset."""
        self._failed = failed
        self._frame = bytearray()
        self._hunting, self._escaped, self._skipping = True, False, False

    def byte(self, value: int, held: bool) -> bytes | None:
        """Take a byte; return the frame that it completes. ``held``: there is no place for another."""
        if value == END and not self._escaped:
            return self._ended()
        if self._hunting:
            return None
        if self._escaped:
            self._escaped = False
            if value in (ESC_END, ESC_ESC):
                self._add(END if value == ESC_END else ESC, held)
            else:
                self.drop("END after ESC" if value == END else "bad stuffing")
                # An END after an ESC is wrong, and yet ends the frame.
                self._hunting = value != END
        elif value == ESC:
            self._escaped = True
        else:
            self._add(value, held)
        return None

    def _add(self, value: int, held: bool) -> None:
        if self._skipping:
            return
        if held or len(self._frame) == LONGEST:
            self._frame.clear()
            self._skipping = True
            self._failed("frame still held" if held else "too long")
            return
        self._frame.append(value)

    def drop(self, what: str) -> None:
        """Drop the frame under way: it is wrong."""
        self._frame.clear()
        self._skipping = self._escaped = False
        self._hunting = True
        self._failed(what)

    def _ended(self) -> bytes | None:
        frame, skipped = bytes(self._frame), self._skipping
        self._frame.clear()
        self._hunting = self._skipping = False
        if skipped or not frame:
            return None
        if len(frame) < SHORTEST or checked(frame[:-4]) != frame:
            self._failed("too short" if len(frame) < SHORTEST else "bad CRC")
            return None
        return frame
