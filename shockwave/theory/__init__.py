"""The paper's relations, as functions of a scaled shock: nothing here knows a unit or a simulation."""
