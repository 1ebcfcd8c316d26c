"""What an identification returns, how well records are predicted, and the files of it."""
