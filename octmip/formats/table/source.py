"""Where a table comes from: a file, plain or compressed by gzip, or standard input."""

import codecs
import gzip
import io
import re
import sys
import unicodedata
import zlib
from dataclasses import dataclass, field
from pathlib import Path

from octmip.errors import DataError
from octmip.input import files
from octmip.input.files import PathLike, decoded, read_bytes

STANDARD_INPUT = "-"
GZIP, PARQUET = b"\x1f\x8b", b"PAR1"
EXPORT = "expected text (.csv, .tsv), plain or packed by gzip, or .parquet; export the table as CSV"
NO_TEXT = {
    b"PK\x03\x04": "an archive, such as a workbook (.xlsx, .ods)",
    b"\xd0\xcf\x11\xe0": "a workbook (.xls)",
    b"\xfd7zXZ\x00": "compressed by xz",
    b"BZh91AY": "compressed by bzip2",
    b"\x28\xb5\x2f\xfd": "compressed by Zstandard",
    b"ARROW1\0": "an Arrow file (Feather)",
    b"SQLite format 3": "a database of SQLite",
    b"\x89HDF": "an HDF5 file",
}
"""What files begin with that hold tables, but no text."""
NO_TABLE = {
    re.compile(PARQUET): "a Parquet file; expected its name to end in .parquet; rename it",
    re.compile(rb"\s*<(?:!doctype|html|table|\?xml|stata_dta)", re.IGNORECASE): "a page, XML or Stata's; " + EXPORT,
    re.compile(rb'\s*(?:\{\s*"|\[\s*[\[{])'): "JSON; " + EXPORT,
    re.compile(rb"(?:\s*%[^\n]*\n)*\s*@relation\s", re.IGNORECASE): "ARFF, as Weka and KEEL write it; " + EXPORT,
    re.compile(rb"[+-]?[\d.]+(?: \d+:\S+)+ *\r?\n"): "sparse rows of LIBSVM; " + EXPORT,
    re.compile(rb".{0,127}[\x00\x02-\x08\x0e-\x19\x1c-\x1f]", re.DOTALL): "no text but a binary file; " + EXPORT,
}
"""What is no table although it may be decoded as text, and what to do."""
PIECE = 2**20  # bytes that are unpacked at a time
SMALL = 2**26  # unpacked bytes that any packed table may have
MOST_TIMES = (
    200  # a larger one may unpack to so many times its size: readings reach 3, flags 9 to 80, sorted copies 160
)
PADDING = "\0\x1a"
"""What programs of CP/M's descent and loggers with blocks of a fixed size write behind the last line."""
BOX = str.maketrans(dict.fromkeys("│┃║", "|") | dict.fromkeys("─━═┄╌┌┬┐├┼┤└┴┘╞╪╡╭╮╯╰┏┳┓┡╇┩╔╦╗╠╬╣╚╩╝", "-"))
"""The lines of a box around a table, as the shells of databases draw them."""
MINUS = re.compile(r"(^|[,;\t|\"])( *)\u2212(?=\.?[0-9])", re.MULTILINE)
"""The minus of typesetters where a cell begins as a number, as spreadsheets write it in some languages."""
ENDINGS = {".csv": "csv", ".tsv": "tsv", ".tab": "tsv", ".parquet": "parquet"}


@dataclass(frozen=True, slots=True, eq=False)
class Source:
    """A table that can be read, more than once.

    Attributes
    ----------
    path
        of the file, "-" for standard input.
    format
        "csv", "tsv" or "parquet".
    held
        the content where it was read to find the format; None where the name said it.
    """

    path: Path
    format: str
    held: bytes | None = field(default=None, repr=False)

    @property
    def name(self) -> str:
        """The source as a sentence names it."""
        return _name(self.path)

    def content(self) -> bytes:
        """Return the bytes of the table, unpacked where they were compressed.

        Raises
        ------
        DataError
            they cannot be read, are too many, or are no gzip although they begin so.
        """
        packed = read_bytes(self.path) if self.held is None else self.held
        _refuse_no_text(packed, self.name)
        return unpacked(packed, self.name) if packed.startswith(GZIP) else packed

    def text(self) -> tuple[str, tuple[str, ...]]:
        """Return the text of a table, and a note where it is not in UTF-8 but in Windows-1252, which holds latin-1.

        Raises
        ------
        DataError
            as `content`, or it is neither.
        """
        text, told = self._decoded()
        if not _escapes_quotes(text):
            return text, told
        return text.replace('\\"', '""'), (*told, f'\\" stands for a quotation mark within the texts of {self.name}')

    def _decoded(self) -> tuple[str, tuple[str, ...]]:
        content = _marked(self.content())
        is_wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
        what = "" if is_wide else next((what for mark, what in NO_TABLE.items() if mark.match(content)), "")
        if what:
            raise DataError(f"{self.name} is {what}")
        try:
            text = _with_line_feeds(decoded(content, self.name))
            if "\0" in text:
                line = text[: text.index("\0")].count("\n") + 1
                raise DataError(f"{self.name}, line {line} holds a NUL character; expected text; write the file again")
            return text, ()
        except DataError:
            try:
                text = content.decode("cp1252")
            except UnicodeDecodeError:
                text = "\0"
            if "\0" in text:  # no text of any kind
                raise
            first = next(character for character in text if not character.isascii())
            line = text[: text.index(first)].count("\n") + 1
            return _with_line_feeds(text), (
                f"{self.name} is not UTF-8 and was read as latin-1 (Windows-1252): line {line} has {first!r}",
            )


