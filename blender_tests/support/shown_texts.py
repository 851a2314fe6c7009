# SPDX-License-Identifier: GPL-3.0-or-later
"""Every text that the add-on may show, read off its sources, and the entries of docs/troubleshooting.md.

A text is a string of the sources of at least two words. Left out is what is said elsewhere or to nobody:
docstrings, declarations (names and descriptions of properties, operators and panels are in docs/reference/), labels of
buttons, errors of Python's own that no artist sees, and the arguments of command lines. What an f-string fills in, and
what is added to a text by +, is "…"; the rest of it are its fixed parts.

Of the native module: what its exceptions say.
"""

import ast
import functools
import pathlib
import re
from dataclasses import dataclass

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "troubleshooting.md"
GAP = "…"

#: Calls whose strings are no messages: declarations, labels of what is pressed, command lines, errors of Python's own.
SILENT_CALLS = re.compile(
    r"\w+Property|size_property|keyframe_insert|operator|prop|prop_search|prop_menu_enum|menu|popover|compile|"
    r"add_argument|add_parser|ArgumentParser|ValueError|FileNotFoundError|NotADirectoryError|PermissionError"
)
#: Attributes of classes that declare.
SILENT_NAMES = re.compile(r"bl_\w+|doing|__doc__")
#: Files of names: of datablocks, of markers, and the labels of a plot and of a bug report.
SILENT_FILES = {"ids.py", "core/capture/known_sets.py", "core/bake_plot.py", "operators/system_facts.py"}
#: Beginnings of texts that nobody is shown: of a name, of a preset file, and of what a program reads.
SILENT_TEXTS = ("Mean-Value rest shape", "import bpy", "openjd_fail: ")
#: The module's own calls that the add-on does not make.
SILENT_FOLDERS = {"baselines"}


@dataclass(frozen=True)
class Text:
    where: str
    text: str

    @property
    def parts(self):
        return fixed_parts(self.text)


@functools.cache
def fixed_parts(text):
    return [part for part in (plain(piece) for piece in text.split(GAP)) if part]


@functools.cache
def plain(text):
    """Without what quotes, full stops and line breaks add."""
    return re.sub(r"\s+", " ", text).strip(" .,:;'\"()")


@functools.cache
def words(text):
    """Without identifiers and formulas (`loop_start`, `tasks.tsv`, `method=`)."""
    form = r"[('\"]*[A-Za-z]+('[a-z]+|-[A-Za-z]+)?[)'\".,:;!?]*"
    return [word for word in text.replace(GAP, " ").split() if re.fullmatch(form, word)]


def says_something(text):
    """No name, label or word that is filled into another text: those are short, without a gap, or in Title Case."""
    said = words(text)
    if GAP in text:
        return len(said) >= 2
    return len(said) >= 4 or (len(said) >= 2 and said[0][0].isupper() and any(word[0].islower() for word in said))


def follows(parts, text):
    """Whether all `parts` are in `text`, in their order."""
    place = 0
    for part in parts:
        place = text.find(part, place)
        if place < 0:
            return False
        place += len(part)
    return True


def of_addon(folder=ROOT / "addon"):
    """[Text] of all Python files, in order."""
    found = []
    for path in sorted(folder.rglob("*.py")):
        name = path.relative_to(folder).as_posix()
        if name not in SILENT_FILES and "presets" not in path.parts:
            found += [Text(f"{name}:{line}", text) for line, text in of_tree(ast.parse(path.read_text()))]
    return found


def of_tree(tree):
    stack, found = [tree], []
    while stack:
        node = stack.pop()
        if _is_silent(node):
            continue
        text = _text(node)
        if text is None:
            stack += ast.iter_child_nodes(node)
            continue
        if len(words(text)) >= 2 and not text.startswith(SILENT_TEXTS):
            found.append((node.lineno, text))
        stack += _filled_in(node)
    return sorted(found)


