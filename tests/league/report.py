"""Writes the league's report: index.html, a page for each witness and each finding, CSV tables, pictures. No network is needed to read it.

    python report.py --etendue PROGRAM --dir target/league --out reports/league
"""
import argparse
import csv
import json
import math
import os
import re
import shutil
from html import escape

import drawing
import findings
import plan
import predictions

HERE = os.path.dirname(os.path.abspath(__file__))
STYLE = """
:root{color-scheme:light dark;--ink:#1c1d1f;--soft:#5d6066;--paper:#fff;--line:#dcdee2;--panel:#f5f6f8;--accent:#1f5fa8;
--pass:#1b7a43;--fail:#b3261e;--floor:#b3261e;--undecided:#8a6100;--none:#6b6e75;--plus:#c0392b;--minus:#2463a8;--pred:#c2570c}
@media(prefers-color-scheme:dark){:root{--ink:#e6e7ea;--soft:#a2a6ae;--paper:#15171a;--line:#33373d;--panel:#1d2024;--accent:#7db3f2;
--pass:#5cc98a;--fail:#ff8a80;--floor:#ff8a80;--undecided:#e3b341;--none:#9a9ea6;--plus:#ff7b6b;--minus:#6aaeff;--pred:#ffa45c}}
*{box-sizing:border-box}body{margin:0;background:var(--paper);color:var(--ink);font:16px/1.55 system-ui,-apple-system,"Segoe UI",sans-serif}
main{max-width:74rem;margin:0 auto;padding:1.2rem 1rem 4rem}h1{font-size:1.7rem;line-height:1.25;margin:.4rem 0}h2{font-size:1.2rem;margin:2.2rem 0 .5rem}
p{max-width:46rem}a{color:var(--accent)}.soft{color:var(--soft)}.scroll{overflow-x:auto;-webkit-overflow-scrolling:touch}
table{border-collapse:collapse;font-size:.86rem;font-variant-numeric:tabular-nums;margin:.6rem 0}th,td{padding:.3rem .6rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}
th{font-weight:600;color:var(--soft);vertical-align:bottom}td.k{white-space:nowrap}td.w{min-width:13rem}code{background:var(--panel);border-radius:4px;padding:0 .25em;font-size:.92em}td.n{text-align:right;white-space:nowrap}.v{font-weight:600;white-space:nowrap}
.pass{color:var(--pass)}.fail,.floor{color:var(--fail)}.undecided{color:var(--undecided)}.none{color:var(--none)}
pre{background:var(--panel);border:1px solid var(--line);border-radius:6px;padding:.8rem;overflow-x:auto;font-size:.8rem;line-height:1.45}
pre.letter{white-space:pre-wrap}.plot{width:100%;min-width:34rem;max-width:42rem;height:auto;display:block;margin:.8rem 0}
.plot .grid{stroke:var(--line)}.plot text{fill:var(--ink);font:12px system-ui,sans-serif}.plot .tick{fill:var(--soft);font-size:11px;stroke:var(--paper);stroke-width:4px;paint-order:stroke}
.plot .label{fill:var(--soft)}.plot polyline{fill:none}.plot .exact{stroke:var(--soft);stroke-width:1.5}.plot .predicted{stroke:var(--pred);stroke-width:2;stroke-dasharray:5 4}
.plot .dot{fill:var(--accent)}.plot .bar{stroke:var(--accent);stroke-width:1.2}.plot .series{stroke:var(--accent);stroke-width:1.5}.plot .s1{stroke:var(--pred)}
.plot .cell{stroke:var(--line)}.plot .cell.plus{fill:var(--plus)}.plot .cell.minus{fill:var(--minus)}.plot .cell.none{fill:none}.plot .strong{fill:var(--paper)}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(17rem,1fr));gap:.7rem;padding:0;list-style:none}
.cards li{border:1px solid var(--line);border-radius:8px;padding:.7rem .8rem}.cards b{display:block}
"""


def kind(verdict):
    return {"pass": "pass", "converges": "pass", "fail": "fail", "floor": "floor", "undecided": "undecided"}.get(verdict, "none")


def percent(share, digits=2):
    return "" if share is None or not math.isfinite(share) else f"{100 * share:+.{digits}f} %" if abs(share) >= 5e-5 else f"{100 * share:+.4f} %"


def unsigned(share):
    return "" if share is None or not math.isfinite(share) else f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def digits(value, places=2):
    """A number to be read: neither 4090453.24 nor 2.2e+02."""
    return f"{value:.{places}f}" if abs(value) < 1e3 else f"{value:.2g}" if abs(value) >= 1e6 else f"{value:,.0f}"


