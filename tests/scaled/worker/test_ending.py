"""A task ends also when one cancellation of it is lost."""

import asyncio

from app.scaled.worker.cancellation import end
from tests.patience import PATIENCE_S


def test_a_task_that_loses_its_first_cancellation_is_cancelled_again() -> None:
    lost: list[str] = []

    async def goes_on() -> None:
        try:
            await asyncio.sleep(60.0)
        except asyncio.CancelledError:
            lost.append("first")
        await asyncio.sleep(60.0)

    async def story() -> asyncio.Task[None]:
        task = asyncio.create_task(goes_on())
        await asyncio.sleep(0.0)
        async with asyncio.timeout(PATIENCE_S):
            await end([task], again_s=0.01)
        return task

    assert asyncio.run(story()).cancelled()
    assert lost == ["first"]
