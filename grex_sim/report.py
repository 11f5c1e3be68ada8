"""Pictures and texts of plans and runs; the only user of matplotlib."""


def draw(folder, config, plan):
    pass
