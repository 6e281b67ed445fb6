"""Runs the league: renders what is missing, judges everything, compares with what is expected.

    python league.py --etendue PROGRAM [--dir target/league] [--quick] [--only WITNESS] [--seed-set N] [--case CASE] [--jobs J]

run.sh sets the environments up and calls this. Renders are kept in DIR/work, keyed by a digest of everything that they depend
on; verdicts are made anew each time, they cost little. DIR/results[-quick][-N].json holds all rows for report.py.
"""
import argparse
import concurrent.futures
import csv
import fcntl
import hashlib
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time

import numpy as np

import plan
import protocol

HERE = os.path.dirname(os.path.abspath(__file__))


def digest(*parts):
    made = hashlib.sha256()
    for part in parts:
        made.update(part if isinstance(part, bytes) else json.dumps(part, sort_keys=True).encode())
    return made.hexdigest()[:20]


def read(path):
    with open(path, "rb") as file:
        return file.read()


class League:
    def __init__(self, given):
        self.given = given
        self.results, self.lock = {}, threading.Lock()
        self.witnesses = os.path.join(HERE, "witnesses")
        self.suffix = ("-quick" if given.quick else "") + (f"-{given.seed_set}" if given.seed_set > 1 else "")

    def etendue(self, *arguments):
        return subprocess.run([self.given.etendue, *map(str, arguments)], capture_output=True, text=True)

    def python(self, witness):
        return os.path.join(self.given.dir, "venv", witness, "bin", "python")

    def wants(self, witness):
        return read(os.path.join(HERE, "requirements", witness + ".txt"))

    def installed(self, witness):
        """None, or why a witness cannot be asked."""
        if witness == "etendue":
            return None
        if not os.path.exists(os.path.join(self.given.dir, "venv", witness, "ready")):
            return "its packages could not be installed"
        if witness == "povray" and shutil.which("povray") is None:
            return "povray is not on the PATH (Debian: apt-get install povray)"
        return None

    def chunk(self, entry, folder, first, count):
        """One run of a witness: the path of what it wrote and what it said, or a status with words. A crash must show itself twice."""
        out, said = self.tried(entry, folder, first, count)
        if out == "crashed":
            words = said["words"]
            out, said = self.tried(entry, folder, first, count)
            if "notes" in said:
                said["notes"].append(f"crashed once ({words}), not when asked again")
                with open(os.path.join(folder, f"{first}-{count}", "said.json"), "w") as file:
                    json.dump(said, file)
        return out, said

    def tried(self, entry, folder, first, count):
        entry_folder = os.path.join(folder, f"{first}-{count}")
        out = os.path.join(entry_folder, "out.npy" if entry["mode"] == "images" else "out.csv")
        said_path = os.path.join(entry_folder, "said.json")
        if os.path.exists(out) and os.path.exists(said_path):
            return out, json.loads(read(said_path))
        if self.given.judge:
            return "not judged", {"words": "nothing was rendered yet"}
        shutil.rmtree(entry_folder, ignore_errors=True)
        os.makedirs(entry_folder)
        job = {"mode": entry["mode"], "scene": os.path.join(folder, "scene.json"), "manifest": os.path.join(folder, "manifest.json"),
               "out": out, "settings": entry["settings"], "samples": entry["samples"], "count": count, "efforts": entry.get("efforts", []),
               "first": first, "seed_set": self.given.seed_set, "most": entry["most"]}
        path = os.path.join(entry_folder, "job.json")
        with open(path, "w") as file:
            json.dump(job, file)
        command = [self.python(entry["witness"]), os.path.join(self.witnesses, entry["witness"] + ".py"), path]
        # With what it prints in files nothing fills up, and its processor time can be asked for when it ends.
        stdout_path = os.path.join(entry_folder, "stdout.txt")
        with open(stdout_path, "wb") as stdout, open(os.path.join(entry_folder, "stderr.txt"), "wb") as errors:
            child = subprocess.Popen(command, stdout=stdout, stderr=errors, cwd=entry_folder, start_new_session=True)
            begin, done = time.time(), 0
            while not done:
                if time.time() - begin > entry["timeout"]:
                    os.killpg(child.pid, signal.SIGKILL)
                    child.wait()
                    return "hung", {"words": f"no end after {entry['timeout']} s"}
                time.sleep(0.05)
                done, status, usage = os.wait4(child.pid, os.WNOHANG)
            child.returncode = os.waitstatus_to_exitcode(status)
        lines = read(stdout_path).decode(errors="replace").strip().splitlines()
        try:
            said = json.loads(lines[-1])
        except (IndexError, ValueError):
            last = read(os.path.join(entry_folder, "stderr.txt")).decode(errors="replace").strip().splitlines()[-1:]
            return "crashed", {"words": f"exit status {child.returncode} before it had finished: {' '.join(last)[:300]}"}
        if "inexpressible" in said:
            return "inexpressible", {"words": said["inexpressible"]}
        if child.returncode:
            # After the work was done and its file in place: told, not held against it.
            said["notes"].append(f"exit status {child.returncode} after the result was written")
        if not os.path.exists(out):
            return "broken output", {"words": "it said that it had finished, and there is no file"}
        problem = self.broken(entry, job, out)
        if problem:
            return "broken output", {"words": problem}
        said["processor_seconds"] = round(usage.ru_utime + usage.ru_stime, 2)
        with open(said_path, "w") as file:
            json.dump(said, file)
        return out, said

    @staticmethod
    def broken(entry, job, out):
        """What is wrong with a file as a file: half of it, another shape, no numbers. Wrong values are the judge's affair."""
        try:
            if entry["mode"] == "images":
                stack, due = np.load(out), (job["count"], *reversed([int(n) for n in entry["pixels"].split("x")]))
                if stack.shape != due:
                    return f"an array {stack.shape} where {due} is due"
                return None if np.isfinite(stack).all() else "NaN or infinite pixels"
            tables, due = protocol.read_points(out), job["efforts"] or [job["samples"]]
            if sorted(tables) != sorted(set(due)):
                return f"samples {sorted(tables)} where {sorted(due)} are due"
            return None if all(np.isfinite(t).all() for t in tables.values()) else "values that are missing, NaN or infinite"
        except Exception as error:
            return f"cannot be read: {error}"

    def run(self, entry):
        """Renders and judges one entry to the end: a row of the table."""
        row = {k: entry[k] for k in ("witness", "case", "label", "control", "mode", "samples", "settings", "pixels")}
        absent = self.installed(entry["witness"])
        if absent:
            return {**row, "verdict": "not installed", "words": absent}
        case = os.path.join(HERE, "cases", entry["case"] + ".toml")
        if entry["mode"] == "own":
            return self.own(entry, row, case)
        witness_files = [read(os.path.join(self.witnesses, entry["witness"] + ".py")), read(os.path.join(HERE, "protocol.py")),
                         self.wants(entry["witness"])]
        # What is rendered does not depend on where points are measured, nor on the remarks above the case.
        told = read(case).decode().partition("\ntitle")[2]
        witness_files.append((told.partition("[measure]")[0] if entry["mode"] == "images" else told).encode())
        witness_files += [read(os.path.join(HERE, "cases", picture)) for picture in re.findall(r'image = "([^"]+)"', told)]
        settings = {k: v for k, v in entry["settings"].items() if k != "first_sample_at_centre"}
        name = re.sub(r"[^a-z0-9]+", "-", f"{entry['witness']}-{entry['case']}-{entry['label']}".lower())
        key = digest(*witness_files, settings, entry["mode"], entry["pixels"], entry["samples"], entry.get("efforts"), self.given.seed_set)
        folder = os.path.join(self.given.dir, "work", f"{name[:80]}-{key}")
        made = self.etendue("export", case, "--for", "json", "--pixels", entry["pixels"], "--samples", entry["samples"], "-o", folder)
        if made.returncode:
            return {**row, "verdict": "inexpressible", "words": made.stderr.strip()[:300]}
        if entry["settings"].get("first_sample_at_centre"):
            path = os.path.join(folder, "manifest.json")
            manifest = json.loads(read(path))
            manifest["first_sample_at_centre"] = True
            with open(path, "w") as file:
                json.dump(manifest, file, indent=2)
        have, seconds, processor, step, outs, notes = 0, 0.0, 0.0, entry["count"], [], set()
        while True:
            out, said = self.chunk(entry, folder, have, step)
            if have and self.given.judge and out == "not judged":
                return row
            if not isinstance(out, str) or not os.path.exists(out):
                return {**row, "verdict": out, "words": said["words"]}
            outs.append(out)
            have, seconds = have + step, seconds + said["seconds"]
            processor += said.get("processor_seconds", said["seconds"])
            notes |= set(said["notes"])
            judged = self.verify(entry, folder, case, outs)
            row.update(judged, version=said["version"], seconds=seconds, processor_seconds=processor, notes=sorted(notes), count=have, folder=folder)
            wanted = re.search(r"about (\d+) (images|replicates) would do", judged.get("words", ""))
            if judged["verdict"] != "undecided" or have >= entry["most"]:
                return row
            # As many as are said to do, at least half as many again, at most what the plan allows.
            more = int(int(wanted.group(1)) * (4 / 3 if entry["mode"] == "points" else 1) * 1.1) if wanted else 2 * have
            step = min(max(more, have * 3 // 2), entry["most"], 4 * have) - have

    def verify(self, entry, folder, case, outs):
        name = f"{entry['witness']}: {entry['label']}" if entry["mode"] == "images" else entry["witness"]
        report = os.path.join(folder, "report" + self.suffix)
        if entry["mode"] == "images":
            whole = os.path.join(folder, "images.npy")
            np.save(whole, np.concatenate([np.load(path) for path in outs]))
        else:
            whole = os.path.join(folder, "estimates.csv")
            with open(whole, "w") as file:
                file.write("point,replicate,samples,value\n")
                begin = 0
                for path in outs:
                    rows = list(csv.DictReader(open(path)))
                    file.writelines(f"{r['point']},{begin + int(r['replicate'])},{r['samples']},{r['value']}\n" for r in rows)
                    begin += 1 + max(int(r["replicate"]) for r in rows)
        shutil.rmtree(report, ignore_errors=True)
        arguments = ["verify", case, whole, "--name", name, "--out", report]
        if entry["mode"] == "efforts":
            arguments += ["--converging"]
        else:
            arguments += ["--tolerance", entry["tolerance"], "--smallest-bias", entry["smallest"]]
        if entry["mode"] == "images":
            arguments += ["--manifest", os.path.join(folder, "manifest.json")]
        done = self.etendue(*arguments)
        if done.returncode not in (0, 1, 3):
            return {"verdict": "not judged", "words": (done.stderr or done.stdout).strip()[:400]}
        judged = {"report": report}
        path = os.path.join(report, "verdict.json")
        if os.path.exists(path):
            found = json.loads(read(path))
            judged["found"] = found
            verdicts = found.get("verdicts", [])
            bias = next((v for v in verdicts if v["property"] in ("bias", "limit")), None)
            judged["verdict"] = (bias or found)["verdict"]
            if entry["mode"] == "efforts":  # Where it goes, rather than whether it is there.
                judged["verdict"] = {"pass": "converges", "fail": "floor"}.get(judged["verdict"], judged["verdict"])
            judged["words"] = (bias or found).get("words") or ""
            judged["others"] = {v["property"]: v["verdict"] for v in verdicts if v["property"] not in ("bias", "limit")}
            for k in ("effect", "effect_low", "effect_high", "evidence_log10", "smallest_bias_mean", "smallest_bias_place"):
                judged[k] = (bias or {}).get(k)
        else:
            judged.update(self.spoken(done.stdout))
        os.makedirs(report, exist_ok=True)
        if entry["mode"] != "images":
            judged["exact_mean"] = self.tabulate(entry, case, whole, os.path.join(report, "points.csv"))
        return judged

    @staticmethod
    def spoken(text):
        """A verdict on estimates from what is printed."""
        words = {"PASS": "pass", "FAIL": "fail", "UNDECIDED": "undecided"}
        line = re.search(r"^(PASS|FAIL|UNDECIDED) .* bias +(.*±.*)$", text, re.M)
        number = r"([-−+]?[\d.]+)"
        found = re.search(number + r" ± " + number + r" %\s+" + number + r" / " + number + r" %\s+(\S+)", line.group(2))
        value = [float(x.replace("−", "-").replace("∞", "inf")) for x in found.groups()]
        # The command that follows names folders of this machine.
        told = " ".join(text[text.find("\n", line.end()):].split()).split(" again: ")[0]
        return {"verdict": words[line.group(1)], "words": told[:400], "effect": value[0] / 100, "effect_low": (value[0] - value[1]) / 100,
                "effect_high": (value[0] + value[1]) / 100, "smallest_bias_mean": value[2] / 100, "smallest_bias_place": value[3] / 100,
                "evidence_log10": value[4]}

    def tabulate(self, entry, case, estimates, out):
        """Means and standard errors at each point beside the exact value: the finest effort of a deterministic witness."""
        exact = list(csv.DictReader(self.etendue("exact", case).stdout.splitlines()))
        tables = protocol.read_points(estimates)
        with open(out, "w", newline="") as file:
            write = csv.writer(file)
            write.writerow(["point", "samples", "x_m", "y_m", "z_m", "region", "exact_irradiance_W_m2", "mean_irradiance_W_m2",
                            "std_error_W_m2"])
            for samples, table in sorted(tables.items()):
                mean = table.mean(axis=0)
                error = table.std(axis=0, ddof=1) / math.sqrt(len(table)) if len(table) > 1 else 0 * mean
                for i, e in enumerate(exact):
                    write.writerow([i, samples, e["x_m"], e["y_m"], e["z_m"], e["region"], e["irradiance_W_m2"], repr(float(mean[i])),
                                    repr(float(error[i]))])
        return float(np.mean([float(e["irradiance_W_m2"]) for e in exact]))

    def own(self, entry, row, case):
        """etendue's own estimator: the verdict of a run."""
        out = os.path.join(self.given.dir, "work", f"etendue-{entry['case']}-{entry['label']}-{self.given.seed_set}{self.suffix}")
        begin = time.time()
        done = self.etendue("run", case, "--strategy", entry["label"], "--samples", entry["samples"], "--replicates", "auto",
                            "--smallest-bias", entry["smallest"], "--seed", self.given.seed_set, "--no-plots", "--out", out, "--allow-undecided")
        if done.returncode not in (0, 1):
            return {**row, "verdict": "not judged", "words": done.stderr.strip()[:300]}
        with open(os.path.join(out, "verdicts.csv")) as file:
            verdicts = {v["property"]: v for v in csv.DictReader(file)}
        bias = verdicts["bias"]
        number = lambda k: float(bias[k]) if bias[k] else None
        return {**row, "verdict": bias["verdict"], "words": "", "effect": number("effect"), "effect_low": number("effect_low"),
                "effect_high": number("effect_high"), "smallest_bias_mean": number("smallest_bias_mean"),
                "smallest_bias_place": number("smallest_bias_point"), "evidence_log10": number("evidence"),
                "others": {k: v["verdict"] for k, v in verdicts.items() if k != "bias"}, "seconds": time.time() - begin,
                "version": self.etendue("--version").stdout.strip(), "notes": [], "count": None, "folder": out, "report": out}

    def save(self):
        # Several runs of the league may share a folder.
        with open(os.path.join(self.given.dir, "results.lock"), "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            self.save_alone()

    def save_alone(self):
        path = os.path.join(self.given.dir, f"results{self.suffix}.json")
        rows = {}
        if os.path.exists(path):
            rows = {tuple(r[k] for k in ("witness", "case", "label")): r for r in json.loads(read(path))["rows"]}
        planned = {tuple(e[k] for k in ("witness", "case", "label")): i for i, e in enumerate(plan.ENTRIES)}
        rows = {k: v for k, v in rows.items() if k in planned} | self.results
        ordered = [rows[k] for k in sorted(rows, key=planned.get)]
        with open(path + ".part", "w") as file:
            json.dump({"date": time.strftime("%Y-%m-%d"), "etendue": self.etendue("--version").stdout.strip(), "seed_set": self.given.seed_set,
                       "quick": self.given.quick, "machine": machine(), "rows": ordered}, file, indent=1)
        os.replace(path + ".part", path)

    def note(self, row):
        if self.given.judge and row["verdict"] == "not judged":
            return  # What an earlier run said of it stands.
        with self.lock:
            self.results[row["witness"], row["case"], row["label"]] = row
            seen = " / ".join("-" if row.get(k) is None else f"{100 * row[k]:.2g}" for k in ("smallest_bias_mean", "smallest_bias_place"))
            effect = "" if row.get("effect") is None else f"{100 * row['effect']:+.3f} %"
            print(f"{row['verdict'].upper():14} {row['witness']:9} {row['case']:20} {row['label']:44} {effect:>10}  seen from {seen} %  "
                  f"{row.get('seconds') or 0:.0f} s", flush=True)
            if row["verdict"] not in ("pass", "undecided") and not row.get("effect"):
                print(f"               {row.get('words', '')[:200]}", flush=True)
            self.save()

    def guarded(self, entry):
        try:
            return self.run(entry)
        except Exception as error:  # One entry's trouble is told in its row, and the rest goes on.
            return {**{k: entry[k] for k in ("witness", "case", "label", "control", "mode", "samples", "settings", "pixels")},
                    "verdict": "not judged", "words": f"{type(error).__name__}: {error}"}


def machine():
    import platform
    model = re.search(r"model name\s*: (.*)", open("/proc/cpuinfo").read()) if os.path.exists("/proc/cpuinfo") else None
    return f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores{', ' + model.group(1) if model else ''}"


def expected(quick):
    path = os.path.join(HERE, "expected.csv")
    if not os.path.exists(path):
        return {}
    with open(path) as file:
        return {(r["witness"], r["case"], r["label"]): r["verdict"] for r in csv.DictReader(file) if (r["run"] == "quick") == quick}


def expect(quick, results):
    """Replaces what is expected of the entries that were run."""
    path, mine = os.path.join(HERE, "expected.csv"), "quick" if quick else "full"
    rows = {}
    if os.path.exists(path):
        with open(path) as file:
            rows = {(r["run"], r["witness"], r["case"], r["label"]): r["verdict"] for r in csv.DictReader(file)}
    rows |= {(mine, *key): row["verdict"] for key, row in results.items() if row["verdict"] not in ("not installed", "not judged")}
    order = {(e["witness"], e["case"], e["label"]): i for i, e in enumerate(plan.ENTRIES)}
    with open(path, "w", newline="") as file:
        write = csv.writer(file)
        write.writerow(["run", "witness", "case", "label", "verdict"])
        write.writerows([*k, v] for k, v in sorted(rows.items(), key=lambda r: (r[0][0] == "quick", order.get(r[0][1:], 1e9))) if k[1:] in order)


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--etendue", required=True)
    words.add_argument("--dir", required=True)
    words.add_argument("--quick", action="store_true")
    words.add_argument("--only", help="one witness, or several with commas")
    words.add_argument("--case")
    words.add_argument("--seed-set", type=int, default=1)
    words.add_argument("--jobs", type=int, default=2)
    words.add_argument("--judge", action="store_true", help="judge what has been rendered, and render nothing")
    words.add_argument("--expect", action="store_true", help="write the verdicts of this run into expected.csv")
    given = words.parse_args()
    given.dir, given.etendue = os.path.abspath(given.dir), os.path.abspath(given.etendue)
    begin, league = time.time(), League(given)
    entries = [e for e in plan.ENTRIES if not given.only or e["witness"] in given.only.split(",")]
    if given.quick:
        entries = [{**e, "smallest": plan.SMALLEST_QUICK, **e["quick"]} for e in entries if e["quick"] is not None]
    controls = [e for e in entries if e["control"]]
    others = [e for e in entries if not e["control"] and (not given.case or e["case"] == given.case)]
    passed = set()
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
        for row in pool.map(league.guarded, controls):
            league.note(row)
            if row["verdict"] in ("pass", "converges"):
                passed.add(row["witness"])
        held = lambda e: league.guarded(e) if e["witness"] in passed or not league.installed(e["witness"]) is None else {
            **{k: e[k] for k in ("witness", "case", "label", "control", "mode", "samples", "settings", "pixels")},
            "verdict": "not judged", "words": "its control does not agree"}
        for done in concurrent.futures.as_completed([pool.submit(held, e) for e in others]):
            league.note(done.result())
    known, changed = expected(given.quick), 0
    for (key, row) in league.results.items():
        due = known.get(key)
        if row["verdict"] == "not installed":
            print(f"NOT INSTALLED: {key[0]}: {row['words']}")
        elif due is not None and due != row["verdict"]:
            changed += 1
            print(f"CHANGED: {' / '.join(key)}: {row['verdict']}, expected {due}: {row.get('words', '')}")
    if given.expect:
        expect(given.quick, league.results)
    print(f"{len(league.results)} entries, {changed} other than expected, {time.time() - begin:.0f} s")
    sys.exit(1 if changed else 0)


if __name__ == "__main__":
    main()
