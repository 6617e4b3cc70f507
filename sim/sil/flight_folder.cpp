#include "sim/sil/flight_folder.hpp"

#include <fstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

namespace ilp::sil {
namespace fs = std::filesystem;
namespace {

/// Is in the folder from the beginning of a start until the flight has begun, and in the folder of images that are
/// rendered alone until they are complete.
constexpr const char* marker = ".start-not-finished";

/// What a start makes, beside the marker: the database with its companions, and these.
bool is_of_a_start(const std::string& name) {
  return name == "outbox" || name == "acknowledged" || name == "flight" || name == "images" || name == "frames.txt" ||
         name == "exif-positions.csv" || name == "navigation.csv" || name.starts_with("flight.db");
}

bool never_flew(const fs::path& out) {
  std::error_code error;
  return fs::exists(out / marker, error);
}

void remove_unfinished_start(const fs::path& out) {
  std::error_code error;
  std::vector<fs::path> made;
  for (const auto& entry : fs::directory_iterator(out, error)) {
    if (is_of_a_start(entry.path().filename().string())) made.push_back(entry.path());
  }
  for (const fs::path& path : made) fs::remove_all(path, error);
  // Last, so that an interruption here changes nothing.
  fs::remove(out / marker, error);
}

void remove_unfinished(const fs::path& out) {
  std::error_code error;
  if (never_flew(out)) remove_unfinished_start(out);
  if (never_flew(out / "flight")) fs::remove_all(out / "flight", error);
}

void mark(const fs::path& out) {
  if (!(std::ofstream(out / marker) << "The flight in this folder has not begun yet.\n").flush()) {
    throw std::runtime_error("cannot write into " + out.string() +
                             ": check its permissions and the space on its disk, or name another --out");
  }
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    throw std::runtime_error("cannot create " + folder.string() + ": " + error.message() + "; name another --out");
  }
}

}  // namespace

void prepare_folder(const fs::path& out, bool resume) {
  std::error_code error;
  const bool holds_flight = fs::exists(out / "flight.db", error);
  if (resume) {
    if (never_flew(out)) {
      throw std::runtime_error("--resume: the flight in " + out.string() +
                               " was interrupted before it began: give the same command without --resume");
    }
    if (!holds_flight) {
      throw std::runtime_error("--resume: there is no flight.db in " + out.string() +
                               ": name the folder of the flight, or begin a new one without --resume");
    }
    return;
  }
  if (fs::exists(out, error) && !fs::is_directory(out, error))
    throw std::runtime_error(out.string() + " is not a folder: name another --out");
  remove_unfinished(out);
  if (fs::is_directory(out, error) && !fs::is_empty(out, error)) {
    throw std::runtime_error("the folder " + out.string() +
                             " is not empty: name a new one, so that no earlier flight is lost" +
                             (holds_flight ? ", or --resume the flight in it" : ""));
  }
  make_folder(out);
  mark(out);
  for (const char* folder : {"outbox", "acknowledged"}) make_folder(out / folder);
}

void prepare_render_folder(const fs::path& out) {
  std::error_code error;
  remove_unfinished(out);
  const fs::path folder = out / "flight";
  if (fs::exists(folder, error) && !fs::is_empty(folder, error))
    throw std::runtime_error(folder.string() + " is not empty: name a new --out, so that no earlier flight is lost");
  make_folder(folder);
  mark(folder);
}

void images_are_complete(const fs::path& out) {
  std::error_code error;
  fs::remove(out / "flight" / marker, error);
}

void flight_has_begun(const fs::path& out) {
  std::error_code error;
  fs::remove(out / marker, error);
}

}  // namespace ilp::sil
