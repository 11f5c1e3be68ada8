"""Pictures and texts of plans and runs; the only user of matplotlib."""
from pathlib import Path
def draw(folder, config, plan): pass
