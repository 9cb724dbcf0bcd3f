"""The prose of a file: paragraphs of its documents, comments, and the texts that a program shows.

A passage is one paragraph, list item, table cell, comment or string. `comment` marks passages that only readers of the source
see. The parsers understand just enough of each language to find comments and strings.
"""
import dataclasses
import html.parser
import io
import re
import tokenize

CLIKE = (".cpp", ".hpp", ".def", ".glsl", ".ts", ".mjs", ".js", ".css")
LEAST_WORDS = 4  # shorter strings are names, keys and labels


@dataclasses.dataclass
class Passage:
    comment: bool
    lines: list  # (line number, text)
    heading: bool = False

    @property
    def text(self):
        return " ".join(text for _, text in self.lines)

    def line_at(self, offset):
        for number, text in self.lines:
            if offset <= len(text):
                return number
            offset -= len(text) + 1
        return self.lines[-1][0]


def passages(name, text, script=""):
    """Returns all passages of a file. `script`: the interpreter of a file without an extension."""
    if name.endswith(".md"):
        return list(of_markdown(text))
    if name.endswith(CLIKE):
        return list(of_c(name, text))
    if name.endswith(".py") or script == "python":
        return list(of_python(name, text))
    if name.endswith(".html"):
        return list(of_html(text))
    if name.endswith(".json"):
        return list(of_json(text))
    if name.endswith((".yaml", ".yml")):
        return list(of_yaml(name, text))
    if name.endswith((".sh", ".cmake", "CMakeLists.txt", "Dockerfile")) or script == "shell":
        return list(of_shell(name, text))
    return []


# -- documents

def plain(line):
    """Returns a line of Markdown without markup: code becomes one word, and a link becomes its text."""
    line = re.sub(r"`+[^`]*`+", "CODE", line)
    line = re.sub(r"!?\[((?:[^\]\[]|\[[^\]]*\])*)\]\([^)\s]*(?: \"[^\"]*\")?\)", r"\1", line)
    return re.sub(r"<[^>]*>|\*\*|(?<!\w)[_*](?=\w)|(?<=\w)[_*](?!\w)", "", line)


def cells(row):
    return [cell.strip() for cell in row.strip().strip("|").replace("\\|", "/").split("|")]


def of_markdown(text):
    fenced, lines = "", []

    def close():
        nonlocal lines
        done, lines = lines, []
        return [Passage(False, done)] if done else []

    for number, line in enumerate(text.splitlines(), 1):
        bare = line.strip()
        fence = re.match(r"(```+|~~~+)", bare)
        if fenced or fence:
            yield from close()
            if fence and not fenced:
                fenced = fence.group(1)
            elif fenced and bare.startswith(fenced):
                fenced = ""
        elif not bare or (line.startswith("    ") and not lines) or re.match(r"\[[^\]]+\]: \S+$", bare):
            yield from close()
        elif bare.startswith("#"):
            yield from close()
            yield Passage(False, [(number, plain(bare.lstrip("# ")))], heading=True)
        elif bare.startswith("|"):
            yield from close()
            if not re.fullmatch(r"[|:\- ]+", bare):
                for cell in cells(plain(bare)):
                    if cell:
                        yield Passage(False, [(number, cell)])
        else:
            item = re.match(r"(?:[-*+]|\d+[.)]) +|> ?", bare)
            if item:
                yield from close()
            lines.append((number, plain(bare[item.end():] if item else bare)))
    yield from close()


# -- comments

def blocks(lines):
    """Joins adjacent comment lines into blocks. Paragraphs, items and drawings start new blocks, and so does the second cell of each
    row in a two-column table."""
    block, last = [], 0
    for number, text, whole in lines:
        bare = text.strip()
        key = re.match(r"\S+(?: \S+){0,2} {2,}(?=\S+ \S+ \S+)(?!.*\S {3,}\S)", bare)
        drawing = not key and re.search(r"\S {3,}\S|[-=_|\\/*+~.]{4,}", bare) or not re.search(r"[a-z]{2}", bare)
        item = re.match(r"(?:[-*] |\d+[.)] |@\w+|--\w+)", bare)
        if block and (number != last + 1 or drawing or item or key or not bare or not whole):
            yield block
            block = []
        if bare and not drawing:
            block.append((number, re.sub(r"`[^`]+`", "CODE", bare[key.end():] if key else bare)))
        last = number if whole else -1
    if block:
        yield block


