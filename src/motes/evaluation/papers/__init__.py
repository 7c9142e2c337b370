"""What the papers tabulate or plot, measured here: a generator of results for each experiment."""
