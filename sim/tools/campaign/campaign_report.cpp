#include "sim/tools/campaign/campaign_report.hpp"

#include <algorithm>

#include "sim/ground/report/report_style.hpp"
#include "sim/host/files.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/campaign/job_run.hpp"
#include "sim/tools/campaign/sweep_plot.hpp"

namespace ilp::batch {
namespace fs = std::filesystem;
namespace {

using ground::counted;
using ground::escaped;

constexpr std::size_t log_bytes = 3000, most_failures_shown = 40;

struct Counts {
  std::size_t scored = 0, failed = 0, not_run = 0, incomplete = 0;
};

Counts count(const JobResults& results) {
  Counts counts;
  for (const auto& result : results) {
    if (!result) {
      ++counts.not_run;
    } else if (!result->failure.empty()) {
      ++counts.failed;
    } else {
      ++counts.scored;
      counts.incomplete += result->score.complete ? 0 : 1;
    }
  }
  return counts;
}

std::string header_html(const Campaign& campaign, const JobResults& results) {
  const Counts counts = count(results);
  std::string html = "<header><p class=\"kicker\">Campaign</p><h1>" + escaped(campaign.name) + "</h1>";
  if (!campaign.about.empty()) html += "<p class=\"lede\">" + escaped(campaign.about) + "</p>";
  html += "<p class=\"sub\">" + counted(results.size(), "flight") + ": " + std::to_string(counts.scored) + " scored";
  if (counts.failed > 0) html += ", <span class=\"bad\">" + std::to_string(counts.failed) + " failed</span>";
  if (counts.not_run > 0) html += ", <span class=\"warn\">" + std::to_string(counts.not_run) + " not run</span>";
  if (counts.incomplete > 0) {
    html += ", <span class=\"warn\">" + std::to_string(counts.incomplete) + " with an incomplete score</span>";
  }
  return html + "</p></header>";
}

std::string grids_html(const Campaign& campaign) {
  std::string html =
      "<h2>What was flown</h2><div class=\"scroll\"><table><tr><th class=\"t\">grid</th>"
      "<th class=\"t\">parameter</th><th class=\"t\">values</th></tr>";
  const auto row = [&](const std::string& where, const std::string& key, const std::string& values) {
    html += "<tr><td class=\"t\">" + escaped(where) + "</td><td class=\"t\">" + escaped(key) +
            "</td><td class=\"t w\">" + escaped(values) + "</td></tr>";
  };
  for (const Grid& grid : campaign.grids) {
    for (const Axis& axis : grid.axes) {
      std::string values;
      for (const std::string& value : axis.values) values += (values.empty() ? "" : " | ") + value;
      row(grid.name, axis.key, values);
    }
  }
  for (const Setting& setting : campaign.settings) row("all", setting.key, setting.value);
  if (campaign.frames > 0) row("all", "frames", std::to_string(campaign.frames));
  return html + "</table></div>";
}

std::string table_html(const Campaign& campaign, const CellTable& table, const std::vector<Job>& jobs,
                       const JobResults& results) {
  std::string html = table.grids.empty() ? "" : "<h3>" + escaped(table.grids) + "</h3>";
  html += "<div class=\"scroll\"><table><tr>";
  for (const std::string& axis : table.axes) html += "<th class=\"t\">" + escaped(axis) + "</th>";
  html += "<th>flights</th>";
  for (const std::string& column : campaign.columns) {
    html += "<th title=\"" + escaped(find_summary_key(column)->label) + "\">" + escaped(column) + "</th>";
  }
  html += "</tr>";
  for (const TableCell& cell : table.cells) {
    html += "<tr>";
    for (const auto& axis : cell_of(jobs[cell.jobs.front()]))
      html += "<td class=\"t\">" + escaped(axis.second) + "</td>";
    html += (cell.scored == cell.jobs.size() ? "<td>" : "<td class=\"bad\">") + flights_text(cell) + "</td>";
    for (const std::string& column : campaign.columns) {
      html += "<td>" + escaped(cell_text(cell, results, *find_summary_key(column))) + "</td>";
    }
    html += "</tr>";
  }
  return html + "</table></div>";
}

std::string plots_html(const Campaign& campaign, const std::vector<Job>& jobs, const JobResults& results) {
  if (campaign.plots.empty()) return {};
  std::string html =
      "<h2>Plots</h2><p class=\"note\">A dot for each flight, the line through the means.</p><div "
      "class=\"plots\">";
  for (const PlotRequest& request : campaign.plots) {
    const SweepPlot plot = sweep_plot(request, jobs, results);
    html += "<figure>" + draw(plot);
    if (plot.without_number > 0) {
      html += "<figcaption>" + counted(plot.without_number, "flight") + " without these numbers</figcaption>";
    }
    html += "</figure>";
  }
  return html + "</div>";
}

/// Line by line: `escaped` makes spaces of control characters.
std::string log_html(const fs::path& file) {
  std::string html;
  std::string line;
  for (const char c : tail_of(file, log_bytes) + '\n') {
    if (c != '\n') {
      line += c == '\r' ? ' ' : c;
      continue;
    }
    html += escaped(line) + "\n";
    line.clear();
  }
  while (html.ends_with("\n\n")) html.pop_back();
  return "<pre>" + html + "</pre>";
}

std::string failures_html(const std::vector<Job>& jobs, const JobResults& results, const fs::path& out) {
  std::string html;
  std::size_t failures = 0;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (!results[i] || results[i]->failure.empty() || ++failures > most_failures_shown) continue;
    html += "<details" + std::string(failures <= 3 ? " open" : "") + "><summary><b>" + escaped(jobs[i].name) +
            "</b>: <span class=\"bad\">" + escaped(results[i]->failure) + "</span></summary>" +
            log_html(out / "jobs" / jobs[i].name / "log.txt") + "</details>";
  }
  if (failures == 0) return {};
  if (failures > most_failures_shown) {
    html += "<p class=\"note\">" + std::to_string(failures - most_failures_shown) + " more are in table.csv.</p>";
  }
  return "<h2>Failures</h2>" + html;
}

std::string remarks_html(const std::vector<Job>& jobs, const JobResults& results) {
  std::string html;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (!results[i]) continue;
    for (const std::string& remark : results[i]->score.remarks) {
      html +=
          "<tr><td class=\"t\">" + escaped(jobs[i].name) + "</td><td class=\"t w\">" + escaped(remark) + "</td></tr>";
    }
  }
  if (html.empty()) return {};
  return "<h2>Remarks of the scores</h2><details><summary>show</summary><div class=\"scroll\"><table>" + html +
         "</table></div></details>";
}

