"""Numbers of the phase filter and the counter."""

from dataclasses import dataclass

from estimators.errors import SetupError


@dataclass(frozen=True)
class GuidanceParameters:
    """Numbers of the phase filter and the counter, one set for all exercises; the equation stands with each.

    Attributes
    ----------
    pace_sd : float
        (2): sigma_r as a share of r0 = 1 / T.
    slope_sd_per_s, slope_share : float
        (2): sigma_v of a channel over its s_c where the template rests, 1/s, and the share of M of (4) by which its
        square grows where the template moves: people differ most where they are fast.
    slowest, fastest : float
        (2): limits of the pace, in r0.
    blur_per_s : float
        (3): growth of the variance of the phase.
    split_blur : float
        (3): share of the variance f (1 - f) bins that splitting a mass between two bins would add by itself.
    size_exchange_per_s : float
        (3): how fast sizes mix. Standing still costs by its slopes, below.
    pace_follows_s : float
        How long a movement as well known as the pace before it must be seen until the patient's own pace is half of
        what is expected next.
    pace_forgets_s : float
        Time constant with which it goes back to the template's at rest: the next repetition may have another.
    free_misfit, direction, steepness, misfit_cap, memory_s : float
        (4): what costs nothing, weight of the direction of movement, weight of how much a phase can explain (the
        logarithm of the variance of slopes that it expects), largest D, and for how long one look counts.
    rest_speed, wrong_misfit : float
        (5): 0.36 and the D of WRONG.
    stiff_from, stiff_misfit, stiff_least : float
        From which mean D on a movement is also looked at with one channel that does not come along, what that costs,
        and the least share of its way that such a channel goes; below it the movement is another one.
    rest_to_start_per_s, end_to_rest_per_s, end_to_start_per_s, to_wrong_per_s, from_wrong_per_s, to_rest_per_s, \
restart_per_s : float
        (6), in the order of that equation.
    broad_share : float
        (7): share of the size prior that is spread over all sizes.
    start_follows_s : float
        Time constant with which the start posture follows at rest.
    still_s : float
        After so long without movement, nearer to the start posture than `least_excursion`, it is rest whatever (5)
        says, and the start posture is there: it was prompted before the patient was in it.
    wrong_share, least_excursion, least_attempt_s : float
        (9): mean P(WRONG) from which an attempt is wrong; share of the template's excursion and duration below which
        it is ignored.
    """

    pace_sd: float = 0.7
    slope_sd_per_s: float = 0.7
    slope_share: float = 0.04
    slowest: float = -0.1
    fastest: float = 4.0
    blur_per_s: float = 0.001
    split_blur: float = 0.2
    size_exchange_per_s: float = 0.3
    pace_follows_s: float = 4.0
    pace_forgets_s: float = 1.0
    free_misfit: float = 0.0
    direction: float = 6.0
    steepness: float = 0.2
    misfit_cap: float = 12.0
    memory_s: float = 0.02
    rest_speed: float = 0.36
    wrong_misfit: float = 6.0
    stiff_from: float = 1.5
    stiff_misfit: float = 2.0
    stiff_least: float = 0.15
    rest_to_start_per_s: float = 0.5
    end_to_rest_per_s: float = 6.0
    end_to_start_per_s: float = 8.0
    to_wrong_per_s: float = 0.05
    from_wrong_per_s: float = 1.0
    to_rest_per_s: float = 0.05
    restart_per_s: float = 0.03
    broad_share: float = 0.2
    start_follows_s: float = 5.0
    still_s: float = 1.5
    wrong_share: float = 0.2
    least_excursion: float = 0.15
    least_attempt_s: float = 0.4

    def __post_init__(self) -> None:
        positive = ("pace_sd", "slope_sd_per_s", "memory_s", "pace_follows_s", "pace_forgets_s")
        if not min(getattr(self, name) for name in positive) > 0:
            raise SetupError(f"{self}: {', '.join(positive)} must be positive")
        if not self.slowest <= 0 < self.fastest <= 10:
            raise SetupError(f"{self}: slowest is at most 0, fastest 0 to 10")
