"""The normal form in which outputs are frozen, and the comparison of two outputs in that form.

Tolerance: a number may differ by 1e-5 of its size, by 1e-9, or by one unit of its last printed digit.
The kernels choose AVX-512, AVX2 or SSE2 by the processor, and so does the C library. Their sums differ in the last bits.
Iterations amplify that: between AVX-512 and SSE2 the bound of `truepose plan` differs by 3e-6, all other outputs by less than 1e-6.
"""
import difflib
import json
import re

RELATIVE, ABSOLUTE = 1e-5, 1e-9
HEAD, TAIL, MOST_LINES = 80, 20, 260

# What differs between runs or machines. The gap of the rank has a rounding error as its divisor.
MASKS = [(re.compile(pattern, re.MULTILINE), mask) for pattern, mask in [
    (r"\b[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}\b", "<uuid>"),
    (r"\b\d{4}-\d\d-\d\dT[\d-]+\.\d+Z_\d+\.pcapng\b", "<recording>"),
    (r"\b([Cc]ampaign) [0-9a-f]{8}\b(?!-)", r"\1 <id>"),
    (r"\b\d{4}-\d\d-\d\d[T ]\d\d[:-]\d\d(?:[:-]\d\d(?:\.\d+)?)?(?:Z| UTC)?", "<time>"),
    (r"(?<![\w.])[0-9a-f]{64}\b", "<sha256>"),
    (r"(?<![\w.])(?:[0-9a-f]{32}|[0-9a-f]{16})\b", "<id>"),
    (r"\b((?:127\.0\.0\.1|localhost):)\d{2,5}\b", r"\1<port>"),
    (r"\bport \d+\b", "port <port>"),
    (r"\bprocess \d+\b", "process <pid>"),
    (r'\bversion="[^"]*"', 'version="<version>"'),
    (r"\bwith Boost .*", "with <libraries>"),
    (r" *\b[\d.]+ ms$", " <time>"),
    (r"^Gap \| [\d.e+]+", "Gap | <rounding>"),
    (r"\(\d+ kB\)", "(<size>)"),
    (r"\b(Needs|Excludes):((?: --[\w-]+)+)", lambda found: f"{found[1]}: {' '.join(sorted(found[2].split()))}"),  # of a set of pointers
    (r"\b(truepose[\w-]*|version) \d+\.\d+\.\d+[\w.+-]*", r"\1 <version>"),
]]

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?!\w|\.\d)")


def masked(text, masks=()):
    """A text with all masks applied. masks: further ones, (pattern, mask), which come first."""
    for pattern, mask in [*masks, *MASKS]:
        text = re.sub(pattern, mask, text)
    return text


def shortened(text):
    """The first and the last lines of a long text."""
    lines = text.splitlines()
    if len(lines) <= MOST_LINES:
        return "\n".join(lines)
    return "\n".join([*lines[:HEAD], f"[{len(lines) - HEAD - TAIL} lines between]", *lines[-TAIL:]])


def without_numbers(text):
    """A text with # in place of each number."""
    return re.sub(r" +", " ", NUMBER.sub("#", text))


def json_form(value, hidden=frozenset(), masks=()):
    """JSON with sorted members. hidden: members without a reproducible value. A long array is cut to its first three elements and its last."""
    def reduced(of):
        if isinstance(of, str):
            text = masked(of, masks)
            return [*text.splitlines()[:3], "[further lines]"] if text.count("\n") > 3 else text
        if isinstance(of, dict):
            return {masked(name, masks): f"<{name}>" if name in hidden else reduced(member) for name, member in sorted(of.items())}
        if isinstance(of, list):
            most = 3 if any(isinstance(element, (dict, list)) for element in of) else 12
            if len(of) > most + 1:
                return [*map(reduced, of[:3]), f"[{len(of) - 4} elements between]", reduced(of[-1])]
            return [*map(reduced, of)]
        return of

    def written(of, indent):
        inner = indent + " "
        if isinstance(of, dict) and of:
            members = [f"{inner}{json.dumps(name)}: {written(member, inner)}" for name, member in of.items()]
            return "{\n" + ",\n".join(members) + f"\n{indent}}}"
        if isinstance(of, list) and any(isinstance(element, (dict, list)) for element in of):
            return "[\n" + ",\n".join(inner + written(element, inner) for element in of) + f"\n{indent}]"
        return json.dumps(of, ensure_ascii=False)

    return written(reduced(value), "")


def output_text(text, hidden=frozenset(), masks=()):
    """A printed or written text: JSON with sorted members, any other by its lines."""
    try:
        document = json.loads(text)
    except ValueError:
        return shortened(masked(text, masks))
    return json_form(document, hidden, masks)


def shape(*values, hidden=frozenset()):
    """The paths of all members of JSON values with their types, one a line. hidden: members whose types depend on the timing."""
    kinds = {bool: "boolean", int: "integer", float: "number", str: "string", type(None): "null"}
    found = {}

    def walk(of, path):
        if isinstance(of, dict):
            found.setdefault(path or ".", set()).add("object")
            for name, member in of.items():
                if name in hidden:
                    found[f"{path}.{name}"] = {"any type"}
                else:
                    walk(member, f"{path}.{name}")
        elif isinstance(of, list):
            found.setdefault(path or ".", set()).add("array")
            for element in of:
                walk(element, path + "[]")
        else:
            found.setdefault(path or ".", set()).add(kinds[type(of)])

    for value in values:
        walk(value, "")
    return "\n".join(f"{path}: {' or '.join(sorted(types))}" for path, types in sorted(found.items()))


def last_digit(number):
    """One unit of the last printed digit; of an integer 0."""
    digits, _, exponent = number.lower().partition("e")
    decimals = len(digits.partition(".")[2])
    return 10.0 ** (int(exponent or 0) - decimals) if decimals or exponent else 0


def is_near(a, b):
    """Whether two lines have the same words and, within the tolerance, the same numbers. Blanks before a number depend on its digits."""
    if a == b:
        return True
    if [part.rstrip(" ") for part in NUMBER.split(a)] != [part.rstrip(" ") for part in NUMBER.split(b)]:
        return False
    for one, other in zip(NUMBER.findall(a), NUMBER.findall(b)):
        x, y = float(one), float(other)
        units = [unit for unit in (last_digit(one), last_digit(other)) if unit]
        if abs(x - y) > max(RELATIVE * max(abs(x), abs(y)), ABSOLUTE, 1.001 * min(units, default=0)):
            return False
    return True


def difference(name, frozen, found):
    """A compact unified diff of what differs beyond the tolerance; empty: nothing."""
    a, b = frozen.splitlines(), found.splitlines()
    if len(a) == len(b) and all(map(is_near, a, b)):
        return ""
    words_a, words_b = ([re.sub(r" *" + NUMBER.pattern, "#", line) for line in lines] for lines in (a, b))
    for block in difflib.SequenceMatcher(None, words_a, words_b, autojunk=False).get_matching_blocks():
        for i, j in zip(range(block.a, block.a + block.size), range(block.b, block.b + block.size)):
            if is_near(a[i], b[j]):
                b[j] = a[i]
    return "\n".join(difflib.unified_diff(a, b, f"frozen/{name}", f"now/{name}", n=1, lineterm=""))
