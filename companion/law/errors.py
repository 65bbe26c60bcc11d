"""What the law says where it is not defined."""

from companion.vehicle import CompanionError


class LawError(CompanionError):
    """A state where the law is not defined (Lemma 4.1), or outside the domain of the mission's expressions."""
