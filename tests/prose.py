#!/usr/bin/env python3
"""Holds the words that people read to limits, by kind of page.

    tests/prose.py               checks the tree of QUILTD_SOURCE (.); exit status 1 if a rule is broken
    tests/prose.py --self-test   breaks each rule once in a small tree; each must be found
    tests/prose.py --table       prints the numbers of each page, and the size of the manual

QUILTD_BUILD names the folder of the programs, whose --help is read. Sentences are those of running text: no tables,
code blocks and headings. docs/lab is frozen and is not read.
"""

import collections
import functools
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

Limits = collections.namedtuple("Limits", "median p90 longest over30 passive forbidden brackets paragraph")
LIMITS = {
    "guide": Limits(16, 24, 35, 2, 35, 0, 6, 80),
    "reference": Limits(16, 26, 40, 4, 35, 1, 8, 90),
    "developer": Limits(17, 28, 40, 5, 35, 1, 8, 100),
}
HELP_WORDS, HELP_LINES = 16, 2  # of an option
MESSAGE_WORDS = 25

PAGES = [  # the first that fits
    ("", "docs/lab/*"),
    ("guide", "README.md"),
    ("guide", "CONTRIBUTING.md"),
    ("guide", "docs/guide/*.md"),
    ("guide", "clients/*/README.md"),
    ("reference", "docs/reference/**/*.md"),
    ("reference", "docs/man/*.1"),
    ("developer", "docs/developer/**/*.md"),
]
GLOSSARY = "docs/developer/glossary.md"
PROGRAMS = ["quiltd", "quiltctl", "quiltrender", "quiltfarm", "quiltmerge", "quiltprint", "quiltsim", "quiltbench", "quiltweb"]
FOLDERS = ["base", "render", "quilt", "device", "daemon", "bench", "scenes", "clients", "tests", "docs", "systemd", "debian", ".ci"]

FORBIDDEN = re.compile(
    r"""\b(?: but\ for | lest | anew | whoever | so\ many | honestly | mend(?:s|ed)? | woven | weaves? | ours
        | what\ (?:is|are)\ (?:there|left|drawn|seen|known|wanted) | (?<!there\ )(?:is|are)\ no | (?:that|those)\ of | the\ same\ of
        | tells | told | things? | beside | stands?\ (?:in|at|on|for|by|behind|beside|still|beneath|below|near|where|there)
        | go(?:es)?\ with | with(?:out)?\ a\ word | says?\ a\ word | one\ an?\ (?:view|pixel|row|line|frame|file) )\b""",
    re.I | re.X,
)
# Words of the glossary with an everyday sense, too: a page may use them without a link.
EVERYDAY = set("""view row window guides pass cycle half stream hole skip channel solid film answer feature fit cell
    section body reader batch card part state chain shift selection reuse module fault pitch slope n B q M outline
    coarse complete prefix suffix sweep sections slice visit reservoir""".split())

IRREGULAR = set("""been begun bent bound broken brought built caught chosen cut done drawn driven fallen fed forgotten
    found frozen given gone grown held hidden kept known laid led left lent lit lost made meant met paid put read run
    said seen sent set shown shut sold spent split spoken spread stored struck sunk taken taught thought thrown told
    torn understood won worn written""".split())
PASSIVE = re.compile(
    r"\b(?:is|are|was|were|be|been|being|gets?|got)\s+(?:(?:not|also|then|thus|always|never|only|still|often|first|already"
    r"|all|both|each|once|\w+ly)\s+){0,2}(\w+)"
)

Page = collections.namedtuple("Page", "path kind text paragraphs code headings cells")


# --- reading pages ---


def markdown(text):
    """Paragraphs (an item of a list is one), lines of code, headings, cells of tables."""
    paragraphs, code, headings, cells, words = [], [], [], [], []
    fence = blank = False

    def flush():
        if words:
            paragraphs.append(" ".join(words))
            words.clear()

    for line in text.split("\n"):
        bare = line.strip()
        if bare.startswith("```"):
            flush()
            fence = not fence
        elif fence:
            code.append(bare)
        elif not bare:
            flush()
        elif not words and re.match(r" {4}|\t", line) and not re.match(r"\s*[-*] |\s*\d+\. ", line):
            code.append(bare)
        elif re.match(r"#+ ", line):
            flush()
            headings.append(re.sub(r"^#+ +", "", line))
        elif bare[0] == "|" or bare.startswith("!["):
            flush()
            cells += re.split(r"(?<!\\)\|", bare)
        else:
            item = re.match(r"(?:[-*]|\d+\.) +", bare)
            if item:
                flush()
            words.append(bare[item.end() :] if item else bare)
    flush()
    return tuple(paragraphs), tuple(code), tuple(headings), tuple(cells)


