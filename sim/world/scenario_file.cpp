#include "sim/world/scenario_file.hpp"

#include <ini.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace ilp::world {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t longest_line = 190;  // the parser cuts at 200
constexpr std::size_t longest_name = 49;   // the parser cuts section and name here

struct Reading {
  std::ifstream in;
  std::string file;
  int line = 0;
  std::string fault;
  std::vector<ScenarioEntry> entries;
};

std::string place(const Reading& reading, int line) {
  return reading.file + ", line " + std::to_string(line);
}

/// The parser's fgets: counts the lines, which the parser does not hand on.
char* next_line(char* buffer, int size, void* stream) {
  auto& reading = *static_cast<Reading*>(stream);
  std::string text;
  if (!reading.fault.empty() || !std::getline(reading.in, text)) return nullptr;
  ++reading.line;
  if (text.size() > longest_line || text.size() + 2 > static_cast<std::size_t>(size)) {
    reading.fault = place(reading, reading.line) + ": expected at most " + std::to_string(longest_line) + " characters";
    return nullptr;
  }
  if (text.find('\0') != std::string::npos) {
    reading.fault = place(reading, reading.line) + ": expected text";
    return nullptr;
  }
  // An indented line would continue the value before it.
  text.erase(0, text.find_first_not_of(" \t"));
  text += '\n';
  std::memcpy(buffer, text.c_str(), text.size() + 1);
  return buffer;
}

int take_entry(void* user, const char* section, const char* name, const char* value) {
  auto& reading = *static_cast<Reading*>(user);
  if (!reading.fault.empty()) return 1;
  const std::string full = "[" + std::string(section) + "] " + name;
  for (const ScenarioEntry& entry : reading.entries) {
    if (entry.section == section && entry.name == name)
      reading.fault = place(reading, reading.line) + ": " + full + " is given a second time, expected once";
  }
  if (std::strlen(section) >= longest_name || std::strlen(name) >= longest_name)
    reading.fault = place(reading, reading.line) + ": " + full + "...: there is no name as long as this";
  reading.entries.push_back({section, name, value, place(reading, reading.line)});
  return 1;
}

}  // namespace

ScenarioEntry parse_override(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::size_t dot = text.find('.');
  if (equals == std::string::npos || dot == std::string::npos || dot == 0 || dot + 1 >= equals) {
    throw std::invalid_argument("--set " + text + ": expected section.name=value, such as flight.altitude_m=120");
  }
  return {text.substr(0, dot), text.substr(dot + 1, equals - dot - 1), text.substr(equals + 1), "--set"};
}

std::vector<ScenarioEntry> read_scenario_file(const fs::path& path) {
  Reading reading;
  reading.file = path.string();
  std::error_code ignored;
  if (fs::is_regular_file(path, ignored)) reading.in.open(path, std::ios::binary);
  if (!reading.in.is_open()) throw std::invalid_argument("scenario file " + path.string() + " cannot be read");
  const int result = ini_parse_stream(next_line, &reading, take_entry, &reading);
  if (result > 0 && (reading.fault.empty() || result < reading.line))
    throw std::invalid_argument(place(reading, result) + ": expected [section], name = value or a ; comment");
  if (!reading.fault.empty()) throw std::invalid_argument(reading.fault);
  return std::move(reading.entries);
}

bool can_stand_in_a_file(const std::string& value) {
  constexpr std::size_t longest_value = longest_line - longest_name - 3;
  const bool trimmed =
      value.empty() || (std::strchr(" \t", value.front()) == nullptr && std::strchr(" \t", value.back()) == nullptr);
  const bool comment = value.find(" ;") != std::string::npos || value.find("\t;") != std::string::npos ||
                       (!value.empty() && value.front() == ';');
  return trimmed && !comment && value.size() <= longest_value && value.find_first_of("\r\n") == std::string::npos;
}

}  // namespace ilp::world
