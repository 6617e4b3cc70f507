#include "sim/ground/serve/static_files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ilp::serve {

void StaticFiles::put(Pictures pictures, std::set<std::string> files) {
  const std::lock_guard lock(mutex_);
  earlier_ = std::move(pictures_);
  pictures_ = std::move(pictures);
  files_ = std::move(files);
}

std::shared_ptr<const std::vector<std::uint8_t>> StaticFiles::picture(const std::string& path) const {
  const std::lock_guard lock(mutex_);
  for (const Pictures* pictures : {&pictures_, &earlier_}) {
    const auto found = pictures->find(path);
    if (found != pictures->end()) return found->second;
  }
  return nullptr;
}

OpenFile StaticFiles::open(const std::string& name) const {
  OpenFile opened;
  {
    const std::lock_guard lock(mutex_);
    opened.known = files_.contains(name);
  }
  if (!opened.known) return opened;
  std::error_code error;
  const std::filesystem::path folder = std::filesystem::canonical(folder_, error);
  const std::filesystem::path path = folder / name;
  if (error || std::filesystem::canonical(path, error) != path || error) return opened;
  opened.file = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  struct stat facts {};
  if (opened.file >= 0 && (::fstat(opened.file, &facts) != 0 || !S_ISREG(facts.st_mode))) {
    ::close(opened.file);
    opened.file = -1;
  }
  opened.bytes = static_cast<std::uint64_t>(facts.st_size);
  return opened;
}

}  // namespace ilp::serve
