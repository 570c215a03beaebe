"""usage: check_called.py ROOT: every function of a test script is used in it. (The compiler looks after those in C.)"""
import ast
import pathlib
import sys


def unused(path):
    """(line, name) of each function of the script that nothing in it names."""
    tree = ast.parse(path.read_text())
    named = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name not in named:
            yield node.lineno, node.name


def main(root):
    count = failed = 0
    for path in sorted(pathlib.Path(root, "tests").rglob("test_*.py")):
        count += 1
        for line, name in unused(path):
            failed += 1
            print(f"{path}:{line}: '{name}' is never called, so it cannot fail")
    print(f"{count} scripts, {failed} functions never called")
    return 1 if failed or not count else 0


sys.exit(main(sys.argv[1]))
