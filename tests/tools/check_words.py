"""usage: check_words.py ROOT: the core uses none of the words below (comments do not count)."""
import re
import sys

from csource import code_of, files

FORBIDDEN = {
    "int8_t uint8_t": "a 16-bit-char machine has no 8-bit type; use uint_least8_t or uint16_t",
    "double": "the core computes in float",
    "malloc calloc realloc alloca": "the core does not allocate",
    "volatile": "the core shares no memory with hardware",
    "printf fprintf sprintf snprintf puts": "the core does not print",
    "memcpy memset memmove": "assign structs instead",
    "errno setjmp longjmp goto": "the core returns a status",
    "asm __asm__": "the core is plain C99",
}
WHY = {word: why for words, why in FORBIDDEN.items() for word in words.split()}
PATTERN = re.compile(r"\b(" + "|".join(WHY) + r")\b")


def main(root):
    count = failed = 0
    for path in files(root, "include", "src"):
        count += 1
        for number, line in enumerate(code_of(path.read_text()).splitlines(), 1):
            if re.match(r"\s*#\s*(include|error)\b", line):
                continue
            for word in PATTERN.findall(line):
                failed += 1
                print(f"{path}:{number}: '{word}': {WHY[word]}")
    print(f"{count} files, {failed} forbidden words")
    return 1 if failed or not count else 0


sys.exit(main(sys.argv[1]))
