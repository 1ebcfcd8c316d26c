"""Campaigns in which one thing is declared or recorded wrongly, and what mechid says of them."""
