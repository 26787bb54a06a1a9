#!/usr/bin/env python3
"""Mutation test: does some test fail when a line of the product is weakened?

    tests/mutation/mutate.py [--count 240] [--seed 1] [--modules clay haptics io engine] [--folder build/mutants]
                            [--resume [--again]]

Copies the tree into FOLDER/src, puts seeded mutants into the sources of the modules (a comparison turned, a constant
changed, a sum made a difference, a statement left out ...), all of them into one build, where the variable ARGIL_MUTANT
switches one on. Every test is run once to see which mutants it reaches; then each mutant meets the tests that reach it,
the quickest first, until one fails. A test that fails without a mutant too does not count. Tests that take ten times the
processor time that they took (and 20 s more) count as failed, and those that take 20 times as long by the clock (and
2 minutes more): they hang. So other work may go on beside a run.

Prints a line for each mutant that no test noticed and, at the end, the share of mutants that were noticed; exit code 1
when it is below 90 %. FOLDER/results.json holds all. A run that was cut off goes on with --resume: same count, seed and
modules, and the product as it was; with --again mutants that no test noticed meet the tests of now. It needs Python 3.9, and what building Argil needs.
"""

import argparse
import json
import os
import pathlib
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor, as_completed

ROOT = pathlib.Path(__file__).resolve().parents[2]
REQUIRED_SHARE = 0.9
TEST_LIMIT_S = 240        # a test that takes more processor time than this is no part of the quick tier
BATCH_S, BATCH_TESTS = 3.0, 200  # tests that one process runs: their processor time, their count
MOST_MUTANTS = 4096       # tests/mutation/mutant.h

# What is exchanged for what inside an expression. Blanks around operators keep templates and pointers out.
EXCHANGES = [(" < ", " <= "), (" <= ", " < "), (" > ", " >= "), (" >= ", " > "), (" == ", " != "), (" != ", " == "),
             (" + ", " - "), (" - ", " + "), (" * ", " / "), (" / ", " * "), (" && ", " || "), (" || ", " && "),
             ("std::min(", "std::max("), ("std::max(", "std::min("), ("true", "false"), ("false", "true"),
             (" += ", " -= "), (" -= ", " += ")]
CONSTANT = re.compile(r"(?<![\w.\[<])(\d+\.\d+|\d+\.|\d+)(f?)(?![\w.>])")
ASSIGNMENT = re.compile(r"^[\w.\->\[\]]+(\([\w., ]*\))? (=|\+=|-=|\*=) .+;$")
CALL = re.compile(r"^[A-Za-z_][\w.\->:]*\(.*\);$")
INITIALISER = re.compile(r"^(const (?:auto|bool|int|int32_t|int64_t|uint64_t|size_t|float|double|Vec3d|Vec3f) \w+ = )(.+);$")


def balanced(text):
    depth = 0
    for letter in text:
        depth += letter in "([{"
        depth -= letter in ")]}"
        if depth < 0:
            return False
    return depth == 0


def changes(expression):
    """All expressions that are this one with one thing exchanged."""
    found = []
    for old, new in EXCHANGES:
        at = expression.find(old)
        while at >= 0:
            found.append(expression[:at] + new + expression[at + len(old):])
            at = expression.find(old, at + 1)
    for match in CONSTANT.finditer(expression):
        number, suffix = match.groups()
        other = str(int(number) + 1) if number.isdigit() else repr(float(number) * 2 if float(number) else 1.0) + suffix
        found.append(expression[:match.start()] + other + expression[match.end():])
    return found


