"""Work on many motions in parts: in this process, on an executor, kept in a folder.

The folder is laid out as those of the command line's long studies: ``manifest.toml`` says what is computed, a file ``00000.part`` holds
each finished part, complete or absent. A part has the sum of its rows (SHA-256) in a line, then the rows as JSON.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Optional, Protocol, Union

from ._progress import Bar

#: Most parts of a study, and the least and most rows of one.
_PARTS, _LEAST, _MOST = 200, 8, 4096
#: The form of a part; parts of other forms are refused.
_FORM = 3


class Work(Protocol):
    """Rows of many motions; it is sent to other processes."""

    def count(self) -> int:
        """Number of rows."""

    def part(self, begin: int, end: int) -> Work:
        """Some of the rows."""

    def told(self) -> Iterator[bytes]:
        """All on which the rows depend."""

    def rows(self, report: Any) -> list[Any]:
        """Computes the rows."""


def _computed(work: Work) -> list[Any]:
    """Rows of a part, in another process."""
    return work.rows(None)


def rows_of(work: Work, executor: Any, checkpoint: Union[None, str, os.PathLike[str]], progress: bool) -> list[Any]:
    """All rows, computed where they are not kept yet.

    Raises
    ------
    KeyboardInterrupt
        With the rows so far as its attribute ``partial``, None for those that are missing.
    """
    if executor is not None and not callable(getattr(executor, "submit", None)):
        raise TypeError(
            f"executor is of type {type(executor).__name__}: allowed is what has `submit`, as executors of concurrent.futures, of loky and mpi4py, "
            "and a Client of dask have"
        )
    if checkpoint is not None and not isinstance(checkpoint, (str, os.PathLike)):
        raise TypeError(f"checkpoint = {checkpoint!r} is of type {type(checkpoint).__name__}: allowed is the path of a folder")
    count = work.count()
    if executor is None and checkpoint is None:
        with Bar(progress, count, "motions") as bar:
            return work.rows(bar.report)
    size = min(max(-(-count // _PARTS), _LEAST), _MOST)
    ends = [(begin, min(begin + size, count)) for begin in range(0, count, size)]
    folder = None if checkpoint is None else _Folder(Path(checkpoint), work, count, size)
    found: list[Optional[list[Any]]] = [None if folder is None else folder.load(k) for k in range(len(ends))]
    missing = [k for k, rows in enumerate(found) if rows is None]
    with Bar(progress, len(ends), "parts") as bar, _partial(found, ends):
        parts = _here(work, ends, missing) if executor is None else _there(executor, work, ends, missing)
        for done, (k, rows) in enumerate(parts):
            if folder is not None:
                folder.save(k, rows)
            found[k] = rows
            if bar.report is not None:
                bar.report(len(ends) - len(missing) + done + 1, len(ends))
    return [row for rows in found for row in rows or ()]


def _here(work: Work, ends: list[tuple[int, int]], missing: list[int]) -> Iterator[tuple[int, list[Any]]]:
    for k in missing:
        try:
            yield k, work.part(*ends[k]).rows(None)
        except Exception as error:
            _place(error, ends[k][0])
            raise


def _there(executor: Any, work: Work, ends: list[tuple[int, int]], missing: list[int]) -> Iterator[tuple[int, list[Any]]]:
    """Parts by an executor, in their order; what is not begun is cancelled where the work ends early."""
    # Dask takes calls with equal arguments for one, whose result it may still have: so they are.
    futures = [(k, executor.submit(_computed, work.part(*ends[k]))) for k in missing]
    try:
        for k, future in futures:
            try:
                yield k, future.result()
            except Exception as error:
                _place(error, ends[k][0])
                raise
    finally:
        for _, future in futures:
            if not future.done():
                future.cancel()


def _place(error: Exception, begin: int) -> None:
    """Says where the numbers of motions in a message of a part begin."""
    if begin and error.args and isinstance(error.args[0], str) and error.args[0].startswith("motion "):
        number, _, rest = error.args[0][len("motion ") :].partition(":")
        if number.isdecimal():
            error.args = (f"motion {int(number) + begin}:{rest}", *error.args[1:])


@contextlib.contextmanager
def _partial(found: list[Optional[list[Any]]], ends: list[tuple[int, int]]) -> Iterator[None]:
    try:
        yield
    except KeyboardInterrupt as interrupt:
        kept = [row for rows, (begin, end) in zip(found, ends) for row in (rows or [None] * (end - begin))]
        setattr(interrupt, "partial", kept)  # noqa: B010 (not in its type)
        raise


def _sum_of(rows: bytes) -> bytes:
    """The sum by which a damaged part is known."""
    return hashlib.sha256(rows).hexdigest().encode()


class _Folder:
    """Finished parts in a folder."""

    def __init__(self, path: Path, work: Work, count: int, size: int) -> None:
        from ._native import __version__

        digest = hashlib.sha256()
        for part in work.told():
            digest.update(len(part).to_bytes(8, "little") + part)
        manifest = f'program = "vibro_impact"\nversion = "{__version__}"\nform = {_FORM}\nrows = {count}\npart = {size}\nwork = "{digest.hexdigest()}"\n'
        self.path = path
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as problem:
            raise type(problem)(f"checkpoint = {path}: {problem}: allowed is a folder") from problem
        own = path / "manifest.toml"
        if own.exists():
            there = own.read_text(encoding="utf-8")
            if there != manifest:
                lines = zip(there.splitlines(), manifest.splitlines())
                other = "; ".join(f"`{a}` in place of `{b}`" for a, b in lines if a != b) or "its manifest.toml is cut"
                raise ValueError(f"checkpoint = {path}: holds parts of other work, {other}: allowed is another folder, or this one emptied")
        elif any(path.iterdir()):
            raise ValueError(f"checkpoint = {path}: holds files but no manifest.toml of parts: allowed is an empty folder or a new one")
        else:
            self._write(own, manifest)

    def _file(self, k: int) -> Path:
        return self.path / f"{k:05d}.part"

    def load(self, k: int) -> Optional[list[Any]]:
        """A finished part."""
        if not self._file(k).exists():
            return None
        total, _, rows = self._file(k).read_bytes().partition(b"\n")
        if total != _sum_of(rows):
            raise ValueError(f"{self._file(k)} is damaged, its sum is not that of its rows: allowed is to delete it")
        found: list[Any] = json.loads(rows)
        return found

    def save(self, k: int, rows: list[Any]) -> None:
        """Keeps a part, completely or not at all."""
        text = json.dumps(rows)
        self._write(self._file(k), f"{_sum_of(text.encode()).decode()}\n{text}")

    def _write(self, path: Path, text: str) -> None:
        beside = path.with_name(f"{path.name}.{os.getpid()}.writing")
        with beside.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
