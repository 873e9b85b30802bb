#!/usr/bin/env python3
"""Runs a sweep on a Ray cluster, with the results that `wherein sweep` has on one machine.

Each case is a task, in which the program `wherein` runs one shard of the sweep. The program, the scene and the files
that it names travel to the nodes; the files of a case come back as soon as it ends, and lie in DIR as `wherein sweep`
would write them. A case whose worker or node dies, or that takes longer than its limit, is run again elsewhere. At the
end `wherein merge` writes the results. The same command given again runs only the cases that are missing.
"""

import argparse
import collections
import fcntl
import hashlib
import json
import os
import pathlib
import random
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

try:
    import ray
    from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy
except ImportError:
    print(
        "wherein.ray: failed to import the Python package ray: expected it to be installed (pip install 'ray[client]')",
        file=sys.stderr,
    )
    sys.exit(2)

EXIT_CODES = (
    "Exit code: 0 every case met the scene's expectations, 1 some did not, 2 some are missing or could not run."
)
# How much longer than a task's own limit the driver waits before it takes the worker for hung: files have to be packed
# and sent, too.
GRACE_S = 20.0
# How long a task tries to say that it has begun, where the node that keeps the roll has died.
NOTE_S = 10.0
# A shard beyond the greatest number of cases that a sweep may have: the program writes the plan of the sweep and runs
# nothing.
NO_CASE = "1000000000/1000000000"
# How long the driver waits for an answer from the address of the cluster.
REACHED_S = 10.0
# Port of a cluster at an address such as ray://HOST.
CLIENT_PORT = "10001"
HOW_TO_START = "ray start --head starts one, --address local uses none"
# Time between two lines of progress where standard error is no terminal.
LINE_EVERY_S = 30.0
# Least number of tasks in flight: more than a small cluster has cores, so that a cluster that grows on demand sees the
# demand.
FEWEST_IN_FLIGHT = 16
# Variables of the driver's environment that decide which adapter renders and with which bytes, and that the tasks get,
# too.
VARIABLES = ("WHEREIN_", "LP_", "NODEVICE_SELECT")
# Files larger than this are not searched for the names of further files.
LARGEST_TEXT_BYTES = 1_000_000
# A child that has Linux kill it when its parent dies, and then becomes the program: a killed worker leaves no program
# behind. On other systems the program goes on to its end, in vain.
DIE_WITH_PARENT = """
import os, sys
try:
    import ctypes
    ctypes.CDLL(None).prctl(1, 9)
except Exception:
    pass
os.execv(sys.argv[1], sys.argv[1:])
"""


class Refused(Exception):
    """The sweep cannot be carried out. The text is for the user; it is empty where the program has said the reason
    itself.
    """


# What runs on the nodes.


def node_folder():
    """Returns the folder that the tasks of a user share on this node."""
    folder = pathlib.Path(tempfile.gettempdir()) / f"wherein-ray-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    return folder


def shard_folder():
    """Returns a new folder for the results of a shard, which names this process; those that killed workers of this node
    left behind are deleted.
    """
    base = node_folder()
    for left in base.glob("shard-*"):
        try:
            os.kill(int(left.name.split("-")[1]), 0)
        except (ProcessLookupError, PermissionError):
            # There is no such process any more, or another user's has its number by now.
            shutil.rmtree(left, ignore_errors=True)
    return tempfile.TemporaryDirectory(prefix=f"shard-{os.getpid()}-", dir=base)


def staged(name, content):
    """Returns a folder of this node with the files of a stored dict {path: (mode, bytes)}, which is fetched where the
    folder is not there yet.

    name: digest of the content, which the folder is called by. It appears whole or not at all, so that several workers
        may make it at the same time.
    """
    base = node_folder()
    folder = base / name
    if not folder.exists():
        partial = pathlib.Path(tempfile.mkdtemp(dir=base))
        for path, (mode, stored) in ray.get(content).items():
            to = partial / path.lstrip("/")
            to.parent.mkdir(parents=True, exist_ok=True)
            to.write_bytes(stored)
            to.chmod(mode)
        try:
            partial.rename(folder)
        except OSError:
            # Another worker was faster.
            shutil.rmtree(partial)
    return folder


