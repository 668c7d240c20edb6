"""From a magnetic source and sensors to relative pose."""
