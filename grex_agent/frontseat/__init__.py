"""What steers a real craft: an autopilot behind MAVLink takes the place of the simulated vehicle."""