def run_program(job, shard, limit_s, folder):
    """Runs one shard of the sweep into `folder`. Returns the exit code, None where it took longer than `limit_s`, and
    what the program said.

    The program starts in a copy of the driver's folder, so that relative paths name the files that travelled.
    """
    program = staged(*job["program"]) / "wherein"
    tree = staged(*job["files"])
    here = tree / job["cwd"].lstrip("/")
    here.mkdir(parents=True, exist_ok=True)
    scene = f"{tree}{job['scene']}" if os.path.isabs(job["scene"]) else job["scene"]
    # Annotations of a CI system are the driver's to make.
    variables = {name: value for name, value in os.environ.items() if not name.startswith("GITHUB_")}
    command = [sys.executable, "-I", "-S", "-c", DIE_WITH_PARENT, program, "sweep", scene, *job["options"]]
    with tempfile.TemporaryFile() as said:
        child = subprocess.Popen(
            [*command, "--shard", shard, "--jobs", "1", "--out", folder],
            cwd=here,
            env={**variables, **job["variables"]},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=said,
            start_new_session=True,
        )
        try:
            code = child.wait(limit_s)
        except subprocess.TimeoutExpired:
            code = None
        finally:
            if child.poll() is None:
                os.killpg(child.pid, signal.SIGKILL)
                child.wait()
        said.seek(0)
        return code, said.read().decode(errors="replace").strip()


def run_shard(job, shard, limit_s, attempt, roll):
    """The task: runs one shard and returns its plan, the files of its cases, the exit code and what the program said.

    attempt: number by which the driver knows this task; 0 for one that only plans, which returns the whole plan.
    roll: actor that is told when and where the task began.
    """
    node = ray.get_runtime_context().get_node_id()
    if roll is not None:
        try:
            # The program starts when the note has arrived: the driver can tell a task that hangs from one that waits.
            ray.get(roll.note.remote(attempt, node, os.getpid()), timeout=NOTE_S)
        except ray.exceptions.RayError:
            # The roll is being moved to another node. The driver then goes by which tasks began later than this one.
            pass
    with shard_folder() as folder:
        code, said = run_program(job, shard, limit_s, folder)
        plan = pathlib.Path(folder) / "sweep.json"
        cases = pathlib.Path(folder) / "cases"
        found = [case for case in cases.iterdir() if not case.name.startswith(".")] if cases.exists() else []
        return {
            "node": node,
            "code": code,
            "said": said,
            "plan": plan.read_text() if plan.exists() and attempt == 0 else None,
            "facts": facts(plan.read_text()) if plan.exists() else None,
            "cases": {case.name: {file.name: file.read_bytes() for file in case.iterdir()} for case in found},
        }


def facts(plan):
    """Returns what has to be equal for parts of one sweep, by the text of its plan.

    The names of the cases, up to a million, become a digest. The path of the scene, which differs from node to node, is
    left out.
    """
    told = json.loads(plan)
    del told["path"]
    return {**told, "cases": hashlib.sha256(" ".join(told["cases"]).encode()).hexdigest()}


def end_worker(pid):
    """The task that ends a hung worker of this node, which holds a core otherwise; its program dies with it."""
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


class Roll:
    """The actor that is told which tasks have begun: a task that only waits for a core is not late."""

    def __init__(self):
        self.begun = []

    def note(self, attempt, node, pid):
        """Notes that a task has begun in a process of a node."""
        self.begun.append((attempt, node, pid))

    def take(self):
        """Returns what was noted since the last call."""
        begun, self.begun = self.begun, []
        return begun


