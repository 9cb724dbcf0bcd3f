"""Finds long sentences, long table rows, and writing habits that make a reader stop, if a pattern can recognize them.

CONTRIBUTING.md says how to write instead. The patterns miss many offences, but rarely report a correct sentence.
"""
import dataclasses
import re

from .prose import cells

MOST_WORDS = 40  # maximum length of a sentence
LONGEST_ROW = 200  # maximum length of a table row in the source, in characters

# A sentence begins at the start of the passage, or after a full stop.
BEGIN = r"(?:^|(?<=[.!?:] )|(?<=[.!?][)\"'] ))"
BE = r"(?:is|are|was|were|be|been|being)"
AUXILIARY = r"(?:is|are|was|were|has|have|had|does|do|did|can|cannot|could|would|will|may|might|must)"
VERB = (rf"(?:{AUXILIARY}|needs?|takes?|gives?|makes?|comes?|goes|becomes?|says?|holds?|keeps?|stays?|stands?|asks?|tells?|adds?|waits?|"
        r"starts?|gets?|leaves?|reads?|writes?|sends?|uses?|wants?|works?|runs?|shares?|computes?)")
PROGRAM = (r"(?i:threads?|workers?|servers?|process(?:es)?|programs?|functions?|callers?|clients?|helpers?|requests?|readers?|writers?|"
           r"prox(?:y|ies)|browsers?|tasks?|loops?|jobs?|computations?|connections?)")
# Comparatives, because "is no longer" is fine. Common nouns with the same ending are excluded by name.
COMPARED = (r"(?:more|less|worse|different|(?!(?:answer|buffer|caller|center|character|cluster|corner|filter|folder|header|helper|layer|member|"
            r"number|order|owner|parameter|pointer|reader|server|user|worker|writer)\b)\w+er)")
# A noun phrase of a few words, without a verb.
NOUN = (r"(?:an?|the|no|each|every|this|these|its|their|such|one|both|all|most|only) "
        r"(?:(?!(?:that|which|who|whom|whose|when|if|where|what|as|and|or|it|they|there|he|we|you|than|whether)\b)[\w'-]+ ){1,4}")
# Things that are not geometry. "A point lies in a plane" is fine, "the key lies in a file" is not.
CONTAINER = (r"(?:files?|folders?|caches?|tables?|lists?|memory|disk|build|documents?|page|repository|checkout|archive|store|path|root|server|"
             r"program)")

