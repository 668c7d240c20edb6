"""Whether what is said of a patient's progress is true: courses of which the change is known."""

from validation.progress.experiments import PROGRESS_FALSE_ALARMS, PROGRESS_INTERVAL, PROGRESS_POWER

__all__ = ["PROGRESS_FALSE_ALARMS", "PROGRESS_INTERVAL", "PROGRESS_POWER"]
