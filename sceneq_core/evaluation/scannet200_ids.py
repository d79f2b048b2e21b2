"""The numbers of the ScanNet200 labels, and which of them are instances.

ScanNet's files say 'chair' as 2: the ``id`` column of ``scannetv2-labels.combined.tsv``.
"""

from sceneq_core.routing import scannet200

_HEAD_IDS = (
    "1 2 3 4 5 6 7 8 9 10 11 13 14 15 16 17 18 19 21 22 23 24 26 27 28 29 31 32 33 34 35 36 38 "
    "40 41 42 48 51 52 55 56 57 58 62 69 70 71 72 74 75 78 86 89 96 97 99 110 125 128 159 161 "
    "540 1163 1164 1165 1171"
)
_COMMON_IDS = (
    "39 44 45 46 47 49 50 54 59 63 64 65 66 67 68 73 76 77 80 82 84 87 90 93 95 98 101 104 105 "
    "106 107 116 120 121 122 131 132 134 136 139 140 141 154 156 165 177 188 191 193 213 214 "
    "250 276 283 323 342 609 748 1156 1166 1167 1168 1169 1173 1178 1183 1189 1191"
)
_TAIL_IDS = (
    "79 88 100 102 103 112 115 118 130 138 145 148 155 157 163 166 168 169 170 180 185 195 202 "
    "208 221 229 230 232 233 242 261 264 286 300 304 312 325 331 356 370 392 395 399 408 417 "
    "488 562 570 572 581 776 1170 1172 1174 1175 1176 1179 1180 1181 1182 1184 1185 1186 1187 "
    "1188 1190"
)
"""In the order of the labels in ``routing.scannet200``."""

NOT_INSTANCES = frozenset({"wall", "floor"})
"""Labels of surfaces, which the instance benchmark leaves out: 198 classes remain."""


def _numbered(labels: str, ids: str) -> dict[int, str]:
    return dict(zip(map(int, ids.split()), labels.split(", "), strict=True))


_SPLITS = {
    "head": _numbered(scannet200.HEAD, _HEAD_IDS),
    "common": _numbered(scannet200.COMMON, _COMMON_IDS),
    "tail": _numbered(scannet200.TAIL, _TAIL_IDS),
}

LABELS = {number: name for split in _SPLITS.values() for number, name in split.items()}
"""Number -> label, all 200."""

INSTANCE_CLASSES = {n: name for n, name in LABELS.items() if name not in NOT_INSTANCES}
"""Number -> label of the 198 classes in which instance AP is measured."""

SPLITS = {
    split: frozenset(numbered.values()) - NOT_INSTANCES for split, numbered in _SPLITS.items()
}
"""``head``, ``common``, ``tail`` -> the labels of their instance classes."""
