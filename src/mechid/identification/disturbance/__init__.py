"""Disturbances that are no plant: what differs between records, and between clocks, and is none of the mechanism's."""
