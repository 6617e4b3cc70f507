// Kills a process in the middle of its work. The time is determined by changes of its files, so that it does not depend
// on the speed of the machine.
#pragma once

#include <signal.h>
#include <sys/wait.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace ilp::test {

/// Returns the sizes of all files below a folder, by path.
[[nodiscard]] inline std::map<std::string, std::uintmax_t> sizes_below(const std::filesystem::path& folder) {
  std::map<std::string, std::uintmax_t> sizes;
  std::error_code error;
  for (std::filesystem::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code gone;
    sizes[entry->path().string()] = entry->file_size(gone);
  }
  return sizes;
}

/// Kills a child process when names or sizes of files below `folder` have changed `changes` times. Returns false if the
/// child has ended by itself before.
[[nodiscard]] inline bool kill_after_changes(pid_t child, const std::filesystem::path& folder, int changes) {
  std::map<std::string, std::uintmax_t> before = sizes_below(folder);
  int status = 0;
  while (changes > 0) {
    if (waitpid(child, &status, WNOHANG) == child) return false;
    std::map<std::string, std::uintmax_t> now = sizes_below(folder);
    if (now == before) continue;
    --changes;
    before.swap(now);
  }
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return WIFSIGNALED(status);
}

}  // namespace ilp::test