TOKEN = re.compile(r"""
    (?P<line>//[^\n]*) | (?P<block>/\*.*?\*/)
  | R"(?P<mark>[^(\s]*)\((?P<raw>.*?)\)(?P=mark)"
  | "(?P<double>(?:[^"\\\n]|\\.)*)" | (?P<single>'(?:[^'\\\n]|\\.)*') | (?P<template>`(?:[^`\\]|\\.)*`)
  | (?P<regex>(?:(?<=[(,=:\[!&|?{};] )|(?<=[(\[!]))/(?![/*])(?:[^/\\\n\[]|\\.|\[(?:[^\]\\\n]|\\.)*\])+/)
""", re.X | re.S)


def of_c(name, text):
    scripted = name.endswith((".ts", ".mjs", ".js"))
    comments, strings = [], []
    end, number, counted = 0, 1, 0
    for token in TOKEN.finditer(text):
        kind = token.lastgroup if token.lastgroup != "mark" else "raw"
        number += text.count("\n", counted, token.start())
        counted = token.start()
        start_of_line = text.rfind("\n", 0, token.start()) + 1
        if kind == "line":
            comments.append((number, token["line"].lstrip("/"), not text[start_of_line:token.start()].strip()))
        elif kind == "block":
            shown = name.startswith("client/typescript/src/") and token["block"].startswith("/**")
            lines = [(number + k, re.sub(r"^\s*\*(?!\*)|^/\*+|\*+/$", "", line.strip()), True)
                     for k, line in enumerate(token["block"].splitlines())]
            for block in blocks(lines):
                yield Passage(not shown, block)
        elif kind == "double" or (scripted and kind in ("single", "template")):
            said = unescaped(token["double"] if kind == "double" else token.group()[1:-1])
            adjacent = strings and not scripted and not text[end:token.start()].strip()
            lines = [(number + k, line) for k, line in enumerate(said.split("\n"))] if kind == "template" else [(number, said)]
            if adjacent:
                strings[-1] += lines
            elif not re.search(r"#\s*include\s*$", text[start_of_line:token.start()]):
                strings.append(lines)
            end = token.end()
    for block in blocks(comments):
        yield Passage(True, block)
    if not name.startswith("tests/"):
        for lines in strings:
            yield from shown_text(lines)


def unescaped(string):
    string = re.sub(r"\$\{[^{}]*\}", "X", string)
    return re.sub(r"\\(.)", lambda found: {"n": " ", "t": " ", '"': '"', "'": "'"}.get(found[1], found[0]), string)


def shown_text(lines):
    """Yields the passages of a string that people read: words, mostly in lower case. Each column is a separate passage."""
    parts = [[]]
    for number, text in lines:
        for k, part in enumerate(re.split(r"\s{3,}", re.sub(r"`[^`]+`|'[^' ]+'|<[^>]*>", "CODE", text))):
            parts += [[]] if k else []
            if part.strip():
                parts[-1].append((number, re.sub(r"\s+", " ", part).strip()))
    for part in parts:
        said = " ".join(text for _, text in part)
        if len(re.findall(r"\b[A-Za-z][a-z]+\b", said)) >= LEAST_WORDS and \
                not re.search(r"[;{]\s*$|\|.*\|.*\||\bvec[234]\b|==|</|\bfunction\b|\w=[\w-]+[;,] ?\w+=", said):
            yield Passage(False, part)


# -- scripts

