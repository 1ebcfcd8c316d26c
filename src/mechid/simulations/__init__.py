"""What the mechanism as written would do in each record: simulated, and shown."""
