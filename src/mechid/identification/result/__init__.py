"""Results of an identification: estimates, the fit of each record, the grade, and their files."""
