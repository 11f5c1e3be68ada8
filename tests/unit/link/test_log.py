"""What a user should look into is one line on standard error that says who speaks."""

import pytest

from grex_link import log


@pytest.mark.parametrize("speak", [log.warn, log.info])
def test_one_line(fresh_log, monkeypatch, capsys, speak) -> None:
    """A log line goes to standard error, names its participant and its fields, and leaves standard output alone."""
    monkeypatch.setattr(log, "_who", "grex")
    log.speak_as("agent auv2")
    speak("dropped a message", key="grex/team/auv2/fix", count=3)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    level = "warning" if speak is log.warn else "info"
    for part in (
        f"level={level}",
        'who="agent auv2"',
        'event="dropped a message"',
        "key=grex/team/auv2/fix",
        "count=3",
    ):
        assert part in err
