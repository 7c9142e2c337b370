"""Several cameras, and objects that keep their identity among them."""
