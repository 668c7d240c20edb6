"""How many partitions each worker holds, and which it tries first: no two workers differ by more than one."""


def share_of(rank: int, workers: int, partitions: int) -> tuple[int, int]:
    """Return the first partition that a worker tries, and how many it holds.

    The shares of all are the partitions, and no share becomes smaller when a worker goes.

    Parameters
    ----------
    rank : int
        Place of the worker's name among those of all.
    """
    least, more = divmod(partitions, workers)
    return rank * least + min(rank, more), least + (rank < more)
