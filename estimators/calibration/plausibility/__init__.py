"""Whether readings can be right: units, axes, signs, clips, copies, against what does not depend on them."""
