"""Multi-object tracking: detection, association, counting, several cameras."""
