"""The lab of motes: trackers measured on sequences, the papers' tables, and speed."""
