"""Missing effects: what mechanism and campaign files do not declare and records ask for, found, kept and dropped."""
