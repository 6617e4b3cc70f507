#include "tests/faults/cut_disk.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t sector_bytes = 512;

std::uint64_t inode_of(const fs::path& path) {
  struct stat state {};
  return stat(path.c_str(), &state) == 0 ? state.st_ino : 0;
}

std::vector<std::uint8_t> read_whole(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::size_t sectors_of(std::size_t bytes) {
  return (bytes + sector_bytes - 1) / sector_bytes;
}

/// Copies one sector, as far as `from` reaches; what is behind it stays.
void copy_sector(const std::vector<std::uint8_t>& from, std::size_t sector, std::vector<std::uint8_t>& to) {
  const std::size_t begin = sector * sector_bytes;
  if (begin >= from.size()) return;
  const std::size_t end = std::min(begin + sector_bytes, from.size());
  if (to.size() < end) to.resize(end);
  std::copy(from.begin() + static_cast<std::ptrdiff_t>(begin), from.begin() + static_cast<std::ptrdiff_t>(end),
            to.begin() + static_cast<std::ptrdiff_t>(begin));
}

bool same_sector(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b, std::size_t sector) {
  std::vector<std::uint8_t> one, other;
  copy_sector(a, sector, one);
  copy_sector(b, sector, other);
  return one == other;
}

/// The reserve of the disk's room has no content.
bool is_modelled(const fs::directory_entry& entry) {
  const std::string name = entry.path().filename().string();
  return entry.is_regular_file() && name.rfind("flight.db", 0) == 0 && !name.ends_with("-reserve");
}

}  // namespace

CutDisk::CutDisk(const fs::path& folder) : folder_(folder) {
  Names names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!is_modelled(entry)) continue;
    names[name] = inode_of(entry.path());
    files_[names[name]].durable = read_whole(entry.path());
  }
  names_.push_back(names);
}

CutDisk::File& CutDisk::of(int file) {
  struct stat state {};
  fstat(file, &state);
  return files_[state.st_ino];
}

std::vector<std::uint8_t> CutDisk::present(std::uint64_t inode) const {
  const File& file = files_.at(inode);
  if (file.removed) return file.last;
  for (const auto& [name, number] : names_.back()) {
    if (number == inode) return read_whole(folder_ / name);
  }
  return file.durable;
}

void CutDisk::opened(const fs::path& path, int file) {
  Names names = names_.back();
  struct stat state {};
  if (fstat(file, &state) != 0 || names[path.filename().string()] == state.st_ino) return;
  // A number of a file that was removed may come again.
  files_[state.st_ino] = {};
  names[path.filename().string()] = state.st_ino;
  names_.push_back(names);
}

void CutDisk::wrote(int file, std::int64_t at, std::size_t bytes) {
  std::set<std::size_t>& dropped = of(file).dropped;
  const auto begin = static_cast<std::size_t>(at);
  dropped.erase(dropped.lower_bound(begin / sector_bytes), dropped.upper_bound((begin + bytes - 1) / sector_bytes));
}

void CutDisk::synchronised(int descriptor, bool done) {
  File& file = of(descriptor);
  const Octets now = read_whole("/proc/self/fd/" + std::to_string(descriptor));
  if (!done) {
    for (std::size_t s = 0; s < sectors_of(now.size()); ++s) {
      if (!same_sector(now, file.durable, s)) file.dropped.insert(s);
    }
    return;
  }
  Octets durable = now;
  for (const std::size_t s : file.dropped) {
    const std::size_t begin = s * sector_bytes;
    if (begin >= durable.size()) continue;
    std::fill(durable.begin() + static_cast<std::ptrdiff_t>(begin),
              durable.begin() + static_cast<std::ptrdiff_t>(std::min(begin + sector_bytes, durable.size())),
              std::uint8_t{0});
    Octets old = file.durable;
    if (old.size() > durable.size()) old.resize(durable.size());
    copy_sector(old, s, durable);
  }
  file.durable = std::move(durable);
}

void CutDisk::synchronised_folder() {
  names_ = {names_.back()};
}

void CutDisk::unlinks(const fs::path& path) {
  Names names = names_.back();
  const auto found = names.find(path.filename().string());
  if (found == names.end()) return;
  File& file = files_[found->second];
  file.last = read_whole(path);
  file.removed = true;
  names.erase(found);
  names_.push_back(names);
}

void CutDisk::renamed(const fs::path& from, const fs::path& to) {
  Names names = names_.back();
  const auto found = names.find(from.filename().string());
  if (found == names.end()) return;
  const std::uint64_t inode = found->second;
  names.erase(found);
  names[to.filename().string()] = inode;
  names_.push_back(names);
}

void CutDisk::cut(Loss loss, Rng& rng) {
  const auto versions = static_cast<std::uint32_t>(names_.size());
  const Names names = loss == Loss::all       ? names_.front()
                      : loss == Loss::nothing ? names_.back()
                                              : names_[rng.below(versions)];
  std::map<std::string, Octets> left;
  for (const auto& [name, inode] : names) {
    const File& file = files_.at(inode);
    const Octets now = present(inode);
    Octets result = loss == Loss::nothing ? now : file.durable;
    if (loss == Loss::parts) {
      for (std::size_t s = 0; s < sectors_of(now.size()); ++s) {
        if (file.dropped.count(s) == 0 && rng.below(2) == 1) copy_sector(now, s, result);
      }
      // It was cut, and the cut may be on the disk.
      if (now.size() < result.size() && rng.below(2) == 1) result.resize(now.size());
    }
    left[name] = std::move(result);
  }
  for (const auto& entry : fs::directory_iterator(folder_)) {
    if (entry.is_regular_file() && entry.path().filename().string().rfind("flight.db", 0) == 0)
      fs::remove(entry.path());
  }
  for (const auto& [name, octets] : left) {
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(octets.data()), static_cast<std::streamsize>(octets.size()));
  }
}

}  // namespace ilp::faults
