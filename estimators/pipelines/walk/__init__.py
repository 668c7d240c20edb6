"""From sensors and load cells on the feet to strides, forces and the centre of mass."""
