// A real disk of a few MiB, where the system lets us have one.
#pragma once

#include <sys/mount.h>

#include <filesystem>
#include <string>

namespace ilp::test {

/// A file system in memory, mounted at a folder that is made for it. Needs the right to mount.
class SmallDisk {
 public:
  SmallDisk(std::string folder, int mebibytes) : folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_);
    mounted_ = mount("tmpfs", folder_.c_str(), "tmpfs", 0, size(mebibytes).c_str()) == 0;
  }
  ~SmallDisk() {
    if (mounted_) umount2(folder_.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

  [[nodiscard]] bool mounted() const { return mounted_; }
  [[nodiscard]] const std::string& path() const { return folder_; }
  [[nodiscard]] bool resize(int mebibytes) const {
    return mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT, size(mebibytes).c_str()) == 0;
  }
  [[nodiscard]] bool set_read_only(bool read_only) const {
    return mount("tmpfs", folder_.c_str(), "tmpfs", MS_REMOUNT | (read_only ? MS_RDONLY : 0), nullptr) == 0;
  }

 private:
  static std::string size(int mebibytes) { return "size=" + std::to_string(mebibytes) + "m"; }

  std::string folder_;
  bool mounted_ = false;
};

}  // namespace ilp::test
