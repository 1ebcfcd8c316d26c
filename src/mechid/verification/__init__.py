"""Test reports: a result with its test article, set-up, records and digests, verification table and deviations."""
