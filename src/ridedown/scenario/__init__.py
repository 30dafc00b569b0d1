"""What the user writes: vehicles, collision, occupants and restraints, as frozen models, read from TOML or YAML."""

from __future__ import annotations

from ridedown.scenario.bar import Arms, Bar
from ridedown.scenario.channels import centre_of_mass, total_forces
from ridedown.scenario.files import dump, load
from ridedown.scenario.kinds import Scenario
from ridedown.scenario.lowering import lower
from ridedown.scenario.member import Member, Piece
from ridedown.scenario.model import Collision, CrashScenario, Source
from ridedown.scenario.networks import Crush, NetworkScenario, PointMass, Tie
from ridedown.scenario.occupant import Body, Joint, Occupant, Restraint, Seat
from ridedown.scenario.parameters import Parameter, broken_rules, parameters, quantities, substitute
from ridedown.scenario.restraints import Airbag, AnyRestraint, Belt, Contact, LoadLimiter, Pretensioner
from ridedown.scenario.schema import json_schema
from ridedown.scenario.sled import SledScenario
from ridedown.scenario.vehicle import Vehicle

__all__ = [
    "Airbag",
    "AnyRestraint",
    "Arms",
    "Bar",
    "Belt",
    "Body",
    "Collision",
    "Contact",
    "CrashScenario",
    "Crush",
    "Joint",
    "LoadLimiter",
    "Member",
    "NetworkScenario",
    "Occupant",
    "Parameter",
    "Piece",
    "PointMass",
    "Pretensioner",
    "Restraint",
    "Scenario",
    "Seat",
    "SledScenario",
    "Source",
    "Tie",
    "Vehicle",
    "broken_rules",
    "centre_of_mass",
    "dump",
    "json_schema",
    "load",
    "lower",
    "parameters",
    "quantities",
    "substitute",
    "total_forces",
]
