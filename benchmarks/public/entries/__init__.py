"""Entries of the table in the docs: mechid, SciPy's least squares, CasADi's multiple shooting."""