def roff(text):
    """The same of a man page; tags of a list are code."""
    paragraphs, code, headings, words = [], [], [], []
    verbatim = tag = False

    def flush():
        if words:
            paragraphs.append(" ".join(words))
            words.clear()

    for line in text.split("\n"):
        line = re.sub(r"\\f(?:\[\w*\]|\(..|.)|\\&", "", line).replace("\\-", "-").replace("\\(aq", "'")
        line = re.sub(r"\\\((?:lq|rq|dq)|\\\[(?:lq|rq|dq)\]", '"', line)
        macro, _, rest = line.partition(" ")
        if macro in (".nf", ".EX", ".TS", ".fi", ".EE", ".TE"):
            flush()
            verbatim = macro in (".nf", ".EX", ".TS")
        elif verbatim:
            code.append(line)
        elif macro in (".SH", ".SS"):
            flush()
            headings.append(rest.strip('"'))
        elif macro in (".TP", ".IP", ".TQ"):
            flush()
            tag = macro != ".IP"
            code.append(rest if macro == ".IP" else "")
        elif macro in (".B", ".I", ".BR", ".BI", ".RB", ".RI", ".IR", ".IB", ".SM") or not macro.startswith("."):
            rest = rest if macro.startswith(".") else line
            if macro in (".BR", ".BI", ".RB", ".RI", ".IR", ".IB"):
                rest = "".join(a or b for a, b in re.findall(r'"([^"]*)"|(\S+)', rest))
            (code if tag else words).append(rest.replace('"', "") if macro.startswith(".") else rest)
            tag = False
        elif macro in (".PP", ".P", ".LP", ".RS", ".RE", ".br", ".sp"):
            flush()
    flush()
    return tuple(paragraphs), tuple(code), tuple(headings), ()


@functools.lru_cache(maxsize=None)
def pages(tree):
    found = {}
    for kind, pattern in PAGES:
        for path in sorted(tree.glob(pattern)):
            found.setdefault(path, kind)
    read = []
    for path, kind in found.items():
        if kind:
            text = path.read_text(errors="replace")
            read.append(Page(path.relative_to(tree).as_posix(), kind, text, *(markdown if path.suffix == ".md" else roff)(text)))
    return read


def plain(paragraph):
    """Without markup: code is one word, a link its text."""
    paragraph = re.sub(r"`[^`]*`", "X", paragraph)
    paragraph = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", paragraph)
    return re.sub(r"\*+|\b(e\.g|i\.e|vs|cf|Rec|Fig|Eq|approx)\.", lambda m: m.group(1) or "", paragraph)


def words_in(text):
    return [w for w in text.split() if re.search(r"\w", w)]


def sentences(page):
    for paragraph in page.paragraphs:
        for sentence in re.split(r"(?<=[.?!])[\"')]*\s+(?=[\"'(\[]*[^\Wa-z_])", plain(paragraph)):
            if len(words_in(sentence)) > 2:  # not a label
                yield sentence


def is_passive(sentence):
    return any(w in IRREGULAR or (w.endswith("ed") and len(w) > 3) for w in PASSIVE.findall(sentence))


def forbidden_places(page, _=None):
    """In running text, headings and tables."""
    for text in map(plain, page.paragraphs + page.headings + page.cells):
        for found in FORBIDDEN.finditer(text):
            yield f"{found.group()}: …{text[max(0, found.start() - 40) : found.end() + 40]}…"