/// Fit for a file; plots of a campaign have different names, their files too.
std::string plot_file(const std::vector<PlotRequest>& plots, std::size_t index) {
  std::string name;
  for (const char c : plots[index].name) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain || c == '_') {
      name += c;
    } else if (!name.empty() && name.back() != '-') {
      name += '-';
    }
  }
  for (std::size_t i = 0; i < index; ++i) {
    if (plot_file(plots, i) == name) return name + "-" + std::to_string(index + 1);
  }
  return name.empty() ? "plot-" + std::to_string(index + 1) : name;
}

}  // namespace

std::string report_html(const Campaign& campaign, const std::vector<Job>& jobs, const JobResults& results,
                        const fs::path& out) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\"><title>" +
      escaped(campaign.name) + "</title><style>" + ground::report_style + sweep_style() +
      "pre{overflow-x:auto;font-size:12px;background:var(--plate);padding:10px;border-radius:8px}"
      ".plots figure svg{max-width:760px;border:1px solid var(--line);padding:10px;background:var(--card)}"
      "</style></head><body><main>";
  html += header_html(campaign, results);
  html +=
      "<h2>Results</h2><p class=\"note\">Mean over the seeds, and the worst in parentheses. Every flight by itself is "
      "in table.csv.</p>";
  for (const CellTable& table : cell_tables(jobs, results)) html += table_html(campaign, table, jobs, results);
  html += plots_html(campaign, jobs, results) + failures_html(jobs, results, out) + grids_html(campaign) +
          remarks_html(jobs, results);
  return html + "</main></body></html>\n";
}

void write_report(const Campaign& campaign, const std::vector<Job>& jobs, const JobResults& results,
                  const fs::path& out) {
  ground::write_file(out / "table.csv", table_csv(jobs, results));
  ground::write_file(out / "table.md", table_markdown(campaign, jobs, results));
  fs::remove_all(out / "plots");
  if (!campaign.plots.empty()) ground::make_output_folder(out / "plots");
  for (std::size_t i = 0; i < campaign.plots.size(); ++i) {
    ground::write_file(out / "plots" / (plot_file(campaign.plots, i) + ".svg"),
                       svg_file(sweep_plot(campaign.plots[i], jobs, results)));
  }
  ground::write_file(out / "report.html", report_html(campaign, jobs, results, out));
}

}  // namespace ilp::batch
