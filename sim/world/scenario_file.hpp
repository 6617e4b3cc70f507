// Scenario files as text: [section], name = value, and where each entry stands.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::world {

/// One line of a scenario file, or one --set.
struct ScenarioEntry {
  std::string section, name, value;
  std::string origin;  ///< file and line, for messages
};

/// "section.name=value". std::invalid_argument when it is not of this form.
[[nodiscard]] ScenarioEntry parse_override(const std::string& text);

/// An .ini file; ';' and '#' begin comments. std::invalid_argument names the file, and the line of what is no section
/// and no entry, of an entry given twice and of a line that is too long.
[[nodiscard]] std::vector<ScenarioEntry> read_scenario_file(const std::filesystem::path& path);

/// Whether an entry with this value is read as it was written.
[[nodiscard]] bool can_stand_in_a_file(const std::string& value);

}  // namespace ilp::world
