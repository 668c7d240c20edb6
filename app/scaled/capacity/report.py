"""`telemotion capacity`: what a number of live sessions needs, and what the death of a worker does to them."""

import numpy as np
import typer

from app.scaled.capacity.costs import Costs, plan
from app.scaled.capacity.simulation import fail, place

DEATHS = 50


def capacity(sessions: int, partitions: int) -> None:
    """Print the plan and the simulation.

    Parameters
    ----------
    sessions : int
        Live at once, each watched.
    """
    costs = Costs()
    found = plan(sessions, costs)
    typer.echo(f"{found.sessions} live sessions of 17 sensors at 100 Hz, each with one view")
    typer.echo(f"  workers, one core each     {found.workers}")
    typer.echo(f"  edges, one core each       {found.edges}")
    typer.echo(f"  cores busy in brokers      {found.broker_cores:.1f}")
    typer.echo(f"  cores busy in databases    {found.database_cores:.1f}")
    typer.echo(f"  into the streams           {found.stream_mb_s:.0f} MB/s")
    typer.echo(
        f"  into the databases         {found.database_mb_s:.0f} MB/s, {found.database_tb_day:.2f} TB a day stay"
    )
    typer.echo(f"  to the views               {found.view_mb_s:.0f} MB/s")
    workers = found.workers
    if workers < 2:
        return
    placement = place(sessions, partitions, workers)
    busy = placement.busy(workers, costs)
    typer.echo(f"placement on {partitions} partitions")
    typer.echo(f"  a worker is busy           {busy.mean():.0%} on average, {busy.max():.0%} at most")
    generator = np.random.default_rng(0)
    fails = [fail(placement, workers, one % workers, costs, generator) for one in range(DEATHS)]
    shown = np.concatenate([one.shown_s for one in fails])
    typer.echo(f"a worker dies ({DEATHS} times)")
    typer.echo(
        f"  its sessions show again    after {np.median(shown):.2f} s (median),"
        f" {np.quantile(shown, 0.95):.2f} s (95 %), {shown.max():.2f} s (last)"
    )
    typer.echo(f"  all is worked off          after {max(one.level_s for one in fails):.1f} s")
    typer.echo(f"  the busiest worker then    {max(one.busiest for one in fails):.0%}")
