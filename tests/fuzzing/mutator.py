"""Damage to texts and other bytes: what disks, editors and other programs do to files."""

import re
from collections.abc import Callable, Sequence
from random import Random

MOST = 200_000
"""Bytes of an input."""
LONG = 20_000
"""Bytes, characters or levels of what is long."""
NUMBERS = (
    b"0", b"-0", b"1", b"-1", b"2", b"0.5", b"-1e-320", b"1e-9", b"nan", b"NaN", b"inf",
    b"-Infinity", b"1e300", b"-1e300", b"1e308", b"1e400", b"1e18", b"255", b"65536",
    b"2147483648", b"9223372036854775807", b"9223372036854775808", b"-9223372036854775809",
    b"18446744073709551616", b"1" + b"0" * 400, b"1" + b"0" * 5000, b"1_0", b"0x10", b"00", b"+5",
    b"5.", b".5", b"1,5", "٣".encode(), b"true", b"null", b"''", b'"x"', b"[]", b"{}", b"",
)  # fmt: skip
PIECES = (
    b"\xef\xbb\xbf", b"\xff\xfe", b"\x00", b"\r\n", b"\r", b"\n", b"\n\n", b"\xe9", b"\xed\xa0\x80",
    b"\x1b[31m", b"\x0c", b"\x85", "\u2028".encode(), b" ", b"\t", b",", b";", b'"', b"'", b"\\",
    b"=", b"#", b"[", b"]", b"{", b"}", b"<", b">", b"&", b"|", b"%s", b"/", b"../",
)  # fmt: skip
NESTS = ((b"[", b"]"), (b"{", b"}"), (b'{"a":', b"}"), (b"a.", b""), (b"a = [", b"]"), (b"(", b""))

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_]+")

Change = Callable[[Random, bytes, Sequence[bytes]], bytes]


def mutate(rng: Random, seeds: Sequence[bytes]) -> bytes:
    """Return one of the seeds with one to six changes."""
    data = rng.choice(seeds)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        data = rng.choice(CHANGES)(rng, data, seeds)[:MOST]
    return data


def _span(rng: Random, data: bytes, longest: int = 40) -> tuple[int, int]:
    """Return where a part of the data begins and ends."""
    start = rng.randint(0, len(data))
    return start, min(len(data), start + rng.randint(0, longest))


def _flip(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    flipped = bytearray(data)
    for _time in range(rng.choice((1, 1, 4, 16)) if data else 0):
        flipped[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(flipped)


def _cut(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    place = rng.randint(0, len(data))
    return data[:place] if rng.random() < 0.8 else data[place:]


def _remove(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    start, end = _span(rng, data)
    return data[:start] + data[end:]


def _insert(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    place = rng.choice((0, len(data), rng.randint(0, len(data))))
    piece = rng.choice(PIECES) if rng.random() < 0.8 else rng.randbytes(rng.randint(1, 8))
    return data[:place] + piece + data[place:]


def _splice(rng: Random, data: bytes, seeds: Sequence[bytes]) -> bytes:
    other = rng.choice(seeds)
    return data[: rng.randint(0, len(data))] + other[rng.randint(0, len(other)) :]


def _replaced(rng: Random, data: bytes, what: re.Pattern[bytes], new: bytes) -> bytes:
    """Return the data with one of what fits a pattern replaced, or now and then all of it."""
    found = list(what.finditer(data))
    if not found:
        return data
    if rng.random() < 0.05:
        return what.sub(lambda _: new, data)
    place = rng.choice(found)
    return data[: place.start()] + new + data[place.end() :]


def _number(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    return _replaced(rng, data, _NUMBER, rng.choice(NUMBERS))


def _word(rng: Random, data: bytes, seeds: Sequence[bytes]) -> bytes:
    words = _WORD.findall(rng.choice(seeds)) or [b"x"]
    return _replaced(rng, data, _WORD, rng.choice(words))


def _lines(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    """Repeat, drop or move lines, or give them other ends."""
    lines = data.split(b"\n")
    first, second = rng.randrange(len(lines)), rng.randrange(len(lines))
    match rng.randrange(5):
        case 0:
            lines.insert(second, lines[first])
        case 1:
            lines[first : first + rng.randint(1, 3)] = []
        case 2:
            lines[first], lines[second] = lines[second], lines[first]
        case 3:
            lines[first:first] = [lines[first]] * rng.randint(2, 200)
        case _:
            return data.replace(b"\n", rng.choice((b"\r\n", b"\r", b"", b"\n\n", b" ")))
    return b"\n".join(lines)


def _lengthen(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    """Repeat a part of the data many times."""
    start, end = _span(rng, data, 12)
    return data[:start] + data[start:end] * rng.choice((2, 50, LONG // 12)) + data[end:]


def _nest(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    start, end = _span(rng, data)
    (left, right), depth = rng.choice(NESTS), rng.choice((3, 300, LONG))
    return data[:start] + left * depth + data[start:end] + right * depth + data[end:]


def _length(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    """Put an extreme or a small number where a length of a binary file may be."""
    size = rng.choice((2, 4, 8))
    value = rng.choice((0, 1, 255, (1 << 8 * size) - 1))
    place = rng.randint(0, len(data))
    return data[:place] + value.to_bytes(size, rng.choice(("big", "little"))) + data[place + size :]


def _empty(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    return rng.choice((b"", b"\n", b" ", rng.choice(PIECES), bytes(len(data))))


def _encode(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    coding = rng.choice(("utf-16", "utf-32-le", "utf-8-sig"))
    return data.decode("latin-1").encode(coding)


CHANGES: tuple[Change, ...] = (
    *(_number,) * 6, *(_word,) * 3, *(_lines,) * 3, *(_flip,) * 3, *(_insert,) * 3, *(_cut,) * 2,
    *(_remove,) * 2, *(_length,) * 2, _splice, _lengthen, _nest, _empty, _encode,
)  # fmt: skip
"""More often what gets farther into a parser."""
