"""The figures of the papers, of any run: `motes track --figures`."""
