"""Every partition is somebody's, and a death moves only what the dead one held."""

import itertools

from app.scaled.placement import share_of


def test_shares_are_even_and_cover_every_partition_once() -> None:
    for workers, partitions in itertools.product(range(1, 12), (1, 4, 16, 37)):
        tried = [share_of(rank, workers, partitions) for rank in range(workers)]
        own = [one for first, share in tried for one in range(first, first + share)]
        assert own == list(range(partitions))
        counts = [share for _, share in tried]
        assert max(counts) - min(counts) <= 1


def test_nobody_gives_back_when_another_one_goes() -> None:
    for workers, partitions in itertools.product(range(2, 12), (1, 4, 16, 37)):
        for gone in range(workers):
            for rank in set(range(workers)) - {gone}:
                before = share_of(rank, workers, partitions)[1]
                after = share_of(rank - (rank > gone), workers - 1, partitions)[1]
                assert after >= before