# The folder of the sweep.


class Folder:
    """The folder of a sweep, with the same files and the same lock as `wherein sweep` has there."""

    def __init__(self, path):
        """Creates or opens the folder, locks it, and removes what a killed process left half written."""
        self.path = path
        try:
            (path / "cases").mkdir(parents=True, exist_ok=True)
            self.lock = open(path / ".lock", "a+")
        except OSError as error:
            raise Refused(f"failed to write into {path}: {error.strerror}")
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self.lock.seek(0)
            holder = self.lock.read() or "another process"
            raise Refused(
                f"failed to use the folder {path}: {holder} is sweeping into it; "
                "wait until it is done, or choose another --out"
            )
        self.lock.truncate(0)
        self.lock.write(f"process {os.getpid()}")
        self.lock.flush()
        # Hidden files are others': network file systems and desktops make some.
        for left in filter(pathlib.Path.is_dir, (path / "cases").glob(".*")):
            shutil.rmtree(left)

    def close(self):
        """Gives the lock back."""
        self.lock.close()

    def write_plan(self, text):
        """Writes the plan whole or not at all."""
        partial = self.path / ".sweep.json"
        partial.write_text(text)
        partial.replace(self.path / "sweep.json")

    def holds(self, case, frames):
        """Whether the case has run, its files are unchanged since, and the wanted images are among them."""
        folder = self.path / "cases" / case
        try:
            seal = json.loads((folder / "case.json").read_bytes())
            files = {name: (folder / name).read_bytes() for name in seal["files"]}
        except (OSError, ValueError, KeyError):
            return False
        return seal["failure"] is None and frames in ("none", seal["frames"]) and is_sealed(case, seal, files)

    def write_case(self, case, files):
        """Writes a case whole or not at all, in place of a record that is damaged or failed."""
        folder, partial = self.path / "cases" / case, self.path / "cases" / f".{case}"
        partial.mkdir()
        for name, content in files.items():
            (partial / name).write_bytes(content)
        if folder.exists():
            shutil.rmtree(folder)
        partial.rename(folder)


def is_sealed(case, seal, files):
    """Whether a case's files are those whose digests its record, the file case.json, has."""
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items() if name != "case.json"}
    return seal["id"] == case and seal["files"] == digests


# What travels.


def named_files(text, folder):
    """Returns the files that a text names by paths relative to `folder`."""
    words = set(re.split(r"[\s\"'=,;:\[\]{}()]+", text)) | set(re.findall(r"[\"']([^\"'\n]+)[\"']", text))
    named = set()
    for word in words:
        # A path that is absolute, or no path at all because it is too long, names nothing that travels.
        if word and not os.path.isabs(word) and len(word) < 256:
            path = os.path.abspath(os.path.join(folder, word))
            if os.path.isfile(path):
                named.add(path)
    return named


def subject_of_file(path):
    """Returns what a sweep file states as `subject`, or an empty text. The program runs it as a command in the present
    folder, and not in that of the file.
    """
    try:
        text = pathlib.Path(path).read_text(errors="replace")
    except OSError:
        return ""
    stated = re.search(r"""^\s*subject\s*=\s*("(?:[^"\\]|\\.)*"|'[^']*')""", text, re.M)
    return stated[1][1:-1].replace('\\"', '"') if stated else ""


def travelling(asked):
    """Returns the files that the sweep needs, as {absolute path: (mode, bytes)}: those that are shipped, and what they
    name, over and over.
    """
    todo = {os.path.abspath(asked.scene)}
    for path in asked.ship:
        below = [os.path.join(folder, name) for folder, _, names in os.walk(path) for name in names]
        todo |= {os.path.abspath(file) for file in below or [path]}
    todo |= named_files(asked.subject or subject_of_file(asked.scene), os.getcwd())
    for varied in asked.vary:
        todo |= named_files(varied, os.path.dirname(os.path.abspath(asked.scene)))
    files = {}
    while todo:
        path = todo.pop()
        try:
            content = pathlib.Path(path).read_bytes()
        except OSError as error:
            raise Refused(f"failed to read {path}: {error.strerror}")
        files[path] = (os.stat(path).st_mode & 0o777, content)
        if path.endswith((".toml", ".yaml", ".yml")) and len(content) < LARGEST_TEXT_BYTES:
            todo |= named_files(content.decode(errors="replace"), os.path.dirname(path)) - files.keys()
    return files


