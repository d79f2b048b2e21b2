"""Questions for what is not in a room."""

from sceneq_tools.evaluation.absent_names import absent_names, absent_purposes
from sceneq_tools.evaluation.true_things import TrueThing

from support.furnished import ROOM, router

THINGS = tuple(
    TrueThing(number, f"thing {number}", (thing.name,), False, 0)
    for number, thing in enumerate(ROOM, 1)
)
ROUTER = router()


def asked(things=THINGS):
    return {query.text for query in absent_names(ROUTER, things, 200)}


def test_labels_that_name_nothing_there_are_asked_for():
    assert {"bathtub", "piano", "guitar", "toilet"} <= asked()
    assert all(query.is_absent for query in absent_names(ROUTER, THINGS))


def test_what_is_there_or_shares_a_word_with_it_is_not():
    assert asked().isdisjoint({"chair", "office chair", "table", "end table", "lamp", "couch"})


def test_parts_of_the_building_are_not():
    assert asked(()).isdisjoint({"wall", "floor", "ceiling"})
    assert "chair" in asked(())


def test_synonyms_are_names_too():
    sofa = TrueThing(99, "sofa", ("sofa", "bathtub"), False, 0)
    assert "bathtub" not in asked((*THINGS, sofa))


def test_many_of_them_are_spread_over_the_label_set():
    everything = [query.text for query in absent_names(ROUTER, THINGS, 200)]
    some = [query.text for query in absent_names(ROUTER, THINGS, 5)]
    assert len(some) == 5
    assert (some[0], some[-1]) == (everything[0], everything[-1])
    assert everything.index(some[2]) == (len(everything) - 1) // 2


def test_a_purpose_that_something_serves_is_not_asked_for_in_vain():
    sofa = TrueThing(99, "sofa", ("sofa",), False, 0, ("sit", "lie down"))
    mug = TrueThing(98, "mug", ("mug",), False, 0, ("drink from",))
    texts = [query.text for query in absent_purposes((sofa, mug))]
    assert "something to read" in texts
    assert {"somewhere to sit down", "something to drink from"}.isdisjoint(texts)
    assert all(not query.targets for query in absent_purposes((sofa, mug)))
    assert absent_purposes(THINGS) == ()  # nobody says what they are good for
