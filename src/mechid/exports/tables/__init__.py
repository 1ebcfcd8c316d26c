"""Tables: lines of the torque over the rate and time histories, for Excel, Python, and Nastran."""