def spoken(text):
    """What the judge said, without the paths of this machine and the command that repeats it."""
    return re.sub(r"(?<![\w.])/\S*/", "", re.sub(r" again:? .*", "", text or ""))


def sized(row):
    """Adds what the tables of a row say: deviation of the mean, the worst place."""
    row["data"] = None
    path = row.get("report")
    if not path or row["mode"] == "own":
        row["mean_dev"], row["mean_error"] = row.get("effect"), None
        return row
    name = os.path.join(path, "pixels.csv" if row["mode"] == "images" else "points.csv")
    if not os.path.exists(name):
        return row
    data = predictions.Row(row, None)
    total = data.exact.sum()
    row["data"] = data
    row["mean_dev"], row["mean_error"] = float(data.mean.sum() / total - 1), float((data.error**2).sum() ** 0.5 / total)
    worst = abs(data.mean - data.exact).argmax()
    row["worst_of_peak"] = float((data.mean - data.exact)[worst] / data.peak)
    row["worst_error"] = float(data.error[worst] / data.peak)
    if row["mode"] == "efforts":
        row["errors"] = [(n, float(abs(v - data.exact).max() / data.peak), float(abs(v.sum() / total - 1))) for n, v in data.by_effort.items()]
    return row


def reflowed(text):
    """A letter without our line breaks: lists, tables and headings keep theirs."""
    out = []
    for line in text.split("\n"):
        heading = bool(out) and out[-1].startswith("**") and out[-1].endswith("**")
        if out and line and out[-1] and not heading and not line.startswith(("    ", "**", "- ")) and not out[-1].startswith("    "):
            out[-1] += " " + line
        else:
            out.append(line)
    return "\n".join(out)


def words(text):
    """Text of ours with `code` in it, for a page: formulas as they are written by hand."""
    parts = escape(text).split("`")
    for k in range(0, len(parts), 2):
        parts[k] = parts[k].replace("sqrt(", "√(").replace("chi2", "χ²").replace("^2", "²").replace("^3", "³")
    return "".join(f"<code>{part}</code>" if k % 2 else part for k, part in enumerate(parts))


def page(title, body, depth=0):
    up = "../" * depth
    plain = escape(title.replace("`", ""))
    nav = f'<p><a href="{up}index.html">the league</a></p>' if depth else ""
    return (f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">'
            f"<title>{plain}</title><style>{STYLE}</style><main>{nav}<h1>{words(title)}</h1>{body}</main></html>\n")


def table(head, rows, numbers=()):
    # Long cells may wrap, short ones stay on their line: on a phone a table is moved sideways.
    kind_of = lambda k, c: "n" if k in numbers else "w" if len(re.sub("<[^>]*>", "", str(c))) > 34 else "k"
    cells = lambda row: "".join(f"<td class={kind_of(k, c)}>{c}</td>" for k, c in enumerate(row))
    return ('<div class="scroll"><table><thead><tr>' + "".join(f"<th>{h}</th>" for h in head) + "</tr></thead><tbody>"
            + "".join(f"<tr>{cells(r)}</tr>" for r in rows) + "</tbody></table></div>")


def verdict_cell(row):
    return f'<span class="v {kind(row["verdict"])}">{escape(row["verdict"])}</span>'


def seen(row):
    if kind(row["verdict"]) == "none":
        return escape(spoken(row.get("words")))
    if row["mode"] == "efforts":
        within = re.search(r"within ([\d.]+ %) in the mean, ([\d.]+ %)", row.get("words") or "")
        return f"within {within.group(1)} / {within.group(2)}" if within else "by convergence"
    return f"{unsigned(row.get('smallest_bias_mean'))} / {unsigned(row.get('smallest_bias_place'))}"


def with_error(share, error, places):
    """In percent, with so many places or as many as the error needs to show."""
    if share is None:
        return ""
    if not error:
        return f"{100 * share:+.{places}f} %"
    places = max(places, -math.floor(math.log10(100 * error)))
    return f"{100 * share:+.{places}f} ± {100 * error:.{places}f} %"


def minutes(seconds):
    return f"{seconds / 60:.0f} min" if seconds >= 60 else "under 1 min"


def deviation(row):
    return with_error(row.get("mean_dev"), row.get("mean_error"), 3)


def worst(row):
    return with_error(row.get("worst_of_peak"), row.get("worst_error"), 2)


