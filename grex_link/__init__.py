"""What lies between the craft: the contracts, the bus, and the water."""
