"""A simulated walk on two instrumented shoes, analysed up to force and pressure centre of both feet."""

from dataclasses import dataclass, replace

import numpy as np

from estimators.balance import BothFeet, body_mass, combine_feet
from estimators.conventions import SIDES, Side
from estimators.kinetics import ShoeKinetics, ShoeParameters, analyse_shoe
from estimators.recording import Float
from estimators.simulation import GaitScenario, GaitTruth, gait_preset, simulate_gait


@dataclass(frozen=True)
class AnalysedWalk:
    """What the shoes say of a walk, and the truth.

    Attributes
    ----------
    mass_kg : float
        As the shoes feel it.
    height_m : float
        Mean height of the true centre of mass, for the sacrum of the published method.
    """

    shoes: dict[Side, ShoeKinetics]
    feet: BothFeet
    mass_kg: float
    height_m: float
    truth: GaitTruth

    @property
    def fused(self) -> tuple[Float, Float, float, float, float]:
        """Arguments of every centre-of-mass estimate: force, pressure centre, rate, mass, height."""
        return self.feet.force_n, self.feet.cop_m, self.feet.rate_hz, self.mass_kg, self.height_m


def analysed_walk(scenario: GaitScenario, parameters: ShoeParameters | None = None) -> AnalysedWalk:
    """Simulate a walk and analyse both shoes; the mould's width at start and end is known."""
    walk = simulate_gait(scenario)
    sensors = walk.recording.sensors
    chosen = parameters or ShoeParameters(position_mode="pivot")
    shoes: dict[Side, ShoeKinetics] = {
        side: analyse_shoe(sensors[f"heel_{side}"], sensors[f"forefoot_{side}"], None, chosen)
        for side in SIDES
    }
    width = scenario.walk.step_width_m
    feet = combine_feet(shoes["left"], shoes["right"], width, end_width_m=width)
    mass_kg = body_mass(feet.force_n, feet.is_standing)
    return AnalysedWalk(shoes, feet, mass_kg, float(walk.truth.com.position[:, 2].mean()), walk.truth)


def com_scenario(seed: int, momentum_arm_m: float = 0.0, errors: str = "shoe_nominal") -> GaitScenario:
    """Return one trial of the centre-of-mass protocol."""
    base = gait_preset("centre_of_mass", seed)
    return replace(base, errors=errors, body=replace(base.body, momentum_arm_m=momentum_arm_m))


def axis_errors_mm(position_m: Float, truth: GaitTruth) -> Float:
    """Return RMS errors along x, y and z in mm; the trial's mean is taken out of x and y, as published."""
    error = position_m - truth.com.position
    error = error - np.append(error[:, :2].mean(axis=0), 0.0)
    return np.asarray(1e3 * np.sqrt(np.mean(error**2, axis=0)))
