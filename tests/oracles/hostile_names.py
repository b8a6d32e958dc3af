"""Names that a language, a file or a terminal may take for more than a name, by kind; the same ones for every run."""

import random
import string
from collections.abc import Callable

CANARY = "DROP TABLE secret"
"""Statement that names for SQL try to run; the table `secret` must survive."""

Kind = Callable[[random.Random], str]

SQL = (
    "**// FROM readings; DROP TABLE secret; --",
    "*/ FROM readings; DROP TABLE secret; /*",
    'a"; DROP TABLE secret; --',
    '" <= 0 THEN 1 END FROM readings; DROP TABLE secret; --',
    "'; DELETE FROM secret; --",
    'x""y"',
    "`a`; DROP TABLE secret",
    "[a]; DROP TABLE secret",
    "$$; DROP TABLE secret; $$",
    "a -- b",
)
KEYWORDS = ("select", "from", "NULL", "case", "END", "order by", "true", "rowid", "int", "return", "while", "digraph")
C = (
    "*/ int system(const char *); /*",
    "*/ #include <stdlib.h>",
    "a??/",
    "a\\",
    "a\\\n#error canary",
    "??/\n#error canary",
    "// a",
    '"; abort(); "',
    "%:error x",
)
HTML = (
    "<script>window.__pwned=1</script>",
    "</script><script>window.__pwned=1</script>",
    "</pre><img src=x onerror=window.__pwned=1>",
    '"><svg onload=window.__pwned=1>',
    "' onmouseover='window.__pwned=1",
    "</title><script>alert(1)</script>",
    "</style><script>alert(1)</script>",
    "<!--",
    "-->",
    "]]>",
    "<![CDATA[",
    "&lt;b&gt;",
    "&#x41;",
    "javascript:alert(1)",
    "<iframe src=https://example.org>",
    "<meta http-equiv=refresh content=0;url=https://example.org>",
    "<base href=https://example.org>",
    "@import url(https://example.org)",
    "<a href=javascript:alert(1)>x</a>",
    "\u2028alert(1)\u2029",
)
DOT = (r"\N", r"\G", r"\L", r"a\lb\rc", r"\E\T\H", "<b>bold</b>", "<<b>x</b>>", 'a"]; n9 [label="x', "a\\", "n0 -> n1;")
MARKDOWN = (
    "a|b",
    "a\\|b",
    "`code`",
    "```",
    "[x](javascript:alert(1))",
    "![x](https://example.org/a.png)",
    "# head",
    "- item",
    "> quote",
    "**bold**",
    "_em_",
    "https://example.org",
    "www.example.org",
    "a\n\n# forged",
    "~~gone~~",
    "<details open>",
    "\\",
)
FORMATS = (
    "%s%n%d",
    "%(x)s",
    "{0}",
    "{name.__class__}",
    "{{7*7}}",
    "${7*7}",
    "$(id)",
    "`id`",
    "#{7*7}",
    "<%= 7*7 %>",
    "%%",
)
PATHS = (
    "../../etc/passwd",
    "/etc/passwd",
    "..\\..\\boot.ini",
    "C:\\x41",
    "a/b",
    "file:///etc/passwd",
    "con",
    "a\0.csv",
)
FORMULAS = (
    "=cmd|' /C calc'!A0",
    "=1+1",
    "+1",
    "-1",
    "@SUM(A1)",
    "\t=1+1",
    "\r=1+1",
    '=HYPERLINK("http://x","y")',
    "1,2",
    '"',
)
TEX = (
    "$",
    "$$",
    "a$b$c",
    r"$\frac{1}{0$",
    r"$\undefined$",
    r"\$",
    r"\input{/etc/passwd}",
    "x_1^2",
    r"$\alpha$ $",
    "_hidden",
)
TWINS = (
    "\u00e9",
    "e\u0301",
    "\u212b",
    "\u00c5",
    "A\u030a",
    "\ufb01",
    "fi",
    "\u0410",
    "A",
    "a",
    "\u017f",
    "s",
    "\u0131",
    "i\u0307",
)
DIRECTIONS = (
    "\u202egnp.exe",
    "a\u202eb\u202cc",
    "\u2066a\u2069",
    "\u2067 x",
    "\u200f)(",
    "\u061c1",
    "\u05e9\u05dc\u05d5\u05dd",
    "\u0645\u0631\u062d\u0628\u0627 12",
    "a \u05d0 <= 5 \u05d1",
    "\u2068",
    "\u2069",
)
UNSEEN = (
    "",
    " ",
    "  ",
    "\t",
    "\n",
    "a ",
    " a",
    "\u200b",
    "a\u200bb",
    "\ufeff",
    "\u2060",
    "\u3164",
    "\u2800",
    "\u00a0",
    "\u00ad",
    "\u034f",
)
EMOJI = (
    "\U0001f600",
    "\U0001f468\u200d\U0001f469\u200d\U0001f467",
    "\u2764\ufe0f",
    "\U0001f1e9\U0001f1ea",
    "\u4f60\u597d",
    "\U0001d54f",
)
ANSI = (
    "\x1b[31mred\x1b[0m",
    "\x1b[2J\x1b[H",
    "\x1b]0;title\x07",
    "\x1b]8;;https://example.org\x1b\\x\x1b]8;;\x1b\\",
    "\x9b31m",
    "a\rb",
    "a\bb",
    "\x07",
    "\x7f",
    "\x85",
    "\x0b\x0c",
)
UNENCODABLE = ("\ud800", "a\udfff", "\udc80\udcff", "\ude00\ud83d", "\0", "a\0b", "\uffff", "\ufdd0", "\U0010ffff")


