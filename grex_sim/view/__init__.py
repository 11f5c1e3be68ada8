"""The live page: what a run looks like, from the bus or from a recording."""
