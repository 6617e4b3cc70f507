// Lists the processes of the board and their names.
#pragma once

#include <dirent.h>
#include <fcntl.h>
#include <unistd.h>

#include <charconv>
#include <cstdio>
#include <cstring>

namespace board {

/// Calls visit(number, name) for every running process.
template <typename Visit>
void for_each_process(Visit visit) {
  DIR* processes = opendir("/proc");
  if (processes == nullptr) return;
  while (const dirent* entry = readdir(processes)) {
    int process = 0;
    const char* const end = entry->d_name + std::strlen(entry->d_name);
    const auto [rest, error] = std::from_chars(entry->d_name, end, process);
    if (error != std::errc() || rest != end) continue;
    char path[64], name[32] = {};
    std::snprintf(path, sizeof(path), "/proc/%d/comm", process);
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) continue;
    const ssize_t length = read(file, name, sizeof(name) - 1);
    close(file);
    if (length <= 0) continue;
    name[std::strcspn(name, "\n")] = 0;
    visit(process, name);
  }
  closedir(processes);
}

}  // namespace board
