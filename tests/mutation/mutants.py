"""Finds what may be mutated in C sources, and writes them with chosen mutants by schemata.

A mutant is a small change: another comparison, another operator, another constant, a condition negated,
a statement left out. All of them are in one build; the variable lode_mutant says at run time which of
them, if any, is alive.
"""
import collections
import dataclasses
import pathlib
import re

import tree_sitter
import tree_sitter_c

LANGUAGE = tree_sitter.Language(tree_sitter_c.language())
FOLDERS = ("src", "include/lodestar")

RELATIONS = {"<": ("<=", ">="), ">": (">=", "<="), "<=": ("<", ">"), ">=": (">", "<"), "==": ("!=",), "!=": ("==",)}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*", "&": "|", "|": "&", "^": "|", "<<": ">>", ">>": "<<"}
LOGIC = ("&&", "||")
CONDITIONS = ("if_statement", "while_statement", "for_statement", "conditional_expression", "do_statement")
# Where C wants a constant, or nothing is computed.
NEVER_IN = ("enumerator", "array_declarator", "sizeof_expression", "bitfield_clause", "field_declaration",
            "type_definition", "preproc_def", "preproc_function_def", "preproc_if", "preproc_call", "type_descriptor")
# Macros whose arguments are expressions like any other's.
PLAIN_MACROS = ("LODE_USUALLY", "LODE_RARELY", "LODE_SHARED_STORE", "LODE_SHARED_LOAD")
# Words of this project that C's grammar does not know; blanks in their place, of the same length.
QUALIFIERS = re.compile(rb"\b(LODE_INLINE|LODE_RAMFUNC|LODE_SHARED|LODE_NOINLINE)\b(?!\()")

PREAMBLE = """\
#ifndef LODE_MUTANT_H
#define LODE_MUTANT_H
extern int lode_mutant;
extern unsigned char lode_reached[];
static inline __attribute__((always_inline)) int lode_m(int k) {
    lode_reached[k] = 1;
    return lode_mutant == k;
}
int lode_test_begins(const char *name);
void lode_test_ends(void);
// In place of RUN_TEST(): each test can be run alone.
#define LODE_RUN_TEST(test) \\
    do { \\
        if (lode_test_begins(#test)) { \\
            UnityDefaultTestRun(test, #test, __LINE__); \\
            lode_test_ends(); \\
        } \\
    } while (0)
#endif
"""

# LODE_MUTANT: the number of the one that is alive; LODE_TEST: the test that is run, of all of the program's;
# LODE_REACHED: a file for the numbers that it reached; LODE_LIST: nothing runs, the tests' names are printed.
SELECTOR = """\
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
int lode_mutant = -1;
unsigned char lode_reached[%d];
__attribute__((constructor)) static void choose(void) {
    const char *text = getenv("LODE_MUTANT");
    lode_mutant = text ? atoi(text) : -1;
}
int lode_test_begins(const char *name) {
    const char *only = getenv("LODE_TEST");
    if (getenv("LODE_LIST")) {
        printf("LODE_LIST %%s\\n", name);
        return 0;
    }
    memset(lode_reached, 0, sizeof lode_reached);
    return only == NULL || strcmp(only, name) == 0;
}
void lode_test_ends(void) {
    const char *name = getenv("LODE_REACHED");
    FILE *file = name ? fopen(name, "wb") : NULL;
    if (file) {
        fwrite(lode_reached, 1, sizeof lode_reached, file);
        fclose(file);
    }
}
"""


@dataclasses.dataclass(frozen=True)
class Mutant:
    file: str    # relative to the root
    line: int
    column: int  # in the line without its indent
    start: int   # bytes, of the node
    end: int
    kind: str    # relation, arithmetic, constant, condition, statement
    change: str  # what becomes of what
    text: str    # the source line
    where: str = ""  # function, and number in it, where the rest of the key is that of several

    def name(self):
        return f"{self.file}:{self.line}:{self.column}: {self.change}: {self.text}"

    def key(self):
        """Without the line's number, which moves, but with the place in it."""
        return " | ".join(filter(None, (self.file, f"{self.change} at {self.column}", self.text, self.where)))


def sources(root):
    for folder in FOLDERS:
        yield from sorted(path for path in pathlib.Path(root, folder).iterdir() if path.suffix in (".c", ".h"))


def text_of(node):
    return node.text.decode()


def ignored(node):
    """No mutants at or below it."""
    if node.type in NEVER_IN or node.type == "comment":
        return True
    if node.type == "call_expression":
        name = text_of(node.child_by_field_name("function"))
        return name.isupper() and name not in PLAIN_MACROS
    if node.type == "declaration":
        return any(text_of(child) == "static" for child in node.children)
    return False


