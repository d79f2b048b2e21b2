"""What the classifier says about any piece of an indoor image, to be subtracted."""

import base64

import numpy as np

from sceneq_core.arrays import Float32

_MEAN_LOGITS = (
    "ZrxTNVa7Grk/ufmyS7s/ty+4frcfqC+8crg9uca4LLgtupOyzrMZt7O1abX/t1i2tLgOuwSxv7ERvHa1sbmqtzq3erdg"
    "s464mbTMtkQ3p7hWtVa0yrFFLTu5NrJStQyxzbhpuCe5AS35uj65FbqVuje5qLgPufi1r7cluLmwLrQntPW33TA6umMu"
    "eLcPtRi5OrhVONy3dbmFt/utZjGlteclZLrkt1G2lLePJUK177IZtu+3frcYtrO2Z7pQrwuyaruguCIygrlkuNi4hrZp"
    "MDG6RLtau+G6drd8Koe7jisxt8638bi/ubC0zjXzuaS296wPuJy6obuqutmwwzBluEI09Livt7646rYeuaW4/bQ7uL23"
    "LbX7sSy0FrDJMJyzsbfMuJa28rENrPWhPbOErU4wirRNstKzJbMEtNsxrLEcsH21z7U4r0G0c7fHrz0t5jPCsuK4aqwp"
    "tLK2BDOcsOa1TLj4ts22lbXgp++4RycPt1OzOTAisJkpWbQLNBq1ypQNtx0xC7b8soWvUyqntui4hrWjsQq4eLXEsAEs"
    "OLT3sBy53CeZrgiwX7V7r160060Kr3y0q7m9NPqwoDQKNimw7bY2KbG36TNUtWy0Qbd7uAIu3a5Js9+rdrR0tTu0ELjJ"
    "sDm49riOuQysQazntZaq2rfztEq49zODK+2o4Ld9rQ62mCiAsSav8qVCLOW0xjGBp4ixLSgvtCS4wbeFp2ayTLTMrOWx"
    "hLhKuNG26Slctf2sF7IhLMWxU66euqe5bbUvuGC1tLkNtXyz/7VdtSI18LJepiq0QrnSti+2wLe2tA63LLwwuHS5Kbaj"
    "M7y1HLEVsI6wtLbLttO46LOlr+O2BraMteC34rVJuC25iricuI66rSj5t3C3HrhkuRw2CbOMuEi1OSR6t5OqFrWYuVa5"
    "rbZfuBG4VrsVtbS2Pa8atykxDzKzsxuc97W9rGm0SLPxpKy4Mbkauae3Gbtsumm6abDItQCxH7mCtKK227ZkuBuwP7j3"
    "uZe5mbvTuYq5gbXDtousw7QzueO1G7fItm0zU7gUt1GxWLTLrBU6kjqhOXG6TqsQm0g1Qzu9NC00XLCtPDIujK0bOkU6"
    "uLenuJA9FjPCPDpA9rA0PeszhLECvSS5HDnsOfayqbF4Np85/DUfsIU4RT3ltOAwIz0VODW5KLQMNLE1ULTjuANCsjKc"
    "NlamszS4O4+1GD2XuRetezVrtwm10qNXs1CylDyYNMUxQD01qJy8ybaauMw7y7Nzs6E9F7b3tLO5hDr0QDa6GjljOhs4"
    "g7QnMcSmmLA7upo3eS1RM1M7eTx4PUJAUDgUsHS4A61jPo4vkTPLNw82XrNAtpa1aDpfMQ66cTn1sCCpOraRrxKzqz/9"
    "OVW1Zj4EPO2zNzmXqgKM1K5VQM06sLy6MIk9IDkdQFazsTw9uhm4Sq+usNM6SjaJpzgtUznxuBA0lbRSuXQ9akAUMLY8"
    "cbjIP2qwNLrdQC6tPzSTPXG50jhttC2xATo3tAS48RkouCeog6wGve+o467OqyqqILUjPai93jScu+m9QLksQZA6Rjl/"
    "NFk10jgQNAE5sjuPs3MxgjdFtG487LnaOjM3tj7ANOM5YbVDPt+x5jmjMR2zBbvSO30yrLCWOuW04DwfNFU6w7h7Pew6"
    "jLpruEU+ojlvLe46Nq/bsNo1CzWCO/Q7vz1wNrI7fjQCM1W5KzAFutA4bzuItDU6fbpqPMc59zyMsPy2iz6/uSU6U7T1"
    "sr2wZTsZrlq4HTisuGA++jXRNQe5P7MmO1SyNTLIuC+4raIRKeM+3TzJOGc9OjzhuKA+AbBKrEs75Tolu+s9Xi+oMBg4"
    "d6ulrRo63rAvN0mvEDSSrI63aD0wQPY5ez6uJY63MRwlOTq2skCctRo6hSPqOl4+tjnzMzE1wLc8pEOwczsOs+U4GTcP"
    "tDa3Ij75MWk6SUEeN+w967SJNVGzaLk8PDC6QTcqPII59TxAPAQ63zrCOK86Ej4Rt/Y6PzkaKbW0QzmWt8ktvbDgpuAz"
    "w7kPOTWpgyI5Oz6v1DmPMaM7NrnTP8u15T0rPruo7q3Hs2243jbUOrG0M7MNOitAIDquNXW7LTmytcCzLEFuNWC1uzTa"
    "LIc7vDm4Nvc1FEAaPIO3q7gCuQQ5kj5vNsUxbTylteC4RjsbQJs8Bz25OSi1HLrisdU84bH7uxozASIesmOwLLYCML07"
    "WbhmvP88kkFPMbkoXiIcs8IxrbU3PZa8yjg3OhA3U6vWPxaxvECdpISxtbd1uHo+ZjXOtcw6Wzg7Oig42DCTL103mzl1"
    "OAe2G7RTtgS2nC6FOSw1x7ZaNtE6/7Umt/m30DkQOzs0XaPXMvs9UbbqN5AywjyEuHQ1SrreuHeX0rKuPjQ57D4aOHc/"
    "YK+BsEU2brZEOWw9vbRHPHA/ez1OtIY3C7zBuOo2pDpGtpQ4PLl8ObqsDzNZOT44AEDqq1i1qbVKKES5s7kSuDawVbZH"
    "uA+8+LYwuGa7Y7jUtIi5xbqPrui6rbUYuBy23LSqt+e61LjXtpG117quujC8NruhuBq5D7kquau5hrmauoC8Urrtu9m7"
    "objdume6ry7BMJW1HbpZt/ol6zObrfI48zVst0W33a2yula5eLTyth68wazVuQ65IrccteO3Crj3tB20Nq4WvOstjjU="
)
"""1000 float16, mean 0. Measured with the classifier of the conse encoder on 638 crops of 75
objects in two rendered rooms, each label with the same weight; it helps in a real room that was not
used for it (docs/adr/0003-embedded-encoder.md)."""


def indoor_prior() -> Float32:
    """Return the mean logits (1000,) of crops of indoor objects."""
    return np.frombuffer(base64.b64decode(_MEAN_LOGITS), "<f2").astype(np.float32)
