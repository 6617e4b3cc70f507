#include "sim/ground/run_record.hpp"

#include <gdal.h>

#include <algorithm>
#include <ostream>
#include <sstream>
#include <system_error>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/host/digest.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

constexpr const char* file_name = "results.txt";
constexpr const char* first_line = "What ilp-ground has left here, for its next run; version 1";

std::string text_of(const host::FileState& state) {
  return std::to_string(state.bytes) + " " + std::to_string(state.modified_ns) + " " + std::to_string(state.changed_ns);
}

/// Names and states of the files of a folder, or of one file.
std::string tree_text(const fs::path& path) {
  if (path.empty()) return "none\n";
  std::string text = fs::absolute(path).lexically_normal().string() + "\n";
  if (const auto state = host::state_of(path)) return text + text_of(*state) + "\n";
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::recursive_directory_iterator it(path, error), end; !error && it != end; it.increment(error)) {
    files.push_back(it->path());
  }
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) {
    if (const auto state = host::state_of(file)) text += file.string() + " " + text_of(*state) + "\n";
  }
  return text;
}

std::string database_text(const fs::path& database) {
  return database.empty() ? tree_text(database) : tree_text(database) + tree_text(database.string() + "-wal");
}

/// The rest of the line.
std::string rest_of(std::istream& line) {
  std::string rest;
  std::getline(line >> std::ws, rest);
  return rest;
}

void read_line(const std::string& text, RunRecord& record) {
  std::istringstream line(text);
  std::string word;
  line >> word;
  if (word == "inputs") line >> record.inputs;
  if (word == "outbox") record.outbox = rest_of(line);
  if (word == "said") record.said.push_back(rest_of(line));
  if (word == "file") {
    ResultFile file;
    line >> file.content >> file.state.bytes >> file.state.modified_ns >> file.state.changed_ns;
    record.files[rest_of(line)] = file;
  }
  if (word == "acknowledged") {
    std::string bytes, crc;
    line >> bytes >> crc;
    record.acknowledgements[rest_of(line)] = bytes + " " + crc + "\n";
  }
}

std::string text_of(const RunRecord& record) {
  std::string text = std::string(first_line) + "\ninputs " + std::to_string(record.inputs) + "\n";
  if (!record.outbox.empty()) text += "outbox " + record.outbox + "\n";
  for (const std::string& line : record.said) text += "said " + line + "\n";
  for (const auto& [name, file] : record.files) {
    text += "file " + std::to_string(file.content) + " " + text_of(file.state) + " " + name + "\n";
  }
  for (const auto& [name, content] : record.acknowledgements) {
    text += "acknowledged " + content.substr(0, content.size() - 1) + " " + name + "\n";
  }
  return text;
}

/// Whether the file is as recorded, whose times are corrected where they alone have changed.
bool is_valid(const fs::path& path, bool thoroughly, ResultFile& file, bool& corrected) {
  const auto state = host::state_of(path);
  if (!state) return false;
  const bool same = *state == file.state;
  if (same && !thoroughly) return true;
  if (file.content == 0) return same;
  if (state->bytes != file.state.bytes || host::content_digest(path) != file.content) return false;
  corrected = corrected || !same;
  file.state = *state;
  return true;
}

}  // namespace

std::uint64_t digest_of_inputs(const GroundOptions& options) {
  static const std::uint64_t program = host::content_digest("/proc/self/exe").value_or(0);
  std::ostringstream text;
  text.precision(17);
  text << program << " " << GDALVersionInfo("RELEASE_NAME") << "\n"
       << options.title << "\n"
       << options.mission << "\n"
       << options.catalogue << "\n"
       << options.target_overlap << " " << options.max_vertices << "\n"
       << options.acknowledge.string() << "\n"
       << options.landing << " " << options.keep_copies << " " << options.lay_holes << "\n"
       << options.control_body << "\n"
       << options.control_crs << "\n"
       << options.geoid << " " << options.control_original << "\n"
       << database_text(options.flight_db);
  for (const fs::path& path : {options.outbox, options.truth, options.reference, options.flight_info, options.anchor,
                               options.control, options.map, options.images, options.score, options.colour}) {
    text << tree_text(path);
  }
  return host::digest(text.str());
}

std::string name_of_outbox(const fs::path& outbox) {
  std::error_code error;
  return fs::weakly_canonical(fs::absolute(outbox), error).string();
}

RunRecord read_record(const fs::path& out) {
  if (!host::state_of(out / file_name)) return {};
  const std::vector<std::uint8_t> bytes = host::read_file(out / file_name);
  std::string text(bytes.begin(), bytes.end());
  const std::size_t last = text.rfind("end ");
  if (last == std::string::npos || !text.starts_with(first_line)) return {};
  if (text.substr(last) != "end " + host::digest_text(host::digest(text.substr(0, last))) + "\n") return {};
  RunRecord record;
  std::istringstream lines(text.substr(0, last));
  for (std::string line; std::getline(lines, line);) read_line(line, record);
  return record;
}

void write_record(const RunRecord& record, const fs::path& out) {
  const std::string text = text_of(record);
  host::update_file(out / file_name, text + "end " + host::digest_text(host::digest(text)) + "\n");
}

void forget_record(const fs::path& out) {
  fs::remove(out / file_name);
}

RunRecord record_of(const fs::path& out, const std::vector<std::string>& files, const RunRecord& before) {
  RunRecord record;
  for (const std::string& name : files) {
    const auto state = host::state_of(out / name);
    if (!state) continue;
    const auto known = before.files.find(name);
    const bool same = known != before.files.end() && known->second.state == *state;
    const bool checks_itself = name == intake::catalogue_name;
    record.files[name] = {*state, same            ? known->second.content
                                  : checks_itself ? 0
                                                  : host::content_digest(out / name).value_or(0)};
  }
  return record;
}

bool keep_valid_files(const fs::path& out, bool thoroughly, RunRecord& record, std::ostream& messages) {
  bool all_valid = true, corrected = false;
  for (auto it = record.files.begin(); it != record.files.end();) {
    if (is_valid(out / it->first, thoroughly, it->second, corrected)) {
      ++it;
      continue;
    }
    all_valid = false;
    if (it->second.content != 0) {
      messages << it->first << " is missing or was changed: it is made again\n";
      std::error_code ignored;
      fs::remove(out / it->first, ignored);
    }
    it = record.files.erase(it);
  }
  if (all_valid && corrected) write_record(record, out);
  return all_valid;
}

}  // namespace ilp::ground