HABITS = [
    ("of-first", BEGIN + r"Of (?!(?:course|the \d[\d,]*|\d[\d,]*)\b)",
     "name the subject first: 'Maximum number of hulls', not 'Of an aggregate, which has …'"),
    ("what-first", BEGIN + r"(?:What|Who|Whose|Where|Whoever|Whatever)\b(?! to\b| possible\b|')",
     "begin with a noun or with 'if': 'The pieces that the limits merge', not 'What the limits merge'"),
    ("what-noun",
     r"\b(?:(?<!regardless )(?<!independent )(?<!irrespective )(?<!top )of|from(?! what (?:it|they))|by|with|into|than|through|without|in|at|"
     r"beside|(?<!taken )(?<!asks )for) what (?:is|are|was|were|has|had|the|an?|it|its|they|comes|came|remains|lies|stands|does|belongs|cannot)\b",
     "use a noun: 'the file', not 'of what is read'"),
    ("where-if", r"\b(?<!from )(?<!to )(?<!place )(?<!places )(?<!point )(?<!points )(?<!lies )(?<!stays )[Ww]here "
     r"(?:there (?:is|are|was|were)\b|(?:none|no|nothing|neither|nobody|any)\b|(?:one|that|those) (?:is|are|was|were)(?= \w)"
     r"|(?:it|they) (?:is|are|was|were) (?:known|installed|possible|needed|wanted|certain|missing|not)\b)",
     "use 'if' or 'when' for a condition"),
    ("is-no", r"(?<!there )(?<!There )\b(?:is|are|was|were) no "
     rf"(?!(?:{COMPARED}|good|use|secret|surprise|wonder|exception|match|guarantee|reason|news)\b)[a-z]",
     "write 'is not a …'"),
    ("beside", r"\b[Bb]eside\b", "write 'next to', 'with', 'compared with' or 'in addition to'"),
    ("who", r"(?:^|(?<=[;:.(] )|(?<=\bfor )|(?<=\bof )|(?<=\bby )|(?<=\bthan )|(?<=\bwith )|(?<=\bfrom )|(?<=\bas )|(?<=\bto ))"
     rf"who {VERB}\b(?!.{{0,40}}\b(?:whom?|when|what)\b)|\b{PROGRAM},? who {VERB}\b",
     "a program is a 'which' or 'that'; a person in general is 'a caller', 'a client', 'users who'"),
    ("for-because", rf"(?<=[,;.] )[Ff]or (?:it|they|there|he|we|nothing|none|nobody|neither) (?:\w+ )?{AUXILIARY}\b"
     rf"|(?<=[,;] )for {NOUN}{AUXILIARY}\b",
     "write 'because'"),
    ("stands", r"\b(?:stands?|stood|standing) (?:in(?! (?:for|front|rows?|heaps?)\b| (?:the|its|their|his|our|your) way)"
     r"|below|above(?! (?:the ground|it)\b)|under|beside|there|here|at)\b(?! [\w']+ [\w']*'?s? ?way\b)",
     "say where it is: 'is in', 'is on', 'is defined in'"),
    ("lies", r"\b(?:lies?|lay) (?:in|at|on|under|below|beside|above) (?:the |an? |its |their |this |that |one |another )?(?:same |own )?"
     rf"{CONTAINER}\b", "say where it is: 'is in', 'is on'"),
    ("told", rf"\b{BE} told(?= (?:from|by|otherwise|here|once|at|in)\b)|\b(?:can|cannot|could|may|might|to) be told(?=[.,;:)]|$)",
     "'are distinguished by', 'is known from', 'the client is informed'"),
    ("of-own", r"\b[Aa]n own\b|\bof (?:its|their) own(?=[.,;:)]|$| (?:and|or|if|in|on|for|with|below)\b)",
     "'its own mesh', 'separate meshes', not 'a mesh of its own'"),
    ("several", r"\b(?:[Pp]ieces|[Ff]ragments|[Cc]uts|[Tt]riangles|[Cc]ells) of several (?:parts|materials|nodes)\b", "write 'of different parts'"),
    ("another-than", r"\banother (?:number|count|size|format|dimension|unit|order|version|length) (?:of [\w ]+)?than\b",
     "write 'a different number from'"),
    ("by-itself", r"\b(?:is|are|was|were|be|not) (?:closed|cut|divided|read|written|checked|made|make \w+|does \w+) by (?:itself|themselves)\b",
     "write 'separately', 'automatically' or 'only on request'"),
    ("meant", r"\b(?:cannot|can|could|may|must) be meant\b", "write 'is implausible' or 'is likely'"),
    ("stands-for", r"\bstands? (?:for (?:all|another|many|a|the) [\w']+ (?:of|below|that|which|nodes?)\b|with the\b)",
     "name the relation: 'matches', 'replaces', 'is next to'"),
    ("said", rf"\b{BE} said\b(?! to\b)", "name the message: 'is reported', 'the report lists'"),
]
HABITS = [(name, re.compile(pattern), better) for name, pattern, better in HABITS]
NO_SUBJECT = re.compile(r"(?:What|Who|Where|Which|Nothing|None|That)\b(?! to\b)(?!.*\?$)")
END = re.compile(r"[.!?][)\"'\]]*(?= +[(\"'\[]?[A-Z0-9(]|$)")
ABBREVIATED = re.compile(r"\b(?:e\.g|i\.e|cf|vs|etc|al|No|Fig|Sec|Eq|approx|[A-Z])\.$")


def sentences(text):
    """Yields (offset, sentence) for each sentence of a passage."""
    start = 0
    for end in END.finditer(text):
        if not ABBREVIATED.search(text[start:end.end()]):
            yield start, text[start:end.end()]
            start = end.end() + 1
    if text[start:].strip():
        yield start, text[start:]


@dataclasses.dataclass
class Offence:
    habit: str
    first: int  # number of the first line
    last: int  # number of the last line
    found: str
    better: str


def find(passage):
    """Yields each offence in a passage. Questions may begin with What, Who and Where."""
    text = passage.text
    if passage.heading and NO_SUBJECT.match(text):
        yield Offence("heading", passage.lines[0][0], passage.lines[0][0], text, "name the subject as a reader would search for it")
        return
    for start, sentence in sentences(text):
        words = re.findall(r"[^\W_][\w'.,-]*", sentence)
        if len(words) > MOST_WORDS and 3 * sentence.count(",") < len(words):  # else it is a list of names
            yield Offence("long", passage.line_at(start), passage.line_at(start + len(sentence)), f"{' '.join(words[:6])} …",
                          f"divide the sentence: it has {len(words)} words, at most {MOST_WORDS} are allowed")
        asks = sentence.rstrip(")\"' ").endswith("?")
        for name, pattern, better in HABITS:
            for found in () if asks and name in ("what-first", "who") else pattern.finditer(sentence):
                yield Offence(name, passage.line_at(start + found.start()), passage.line_at(start + found.end()),
                              around(sentence, found), better)


def around(sentence, found):
    """Returns the text that a pattern found, and the words after it."""
    return " ".join(sentence[found.start():found.end() + 30].split(" ")[:7]).strip()


def long_rows(text):
    """Yields (line, length) for each row of a Markdown table that is too long."""
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        fenced ^= line.lstrip().startswith("```")
        if not fenced and line.startswith("|") and len(line) > LONGEST_ROW and len(cells(line)) > 1:
            yield number, len(line)
