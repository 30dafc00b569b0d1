"""The event-exact solver: kernels on bare arrays, and the paper's closed form as an independent check."""
