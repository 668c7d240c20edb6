"""The centre of mass of shoes and of worn sensors, as published and ours."""
