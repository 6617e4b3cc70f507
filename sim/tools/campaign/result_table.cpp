#include "sim/tools/campaign/result_table.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <set>

#include "sim/host/text_format.hpp"

namespace ilp::batch {
namespace {

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

std::string exact(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof(text), value).ptr};
}

std::vector<std::string> all_axes(const std::vector<Job>& jobs) {
  std::vector<std::string> keys;
  for (const Job& job : jobs) {
    for (const auto& axis : job.axes) {
      if (std::find(keys.begin(), keys.end(), axis.first) == keys.end()) keys.push_back(axis.first);
    }
  }
  return keys;
}

/// The known ones in their order, then what else the scores have.
std::vector<std::string> all_numbers(const JobResults& results) {
  std::vector<std::string> names;
  for (const SummaryKey& key : summary_keys()) names.emplace_back(key.name);
  std::set<std::string> others;
  for (const auto& result : results) {
    if (!result) continue;
    for (const auto& entry : result->score.summary) {
      if (find_summary_key(entry.first) == nullptr) others.insert(entry.first);
    }
  }
  names.insert(names.end(), others.begin(), others.end());
  return names;
}

std::string markdown_cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, 1, '\\');
  return text;
}

}  // namespace

std::string table_csv(const std::vector<Job>& jobs, const JobResults& results) {
  const std::vector<std::string> axes = all_axes(jobs), numbers = all_numbers(results);
  std::string csv = "job,grid";
  for (const std::string& key : axes) csv += "," + csv_field(key);
  csv += ",result,complete";
  for (const std::string& name : numbers) csv += "," + csv_field(name);
  csv += ",failure\n";
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    csv += csv_field(jobs[i].name) + "," + jobs[i].grid;
    for (const std::string& key : axes) {
      const std::string* value = axis_value(jobs[i], key);
      csv += "," + (value == nullptr ? "" : csv_field(*value));
    }
    const auto& result = results[i];
    const bool scored = result && result->failure.empty();
    csv += !result ? ",not run," : scored ? (result->score.complete ? ",done,true" : ",done,false") : ",failed,";
    for (const std::string& name : numbers) {
      csv += ",";
      if (!scored) continue;
      const auto found = result->score.summary.find(name);
      if (found != result->score.summary.end() && found->second) csv += exact(*found->second);
    }
    csv += "," + (result ? csv_field(result->failure) : "") + "\n";
  }
  return csv;
}

std::vector<CellTable> cell_tables(const std::vector<Job>& jobs, const JobResults& results) {
  std::vector<CellTable> tables;
  std::map<std::pair<std::string, std::vector<std::pair<std::string, std::string>>>, std::size_t> places;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const auto cell = cell_of(jobs[i]);
    if (i == 0 || jobs[i].grid != jobs[i - 1].grid) {
      std::vector<std::string> axes;
      axes.reserve(cell.size());
      for (const auto& axis : cell) axes.push_back(axis.first);
      const bool shared = !tables.empty() && tables.back().axes == axes;
      if (shared) {
        tables.back().grids += ", " + jobs[i].grid;
      } else {
        tables.push_back({jobs[i].grid, std::move(axes), {}});
      }
    }
    std::vector<TableCell>& cells = tables.back().cells;
    const auto [place, fresh] = places.try_emplace({jobs[i].grid, cell}, cells.size());
    if (fresh) cells.emplace_back();
    cells[place->second].jobs.push_back(i);
    cells[place->second].scored += results[i] && results[i]->failure.empty();
  }
  return tables;
}

CellNumber cell_number(const TableCell& cell, const JobResults& results, const SummaryKey& key) {
  std::vector<double> values;
  for (const std::size_t job : cell.jobs) {
    if (!results[job] || !results[job]->failure.empty()) continue;
    const auto found = results[job]->score.summary.find(std::string(key.name));
    if (found != results[job]->score.summary.end() && found->second) values.push_back(*found->second);
  }
  double sum = 0;
  for (const double value : values) sum += value;
  const double mean =
      values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
  return {values.size(), mean, worst_of(key, values)};
}

std::string cell_text(const TableCell& cell, const JobResults& results, const SummaryKey& key) {
  const CellNumber number = cell_number(cell, results, key);
  std::string text = ground::brief(number.mean);
  if (number.count > 1 && key.better != Better::neither) text += " (" + ground::brief(number.worst) + ")";
  if (number.count > 0 && number.count < cell.scored) text += " of " + std::to_string(number.count);
  return text;
}

std::string flights_text(const TableCell& cell) {
  const std::string all = std::to_string(cell.jobs.size());
  return cell.scored == cell.jobs.size() ? all : std::to_string(cell.scored) + " of " + all;
}

std::string table_markdown(const Campaign& campaign, const std::vector<Job>& jobs, const JobResults& results) {
  std::string text = "# " + campaign.name + "\n";
  if (!campaign.about.empty()) text += "\n" + campaign.about + "\n";
  text += "\nMean over the seeds, and the worst in parentheses.\n";
  for (const CellTable& table : cell_tables(jobs, results)) {
    text += table.grids.empty() ? "\n" : "\n## " + table.grids + "\n\n";
    std::string rule = "|";
    text += "|";
    for (const std::string& axis : table.axes) {
      text += " " + axis + " |";
      rule += " --- |";
    }
    text += " flights |";
    rule += " ---: |";
    for (const std::string& column : campaign.columns) {
      text += " " + column + " |";
      rule += " ---: |";
    }
    text += "\n" + rule + "\n";
    for (const TableCell& cell : table.cells) {
      text += "|";
      for (const auto& axis : cell_of(jobs[cell.jobs.front()])) text += " " + markdown_cell(axis.second) + " |";
      text += " " + flights_text(cell) + " |";
      for (const std::string& column : campaign.columns) {
        text += " " + cell_text(cell, results, *find_summary_key(column)) + " |";
      }
      text += "\n";
    }
  }
  return text;
}

}  // namespace ilp::batch
