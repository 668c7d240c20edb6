"""`telemotion simulate`: one of three simulated patients, each imported only when it is meant."""

from app.commands.options.declared import shared
from app.commands.options.simulate import SimulateOptions


def simulate(options: SimulateOptions) -> None:
    """Stream a source, a walk or an arm, whichever the options name."""
    if options.relative:
        from app.commands.simulation.relative import RelativeOptions, simulate_relative

        simulate_relative(shared(RelativeOptions, options))
    elif options.walk:
        from app.commands.simulation.walk import WalkOptions, simulate_walk

        simulate_walk(shared(WalkOptions, options))
    else:
        from app.commands.simulation.arm import Options
        from app.commands.simulation.arm import simulate as simulate_arm

        simulate_arm(shared(Options, options))
