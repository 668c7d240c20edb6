"""English sentences of live guidance: what is said during an exercise, a few words each."""

from typing import Final

ENGLISH: Final[dict[str, str | dict[str, str]]] = {
    "guidance.arm_to_side": "Keep the arm to the side.",
    "guidance.arm_not_across": "Not so far across the body.",
    "guidance.arm_in_front": "Keep the arm in front.",
    "guidance.arm_not_back": "Not so far back.",
    "guidance.sit_tall": "Sit tall.",
    "guidance.stand_tall": "Stand tall.",
    "guidance.shoulder_down": "Shoulder down.",
    "guidance.further": "A little further.",
    "guidance.slower": "Slower.",
    "guidance.quicker": "A bit quicker.",
    "guidance.well_done": "Well done.",
}
