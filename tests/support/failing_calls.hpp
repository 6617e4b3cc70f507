// Calls of the system that fail on command: those of the whole program, whichever library makes them. A program that
// links failing_calls.cpp has them in place of the C library's.
#pragma once

#include <functional>
#include <string>

namespace ilp::test {

enum class Call : unsigned {
  read = 1,
  write = 2,
  synchronise = 4,
  truncate = 8,
  create = 16,
  remove = 32,
  rename = 64
};
constexpr unsigned operator|(Call a, Call b) {
  return static_cast<unsigned>(a) | static_cast<unsigned>(b);
}
constexpr unsigned operator|(unsigned a, Call b) {
  return a | static_cast<unsigned>(b);
}
/// Those that change a disk.
inline constexpr unsigned changes =
    Call::write | Call::synchronise | Call::truncate | Call::create | Call::remove | Call::rename;

struct CallFault {
  unsigned calls = 0;
  int first = 1;         ///< number of the first call that fails, from 1
  int count = 1 << 30;   ///< that fail in a row
  int reason = 5;        ///< errno; EIO. With ENOSPC writes fail only where a file grows
  bool ends = false;     ///< the process ends in the call instead, as if it were killed
  bool nothing = false;  ///< the call reads 0 octets instead
  bool in_part = false;  ///< the call before them reads or writes only a half
};

/// While one exists, calls on files whose path contains `part` are counted and fail. One at a time.
class FailingCalls {
 public:
  FailingCalls(const std::string& part, const CallFault& fault);
  ~FailingCalls();
  FailingCalls(const FailingCalls&) = delete;
  FailingCalls& operator=(const FailingCalls&) = delete;

  /// Calls so far, also those that have not failed.
  [[nodiscard]] int seen() const;
  [[nodiscard]] bool failed() const;
};

/// Runs `work` in a process of its own, which ends in its call number `call` that changes what has `part` in its path,
/// as in a power cut. False: `work` was done before. A child that crashes aborts the program.
[[nodiscard]] bool cut_in_call(const std::string& part, int call, const std::function<void()>& work);

}  // namespace ilp::test
