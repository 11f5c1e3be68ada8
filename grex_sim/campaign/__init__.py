"""Campaigns: one scenario, varied and repeated many times on all cores or on a cluster, resumable."""
