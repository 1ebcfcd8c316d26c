"""Many campaigns, each identified, and what their parameters say together."""
