"""Whatever fails, nothing is lost: a line, an exit code, and a rerun that gives the same bytes."""

import contextlib
import errno
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

import hostile_inputs
import numpy as np
import pytest
import typer
from file_faults import CALLS, broken, command, failing, interrupt, is_one_line, kill, run_in_child, tree
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.core.errors import OutputError
from walkergen.core.files.output import Folder

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="faults by means of POSIX")

FILES = {"a.csv": b"first\n" * 9000, "deep/b.stl": b"second" * 30, "deep/c.md": b"third"}


def written(folder, manifest="manifest.json", files=FILES):
    """Write a folder as a job does."""
    with Folder(folder, manifest) as target:
        for name, data in files.items():
            target.write(name, data)
        if manifest:
            target.finish({"by": "a test"})


@pytest.fixture(params=["manifest.json", ""], ids=["manifest", "plain"])
def job(request, tmp_path):
    """Function that writes a folder, the folder, and what it holds when nothing fails."""
    written(tmp_path / "reference", request.param)
    out = tmp_path / "out"
    # What another run left that made one file more, and one of another content
    before = FILES | {"a.csv": b"of before", "deep/old.stl": b"old"}
    reference = tree(tmp_path / "reference")
    if not request.param:
        del before["deep/old.stl"]  # without a manifest files are only added
        reference.pop(".walkergen")
    written(out, request.param, before)
    return (lambda: written(out, request.param)), out, reference


def settled(out):
    """Files of a folder, all but the memory of a folder without a manifest."""
    found = tree(out)
    found.pop(".walkergen", None)
    return found


def whole(out, reference):
    """True when every file of a folder is as before or as made, and none is half-written."""
    olds = {"a.csv": b"of before", "deep/old.stl": b"old"}
    return all(
        name.endswith("manifest.json") or data in (reference.get(name), olds.get(name))
        for name, data in tree(out).items()
        if not name.rpartition("/")[2].startswith(".")
    )


def refusal(work):
    """Text of the error that work ends in; "" for none."""
    try:
        work()
    except OutputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EIO, errno.EACCES])
def test_every_system_call_that_fails_is_a_line_and_a_rerun_completes(job, call, number):
    """EACCES is what Windows says of a file that another program holds open."""
    work, out, reference = job
    for count in range(1, 100):
        if call == "mkdir":
            shutil.rmtree(out)  # where a folder is already, its making may fail
        with failing(out, call, count, broken(number)) as seen:
            told = refusal(work)
        if len(seen) < count:
            break
        if call == "mkdir" and not told:  # of one that was there after all
            assert settled(out) == reference
            continue
        if (call, number, told) == ("open", errno.EACCES, ""):  # what nobody can read is not ours
            work()
            assert whole(out, reference)
            continue
        assert is_one_line(told)
        assert str(out) in told
        assert os.strerror(number) in told
        assert whole(out, reference)
        work()
        assert settled(out) == reference
        written(out, "manifest.json" if "manifest.json" in reference else "", FILES | {"a.csv": b"of before"})
    assert call in ("unlink", "fsync") or count > 1  # only a manifest waits for the disk


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "after"),
    [
        (kill, False),
        (interrupt, True),
        pytest.param(kill, True, marks=pytest.mark.nightly),
        pytest.param(interrupt, False, marks=pytest.mark.nightly),
    ],
)
def test_killed_or_interrupted_at_any_call_a_rerun_gives_the_same_bytes(job, fault, after):
    work, out, reference = job
    ends = 0
    for call in CALLS:
        for count in range(1, 100):

            def faulty(call=call, count=count):
                with failing(out, call, count, fault, after) as seen:
                    try:
                        work()
                    except KeyboardInterrupt:
                        sys.exit(130)
                sys.exit(0 if len(seen) < count else 3)

            code, _, told = run_in_child(faulty)
            assert not told
            if code == 0:
                break
            ends += 1
            assert code in (-9, 130)
            assert whole(out, reference)
            if fault is interrupt and not after:  # it had the time to tidy up
                assert not [name for name in tree(out) if ".walkergen-" in name]
            work()
            assert settled(out) == reference
    assert ends > 10


