"""The default tracker: learned filters that locate a target, and particles that search for it."""
