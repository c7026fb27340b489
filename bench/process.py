"""Runs a program and measures it from outside: clock, processors, memory, bytes, disk.

Linux only. What the kernel says is taken, not what the program says of itself.
"""

import os
import subprocess
import threading
import time
from dataclasses import dataclass

SAMPLE_SECONDS = 0.1


class RunFailed(Exception):
    """A run that gave no result; the message is what the table shows."""


@dataclass
class Usage:
    """What one process took."""

    seconds: float  # wall clock
    cpu_seconds: float  # user and system, all threads
    peak_rss: int  # bytes; ru_maxrss, so never below that of this small driver
    bytes_read: int | None  # through system calls, from caches too; None where /proc does not say
    bytes_written: int | None
    peak_disk: dict  # most bytes allocated below each watched directory, and below "all" at one time
    stdout: str


def allocated_bytes(directory):
    """Bytes on disk of all files below a directory; files that go meanwhile are passed over."""
    total = 0
    waiting = [directory]
    while waiting:
        try:
            with os.scandir(waiting.pop()) as entries:
                for entry in entries:
                    try:
                        if entry.is_dir(follow_symlinks=False):
                            waiting.append(entry.path)
                        else:
                            total += 512 * entry.stat(follow_symlinks=False).st_blocks
                    except FileNotFoundError:
                        pass
        except FileNotFoundError:
            pass
    return total


def unlinked_bytes(pid, directory):
    """Bytes on disk of files that the process holds open though they have no name any more."""
    total = 0
    folder = f"/proc/{pid}/fd"
    try:
        for name in os.listdir(folder):
            try:
                target = os.readlink(f"{folder}/{name}")
                if target.startswith(directory + "/") and target.endswith(" (deleted)"):
                    total += 512 * os.stat(f"{folder}/{name}").st_blocks
            except OSError:
                pass
    except OSError:
        pass
    return total


class DiskWatch:
    """Samples the space taken below directories while a process runs."""

    def __init__(self, pid, directories):
        self.peaks = {name: 0 for name in (*directories, "all")}
        self._pid = pid
        self._directories = {name: os.path.realpath(path) for name, path in directories.items()}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._thread.start()

    def _sample(self):
        taken = {name: allocated_bytes(path) + unlinked_bytes(self._pid, path)
                 for name, path in self._directories.items()}
        taken["all"] = sum(taken.values())
        for name, size in taken.items():
            self.peaks[name] = max(self.peaks[name], size)

    def _watch(self):
        while not self._stop.wait(SAMPLE_SECONDS):
            self._sample()

    def finish(self):
        self._stop.set()
        self._thread.join()
        self._sample()
        return self.peaks


def io_of(pid):
    """(bytes read, bytes written) of a process, which may have ended but must not be reaped."""
    try:
        with open(f"/proc/{pid}/io", encoding="ascii") as file:
            counts = dict(line.split(": ") for line in file)
        return int(counts["rchar"]), int(counts["wchar"])
    except (OSError, KeyError, ValueError):
        return None, None


def last_line(path):
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = [line.strip() for line in file if line.strip()]
    return lines[-1] if lines else ""


def run_measured(command, log_dir, watched=None):
    """Runs a command to its end.

    command   a list; its standard output is returned, its errors go to a file in log_dir
    watched   {name: directory} whose space on disk is sampled
    Raises RunFailed with the exit code and the last line of its errors.
    """
    command = [str(part) for part in command]
    out_path, err_path = os.path.join(log_dir, "stdout"), os.path.join(log_dir, "stderr")
    with open(out_path, "wb") as out, open(err_path, "wb") as err:
        start = time.monotonic()
        try:
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=err)
        except OSError as error:
            raise RunFailed(f"{os.path.basename(command[0])} cannot be started: {error.strerror}") from error
        watch = DiskWatch(process.pid, watched or {})
        try:
            os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
            seconds = time.monotonic() - start
            read, written = io_of(process.pid)
        except BaseException:
            process.terminate()
            process.wait()
            raise
        finally:
            peaks = watch.finish()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        how = f"exit code {process.returncode}" if process.returncode > 0 else f"signal {-process.returncode}"
        raise RunFailed(f"{how}: {last_line(err_path)}")
    with open(out_path, encoding="utf-8", errors="replace") as file:
        stdout = file.read()
    return Usage(seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024, read, written, peaks, stdout)
