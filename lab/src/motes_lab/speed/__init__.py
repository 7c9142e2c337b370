"""Speed of trackers, measured side by side."""
