"""Tasks aboard: planned as tracks, run one after another, sent to others and echoed, and who is sent to an event."""
