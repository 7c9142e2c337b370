"""Events and pictures on their way out of a run: to brokers, addresses and browsers."""
