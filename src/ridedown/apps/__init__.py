"""What a person meets: the command line. Parse, call, show; no physics."""
