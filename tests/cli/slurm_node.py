# SPDX-License-Identifier: Apache-2.0
"""A Slurm cluster of one node on this machine, for one test: munged, slurmctld and slurmd with everything that is theirs in
a temporary folder and on ports of their own. It needs neither systemd nor control groups, but root, as slurmd does.
"""

import ctypes
import os
import pathlib
import secrets
import shutil
import signal
import socket
import subprocess
import tempfile
import time

PATIENCE = 60  # seconds for the daemons to come up

CONFIGURATION = """
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
SlurmctldPort={controller_port}
SlurmdPort={node_port}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
ReturnToService=2
KillWait=5
MaxArraySize={array_size}
NodeName={host} NodeAddr=127.0.0.1 CPUs={processors} State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=INFINITE State=UP
"""


def program(name):
    """Its path, also where only root's PATH has it; None if it is not installed."""
    return shutil.which(name, path=f"{os.environ.get('PATH', '')}:/usr/sbin:/sbin:/usr/local/sbin")


def why_not():
    """Why no node can be started here, or None."""
    absent = [name for name in ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo")
              if not program(name)]
    if absent:
        return f"Slurm is not installed: there is no {', '.join(absent)}"
    if os.geteuid() != 0:
        return "slurmd needs root"
    return None


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    try:
        for s in sockets:
            s.bind(("127.0.0.1", 0))
        return [s.getsockname()[1] for s in sockets]
    finally:
        for s in sockets:
            s.close()


def adopt_orphans():
    """What the daemons start becomes a child of this process when they end, so that it can be found and stopped."""
    PR_SET_CHILD_SUBREAPER = 36
    ctypes.CDLL(None, use_errno=True).prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def children():
    text = "".join(path.read_text() for path in pathlib.Path("/proc/self/task").glob("*/children"))
    return {int(word) for word in text.split()}


class CannotStart(Exception):
    pass


class Node:
    """with Node(...) as node: node.run("sbatch", ...)"""

    def __init__(self, processors=2, array_size=1001):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="juliavdb_slurm_"))
        self.daemons = []
        self.before = children()
        self.environment = {name: value for name, value in os.environ.items()
                            if not name.startswith(("SLURM_", "SBATCH_"))}
        self.environment["SLURM_CONF"] = str(self.folder / "slurm.conf")
        try:
            self.start(processors, array_size)
        except BaseException:
            self.stop()
            raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self, processors, array_size):
        adopt_orphans()
        self.folder.chmod(0o755)  # munged wants a socket that all can reach
        for name in ("state", "spool"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.touch(0o600)
        key.write_bytes(secrets.token_bytes(128))
        controller_port, node_port = free_ports(2)
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            folder=self.folder, host=socket.gethostname().split(".")[0], controller_port=controller_port,
            node_port=node_port, processors=processors, array_size=array_size))
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n")
        own = {what: f"{self.folder}/munge.{what}" for what in ("socket", "pid", "log", "seed")}
        self.daemon("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={own['socket']}",
                    f"--pid-file={own['pid']}", f"--log-file={own['log']}", f"--seed-file={own['seed']}")
        self.wait_for("munged", lambda: (self.folder / "munge.socket").exists())
        self.daemon("slurmctld", "-D", "-i")
        self.daemon("slurmd", "-D", "-f", str(self.folder / "slurm.conf"))
        self.wait_for("the node", lambda: "idle" in self.run("sinfo", "--noheader", "--format=%T", check=False).stdout)

    def daemon(self, name, *arguments):
        log = open(self.folder / f"{name}.out", "wb")
        self.daemons.append(subprocess.Popen(
            [program(name), *arguments], env=self.environment, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=log,
            stderr=subprocess.STDOUT, start_new_session=True))
        log.close()

    def logs(self):
        return "\n".join(f"--- {path.name}\n{path.read_text(errors='replace')[-3000:]}"
                         for path in sorted([*self.folder.glob("*.out"), *self.folder.glob("*.log")]))

    def wait_for(self, what, there):
        end = time.monotonic() + PATIENCE
        while not there():
            if time.monotonic() > end or any(daemon.poll() is not None for daemon in self.daemons):
                raise CannotStart(f"{what} did not come up\n{self.logs()}")
            time.sleep(0.1)

    def run(self, name, *arguments, check=True, **options):
        done = subprocess.run([program(name) or name, *map(str, arguments)], env=self.environment, text=True,
                              stdin=subprocess.DEVNULL, capture_output=True, timeout=PATIENCE, **options)
        if check and done.returncode != 0:
            raise AssertionError(f"{name} {arguments}: {done.returncode}\n{done.stdout}{done.stderr}\n{self.logs()}")
        return done

    def jobs(self):
        """Lines "ID STATE" of the jobs that are not over; each task of an array that has started is one."""
        return self.run("squeue", "--noheader", "--format=%A %T").stdout.splitlines()

    def wait_until_idle(self, seconds=300):
        end = time.monotonic() + seconds
        while self.jobs():
            if time.monotonic() > end:
                raise AssertionError(f"jobs are left: {self.jobs()}\n{self.logs()}")
            time.sleep(0.2)

    def stop(self):
        """Calls after the first do nothing."""
        try:
            if len(self.daemons) == 3 and self.daemons[1].poll() is None:
                self.run("scancel", "--user=root", "--signal=KILL", "--full", check=False)
                self.run("scancel", "--user=root", check=False)
        except (OSError, subprocess.SubprocessError):
            pass
        for daemon in reversed(self.daemons):
            daemon.terminate()
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
        self.daemons.clear()
        # What they had started is ours now.
        for _ in range(5):
            for orphan in children() - self.before:
                try:
                    os.kill(orphan, signal.SIGKILL)
                    os.waitpid(orphan, 0)
                except (ProcessLookupError, ChildProcessError):
                    pass
        shutil.rmtree(self.folder, ignore_errors=True)