def effort(row):
    if kind(row["verdict"]) == "none":
        return ""
    if row["mode"] == "efforts":
        return "up to " + str(max(n for n, *_ in row["errors"])) + " samples" if row.get("errors") else ""
    if row["mode"] == "own":
        return f"{row['samples']} samples"
    return f"{row.get('count', '')} x {row['samples']}" + (f", {row['pixels']} pixels" if row["mode"] == "images" else "")


HEAD = ["case", "setting", "verdict", "seen from, mean / place", "mean", "worst place, of the brightest", "work"]


def table_row(row):
    return [escape(row["case"]), escape(row["label"]), verdict_cell(row), seen(row), deviation(row), worst(row), effort(row)]


def picture(row, found):
    """The picture of a row: a profile, or a map."""
    data = row.get("data")
    if data is None:
        return ""
    title = f"{row['witness']}, {row['case']}, {row['label']}"
    fitting = [(one["name"], one["predicted"]) for one in found or [] if one["fits"] and one["name"] != "exact"][:1]
    if row["mode"] == "images":
        columns, rows = (int(n) for n in row["pixels"].split("x"))
        share = [100 * (m / e - 1) if e > 0 else None for m, e in zip(data.mean, data.exact)]
        z = [(m - e) / s if s > 0 else None for m, e, s in zip(data.mean, data.exact, data.error)]
        row_of = rows // 2
        line = slice(row_of * columns, (row_of + 1) * columns)
        along = data.position[line]
        step = ((along - along[0]) ** 2).sum(axis=1) ** 0.5
        straight = [(n, list(p)[line]) for n, p in fitting]
        across = drawing.profile(list(step - step[-1] / 2), list(data.exact[line]), list(data.mean[line]), list(data.error[line]), straight,
                                 title, "along the middle row of pixels, m from its middle", data.peak)
        return scrolled(across) + scrolled(drawing.signed_map(columns, rows, share, z, title))
    x = ((data.position - data.position[0]) ** 2).sum(axis=1) ** 0.5 + (data.position[0][0] if abs(data.position[0][1] - data.position[-1][1]) < 1e-9 else 0)
    return scrolled(drawing.profile(list(x), list(data.exact), list(data.mean), list(data.error), fitting, title))


# The cases that say most, first: shadows, then what is textured or mirrored, then what is open.
TELLING = ["disk-occluder", "rectangle-occluder", "distant-disk", "mirror", "ball", "textured", "sphere-occluder", "annular-eclipse", "contact-1mm", "disk-050", "rectangle"]


def telling(rows, most):
    """Some rows, of different cases as far as there are."""
    order = sorted(rows, key=lambda r: TELLING.index(r["case"]) if r["case"] in TELLING else len(TELLING))
    first, cases = [], set()
    for r in order:
        if r["case"] not in cases:
            first.append(r)
            cases.add(r["case"])
    return first[:most]


def scrolled(svg):
    return f'<div class="scroll">{svg}</div>'


def tests_table(found):
    rows = []
    for one in found:
        fit = f"{one['worst_of_peak']:.1e} (allowed {one['error_of_peak']:.1e})" if "error_of_peak" in one else f"{digits(one['chi2_n'])} ({one['dof']} free)"
        name = one["name"].replace("_", " ")
        rows.append([f"<b>{name}</b>" if one["fits"] else name,
                     f'<span class="v {"pass" if one["fits"] else "none"}">{"fits" if one["fits"] else "does not fit"}</span>', fit,
                     words(one["words"]) + (f" <span class=soft>{escape(one['fitted'])}</span>" if one["fitted"] else "")])
    return table(["hypothesis", "", "χ²/n, or worst of the brightest", "what it says"], rows)


def plain_table(rows):
    """A table for a letter: fixed width."""
    lines = [f"    {'case':22} {'mean':>20} {'worst, of the brightest':>26}"]
    return "\n".join(lines + [f"    {r['case']:22} {deviation(r):>20} {worst(r):>26}" for r in rows])


