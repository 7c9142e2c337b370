"""Tests of jobs on many machines, which share what a cluster costs."""