def constants(text):
    """Others in its place."""
    match = re.fullmatch(r"(\d+)([uUlL]*)", text)
    if match:
        value, suffix = int(match[1]), match[2]
        return [f"{value + 1}{suffix}"] + ([f"{value - 1}{suffix}"] if value > 0 else [])
    if re.fullmatch(r"[\d.eE+-]+[fF]", text):
        return ["1.0f"] if float(text[:-1]) == 0.0 else [f"(2.0f * {text})", "0.0f"]
    return []


def changes(node):
    """(kind, change) of each mutant of this very node."""
    if node.type == "binary_expression":
        sign = text_of(node.child_by_field_name("operator"))
        for other in RELATIONS.get(sign, ()):
            yield "relation", f"{sign} -> {other}"
        if sign in ARITHMETIC:
            yield "arithmetic", f"{sign} -> {ARITHMETIC[sign]}"
        if sign in LOGIC:
            yield "relation", f"{sign} -> {LOGIC[1 - LOGIC.index(sign)]}"
    elif node.type == "assignment_expression":
        sign = text_of(node.child_by_field_name("operator")).removesuffix("=")
        if sign in ARITHMETIC:
            yield "arithmetic", f"{sign}= -> {ARITHMETIC[sign]}="
    elif node.type == "unary_expression":
        sign = text_of(node.child_by_field_name("operator"))
        if sign in "-!":
            yield "arithmetic" if sign == "-" else "condition", f"{sign} -> nothing"
    elif node.type == "update_expression":
        sign = text_of(node.child_by_field_name("operator"))
        yield "arithmetic", f"{sign} -> {'--' if sign == '++' else '++'}"
    elif node.type == "number_literal":
        for other in constants(text_of(node)):
            yield "constant", f"{text_of(node)} -> {other}"
    elif node.type == "break_statement":
        if not ends_switch(node):
            yield "statement", "left out"
    elif node.type == "expression_statement" and node.named_children:
        first = node.named_children[0]
        if first.type not in ("cast_expression", "number_literal", "identifier") and not ignored(first) and \
                not text_of(node).startswith(("(void)", "LODE_SIGNAL_FENCE")):
            yield "statement", "left out"


def ends_switch(node):
    """Whether nothing follows that a clause without this `break` would run into."""
    clause = node.parent
    return clause.type == "case_statement" and clause.named_children[-1] == node and clause.next_named_sibling is None


def condition_of(node):
    return node.child_by_field_name("condition") if node.type in CONDITIONS else None


def function_of(body):
    node = body.parent.child_by_field_name("declarator")
    while node.type != "identifier":
        node = node.child_by_field_name("declarator")
    return text_of(node)


