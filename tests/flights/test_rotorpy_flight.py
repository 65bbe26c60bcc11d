"""The law flies RotorPy's Hummingbird in RotorPy's own world, which it knows nothing of: a second plant."""

from trials.rivals.course import circle, figure_eight
from trials.rivals.sorties import ITS_OWN, RATES, Sortie, flown


def test_a_circle_at_a_fifth_of_the_error_of_rotorpys_own_controller() -> None:
    theirs = flown(Sortie(ITS_OWN, "RotorPy", circle(3.0), 9.0, 6.0))
    ours = flown(Sortie(RATES, "RotorPy", circle(3.0), 9.0, 6.0))
    assert ours.path_rms < 0.2 * theirs.path_rms


def test_a_figure_eight_with_a_yaw_loop_far_quicker_than_px4s() -> None:
    seen = flown(Sortie(RATES, "RotorPy", figure_eight(4.0), 16.0, 6.0))
    assert not seen.lost and seen.path_max < 0.2 and seen.yaw_rms < 10.0
