"""Reads a run into numpy, cell by cell: open it as a notebook in an editor that knows ``# %%``, or run it as it is.

python deploy/examples/read_run.py runs/demo
"""

# %% Which run
import sys
from pathlib import Path

import numpy as np

from grex_link.recording import Recording

RUN = Path(sys.argv[1] if len(sys.argv) > 1 and not sys.argv[1].startswith("-") else "runs/demo")

# %% Read it: the scenario, and the messages of some topics, as they were on the bus
recording = Recording(RUN)
truths = [entry.message for entry in recording.entries(["truth"])]
craft = [pose.craft for pose in truths[0].poses]
t_s = np.array([truth.t_ns for truth in truths]) / 1e9
true_m = np.array([[(pose.north_m, pose.east_m) for pose in truth.poses] for truth in truths])  # (tick, craft, 2)
print(f"{recording.scenario.title}: {', '.join(craft)}, {t_s[-1]:.0f} s")

# %% What every craft believed of every mate: north, east (m), claimed sigma (m), age (s)
beliefs = {}
for entry in recording.entries(["state"]):
    for mate in entry.message.mates:
        row = (entry.message.tick, mate.north_m, mate.east_m, mate.sigma_m, mate.age_s)
        beliefs.setdefault((entry.craft, mate.craft), []).append(row)
beliefs = {pair: np.array(rows) for pair, rows in beliefs.items()}

# %% How far they were off
for (who, whom), rows in beliefs.items():
    place = true_m[rows[:, 0].astype(int), craft.index(whom)]
    error_m = np.hypot(*(rows[:, 1:3] - place).T)
    print(f"{who} of {whom}: {np.sqrt(np.mean(error_m**2)):.3f} m r.m.s., it claims {np.mean(rows[:, 3]):.3f} m")

# %% The figure of merit, step by step: columns of series.csv by name
series = np.genfromtxt(RUN / "series.csv", delimiter=",", names=True)
print(f"FD {series['fd'].mean():.4f}, of it distance {series['fd_distance'].mean():.4f} m")

# %% What became of the messages in the water
events = [entry.message for entry in recording.entries(["link_event"])]
latency_s = np.array([event.lasting_ns for event in events if event.kind == "delivered"]) / 1e9
lost = sum(event.kind == "lost" for event in events)
print(f"{len(latency_s)} receptions, {lost} lost; latency {latency_s.mean():.1f} s on average")

# %% A picture, if you like:
#    import matplotlib.pyplot as plt
#    plt.plot(true_m[:, :, 1], true_m[:, :, 0])
#    plt.show()
