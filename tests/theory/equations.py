"""Reads the numbered equations of docs/theory.md and evaluates them, so that the page itself is tested.

The page uses a small part of TeX: names with accents, subscripts and primes, a sign as superscript for before and after an
impact, fractions, roots, the usual functions, matrices. A name becomes a real symbol of SymPy unless the environment has
another value for it: `\\hat f_{10}` is `hat_f_10`, `\\dot x_1^+` is `dot_x_1_plus`, `X_1'` is `X_1p`.
"""

import re
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Callable, Dict, List, Mapping, Optional, Tuple

import sympy

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "theory.md"

Environment = Mapping[str, Any]
Formula = Callable[..., Any]

TOKEN = re.compile(r"\\[A-Za-z]+|[A-Za-z]|\d+|[{}()\[\]^_+\-/=,&'!]")
RELATIONS = {"=": "=", r"\lt": "<", r"\le": "<=", r"\ge": ">=", r"\gt": ">"}
ACCENTS = {r"\hat", r"\dot", r"\ddot", r"\bar"}
GREEK = set(
    r"\alpha \beta \gamma \delta \varepsilon \zeta \eta \theta \kappa \lambda \mu \nu \xi \rho \sigma \tau \varphi \chi \psi"
    r" \omega \vartheta \Gamma \Delta \Lambda \Phi \Omega".split()
)
FUNCTIONS = {r"\sin": "sin", r"\cos": "cos", r"\cot": "cot", r"\arcsin": "asin", r"\arccos": "acos", r"\arg": "arg"}
NAMED = {"Re", "Im", "atan2"}
OPENING = {"{", "(", r"\begin", r"\lvert"}
CLOSING = {"}", ")", r"\end", r"\rvert"}

DEFAULTS: Dict[str, Any] = {
    "sin": sympy.sin,
    "cos": sympy.cos,
    "cot": sympy.cot,
    "asin": sympy.asin,
    "acos": sympy.acos,
    "arg": sympy.arg,
    "atan2": sympy.atan2,
    "Re": sympy.re,
    "Im": sympy.im,
    "abs": sympy.Abs,
    "sqrt": sympy.sqrt,
    "conjugate": sympy.conjugate,
    "factorial": sympy.factorial,
    "exp": sympy.exp,
    "i": sympy.I,
    "pi": sympy.pi,
    "number": sympy.Integer,
}


def sym(name: str) -> sympy.Symbol:
    """Returns the symbol for a name of the page."""
    return sympy.Symbol(name, real=True)


def tokens_of(tex: str) -> List[str]:
    """Splits TeX into its meaningful tokens; fails on an unknown character."""
    tex = re.sub(r"\\(?:left|right|quad)(?![A-Za-z])|\.(?=\s|$)", " ", tex)
    rest = TOKEN.sub("", tex)
    if rest.strip():
        raise ValueError(f"unknown TeX {rest.strip()!r} in {tex!r}")
    return TOKEN.findall(tex)


