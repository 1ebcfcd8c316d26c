"""A finished fit taken up again: the likelihood's profile, the scatter of refits."""