def stored(files):
    """Puts files into Ray's store, and returns their digest and a reference to them."""
    digest = hashlib.sha256()
    for path, (mode, content) in sorted(files.items()):
        digest.update(f"{path}\0{mode}\0{len(content)}\0".encode())
        digest.update(content)
    return digest.hexdigest(), ray.put(files)


# The driver.


class Progress:
    """A bar on a terminal, and otherwise a line every so often, on standard error."""

    def __init__(self, n_cases):
        self.n_cases, self.began = n_cases, time.monotonic()
        self.n_done, self.n_missed, self.n_failed = 0, 0, 0
        self.is_terminal, self.shown = sys.stderr.isatty(), self.began

    def count(self, files):
        """Counts one case by its files."""
        self.n_done += 1
        if json.loads(files["case.json"])["failure"] is not None:
            self.n_failed += 1
        elif not json.loads(files["summary.json"])["verdict"]["passed"]:
            self.n_missed += 1

    def show(self):
        """Draws the bar again, or prints a line if it is time for one."""
        now = time.monotonic()
        if not self.is_terminal and now - self.shown < LINE_EVERY_S:
            return
        self.shown = now
        per_s = self.n_done / max(now - self.began, 1e-3)
        left = f"{(self.n_cases - self.n_done) / per_s:.0f} s left" if self.n_done else "no case has ended yet"
        tally = "all passed so far"
        if self.n_missed + self.n_failed:
            tally = (
                f"{self.n_missed} FAILED" + (f" and {self.n_failed} could not run" if self.n_failed else "") + " so far"
            )
        text = f"{self.n_done}/{self.n_cases} cases, {60 * per_s:.1f}/min, {left}, {tally}"
        full = 32 * self.n_done // max(self.n_cases, 1)
        sys.stderr.write(f"\r\033[K{'█' * full}{'░' * (32 - full)} {text}" if self.is_terminal else text + "\n")
        sys.stderr.flush()

    def say(self, text):
        """Prints a line of its own, above the bar."""
        sys.stderr.write(("\r\033[K" if self.is_terminal else "") + text + "\n")
        sys.stderr.flush()

    def end(self):
        """Removes the bar."""
        if self.is_terminal:
            sys.stderr.write("\r\033[K")


class Attempt:
    """A task that was sent: the shard, its cases, and what is known of when and where it runs."""

    def __init__(self, number, shard, cases):
        self.number, self.shard, self.cases = number, shard, cases
        self.node, self.pid, self.began = None, None, None


