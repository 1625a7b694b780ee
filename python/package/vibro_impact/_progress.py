"""Progress bar of long calls."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import Any, Callable, Optional


class Bar:
    """A tqdm bar if tqdm is installed, else a line on standard error."""

    def __init__(self, wanted: bool, total: int, unit: str) -> None:
        self.total = total
        self.shown = 0
        self.words = ""
        self.bar: Any = None
        self.wanted = wanted
        if wanted:
            try:
                from tqdm.auto import tqdm
            except ImportError:
                return
            self.bar = tqdm(total=total, unit=unit)

    @property
    def report(self) -> Optional[Callable[..., None]]:
        """Callback of the computation: number of finished parts, number of all parts (0 if this bar knows it), and optional words for the current part."""
        return self._show if self.wanted else None

    def _show(self, done: int, total: int, words: str = "") -> None:
        self.total = total or self.total
        if self.bar is not None:
            self.bar.total = self.total
            self.bar.set_postfix_str(words, refresh=False)
            self.bar.update(done - self.shown)
        elif (words, 100 * done // max(self.total, 1)) != (self.words, 100 * self.shown // max(self.total, 1)):
            # Pad, so that shorter words overwrite longer ones.
            sys.stderr.write(f"\r{100 * done // max(self.total, 1):3d} % {words}".ljust(len(self.words) + 7))
            sys.stderr.flush()
        self.shown, self.words = done, words

    def __enter__(self) -> Bar:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()
        elif self.wanted:
            sys.stderr.write("\n")


@contextlib.contextmanager
def partial(made: Callable[[Any], Any]) -> Iterator[None]:
    """Converts the best result so far of a search, which a KeyboardInterrupt has as its attribute `partial`."""
    try:
        yield
    except KeyboardInterrupt as interrupt:
        found = getattr(interrupt, "partial", None)
        setattr(interrupt, "partial", None if found is None else made(found))  # noqa: B010 (not in its type)
        raise