def of_python(name, text):
    helps = name.startswith("scripts/") and not name.startswith("scripts/lib/")
    packages = name.startswith(("client/python/", "client/blender/"))
    comments, strings, before = [], [], tokenize.NEWLINE
    try:
        tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    except (tokenize.TokenError, SyntaxError, IndentationError):
        return
    first = True
    for token in tokens:
        if token.type == tokenize.COMMENT:
            comments.append((token.start[0], token.string.lstrip("#!"), not token.line[:token.start[1]].strip()))
            continue
        if token.type in (tokenize.NL, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING):
            continue
        if token.type == tokenize.STRING:
            body = re.sub(r"^[A-Za-z]*('''|\"\"\"|'|\")", "", token.string)
            body = re.sub(r"('''|\"\"\"|'|\")$", "", body)
            lines = [(token.start[0] + k, line, True) for k, line in enumerate(body.split("\n"))]
            if before == tokenize.NEWLINE:  # then the string is a docstring
                shown = packages or (helps and first)
                for block in blocks(lines):
                    yield Passage(not shown, block)
            else:
                plain_lines = [(number, unescaped(line)) for number, line, _ in lines]
                if before == tokenize.STRING:
                    strings[-1] += plain_lines
                else:
                    strings.append(plain_lines)
            first = False
        before = token.type if token.type != tokenize.STRING or before != tokenize.NEWLINE else tokenize.OP
    for block in blocks(comments):
        yield Passage(True, block)
    if not name.startswith("tests/"):
        for lines in strings:
            yield from shown_text(lines)


def of_shell(name, text):
    """Yields the comments of a shell script. Its first comment block is its help, and printed strings are messages."""
    helps = name.startswith("scripts/") and not name.endswith((".sh", ".txt"))
    comments = []
    for number, line in enumerate(text.splitlines(), 1):
        found = re.search(r"(?:^|\s)#(?!!)(.*)", line)
        if found and (not line[:found.start()].strip() or re.match(r".*\S  # ", line)):
            comments.append((number, found[1], not line[:found.start()].strip()))
        elif re.search(r"\b(echo|fail|fail_run|message)\b", line) and not name.startswith("tests/"):
            for string in re.findall(r'"((?:[^"\\]|\\.)*)"', line):
                yield from shown_text([(number, unescaped(string))])
    head = next((number for number, line in enumerate(text.splitlines(), 1) if number > 1 and not line.startswith("#")), 0)
    for block in blocks(comments):
        yield Passage(not (helps and block[-1][0] < head), block)


# -- pages and descriptions

class Page(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.found, self.silent = [], 0

    def handle_starttag(self, tag, attributes):
        self.silent += tag in ("script", "style")
        for name, value in attributes:
            if name in ("title", "placeholder", "aria-label", "content", "alt") and value:
                self.found.append((self.getpos()[0], value))

    def handle_endtag(self, tag):
        self.silent -= tag in ("script", "style")

    def handle_data(self, data):
        if not self.silent:
            self.found.append((self.getpos()[0], data))


def of_html(text):
    page = Page()
    page.feed(text)
    for number, said in page.found:
        yield from shown_text([(number + k, line) for k, line in enumerate(said.split("\n"))])


def of_json(text):
    for number, line in enumerate(text.splitlines(), 1):
        for said in re.findall(r'"(?:description|title|summary)": *"((?:[^"\\]|\\.)*)"', line):
            yield from shown_text([(number, unescaped(said))])


def of_yaml(name, text):
    """Yields comments and, in interfaces and alerts, the texts of keys: one passage for each key, item or paragraph."""
    comments, lines = [], []
    shown = name.startswith("proto/") or name.endswith("alerts.yaml")
    for number, line in enumerate(text.splitlines(), 1):
        bare = line.strip()
        if bare.startswith("#"):
            comments.append((number, bare.lstrip("#"), True))
            continue
        key = re.match(r"(?:- )?(?:[\w./{}$-]+|\"[^\"]+\"|'[^']+'):(?: |$)[|>]?-?\s*|- ", bare)
        if key or not bare:
            yield from shown_text(lines) if shown else ()
            lines = []
        said = bare[key.end():] if key else bare
        said = re.sub(r"^\{ *(?:[\w]+: [^,]*, *)*description: *|^[\"']|[\"'] *\}?$", "", said)
        if said and not said.startswith(("{", "[", "$")):
            lines.append((number, said))
    yield from shown_text(lines) if shown else ()
    for block in blocks(comments):
        yield Passage(True, block)
