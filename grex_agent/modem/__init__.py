"""The agent's modem: the port it speaks through, and the driver of a real one."""