def mutants_of_line(line):
    """(what is weakened, a function from the mutant's number to the line's new text) for each mutant of a line."""
    text = line.strip()
    code = text.split(" // ")[0].split("  //")[0].rstrip()
    if not code or code.startswith(("//", "#", "case ", "template", "using ", "static_assert", "constexpr", "inline ",
                                    "throw ", "friend ", "typedef", "} else", "for ", "while ", "do ", "namespace")):
        return
    if ".reserve(" in code:  # It changes what something costs, which tests do not time.
        return
    if '"' in code or "constexpr" in code or "HWY_" in code or not balanced(code.rstrip("{").rstrip()):
        return
    indent = line[:len(line) - len(line.lstrip())]
    ask = "::argil_mutation::on({})"
    condition = re.match(r"^if \((.+)$", code)
    if condition:
        depth, end = 1, None
        for i, letter in enumerate(condition.group(1)):
            depth += (letter == "(") - (letter == ")")
            if depth == 0:
                end = i
                break
        if end is None:
            return
        test, rest = condition.group(1)[:end], condition.group(1)[end + 1:]
        if " = " in test or ";" in test:
            return
        for changed in changes(test) + ["!(" + test + ")"]:
            yield (f"if ({changed})", lambda n, c=changed, t=test, r=rest:
                   f"{indent}if ({ask.format(n)} ? static_cast<bool>({c}) : static_cast<bool>({t})){r}\n")
        return
    if not code.endswith(";"):
        return
    if code.startswith("return "):
        value = code[7:-1]
        if value.startswith("{"):
            return
        for changed in changes(value):
            yield (f"return {changed};", lambda n, c=changed, v=value: f"{indent}return {ask.format(n)} ? ({c}) : ({v});\n")
        return
    initialiser = INITIALISER.match(code)
    if initialiser:
        head, value = initialiser.groups()
        if value.startswith("["):
            return
        for changed in changes(value):
            yield (f"{head}{changed};", lambda n, c=changed, h=head, v=value: f"{indent}{h}{ask.format(n)} ? ({c}) : ({v});\n")
        return
    if ASSIGNMENT.match(code) or CALL.match(code):
        yield ("left out", lambda n, c=code: f"{indent}{{ if (!{ask.format(n)}) {{ {c} }} }}\n")
        if ASSIGNMENT.match(code):
            for changed in changes(code):
                yield (changed, lambda n, c=changed, o=code: f"{indent}{{ if ({ask.format(n)}) {{ {c} }} else {{ {o} }} }}\n")


def choose(modules, count, seed):
    """Seeded, spread over modules and files: one mutant a line at most."""
    rng = random.Random(seed)
    chosen = []
    tracked = subprocess.run(["git", "ls-files", "--", *modules], cwd=ROOT, capture_output=True, text=True, check=True)
    for module in modules:
        files = []
        for name in tracked.stdout.split():
            if not name.startswith(module + "/") or not name.endswith(".cpp"):
                continue
            lines = (ROOT / name).read_text().splitlines(keepends=True)
            sites = []
            for i, line in enumerate(lines):
                # Lines that go on from the one before are parts of a longer expression.
                before = lines[i - 1].split("//")[0].strip() if i else ""
                if before and not before.endswith((";", "{", "}", ":", ")")):
                    continue
                options = list(mutants_of_line(line))
                if options:
                    sites.append((name, i, line, rng.choice(options)))
            rng.shuffle(sites)
            if sites:
                files.append(sites)
        # A file is drawn as often as it is long, no two from one line.
        pool = [site for sites in files for site in sites]
        rng.shuffle(pool)
        chosen += pool[:count // len(modules)]
    return chosen


def write_if_changed(path, text):
    if path.exists() and path.read_text(errors="surrogateescape") == text:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, errors="surrogateescape")


def lay_out(folder, mutants):
    """The tree with the mutants that are left; untouched files keep their times."""
    by_file = {}
    for number, mutant in mutants.items():
        by_file.setdefault(mutant["file"], []).append((number, mutant))
    tracked = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT,
                             capture_output=True, text=True, check=True)
    for name in tracked.stdout.split("\n"):
        source = ROOT / name
        if not name or not source.is_file():
            continue
        if name in by_file:
            lines = source.read_text().splitlines(keepends=True)
            for number, mutant in by_file[name]:
                lines[mutant["line"] - 1] = mutant["make"](number)
            write_if_changed(folder / "src" / name, '#include "tests/mutation/mutant.h"\n#line 1\n' + "".join(lines))
        else:
            target = folder / "src" / name
            data = source.read_bytes()
            if target.exists() and target.read_bytes() == data:
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
            target.chmod(source.stat().st_mode)


