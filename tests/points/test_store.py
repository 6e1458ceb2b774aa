"""Store of points: stored records are read back, after kills and next to other programs, or a clear error."""

import json
import os
import signal
import sqlite3
import subprocess
import sys
import time

import pytest
from nightly_cases import mostly_nightly

from walkergen.core.errors import OutputError
from walkergen.points.store import Store

RECORD = {"status": "ok", "speed_mm_s": 0.1 + 0.2, "runs": 7, "model": "é", "low_95_mm_s": None}

WRITER_SCRIPT = """
import sqlite3, sys
from pathlib import Path
sys.modules["walkergen.core.numerics.kernels"] = type(sys)("kernels")  # numba takes seconds to import
sys.modules["walkergen.points.point"] = point = type(sys)("point")
point.Record = dict
from walkergen.points.store import Store
store, first = Store(Path(sys.argv[1])), int(sys.argv[2])
print("ready", flush=True)
for number in range(first, first + 1_000_000, 3):
    rows = [(f"{number + more}", {"speed_mm_s": number / 7, "status": "x" * 300})
            for more in range(3)]
    store.save(rows)
    print(number, flush=True)
"""


@pytest.fixture
def path(tmp_path):
    return tmp_path / "points.sqlite"


def writer(path, first):
    return subprocess.Popen(
        [sys.executable, "-c", WRITER_SCRIPT, str(path), str(first)], stdout=subprocess.PIPE, text=True
    )


def test_records_come_back_to_the_last_bit(path):
    store = Store(path)
    store.save([("a", RECORD), ("b", {"status": "refused: no"})])
    assert store.get(["a", "b", "c"]) == {"a": RECORD, "b": {"status": "refused: no"}}
    assert list(store.get(["a"])["a"]) == list(RECORD)  # columns keep their order
    assert store.get([]) == {}
    store.save([("a", {"status": "anew"})])
    store.close()
    assert Store(path).get(["a"]) == {"a": {"status": "anew"}}


def test_a_put_is_saved_completely_or_not_at_all(path):
    store = Store(path)
    with pytest.raises(ValueError, match="not JSON compliant"):
        store.save([("a", RECORD), ("b", {"speed_mm_s": float("nan")})])
    with pytest.raises(OutputError, match="cannot be used"):
        store.save([("a", RECORD), (["no key"], RECORD)])
    assert store.get(["a"]) == {}
    store.save([("a", RECORD)])  # and it goes on
    assert Store(path).get(["a"]) == {"a": RECORD}


def killed_while_writing(path, first, after):
    """Numbers that a writer has reported as saved before it was killed."""
    with writer(path, first) as process:
        assert process.stdout.readline() == "ready\n"
        process.stdout.readline()
        time.sleep(after)
        process.kill()  # SIGKILL
        told = process.stdout.read().split("\n")
    assert process.returncode == -signal.SIGKILL
    return [first, *(int(word) for word in told[:-1])]


@pytest.mark.parametrize("times", mostly_nightly([5, 50], 5))
def test_kills_lose_no_saved_record(path, times):
    for kill in range(times):
        saved = killed_while_writing(path, 1_000_000 * kill, 0.002 * (kill % 7))
        store = Store(path)
        for number in saved:
            found = store.get([f"{number + more}" for more in range(3)])
            assert [one["speed_mm_s"] for one in found.values()] == [number / 7] * 3
        # What was under way when it was killed is there as a whole or not at all.
        assert len(store.get([f"{saved[-1] + 3 + more}" for more in range(3)])) in (0, 3)
        store.close()
    assert sqlite3.connect(path).execute("PRAGMA integrity_check").fetchall() == [("ok",)]


def test_two_programs_write_at_once(path):
    with writer(path, 0) as one, writer(path, 1_000_000) as other:
        written = []
        for process in (one, other):
            assert process.stdout.readline() == "ready\n"
        for process in (one, other):
            written.append([int(process.stdout.readline()) for _ in range(5)])
        for process in (one, other):
            process.kill()
    store = Store(path)
    for numbers in written:
        assert len(store.get([f"{number}" for number in numbers])) == 5


def test_a_writer_waits_for_another(path):
    """One that holds the lock for a while delays another, which then goes on."""
    store = Store(path)
    holder = sqlite3.connect(path, isolation_level=None)
    holder.execute("BEGIN IMMEDIATE")
    with writer(path, 0) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(0.3)
        assert process.poll() is None
        assert store.get(["0"]) == {}
        holder.execute("COMMIT")
        assert process.stdout.readline() == "0\n"
        process.kill()
    assert len(store.get(["0", "1", "2"])) == 3


def _used(path):
    store = Store(path)
    store.get(["a"])
    store.save([("b", RECORD)])


def store_refusal(path):
    """Return the line that states why a store cannot be used."""
    with pytest.raises(OutputError) as told:
        _used(path)
    (line,) = str(told.value).splitlines()
    assert line.startswith(f"{path}: the store of points cannot be used: ")
    assert "delete the file" in line
    return line


def test_a_file_of_another_program_is_left_unchanged(path):
    path.write_bytes(b"my thesis" * 1000)
    assert "not a database" in store_refusal(path)
    assert path.read_bytes() == b"my thesis" * 1000


def test_a_damaged_file_is_named(path):
    store = Store(path)
    store.save([(f"{number:032}", RECORD) for number in range(1000)])
    store.close()
    whole = path.read_bytes()
    path.write_bytes(whole[:4096] + bytes(len(whole) - 4096))
    store_refusal(path)
    path.write_bytes(whole[: len(whole) // 2])
    store_refusal(path)


def test_a_folder_that_is_not_there_or_not_writable_is_named(path, tmp_path):
    store_refusal(tmp_path / "nowhere" / "points.sqlite")
    (tmp_path / "file").write_text("")
    store_refusal(tmp_path / "file" / "points.sqlite")
    folder = tmp_path / "locked"
    folder.mkdir()
    folder.chmod(0o500)
    if not os.access(folder, os.W_OK):  # the superuser may write there all the same
        store_refusal(folder / "points.sqlite")


def test_a_full_disk_keeps_what_was_there(path):
    store = Store(path)
    store.save([("a", RECORD)])
    store._base.execute("PRAGMA max_page_count = 4")
    with pytest.raises(OutputError, match="full"):
        store.save([(f"{number}", {"status": "x" * 1000}) for number in range(100)])
    store._base.execute("PRAGMA max_page_count = 100000")
    assert store.get(["a", "0"]) == {"a": RECORD}
    store.save([("b", RECORD)])
    assert set(Store(path).get(["a", "b"])) == {"a", "b"}


def test_the_text_of_a_record_is_plain_json(path):
    """Anybody can read the table without walkergen."""
    Store(path).save([("a", RECORD)])
    ((text,),) = sqlite3.connect(path).execute("SELECT record FROM points").fetchall()
    assert json.loads(text) == RECORD


@pytest.mark.parametrize(
    "text",
    [
        "",
        "null",
        "[]",
        "{}",
        "{",
        "1",
        '{"speed_mm_s": NaN, "status": "ok"}',
        '{"runs": [1]}',
        '{"speed_mm_s": Infinity}',
        "[" * 100_000,
    ],
)
def test_a_damaged_record_is_ignored_and_measured_again(path, text):
    store = Store(path)
    store.save([("a", RECORD), ("b", RECORD)])
    with sqlite3.connect(path) as base:
        base.execute("UPDATE points SET record = ? WHERE key = 'a'", (text,))
    assert store.get(["a", "b"]) == {"b": RECORD}
    store.save([("a", RECORD)])
    assert store.get(["a"]) == {"a": RECORD}
