"""What all tests have in common."""

import signal

# A shell that starts a job in the background lets it ignore interrupts, and Python then does not raise KeyboardInterrupt. Tests of interrupts need it,
# in this process and in those that it starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