class Reader:
    """Evaluates tokens while reading them."""

    def __init__(self, tokens: List[str], environment: Environment):
        self.tokens = tokens
        self.at = 0
        self.environment = environment

    def peek(self, ahead: int = 0) -> str:
        index = self.at + ahead
        return self.tokens[index] if index < len(self.tokens) else ""

    def take(self, expected: Optional[str] = None) -> str:
        token = self.peek()
        if not token or (expected is not None and token != expected):
            raise ValueError(f"{token!r} instead of {expected!r} in {' '.join(self.tokens)}")
        self.at += 1
        return token

    def value(self, name: str) -> Any:
        if name in self.environment:
            return self.environment[name]
        return DEFAULTS[name] if name in DEFAULTS else sym(name)

    def function(self, name: str) -> Callable[..., Any]:
        return self.environment.get(name, DEFAULTS.get(name))  # type: ignore[no-any-return]

    def all(self) -> Any:
        result = self.sum()
        if self.peek():
            raise ValueError(f"{self.peek()!r} left over in {' '.join(self.tokens)}")
        return result

    def sum(self) -> Any:
        negative = self.peek() == "-"
        if self.peek() in ("+", "-"):
            self.take()
        result = self.product()
        result = -result if negative else result
        while self.peek() in ("+", "-"):
            sign = self.take()
            term = self.product()
            result = result + term if sign == "+" else result - term
        return result

    def product(self) -> Any:
        result = self.power()
        while True:
            token = self.peek()
            if token == "/":
                self.take()
                result = result / self.power()
            elif token and token not in {"+", "-", ",", "&", r"\cr", "'", "^", "_"} | CLOSING:
                result = result * self.power()
            else:
                return result

    def power(self) -> Any:
        base = self.atom()
        while self.peek() in ("^", "!"):
            if self.take() == "!":
                base = self.function("factorial")(base)
            elif self.peek() == "T":
                self.take()
                base = base.T
            else:
                exponent = self.argument()
                rounded = self.environment.get("exponent")
                base = base ** (rounded(exponent) if rounded else exponent)
        return base

    def argument(self) -> Any:
        """A group in braces or a single token."""
        if self.peek() == "{":
            return self.group("{", "}")
        token = self.take()
        return self.function("number")(int(token)) if token.isdigit() else self.value(token.lstrip("\\"))

    def group(self, opening: str, closing: str) -> Any:
        self.take(opening)
        result = self.sum()
        self.take(closing)
        return result

    def arguments(self) -> List[Any]:
        self.take("(")
        found = [self.sum()]
        while self.peek() == ",":
            self.take()
            found.append(self.sum())
        self.take(")")
        return found

    def atom(self) -> Any:
        token = self.peek()
        if token.isdigit():
            self.take()
            return self.function("number")(int(token))
        if token == "(":
            return self.group("(", ")")
        if token == "{":
            return self.group("{", "}")
        if token == r"\lvert":
            return self.function("abs")(self.group(r"\lvert", r"\rvert"))
        if token == r"\frac":
            self.take()
            above = self.group("{", "}")
            return above / self.group("{", "}")
        if token == r"\sqrt":
            self.take()
            return self.function("sqrt")(self.group("{", "}"))
        if token == r"\overline":
            self.take()
            return self.function("conjugate")(self.group("{", "}"))
        if token == r"\begin":
            return self.matrix()
        if token == r"\mathrm":
            return self.upright()
        if token in FUNCTIONS:
            self.take()
            function = self.function(FUNCTIONS[token])
            exponent = None
            if self.peek() == "^":
                self.take()
                exponent = self.argument()
            result = function(self.atom())
            return result if exponent is None else result**exponent
        if token == r"\pi":
            self.take()
            return self.value("pi")
        name = self.name()
        known = self.environment.get(name)
        if self.peek() == "(" and callable(known) and not isinstance(known, sympy.Basic):
            return known(*self.arguments())
        return self.value(name)

    def upright(self) -> Any:
        self.take(r"\mathrm")
        self.take("{")
        word = ""
        while self.peek() != "}":
            word += self.take()
        self.take("}")
        if word == "e":
            self.take("^")
            return self.function("exp")(self.argument())
        if word == "i":
            return self.value("i")
        if word in NAMED:
            return self.function(word)(*self.arguments())
        raise ValueError(f"unknown word {word}")

    def matrix(self) -> Any:
        for part in (r"\begin", "{", *"pmatrix", "}"):
            self.take(part)
        rows = [[self.sum()]]
        while self.peek() in ("&", r"\cr"):
            if self.take() == "&":
                rows[-1].append(self.sum())
            else:
                rows.append([self.sum()])
        for part in (r"\end", "{", *"pmatrix", "}"):
            self.take(part)
        return self.function("matrix")(rows) if "matrix" in self.environment else sympy.Matrix(rows)

    def name(self) -> str:
        """Reads a variable's name with its accents, subscripts and superscripts."""
        token = self.take()
        if token in ACCENTS:
            return f"{token[1:]}_{self.name()}"
        if token == r"\delta" and (self.peek() in ACCENTS or self.peek().isalpha() or self.peek() in GREEK):
            return f"delta_{self.name()}"
        if not (token.isalpha() or token in GREEK):
            raise ValueError(f"{token!r} is not a name in {' '.join(self.tokens)}")
        name = token.lstrip("\\")
        if self.peek() == "_":
            self.take()
            name += "_" + self.subscript()
        while self.peek() == "'":
            self.take()
            name += "p"
        if self.peek() == "^" and self.peek(1) in ("+", "-"):
            self.take()
            name += "_plus" if self.take() == "+" else "_minus"
        return name

    def subscript(self) -> str:
        if self.peek() != "{":
            return self.take().lstrip("\\")
        self.take("{")
        text = ""
        while self.peek() != "}":
            text += self.take().lstrip("\\").replace("'", "p")
        self.take("}")
        return text