def _listed(names: tuple[str, ...]) -> Kind:
    """Return a kind that gives the listed names, joined with others of them and with plain text."""
    return lambda rng: "".join(rng.choice((*names, "g01", " ")) for _ in range(rng.randint(1, 3)))


def _control(rng: random.Random) -> str:
    codes = rng.choices([*range(32), *range(127, 160)], k=rng.randint(1, 4))
    return "".join(map(chr, codes)) + rng.choice(("", "g"))


def _any_character(rng: random.Random) -> str:
    return "".join(chr(rng.randrange(0x110000)) for _ in range(rng.randint(1, 8)))


def _punctuation(rng: random.Random) -> str:
    return "".join(rng.choice(string.punctuation + " ") for _ in range(rng.randint(1, 24)))


def _long(rng: random.Random) -> str:
    piece = rng.choice(("g", "\U0001f600", '"', "*/", "<b>", "\\", "a b", "'", "\u0301"))
    return (piece * 10_000)[: 10_000 - 8] + f"{rng.randrange(10**8):08d}"


KINDS: dict[str, tuple[tuple[str, ...], Kind]] = {
    "SQL": (SQL, _listed(SQL)),
    "keyword": (KEYWORDS, _listed(KEYWORDS)),
    "C": (C, _listed(C)),
    "HTML": (HTML, _listed(HTML)),
    "DOT": (DOT, _listed(DOT)),
    "Markdown": (MARKDOWN, _listed(MARKDOWN)),
    "format, template": (FORMATS, _listed(FORMATS)),
    "path": (PATHS, _listed(PATHS)),
    "formula": (FORMULAS, _listed(FORMULAS)),
    "TeX": (TEX, _listed(TEX)),
    "Unicode twin": (TWINS, _listed(TWINS)),
    "direction": (DIRECTIONS, _listed(DIRECTIONS)),
    "unseen": (UNSEEN, _listed(UNSEEN)),
    "emoji": (EMOJI, _listed(EMOJI)),
    "ANSI": (ANSI, _listed(ANSI)),
    "unencodable": (UNENCODABLE, _listed(UNENCODABLE)),
    "control": ((), _control),
    "any character": ((), _any_character),
    "punctuation": ((), _punctuation),
    "10,000 characters": ((), _long),
}


def hostile_names(count: int, seed: int = 0) -> list[tuple[str, str]]:
    """Return `count` pairs of kind and name, all names different, the kinds in turn, listed names first.

    The names of a kind come in an order drawn by `seed`, so that a small count takes some of every kind.
    """
    rng = random.Random(seed)
    waiting = {kind: rng.sample(listed, len(listed)) for kind, (listed, _) in KINDS.items()}
    found: dict[str, str] = {}
    while len(found) < count:
        for kind, (_, draw) in KINDS.items():
            name = waiting[kind].pop() if waiting[kind] else draw(rng)
            if len(found) < count:
                found.setdefault(name, kind)
    return [(kind, name) for name, kind in found.items()]
