"""Export as tables for Excel, Python and Nastran: torque lines over the rate, and time histories."""