def test_a_full_disk_at_any_size_loses_nothing(job):
    work, out, reference = job
    largest = max(map(len, FILES.values()))
    seen = set()
    for size in range(0, largest + 4000, largest // 19):

        def full(size=size):
            resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
            told = refusal(work)
            assert not told or "File too large. Try another" in told
            sys.exit(bool(told))

        code, _, _ = run_in_child(full)
        seen.add(code)
        assert whole(out, reference)
        work()
        assert settled(out) == reference
        written(out, "manifest.json" if "manifest.json" in reference else "", FILES | {"a.csv": b"of before"})
    assert seen == {0, 1}


def test_what_is_not_ours_is_left_alone_and_all_else_is_written(tmp_path):
    """Changed since, or somebody's from the start; links, folders and pipes as well."""
    written(tmp_path)
    (tmp_path / "a.csv").write_bytes(b"with my notes")
    (tmp_path / "deep" / "c.md").unlink()
    (tmp_path / "deep" / "c.md").symlink_to(tmp_path / "a.csv")
    (tmp_path / "empty").touch()
    more = {"empty": b"1", "folder/x": b"2", "pipe": b"3", "new": b"4"}
    (tmp_path / "folder" / "x").mkdir(parents=True)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputError) as caught:
        written(tmp_path, files={name: data + b"!" for name, data in FILES.items()} | more)
    lines = str(caught.value).splitlines()
    assert all("not as walkergen wrote it: left alone" in line for line in lines)
    assert [line.split("'")[1].removeprefix(f"{tmp_path}/") for line in lines] == [
        "a.csv",
        "deep/c.md",
        "folder/x",
        "pipe",
    ]
    assert (tmp_path / "a.csv").read_bytes() == b"with my notes"
    assert (tmp_path / "deep" / "b.stl").read_bytes() == FILES["deep/b.stl"] + b"!"
    assert (tmp_path / "new").read_bytes() == b"4"
    assert (tmp_path / "empty").read_bytes() == b"1"
    (tmp_path / "a.csv").unlink()  # moved away, as it says
    with pytest.raises(OutputError, match="left alone") as caught:
        written(tmp_path)
    assert "a.csv" not in str(caught.value)


def test_a_file_left_alone_is_named_once_however_often_it_was_to_be_written(tmp_path):
    (tmp_path / "a.csv").write_bytes(b"mine")
    with contextlib.suppress(OutputError), Folder(tmp_path) as folder:
        assert not folder.write("a.csv", b"half")
        assert not folder.write("a.csv", b"whole")
        assert folder.left == ["a.csv"]


@pytest.mark.parametrize(
    "content",
    [
        b"{}",
        b"[1]",
        b"",
        b"{",
        b"[" * 10_000,
        b'{"a":' * 10_000,
        b"\xff\xfe",
        b'{"files": 3}',
        b'{"files": {"a.csv": 1}}',
    ],
)
def test_a_manifest_that_is_not_ours_stops_everything_before_it_begins(tmp_path, content):
    from walkergen.core.files import ledger

    for data in (content, b'{"x": %s,\n  "sealed": "%s"\n}\n' % (content, ledger.BLANK_SEAL)):
        sealed = ledger.add_seal(data) if data.endswith(b"}\n") else data
        (tmp_path / "manifest.json").write_bytes(sealed)
        before = tmp_path.joinpath("manifest.json").read_bytes()
        if ledger.decode_manifest(before) is not None:
            continue  # JSON after all, and sealed: a manifest without files
        with pytest.raises(OutputError, match="all files there are left alone") as caught:
            written(tmp_path)
        assert is_one_line(str(caught.value))
        assert [one.name for one in tmp_path.iterdir()] == ["manifest.json"]


def test_a_manifest_too_large_or_no_plain_file_is_not_read(tmp_path):
    path = tmp_path / "manifest.json"
    path.touch()
    os.truncate(path, 10**13)
    for make in (None, lambda: os.mkfifo(path), lambda: path.symlink_to("/dev/zero"), path.mkdir):
        if make is not None:
            path.unlink()
            make()
        with pytest.raises(OutputError, match="all files there are left alone"):
            written(tmp_path)


def test_two_at_once_do_not_write_one_folder_and_a_dead_one_keeps_nobody_out(tmp_path):
    with Folder(tmp_path) as first:
        first.write("a.csv", b"of the first")
        code, _, told = run_in_child(command("sweep", "--set", "legs.tilt_deg=5", "--out", tmp_path))
        assert (code, is_one_line(told)) == (2, True)
        assert "another walkergen writes there" in told
        first.finish({})
    assert set(tree(tmp_path)) == {"a.csv", "manifest.json"}


