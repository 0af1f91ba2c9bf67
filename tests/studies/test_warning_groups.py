"""Warnings of many simulations by kind."""

from shockwave.studies.warning_groups import WarningGroups


def test_warnings_that_differ_in_numbers_alone_are_one_with_their_scenes() -> None:
    groups = WarningGroups()
    for index in range(8):
        groups.add([f"The force exceeds {index} N.", *["Rare."] * (index == 3)])
    groups.add([])
    frequent = "In 8 of 9 points (0, 1, 2, 3, 4, ...), greatest at point 7: The force exceeds 7 N."
    assert groups.sentences("points", numbered=True) == (frequent, "In 1 of 9 points (3): Rare.")
    assert groups.sentences(besides=["The force exceeds 12 kN."]) == ("In 1 of 9 scenes: Rare.",)


def test_a_warning_of_all_scenes_has_no_number() -> None:
    groups = WarningGroups()
    groups.add(["Always."])
    assert groups.sentences() == ("In all scenes: Always.",)


def test_the_greatest_value_is_stated_in_whatever_unit_and_at_whatever_contact() -> None:
    groups = WarningGroups()
    for ratio, force, contact in (("1.2", "172 N", 3), ("110", "1.2 kN", 20), ("9", "980 N", 1)):
        place = f"at contact {contact}, between granule {contact} (steel-{contact}0) and the wall (rigid)"
        groups.add([f"A peak is {ratio} times that of first yield, {place}.", f"A force of at most {force}."])
    yields, later = groups.sentences("points")
    assert yields.startswith("In all points, here the greatest: A peak is 110 times that of first yield, at contact 20")
    assert later == "In all points, here the greatest: A force of at most 1.2 kN."
