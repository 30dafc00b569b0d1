"""Regulations and their limits, and what a measured or a simulated crash comes to before them."""

from ridedown.limits.assess import Assessment, Judgement, Verdict, assess, assess_all
from ridedown.limits.evidence import Evidence, Person, Pulse, Signals, evidence
from ridedown.limits.findings import CRITERIA, Finding
from ridedown.limits.regulations import Limit, Regulation, regulation, regulations
from ridedown.limits.summary import CrashCriteria, OccupantCriteria, VehicleCriteria, criteria_of

__all__ = [
    "CRITERIA",
    "Assessment",
    "CrashCriteria",
    "Evidence",
    "Finding",
    "Judgement",
    "Limit",
    "OccupantCriteria",
    "Person",
    "Pulse",
    "Regulation",
    "Signals",
    "VehicleCriteria",
    "Verdict",
    "assess",
    "assess_all",
    "criteria_of",
    "evidence",
    "regulation",
    "regulations",
]