def _text(node):
    """What a string says, with GAP for what is filled in; None of what is no string."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return re.sub(r"\{[^{}]*\}", GAP, node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else GAP for part in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        sides = [_text(node.left), _text(node.right)]
        return None if sides == [None, None] else "".join(side or GAP for side in sides)
    return None


def _filled_in(node):
    """Nodes inside of a text whose strings are texts of their own."""
    if isinstance(node, ast.JoinedStr):
        return [part for part in node.values if isinstance(part, ast.FormattedValue)]
    if isinstance(node, ast.BinOp):
        return [side for side in (node.left, node.right) if not isinstance(side, ast.Constant)]
    return []


def _is_silent(node):
    if isinstance(node, ast.Call):
        called = ast.unparse(node.func)
        return called.startswith("aside(") or bool(SILENT_CALLS.fullmatch(called.rpartition(".")[2]))
    if isinstance(node, (ast.Assign, ast.AnnAssign)):
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        return all(SILENT_NAMES.fullmatch(ast.unparse(target)) for target in targets)
    if isinstance(node, ast.ClassDef):
        return any(ast.unparse(base) in {"enum.Enum", "enum.Flag"} for base in node.bases)
    if isinstance(node, ast.Tuple):  # an item of an enum: ('AUTO', "Automatic", "By the shape ...")
        constants = [item.value for item in node.elts if isinstance(item, ast.Constant)]
        first = node.elts[0] if node.elts else None
        is_name = first is not None and ast.unparse(first).isupper()
        is_plain = all(isinstance(value, (str, int, float, type(None))) for value in constants)
        return is_name and is_plain and len(node.elts) >= 3
    # A docstring, or a string that stands by itself.
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def of_native(folder=ROOT / "native"):
    """[Text] of what the module's exceptions say, as far as C++ tells it: strings between what is filled in."""
    found = []
    for path in sorted(folder.rglob("*.cpp")):
        if path.relative_to(folder).parts[0] in {"meanvalue", "bindings"} and not SILENT_FOLDERS & set(path.parts):
            source = path.read_text()
            for match in re.finditer(r"\b(?:InvalidInput|SolverFailure|return message)\(", source):
                text = cpp_text(_in_brackets(source, match.end()))
                if len(words(text)) >= 2:
                    line = source.count("\n", 0, match.start()) + 1
                    found.append(Text(f"{path.relative_to(folder).as_posix()}:{line}", text))
    return found


def _in_brackets(source, begin):
    depth, end, in_string = 1, begin, False
    while depth:
        letter = source[end]
        if letter == '"' and source[end - 1] != "\\":
            in_string = not in_string
        elif not in_string:
            depth += {"(": 1, ")": -1}.get(letter, 0)
        end += 1
    return source[begin : end - 1]


def cpp_text(arguments):
    """`message("anchor ", k, " is vertex ")` is "anchor … is vertex "; strings that follow each other are one."""
    arguments = re.sub(r'"\s*\n\s*"', "", arguments)
    pieces = re.findall(r'"((?:[^"\\]|\\.)*)"', arguments)
    between = re.split(r'"(?:[^"\\]|\\.)*"', arguments)
    text = pieces[0] if pieces else ""
    if pieces and re.sub(r"\b(?:::)?(?:meanvalue::)?message\(", "", between[0]).strip(" ,\n"):
        text = GAP + text
    for piece, gap in zip(pieces[1:], between[1:-1], strict=True):
        text += (GAP if gap.strip(" ,\n") else "") + piece
    return text + (GAP if pieces and between[-1].strip(" ,\n)") else "")


def entries(page=None):
    """[(line, pattern)] of a page of entries: what is in *italics* in the first cell of the rows of its tables."""
    found = []
    for number, line in enumerate((PAGE.read_text() if page is None else page).splitlines(), 1):
        if line.startswith("| *"):
            cell = line[2:].split(" | ")[0]
            found += [(number, pattern) for pattern in re.findall(r"\*([^*]+)\*", cell)]
    return found


def matches(pattern, text):
    """Whether the entry `pattern` is of `text`: it quotes that, or a part of it long enough to know it by.

    A text that is only a part of what is shown ("not checked in …") may be quoted with what is around it.
    """
    parts = fixed_parts(pattern)
    if not parts:
        return False
    said = plain(text)
    is_enough = len(words(pattern)) >= 4 or len(words(pattern)) >= 0.4 * len(words(text))
    is_quoted = follows(parts, said) and is_enough
    is_part = len(words(text)) < len(words(pattern)) and follows(fixed_parts(text), plain(pattern))
    return is_quoted or is_part
