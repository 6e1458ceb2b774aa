"""Twenty names in the scripts of the font that comes with every installation, and one of another."""

NAMES = (
    "ANNA",
    "Otto",
    "Zoë",
    "Ünal",
    "María José",
    "Łukasz",
    "Søren",
    "Nguyễn",
    "ALEXANDRA",
    "LAB 42",
    "Ωμέγα",
    "Ἑλένη",
    "Иван",
    "Ђорђе",
    "Գոհար",
    "გიორგი",
    "שלום",
    "سلام",
    "♥",
    "李娜",
)