def build(folder, mutants, programs, jobs):
    """Builds; mutants that do not compile are taken out."""
    # Laid out and built as the release preset is, so that ccache has what no mutant touches.
    work = folder / "src" / "build" / "release"
    configure = ["cmake", "-S", str(folder / "src"), "-B", str(work), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                 "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG"]
    for _ in range(8):
        lay_out(folder, mutants)
        done = subprocess.run(configure, capture_output=True, text=True)
        if done.returncode:
            sys.exit(done.stdout + done.stderr)
        done = subprocess.run(["ninja", "-C", str(work), "-k", "0", "-j", str(jobs), *programs], capture_output=True, text=True)
        if done.returncode == 0:
            return work
        places = set()
        for match in re.finditer(r"([\w./-]+\.cpp):(\d+):(?:\d+:)? (?:fatal )?error", done.stdout):
            places.add((match.group(1), int(match.group(2))))
        bad = [n for n, m in mutants.items()
               if any(name.endswith(m["file"]) and abs(line - m["line"]) <= 1 for name, line in places)]
        if not bad:
            # A message that names another place: all mutants of the files that failed go.
            failed = set(re.findall(r"FAILED: \S*?CMakeFiles/[\w-]+\.dir/(\S+?)\.o\b", done.stdout))
            bad = [n for n, m in mutants.items() if any(m["file"].endswith("/" + f) for f in failed)]
        if not bad:
            sys.exit(done.stdout[-6000:])
        for number in bad:
            del mutants[number]
        print(f"{len(bad)} mutants do not compile and are left out", flush=True)
    sys.exit("mutants still do not compile")


def under(program):
    """What starts a program, as tests/CMakeLists.txt says."""
    return ["umockdev-wrapper"] if program.name.startswith("usb_") else []


def run_tests(program, names, most_cpu_s, most_s, **variables):
    """(the test that failed or None, seconds of processor time, seconds by the clock)"""
    environment = dict(os.environ, **variables)
    environment.pop("GTEST_OUTPUT", None)
    scratch = f"/tmp/argil-mutation-{os.getpid()}-{random.getrandbits(60):x}"
    environment["XDG_STATE_HOME"] = scratch
    limit = int(most_cpu_s) + 1

    def begin():
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # a run in the background may have it ignored

    start = time.monotonic()
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen([*under(program), str(program), "--gtest_filter=" + ":".join(names), "--gtest_fail_fast"],
                                   env=environment, cwd=program.parent, stdout=said, stderr=subprocess.DEVNULL,
                                   stdin=subprocess.DEVNULL, preexec_fn=begin)
        late = threading.Timer(most_s, process.kill)
        late.start()
        _, status, used = os.wait4(process.pid, 0)
        late.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        begun = re.findall(rb"^\[ +(?:RUN|FAILED) +\] ([\w/.]+)", said.read(), re.MULTILINE)
    subprocess.run(["rm", "-rf", scratch])
    failed = None
    if process.returncode:
        failed = begun[-1].decode() if begun else names[0]
    return failed, used.ru_utime + used.ru_stime, time.monotonic() - start


def trace(work, folder, programs, jobs, known):
    """[(seconds of processor time, by the clock, program, test, numbers of the mutants that it reaches)], quickest first;
    `known`: tests that need no look."""
    tests = []
    for name in programs:
        program = work / "bin" / name
        listed = subprocess.run([*under(program), str(program), "--gtest_list_tests"], capture_output=True, text=True, check=True, cwd=work / "bin")
        suite = ""
        for line in listed.stdout.splitlines():
            word = line.split("#")[0].strip()
            if line and not line[0].isspace():
                suite = word if word.endswith(".") else ""
            elif suite and not suite.startswith("Long") and (name, suite + word) not in known:
                tests.append((program, suite + word))

    def one(job):
        program, test = job
        file = folder / f"trace-{program.name}-{test.replace('/', '_')}"
        file.unlink(missing_ok=True)
        failed, cpu_s, seconds = run_tests(program, [test], TEST_LIMIT_S, 10 * TEST_LIMIT_S, ARGIL_MUTANT_TRACE=str(file))
        reached = {i for i, b in enumerate(file.read_bytes()) if b} if file.exists() else set()
        file.unlink(missing_ok=True)
        if failed:
            print(f"{program.name} {test}: failed or took too long without a mutant; left out", flush=True)
            return None
        return cpu_s, seconds, program, test, reached

    with ThreadPoolExecutor(jobs) as pool:
        done = [row for row in pool.map(one, tests) if row]
    return sorted(done, key=lambda row: row[0])


