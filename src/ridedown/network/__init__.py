"""The crash as the solver sees it: coordinates, elements and their laws, as flat arrays."""

from ridedown.network.builder import Builder
from ridedown.network.channels import Channel, Family, channels
from ridedown.network.model import (
    Action,
    Curve,
    KelvinVoigt,
    Law,
    Linear,
    Network,
    Number,
    Pulse,
    Restraint,
    Threshold,
    Timer,
)

__all__ = [
    "Action",
    "Builder",
    "Channel",
    "Curve",
    "Family",
    "KelvinVoigt",
    "Law",
    "Linear",
    "Network",
    "Number",
    "Pulse",
    "Restraint",
    "Threshold",
    "Timer",
    "channels",
]
