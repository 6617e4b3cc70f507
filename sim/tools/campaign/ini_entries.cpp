#include "sim/tools/campaign/ini_entries.hpp"

#include <ini.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "sim/host/files.hpp"

namespace ilp::batch {
namespace {

// What libinih keeps of a section or key; it cuts longer ones silently.
constexpr std::size_t longest_name = 49;

struct Reading {
  std::string_view rest;
  int line = 0;
  bool indented = false;
  std::string fault;  ///< of the current line, where reading stops
  std::vector<IniEntry> entries;
};

std::string fault_of(std::string_view line, std::size_t room) {
  if (line.size() + 2 > room) return "the line is longer than " + std::to_string(room - 2) + " characters";
  if (line.find('\0') != std::string_view::npos) return "not a text file";
  const std::size_t first = line.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  line.remove_prefix(first);
  const std::size_t end = line[0] == '[' ? line.find(']') : line.find_first_of("=:");
  const std::size_t length = end == std::string_view::npos ? 0 : end - (line[0] == '[' ? 1 : 0);
  const bool comment = line[0] == ';' || line[0] == '#';
  if (!comment && length > longest_name) return "a name is longer than " + std::to_string(longest_name) + " characters";
  return {};
}

char* next_line(char* buffer, int room, void* stream) {
  auto& reading = *static_cast<Reading*>(stream);
  if (reading.rest.empty() || !reading.fault.empty()) return nullptr;
  const std::size_t end = reading.rest.find('\n');
  const std::string_view line = reading.rest.substr(0, end);
  reading.rest.remove_prefix(end == std::string_view::npos ? reading.rest.size() : end + 1);
  ++reading.line;
  reading.indented = !line.empty() && std::isspace(static_cast<unsigned char>(line[0])) != 0;
  reading.fault = fault_of(line, static_cast<std::size_t>(room));
  if (!reading.fault.empty()) return nullptr;
  std::memcpy(buffer, line.data(), line.size());
  buffer[line.size()] = '\n';
  buffer[line.size() + 1] = 0;
  return buffer;
}

int take_entry(void* user, const char* section, const char* key, const char* value) {
  auto& reading = *static_cast<Reading*>(user);
  if (!reading.fault.empty()) return 1;
  std::vector<IniEntry>& entries = reading.entries;
  if (reading.indented && !entries.empty() && entries.back().section == section && entries.back().key == key) {
    entries.back().value += std::string(" ") + value;
    return 1;
  }
  const auto twin = std::find_if(entries.begin(), entries.end(),
                                 [&](const IniEntry& e) { return e.section == section && e.key == key; });
  if (twin != entries.end()) {
    reading.fault =
        "[" + std::string(section) + "] " + key + " stands in line " + std::to_string(twin->line) + " already";
    return 1;
  }
  entries.push_back({section, key, value, reading.line});
  return 1;
}

}  // namespace

void refuse_line(const std::filesystem::path& file, int line, const std::string& message) {
  throw std::runtime_error(file.string() + ":" + std::to_string(line) + ": " + message);
}

std::vector<IniEntry> read_ini(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) throw std::runtime_error(file.string() + " is a folder, not a file");
  const std::vector<std::uint8_t> bytes = ground::read_file(file);
  Reading reading;
  reading.rest = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  const int result = ini_parse_stream(next_line, &reading, take_entry, &reading);
  // The parser goes on after its first error, ours stops: the earlier of the two is the one to name.
  if (result > 0 && (reading.fault.empty() || result < reading.line)) {
    refuse_line(file, result, "neither a [section] nor key = value nor a comment");
  }
  if (!reading.fault.empty()) refuse_line(file, reading.line, reading.fault);
  if (result < 0) throw std::runtime_error("cannot read " + file.string());
  return std::move(reading.entries);
}

}  // namespace ilp::batch