@functools.lru_cache(maxsize=None)
def measure(page):
    """The numbers of a page in the order of Limits, and its words."""
    text = list(map(plain, page.paragraphs))
    total = sum(len(words_in(p)) for p in text) or 1
    lengths = sorted(len(words_in(s)) for s in sentences(page)) or [0]
    count = len(lengths)
    return Limits(
        statistics.median(lengths),
        lengths[min(count - 1, count * 9 // 10)],
        lengths[-1],
        100 * sum(n > 30 for n in lengths) / count,
        100 * sum(map(is_passive, sentences(page))) / count,
        1000 * len(list(forbidden_places(page))) / (total + sum(len(words_in(plain(c))) for c in page.headings + page.cells)),
        100 * sum(len(words_in(b)) for p in text for b in re.findall(r"\(([^()]*)\)", p)) / total,
        max((len(words_in(p)) for p in text), default=0),
    ), total


# --- rules: each yields its complaints ---


def over(field, unit, examples=lambda page, limit: []):
    def rule(tree):
        for page in pages(tree):
            value, limit = getattr(measure(page)[0], field), getattr(LIMITS[page.kind], field)
            if value > limit:
                yield f"{page.path}: {value:.4g} {unit}, at most {limit} in a {page.kind} page"
                for example in examples(page, limit):
                    yield "    " + example[:160]

    return rule


def longest_first(page, least):
    return [s for s in sorted(sentences(page), key=lambda s: -len(words_in(s)))[:5] if len(words_in(s)) > least]


def slugs(text):
    """Anchors of a page's headings, as GitHub names them."""
    seen, out = collections.Counter(), set()
    for heading in markdown(text)[2]:
        slug = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower()
        slug = re.sub(r"[^\w -]", "", slug).strip().replace(" ", "-")
        out.add(f"{slug}-{seen[slug]}" if seen[slug] else slug)
        seen[slug] += 1
    return out


def dead_links(tree):
    for page in pages(tree):
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", page.text)):
            if re.match(r"[a-z]+:", target) or not page.path.endswith(".md"):
                continue
            name, _, anchor = target.partition("#")
            file = (tree / page.path).parent / name if name else tree / page.path
            if not file.exists():
                yield f"{page.path}: {target}: no such file"
            elif anchor and file.suffix == ".md" and anchor not in slugs(file.read_text()):
                yield f"{page.path}: {target}: no such heading"


@functools.lru_cache(maxsize=None)
def file_names(tree):
    names = set()
    for folder in FOLDERS:
        for _, _, files in os.walk(tree / folder):
            names.update(files)
    return names


def dead_paths(tree):
    made = "".join(p.read_text() for p in tree.glob("scenes/module.mk"))  # the build makes some scenes
    for page in pages(tree):
        # a man page has no backticks
        in_text = r"`([\w.*/-]+)`" if page.path.endswith(".md") else r"\b(docs/[\w/-]+\.\w+)"
        for name in sorted(set(re.findall(in_text, page.text.replace("\\-", "-")))):
            inside = name.split("/")[0] in FOLDERS and "/" in name and not re.search(r"NAME|DIR|%", name)
            if inside and not any(tree.glob(name.rstrip("/"))) and name not in made:
                yield f"{page.path}: {name}: no such path"
            elif re.fullmatch(r"\w+\.[ch]", name) and name not in file_names(tree):
                yield f"{page.path}: {name}: no file has this name"


@functools.lru_cache(maxsize=None)
def help_of(*command):
    build = os.environ.get("QUILTD_BUILD")
    program = pathlib.Path(build or "/nonexistent") / command[0]
    if not program.exists():
        return None
    run = subprocess.run([program, *command[1:], "--help"], capture_output=True, text=True, timeout=30, stdin=subprocess.DEVNULL)
    return run.stdout + run.stderr


@functools.lru_cache(maxsize=None)
def knows(program, option):
    if re.search(re.escape(option) + r"(?![\w-])", help_of(program) or ""):
        return True
    if program == "quiltbench":
        commands = re.findall(r"^  ([a-z]+)  ", help_of(program) or "", re.M)
        return any(re.search(re.escape(option) + r"(?![\w-])", help_of(program, c) or "") for c in commands)
    # An old name is known but is not in --help, which ends the program before it starts.
    return "unknown option" not in (answer := help_of(program, option + "=") or "") and "is ambiguous" not in answer


FOREIGN = "node|podman|apptainer|sbatch|squeue|systemctl|journalctl|apt-get|adduser|ffmpeg|usbip|modprobe|nngcat"
OF_OTHERS = re.compile(rf"\b(?:{FOREIGN})(?: [\w.@-]+)* --[a-z]\S*")
OPTION = re.compile(r"(?<![\w/-])--[a-z][a-z0-9-]*(?<!-)")


def options_of(page):
    """(option, programs that may have it) of commands, and of code that begins with the option."""
    named = [p for p in PROGRAMS if re.search(rf"\b{p}\b", page.text)]
    own = [pathlib.Path(page.path).stem] if page.path.endswith(".1") else []
    # a fence has three backticks, after which pairs would be wrong
    code = [*page.code, *re.findall(r"`([^`]+)`", re.sub(r"^```.*?^```", "", page.text, flags=re.M | re.S))]
    if own:
        text = OF_OTHERS.sub("", " ".join(page.paragraphs))
        code = [*page.code, *OPTION.findall(text)]
    for line in code:
        line = OF_OTHERS.sub("", re.split(r"\s#\s", line)[0])
        # behind "--" quiltfarm takes words of quiltrender, or of the farm's program
        line = re.sub(r"(quiltfarm (?:submit|resume) .*?)\s--\s.*", r"\1", re.sub(r"(quiltfarm plan .*?)\s--\s", r"\1 | quiltrender ", line))
        for found in OPTION.finditer(line):
            before = re.findall(r"(?:^|[\s/|;&(])(quilt(?:d|ctl|render|sim|bench|web|print|merge|farm))(?=\s)", line[: found.start()])
            if before:
                yield found.group(), before[-1:]
            elif line.lstrip().startswith("-") or own:
                yield found.group(), named + own


def unknown_options(tree):
    if not all(help_of(p) for p in PROGRAMS):
        return
    for page in pages(tree):
        if page.kind != "developer" and page.path != "CONTRIBUTING.md":
            for option, programs in sorted({(o, tuple(p)) for o, p in options_of(page)}):
                if not any(knows(p, option) for p in programs):
                    yield f"{page.path}: {option}: unknown to {', '.join(programs) or 'all programs'}"


def house_terms(tree):
    terms = set()
    if (tree / GLOSSARY).exists():
        for line in re.findall(r"^\|([^|]+)\|[^|]+\|", (tree / GLOSSARY).read_text().split("## The field's words")[0], re.M):
            terms.update(t.strip() for t in line.split(",") if re.search(r"\w", t))
    return {t for t in terms - EVERYDAY - {"word"} if re.fullmatch(r"[A-Za-z][A-Za-z -]+", t)}


def unlinked_terms(tree):
    terms = house_terms(tree)
    for page in pages(tree):
        if page.path == GLOSSARY or re.search(r"\]\([^)]*glossary\.md|\bglossary\b", page.text):
            continue
        text = " ".join(map(plain, page.paragraphs))
        used = {t for t in terms if re.search(rf"\b{re.escape(t)}s?\b", text)}
        undefined = sorted(t for t in used if not re.search(rf"\*{re.escape(t)}s?\*", page.text))
        if undefined:
            yield f"{page.path}: no link to the glossary, for {', '.join(undefined)}"


def help_entries(text):
    """(option, lines of text) of a --help."""
    entries = []
    for line in text.split("\n"):
        start = re.match(r" {2}(-\S.*?)(?: {2,}(.*))?$", line)
        if start:
            entries.append((start.group(1), [start.group(2)] if start.group(2) else []))
        elif entries and re.match(r" {8,}\S", line):
            entries[-1][1].append(line.strip())
        else:
            entries.append(("", []))
    return [e for e in entries if e[0]]


def without_values(text):
    """Help without the list of an option's values at its end: ": left (default), right or top", ", one of: none wrong-magic", "; restir; mvrestir"."""
    value = r"[\w.-]+(?: \(default\))?"
    text = re.sub(rf": {value}(?:, {value})*(?: or {value})?$", "", text)
    return re.sub(r", one of: [\w -]+$|(?:; [\w-]+)+$", "", text)


def long_help(tree):
    texts = {p: help_of(p) or "" for p in PROGRAMS}
    for path in tree.glob("*.help"):  # of the self-test
        texts[path.name] = path.read_text()
    for program, text in texts.items():
        for option, lines in help_entries(text):
            text = without_values(" ".join(lines))
            count = len(words_in(text))
            if count > HELP_WORDS or (len(lines) > HELP_LINES and text == " ".join(lines)):
                yield f"{program}: {option}: {count} words in {len(lines)} lines, at most {HELP_WORDS} in {HELP_LINES}"


@functools.lru_cache(maxsize=None)
def messages(tree):
    """(file, text) of the strings of errors and warnings."""
    call = re.compile(r"\b\w*(?:error|fail|warn|complain|refuse|lf_log)\w*\(")
    found = []
    for folder in FOLDERS[:6]:
        for path in sorted((tree / folder).rglob("*.c")):
            source = re.sub(r'"\s*"', "", path.read_text(errors="replace"))  # joined literals
            source = re.sub(r'"\s*PRI\w+\s*"', "d", source)
            for start in call.finditer(source):
                statement = source[start.end() : source.find(";\n", start.end())]
                for text in re.findall(r'"((?:[^"\\]|\\.)*)"', statement):
                    found.append((path.relative_to(tree).as_posix(), text))
    return sorted(set(found))


def long_messages(tree):
    for path, text in messages(tree):
        if len(words_in(text)) > MESSAGE_WORDS:
            yield f"{path}: more than {MESSAGE_WORDS} words: {text}"


def joined_messages(tree):
    for path, text in messages(tree):
        if re.search(r"%s (?:\w+ )?(?:no|not|of no) %s|%s (?:knows|has|takes|supports) %s", text):
            yield f"{path}: joined from parts: {text}"


RULES = {
    "median": over("median", "words in the median sentence"),
    "p90": over("p90", "words in one of ten sentences", longest_first),
    "longest": over("longest", "words in the longest sentence", longest_first),
    "over30": over("over30", "% of the sentences have more than 30 words", lambda page, _: longest_first(page, 30)),
    "passive": over("passive", "% of the sentences are passive"),
    "forbidden": over("forbidden", "forbidden words per 1000", forbidden_places),
    "brackets": over("brackets", "% of the words are in brackets"),
    "paragraph": over("paragraph", "words in the longest paragraph"),
    "dead_links": dead_links,
    "dead_paths": dead_paths,
    "unknown_options": unknown_options,
    "unlinked_terms": unlinked_terms,
    "long_help": long_help,
    "long_messages": long_messages,
    "joined_messages": joined_messages,
}


# --- the rules, held against breaches of them ---


def write(tree, path, text):
    (tree / path).parent.mkdir(parents=True, exist_ok=True)
    (tree / path).write_text(text)


def make_breaches(tree):
    """rule: the words of the complaint that it must yield"""
    short, long = "The panel shows it.", "Word " + "word " * 40 + "word."
    write(tree, "docs/guide/median.md", "# M\n\n" + ("Seventeen words " + "word " * 14 + "end. ") * 3)
    write(tree, "docs/developer/long.md", f"# L\n\n- {long}\n- {short}\n")
    write(tree, "docs/developer/estimators/deep.md", f"# D\n\n{long}\n\n    {long}\n")
    write(tree, "docs/guide/passive.md", "# P\n\nThe panel is driven by it. It was not often rendered here. The file goes there.\n")
    write(tree, "docs/guide/forbidden.md", "# F\n\nAll things are good.\n\n| a | b |\n|---|---|\n| c | anew |\n")
    write(tree, "docs/reference/brackets.md", "# B\n\nThe panel (which is new) shows it (twice).\n")
    write(tree, "docs/guide/paragraph.md", "# P\n\n" + short + (" " + short) * 20)
    write(tree, "docs/guide/links.md", "# Here it is\n\nSee [a](gone.md), [b](#here-it-is), [c](#there) and [d](links.md#here).\n\n```\n# there\n```\n")
    write(tree, "docs/guide/paths.md", "# P\n\nSee `render/gone.c`, `gone.h`, `render/message.c` and `message.c`.\n")
    write(tree, "docs/guide/options.md", "# O\n\n    quiltctl --no-such-option status   # --comment\n    apt-get --foreign\n")
    write(tree, "docs/man/quiltctl.1", ".TH X\n.SH OPTIONS\n.TP\n.B \\-\\-no\\-such\\-tag\nWith systemctl enable \\-\\-foreign, see docs/gone.md.\n.PP\n" + long.replace("word.", "end."))
    write(tree, GLOSSARY, "# G\n\n| word | meaning |\n|---|---|\n| pivot, fan | a point |\n")
    write(tree, "docs/guide/terms.md", "# T\n\nTwo pivots are here.\n")
    write(tree, "docs/guide/defined.md", "# T\n\nA *pivot* is here.\n")
    write(tree, "docs/lab/frozen.md", f"# Z\n\n{long}\nThings [x](gone.md).\n")
    write(tree, "x.help", "Usage\n\n  --much TEXT     " + "word " * 17 + "\n  --tall\n          a\n          b\n          c\n  --fine   word\n")
    source = 'f = lf_error_set(err, "%s knows no %s", a, b);\nlf_fail("' + "word " * 13 + '"\n    "' + "word " * 13 + '");\n'
    write(tree, "render/message.c", source)
    return {
        "median": ["docs/guide/median.md: 17"],
        "p90": ["docs/developer/long.md: 42"],
        "longest": ["docs/developer/long.md: 42", "docs/developer/estimators/deep.md: 42", "docs/man/quiltctl.1: 42"],
        "over30": ["docs/developer/long.md: 50"],
        "passive": ["docs/guide/passive.md: 66.67"],
        "forbidden": ["docs/guide/forbidden.md: 222.2"],
        "brackets": ["docs/reference/brackets.md: 50"],
        "paragraph": ["docs/guide/paragraph.md: 84"],
        "dead_links": ["links.md: gone.md: no such file", "links.md: #there: no such heading", "links.md: links.md#here: no such heading"],
        "dead_paths": ["paths.md: render/gone.c: no such path", "paths.md: gone.h: no file", "quiltctl.1: docs/gone.md: no such path"],
        "unknown_options": ["options.md: --no-such-option: unknown to quiltctl", "quiltctl.1: --no-such-tag: unknown"],
        "unlinked_terms": ["docs/guide/terms.md: no link to the glossary, for pivot"],
        "long_help": ["x.help: --much TEXT: 17 words", "x.help: --tall: 3 words in 3 lines"],
        "long_messages": ["render/message.c: more than 25 words"],
        "joined_messages": ["render/message.c: joined from parts"],
    }


def self_test():
    """Each rule finds each of its breaches, and complains of no other place."""
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        tree = pathlib.Path(folder)
        breaches = make_breaches(tree)
        for name, rule in RULES.items():
            if name == "unknown_options" and not help_of("quiltctl"):
                print(f"prose: {name}: skipped, QUILTD_BUILD has no programs")
                continue
            found = [c for c in rule(tree) if not c.startswith("    ")]
            missed = [b for b in breaches[name] if not any(b in c for c in found)]
            strange = [c for c in found if "frozen" in c or "defined" in c or "--comment" in c or "--foreign" in c or "--fine" in c]
            for words in missed + strange:
                failed += 1
                print(f"prose: {name}: {'does not find' if words in missed else 'complains of'}: {words}")
    if not failed:
        print(f"prose: each of the {len(RULES)} rules finds its breaches")
    return failed


def table(tree):
    print(f"{'page':44}{'words':>7}{'median':>8}{'p90':>5}{'longest':>9}{'>30 %':>7}{'passive %':>11}{'forb./1000':>12}{'( ) %':>7}{'par.':>6}")
    totals = collections.Counter()
    for page in pages(tree):
        numbers, words = measure(page)
        totals[page.kind] += words
        print(f"{page.path:44}{words:7}{numbers.median:8.4g}{numbers.p90:5}{numbers.longest:9}{numbers.over30:7.1f}"
              f"{numbers.passive:11.0f}{numbers.forbidden:12.1f}{numbers.brackets:7.1f}{numbers.paragraph:6}")
    print(", ".join(f"{kind} {words} words" for kind, words in totals.items()) + f", together {sum(totals.values())}")


def main(arguments):
    tree = pathlib.Path(os.environ.get("QUILTD_SOURCE", ".")).resolve()
    if arguments == ["--self-test"]:
        return 1 if self_test() else 0
    if arguments == ["--table"]:
        table(tree)
        return 0
    if arguments:
        print(__doc__, file=sys.stderr)
        return 2
    broken = 0
    if not all(help_of(p) for p in PROGRAMS):
        print("prose: unknown_options, long_help: skipped, QUILTD_BUILD has no programs")
    for name, rule in RULES.items():
        for complaint in rule(tree):
            broken += not complaint.startswith("    ")
            print(complaint if complaint.startswith("    ") else f"{name}: {complaint}")
    print(f"prose: {broken} complaints")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
