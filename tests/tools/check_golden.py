"""usage: check_golden.py GENERATOR HEADER: the header is what the generator prints today."""
import difflib
import pathlib
import subprocess
import sys

generator, header = map(pathlib.Path, sys.argv[1:])
run = subprocess.run([sys.executable, str(generator)], stdout=subprocess.PIPE, text=True)
if run.returncode != 0:
    sys.exit(f"{generator}: ended with code {run.returncode}")
if not header.exists():
    sys.exit(f"{header}: missing; expected the output of: python3 {generator}")
old, new = header.read_text().splitlines(), run.stdout.splitlines()
if old == new:
    print(f"{header.name}: {len(new)} lines agree")
    sys.exit(0)
diff = difflib.unified_diff(old, new, str(header), f"output of {generator.name}", lineterm="", n=0)
for line, _ in zip(diff, range(20)):
    print(line)
sys.exit(f"{header}: differs from what {generator} prints")