@pytest.fixture(scope="module", autouse=True)
def _loaded():
    """All that commands import, once, and not in every fork."""
    from walkergen.files import templates

    templates.list_templates()
    for words in (PREDICT, ("--help",)):
        assert CliRunner().invoke(command_line, words).exit_code == 0


def test_a_place_where_nothing_can_be_written_is_told_before_the_work(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: not mode & os.W_OK)
    for name in ("", "out", "a/b/out"):
        code, _, told = run_in_child(command("crowd", "--count", "900", "--out", tmp_path / name))
        assert (code, is_one_line(told)) == (1, True)
        assert f"'{tmp_path / name}': cannot be written: Permission denied. Try another --out" in told
    assert not tree(tmp_path)
    monkeypatch.undo()
    (tmp_path / "file").touch()
    code, _, told = run_in_child(command("crowd", "--count", "900", "--out", tmp_path / "file" / "out"))
    assert (code, is_one_line(told)) == (1, True)
    assert "cannot be written: Not a directory" in told


EXPORT = ("export", "--tilt", "10", "--legs", "braced", "--format", "stl,svg", "--quiet", "--out")


def test_a_command_names_the_file_that_could_not_be_written(tmp_path):
    out = tmp_path / "out"
    assert run_in_child(command(*EXPORT, out)) == (0, "", "")
    reference = tree(out)
    for call in ("open", "write", "replace"):

        def faulty(call=call):
            with failing(out, call, 2, broken(errno.EIO)):
                command(*EXPORT, out)()

        for path in (*out.glob("*/*"), *out.glob(".*")):
            path.unlink()
        code, _, told = run_in_child(faulty)
        assert (code, is_one_line(told)) == (1, True)
        assert told.startswith(f"error: '{out}/")
        assert run_in_child(command(*EXPORT, out)) == (0, "", "")
        assert tree(out) == reference


PREDICT = ("predict", "--tilt", "10", "--legs", "braced")


@pytest.mark.parametrize("words", [PREDICT, ("templates", "--json"), ("--help",)])
def test_output_that_nobody_can_read_is_a_line_and_a_failure(words):
    def full(*numbers):
        def prepare():
            for number in numbers:
                os.dup2(os.open("/dev/full", os.O_WRONLY), number)

        return prepare

    assert run_in_child(command(*words), full(1))[::2] == (1, "error: 'standard output': No space left on device\n")
    assert run_in_child(command(*words), closed=(1,))[::2] == (1, "error: 'standard output': Bad file descriptor\n")
    assert run_in_child(command(*words), full(1, 2)) == (1, "", "")
    assert run_in_child(command(*words), closed=(0, 1, 2)) == (1, "", "")


def test_a_reader_that_has_gone_is_no_mistake():
    def gone():
        read, write = os.pipe()
        os.close(read)
        os.dup2(write, 1)

    assert run_in_child(command(*PREDICT), gone) == (1, "", "")


def test_no_file_takes_the_place_of_a_closed_stream(tmp_path):
    code, _, _ = run_in_child(command(*EXPORT[:-2], "--out", tmp_path), closed=(0, 1, 2))
    assert code == 1  # its list of files could not be told
    for path in tmp_path.glob("stl/*"):
        assert (path.stat().st_size - 84) % 50 == 0


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8"])
def test_letters_that_a_stream_has_not_are_replaced_and_in_json_escaped(encoding):
    def work():
        import io
        import json as plain

        from walkergen.cli import console, streams
        from walkergen.files.report import Report

        for name in ("stdout", "__stdout__"):
            setattr(sys, name, io.TextIOWrapper(io.FileIO(1, "w", closefd=False), encoding))
        sys.__stdout__ = sys.stdout
        streams.prepare()
        print("± 3 µm, −1")
        report = Report(name="r", title="r", tables=[], facts={"Läufer ±": "\udcff"})
        console.print_report(report, json=True, quiet=False)
        assert plain.loads('"\\udcff"') == "\udcff"

    code, out, told = run_in_child(work)
    assert (code, told) == (0, "")
    first, *rest = out.splitlines()
    assert len(first) == 10
    assert '"\\udcff"' in "".join(rest)


