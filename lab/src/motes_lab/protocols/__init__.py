"""The protocols by which trackers are run over sequences."""
