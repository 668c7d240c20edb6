"""From sensors on trunk and arms to joint angles."""
