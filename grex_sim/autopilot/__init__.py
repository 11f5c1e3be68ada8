"""A simulated autopilot: our craft speaks MAVLink as real ones do. Pure, but for codec, links and shell."""
