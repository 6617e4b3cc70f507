// The entries of an INI file with their lines, read by libinih.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace ilp::batch {

struct IniEntry {
  std::string section, key, value;
  int line = 0;
};

/// An indented line continues the value before it, joined by a space. std::runtime_error names the file and the line of
/// what is no section, entry or comment, of a key that stands twice in a section, and of what is longer than the parser
/// takes.
[[nodiscard]] std::vector<IniEntry> read_ini(const std::filesystem::path& file);

/// std::runtime_error "FILE:LINE: message".
[[noreturn]] void refuse_line(const std::filesystem::path& file, int line, const std::string& message);

}  // namespace ilp::batch