def _escapes_quotes(text: str) -> bool:
    """Whether quotation marks within texts follow a backslash, as R's write.table writes them, and do not stand twice.

    Read so the marks of each line come in pairs, and otherwise not those of some.
    """
    lines = [line for line in text.split("\n") if '\\"' in line] if '\\"' in text else []
    pairs = [(line.count('"') % 2 == 0, line.replace('\\"', "").count('"') % 2 == 0) for line in lines]
    return any(not doubled for doubled, _ in pairs) and all(escaped for _, escaped in pairs)


def _marked(content: bytes) -> bytes:
    """Return a text in UTF-16 without a byte-order mark with one: every other byte of its first line is zero."""
    head = content[:200]
    for mark, zeros, letters in (
        (codecs.BOM_UTF16_LE, head[1::2], head[::2]),
        (codecs.BOM_UTF16_BE, head[::2], head[1::2]),
    ):
        if len(head) > 3 and not any(zeros) and all(letters):
            return mark + content
    return content


def _refuse_no_text(content: bytes, name: str) -> None:
    what = next((what for mark, what in NO_TEXT.items() if content.startswith(mark)), "")
    if what:
        raise DataError(f"{name} is {what}; {EXPORT}")


def _with_line_feeds(text: str) -> str:
    """Return a text whose lines end with a line feed; some end with a carriage return, which a quoted cell may hold."""
    is_alone = "\r" in text and ("\n" not in text or (text.count("\r") != text.count("\r\n") and '"' not in text))
    text = text.lstrip("\ufeff").rstrip(PADDING)
    text = text.replace("\n\ufeff", "\n") if "\ufeff" in text else text  # files that were joined have several marks
    text = text.replace("\r\n", "\n").replace("\r", "\n") if is_alone else text
    if not text.isascii():  # one spelling of each letter, since some systems write an accent behind it
        text = unicodedata.normalize("NFC", text.translate(BOX) if "│" in text or "┃" in text else text)
    return MINUS.sub(r"\1\2-", text) if "\u2212" in text else text


def open_source(path: PathLike) -> Source:
    """Return the source of a table: its format is said by the ending of its name, or found in what it holds.

    Raises
    ------
    DataError
        it cannot be read or is an archive such as a workbook, or standard input is empty or too long.
    """
    path = Path(path)
    form = form_by_ending(path)
    if form is not None:
        return Source(path, form)
    held = _standard_input() if str(path) == STANDARD_INPUT else read_bytes(path)
    return Source(path, _form_of(held, _name(path)), held)


def _name(path: Path) -> str:
    return "standard input" if str(path) == STANDARD_INPUT else str(path)


def _form_of(content: bytes, name: str) -> str:
    _refuse_no_text(content, name)
    return "parquet" if content.startswith(PARQUET) else "csv"


def form_by_ending(path: Path) -> str | None:
    """Return the format that the ending of a file's name says, None where it says none."""
    ending = Path(path.stem).suffix if path.suffix == ".gz" else path.suffix
    return ENDINGS.get(ending.lower())


def _standard_input() -> bytes:
    content = sys.stdin.buffer.read(files.MOST_BYTES + 1)
    if len(content) > files.MOST_BYTES:
        raise DataError(f"standard input is longer than {files.MOST_BYTES} bytes; expected a shorter table; drop rows")
    if not content.strip():
        raise DataError("standard input is empty; expected a table; pipe one into the command")
    return content


def unpacked(content: bytes, name: str) -> bytes:
    """Return what gzip packed; its length is counted before it is kept, since a few bytes may unpack to terabytes.

    Raises
    ------
    DataError
        it is no gzip to its end, or unpacks to more than `SMALL` bytes and `MOST_TIMES` its size, or than a file may
        have.
    """
    most = min(files.MOST_BYTES, max(SMALL, MOST_TIMES * len(content)))
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(content)) as stream:
            n_bytes = 0
            while piece := stream.read(PIECE):
                n_bytes += len(piece)
                if n_bytes > most:
                    raise DataError(
                        f"{name} unpacks to more than {most} bytes ({most / len(content):.3g} times its size); "
                        "expected at most so many; drop rows or columns, or give it unpacked"
                    )
        found = gzip.decompress(content)
    except (OSError, EOFError, zlib.error) as error:
        reason = re.sub(r"\s+", " ", str(error))[:100]
        raise DataError(f"{name} cannot be unpacked ({reason}); expected gzip; was it written to the end?") from error
    if not found.strip():
        raise DataError(f"{name} is empty ({len(found)} bytes unpacked); expected a table; was it written to the end?")
    return found
