"""A command of mechid as its user runs it: the files of a bench, and its time by parts."""
