"""motes unattended: batches, rigs of cameras, events over networks, annotation services."""
