"""Warnings of many simulations by kind."""

from shockwave.studies.warning_groups import WarningGroups


def test_warnings_that_differ_in_numbers_alone_are_one_with_their_scenes() -> None:
    groups = WarningGroups()
    for index in range(8):
        groups.add([f"The force exceeds {index} N.", *["Rare."] * (index == 3)])
    groups.add([])
    frequent = "In 8 of 9 points (0, 1, 2, 3, 4, ...), here the first: The force exceeds 0 N."
    assert groups.sentences("points", numbered=True) == (frequent, "In 1 of 9 points (3): Rare.")
    assert groups.sentences(besides=["The force exceeds 12 kN."]) == ("In 1 of 9 scenes: Rare.",)


def test_a_warning_of_all_scenes_has_no_number() -> None:
    groups = WarningGroups()
    groups.add(["Always."])
    assert groups.sentences() == ("In all scenes: Always.",)
