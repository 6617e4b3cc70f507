#include "sim/host/files.hpp"

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

namespace ilp::host {
namespace fs = std::filesystem;

std::vector<std::uint8_t> read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad()) throw std::runtime_error("cannot read " + path.string());
  return bytes;
}

void write_file(const fs::path& path, std::span<const std::uint8_t> bytes) {
  fs::path temporary = path;
  temporary += ".part";
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
      std::error_code ignored;
      fs::remove(temporary, ignored);
      throw std::runtime_error("cannot write " + path.string() + ": check the folder's permissions and free space");
    }
  }
  std::error_code error;
  fs::rename(temporary, path, error);
  if (error) throw std::runtime_error("cannot write " + path.string() + ": " + error.message());
}

void write_file(const fs::path& path, std::string_view text) {
  write_file(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

void make_output_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw std::runtime_error("cannot create the output folder " + folder.string() +
                             (error ? ": " + error.message() : std::string(": something else has this name")));
  }
  const fs::path probe = folder / ".ilp-ground-probe";
  const bool writable = std::ofstream(probe).good();
  fs::remove(probe, error);
  if (!writable) throw std::runtime_error("the output folder " + folder.string() + " is not writable");
}

}  // namespace ilp::host
