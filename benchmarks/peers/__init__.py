"""P1 by what users would pick instead of ridedown."""