def environment(**more):
    """Environment of a process without a home, or with what is given."""
    kept = {name: os.environ[name] for name in ("PATH", "PYTHONPATH") if name in os.environ}
    root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))  # noqa: PTH100, PTH120
    return kept | {"PYTHONPATH": root} | more


@pytest.mark.slow
@pytest.mark.parametrize(
    "surroundings",
    [
        {
            "HOME": "/nowhere",
            "TMPDIR": "/nowhere",
            "XDG_CACHE_HOME": "/dev/null",
            "LC_ALL": "C",
            "MPLBACKEND": "nonsense",
            "SOURCE_DATE_EPOCH": "abc",
            "PYTHONUTF8": "0",
            "PYTHONCOERCECLOCALE": "0",
        },
        pytest.param({"PYTHONIOENCODING": "ascii"}, marks=pytest.mark.nightly),
        pytest.param({"HOME": "/proc"}, marks=pytest.mark.nightly),
    ],
)
def test_surroundings_do_not_matter(tmp_path, surroundings):
    words = [sys.executable, "-m", "walkergen", "family", "--tilt", "10", "--legs", "braced", "--out", str(tmp_path)]
    done = subprocess.run(words, env=environment(**surroundings), capture_output=True, cwd="/")
    told = done.stderr.decode()
    assert done.returncode == 0, told
    assert "Traceback" not in told
    assert "matplotlib" not in told.lower()
    assert (tmp_path / "speed.pdf").read_bytes()[:5] == b"%PDF-"


def test_ctrl_c_while_a_library_loads_is_no_failure_of_it():
    """Python tells a Ctrl-C in the start of a module in C as an ImportError caused by it."""
    from walkergen import cli

    def stopped():
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as cause:
            raise ImportError("initialization failed") from cause

    code, _, told = run_in_child(lambda: cli.main(stopped))
    assert (code, told) == (130, "error: " + cli.INTERRUPTED_MESSAGE + "\n")


@pytest.mark.parametrize("program", ["walkergen", "evidence"])
def test_ctrl_c_while_a_program_is_loaded_leaves_no_trace(program):
    code = (
        "import runpy, sys\nclass Stop:\n    def find_spec(name, *_):\n"
        "        if name == 'walkergen.cli': raise KeyboardInterrupt\n"
        f"sys.meta_path.insert(0, Stop)\nrunpy.run_module('{program}', run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", code], env=environment(), capture_output=True)
    assert (done.returncode, done.stderr) == (130, b"")


def test_ctrl_c_that_a_library_prints_while_it_loads_is_no_failure_of_it():
    """As numba does where a Ctrl-C comes in the start of its part in C: PyErr_Print, then an ImportError of its own."""
    from walkergen import cli

    commands = typer.Typer()

    @commands.command()
    def stopped():
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt:
            sys.excepthook(*sys.exc_info())
        raise ImportError("numba._devicearray failed to import")

    def work():
        sys.argv = ["walkergen"]
        cli.main(commands)

    code, _, told = run_in_child(work)
    assert (code, told) == (130, "error: " + cli.INTERRUPTED_MESSAGE + "\n")


def test_ctrl_c_while_an_object_is_taken_apart_ends_the_command():
    """Python alone prints such a one, with a trace, and goes on."""
    from walkergen import cli

    class Dying:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    def stopped():
        Dying()
        time.sleep(20)

    code, _, told = run_in_child(lambda: cli.main(stopped))
    assert (code, told) == (130, "error: " + cli.INTERRUPTED_MESSAGE + "\n")


def test_a_folder_that_is_gone_is_a_line(tmp_path):
    def work():
        os.chdir(tmp_path)
        tmp_path.rmdir()
        command(*EXPORT, "out")()

    code, _, told = run_in_child(work)
    assert (code, is_one_line(told)) == (1, True)