class Driver:
    """Sends the shards of a sweep as tasks, and writes what comes back into the sweep's folder. Which task runs where
    and when is Ray's choice.
    """

    def __init__(self, asked, job, plan, folder):
        self.asked, self.job, self.folder = asked, job, folder
        self.ids, self.facts = json.loads(plan)["cases"], facts(plan)
        self.task = ray.remote(max_retries=0)(run_shard)
        # The roll is where the driver is if it can be, and begins anew elsewhere if its node dies.
        here = NodeAffinitySchedulingStrategy(ray.get_runtime_context().get_node_id(), soft=True)
        self.roll = (
            ray.remote(num_cpus=0, max_restarts=-1, max_task_retries=-1)(Roll)
            .options(scheduling_strategy=here)
            .remote()
        )
        self.flying, self.n_sent = {}, 0
        # When which task began; and the greatest number of a task that began so long ago that it is over.
        self.begun, self.newest_over, self.changed = collections.deque(), 0, time.monotonic()
        self.n_tries, self.n_again, self.given_up = collections.Counter(), 0, {}

    def run(self, missing):
        """Runs the cases with these indices; returns when each is written into the folder or given up."""
        self.todo = self.shards(missing)
        self.open = {self.ids[index] for index in missing}
        self.progress = Progress(len(missing))
        self.looked = time.monotonic()
        width = self.width()
        while self.todo or self.flying:
            while self.todo and len(self.flying) < width:
                self.send(*self.todo.popleft())
            ended, _ = ray.wait(list(self.flying), timeout=0.5)
            for reference in ended:
                self.take(self.flying.pop(reference), reference)
            if time.monotonic() - self.looked > 1.0:
                self.look()
                width = self.width()
            self.progress.show()
        self.progress.end()

    def shards(self, missing):
        """Divides cases into shards, with the nodes on which not to run them: shards of the wanted size where all of
        their cases are missing.
        """
        n_shards = -(-len(self.ids) // self.asked.cases_per_task)
        groups = collections.defaultdict(list)
        for index in missing:
            groups[index % n_shards].append(index)
        shards = collections.deque()
        for number, group in groups.items():
            if len(group) == len(range(number, len(self.ids), n_shards)):
                shards.append((f"{number + 1}/{n_shards}", group, None))
            else:
                shards.extend(self.single(index) for index in group)
        return shards

    def single(self, index, not_on=None):
        """Returns the shard that holds one case only."""
        return f"{index + 1}/{len(self.ids)}", [index], not_on

    def width(self):
        """Returns the number of tasks to have in flight: enough that no core waits for the driver."""
        return self.asked.jobs or max(FEWEST_IN_FLIGHT, 2 * int(ray.cluster_resources().get("CPU", 0)))

    def send(self, shard, cases, not_on):
        """Sends a shard as a task, to another node than the one that it failed on if there is one."""
        others = (
            [node["NodeID"] for node in ray.nodes() if node["Alive"] and node["NodeID"] != not_on] if not_on else []
        )
        where = NodeAffinitySchedulingStrategy(random.choice(others), soft=True) if others else "DEFAULT"
        self.n_sent += 1
        self.changed = time.monotonic()
        limit_s = self.asked.case_timeout_s * len(cases)
        reference = self.task.options(scheduling_strategy=where).remote(
            self.job, shard, limit_s, self.n_sent, self.roll
        )
        self.flying[reference] = Attempt(self.n_sent, shard, cases)

    def take(self, attempt, reference):
        """Takes what a task returned: writes its cases, and has those run again that it does not hold."""
        try:
            got = ray.get(reference)
        except ray.exceptions.RayError as error:
            reason = "its node or worker died"
            if isinstance(error, ray.exceptions.RayTaskError):
                reason = "its task failed: " + str(error).strip().splitlines()[-1]
            return self.again(attempt, reason, attempt.node)
        self.check(got)
        for case, files in got["cases"].items():
            seal = json.loads(files["case.json"])
            # The same case may have come from another task, when this one was taken for hung.
            if case in self.open and is_sealed(case, seal, files):
                self.folder.write_case(case, files)
                self.open.remove(case)
                self.progress.count(files)
        reason = (
            f"it took longer than {self.asked.case_timeout_s:g} s"
            if got["code"] is None
            else f"the program said: {got['said']}"
        )
        self.again(attempt, reason, got["node"])

    def check(self, got):
        """Refuses results of another sweep than the planned one, such as that of another graphics adapter."""
        if got["facts"] is None:
            return
        for key, planned in self.facts.items():
            if got["facts"].get(key) != planned:
                what = "" if key == "cases" else f": {got['facts'].get(key)} and {planned}"
                raise Refused(
                    f"failed to merge what the nodes ran: node {got['node'][:8]} and the plan differ in {key}{what}; "
                    "expected nodes that are alike, or an adapter that all of them have (--adapter)"
                )

    def again(self, attempt, reason, node, counts=True):
        """Has the cases of an attempt that are still missing run again, each by itself; gives up those that were tried
        too often.
        """
        for index in attempt.cases:
            case = self.ids[index]
            if case not in self.open:
                continue
            self.n_tries[case] += counts
            if self.n_tries[case] > self.asked.retries:
                self.open.remove(case)
                self.given_up[case] = reason
                self.progress.say(f"wherein.ray: failed to run case {case} in {self.n_tries[case]} attempts: {reason}")
            else:
                self.n_again += 1
                self.progress.say(f"case {case} is run again: {reason}" + (f" (node {node[:8]})" if node else ""))
                self.todo.append(self.single(index, node))

    def look(self):
        """Looks which tasks have begun, and takes cases from workers that do not answer, such as stopped ones."""
        now = self.looked = time.monotonic()
        by_number = {attempt.number: attempt for attempt in self.flying.values()}
        try:
            begun = ray.get(self.roll.take.remote(), timeout=10)
        except ray.exceptions.RayError:
            # The roll is being moved to another node.
            begun = []
        for number, node, pid in begun:
            if number in by_number:
                attempt = by_number[number]
                attempt.node, attempt.pid, attempt.began = node, pid, now
            self.begun.append((now, number))
            self.changed = now
        longest_s = self.asked.case_timeout_s * self.asked.cases_per_task + GRACE_S
        while self.begun and self.begun[0][0] < now - longest_s:
            self.newest_over = max(self.newest_over, self.begun.popleft()[1])
        # No task runs, and none has begun for long, although some are sent.
        is_idle = now - self.changed > longest_s and all(attempt.began is None for attempt in self.flying.values())
        for reference, attempt in list(self.flying.items()):
            limit_s = self.asked.case_timeout_s * len(attempt.cases) + GRACE_S
            if attempt.began is not None and now - attempt.began > limit_s:
                del self.flying[reference]
                there = NodeAffinitySchedulingStrategy(attempt.node, soft=False)
                ray.remote(num_cpus=0, max_retries=0)(end_worker).options(scheduling_strategy=there).remote(attempt.pid)
                self.again(attempt, f"its worker did not answer for {limit_s:g} s", attempt.node)
            elif attempt.began is None and (is_idle or attempt.number < self.newest_over):
                # It was given to a worker that does not begin, or what it told of its beginning is lost.
                del self.flying[reference]
                ray.cancel(reference, force=True)
                self.again(attempt, "it was not begun", None, counts=False)


def options():
    """Returns the parser of the command line: the options of `wherein sweep`, and those of the cluster."""
    parser = argparse.ArgumentParser(
        prog="wherein.ray",
        description=__doc__,
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument("scene", metavar="SCENE", help="a scene file, or a sweep file")
    for name in ("--vary", "--seeds", "--subject", "--subject-timeout-s", "--frames", "--adapter"):
        kind = {"action": "append", "default": []} if name == "--vary" else {}
        parser.add_argument(name, help="as of wherein sweep", **kind)
    parser.add_argument("--baselines", action="store_true", help="as of wherein sweep")
    parser.add_argument("--junit", metavar="FILE", help="as of wherein sweep")
    parser.add_argument("--columns", metavar="NAMES", help="as of wherein sweep")
    parser.add_argument(
        "--out", metavar="DIR", type=pathlib.Path, help="folder for the results; by default sweeps/<scene>"
    )
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=int,
        help="greatest number of tasks in flight; by default twice the cores of the cluster",
    )
    parser.add_argument(
        "--address",
        default="auto",
        help="the cluster: auto, HOST:PORT, ray://HOST:PORT, or local for one on this machine",
    )
    parser.add_argument(
        "--program", default="wherein", help="the program that travels to the nodes; by default the wherein in PATH"
    )
    parser.add_argument(
        "--ship",
        metavar="PATH",
        action="append",
        default=[],
        help="a file or folder that has to travel, too; what scene, values of --vary or --subject name does so anyway",
    )
    parser.add_argument(
        "--case-timeout-s", metavar="S", type=float, default=3600.0, help="time limit of a case; by default 3600 s"
    )
    parser.add_argument(
        "--retries", metavar="N", type=int, default=3, help="how often a case is run again at most; by default 3"
    )
    parser.add_argument(
        "--cases-per-task", metavar="N", type=int, default=1, help="number of cases of one task; by default 1"
    )
    return parser


def passed_on(asked, with_adapter):
    """Returns the options that the program gets in each task."""
    passed = [word for varied in asked.vary for word in ("--vary", varied)]
    for name in ("seeds", "subject", "subject_timeout_s", "frames", "columns") + (("adapter",) if with_adapter else ()):
        value = getattr(asked, name)
        passed += [f"--{name.replace('_', '-')}", value] if value is not None else []
    return passed + (["--baselines"] if asked.baselines else [])


def planned_here(asked, program):
    """Returns the plan of the sweep by this machine's adapter, whichever that is: what is wrong with scene or options
    is said before any task runs.
    """
    variables = {name: value for name, value in os.environ.items() if name != "WHEREIN_ADAPTER"}
    with tempfile.TemporaryDirectory() as folder:
        command = [
            program,
            "sweep",
            asked.scene,
            *passed_on(asked, with_adapter=False),
            "--shard",
            NO_CASE,
            "--out",
            folder,
        ]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=variables)
        try:
            return (pathlib.Path(folder) / "sweep.json").read_text()
        except OSError:
            if not done.stderr:
                raise Refused(f"failed to plan the sweep: {program} ended with {done.returncode} and said nothing")
            sys.stderr.write(done.stderr)
            raise Refused("")


