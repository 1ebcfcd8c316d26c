"""What records tell of each parameter: its visibility, noise, covariances and standard errors, and where these hold."""
