"""What people say: purposes in words, names that mean several things, things a home may lack."""

from sceneq_tools.room.category import Category

PURPOSES: tuple[tuple[str, frozenset[str]], ...] = tuple(
    (text, frozenset(verbs))
    for text, *verbs in (
        ("something to drink from", "drink from"),
        ("somewhere to sit down", "sit", "lie down", "sleep"),
        ("somewhere to lie down", "lie down", "sleep"),
        ("something that gives light", "read in the dark", "light the room"),
        ("something to read", "read", "read the news"),
        ("something to cut paper with", "cut paper"),
        ("something to warm up my lunch in", "heat up food", "cook"),
        ("a place to cook dinner", "cook"),
        ("something to make coffee with", "make coffee"),
        ("something to boil water for tea", "boil water", "cook"),
        ("something to pour tea from", "pour tea"),
        ("where do I throw away garbage", "throw away trash"),
        ("a place to keep my clothes", "store clothes"),
        ("a place to keep books", "store books"),
        ("where can I keep milk cold", "keep food cold"),
        ("where can I wash the dishes", "wash dishes"),
        ("where can I wash my clothes", "wash clothes"),
        ("a place to keep plates and dishes", "store dishes"),
        ("a place to file documents", "store documents"),
        ("something to browse the internet with", "browse the internet"),
        ("something to watch a movie on", "watch movies", "browse the internet"),
        ("something to listen to music with", "listen to music", "browse the internet"),
        ("an instrument to play music on", "play music"),
        ("something to take a photo with", "take a photo", "browse the internet"),
        ("something that tells the time", "check the time"),
        ("something that shows the date", "check the date"),
        ("something to put out a fire with", "put out a fire"),
        ("something that cools me down", "cool down"),
        ("something to eat", "eat"),
        ("an alcoholic drink", "pour wine", "pour beer"),
        ("something to make toast with", "toast bread"),
        ("something to print a document with", "print a document"),
        ("something to play with", "play", "play a board game", "play video games", "cuddle"),
        ("a board game", "play a board game"),
        ("something to play video games with", "play video games"),
        ("something to make a phone call with", "make a phone call"),
        ("something to carry my things in", "carry things", "carry documents",
         "pack clothes for a trip", "store things"),
        ("something to pack my clothes in for a trip", "pack clothes for a trip", "carry things"),
        ("something to wear on my feet", "wear on the feet"),
        ("something to wear on my head", "wear on the head", "protect the head"),
        ("something to chop vegetables with", "cut vegetables"),
        ("something to wipe up a spill with", "wipe up a spill"),
        ("something to change the TV channel with", "change the TV channel"),
        ("something to season my food with", "season food"),
        ("something to weigh flour with", "weigh ingredients"),
        ("something to mix dough with", "mix dough"),
        ("something to blend fruit with", "blend fruit"),
        ("something soft to cuddle", "cuddle"),
        ("something to serve food in", "hold food"),
        ("something to write with", "write"),
        ("something to staple papers with", "staple papers"),
        ("something to put flowers in", "hold flowers"),
    )
)  # fmt: skip
"""Question, and every affordance that serves it: whatever has one of them is a right answer."""

SAME: tuple[frozenset[str], ...] = tuple(
    frozenset(words)
    for words in (
        ("mug", "cup", "glass", "tumbler"),
        ("flowers", "tulips", "orchid"),
        ("picture", "painting", "poster", "photo", "print", "picture frame", "photo frame"),
        ("sofa", "couch", "loveseat"),
        ("dresser", "chest of drawers", "sideboard", "commode"),
        ("kitchen cabinet", "upper cabinet", "wall cabinet", "kitchen sink", "cupboard"),
        ("bookcase", "bookshelf", "shelf", "shelves"),
        ("rug", "carpet", "mat"),
        ("desk lamp", "table lamp"),
        ("laptop", "notebook computer"),
        ("television", "monitor", "screen", "tv", "desktop computer"),
        ("pan", "pot", "saucepan", "cooking pot"),
        ("kettle", "teapot"),
        ("plate", "dish", "saucer"),
        ("hat", "cap"),
        ("sneakers", "shoes", "slippers", "boots"),
        ("pillow", "cushion"),
        ("speaker", "radio", "stereo"),
        ("coffee maker", "espresso machine", "coffee machine"),
        ("mixer", "blender"),
        ("telephone", "phone", "cordless phone"),
        ("handbag", "purse"),
        ("armchair", "loveseat"),
    )
)
"""Names, or the nouns at their heads, that people use for each other's things."""

KINDS: dict[str, frozenset[str]] = {
    general: frozenset(kinds)
    for general, *kinds in (
        ("chair", "armchair", "stool"),
        ("table", "desk", "nightstand"),
        ("cabinet", "dresser", "wardrobe", "nightstand", "sideboard", "tv stand"),
        ("bag", "backpack", "handbag", "briefcase"),
        ("basket", "trash can"),
        ("ball", "basketball", "football"),
        ("computer", "laptop", "tablet"),
        ("clock", "watch"),
        ("bed", "sofa bed"),
        ("toy", "teddy bear", "puzzle cube", "basketball"),
        ("plant", "cactus", "succulent", "bonsai", "orchid", "flowers"),
        ("potted plant", "cactus", "succulent", "bonsai", "bonsai tree", "orchid"),
        ("houseplant", "cactus", "succulent", "bonsai", "bonsai tree", "orchid"),
        ("milk", "milk carton"),
        ("bottle", "milk carton", "flask"),
    )
}
"""General names, and the heads of what else they cover besides things with that word in them."""

ABSENT: tuple[str, ...] = (
    "bathtub", "bicycle", "grand piano", "fish tank", "ironing board", "umbrella", "ladder",
    "treadmill", "toilet", "surfboard", "lawn mower", "wheelchair", "fireplace", "baby stroller",
    "sewing machine", "shower", "pool table", "birdcage", "hair dryer", "violin", "christmas tree",
    "tent", "motorcycle", "drum kit", "telescope", "skateboard", "vacuum cleaner", "tennis racket",
    "typewriter", "rocking horse", "canoe", "traffic light", "barbecue grill", "sled",
)  # fmt: skip
"""Things of homes that no library has; every room is checked for their names all the same."""

_SMALL_WORDS = frozenset({"of", "the", "a", "an", "and", "to", "go", "with"})


def names(category: Category) -> tuple[str, ...]:
    """Return everything a category is called, the label first."""
    return (category.label, *category.synonyms)


def could_mean(phrase: str, category: Category) -> bool:
    """Tell whether somebody who says ``phrase`` could be content with such a thing.

    So it is when the phrase names it, is part of its name ("table" and "coffee table"), covers
    it ("chair" and "armchair"), or is a word for the same ("coffee mug" and "plastic cup").
    """
    said = content_words(phrase)
    return any(said <= content_words(name) or _alike(phrase, name) for name in names(category))


def content_words(text: str) -> frozenset[str]:
    """Return the words of a name that say what it is."""
    return frozenset(text.lower().replace("-", " ").split()) - _SMALL_WORDS


def head(name: str) -> str:
    """Return the noun of a name: "mug" of "coffee mug", "vase" of "vase of flowers"."""
    words = name.lower().replace("-", " ").split(" of ")[0].split()
    return words[-1] if words else ""


def _alike(phrase: str, name: str) -> bool:
    said, called = {phrase.lower(), head(phrase)}, {name.lower(), head(name)}
    if KINDS.get(phrase.lower(), frozenset()) & called:
        return True
    return any(said & group and called & group for group in SAME)
