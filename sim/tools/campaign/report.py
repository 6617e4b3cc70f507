"""What a campaign leaves for its reader: table.csv, table.md, plots/*.svg and report.html, which needs no other file."""

import os
import re
from html import escape

from flights import bytes_of, counted, remove_folder, tail_of, write_file
from metrics import METRICS, SIM
from plots import STYLE, draw, svg_file, sweep_plot
from tables import cell_tables, how_to_read, scored, table_csv, table_markdown

LOG_BYTES, MOST_FAILURES_SHOWN = 3000, 40
PAGE_STYLE = ("pre{overflow-x:auto;font-size:12px;background:var(--plate);padding:10px;border-radius:8px}"
              ".plots figure svg{max-width:760px;border:1px solid var(--line);padding:10px;background:var(--card)}")


def report_style():
    """The style sheets of the ground's report."""
    folder = os.path.join(SIM, "ground", "report", "page")
    sheets = sorted(name for name in os.listdir(folder) if name.endswith(".css"))
    return "".join(bytes_of(os.path.join(folder, name)).decode("utf-8") for name in sheets)


def plain(text):
    return escape(re.sub(r"[\x00-\x1f\x7f]", " ", text))


def cell(text, style="t", mark="td"):
    return f"<{mark}{f' class={chr(34)}{style}{chr(34)}' if style else ''}>{plain(text)}</{mark}>"


def header_html(campaign, results):
    failed = sum(result is not None and bool(result.failure) for result in results)
    not_run = sum(result is None for result in results)
    incomplete = sum(scored(result) and not result.complete for result in results)
    counts = f"{counted(len(results), 'flight')}: {len(results) - failed - not_run} scored"
    for count, style, what in ((failed, "bad", "failed"), (not_run, "warn", "not run"),
                               (incomplete, "warn", "with an incomplete score")):
        counts += f', <span class="{style}">{count} {what}</span>' if count else ""
    about = f'<p class="lede">{plain(campaign.about)}</p>' if campaign.about else ""
    return (f'<header><p class="kicker">Campaign</p><h1>{plain(campaign.name)}</h1>{about}'
            f'<p class="sub">{counts}</p></header>')


def table_html(rows):
    return '<div class="scroll"><table>' + "".join(f"<tr>{row}</tr>" for row in rows) + "</table></div>"


def results_html(campaign, jobs, results):
    html = f'<h2>Results</h2><p class="note">{plain(how_to_read(campaign))} Every flight by itself is in table.csv.</p>'
    for table in cell_tables(jobs, results, campaign.compare):
        rows = ["".join(cell(axis, mark="th") for axis in table.axes) + "<th>flights</th>" +
                "".join(f'<th title="{plain(METRICS[c].label)}">{plain(c)}</th>' for c in campaign.columns)]
        for c in table.cells:
            whole = c.scored() == len(c.results)
            rows.append("".join(map(cell, c.axes.values())) + cell(c.flights(), "" if whole else "bad") +
                        "".join(cell(c.text(column), "") for column in campaign.columns))
        grids = ", ".join(table.grids)
        html += (f"<h3>{plain(grids)}</h3>" if grids else "") + table_html(rows)
    return html


def plots_html(campaign, jobs, results):
    if not campaign.plots:
        return ""
    html = '<h2>Plots</h2><p class="note">A dot for each flight, the line through the means.</p><div class="plots">'
    for request in campaign.plots.values():
        plot = sweep_plot(request, jobs, results)
        caption = f"{counted(plot.without_number, 'flight')} without these numbers"
        html += f"<figure>{draw(plot)}" + (f"<figcaption>{caption}</figcaption>" if plot.without_number else "") + "</figure>"
    return html + "</div>"


def failures_html(jobs, results, out):
    failures = [(job, result) for job, result in zip(jobs, results) if result and result.failure]
    html = "<h2>Failures</h2>" if failures else ""
    for number, (job, result) in enumerate(failures[:MOST_FAILURES_SHOWN]):
        log = tail_of(os.path.join(out, "jobs", job.name, "log.txt"), LOG_BYTES)
        lines = "\n".join(map(plain, log.rstrip("\n").split("\n")))
        html += (f"<details{' open' if number < 3 else ''}><summary><b>{plain(job.name)}</b>: "
                 f'<span class="bad">{plain(result.failure)}</span></summary><pre>{lines}\n</pre></details>')
    more = len(failures) - MOST_FAILURES_SHOWN
    return html + (f'<p class="note">{more} more are in table.csv.</p>' if more > 0 else "")


def grids_html(campaign):
    flown = [(name, key, " | ".join(values)) for name, grid in campaign.grids.items() for key, (values, _) in grid.items()]
    flown += [("all", key, value) for key, value in campaign.settings.items()]
    flown += [("all", "frames", str(campaign.frames))] if campaign.frames else []
    rows = ["".join(cell(name, mark="th") for name in ("grid", "parameter", "values"))]
    rows += [cell(where) + cell(key) + cell(values, "t w") for where, key, values in flown]
    return "<h2>What was flown</h2>" + table_html(rows)


def remarks_html(jobs, results):
    rows = [cell(job.name) + cell(remark, "t w") for job, result in zip(jobs, results) if result for remark in result.remarks]
    if not rows:
        return ""
    return f"<h2>Remarks of the scores</h2><details><summary>show</summary>{table_html(rows)}</details>"


def report_html(campaign, jobs, results, out):
    return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
            f'content="width=device-width,initial-scale=1"><title>{plain(campaign.name)}</title><style>{report_style()}'
            f"{STYLE}{PAGE_STYLE}</style></head><body><main>" + header_html(campaign, results) +
            results_html(campaign, jobs, results) + plots_html(campaign, jobs, results) +
            failures_html(jobs, results, out) + grids_html(campaign) + remarks_html(jobs, results) +
            "</main></body></html>\n")


def plot_files(campaign):
    """Names fit for files; plots of a campaign have different names, their files too."""
    names = []
    for number, plot in enumerate(campaign.plots, 1):
        name = re.sub(r"[^A-Za-z0-9_]+", "-", plot).lstrip("-") or f"plot-{number}"
        names.append(f"{name}-{number}" if name in names else name)
    return names


def write_report(campaign, jobs, results, out):
    write_file(os.path.join(out, "table.csv"), table_csv(jobs, results))
    write_file(os.path.join(out, "table.md"), table_markdown(campaign, jobs, results))
    folder = os.path.join(out, "plots")
    remove_folder(folder)
    if campaign.plots:
        os.mkdir(folder)
    for name, request in zip(plot_files(campaign), campaign.plots.values()):
        write_file(os.path.join(folder, name + ".svg"), svg_file(sweep_plot(request, jobs, results)))
    write_file(os.path.join(out, "report.html"), report_html(campaign, jobs, results, out))
