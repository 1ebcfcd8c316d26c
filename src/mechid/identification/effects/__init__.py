"""Missing effects, which the data support and the files do not declare: found, kept and dropped."""