def planned_there(job, limit_s):
    """Returns the plan of the sweep by the adapter of a node."""
    try:
        got = ray.get(ray.remote(run_shard).remote(job, NO_CASE, limit_s, 0, None))
    except ray.exceptions.RayError as error:
        raise Refused(f"failed to plan the sweep on a node: {str(error).strip().splitlines()[-1]}")
    if got["plan"] is None:
        raise Refused(f"failed to plan the sweep on node {got['node'][:8]}: {got['said'] or 'no answer in time'}")
    return got["plan"]


def make_folder_of(path):
    """Creates the folder of a file that is written at the end, as the program does; nothing for None."""
    try:
        if path is not None:
            pathlib.Path(path).parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Refused(f"failed to create the folder of {path}: {error.strerror}")


def connect(address):
    """Connects to the cluster."""
    if address == "auto" and os.environ.get("RAY_ADDRESS"):
        address = os.environ["RAY_ADDRESS"]
    named = re.fullmatch(r"(ray://)?\[?([^/\]]+?)\]?(?::(\d+))?", address)
    port = named and (named[3] or (CLIENT_PORT if named[1] else None))
    if port:
        # Ray itself tries an address at which nothing listens for minutes, with a warning each time.
        try:
            socket.create_connection((named[2], int(port)), timeout=REACHED_S).close()
        except (OSError, OverflowError) as error:
            raise Refused(f"failed to connect to a Ray cluster at {address}: {error} ({HOW_TO_START})")
    # Functions of this file travel by value, so that nodes need Ray alone.
    if __name__ != "__main__":
        ray.cloudpickle.register_pickle_by_value(sys.modules[__name__])
    # A worker that the driver ends is no error that Ray should print.
    os.environ.setdefault("RAY_IGNORE_UNHANDLED_ERRORS", "1")
    try:
        if not ray.is_initialized():
            ray.init(address=address, log_to_driver=False, logging_level="ERROR")
    except (ConnectionError, RuntimeError, ValueError) as error:
        reason = str(error).strip().splitlines()[0]
        told = HOW_TO_START
        if (pathlib.Path.home() / ".ray/auth_token").exists() and "RAY_AUTH_MODE" not in os.environ:
            told += "; a cluster that was started after ~/.ray/auth_token was made asks for it: set RAY_AUTH_MODE=token"
        raise Refused(f"failed to connect to a Ray cluster at {address}: {reason} ({told})")


