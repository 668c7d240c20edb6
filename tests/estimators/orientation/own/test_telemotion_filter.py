from tests.estimators.orientation.orientation_contract import OrientationContract


class TestTelemotion(OrientationContract):
    name = "telemotion"
    gap_hold_after_ticks = 20
