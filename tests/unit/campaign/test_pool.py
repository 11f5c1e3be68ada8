"""The local executor and the engine, with real processes: nothing is lost, whoever dies."""

import subprocess
import sys
import time

import pytest
from campaign_work import Task, begun, work

from grex_sim.campaign.engine import Outcome, carry_out, do
from grex_sim.campaign.pool import LocalPool


class Kept(list):
    """Keeps outcomes in a list."""

    def add(self, outcome):
        self.append(outcome)


@pytest.fixture(scope="module")
def carried(tmp_path_factory):
    """Twelve sound tasks, one that fails, one that kills its worker once, and one that does so always."""
    folder = str(tmp_path_factory.mktemp("traces"))
    tasks = [Task(f"sound{n}", value=n, folder=folder) for n in range(12)]
    tasks[3:3] = [Task(deed.replace(" ", "-"), deed, 7, folder) for deed in ("fail", "die once", "die")]
    kept, told = Kept(), []
    with LocalPool(work, 2) as pool:
        carry_out(tasks, pool, kept, told.append)
    return {outcome.key: outcome for outcome in kept}, kept, told, tasks


def test_every_job_ends_once(carried):
    """Each job has one outcome, and whoever watches is told of the same."""
    _, kept, told, tasks = carried
    assert sorted(outcome.key for outcome in kept) == sorted(task.key for task in tasks)
    assert told == kept


def test_sound_jobs_have_their_figures(carried):
    """Workers that die take nobody else's job with them."""
    by_key, *_ = carried
    assert all(by_key[f"sound{n}"].figures == {"value": 2 * n} for n in range(12))


def test_a_job_that_raises_has_failed_for_its_reason(carried):
    """What a job raises is its outcome, and it is not begun again: it would raise the same."""
    by_key, _, _, tasks = carried
    assert by_key["fail"] == Outcome("fail", None, "ValueError: no 7")
    assert begun(tasks[3]) == 1


def test_a_job_whose_worker_is_killed_is_tried_once_more(carried):
    """Killed once it comes to its end the second time; killed twice it has failed, and the signal is named."""
    by_key, _, _, tasks = carried
    assert by_key["die-once"].figures == {"value": 14}
    assert by_key["die"].fault == "twice: its worker was killed by SIGKILL"
    assert [begun(task) for task in tasks[4:6]] == [2, 2]


def test_a_grex_error_is_its_own_reason():
    """Errors of GREX are lines for people already."""
    from grex_link.errors import FaultError

    def broken(_):
        raise FaultError("agent auv1", "stopped", 3.0)

    assert do(broken, Task("x")).fault == "agent auv1 stopped at mission time 3.0 s"


def test_workers_end_with_their_parent(tmp_path):
    """Workers whose parent is killed by SIGKILL in the middle of a job do not outlive it."""
    program = (
        "import sys, os; from pathlib import Path; from campaign_work import Task, work\n"
        "from grex_sim.campaign.pool import LocalPool\n"
        "if __name__ == '__main__':\n"
        "    with LocalPool(work, 1) as pool:\n"
        "        worker = pool.outcomes([Task('a'), Task('b', 'sleep', 600)])\n"
        "        next(worker); print(pool._workers[0]._process.pid, flush=True); next(worker)\n"
    )
    file = tmp_path / "parent.py"
    file.write_text(program, encoding="utf-8")
    with subprocess.Popen([sys.executable, file], stdout=subprocess.PIPE, text=True,
                          env={**__import__("os").environ, "PYTHONPATH": ":".join(sys.path)}) as parent:  # fmt: skip
        worker = int(parent.stdout.readline())
        parent.kill()
    deadline = time.monotonic() + 30.0
    while _alive(worker) and time.monotonic() < deadline:
        time.sleep(0.02)
    assert not _alive(worker)


def _alive(process):
    try:
        with open(f"/proc/{process}/stat", encoding="utf-8") as file:  # noqa: PTH123
            return file.read().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False
