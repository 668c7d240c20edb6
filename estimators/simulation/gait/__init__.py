"""A person who walks: course, feet, trunk, forces under the shoes, with exact truth."""
