"""The journal of a campaign: a header, then a line for each run that has ended; append-only, so it survives anything.

Every line is handed to the kernel at once, so a killed campaign loses nothing; about once a second it is put on disk,
so a power failure costs a second. A line that was cut in two is dropped when the journal is opened again.
"""

import fcntl
import os
from pathlib import Path
from types import TracebackType
from typing import Self

import msgspec

from grex_link import clock
from grex_link.errors import ConfigError, GrexError
from grex_sim.campaign.definition import Definition, difference
from grex_sim.campaign.engine import Outcome

JOURNAL_FILE = "journal.jsonl"
_SYNC_S = 1.0


class Journal:
    """What a campaign's folder knows of its runs; use as a context manager.

    Parameters
    ----------
    folder : Path
        The campaign's folder; made if it is not there.
    definition : Definition
        The campaign that is wanted.

    Attributes
    ----------
    outcomes : dict of str to Outcome
        The newest outcome of each job.

    Raises
    ------
    ConfigError
        If the folder is another campaign's, or a campaign is at work in it.
    """

    def __init__(self, folder: Path, definition: Definition) -> None:
        self.outcomes: dict[str, Outcome] = {}
        self.path = folder / JOURNAL_FILE
        self._encode = msgspec.json.Encoder().encode
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o666)
        except OSError as error:
            raise ConfigError("--out", f"cannot keep a campaign in {folder}: {error.strerror}") from None
        self._sync_at = 0.0
        try:
            self._claim(folder)
            self._open(definition)
        except BaseException:
            os.close(self._file)
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            os.fsync(self._file)
        finally:
            os.close(self._file)

    def add(self, outcome: Outcome) -> None:
        """Keep an outcome.

        Raises
        ------
        GrexError
            If the disk is full, or cannot be written for another reason.
        """
        self._write(self._encode(outcome))
        self.outcomes[outcome.key] = outcome
        now = clock.monotonic_s()
        if now >= self._sync_at:
            os.fsync(self._file)
            self._sync_at = now + _SYNC_S

    @property
    def done(self) -> dict[str, Outcome]:
        """Outcomes of the jobs that need not be done again: those that did not fail."""
        return {key: outcome for key, outcome in self.outcomes.items() if outcome.figures is not None}

    def _claim(self, folder: Path) -> None:
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ConfigError(str(folder), "a campaign is at work here; wait for it, or take another --out") from None

    def _open(self, definition: Definition) -> None:
        """Read what is there, drop a line that was cut in two, and compare the header."""
        text = self.path.read_bytes()
        whole = text.rfind(b"\n") + 1
        if whole < len(text):
            os.ftruncate(self._file, whole)
        lines = text[:whole].splitlines()
        if not lines:
            self._write(self._encode(definition))
            return
        try:
            header = msgspec.json.decode(lines[0], type=Definition)
            outcomes = msgspec.json.Decoder(Outcome)
            self.outcomes = {outcome.key: outcome for outcome in map(outcomes.decode, lines[1:])}
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            raise ConfigError(
                str(self.path), f"is damaged, or not of this version ({error}); take another --out"
            ) from None
        if parts := difference(header, definition):
            raise ConfigError(str(self.path.parent), f"holds another campaign ({parts}); take another --out")

    def _write(self, line: bytes) -> None:
        try:
            left = memoryview(line + b"\n")
            while left:
                left = left[os.write(self._file, left) :]
        except OSError as error:
            raise GrexError(f"cannot write {self.path}: {error.strerror}; {len(self.outcomes)} runs are kept") from None
