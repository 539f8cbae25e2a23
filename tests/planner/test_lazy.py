"""Attributes worked out when first asked for."""

from walking_console.planner.lazy import lazy


class Square:
    """Counts how often its area is worked out."""

    def __init__(self, side: float) -> None:
        self.side = side
        self.times = 0

    @lazy
    def area(self) -> float:
        """Of all of it."""
        self.times += 1
        return self.side**2


def test_what_is_lazy_is_worked_out_once_and_only_when_asked_for() -> None:
    square = Square(3.0)
    assert square.times == 0
    assert (square.area, square.area, square.times) == (9.0, 9.0, 1)


def test_every_object_has_its_own() -> None:
    assert [Square(2.0).area, Square(5.0).area] == [4.0, 25.0]


def test_of_the_class_it_is_what_works_it_out_with_its_words() -> None:
    assert Square.area.__doc__ == "Of all of it."
    assert Square.area.work(Square(4.0)) == 16.0