class File:
    def __init__(self, root, path):
        self.path = path
        self.name = path.relative_to(root).as_posix()
        self.bytes = path.read_bytes()
        self.lines = self.bytes.decode().splitlines()
        plain = QUALIFIERS.sub(lambda m: b" " * len(m[0]), self.bytes)
        self.tree = tree_sitter.Parser(LANGUAGE).parse(plain).root_node

    def bodies(self, node=None):
        node = node or self.tree
        if text_of(node).startswith("#ifdef LODE_WITHOUT_"):  # what is left out is not in the tests' build
            node = node.child_by_field_name("alternative") or node.child_by_field_name("name")
        if node.type == "function_definition":
            yield node.child_by_field_name("body")
            return
        for child in node.children:
            if not ignored(child) or child.type.startswith("preproc_if"):
                yield from self.bodies(child)

    def mutant(self, node, kind, change):
        sign = node.child_by_field_name("operator") if change != "negated" else None
        row, column = (sign or node).start_point
        text = self.lines[row]
        return Mutant(self.name, row + 1, column - (len(text) - len(text.lstrip())) + 1, node.start_byte, node.end_byte, kind,
                      change, text.strip())

    def below(self, node, parent=None):
        """Mutants of a node and of all below it."""
        if ignored(node):
            return
        for kind, change in changes(node):
            yield self.mutant(node, kind, change)
        if text_of(node).startswith("#ifdef LODE_WITHOUT_"):  # what is left out is not in the tests' build
            node = node.child_by_field_name("alternative") or node.child_by_field_name("name")
        condition = condition_of(node)
        if condition is not None:
            yield self.mutant(condition, "condition", "negated")
        for child in node.children:
            if node.type == "case_statement" and child == node.child_by_field_name("value"):
                continue
            yield from self.below(child, node)

    def mutants(self):
        found = [dataclasses.replace(mutant, where=function_of(body)) for body in self.bodies() for mutant in self.below(body)]
        same_line = collections.Counter(mutant.key().removesuffix(mutant.where) for mutant in found)
        same_function = collections.Counter(mutant.key() for mutant in found)
        number = collections.Counter()
        for mutant in found:
            key = mutant.key()
            number[key] += 1
            if same_line[key.removesuffix(mutant.where)] == 1:
                mutant = dataclasses.replace(mutant, where="")
            elif same_function[key] > 1:
                mutant = dataclasses.replace(mutant, where=f"{mutant.where} {number[key]}")
            yield mutant

    # ---- Writing ----

    def written(self, chosen):
        """The source with these mutants: {Mutant: number}."""
        here = {}
        for mutant, number in chosen.items():
            if mutant.file == self.name:
                here.setdefault((mutant.start, mutant.end), []).append((mutant, number))
        self.here = here
        parts, at = [], 0
        for body in self.bodies():
            parts += [self.bytes[at:body.start_byte].decode(), self.render(body)]
            at = body.end_byte
        return "".join(parts) + self.bytes[at:].decode()

    def render(self, node):
        parts, at = [], node.start_byte
        for child in node.children:
            parts += [self.bytes[at:child.start_byte].decode(), self.render(child)]
            at = child.end_byte
        text = "".join(parts) + self.bytes[at:node.end_byte].decode()
        mine = self.here.get((node.start_byte, node.end_byte), [])
        own = [m for m in mine if m[0].kind != "condition" or m[0].change != "negated"]
        if own and any(m[0].change in [change for _, change in changes(node)] for m in own):
            text = self.with_mutants(node, text, own)
        for mutant, number in mine:
            parent = node.parent
            if mutant.change == "negated" and parent is not None and condition_of(parent) == node:
                inner = text[1:-1] if node.type == "parenthesized_expression" else text
                text = f"(lode_m({number}) != (0 != ({inner})))"
        return text

    def child_text(self, node, field):
        return self.render(node.child_by_field_name(field))

    def with_mutants(self, node, text, mine):
        if node.type == "number_literal":
            for mutant, number in mine:
                text = f"(lode_m({number}) ? {mutant.change.partition(' -> ')[2]} : {text})"
            return text
        if node.type in ("expression_statement", "break_statement"):
            return f"if (!lode_m({mine[0][1]})) {{ {text} }}"
        sign = text_of(node.child_by_field_name("operator"))
        if node.type == "binary_expression" and sign in LOGIC:
            left, right = self.child_text(node, "left"), self.child_text(node, "right")
            swap = f"lode_m({mine[0][1]}) != {int(sign == '||')}"
            return (f"({{ _Bool swap_ = {swap}; swap_ != ((swap_ != (0 != ({left}))) && "
                    f"(swap_ != (0 != ({right})))); }})")
        if node.type == "binary_expression":
            chain = f"left_ {sign} right_"
            for mutant, number in mine:
                chain = f"lode_m({number}) ? (left_ {mutant.change.partition(' -> ')[2]} right_) : ({chain})"
            left, right = self.child_text(node, "left"), self.child_text(node, "right")
            return f"({{ __auto_type left_ = ({left}); __auto_type right_ = ({right}); {chain}; }})"
        mutant, number = mine[0]
        other = mutant.change.partition(" -> ")[2]
        if node.type == "assignment_expression":
            left, right = self.child_text(node, "left"), self.child_text(node, "right")
            return (f"({{ __auto_type right_ = ({right}); lode_m({number}) ? ({left} {other} right_) : "
                    f"({left} {sign} right_); }})")
        value = self.child_text(node, "argument")
        if node.type == "update_expression":
            after = node.children[0].type != sign
            both = [f"{value}{s}" if after else f"{s}{value}" for s in (other, sign)]
            return f"(lode_m({number}) ? {both[0]} : {both[1]})"
        if sign == "!":
            return f"(lode_m({number}) != !({value}))"
        return f"({{ __auto_type value_ = ({value}); lode_m({number}) ? value_ : -value_; }})"


def all_mutants(root):
    return [mutant for path in sources(root) for mutant in File(root, path).mutants()]


def write(root, target, chosen):
    """Sources of `root` with these mutants, in a tree `target` that has them in the same places."""
    for path in sources(root):
        file = File(root, path)
        out = pathlib.Path(target, file.name)
        text = file.written(chosen)
        if not out.is_file() or out.read_text() != text:
            out.write_text(text)
    count = len(chosen)
    pathlib.Path(target, "src", "mutant.c").write_text(SELECTOR % max(count, 1))
    pathlib.Path(target, "mutant.h").write_text(PREAMBLE)