@dataclass(frozen=True)
class Relation:
    """left = right, or an inequality."""

    left_tokens: Tuple[str, ...]
    sign: str
    right_tokens: Tuple[str, ...]

    def left(self, environment: Environment = {}) -> Any:
        return Reader(list(self.left_tokens), environment).all()

    def right(self, environment: Environment = {}) -> Any:
        return Reader(list(self.right_tokens), environment).all()

    @property
    def key(self) -> str:
        """The name on the left, or its TeX without blanks."""
        try:
            reader = Reader(list(self.left_tokens), {})
            name = reader.name()
            if not reader.peek():
                return name
        except ValueError:
            pass
        return "".join(self.left_tokens)


def split(tokens: List[str], separators: Mapping[str, Any]) -> List[List[str]]:
    """Splits at separators outside all brackets; a separator begins the piece after it."""
    pieces: List[List[str]] = [[]]
    depth = 0
    for token in tokens:
        depth += (token in OPENING) - (token in CLOSING)
        if depth == 0 and token in separators:
            pieces.append([token])
        else:
            pieces[-1].append(token)
    return pieces


@dataclass(frozen=True)
class Equation:
    """A numbered equation: its TeX and the relations in it."""

    number: int
    tex: str

    @property
    def relations(self) -> List[Relation]:
        tex = re.sub(r"\\begin\{aligned\}|\\end\{aligned\}", "", self.tex)
        if "aligned" in self.tex:
            tex = tex.replace("&", "")
        found: List[Relation] = []
        for part in re.split(r"\\qquad" if "pmatrix" in tex else r"\\qquad|\\cr(?![A-Za-z])", tex):
            first, *others = split(tokens_of(part), RELATIONS)
            for other in others:
                found.append(Relation(tuple(first), RELATIONS[other[0]], tuple(other[1:])))
        return found

    def relation(self, key: str) -> Relation:
        """The only relation with this left side."""
        found = [r for r in self.relations if r.key == key]
        assert len(found) == 1, f"({self.number}) has {[r.key for r in self.relations]}, not one {key}"
        return found[0]

    def __call__(self, key: str, environment: Environment = {}) -> Any:
        """The right side of the relation with this left side."""
        return self.relation(key).right(environment)

    def values(self, environment: Environment = {}) -> Dict[str, Any]:
        """All right sides in order, each evaluated with the values of earlier left sides."""
        known: Dict[str, Any] = dict(environment)
        for relation in self.relations:
            known[relation.key] = relation.right(known)
        return {r.key: known[r.key] for r in self.relations}


@lru_cache(maxsize=None)
def whole() -> str:
    """The page with its last section, whose formulas are rules of studies and have separate numbers."""
    return PAGE.read_text(encoding="utf-8")


@lru_cache(maxsize=None)
def page() -> str:
    """The sections with numbered equations, and their table."""
    return whole().split("\n## 17. ")[0]


@lru_cache(maxsize=None)
def displays() -> Tuple[str, ...]:
    """The TeX between lines of two dollars."""
    return tuple(re.findall(r"^\$\$\n(.*?)\n\$\$$", page(), re.S | re.M))


@lru_cache(maxsize=None)
def equations() -> Dict[int, Equation]:
    """All numbered equations."""
    found: Dict[int, Equation] = {}
    for tex in displays():
        tag = re.search(r"\\tag\{(\d+)\}", tex)
        assert tag, f"an equation without a number: {tex}"
        number = int(tag.group(1))
        assert number not in found, f"({number}) twice"
        found[number] = Equation(number, tex.replace(tag.group(0), ""))
    return found


def eq(number: int) -> Equation:
    return equations()[number]


def zero(expression: Any) -> bool:
    """Whether an expression, or every entry of a matrix, simplifies to zero."""
    if isinstance(expression, sympy.MatrixBase):
        return all(zero(x) for x in expression)
    return bool(sympy.simplify(expression) == 0)
