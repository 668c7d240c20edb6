"""Tables from anywhere: what their beginning says, how they are to be read, and reading them."""