def judge(number, tests, most):
    """What became of a mutant. The tests that reach it meet it in turn, the quickest first, some of a program at once."""
    waiting = [row for row in tests if number in row[4]]
    if not waiting:
        return "not reached by any test"
    spent = 0.0
    while waiting and spent <= most:
        program, batch, cpu_s, seconds = waiting[0][2], [], 0.0, 0.0
        for row in waiting:
            if row[2] == program and (not batch or cpu_s + row[0] <= BATCH_S) and len(batch) < BATCH_TESTS:
                batch.append(row)
                cpu_s, seconds = cpu_s + row[0], seconds + row[1]
        names = [row[3] for row in batch]
        waiting = [row for row in waiting if row[2] != program or row[3] not in names]
        limits = (20 + 10 * cpu_s, 120 + 20 * seconds)
        failed, took, _ = run_tests(program, names, *limits, ARGIL_MUTANT=str(number))
        spent += took
        if failed and not run_tests(program, names, *limits)[0]:
            return f"killed by {program.name} {failed}"
    return "survived"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=240)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--modules", nargs="+", default=["clay", "haptics", "io", "engine"])
    parser.add_argument("--folder", type=pathlib.Path, default=ROOT / "build" / "mutants")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--limit", type=float, default=400, help="seconds of processor time of tests that one mutant meets; after them it survived")
    parser.add_argument("--resume", action="store_true", help="go on with a run that was cut off")
    parser.add_argument("--again", action="store_true", help="with --resume: judge again those that no test noticed")
    parser.add_argument("--list", action="store_true", help="print the mutants and stop")
    options = parser.parse_args()
    if not 1 <= options.count <= MOST_MUTANTS:
        parser.error(f"--count: 1 to {MOST_MUTANTS}")
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    mutants = {}
    for number, (name, index, line, (what, make)) in enumerate(choose(options.modules, options.count, options.seed)):
        mutants[number] = {"file": name, "line": index + 1, "was": line.strip(), "is": what, "make": make}
    if options.list:
        for number, m in mutants.items():
            print(f"{number:4} {m['file']}:{m['line']}: {m['was']}  ->  {m['is']}")
        return 0
    programs = [f"{kind}_{module}" for kind in ("unit", "property") for module in options.modules
                if any((ROOT / "tests" / kind / module).glob("*.cpp"))]
    # What else the quick tier has that reaches these modules.
    programs += ["failing_io", "failing_engine", "e2e_cli", "usb_haptics"]
    work = build(folder, mutants, programs, options.jobs)
    print(f"seed {options.seed}: {len(mutants)} mutants", flush=True)
    kept, results = folder / "trace.json", folder / "results.json"
    judged, tests = {}, []
    if options.resume and kept.exists():
        tests = [(cpu_s, seconds, work / "bin" / name, test, set(reached))
                  for cpu_s, seconds, name, test, reached in json.loads(kept.read_text())]
        if results.exists():
            judged = {m["number"]: m["result"] for m in json.loads(results.read_text())["mutants"]
                      if "result" in m and (not options.again or m["result"].startswith("killed"))}
    tests = sorted(tests + trace(work, folder, programs, options.jobs, {(row[2].name, row[3]) for row in tests}),
                    key=lambda row: row[0])
    kept.write_text(json.dumps([(cpu_s, seconds, program.name, test, sorted(reached))
                                for cpu_s, seconds, program, test, reached in tests]))
    print(f"{len(tests)} tests, {sum(row[0] for row in tests):.0f} s of processor time in all", flush=True)
    # In an order of its own, so that a run that is cut off has looked at all modules.
    order = list(mutants)
    random.Random(options.seed).shuffle(order)
    for number in order:
        mutants[number]["number"] = number
        mutants[number].pop("make")
        if number in judged:
            mutants[number]["result"] = judged[number]  # A run that is cut off keeps what the one before knew.
    with ThreadPoolExecutor(options.jobs) as pool:
        running = {pool.submit(judge, number, tests, options.limit): number for number in order if number not in judged}
        for done in as_completed(running):
            m, result = mutants[running[done]], done.result()
            m["result"] = result
            if not result.startswith("killed"):
                print(f"{result}: {m['file']}:{m['line']}: {m['was']}  ->  {m['is']}", flush=True)
            results.write_text(json.dumps({"seed": options.seed, "mutants": list(mutants.values())}, indent=1, default=str))
    share = {}
    for m in mutants.values():
        module = m["file"].split("/")[0]
        killed, all_ = share.get(module, (0, 0))
        share[module] = (killed + m["result"].startswith("killed"), all_ + 1)
    for module, (killed, all_) in share.items():
        print(f"{module}: {killed} of {all_} killed")
    killed, all_ = (sum(column) for column in zip(*share.values()))
    print(f"{killed} of {all_} mutants killed, {100 * killed / all_:.1f} %")
    return 0 if killed >= REQUIRED_SHARE * all_ else 1


if __name__ == "__main__":
    sys.exit(main())