def sweep(asked):
    """Carries out the sweep, and returns the exit code."""
    program = shutil.which(asked.program)
    if program is None:
        raise Refused(f"failed to find the program {asked.program}: expected it in PATH, or its path as --program")
    # Keeps Mesa's device selection layer from asking for a display, which a headless machine does not have.
    os.environ.setdefault("NODEVICE_SELECT", "1")
    plan = planned_here(asked, program)
    files = travelling(asked)
    make_folder_of(asked.junit)
    connect(asked.address)
    job = {
        "program": stored({"wherein": (0o755, pathlib.Path(program).read_bytes())}),
        "files": stored(files),
        "scene": asked.scene,
        "cwd": os.getcwd(),
        "options": passed_on(asked, with_adapter=True),
        "variables": {name: value for name, value in os.environ.items() if name.startswith(VARIABLES)},
    }
    # Where pictures are rendered, the nodes' adapter is part of the plan, and this machine may have another one.
    if json.loads(plan)["adapter"] is not None:
        there = planned_there(job, asked.case_timeout_s)
        paths = [json.dumps(json.loads(text)["path"], ensure_ascii=False) for text in (there, plan)]
        plan = there.replace(*paths, 1)
    told = json.loads(plan)
    out = asked.out or pathlib.Path("sweeps") / told["scene"]
    folder = Folder(out)
    began = time.monotonic()
    try:
        folder.write_plan(plan)
        # A command under test may have changed since a case was recorded.
        is_known = told["program"] is not None and not re.search(r"[\s/]", asked.subject or "")
        cases = enumerate(told["cases"])
        missing = [index for index, case in cases if not (is_known and folder.holds(case, asked.frames or "none"))]
        driver = Driver(asked, job, plan, folder)
        driver.run(missing)
    finally:
        folder.close()
    ran, took_s = len(missing) - len(driver.given_up), time.monotonic() - began
    recorded = len(told["cases"]) - len(missing)
    print(
        f"{ran} case{'' if ran == 1 else 's'} run in {took_s:.1f} s ({60 * ran / took_s:.1f} cases/min), "
        f"{recorded} recorded earlier, {driver.n_again} run again",
        file=sys.stderr,
    )
    # The report names the program as the user did.
    return merge(asked, plan, out)


def merge(asked, plan, out):
    """Has the program merge what was recorded and write report and tables; returns its exit code."""
    with tempfile.TemporaryDirectory() as part:
        (pathlib.Path(part) / "sweep.json").write_text(plan)
        outputs = [word for name in ("junit", "columns") if getattr(asked, name) for word in (f"--{name}", getattr(asked, name))]
        return subprocess.run([asked.program, "merge", part, "--out", out, *outputs]).returncode


def main(arguments=None):
    """Runs the command, and returns the exit code."""
    asked = options().parse_args(arguments)
    for name, least in (("jobs", 1), ("retries", 0), ("cases_per_task", 1), ("case_timeout_s", 0.001)):
        # Not a number is no limit either.
        if getattr(asked, name) is not None and not getattr(asked, name) >= least:
            options().error(f"argument --{name.replace('_', '-')}: expected at least {least}")
    try:
        return sweep(asked)
    except Refused as refused:
        if str(refused):
            print(f"wherein.ray: {refused}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\nwherein.ray: interrupted; the same command goes on where it stopped", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
