"""What stays ashore: the simulated sea, and the bench that launches, records, scores and plots."""
