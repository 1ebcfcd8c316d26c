"""Misreadings of records: wrong declarations, contradicting records, wrong values of the mechanism file."""