class Report:
    def __init__(self, results, explained, out, again):
        # What was run with one set of seeds and with another: (words, results, results).
        self.again = again
        self.rows = [sized(r) for r in results["rows"]]
        self.results, self.explained, self.out = results, explained, out
        self.by = {(r["witness"], r["case"], r["label"]): r for r in self.rows}

    def found(self, row):
        return self.explained.get("/".join(row[k] for k in ("witness", "case", "label")))

    def write(self, name, text):
        path = os.path.join(self.out, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w") as file:
            file.write(text)

    def finding(self, f):
        rows = [self.by[f["witness"], c, l] for c, l in f["entries"] if (f["witness"], c, l) in self.by]
        passes = [self.by[f["witness"], c, l] for c, l in f["passes"] if (f["witness"], c, l) in self.by]
        failed = [r for r in rows if kind(r["verdict"]) in ("fail", "floor")]
        fits = [(r, one) for r in failed for one in self.found(r) or [] if one["name"] == f["hypothesis"]]
        best = next((one for r, one in fits if one["fits"]), fits[0][1] if fits else {})
        filled = {"table": plain_table(rows), "version": next((r["version"] for r in rows if r.get("version")), "?"),
                  "chi2": f"{best.get('chi2_n', float('nan')):.2f}", "n": str(best.get("dof") or len(best.get("predicted", []))),
                  "fit": f"{best.get('worst_of_peak', float('nan')):.0e}",
                  "worst": f"{100 * max((abs(r.get('worst_of_peak') or 0) for r in rows), default=0):.1f} %"}
        fill = lambda text: re.sub(r"\{(\w+)\}", lambda m: filled.get(m.group(1), m.group(0)), text)
        with open(os.path.join(HERE, "findings", f["script"])) as file:
            script = file.read()
        body = f'<p>{words(fill(f["what"]))}</p><p class="soft">How far it reaches: {words(fill(f["scope"]))}</p><p>What to do: {words(f["workaround"])}</p>'
        if not failed:
            body = "<p><b>In this run no entry of this finding failed.</b></p>" + body
        body += "<h2>Measured</h2>" + table(HEAD, [table_row(r) for r in rows])
        for r in failed[:4]:
            body += f"<h3>{escape(r['case'])}, {escape(r['label'])}</h3>" + picture(r, self.found(r))
            if self.found(r):
                body += tests_table(self.found(r))
        body += "<h2>What passes beside it</h2>" + table(HEAD, [table_row(r) for r in passes])
        body += f"<h2>The smallest script that shows it</h2><pre>{escape(script)}</pre>"
        body += f'<h2>Draft of a report to the authors</h2><p class="soft">Not sent. To be read again, and run again on the newest version, before it is.</p><pre class="letter">{escape(fill(reflowed(f["draft"])))}</pre>'
        self.write(f"findings/{f['slug']}.html", page(f["title"], body, 1))
        return {"slug": f["slug"], "title": f["title"], "failed": len(failed), "of": len(rows), "fit": len([1 for _, one in fits if one["fits"]]),
                "tested": len(fits), "best": best, "rows": failed}

    def witness(self, name):
        rows = [r for r in self.rows if r["witness"] == name]
        if not rows:
            return
        title, told_of = findings.WITNESSES[name]
        version = next((r["version"] for r in rows if r.get("version")), "not installed")
        body = f"<p>{escape(version)}. {words(told_of)}</p>"
        notes = sorted({n for r in rows for n in r.get("notes") or []})
        if notes:
            body += "<p class=soft>Said on the way: " + escape("; ".join(notes[:8])) + "</p>"
        control = [r for r in rows if r["control"]]
        body += "<h2>Control</h2><p>An open rectangle off the middle. Nothing else is judged before it agrees.</p>" + table(HEAD, [table_row(r) for r in control])
        body += "<h2>Verdicts</h2>" + table(HEAD, [table_row(r) for r in rows if not r["control"]])
        told = [f for f in findings.FINDINGS if f["witness"] == name]
        if told:
            body += "<h2>Findings</h2><ul>" + "".join(f'<li><a href="../findings/{f["slug"]}.html">{words(f["title"])}</a></li>' for f in told) + "</ul>"
        drawn = [r for r in rows if r.get("data") is not None and not r["control"]]
        right = [r for r in drawn if kind(r["verdict"]) == "pass"]
        wrong = [r for r in drawn if kind(r["verdict"]) in ("fail", "floor")]
        if right:
            body += "<h2>What passes, drawn</h2>" + "".join(self.drawn(r) for r in telling(right, 3))
        if wrong:
            body += "<h2>What deviates, drawn</h2>" + "".join(self.drawn(r) for r in telling(wrong, 3))
        self.write(f"witnesses/{name}.html", page(f"{title}, judged", body, 1))

    def drawn(self, row):
        body = f"<h3>{escape(row['case'])}, {escape(row['label'])}: {verdict_cell(row)}</h3>" + picture(row, self.found(row))
        if row.get("errors"):
            body += scrolled(drawing.convergence([("worst place", [(n, w) for n, w, _ in row["errors"]]), ("mean", [(n, max(m, 1e-7)) for n, _, m in row["errors"]])],
                                                 f"{row['case']}, {row['label']}: errors against effort"))
        return body

    def tables(self):
        with open(os.path.join(self.out, "verdicts.csv"), "w", newline="") as file:
            write = csv.writer(file)
            write.writerow(["witness", "version", "case", "setting", "control", "verdict", "smallest_bias_mean", "smallest_bias_place", "mean_deviation",
                            "mean_std_error", "worst_deviation_of_peak", "worst_std_error_of_peak", "evidence_log10", "images_or_replicates", "samples", "pixels",
                            "seconds", "words"])
            for r in self.rows:
                write.writerow([r["witness"], r.get("version", ""), r["case"], r["label"], r["control"], r["verdict"], r.get("smallest_bias_mean"),
                                r.get("smallest_bias_place"), r.get("mean_dev"), r.get("mean_error"), r.get("worst_of_peak"), r.get("worst_error"),
                                r.get("evidence_log10"), r.get("count"), r["samples"], r["pixels"] if r["mode"] == "images" else "",
                                round(r.get("seconds") or 0, 1), spoken(r.get("words"))])
        with open(os.path.join(self.out, "predictions.csv"), "w", newline="") as file:
            write = csv.writer(file)
            write.writerow(["row", "hypothesis", "fits", "chi2_n", "dof", "worst_of_peak", "allowed_of_peak", "fitted"])
            for key, found in self.explained.items():
                for one in found:
                    write.writerow([key, one["name"], one["fits"], one.get("chi2_n"), one.get("dof"), one["worst_of_peak"], one.get("error_of_peak"), one["fitted"]])

    def other_seeds(self):
        """What came of running entries again."""
        said = []
        for words, first, second in self.again:
            first, second = ({(r["witness"], r["case"], r["label"]): r for r in q["rows"]} if q else {} for q in (first, second))
            asked = lambda k: k in second and "none" not in (kind(first[k]["verdict"]), kind(second[k]["verdict"]))
            both = [k for k in first if asked(k)]
            changed = [f"{' / '.join(k)}: {second[k]['verdict']}" for k in both if first[k]["verdict"] != second[k]["verdict"]]
            outcome = "every verdict was the same" if not changed else f"other verdicts: {'; '.join(changed)}"
            if both:
                said.append(f"{len(both)} entries of the {words} were made again with a second set of seeds: {escape(outcome)}.")
        return f"<p class=soft>{' '.join(said)}</p>" if said else ""

    def index(self, told):
        r = self.results
        names = [n for n in findings.WITNESSES if any(x["witness"] == n for x in self.rows)]
        counts = {k: len([x for x in self.rows if kind(x["verdict"]) == k]) for k in ("pass", "fail", "floor", "undecided", "none")}
        body = (f"<p>Does a renderer get a soft shadow right? Six released programs, and our own estimator, were asked for the irradiance of area "
                f"lights behind occluders and held against its exact value. {len(self.rows)} verdicts: {counts['pass']} passed, "
                f"{counts['fail'] + counts['floor']} deviate, {counts['undecided']} undecided; {counts['none']} could not be asked.</p>"
                f"{self.other_seeds()}"
                f"<p class=soft>{r['date']}, {escape(r['etendue'])}, {escape(r['machine'])}. Again: <code>tests/league/run.sh</code></p>")
        rows = []
        for n in names:
            mine = [x for x in self.rows if x["witness"] == n]
            count = lambda *kinds: len([x for x in mine if kind(x["verdict"]) in kinds])
            version = next((x["version"] for x in mine if x.get("version")), "not installed")
            control = next((x for x in mine if x["control"]), None)
            rows.append([f'<a href="witnesses/{n}.html">{escape(findings.WITNESSES[n][0])}</a>',
                         escape(version) + (", quick run only" if any(x.get("quick") for x in mine) else ""), verdict_cell(control) if control else "",
                         f'<span class=pass>{count("pass")}</span>', f'<span class=fail>{count("fail", "floor")}</span>', count("undecided"), count("none"),
                         minutes(sum(x.get("processor_seconds") or x.get("seconds") or 0 for x in mine))])
        body += "<h2>Who was asked</h2>" + table(["program", "version", "control", "pass", "deviates", "undecided", "cannot be asked", "processor time"], rows, (3, 4, 5, 6, 7))
        body += ('<p class=soft>Each verdict is a gate with a false-alarm probability of one in a million, and says what bias it would have seen (99 %). Deterministic '
                 "programs are judged by convergence: does the error go to nothing with effort, or settle at a floor? A pass says nothing of what was "
                 "not run, and a deviation nothing of settings other than those named.</p>")
        body += "<h2>What passes</h2><ul class=cards>"
        for n in names:
            mine = [x for x in self.rows if x["witness"] == n and kind(x["verdict"]) == "pass"]
            labels = {}
            for x in mine:
                labels.setdefault(x["label"], []).append(x["case"])
            said = "; ".join(f"<i>{escape(l)}</i>: {', '.join(c)}" for l, c in labels.items())
            body += f'<li><b>{escape(findings.WITNESSES[n][0])}</b>{said or "nothing in this run"}</li>'
        body += "</ul><h2>What deviates, and why</h2><ul class=cards>"
        for t in told:
            one, why = t["best"], "No prediction was found."
            if t["fit"]:
                number = f"χ²/n {digits(one['chi2_n'])}" if "chi2_n" in one else f"to {one['worst_of_peak']:.0e} of the brightest"
                why = f"Predicted by <i>{escape(one['name'].replace('_', ' '))}</i>: {t['fit']} of {t['tested']} rows fit ({number})."
            elif t["tested"]:
                why = "The prediction does not fit in this run."
            size = lambda k: max((abs(x.get(k) or 0) for x in t["rows"]), default=0)
            state = f"{t['failed']} of {t['of']} rows deviate" if t["of"] else "Not run"
            if t["rows"]:
                state += f": mean up to {100 * size('mean_dev'):.2g} %, worst place up to {100 * size('worst_of_peak'):.2g} % of the brightest"
            body += f'<li><a href="findings/{t["slug"]}.html"><b>{words(t["title"])}</b></a>{state}. {why if t["of"] else ""}</li>'
        body += "</ul><h2>All verdicts</h2>"
        for n in names:
            mine = [x for x in self.rows if x["witness"] == n]
            body += f"<h3>{escape(findings.WITNESSES[n][0])}</h3>" + table(HEAD, [table_row(x) for x in mine])
        body += "<h2>What was not tested</h2><ul>" + "".join(f"<li>{escape(x)}</li>" for x in findings.NOT_TESTED) + "</ul>"
        body += ('<h2>Tables</h2><p><a href="verdicts.csv">verdicts.csv</a>, <a href="predictions.csv">predictions.csv</a>. Cases: <code>tests/league/cases</code>; '
                 "how each program was asked: <code>tests/league/witnesses</code>, settings in <code>tests/league/plan.py</code>.</p>")
        self.write("index.html", page("The league: soft shadows against exact values", body))


def main():
    line = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    line.add_argument("--etendue", required=True)
    line.add_argument("--dir", required=True)
    line.add_argument("--out", required=True)
    given = line.parse_args()
    with open(os.path.join(given.dir, "results.json")) as file:
        results = json.load(file)
    def read(name):
        path = os.path.join(given.dir, name)
        if not os.path.exists(path):
            return None
        with open(path) as file:
            return json.load(file)

    # A witness that only the quick run has asked stands there with what that could see.
    quick = os.path.join(given.dir, "results-quick.json")
    if os.path.exists(quick):
        have = {r["witness"] for r in results["rows"]}
        with open(quick) as file:
            results["rows"] += [{**r, "quick": True} for r in json.load(file)["rows"] if r["witness"] not in have]
    planned = {(e["witness"], e["case"], e["label"]) for e in plan.ENTRIES}
    results["rows"] = [r for r in results["rows"] if (r["witness"], r["case"], r["label"]) in planned]
    explained = predictions.explained(results["rows"], given.etendue, os.path.join(given.dir, "work", "exact"))
    shutil.rmtree(given.out, ignore_errors=True)
    os.makedirs(given.out)
    again = [("whole run", results, read("results-2.json")), ("quick run", read("results-quick.json"), read("results-quick-2.json"))]
    report = Report(results, explained, given.out, again)
    told = [report.finding(f) for f in findings.FINDINGS]
    for name in findings.WITNESSES:
        report.witness(name)
    report.tables()
    report.index(told)
    print(f"{given.out}/index.html: {len(results['rows'])} verdicts, {len(told)} findings")


if __name__ == "__main__":
    main()
