"""A recorded run for all tests of what is to be seen of one."""

import pytest
from missions import fly


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """Folder of five minutes of case d, a part of whose messages are lost, about a datum."""
    folder = tmp_path_factory.mktemp("recorded")
    datum = "datum={latitude_deg=54.37,longitude_deg=10.16}"
    fly("paper-d", "duration_s=300", "link.loss=0.4", datum, out=folder)
    return folder