LONG = {
    "export": ("export", "--tilt", "5,10", "--format", "stl,3mf,dxf,svg"),
    "family": ("family", "--tilt", "10", "--legs", "braced", "--page"),
    "plate": ("plate", "--tilt", "10", "--copies", "3"),
    "calibration": ("calibrate", "plate", "--no-pictures"),
    "sweep": ("sweep", "--set", "legs.tilt_deg=2:20:1", "--workers", "1"),
    "movie": ("movie", "--tilt", "10", "--legs", "braced", "--seconds", "0.01", "--slow", "40"),
    "trajectory": ("simulate", "--tilt", "10", "--legs", "braced", "--seconds", "0.5"),
    "analyse": ("analyse", "TRACKS"),
    "copy": ("templates", "copy", "koumakis2016"),
    "fit": ("fit", "SPEEDS"),
    "calibrate": ("calibrate", "FORM"),
    "drop": ("calibrate", "drop", "--roll-deg", "0", "--drops", "2", "--measured", "0.6", "--measured-sd", "0.1"),
    "accuracy": ("accuracy", "--budget", "1s"),
    "crowd": ("crowd", "rotator", "--count", "3", "--seconds", "0.5", "--runs", "2", "--no-pictures"),
    "card": ("crowd", "rotator", "--card", "--seconds", "2", "--runs", "4"),
    "validate": ("validate", "--only", "closed", "--quick"),
    "reproduce": ("reproduce", "--tilt", "5,10,20", "--gamma", "1.8,2.4", "--seconds", "0.2", "--runs", "8"),
}
"""Commands that write, with what is asked of them."""

EVIDENCE = ("validate", "reproduce")
"""Those of the evidence."""

TIMED = ("accuracy", "reproduce")
"""Those that write how long they took: equal in the files that they write, not in bytes."""

TRIES = int(os.environ.get("WALKERGEN_FAULTS", "3"))
"""Moments at which each is ended."""


def started(name, folder):
    """Process of a command that writes into a folder, seen from its own, where Ctrl-C is heard."""
    folder.parent.mkdir(exist_ok=True)
    words = [str(FOLDERS.get(word, word)) for word in LONG[name]]
    ends = {"movie": "film.gif", "copy": "mine.toml", "trajectory": "t.csv"}
    where = f"{folder.name}/{ends.get(name, '')}"
    if name != "copy":
        words.append("--trajectory" if name == "trajectory" else "--out")
    words = [sys.executable, "-m", "evidence" if name in EVIDENCE else "walkergen", *words, where]
    return subprocess.Popen(
        words,
        cwd=folder.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment(HOME=os.environ["HOME"], XDG_CACHE_HOME=str(FOLDERS["CACHE"])),
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


FOLDERS = {}
"""Inputs of the commands, made once."""


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Tracks, speeds and a form for the commands that read some."""
    base = tmp_path_factory.mktemp("inputs")
    FOLDERS.update(
        TRACKS=base / "t.csv",
        SPEEDS=base / "f.csv",
        FORM=base / "c.csv",
        CACHE=os.environ.get("XDG_CACHE_HOME", base / "cache"),
    )
    for name in ("SPEEDS", "FORM"):
        FOLDERS[name].write_text(hostile_inputs.TABLES[FOLDERS[name].name][0])
    run = CliRunner().invoke
    words = [*LONG["trajectory"], "--runs", "4", "--trajectory", str(base / "t.csv")]
    assert run(command_line, words).exit_code == 0


@pytest.mark.nightly
@pytest.mark.parametrize("ended_by", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("name", LONG)
def test_ended_at_random_moments_a_rerun_gives_the_same_bytes(tmp_path, inputs, name, ended_by):
    began = time.monotonic()
    for place in ("first", "reference"):  # the first one compiles
        began = time.monotonic()
        process = started(name, tmp_path / place / "out")
        _, told = process.communicate(timeout=600)
        assert process.returncode == 0, told
    lasts = time.monotonic() - began
    reference = tree(tmp_path / "reference" / "out")
    moments = np.random.default_rng(1).uniform(0.1, lasts, TRIES)
    for number, moment in enumerate(moments):
        out = tmp_path / f"{number}" / "out"
        process = started(name, out)
        try:
            process.wait(moment)
        except subprocess.TimeoutExpired:
            process.send_signal(ended_by)
        _, told = process.communicate(timeout=60)
        assert process.returncode in (0, 130 if ended_by == signal.SIGINT else -ended_by), told
        assert b"Traceback" not in told
        half = {path for path in tree(out) if not path.rpartition("/")[2].startswith(".")}
        assert half <= {*reference}
        again = started(name, out)
        _, told = again.communicate(timeout=600)
        if name == "copy" and again.returncode == 2:
            assert b"exists already" in told
        else:
            assert again.returncode == 0, told
        made = tree(out)
        assert made.keys() == reference.keys()
        assert name in TIMED or made == reference
        shutil.rmtree(out.parent)
