#include "sim/tools/campaign/campaign_file.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <set>
#include <string_view>

#include "sim/tools/campaign/ini_entries.hpp"
#include "sim/tools/campaign/summary_keys.hpp"

namespace ilp::batch {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t longest_range = 10000;

std::string trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

template <typename Number>
bool parse_number(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

bool is_word(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

bool is_parameter_key(std::string_view key) {
  const std::size_t dot = key.find('.');
  if (dot == std::string_view::npos) return key == "scenario" || key == "seed" || key == "frames";
  return is_word(key.substr(0, dot)) && is_word(key.substr(dot + 1));
}

class Reader {
 public:
  explicit Reader(const fs::path& file) { campaign_.file = file; }

  Campaign read() {
    for (const IniEntry& entry : read_ini(campaign_.file)) take(entry);
    check();
    return std::move(campaign_);
  }

 private:
  [[noreturn]] void refuse(const IniEntry& entry, const std::string& expected) const {
    refuse_line(campaign_.file, entry.line,
                "[" + entry.section + "] " + entry.key + " = " + entry.value + ": expected " + expected);
  }

  void take(const IniEntry& entry) {
    const std::string group = "group ", plot = "plot ";
    if (entry.section == "campaign") {
      take_campaign(entry);
    } else if (entry.section == "grid") {
      take_axis(entry, "");
    } else if (entry.section.rfind(group, 0) == 0 && is_word(trimmed(entry.section.substr(group.size())))) {
      take_axis(entry, trimmed(entry.section.substr(group.size())));
    } else if (entry.section == "set") {
      check_key(entry);
      check_value(entry, entry.value);
      campaign_.settings.push_back({entry.key, entry.value, entry.line});
    } else if (entry.section.rfind(plot, 0) == 0) {
      take_plot(entry, trimmed(entry.section.substr(plot.size())));
    } else {
      refuse_line(campaign_.file, entry.line,
                  "section [" + entry.section +
                      "]: expected campaign, grid, group NAME (small letters, digits, _, -), set or plot NAME");
    }
  }

  void take_campaign(const IniEntry& entry) {
    if (entry.key == "name") {
      if (entry.value.empty()) refuse(entry, "a name");
      campaign_.name = entry.value;
    } else if (entry.key == "about") {
      campaign_.about = entry.value;
    } else if (entry.key == "frames") {
      campaign_.frames = whole_number(entry, 1, 1000000);
    } else if (entry.key == "jobs") {
      campaign_.jobs = whole_number(entry, 1, 1024);
    } else if (entry.key == "timeout_s") {
      const bool right = parse_number(entry.value, campaign_.timeout_s);
      if (!right || !(campaign_.timeout_s > 0 && campaign_.timeout_s <= 1e6)) refuse(entry, "seconds, above 0 to 1e6");
    } else if (entry.key == "columns") {
      campaign_.columns = list_of(entry);
      for (const std::string& column : campaign_.columns) check_summary_key(entry, column);
    } else {
      refuse_line(campaign_.file, entry.line,
                  "[campaign] " + entry.key + ": expected name, about, frames, timeout_s, jobs or columns");
    }
  }

  [[nodiscard]] int whole_number(const IniEntry& entry, int lowest, int highest) const {
    int value = 0;
    if (!parse_number(entry.value, value) || value < lowest || value > highest) {
      refuse(entry, "a whole number from " + std::to_string(lowest) + " to " + std::to_string(highest));
    }
    return value;
  }

  /// What stands between the bars; none empty, none twice.
  [[nodiscard]] std::vector<std::string> list_of(const IniEntry& entry) const {
    std::vector<std::string> list;
    std::set<std::string> seen;
    std::string_view rest = entry.value;
    for (bool more = true; more;) {
      const std::size_t bar = rest.find('|');
      const std::string item = trimmed(rest.substr(0, bar));
      if (item.empty()) refuse(entry, "values separated by |, none of them empty");
      for (std::string& value : expanded(entry, item)) {
        if (!seen.insert(value).second) refuse(entry, "each value once, not " + value + " twice");
        list.push_back(std::move(value));
      }
      more = bar != std::string_view::npos;
      if (more) rest.remove_prefix(bar + 1);
    }
    return list;
  }

  /// 1..3 is 1, 2, 3; anything else is itself.
  [[nodiscard]] std::vector<std::string> expanded(const IniEntry& entry, const std::string& item) const {
    const std::size_t dots = item.find("..");
    std::uint64_t first = 0, last = 0;
    const bool range = dots != std::string::npos && parse_number(std::string_view(item).substr(0, dots), first) &&
                       parse_number(std::string_view(item).substr(dots + 2), last);
    if (!range) return {item};
    if (last < first || last - first >= longest_range) {
      refuse(entry, "a range that rises, of at most " + std::to_string(longest_range) + " values");
    }
    std::vector<std::string> values;
    for (std::uint64_t i = 0; i <= last - first; ++i) values.push_back(std::to_string(first + i));
    return values;
  }

  void check_key(const IniEntry& entry) const {
    if (!is_parameter_key(entry.key)) {
      refuse_line(campaign_.file, entry.line,
                  "[" + entry.section + "] " + entry.key + ": expected scenario, seed, frames or section.name");
    }
  }

  void check_value(const IniEntry& entry, const std::string& value) const {
    if (value.empty()) refuse(entry, "a value");
    std::uint64_t number = 0;
    if (entry.key == "seed" && !parse_number(value, number)) refuse(entry, "whole numbers");
    int frames = 0;
    if (entry.key == "frames" && (!parse_number(value, frames) || frames < 1)) refuse(entry, "whole numbers from 1 on");
    if (entry.key == "scenario" && is_scenario_file(value)) {
      const fs::path path = campaign_.file.parent_path() / value;
      if (!fs::is_regular_file(path)) refuse(entry, "a preset's name or a file, and there is no " + path.string());
    }
  }

  void take_axis(const IniEntry& entry, const std::string& grid) {
    check_key(entry);
    Axis axis{entry.key, list_of(entry), entry.line};
    for (const std::string& value : axis.values) check_value(entry, value);
    const auto found = std::find_if(campaign_.grids.begin(), campaign_.grids.end(),
                                    [&](const Grid& other) { return other.name == grid; });
    if (found != campaign_.grids.end()) {
      found->axes.push_back(std::move(axis));
    } else {
      campaign_.grids.push_back({grid, {std::move(axis)}});
    }
  }

  void take_plot(const IniEntry& entry, const std::string& name) {
    if (name.empty()) refuse_line(campaign_.file, entry.line, "[plot]: expected a name: [plot NAME]");
    auto found = std::find_if(campaign_.plots.begin(), campaign_.plots.end(),
                              [&](const PlotRequest& other) { return other.name == name; });
    if (found == campaign_.plots.end()) {
      PlotRequest fresh;
      fresh.name = name;
      fresh.line = entry.line;
      found = campaign_.plots.insert(found, std::move(fresh));
    }
    PlotRequest& plot = *found;
    if (entry.key == "x") {
      plot.x = entry.value;
    } else if (entry.key == "y") {
      check_summary_key(entry, entry.value);
      plot.y = entry.value;
    } else if (entry.key == "series") {
      plot.series = list_of(entry);
    } else if (entry.key == "log_x" || entry.key == "log_y") {
      if (entry.value != "true" && entry.value != "false") refuse(entry, "true or false");
      (entry.key == "log_x" ? plot.log_x : plot.log_y) = entry.value == "true";
    } else {
      refuse_line(campaign_.file, entry.line,
                  "[" + entry.section + "] " + entry.key + ": expected x, y, series, log_x or log_y");
    }
  }

  void check_summary_key(const IniEntry& entry, const std::string& key) const {
    if (find_summary_key(key) == nullptr) refuse(entry, "a key of the score's summary: " + summary_key_list());
  }

  [[nodiscard]] bool is_axis(const std::string& key) const {
    return std::any_of(campaign_.grids.begin(), campaign_.grids.end(), [&](const Grid& grid) {
      return std::any_of(grid.axes.begin(), grid.axes.end(), [&](const Axis& axis) { return axis.key == key; });
    });
  }

  void check() {
    if (campaign_.grids.empty()) {
      throw std::runtime_error(campaign_.file.string() + ": no flights: expected a section [grid] or [group NAME]");
    }
    for (const PlotRequest& plot : campaign_.plots) {
      const std::string where = "[plot " + plot.name + "] ";
      if (plot.x.empty() || plot.y.empty()) refuse_line(campaign_.file, plot.line, where + "expected both x and y");
      if (!is_axis(plot.x) && find_summary_key(plot.x) == nullptr) {
        refuse_line(campaign_.file, plot.line,
                    where + "x = " + plot.x + ": expected an axis of a grid or a key of the score's summary");
      }
      const auto stranger = std::find_if_not(plot.series.begin(), plot.series.end(),
                                             [&](const std::string& key) { return is_axis(key); });
      if (stranger != plot.series.end()) {
        refuse_line(campaign_.file, plot.line, where + "series = " + *stranger + ": expected axes of a grid");
      }
    }
    if (campaign_.name.empty()) campaign_.name = campaign_.file.stem().string();
    if (campaign_.columns.empty()) {
      campaign_.columns = {"posed_share",       "position_mean_percent", "position_max_percent",
                           "rotation_mean_deg", "height_median_percent", "completeness"};
    }
  }

  Campaign campaign_;
};

}  // namespace

bool is_scenario_file(const std::string& scenario) {
  return scenario.find('/') != std::string::npos || fs::path(scenario).extension() == ".ini";
}

Campaign read_campaign(const fs::path& file) {
  return Reader(file).read();
}

}  // namespace ilp::batch
