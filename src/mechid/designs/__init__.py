"""The next test: what records would tell, which are worth their time, and which rates lose steps."""
