"""Many jobs on many machines: tables of jobs, pools of workers, results that appear once.

What a job does is a function that the caller gives; this package runs it in the processes of this
machine or as tasks of Ray, and knows neither commands nor evaluations.
"""
