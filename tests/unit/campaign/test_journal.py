"""The journal: what is kept, whatever happens to those who write it."""

import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
from missions import SCENARIOS

from grex_link.errors import ConfigError
from grex_link.scenario import load
from grex_sim.campaign.definition import Definition
from grex_sim.campaign.engine import Outcome
from grex_sim.campaign.journal import Journal

DEFINITION = Definition(load(SCENARIOS / "paper-d.toml"), {"link.loss": ["0", "1"]}, 3, "1.0")
GOOD, BAD = Outcome("0:0", {"fd": 0.5, "digest": "ab"}), Outcome("1:0", None, "agent auv1 fell asleep")


@pytest.fixture
def folder(tmp_path):
    """A campaign's folder, with one good and one bad outcome."""
    with Journal(tmp_path / "c", DEFINITION) as journal:
        journal.add(GOOD)
        journal.add(BAD)
    return tmp_path / "c"


def test_what_was_kept_is_there_again(folder):
    """A journal opened again has all outcomes; only those that did not fail are done."""
    with Journal(folder, DEFINITION) as journal:
        assert journal.outcomes == {"0:0": GOOD, "1:0": BAD}
        assert journal.done == {"0:0": GOOD}


def test_the_newest_outcome_counts(folder):
    """What failed and was tried again has the outcome of the last time, once."""
    with Journal(folder, DEFINITION) as journal:
        journal.add(Outcome("1:0", {"fd": 0.25}))
    with Journal(folder, DEFINITION) as journal:
        assert len(journal.done) == 2
        assert journal.outcomes["1:0"].figures == {"fd": 0.25}


@pytest.mark.parametrize("cut", [1, 5, 20])
def test_a_line_that_was_cut_in_two_is_dropped(folder, cut):
    """Whatever a killed campaign left of its last line goes; what is written next is whole."""
    file = folder / "journal.jsonl"
    os.truncate(file, file.stat().st_size - cut)
    with Journal(folder, DEFINITION) as journal:
        assert journal.outcomes == {"0:0": GOOD}
        journal.add(BAD)
    with Journal(folder, DEFINITION) as journal:
        assert journal.outcomes == {"0:0": GOOD, "1:0": BAD}


def test_another_campaign_is_refused(folder):
    """A folder belongs to one definition: another is refused, with what differs."""
    other = msgspec.structs.replace(DEFINITION, seeds=4)
    with pytest.raises(ConfigError, match=r"holds another campaign \(3 seeds instead of 4\); take another --out$"):
        Journal(folder, other)


def test_two_at_a_time_are_refused(folder):
    """Two campaigns do not write into one folder."""
    with Journal(folder, DEFINITION), pytest.raises(ConfigError, match="a campaign is at work here"):
        Journal(folder, DEFINITION)


def test_a_damaged_journal_is_one_line(folder):
    """A line in the middle that is none is said, not skipped."""
    file = folder / "journal.jsonl"
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(lines[0] + b"nonsense\n" + lines[2])
    with pytest.raises(ConfigError, match="is damaged, or not of this version"):
        Journal(folder, DEFINITION)


def test_a_folder_that_cannot_be_made_is_one_line(tmp_path):
    """A file in the place of the folder is a fault of --out."""
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match=r"^--out: cannot keep a campaign in"):
        Journal(tmp_path / "file", DEFINITION)


def test_a_full_disk_is_one_line_and_what_was_written_opens(tmp_path):
    """The error of a full disk says how much is kept; with room again the journal opens with just that."""
    program = (
        "import resource, sys; sys.path[:0] = sys.argv[2:]; from pathlib import Path\n"
        "from test_journal import *; from grex_link.errors import GrexError\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (8000, resource.RLIM_INFINITY))\n"
        "try:\n"
        "    with Journal(Path(sys.argv[1]), DEFINITION) as journal:\n"
        "        for n in range(10000): journal.add(Outcome(f'0:{n}', {'fd': 0.5}))\n"
        "except GrexError as error:\n"
        "    print(error)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program, tmp_path, *sys.path, Path(__file__).parent],
        capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    with Journal(tmp_path, DEFINITION) as journal:
        kept = len(journal.outcomes)
    assert kept > 10
    assert ended.stdout == f"cannot write {tmp_path / 'journal.jsonl'}: File too large; {kept} runs are kept\n"
